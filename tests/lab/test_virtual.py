"""The virtual machine: the stated truth is in its records, and its files give them back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lab import bench as virtual
from layerjam.errors import FileError, QuantityError
from layerjam.measure.readers.read import read_trace
from layerjam.measure.sidecar import read_facts
from layerjam.mechanics.pull import peak
from strategies import KAPTON, PTFE

PERFECT = virtual.Machine(
    load_cell_noise=0.0, force_quantisation=0.0, elongation_quantisation=0.0, sampling_rate=20_000
)


def test_a_perfect_machine_shows_the_truth() -> None:
    trace = virtual.pull(KAPTON, 94.5e3, 0.01, 0.04, PERFECT)
    top = peak(94.5e3, 0.06, KAPTON)
    assert trace.force.max() == pytest.approx(175.925038, abs=1e-4)
    assert trace.elongation[trace.force.argmax()] == pytest.approx(float(top.elongation), abs=1e-5)
    assert trace.force[-1] == pytest.approx(88.1486228, abs=5e-7)
    assert trace.elongation[-1] == pytest.approx(0.04, abs=1e-12)
    stuck = trace.elongation < 1e-3
    np.testing.assert_allclose(trace.force[stuck], 131e3 * trace.elongation[stuck], rtol=1e-12)


def test_each_fault_shows() -> None:
    machine = virtual.Machine(
        load_cell_noise=0.2,
        drift=0.5,
        zero_offset=1.0,
        jitter=1e-4,
        force_quantisation=0.05,
        seed=3,
    )
    shown = virtual.pull(PTFE, 94.5e3, 1e-3, 0.04, machine)
    truth = virtual.pull(PTFE, 94.5e3, 1e-3, 0.04,
                         virtual.Machine(load_cell_noise=0.0, force_quantisation=0.0))  # fmt: skip
    error = shown.force - truth.force - 1.0 - 0.5 * shown.time
    assert abs(error.mean()) < 0.01 and error.std() == pytest.approx(0.2, rel=0.03)
    assert np.abs(shown.force / 0.05 - np.round(shown.force / 0.05)).max() < 1e-6
    step = np.diff(shown.time)
    assert (step > 0).all() and step.std() > 5e-5
    clipped = virtual.pull(KAPTON, 94.5e3, 1e-3, 0.04, virtual.Machine(load_cell_range=150.0))
    assert clipped.force.max() == 150.0


def test_same_seed_same_record_other_repeat_other_noise() -> None:
    first = virtual.pull(KAPTON, 50e3, 0.013, 0.04, repeat=1)
    again = virtual.pull(KAPTON, 50e3, 0.013, 0.04, repeat=1)
    other = virtual.pull(KAPTON, 50e3, 0.013, 0.04, repeat=2)
    np.testing.assert_array_equal(first.force, again.force)
    assert not np.array_equal(first.force, other.force)


def test_friction() -> None:
    trace = virtual.friction(0.32, 0.24, 2.45, texture=0.0)
    assert trace.force.max() / 2.45 == pytest.approx(0.32, abs=0.005)
    window = (trace.elongation > 0.04) & (trace.elongation < 0.1)
    assert trace.force[window].mean() / 2.45 == pytest.approx(0.24, abs=1e-4)
    rising = trace.elongation < 1e-4
    assert np.abs(trace.force - 5e3 * trace.elongation)[rising].max() < 0.01
    means = [
        virtual.friction(0.32, 0.24, 2.45, kinetic_sd=0.02, repeat=r).force[20_000:].mean() / 2.45
        for r in range(1, 41)
    ]
    assert np.std(means) == pytest.approx(0.02, rel=0.4)


def test_what_cannot_be_is_refused() -> None:
    for wrong in ({"speed": 0.0}, {"travel": -1.0}, {"vacuum": -1.0}):
        with pytest.raises(QuantityError):
            virtual.pull(KAPTON, **({"vacuum": 5e4, "speed": 0.01, "travel": 0.04} | wrong))
    with pytest.raises(QuantityError, match="jitter"):
        virtual.pull(KAPTON, 5e4, 0.01, 0.04, virtual.Machine(jitter=1e-3))
    with pytest.raises(QuantityError, match="kinetic"):
        virtual.friction(0.3, 0.0, 2.45)


@pytest.mark.parametrize("form", virtual.WRITERS)
@pytest.mark.parametrize("kind", ["pull", "friction"])
def test_files_give_the_record_back(form: str, kind: str, tmp_path: Path) -> None:
    machine = virtual.Machine(seed=11, jitter=2e-5)
    if kind == "pull":
        trace = virtual.pull(KAPTON, 94.5e3, 0.013, 0.04, machine, 2, "choi2018-kapton")
    else:
        trace = virtual.friction(0.32, 0.24, 2.45, repeat=2)
    path = virtual.WRITERS[form](trace, tmp_path / "x.dat")
    back = read_trace(path)
    digits = {"own": 0.0, "bluehill": 5.1e-7, "testxpert": 5.1e-5}[form]
    np.testing.assert_allclose(back.force, trace.force, rtol=0, atol=max(digits * 10, 1e-12))
    np.testing.assert_allclose(
        back.elongation, trace.elongation, rtol=0, atol=max(digits, 1e-15) / 100
    )
    np.testing.assert_allclose(back.time, trace.time, rtol=0, atol=digits)
    assert back.facts == trace.facts == read_facts(path) and back.facts.synthetic
    assert b"SYNTHETIC" in path.read_bytes()[:400]
    assert any("synthetic" in w for w in back.warnings)
    with pytest.raises(FileError, match="exists already"):
        virtual.WRITERS[form](trace, path)
    virtual.WRITERS[form](trace, path, force=True)
    (tmp_path / "x.dat.toml").unlink()
    assert any("synthetic" in w for w in read_trace(path).warnings)


def test_nothing_is_written_beside_a_sidecar_of_another(tmp_path: Path) -> None:
    (tmp_path / "x.csv.toml").write_text('note = "mine"')
    with pytest.raises(FileError, match="x.csv.toml: exists already"):
        virtual.write_own(virtual.pull(KAPTON, 5e4, 0.013, 0.04), tmp_path / "x.csv")
    assert not (tmp_path / "x.csv").exists()
