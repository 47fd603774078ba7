"""GCC makes vector code of each loop over many stops, which takes a third less time."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from layerjam.brake.kernel.compiler import FLAGS, SOURCES

STOPS = SOURCES / "stops.c"


def test_every_loop_over_stops_is_vectorised(tmp_path: Path) -> None:
    """A formula with one condition too many is not; its numbers stay the same."""
    words = ["gcc", *FLAGS, "-fPIC", "-c", str(STOPS), "-o", str(tmp_path / "stops.o")]
    try:
        run = subprocess.run(
            [*words, "-fopt-info-vec-optimized"], capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        pytest.skip("gcc is not installed")
    if run.returncode:
        pytest.skip("this gcc does not list the loops that it vectorises")
    lines = STOPS.read_text(encoding="utf-8").splitlines()
    loops = {n + 2 for n, line in enumerate(lines) if line.strip() == "LJ_LOOP"}
    found = {int(n) for n in re.findall(r"stops\.c:(\d+):\d+: optimized: loop vec", run.stderr)}
    assert len(loops) == 5
    assert {n for n in loops if found & {n, n - 1, n + 1}} == loops, run.stderr
