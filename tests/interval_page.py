"""First table of docs/coverage.md: how often intervals contain the true value."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from layerjam.laboratory.identify.calibration.intervals import Interval

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- intervals: begin -->", "<!-- intervals: end -->")
LEAST = 0.92
"""Least share of campaigns whose interval contains the true value."""


@dataclass
class Tally:
    """How often one interval held the truth, and how often the truth lay below or above it."""

    inside: int = 0
    below: int = 0
    above: int = 0
    missing: int = 0
    widths: list[float] = field(default_factory=list)

    @property
    def count(self) -> int:
        return self.inside + self.above + self.below

    @property
    def share(self) -> float:
        return self.inside / self.count if self.count else float("nan")

    def add(self, interval: Interval | None, truth: float) -> None:
        if interval is None:
            self.missing += 1
            return
        self.below += truth < interval.low
        self.above += truth > interval.high
        self.inside += interval.low <= truth <= interval.high
        scale = truth if truth > 0.3 else 1.0
        self.widths.append((interval.high - interval.low) / 2 / scale)


def table(found: dict[str, dict[str, Tally]]) -> str:
    """The coverage table in Markdown."""
    lines = [
        "| fit | parameter | *t* | bootstrap | truth below, above | half width |",
        "|---|---|---|---|---|---|",
    ]
    for fit, tallies in found.items():
        case = fit
        for name, tally in tallies.items():
            if name.endswith("*"):
                continue
            again = tallies.get(f"{name}*")
            other = f"{again.share:.1%}" if again is not None and again.count else "–"
            lines.append(
                f"| {case} | `{name}` | {tally.share:.1%} | {other} | {tally.below}, {tally.above} "
                f"| {np.median(tally.widths):.2g} |"
            )
            case = ""  # stated in the first row of its parameters
    return "\n".join(lines)


def write(found: dict[str, dict[str, Tally]], campaigns: int, seed: int) -> None:
    """Write the table into docs/coverage.md."""
    before, rest = PAGE.read_text(encoding="utf-8").split(MARKS[0])
    missing = sum(tally.missing for tallies in found.values() for tally in tallies.values())
    made = f"""{MARKS[0]}

`python tests/interval_coverage.py --campaigns {campaigns} --seed {seed} --write` writes this
table:

{table(found)}

Intervals that could not be computed: {missing}.

{MARKS[1]}"""
    PAGE.write_text(before + made + rest.split(MARKS[1])[1], encoding="utf-8")
