"""A pull in the simulated test machine: stepped by the C kernel, and by the law as JAX compiles it.

.venv/bin/python -m benchmarks.pulls
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator

from benchmarks.timing import Row, median, table
from layerjam.brake.device.load import load
from layerjam.brake.kernel.engine import SWITCH
from layerjam.brake.simulate.procedure import Procedure, parse_procedure, simple_pull
from layerjam.brake.simulate.tensile import tensile

FILE = load("choi2018-kapton")
LOOP = "; pull at 13 mm/s until 40 mm; return at 13 mm/s to 20 mm"
LOOPS = parse_procedure("evacuate to 94.5 kPa" + 50 * LOOP)
PULL = simple_pull(94.5e3, 13e-3, 40e-3)
FIRST = """
import time
from benchmarks.pulls import FILE, PULL, tensile
start = time.perf_counter()
tensile(FILE, PULL)
print(time.perf_counter() - start)
"""


def rows() -> list[Row]:
    """The first pull of a process, one more, and fifty loops; beside each the law alone."""
    made = []
    for name, measure in (
        ("tensile, first of a process", first),
        (f"tensile, {count(PULL)} samples", lambda: warm(PULL)),
        (f"tensile, {count(LOOPS):,} samples", lambda: warm(LOOPS)),
    ):
        quick = measure()
        with switched_off():
            made.append(Row(name, quick, other=measure(), other_name="by brake_cycle"))
    return made


@contextlib.contextmanager
def switched_off() -> Iterator[None]:
    """Without the kernel."""
    os.environ[SWITCH] = "off"
    try:
        yield
    finally:
        del os.environ[SWITCH]


def first(runs: int = 3) -> float:
    """Median seconds of the first pull in a fresh process, what it imports not counted."""
    times = []
    for _ in range(runs):
        done = subprocess.run(
            [sys.executable, "-c", FIRST], check=True, capture_output=True, text=True
        )
        times.append(float(done.stdout))
    return sorted(times)[runs // 2]


def warm(procedure: Procedure) -> float:
    """Seconds of a procedure in a process that has run it before: the least of 30 runs.

    What else runs on the machine disturbs most runs of some milliseconds, not all.
    """
    return min(median(lambda: tensile(FILE, procedure), 1) for _ in range(30))


def count(procedure: Procedure) -> int:
    """Samples of its record."""
    return len(tensile(FILE, procedure).time)


if __name__ == "__main__":
    print(table(rows()))
