"""What we promise on speed, measured beside what a user would pick instead, in one run.

Prints medians and ratios; nothing here fails a test. `make bench`.
"""

from __future__ import annotations

import contextlib
import io
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import jax
import numpy as np

from benchmarks import (
    calibration,
    control,
    design,
    first_answers,
    force_law,
    impact,
    intervals,
    pulls,
    readers,
    stack,
    workbench,
)
from benchmarks.timing import Row, median, table

jax.config.update("jax_enable_x64", True)
OUT = Path("out/bench")


def process(*words: str, runs: int = 5) -> float:
    """Median seconds of a whole process, after one that warms the caches."""

    def once() -> None:
        subprocess.run(words, check=True, capture_output=True)

    return median(once, runs)


def command_line() -> list[Row]:
    """Whole processes, against a Python that does nothing."""
    python = sys.executable
    bare = process(python, "-c", "pass")
    command = (python, "-m", "layerjam.cli.main")
    inner = "import time; t = time.perf_counter(); import layerjam; print(time.perf_counter() - t)"
    times = []
    for _ in range(7):
        shown = subprocess.run([python, "-c", inner], check=True, capture_output=True, text=True)
        times.append(float(shown.stdout))
    return [
        Row("import layerjam", sorted(times)[3], 0.1),
        Row("layerjam --help", process(*command, "--help"), 0.3, bare, "python -c pass"),
    ]


def main() -> None:
    """Everything, as a table."""
    machine = f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores"
    versions = f"Python {platform.python_version()}, JAX {jax.__version__}, NumPy {np.__version__}"
    print(f"{machine}, {versions}")
    parts: list[tuple[str, Callable[[], list[Row]]]] = [
        ("first answers, processor time of whole processes", first_answers.rows),
        ("command line, whole processes", command_line),
        ("predictions with their intervals", intervals.rows),
        ("force law, 10 million points", force_law.rows),
        ("reading a 40,000-row export, and one calibration", readers.rows),
        ("calibrating on whole curves", calibration.rows),
        ("pulls in the test machine", pulls.rows),
        ("the regulator", control.rows),
        ("the stack, sheet by sheet", stack.rows),
        ("ten million designs", design.rows),
        ("the workbench in a browser", workbench.rows),
    ]
    for title, measure in parts:
        print(f"\n{title} ...", flush=True)
        with contextlib.redirect_stdout(io.StringIO()):
            rows = measure()
        print(table(rows))
    print("\ndrop tests ...\n", flush=True)
    print(impact.report(OUT))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent.parent))
    main()
