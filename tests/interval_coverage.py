"""How often the 95 % intervals of a calibration contain the true value; `make coverage`.

Campaigns are drawn at random: brake, scale factor, stiffness, enclosure, one to three vacuums,
three to five repeats of each. Every repeat has its own friction, stiffness, enclosure, slack and
zero of the force, and noise. The table goes to docs/coverage.md.

    python tests/interval_coverage.py [--campaigns N] [--seed S] [--write]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import jax
import numpy as np
from scipy import stats

import interval_values

jax.config.update("jax_enable_x64", True)

from campaigns import bench as virtual  # noqa: E402
from layerjam.device.brake import Brake  # noqa: E402
from layerjam.device.load import load  # noqa: E402
from layerjam.identify.calibration.intervals import Interval  # noqa: E402
from layerjam.identify.calibration.peaks import calibrate_peaks  # noqa: E402
from layerjam.identify.calibration.whole_curves import calibrate_curves  # noqa: E402
from layerjam.identify.curves import Curve, make_curves  # noqa: E402
from layerjam.identify.pull.features import PullFeatures, pull_features  # noqa: E402
from layerjam.identify.shape import change_shape  # noqa: E402
from layerjam.measure.trace import Trace  # noqa: E402

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
OTHERS = "## How many more pulls?"
CAMPAIGNS, SEED = 1000, 2018
LEAST = 0.92
CHANCE = 0.01
"""Probability with which a row at its bound is called outside."""
SAMPLES = 3000
TRAVEL = 0.04
BRAKES = ("choi2018-kapton", "choi2018-ptfe")


@dataclass(frozen=True, kw_only=True)
class Case:
    """One row of the table: how campaigns are fitted, and what their truth may contain."""

    name: str
    depth: str
    free: tuple[str, ...] = ()
    repeats: tuple[int, ...] = (3, 4, 5)
    vacuums: tuple[int, ...] = (1, 2, 3)
    offset: float = 2e-3
    """Standard deviation of the force's zero between repeats, of the peak."""
    speeds: tuple[float, ...] = (0.013,)
    brakes: tuple[str, ...] = BRAKES
    enclosure_off: float = 0.0
    """By which part the true enclosure differs from the file's, in either direction."""
    between: float | None = None
    """Share of the variance that the pulls of one mounting have in common; pull n of a condition
    belongs to mounting n. None if every pull is mounted by itself and no mounting is stated."""
    stated: bool = True
    """Whether the sidecars state the mounting."""
    records: bool = False
    """Whether whole records are drawn and read, else the values of their pulls (much faster)."""
    most: float = 0.98
    """Greatest share that contains the true value."""


MOUNTED = (("pull", 0.0), ("mixed", 0.5), ("repeat", 1.0))
"""What shares one draw, and the share of the variance that mountings explain."""
CASES = (
    Case(name="exact", depth="exact", records=True),
    Case(
        name="exact, three repeats in all", depth="exact", records=True, repeats=(3,), vacuums=(1,)
    ),
    Case(name="curves", depth="curves", records=True),
    Case(
        name="curves, three repeats in all", depth="curves", records=True, repeats=(3,),
        vacuums=(1,),
    ),
    Case(
        name="curves, force offset free", depth="curves", records=True, free=("force_offset",),
        offset=0.02,
    ),
    Case(
        name="curves, pressure exponent free", depth="curves", records=True,
        free=("pressure_exponent",), vacuums=(2, 3),
    ),
    Case(
        name="curves, speed law free", depth="curves", records=True, free=("speed",),
        speeds=(0.005, 0.013),
    ),
    *(
        Case(name=f"exact, {words} in all", depth="exact", repeats=(count,), vacuums=(1,))
        for count, words in ((2, "2 pulls"), (6, "6 pulls"), (12, "12 pulls"))
    ),
    *(
        Case(name=f"exact, {words}, 3 repeats", depth="exact", repeats=(3,), vacuums=(count,))
        for count, words in ((2, "two vacuums"), (3, "three vacuums"))
    ),
    *(
        Case(
            name=f"exact, enclosure 25 % off, {brake.partition('-')[2]}", depth="exact",
            enclosure_off=0.25, brakes=(brake,), most=1.0,
        )
        for brake in BRAKES
    ),
    *(
        Case(
            name=f"{depth}, 3 mountings of {vacuums * speeds} pulls, per {word}", depth=depth,
            repeats=(3,), vacuums=(vacuums,), speeds=(0.005, 0.013)[-speeds:], between=between,
            most=1.0 if depth == "bayesian" else 0.98,
        )
        for depth, vacuums, speeds in (
            ("exact", 3, 2), ("curves", 3, 2), ("bayesian", 3, 2),
        )
        for word, between in MOUNTED
    ),
    *(
        Case(
            name=f"exact, mountings not stated, per {word}", depth="exact", repeats=(3,),
            vacuums=(3,), speeds=(0.005, 0.013), between=between, stated=False, most=1.0,
        )
        for word, between in MOUNTED
    ),
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """Measured pulls and the truth behind them."""

    brake: Brake
    pulls: tuple[tuple[Trace, PullFeatures, float], ...]
    truth: dict[str, float]

    @property
    def curves(self) -> tuple[Curve, ...]:
        return make_curves(self.pulls)


def campaign(case: Case, random: np.random.Generator) -> Campaign:
    """A random truth and the pulls that a machine records of it."""
    stated = load(case.brakes[random.integers(len(case.brakes))]).brake
    kapton = stated.film.kinetic > 0.1
    truth = {
        "scale_factor": float(stated.scale_factor * random.uniform(0.75, 1.3)),
        "stiffness": float((stated.stiffness_measured or 1e5) * random.uniform(0.7, 1.4)),
        "enclosure_factor": 1.0 + case.enclosure_off * random.choice((-1, 1))
        if case.depth == "exact"
        else float(random.uniform(0.7, 1.4)),
        "pressure_exponent": float(random.uniform(-0.15, 0.15))
        if "pressure_exponent" in case.free
        else 0.0,
        "speed_slope": float(random.uniform(-0.1, 0.1)) if "speed" in case.free else 0.0,
    }
    spread = {
        "scale_factor": random.uniform(0.01, 0.05),
        "stiffness": random.uniform(0.01, 0.05),
        "enclosure_factor": random.uniform(0.01, 0.1),
    }
    noise = random.uniform(2e-4, 3e-3)
    levels = random.choice(np.array([0.25, 0.4, 0.6, 0.8, 1.0]), random.choice(case.vacuums), False)
    vacuums = levels * 94.5e3 * random.uniform(0.95, 1.0)
    repeats = random.choice(case.repeats, len(vacuums))
    reference = np.exp(np.average(np.log(vacuums), weights=repeats))
    middle = np.exp(np.log(case.speeds).mean())
    pulls = []
    common = case.between or 0.0
    mounted = random.standard_normal((max(repeats), len(spread))) if common else np.zeros((99, 3))
    for vacuum, count in zip(vacuums, repeats, strict=True):
        for speed in case.speeds:
            for repeat in range(count):
                drawn = np.sqrt(1 - common) * np.array([random.standard_normal() for _ in spread])
                drawn += np.sqrt(common) * mounted[repeat]
                own = {
                    n: truth[n] * (1 + spread[n] * z) for n, z in zip(spread, drawn, strict=True)
                }
                law = (vacuum / reference) ** truth["pressure_exponent"]
                law *= np.exp(truth["speed_slope"] * np.log10(speed / middle))
                real = change_shape(
                    stated, own["scale_factor"] * law, own["stiffness"], own["enclosure_factor"]
                )
                height = (58.0 if kapton else 12.0) * vacuum / 30e3
                machine = virtual.Machine(
                    sampling_rate=SAMPLES * speed / TRAVEL,
                    load_cell_noise=noise * height,
                    zero_offset=case.offset * height * random.standard_normal(),
                    seed=int(random.integers(1 << 31)),
                )
                number = repeat + 1 if case.between is not None and case.stated else 1
                trace = with_slack(
                    virtual.pull(real, vacuum, speed, TRAVEL, machine, number),
                    random.uniform(0, 3e-3), machine, random,
                )  # fmt: skip
                pulls.append((trace, pull_features(trace), float(vacuum)))
    return Campaign(brake=stated, pulls=tuple(pulls), truth=truth)


def with_slack(
    trace: Trace, slack: float, machine: virtual.Machine, random: np.random.Generator
) -> Trace:
    """The pull after the crosshead has taken up `slack` [m] without any force."""
    count = int(slack / TRAVEL * SAMPLES)
    idle = np.linspace(0, slack, count, endpoint=False)
    still = machine.zero_offset + machine.load_cell_noise * random.standard_normal(count)
    return replace(
        trace,
        force=np.concatenate([still, trace.force]),
        elongation=np.concatenate([idle, slack + trace.elongation]) + 0.1,
        time=None,
    )


def intervals(case: Case, found: Campaign) -> dict[str, Interval | None]:
    """What the calibration states, by parameter; the bootstrap's marked by a star."""
    if case.depth == "exact":
        fit = calibrate_peaks(found.curves, found.brake)
        return {**fit.intervals, **{f"{n}*": i for n, i in fit.bootstrap.items()}}
    deep = calibrate_curves(found.curves, found.brake, case.free)
    return {**deep.intervals, **{f"{n}*": i for n, i in deep.bootstrap.items()}}


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


def measure(
    case: Case, campaigns: int, seed: int, tell: Callable[[str], None] = lambda _: None
) -> dict[str, Tally]:
    """Coverage of every parameter of one case over random campaigns."""
    tallies: dict[str, Tally] = defaultdict(Tally)
    if not case.records:
        for pulls in interval_values.draw(case, campaigns, [seed, CASES.index(case)]):
            for name, interval in interval_values.intervals(case, pulls).items():
                tallies[name].add(interval, pulls.truth[name])
        return dict(tallies)
    said = time.monotonic()
    for number in range(campaigns):
        random = np.random.Generator(np.random.PCG64([seed, CASES.index(case), number]))
        found = campaign(case, random)
        for name, interval in intervals(case, found).items():
            tallies[name].add(interval, found.truth[name.rstrip("*")])
        if time.monotonic() - said > 5:
            said = time.monotonic()
            tell(f"{case.name}: {number + 1} of {campaigns}")
    return dict(tallies)


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


def is_outside(case: Case, inside: int, count: int) -> bool:
    """Whether a row is beyond its bounds by more than chance."""
    below = stats.binom.cdf(inside, count, LEAST) < CHANCE
    return bool(below or stats.binom.sf(inside - 1, count, case.most) < CHANCE)


def page(found: dict[str, dict[str, Tally]], campaigns: int, seed: int) -> str:
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
free). There is up to 3 mm of slack and a noise of 0.02 to 0.3 % of the peak, in {SAMPLES:,}
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
This leaves few degrees of freedom: Student's *t* is 4.3 for three mountings and 12.7 for two.

If no mounting is stated, the groups of first, second, ... pulls at each vacuum and speed are
candidates. An F test compares the scatter between groups with that within groups. They count as
mountings if the probability of so much scatter between three or more groups by chance is below 25 %
(below 5 % for two groups). The `mountings` check states which assumption was made. It is a warning
if the probability is below 0.5 %. Pulls at a single vacuum cannot reveal mountings.

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


def write(found: dict[str, dict[str, Tally]], campaigns: int, seed: int) -> None:
    """Write the first part of docs/coverage.md; other scripts write the rest."""
    text = PAGE.read_text(encoding="utf-8")
    rest = text[text.index(OTHERS) :]
    PAGE.write_text(page(found, campaigns, seed) + "\n" + rest, encoding="utf-8")


def main() -> int:
    """Measure, print, write; 1 where an interval does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--write", action="store_true", help="write docs/coverage.md")
    given = parser.parse_args()
    found = {
        case.name: measure(
            case,
            given.campaigns,
            given.seed,
            lambda s: print(s, file=sys.stderr, flush=True),
        )
        for case in CASES
    }
    print(table(found))
    if given.write:
        write(found, given.campaigns, given.seed)
    wrong = [
        f"{case.name}: {name} {tally.share:.1%}"
        for case in CASES
        for name, tally in found[case.name].items()
        if not name.endswith("*") and is_outside(case, tally.inside, tally.count)
    ]
    for line in wrong:
        print(f"outside its bounds: {line}")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
