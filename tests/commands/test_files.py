"""What every command on measured files does with many of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from campaigns import bench as virtual
from layerjam.commands.calibration import calibrate
from layerjam.commands.files import CURVE, PICTURE, read_each, read_pulls
from layerjam.commands.friction import friction
from layerjam.commands.reading import FileOptions
from layerjam.device.load import load
from layerjam.measure.trace import Trace
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


def test_ctrl_c_keeps_what_was_read_and_names_the_rest(files: list[Path]) -> None:
    def told(what: str, share: float) -> None:
        shares.append(share)
        if share >= 0.5:
            raise KeyboardInterrupt

    shares: list[float] = []
    used, refused = read_each(files, lambda trace: trace.path, FileOptions(), told)
    assert shares == [0.25, 0.5]
    assert used == [str(f) for f in files[:2]]
    assert refused == {str(f): "not read completely: interrupted" for f in files[2:]}


def test_ctrl_c_within_a_file_refuses_that_one_too(files: list[Path]) -> None:
    def use(trace: Trace) -> str:
        if trace.path == str(files[1]):
            raise KeyboardInterrupt
        return trace.path

    used, refused = read_each(files, use, FileOptions())
    assert used == [str(files[0])]
    assert list(refused) == [str(f) for f in files[1:]]


def test_ctrl_c_before_anything_was_read_ends_it(files: list[Path]) -> None:
    def use(_: Trace) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        read_each(files, use, FileOptions())


def test_an_interrupted_calibration_writes_no_brake_unless_told(
    files: list[Path], tmp_path: Path
) -> None:
    def stop(what: str, share: float) -> None:
        if share > 0.6:
            raise KeyboardInterrupt

    out = tmp_path / "brake.toml"
    answer = calibrate("choi2018-kapton", files, vacuum="94.5 kPa", out=out, progress=stop)
    assert answer.file is None
    assert not out.exists()
    assert list(answer.refused) == [str(files[3])]
    partly = calibrate(
        "choi2018-kapton", files, vacuum="94.5 kPa", out=out, partial=True, progress=stop
    )
    assert partly.file == str(out)


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
