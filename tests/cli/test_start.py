"""How the console script ends: at once, with its code, and with nothing lost."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.timing

SCRIPT = """
import atexit, sys, threading, time
import layerjam.cli.start as start
def main():
    {main}
sys.modules["layerjam.cli.main"] = sys
sys.main = main
start.run()
"""


def _ended(main: str, folder: Path) -> subprocess.CompletedProcess[str]:
    code = SCRIPT.format(main=main.replace("\n", "\n    "))
    return subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("code", [0, 1, 2, 3])
def test_the_code_is_the_command_s(code: int, tmp_path: Path) -> None:
    assert _ended(f"return {code}", tmp_path).returncode == code


def test_what_was_printed_and_what_others_do_last_is_not_lost(tmp_path: Path) -> None:
    main = """
print("a" * 100_000)
atexit.register(lambda: open("late.txt", "w").write("done") and print("last"))
return 0
"""
    ended = _ended(main, tmp_path)
    assert ended.stdout == "a" * 100_000 + "\nlast\n"
    assert (tmp_path / "late.txt").read_text() == "done"


def test_a_thread_that_still_writes_is_waited_for(tmp_path: Path) -> None:
    main = """
def later():
    time.sleep(0.3)
    print("written")
threading.Thread(target=later).start()
return 0
"""
    assert _ended(main, tmp_path).stdout == "written\n"


def test_an_interrupt_while_loading_is_one_line(tmp_path: Path) -> None:
    ended = _ended("raise KeyboardInterrupt", tmp_path)
    assert (ended.returncode, ended.stderr) == (130, "layerjam: stopped\n")


def test_a_fault_of_ours_is_a_traceback(tmp_path: Path) -> None:
    ended = _ended("raise RuntimeError('ours')", tmp_path)
    assert ended.returncode == 1
    assert "RuntimeError: ours" in ended.stderr


def test_nothing_is_taken_apart(tmp_path: Path) -> None:
    main = """
class Loaded:
    def __del__(self):
        print("taken apart")
sys.loaded = Loaded()
return 0
"""
    assert _ended(main, tmp_path).stdout == ""
