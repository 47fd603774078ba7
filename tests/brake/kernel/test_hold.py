"""A held load in C, as firmware calls it: ten million times, and no bit of the memory changes."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from layerjam.brake.kernel.compiler import FLAGS, SOURCES, find_compiler

CC = pytest.mark.skipif(
    shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler here"
)
HERE = Path(__file__).parent


@CC
@pytest.mark.parametrize(
    ("define", "calls"),
    [
        ("-ULJ_SINGLE", 10_000_000),
        pytest.param("-DLJ_SINGLE", 10_000_000, marks=pytest.mark.slow),
    ],
)
def test_ten_million_calls_change_no_bit(tmp_path, define, calls):
    """At 0.999 of c L2, and after a slide; at 1.001 it slides."""
    program = tmp_path / "hold"
    sources = [str(HERE / "hold.c"), str(SOURCES / "layerjam.c")]
    command = [
        *find_compiler(),
        *FLAGS,
        define,
        f"-I{SOURCES}",
        *sources,
        "-lm",
        "-o",
        str(program),
    ]
    subprocess.run(command, check=True)
    done = subprocess.run([program, str(calls)], capture_output=True, text=True, check=True)
    said = dict(line.rsplit(" ", 1) for line in done.stdout.splitlines())
    for name in ("rest held", "rest swung", "slid held", "slid swung"):
        assert said[name] == "same", done.stdout
    assert float(said["rest slip"]) == 0 < float(said["above slip"])
