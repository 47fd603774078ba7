"""Medians, and rows of the table that `make bench` prints."""

from __future__ import annotations

import os
import resource
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path


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
            met = "within" if row.value <= row.target else "missed"
            goal = f"{met} {number_text(row.target, row.unit)}"
        ratio = ""
        if row.other is not None:
            other = number_text(row.other, row.unit)
            ratio = f"{row.value / row.other:.2f}x {row.other_name} ({other})"
            if row.target_ratio is not None:
                met = "within" if row.value / row.other <= row.target_ratio else "missed"
                goal = f"{met} {row.target_ratio:.1f}x"
        lines.append(f"  {row.name:<38} {number_text(row.value, row.unit):>9}  {goal:<15} {ratio}")
    return "\n".join(lines)


README = """
import layerjam as lj

stop = lj.drop(
    "choi2018-kapton",
    mass="1 kg",
    speed=2.5,
    vacuum="tuned",
    travel=0.04,
    rope_stiffness="16.8 kN/m",
).require()
print(f"{stop.vacuum / 1e3:.2f} kPa, {stop.peak_force:.1f} N")
"""
"""The README's lines of Python; a test compares."""


def fresh(folder: Path) -> dict[str, str]:
    """This process's environment, with every cache that layerjam and JAX use in a folder.

    Python keeps the modules' byte code, as it does unless PYTHONDONTWRITEBYTECODE is set.
    """
    apart = ("JAX_", "XLA_", "NUMBA_", "LAYERJAM_", "MPL", "PYTHONDONTWRITE", "XDG_")
    own = {"HOME": folder, "XDG_CACHE_HOME": folder / "cache", "NUMBA_CACHE_DIR": folder / "loops"}
    kept = {name: text for name, text in os.environ.items() if not name.startswith(apart)}
    return kept | {name: str(path) for name, path in own.items()}


def cpu(words: Sequence[str], folder: Path) -> float:
    """Seconds of processor time of a process and its own, with its caches in a folder."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, check=True, capture_output=True, cwd=folder, env=fresh(folder))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
