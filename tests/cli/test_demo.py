"""`make demo`: the main job, twice in a row into the same folder."""

from __future__ import annotations

import contextlib
import io
import json
import re
from pathlib import Path

import pytest

from docs.test_pages import compare_keys
from layerjam.bench.rig.stop import Stop
from layerjam.brake.device.load import load
from layerjam.cli.demo import _Steps, demo
from layerjam.core.errors import FileError, LayerjamError
from links import link

STEPS = (
    "friction", "calibrate", "validate", "vacuum", "show", "build", "bench run", "publish",
    "recompute", "reproduce",
)  # fmt: skip
STEP = re.compile(r"  ([a-z]+(?: run)?): .* +\d+\.\d s")
"""Line of a step: its command, its content and its time."""


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(FileError, match="was not created by the demo"):
        demo(out=tmp_path)
    with pytest.raises(FileError, match="is not a folder"):
        demo(out=tmp_path / "thesis.txt")
    if link(tmp_path / "link", tmp_path):
        with pytest.raises(FileError, match="is not a folder"):
            demo(out=tmp_path / "link")
    assert (tmp_path / "thesis.txt").read_text() == "mine"


def test_a_step_prints_one_line_and_logs_the_rest(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Stop, "signalled", True)  # an earlier run of this process was stopped
    steps = _Steps(tmp_path / "demo.log")
    steps.run_step("show: the brake", "show", "choi2018-kapton")
    shown, err = capfd.readouterr()
    assert STEP.fullmatch(shown.rstrip("\n")) and err == ""
    log = steps.path.read_text(encoding="utf-8")
    assert log.startswith("\n$ layerjam show choi2018-kapton\n") and "\nmass " in log
    with pytest.raises(LayerjamError, match=r"'layerjam show none' .* exit code 2; .*demo\.log"):
        steps.run_step("show: no brake", "show", "none")
    shown, err = capfd.readouterr()
    assert shown.startswith("  show: no brake ") and shown.endswith("stopped\n") and err == ""
    log = steps.path.read_text(encoding="utf-8")
    assert "\nmass " in log and "'none'" in log.split("$ layerjam show none\n")[1]


def test_a_terminal_sees_the_share_of_a_long_step(tmp_path: Path) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    steps, terminal = _Steps(tmp_path / "demo.log"), Terminal()
    with contextlib.redirect_stdout(terminal), steps.log_step("reproduce: a page") as tell:
        tell("Fig. 9", 0.4)
    first, share, end = terminal.getvalue().rstrip("\n").split("\r")
    assert first.strip() == "reproduce: a page" and share.split()[-1] == "40%"
    assert STEP.fullmatch(end)
    assert steps.path.read_text(encoding="utf-8") == "  Fig. 9\n"


@pytest.mark.slow
def test_twice_in_a_row(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out" / "demo"
    kept = []
    for _ in range(2):
        done = demo(out=out)
        assert Path(done.report).is_file() and Path(done.dataset).is_dir()
        assert Path(done.pictures).is_dir()
        shown, err = capfd.readouterr()
        # the command line adds the result's table
        assert len(shown.splitlines()) + len(str(done).splitlines()) <= 40 and err == ""
        steps = [step[1] for line in shown.splitlines() if (step := STEP.fullmatch(line))]
        assert steps == ["measure", *STEPS]
        log = Path(done.log).read_text(encoding="utf-8")
        assert log.count("layerjam: lease 600 s: ") == 1 and "Traceback" not in log
        for command in STEPS:
            assert f"\n$ layerjam {command} " in log
        kept.append({p: p.read_bytes() for p in out.rglob("*.*") if p.is_file()})
        # every run of the bench has a number and a time of its own, the log states both
        run = kept[-1].pop(out / "bench.ljrun")
        assert run.startswith(b"SQLite format 3") and kept[-1].pop(out / "demo.log")
        assert f"Open {out / 'report.html'}" in shown and "The five key numbers" in shown
        numbers = shown.split("The five key numbers")[1].splitlines()[1:6]
        assert all(line.startswith("  ") for line in numbers)
    compare_keys("demo", json.loads(done.json()))
    assert kept[0].keys() == kept[1].keys()
    # everything comes from stated truths and seeds
    assert [n for n in kept[0] if kept[0][n] != kept[1][n]] == []
    assert isinstance(json.loads((out / "results.json").read_text(encoding="utf-8")), list)
    assert "This run: from files to a vacuum" in (out / "report.html").read_text(encoding="utf-8")
    fitted = load(out / "my-brake-calibrated.toml")
    assert fitted.brake.scale_factor * fitted.brake.film.kinetic == pytest.approx(0.21, rel=0.005)
    assert fitted.brake.stiffness_measured == pytest.approx(131e3, rel=0.01)
    assert {p.suffix for p in (out / "measurements").iterdir()} == {".csv", ".TRA", ".toml"}
