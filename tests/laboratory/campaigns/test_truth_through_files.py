"""The stated truth comes back through every machine's file format, within the stated error."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from laboratory.campaigns import bench as virtual
from layerjam.brake.mechanics.pull import peak
from layerjam.laboratory.identify.calibration.peaks import calibrate
from layerjam.laboratory.identify.friction.reduction import reduce_friction
from layerjam.laboratory.identify.provenance import find_calibration_files, sha256
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.measure.readers.read import read_trace
from strategies import KAPTON, PTFE, change

ENDING = {"own": "csv", "bluehill": "csv", "testxpert": "TRA"}
FORMATS = pytest.mark.parametrize("kind", list(virtual.WRITERS))
BRAKES = {"kapton": KAPTON, "ptfe": PTFE}


@FORMATS
@pytest.mark.parametrize("name", list(BRAKES))
@pytest.mark.parametrize("vacuum", [94.5e3, 30e3])
def test_scale_factor_and_stiffness(kind: str, name: str, vacuum: float, tmp_path: Path) -> None:
    brake = BRAKES[name]
    noise = 1e-3 * float(peak(vacuum, 0.06, brake).force)
    pulls = []
    for repeat in (1, 2, 3):
        machine = virtual.Machine(load_cell_noise=noise, jitter=5e-5, seed=5)
        trace = virtual.pull(brake, vacuum, 13e-3, 40e-3, machine, repeat=repeat, name="it")
        path = virtual.WRITERS[kind](trace, tmp_path / f"{repeat}.{ENDING[kind]}")
        read = read_trace(path)
        assert read.facts.synthetic and read.facts.vacuum == vacuum
        assert any("synthetic" in w for w in read.warnings)
        pulls.append((pull_features(read), vacuum))
    blank = change(brake, scale_factor=1.0, stiffness_measured=None)
    for chosen in (pulls[:1], pulls):
        found = calibrate(chosen, blank)
        assert found.scale_factor == pytest.approx(brake.scale_factor, rel=0.02)
        assert found.stiffness == pytest.approx(brake.stiffness_measured, rel=0.05)
    one = calibrate(pulls[:1], blank)
    factor_se, stiffness_se = one.standard_errors.values()
    assert 0 < factor_se < 0.01 * brake.scale_factor
    assert abs(one.scale_factor - brake.scale_factor) < 4 * factor_se
    assert abs(one.stiffness - brake.stiffness_measured) < 4 * stiffness_se
    # the three share their truth, so they scatter by what each says of itself
    spread = np.std([f.scale_factor for f in calibrate(pulls, blank).fits], ddof=1)
    assert spread < 4 * factor_se


@FORMATS
def test_friction(kind: str, tmp_path: Path) -> None:
    normal, machine = 2.45, virtual.Machine(sampling_rate=100.0, load_cell_noise=0.00245, seed=3)
    traces = []
    for repeat in (1, 2, 3):
        trace = virtual.friction(
            0.32, 0.24, normal, machine=machine, repeat=repeat,
            static_sd=0.01, kinetic_sd=0.004, string_stiffness=100.0,
        )  # fmt: skip
        path = virtual.WRITERS[kind](trace, tmp_path / f"{repeat}.{ENDING[kind]}")
        traces.append(read_trace(path))
    found = reduce_friction(traces, normal)
    assert abs(found.static - 0.32) < 3 * 0.01 / 3**0.5
    assert abs(found.kinetic - 0.24) < 3 * 0.004 / 3**0.5
    assert traces[0].facts.normal_force == normal


@FORMATS
def test_a_zero_offset_is_not_taken_for_stiffness(kind: str, tmp_path: Path) -> None:
    """An offset of 1 N lifts the peak by 1 N and leaves the slope: both are what was measured."""
    machine = virtual.Machine(load_cell_noise=0.05, zero_offset=1.0, seed=2)
    trace = virtual.pull(KAPTON, 94.5e3, 13e-3, 40e-3, machine)
    read = read_trace(virtual.WRITERS[kind](trace, tmp_path / f"x.{ENDING[kind]}"))
    found = pull_features(read)
    assert found.stiffness == pytest.approx(131e3, rel=0.01)
    assert found.peak_force == pytest.approx(176.925, abs=0.1)


def test_provenance_knows_a_file_by_its_content(tmp_path: Path) -> None:
    from layerjam.brake.device.load import load

    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    one.write_bytes(b"abc")
    other.write_bytes(b"abd")
    assert sha256(str(one)) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    (tmp_path / "big").write_bytes(bytes(3 << 20))
    assert len(sha256(str(tmp_path / "big"))) == 64
    import dataclasses

    file = load("choi2018-kapton")
    assert find_calibration_files(file, [str(one)]) == []
    noted = dataclasses.replace(
        file, notes={"files": [{"name": "x", "sha256": sha256(str(one))}, "odd", {"sha256": 3}]}
    )
    copy = tmp_path / "renamed.csv"
    copy.write_bytes(b"abc")
    found = find_calibration_files(noted, [str(one), str(other), str(copy)])
    assert found == [str(one), str(copy)]
