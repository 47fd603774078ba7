"""Medians, and rows of the table that `make bench` prints."""

from __future__ import annotations

import os
import resource
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One measurement: seconds (or GB), its target, and what it is compared with."""

    name: str
    value: float
    target: float | None = None
    other: float | None = None
    other_name: str = ""
    unit: str = "s"
    target_ratio: float | None = None


def median(run: Callable[[], object], runs: int = 9) -> float:
    """Median seconds of `run`, after one uncounted."""
    run()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return sorted(times)[runs // 2]


def number_text(value: float, unit: str) -> str:
    """Return a number with its unit, in three digits."""
    if unit == "s" and value < 1:
        return f"{value * 1e3:.3g} ms"
    return f"{value:.3g} {unit}"


def table(rows: Sequence[Row]) -> str:
    """Name, median, target with whether it is met, and the ratio to the alternative."""
    lines = []
    for row in rows:
        goal = ""
        if row.target is not None:
            met = "within" if row.value <= row.target else "OVER"
            goal = f"{met} {number_text(row.target, row.unit)}"
        ratio = ""
        if row.other is not None:
            other = number_text(row.other, row.unit)
            ratio = f"{row.value / row.other:.2f}x {row.other_name} ({other})"
            if row.target_ratio is not None:
                met = "within" if row.value / row.other <= row.target_ratio else "OVER"
                goal = f"{met} {row.target_ratio:g}x"
        lines.append(f"  {row.name:<38} {number_text(row.value, row.unit):>9}  {goal:<15} {ratio}")
    return "\n".join(lines)


README = """
import layerjam as lj

stop = lj.drop("choi2018-kapton", mass="1 kg", speed=2.5, vacuum="tuned", travel=0.04)
print(f"{stop.vacuum / 1e3:.2f} kPa, {stop.peak_force:.1f} N")
"""
"""The README's lines of Python; a test compares."""


def cpu(*words: str, runs: int = 5) -> float:
    """Median seconds of processor time of a whole process, after one that warms the caches.

    Python keeps the modules' byte code, as it does unless PYTHONDONTWRITEBYTECODE is set.
    """
    times = []
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    for _ in range(runs + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(words, check=True, capture_output=True, env=environment)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return sorted(times[1:])[runs // 2]
