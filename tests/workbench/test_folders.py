"""Folders of dropped files: gone with their tab, and with the next start after a kill."""

from __future__ import annotations

import subprocess
import sys

import pytest

from layerjam.workbench import folders
from layerjam.workbench.folders import Folder, remove_stale_folders

KILLED = """
import os, signal
from layerjam.workbench.folders import Folder
folder = Folder()
(folder.path / "data.csv").write_text("1")
print(folder.path, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setattr(folders.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr(folders.tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


@pytest.mark.skipif(sys.platform == "win32", reason="nothing is swept on Windows")
def test_what_a_killed_program_left_goes_and_what_is_used_stays(place):
    used = Folder()
    words = [sys.executable, "-c", KILLED]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    left = place / done.stdout.strip()
    assert (left / "data.csv").exists(), done.stderr
    other = place / "layerjam-workbench-of-somebody"
    other.mkdir()
    assert remove_stale_folders() == [left.parent]
    assert not left.parent.exists()
    assert used.path.is_dir() and other.is_dir(), "no lock: it may be in use"
    used.remove()
    assert [p.name for p in place.iterdir()] == [other.name]


@pytest.mark.skipif(sys.platform == "win32", reason="nothing is swept on Windows")
def test_a_link_is_not_followed(place):
    held = Folder()
    outside = place / "outside"
    outside.mkdir()
    (outside / folders.LOCK).touch()
    (place / "layerjam-workbench-link").symlink_to(outside)
    assert remove_stale_folders() == []
    assert outside.is_dir()
    held.remove()
