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
from dataclasses import dataclass, replace

import jax
import numpy as np
from scipy import stats

import interval_values
from interval_page import LEAST, Tally, table, write

jax.config.update("jax_enable_x64", True)

from laboratory.campaigns import bench as virtual  # noqa: E402
from layerjam.brake.device.brake import Brake  # noqa: E402
from layerjam.brake.device.load import load  # noqa: E402
from layerjam.laboratory.identify.calibration.intervals import Interval  # noqa: E402
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks  # noqa: E402
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves  # noqa: E402
from layerjam.laboratory.identify.curves import Curve, make_curves  # noqa: E402
from layerjam.laboratory.identify.pull.features import PullFeatures, pull_features  # noqa: E402
from layerjam.laboratory.identify.shape import change_shape  # noqa: E402
from layerjam.laboratory.measure.trace import Trace  # noqa: E402

CAMPAIGNS, SEED = 1000, 2018
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
    belongs to mounting n. None if every pull has its own mounting."""
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
        Case(
            name=f"exact, {words} in all", depth="exact", repeats=(count,), vacuums=(1,),
            most=1.0 if count == 2 else 0.98,
        )
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
                mounting = number if case.between is not None else len(pulls) + 1
                trace = with_slack(
                    virtual.pull(real, vacuum, speed, TRAVEL, machine, number),
                    random.uniform(0, 3e-3), machine, random,
                )  # fmt: skip
                stated_number = mounting if case.stated else None
                facts = replace(trace.facts, repeat=None, mounting=stated_number)
                trace = replace(trace, facts=facts)
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


def is_outside(case: Case, inside: int, count: int) -> bool:
    """Whether a row is beyond its bounds by more than chance."""
    below = stats.binom.cdf(inside, count, LEAST) < CHANCE
    return bool(below or stats.binom.sf(inside - 1, count, case.most) < CHANCE)


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
