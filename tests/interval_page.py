"""First part of docs/coverage.md: how often intervals contain the true value, as a table."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from layerjam.laboratory.identify.calibration.intervals import Interval

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
OTHERS = "## How many more pulls?"
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
        "| fit | parameter | *t* | bootstrap | truth below, above | half width | campaigns |",
        "|---|---|---|---|---|---|---|",
    ]
    for case, tallies in found.items():
        for name, tally in tallies.items():
            if name.endswith("*"):
                continue
            again = tallies.get(f"{name}*")
            other = f"{again.share:.1%}" if again is not None and again.count else "–"
            lines.append(
                f"| {case} | `{name}` | {tally.share:.1%} | {other} | {tally.below}, {tally.above} "
                f"| {np.median(tally.widths):.2g} | {tally.count} |"
            )
    return "\n".join(lines)


def page(found: dict[str, dict[str, Tally]], campaigns: int, seed: int, samples: int) -> str:
    """docs/coverage.md."""
    return f"""# Do the intervals hold?

Check how far you can trust the intervals and checks of a calibration. A 95 % interval must contain
the true value 95 times in 100. Here the true values are known, because the campaigns are generated
at random in a virtual laboratory. The table is produced by `--campaigns {campaigns} --seed {seed}`
of `tests/interval_coverage.py`:

```sh
make coverage
```

**All data are synthetic** and follow this program's own law of the brake. The table shows that the
statistics are right, not that a real brake follows the law. To test that, use the checks of a
calibration and `layerjam validate`.

{table(found)}

The *t* and bootstrap columns show the percentage of campaigns whose 95 % interval contains the true
value. A percentage measured on {campaigns:,} campaigns itself has an uncertainty of
{uncertainty(campaigns):.1%} (95 %). In rows with a bootstrap value, whole records are generated and
read. In the other rows, the results of a pull (its peak, its slope, its own parameters) are
generated with reading errors. Their intervals are those of `calibrate`, and the posterior is
integrated on a grid. Tests compare both with whole records.

Every row must reach {LEAST:.0%}. With the exact method, percentages for the scale factor exceed 95
% if the true enclosure is that of the file, because the interval allows for a different one. Half
widths (of *t*) are medians, relative to the true value for the scale factor, the stiffness and the
enclosure factor. Student's *t* is 4.3 for three repeats in all, and 12.7 for two. The intervals are
accordingly wide: more repeats help more than more samples.

## Random campaigns

A campaign has Kapton or PTFE sheets. The scale factor is 0.75 to 1.3 times that of the catalogue,
and the stiffness 0.7 to 1.4 times. For whole curves and the Bayesian fit the enclosure also varies,
by 0.7 to 1.4 times. There are one to three vacuums between 22 and 94.5 kPa, with three to five
repeats of each, generated separately.

Every repeat has its own friction (SD of 1 to 5 %, depending on the campaign), stiffness (1 to 5 %)
and enclosure (1 to 10 %). The force has a zero error (SD 0.2 % of the peak; 2 % if the offset is
free). There is up to 3 mm of slack and a noise of 0.02 to 0.3 % of the peak, in {samples:,}
samples.

True pressure exponents are within ±0.15, and true speed slopes (of the logarithm of friction)
within ±0.1 per decade. With the exact method, the mean enclosure equals that of the file, except in
the rows marked "25 % off".

In the rows with mountings, pull *n* of each vacuum and speed belongs to mounting *n*. In rows
marked "per pull", every pull has its own friction, stiffness and enclosure. In rows marked "per
repeat", all pulls of a mounting have the same values. In "mixed" rows, half of the variance is
shared.

## Pulls that share a mounting

Pulls of one mounting share the same friction and grips. If 18 pulls in three mountings are treated
as independent, the intervals contain the true value in only 45 % of campaigns. Intervals therefore
use the scatter between mountings. `mounting` in a pull's sidecar numbers them; if it is omitted,
`repeat` is used. If you repeat pulls without removing the brake, give them the same `mounting`.
This leaves few degrees of freedom: Student's *t* is 4.3 for three mountings.

Fewer than three mountings do not show their scatter, and pulls whose mounting is not stated may all
share one. Intervals then include a scatter of 5 % (SD) between mountings, or the scatter of the
pulls or of two mountings if that is larger. For the enclosure factor the default is 10 %. The
`mountings` check states which assumption was made. To get narrow intervals, mount the brake at
least three times and state `mounting`.

If each pull resembles the one before, even stated mountings are not independent. For each value,
`calibrate` correlates successive mountings if there are at least six. If they correlate more than
independent ones do in 65 % of campaigns, the interval includes their scatter in full, not divided
by the root of their number. Healthy campaigns of twelve pulls therefore have about three times the
width in a third of cases.

## The order of pulls

The checks `wear` and `neighbours` need the order of the pulls. It is that of the start times in the
files' headers, in time columns with dates, or in `date` of the sidecars (with a time of day, such
as `"2026-11-28 10:31"`). Without them it is that of the stated `repeat`, or of the numbers at the
end of the file names, or of the mountings. `repeat` may start again at each vacuum; the vacuums
then follow each other in the order in which the scale factor changes. The check states its source.

## Errors that all pulls share

The pulls do not show errors that they share. If the sidecars of all pulls state `load_cell_limit`
and `gauge_limit`, the intervals of `calibrate` include them. Otherwise the result lists them after
"not included". A force before the rise may be a preload or a zero error. The interval includes both
readings; `--tare` subtracts this force.

## The enclosure

A peak includes the enclosure's force, which the default method takes from the brake file. Its
uncertainty (`force_uncertainty` in `[enclosure]`, 30 % if not stated) contributes to the interval
with the sensitivity of the scale factor. The standard uncertainties are combined in quadrature, and
Student's *t* has the effective degrees of freedom of Welch and Satterthwaite (GUM, annex G.4). With
one or two degrees of freedom, this formula would give a narrower interval for an additional
uncertainty. The interval is therefore never narrower than that of the scatter alone. For whole
curves and in the Bayesian fit, the enclosure is fitted.

## Why *t* over curves

The samples of a curve share one mounting, so they do not show the repeatability. Intervals use only
the scatter between curves, or between mountings. With the exact method this is Student's *t* of the
pulls' values. For whole curves it is the sandwich estimator over curves with residuals scaled for
their leverage (CR2) and Satterthwaite's degrees of freedom (Bell and McCaffrey 2002; Pustejovsky
and Tipton 2018). If all curves have the same weight, the result is the same *t*.

The bootstrap resamples, within each condition, one curve fewer than the condition has, and combines
the standard deviation of the results with *t*. The percentiles of three resampled repeats would
have a coverage of 74 %. Intervals of positive values are symmetric on a logarithmic scale, so they
never include zero.
"""


def uncertainty(campaigns: int) -> float:
    """Half of the 95 % interval of a share of 95 %."""
    return 1.96 * float(np.sqrt(0.95 * 0.05 / campaigns))


def write(found: dict[str, dict[str, Tally]], campaigns: int, seed: int, samples: int) -> None:
    """Write the first part of docs/coverage.md; other scripts write the rest."""
    text = PAGE.read_text(encoding="utf-8")
    rest = text[text.index(OTHERS) :]
    PAGE.write_text(page(found, campaigns, seed, samples) + "\n" + rest, encoding="utf-8")
