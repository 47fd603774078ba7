"""What `make dist` accepts, and the source archive that hatchling builds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from install.dist import REQUIRED, ROOT, build, contents, faults


def test_a_missing_licence_and_a_test_are_faults() -> None:
    whole = [f"layerjam-1/{name}" for name in REQUIRED]
    assert faults(whole) == []
    assert faults(whole[1:]) == ["LICENSE is missing"]
    for name in ("layerjam-1/tests/x.py", "layerjam/test_x.py", "layerjam/__pycache__/x.pyc"):
        assert faults([*whole, name]) == [f"{name} does not belong there"]


@pytest.mark.slow
def test_both_files_are_whole_and_built_the_same_twice(tmp_path: Path) -> None:
    first, second = (build(tmp_path / name, "1700000000") for name in ("first", "second"))
    assert first == second and len(first) == 2
    for name in first:
        names = contents(tmp_path / "first" / name)
        assert faults(names) == []
        held = {n.split("layerjam/", 1)[1] for n in names if "layerjam/" in n}
        command = ("git", "ls-files", "src/layerjam")
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        kept = {line.removeprefix("src/layerjam/") for line in listed.stdout.splitlines()}
        assert kept <= held
    later = build(tmp_path / "later", "1700000002")
    assert later.keys() == first.keys() and later != first


def test_the_tool_is_the_one_that_pip_builds_with() -> None:
    done = subprocess.run([sys.executable, "-m", "hatchling", "version"], cwd=ROOT, check=True,
                          capture_output=True, text=True)  # fmt: skip
    from layerjam import __version__

    assert done.stdout.strip() == __version__
