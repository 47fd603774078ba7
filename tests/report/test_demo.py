"""`make demo`: the main job, twice in a row into the same folder."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from layerjam.cli.demo import demo
from layerjam.device.load import load
from layerjam.errors import FileError

STEPS = (
    "friction", "calibrate", "validate", "vacuum", "show", "build", "bench run", "publish",
    "recompute", "reproduce",
)  # fmt: skip
PROGRESS = re.compile(r"layerjam: [\w. -]+ \d+%")


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(FileError, match="was not made by the demo"):
        demo(out=tmp_path)
    with pytest.raises(FileError, match="is not a folder"):
        demo(out=tmp_path / "thesis.txt")
    link = tmp_path / "link"
    link.symlink_to(tmp_path, target_is_directory=True)
    with pytest.raises(FileError, match="is not a folder"):
        demo(out=link)
    assert (tmp_path / "thesis.txt").read_text() == "mine"


@pytest.mark.slow
def test_twice_in_a_row(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out" / "demo"
    kept = []
    for _ in range(2):
        done = demo(out=out)
        assert Path(done.report).is_file() and Path(done.dataset).is_dir()
        shown, err = capfd.readouterr()
        # a slow machine sees how far it is; the bench states its lease, and nothing else is there
        lines = err.splitlines()
        assert [line for line in lines if line.startswith("layerjam: lease 600 s: ")] != []
        assert all(PROGRESS.fullmatch(line) for line in lines if ": lease " not in line), err
        assert "Traceback" not in shown
        kept.append({p: p.read_bytes() for p in out.rglob("*.*") if p.is_file()})
        run = kept[-1].pop(out / "bench.ljrun")  # every run has a number and a time of its own
        assert run.startswith(b"SQLite format 3")
        for command in STEPS:
            assert f"\n$ layerjam {command} " in shown
        assert f"Open {out / 'report.html'}" in shown and "The five numbers that matter" in shown
        numbers = shown.split("The five numbers that matter")[1].splitlines()[1:6]
        assert all(line.startswith("  ") for line in numbers)
    assert kept[0].keys() == kept[1].keys()
    # everything comes from stated truths and seeds
    assert [n for n in kept[0] if kept[0][n] != kept[1][n]] == []
    assert isinstance(json.loads((out / "results.json").read_text(encoding="utf-8")), list)
    assert "This run: from files to a vacuum" in (out / "report.html").read_text(encoding="utf-8")
    fitted = load(out / "my-brake-calibrated.toml")
    assert fitted.brake.scale_factor * fitted.brake.film.kinetic == pytest.approx(0.21, rel=0.005)
    assert fitted.brake.stiffness_measured == pytest.approx(131e3, rel=0.01)
    assert {p.suffix for p in (out / "measurements").iterdir()} == {".csv", ".TRA", ".toml"}
