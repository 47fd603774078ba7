"""Folders appear whole, and a killed run's hidden folder is removed by the next run alone."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from layerjam.core.drawing.folder import write_folder as write_report
from layerjam.core.toml_files import folders
from layerjam.core.toml_files.folders import make_hidden_folder, replace_folder, write_files
from layerjam.workshop.fabricate.folder import write_folder as write_build
from links import link

pytestmark = pytest.mark.timing

RUN = """
import sys, time
from pathlib import Path
from layerjam.core.toml_files.folders import make_hidden_folder
with make_hidden_folder(Path(sys.argv[1])) as made:
    (made / "half").write_text("written")
    print(made.name, flush=True)
    time.sleep(60)
"""


def running(folder: Path) -> tuple[subprocess.Popen[str], str]:
    """A run that has a hidden folder in `folder`, and the folder's name."""
    run = [sys.executable, "-c", RUN, str(folder)]
    process = subprocess.Popen(run, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    return process, process.stdout.readline().strip()


def kill(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait()
    assert process.stdout is not None
    process.stdout.close()


def test_only_the_folder_of_a_killed_run_is_removed(tmp_path: Path) -> None:
    dead, left = running(tmp_path)
    alive, kept = running(tmp_path)
    kill(dead)
    (tmp_path / ".layerjam-notes").mkdir()
    older = f".layerjam-dataset-{'a' * 32}"  # of an earlier version
    (tmp_path / older).mkdir()
    mine = {".layerjam-notes", "report"}
    if link(tmp_path / ".layerjam-0123456789abcdef", tmp_path / ".layerjam-notes"):
        mine.add(".layerjam-0123456789abcdef")
    leave_for_a_day(tmp_path / left, tmp_path / older)
    assert {left, kept} <= {*os.listdir(tmp_path)}
    write_report(tmp_path / "report", {"report.html": "page"})
    assert {*os.listdir(tmp_path)} == {kept, *mine}
    assert (tmp_path / kept / "half").read_text() == "written"
    kill(alive)
    leave_for_a_day(tmp_path / kept)
    write_build(tmp_path / "build", {"build.json": '{"files": ["build.json"]}'})
    assert {*os.listdir(tmp_path)} == {"build", *mine}


def leave_for_a_day(*left: Path) -> None:
    """Windows cannot lock folders: what is unchanged for a day belongs to nobody."""
    yesterday = time.time() - folders.DAY - 60
    for folder in left if os.name == "nt" else ():
        os.utime(folder, (yesterday, yesterday))


def test_a_folder_that_a_killed_run_moved_away_comes_back(tmp_path: Path) -> None:
    left = tmp_path / ".layerjam-0123456789abcdef"
    write_files(left, {"old/data.csv": "1", folders.TARGET: str(tmp_path / "mine")})
    leave_for_a_day(left)
    with make_hidden_folder(tmp_path):
        assert (tmp_path / "mine" / "data.csv").read_text() == "1"
    assert os.listdir(tmp_path) == ["mine"]


@pytest.mark.parametrize("in_one_step", [True, False])
def test_a_folder_changes_places(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, in_one_step: bool
) -> None:
    if not in_one_step:
        monkeypatch.setattr(folders, "_exchange_folders", lambda *_: False)
    out = tmp_path / "out"
    for text in ("first", "second"):
        with make_hidden_folder(tmp_path) as hidden:
            write_files(hidden / "made", {"deep/a.txt": text, "b.bin": b"\0"})
            replace_folder(hidden / "made", out)
        assert (out / "deep" / "a.txt").read_text() == text
        assert os.listdir(tmp_path) == ["out"]


def test_a_second_run_waits_for_nobody(tmp_path: Path) -> None:
    with make_hidden_folder(tmp_path) as one, make_hidden_folder(tmp_path) as other:
        assert one != other and one.is_dir() and other.is_dir()
    assert os.listdir(tmp_path) == []
