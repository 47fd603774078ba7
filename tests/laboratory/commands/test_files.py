"""What every command on measured files does with many of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from laboratory.campaigns import bench as virtual
from layerjam.brake.device.load import load
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.commands.files import CURVE, PICTURE, read_each, read_pulls
from layerjam.laboratory.commands.friction import friction
from layerjam.laboratory.commands.reading import FileOptions
from layerjam.laboratory.measure.trace import Trace
from strategies import KAPTON

MACHINE = virtual.Machine(sampling_rate=13e-3 / 0.04 * 12_000)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("pulls")
    made = [virtual.pull(KAPTON, 94.5e3, 0.013, 0.04, MACHINE, repeat) for repeat in (1, 2, 3, 4)]
    return [virtual.write_own(t, folder / f"pull-{i}.csv") for i, t in enumerate(made)]


def test_long_records_are_not_kept_whole(files: list[Path]) -> None:
    used, refused, _ = read_pulls(
        files, load("choi2018-kapton"), None, FileOptions(), lambda *_: None
    )
    assert not refused
    for trace, pull, _ in used:
        assert PICTURE / 2 < len(trace) <= PICTURE
        assert CURVE / 2 < len(pull.force) <= CURVE


@pytest.mark.parametrize("partial", [False, True])
@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_ctrl_c_stops_and_writes_nothing(
    files: list[Path], tmp_path: Path, share: float, partial: bool
) -> None:
    def stop(what: str, done: float) -> None:
        if what == "reading files" and done >= share:
            raise KeyboardInterrupt

    how = {"vacuum": "94.5 kPa", "out": tmp_path / "brake.toml", "partial": partial}
    with pytest.raises(KeyboardInterrupt):
        calibrate("choi2018-kapton", files, **how, progress=stop)
    assert not list(tmp_path.iterdir())


def test_ctrl_c_within_a_file_is_not_its_fault(files: list[Path]) -> None:
    def use(trace: Trace) -> str:
        if trace.path == str(files[1]):
            raise KeyboardInterrupt
        return trace.path

    with pytest.raises(KeyboardInterrupt):
        read_each(files, use, FileOptions())


def test_a_zero_that_is_off_and_stick_slip_are_said(tmp_path: Path) -> None:
    clean = virtual.pull(KAPTON, 94.5e3, 0.013, 0.04, MACHINE, 1)
    u = clean.elongation
    slack = np.arange(-300, 0) * (u[1] - u[0])
    off = Trace(
        np.concatenate([np.zeros(300), clean.force]) + 4.0, np.concatenate([slack, u]),
        np.arange(len(u) + 300) * 1e-3, "off.csv", "made",
    )  # fmt: skip
    path = virtual.write_own(off, tmp_path / "off.csv")
    answer = calibrate("choi2018-kapton", [path], vacuum="94.5 kPa")
    assert any("the force is 4" in w and "before the load rises" in w for w in answer.warnings)


def test_friction_of_thinned_records_is_that_of_all_samples(tmp_path: Path) -> None:
    rate = virtual.Machine(sampling_rate=400.0)
    trace = virtual.friction(0.3, 0.24, 2.45, travel=0.11, machine=rate)
    path = virtual.write_own(trace, tmp_path / "f.csv")
    answer = friction([path], normal_force="2.45 N")
    moving = trace.travel
    inside = (moving >= 0.04) & (moving <= 0.1)
    assert answer.kinetic == pytest.approx(trace.force[inside].mean() / 2.45, rel=1e-4)
    assert len(answer.record[0][0]) < len(trace)
