"""How often faulty pulls are found, and faultless campaigns called faulty; into docs/coverage.md.

Campaigns of the virtual laboratory: twelve pulls each, with scatter, noise and slack; into each one
fault is put. Beside what the checks find stands the best test there can be: Neyman and Pearson's,
which knows the scatter, the noise and the size of the fault and needs only say whether some pull,
or whether all, have it.

    python tests/pull_faults.py [--campaigns N] [--seed S] [--write]
"""

from __future__ import annotations

import argparse
import functools
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import jax
import numpy as np

jax.config.update("jax_enable_x64", True)

from layerjam.brake.device.load import load  # noqa: E402
from layerjam.brake.mechanics.pull import peak  # noqa: E402
from layerjam.laboratory.campaigns.campaign import Campaign, campaign  # noqa: E402
from layerjam.laboratory.campaigns.faults import Faults  # noqa: E402
from layerjam.laboratory.campaigns.spec import Odd, Pulls, Scatter, Spec, Truth  # noqa: E402
from layerjam.laboratory.identify.calibration.forward import pull_force  # noqa: E402
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks, fit_curves  # noqa: E402
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves  # noqa: E402
from layerjam.laboratory.identify.curves import Curve, make_curves  # noqa: E402
from layerjam.laboratory.identify.fit_checks import Check  # noqa: E402
from layerjam.laboratory.identify.pull.features import pull_features  # noqa: E402
from layerjam.laboratory.identify.pull_checks import check_single_pulls  # noqa: E402
from layerjam.laboratory.identify.validation.metrics import validate_curves  # noqa: E402
from layerjam.laboratory.identify.validation.several import add_pull_table, check_validation  # noqa: E402

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- faulty pulls: begin -->", "<!-- faulty pulls: end -->")
CAMPAIGNS, SEED = 200, 2018
FAULTLESS = 10
"""Times as many faultless campaigns."""
MUST = 0.8
NONE = "nothing"
VACUUMS, SPEEDS, REPEATS = (30e3, 55e3, 80e3), (7e-3, 13e-3), 2
PULLS = len(VACUUMS) * len(SPEEDS) * REPEATS
BRAKES = ("choi2018-kapton", "choi2018-ptfe")
SEAT = 0.5
"""Load at which a seat has given way to 1 - 1/e, part of the middle vacuum's peak."""
FORMS = ("overshoot", "seating")
ALARMS = 0.05
NULL = 20_000


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One row: what is wrong, in words and as the laboratory takes it.

    `softer` is by which part a seat lowers the slope, `of_all` whether in all pulls.
    """

    name: str
    odd: Odd = Odd()
    overshoot: float = 0.0
    softer: float = 0.0
    of_all: bool = False
    strong: bool = False
    """Must be found in 80 % of campaigns."""


def one(name: str, strong: bool = False, **odd: float) -> Fault:
    return Fault(name=name, odd=Odd(how_many=1, **odd), strong=strong)


def level(name: str, strong: bool = False, **odd: float) -> Fault:
    return Fault(name=name, odd=Odd(how_many=1, per="vacuum", **odd), strong=strong)


FAULTS = (
    Fault(name=NONE),
    *(one(f"friction of one pull {100 * d:+g} %", abs(d) >= 0.15, friction_change=d)
      for d in (0.05, 0.075, 0.1, 0.15, 0.2, -0.15)),
    *(one(f"vacuum of one pull {100 * d:+g} %", abs(d) >= 0.15, vacuum_change=d)
      for d in (0.1, 0.15, -0.15)),
    *(level(f"one vacuum of three {100 * d:+g} %", abs(d) >= 0.15, vacuum_change=d)
      for d in (0.05, 0.1, 0.15, -0.15)),
    *(one(f"stiffness of one pull {100 * d:+g} %", abs(d) >= 0.15, stiffness_change=d)
      for d in (-0.05, -0.1, -0.15, -0.3)),
    one("static overshoot of one pull 5 %", overshoot=0.05),
    one("static overshoot of one pull 15 %", True, overshoot=0.15),
    *(Fault(name=f"static overshoot of all {100 * d:g} %", overshoot=d, of_all=True)
      for d in (0.01, 0.02, 0.05)),
    Fault(name="static overshoot of all 15 %", overshoot=0.15, of_all=True, strong=True),
    Fault(name="seating of one pull, stiffness −10 %", softer=0.1),
    Fault(name="seating of one pull, stiffness −30 %", softer=0.3, strong=True),
    Fault(name="seating of all, stiffness −10 %", softer=0.1, of_all=True),
    Fault(name="seating of all, stiffness −30 %", softer=0.3, of_all=True, strong=True),
    one("speed of one pull +15 %", True, speed_change=0.15),
)  # fmt: skip


def seat(softer: float, height: float, stiffness: float) -> float:
    """Depth of a seat [m] that lowers the slope over 20 to 80 % of `height` [N] by that part."""
    force = np.linspace(0.2, 0.8, 400) * height
    low, high = 0.0, 100 * height / stiffness
    for _ in range(60):
        depth = (low + high) / 2
        u = force / stiffness - depth * np.expm1(-force / (SEAT * height))
        even = np.linspace(u[0], u[-1], 400)  # a crosshead passes elongations, not forces, evenly
        slope = np.polyfit(even, np.interp(even, u, force), 1)[0]
        low, high = (depth, high) if slope > (1 - softer) * stiffness else (low, depth)
    return low


def drawn(fault: Fault, seed: Sequence[int]) -> Campaign:
    """A campaign with that fault; its truth, scatter and noise are drawn."""
    random = np.random.Generator(np.random.PCG64(list(seed)))
    name = BRAKES[random.integers(2)]
    known = load(name).brake
    factor = float(known.scale_factor * random.uniform(0.75, 1.3))
    stiffness = float((known.stiffness_measured or 1e5) * random.uniform(0.7, 1.4))
    truth = replace(known, scale_factor=factor, stiffness_measured=stiffness)
    height = float(peak(VACUUMS[1], 0.06, truth).force)
    depth = seat(fault.softer, height, stiffness) if fault.softer else 0.0
    odd = fault.odd
    if depth and not fault.of_all:
        odd = Odd(how_many=1, seating=depth)
    machine = Faults(
        sampling_rate=1000.0,
        force_noise=float(random.uniform(2e-4, 3e-3)) * height,
        slack=5e-4,
        overshoot=fault.overshoot,
        seating=depth if fault.of_all else 0.0,
        seating_force=SEAT * height,
    )
    spread = random.uniform(0.01, 0.04, 2)
    spec = Spec(
        brakes=(Truth(brake=name, scale_factor=factor, stiffness=stiffness),),
        seed=int(random.integers(1 << 31)),
        pulls=Pulls(vacuums=VACUUMS, speeds=SPEEDS, repeats=REPEATS, travel=0.04),
        scatter=Scatter(
            friction=float(spread[0]),
            stiffness=float(spread[1]),
            enclosure=float(random.uniform(0.01, 0.1)),
        ),
        machine=machine,
        odd=odd,
    )
    return campaign(spec)


def curves(made: Campaign) -> tuple[Curve, ...]:
    """Its pulls as a calibration takes them."""
    return make_curves([(t, pull_features(t), float(t.facts.vacuum or 0)) for t in made.traces()])


@dataclass
class Tally:
    """Campaigns, and in how many of them something was found, by which means."""

    campaigns: int = 0
    found: int = 0
    named: int = 0
    """The faulty pulls, and no others."""
    curves: int = 0
    table: int = 0
    """By the table pull by pull and the mean shape alone: the least that every method finds."""
    validated: int = 0
    best: int | None = None


def measure(
    fault: Fault, campaigns: int, seed: int, tell: Callable[[str], None] = lambda _: None
) -> Tally:
    """Counts over random campaigns."""
    tally, said = Tally(campaigns=campaigns), time.monotonic()
    for number in range(campaigns):
        made = drawn(fault, (seed, FAULTS.index(fault), number))
        pulls, brake = curves(made), made.subjects[0].known
        kept = [p for p, f in zip(pulls, fit_curves(pulls, brake), strict=True) if f is not None]
        found = calibrate_peaks(kept, brake)
        # a pull that is refused is found too: the command says why
        tally.found += len(kept) < len(pulls) or failed(found.checks)
        true = {t.name for t in made.tests if t.odd or fault.of_all}
        tally.named += {row.file for row in found.pulls if row.is_outlier} == true
        tally.table += failed(check_single_pulls(found.pulls, np.inf))
        tally.curves += failed(calibrate_curves(pulls, brake).checks)
        true_brake = made.subjects[0].true
        compared = add_pull_table(validate_curves(pulls, true_brake), pulls, true_brake)
        tally.validated += failed(check_validation(compared, 0))
        best = best_test(fault, made)
        if best is not None:
            tally.best = (tally.best or 0) + best
        if time.monotonic() - said > 10:
            said = time.monotonic()
            tell(f"{fault.name}: {number + 1} of {campaigns}")
    return tally


def failed(checks: Sequence[Check]) -> bool:
    """Whether any check says look."""
    return any(not c.passed for c in checks)


def best_test(fault: Fault, made: Campaign) -> bool | None:
    """Whether Neyman and Pearson's test sees the fault; None where it has no single size.

    It is told every pull's true friction (or stiffness), their scatter and the fault's size, not
    the mean nor which pull, or vacuum, it is: the likelihood ratio is the mean over all of them.
    """
    odd, spread = fault.odd, made.spec.scatter
    shift = np.log1p(odd.friction_change) + np.log1p(odd.vacuum_change)
    values = [t.friction * (t.true_vacuum or 0) / (t.vacuum or 1) for t in made.tests]
    width = spread.friction
    if odd.stiffness_change:
        shift, width = np.log1p(odd.stiffness_change), spread.stiffness
        values = [t.stiffness for t in made.tests]
    if any(getattr(part, name) for part in (made.spec.machine, made.spec.odd) for name in FORMS):
        return best_of_shapes(made)
    if not (odd.how_many and shift):
        return None
    size = PULLS // len(VACUUMS) if odd.per == "vacuum" else 1
    sets = np.kron(np.eye(PULLS // size), np.ones(size))  # pulls come vacuum by vacuum
    away = (sets - sets.mean(axis=1, keepdims=True)) * shift / width
    squares = (away**2).sum(axis=1) / 2

    def ratio(z: np.ndarray) -> np.ndarray:
        return np.log(np.exp(z @ away.T - squares).mean(axis=1))

    random = np.random.Generator(np.random.PCG64(made.spec.seed))
    least = np.quantile(ratio(random.standard_normal((NULL, PULLS))), 1 - ALARMS)
    return bool(ratio(np.log(values)[None, :] / width)[0] > least)


def best_of_shapes(made: Campaign) -> bool:
    """Whether Neyman and Pearson's test sees an overshoot, or a seat that gives way.

    It knows the noise, the fault's form and its size, whether one pull or all have it, not which;
    each pull's friction, stiffness, enclosure and slack are free, so that only what none of these
    can make counts.
    """
    spec, brake = made.spec, made.subjects[0].true
    fault = {name: getattr(spec.machine, name) or getattr(spec.odd, name) for name in FORMS}
    quiet = replace(spec.machine, force_noise=0.0, overshoot=0.0, seating=0.0)
    plain, faulty = (
        campaign(replace(spec, machine=machine, odd=Odd())).traces()
        for machine in (quiet, replace(quiet, **fault))
    )
    size, seen = [], []
    for test, trace, without, with_it in zip(made.tests, made.traces(), plain, faulty, strict=True):
        own = [
            np.log(brake.scale_factor * test.friction),
            np.log((brake.stiffness_measured or 0) * test.stiffness),
            test.enclosure,
            spec.machine.slack,
            0.0,
        ]
        free = slopes()(np.array(own), trace.elongation, float(test.vacuum or 0), brake)[:, :4]
        form = with_it.force - without.force
        form = form - free @ np.linalg.lstsq(free, form, rcond=None)[0]
        size.append(float(np.sqrt(form @ form)) / spec.machine.force_noise)
        told = form @ (trace.force - without.force) / np.sqrt(form @ form)
        seen.append(float(told) / spec.machine.force_noise)
    sizes = np.array(size)

    def ratio(z: np.ndarray) -> np.ndarray:
        each = z * sizes - sizes**2 / 2
        if spec.odd.how_many:
            top = each.max(axis=1)
            return top + np.log(np.exp(each - top[:, None]).mean(axis=1))
        return each.sum(axis=1)

    random = np.random.Generator(np.random.PCG64(spec.seed))
    least = np.quantile(ratio(random.standard_normal((NULL, PULLS))), 1 - ALARMS)
    return bool(ratio(np.array(seen)[None, :])[0] > least)


@functools.cache
def slopes() -> Callable[..., np.ndarray]:
    """How the force changes with a pull's own numbers, as `forward.pull_force` has them."""
    law = jax.jit(jax.jacfwd(lambda own, u, vacuum, brake: pull_force(own, u, vacuum, 1, 1, brake)))
    return lambda *given: np.asarray(law(*given))


def table(found: dict[str, Tally]) -> str:
    """The table in Markdown."""

    def share(count: int | None, of: int) -> str:
        return "–" if count is None or not of else f"{count / of:.1%}"

    lines = [
        "| what is wrong | campaigns | `calibrate` | named | whole curves | table alone "
        "| `validate` | best test |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, t in found.items():
        strong = next(f for f in FAULTS if f.name == name).strong
        cells = [
            f"**{name}**" if strong else name,
            f"{t.campaigns:,}",
            share(t.found, t.campaigns),
            share(None if name == NONE else t.named, t.campaigns),
            share(t.curves, t.campaigns),
            share(t.table, t.campaigns),
            share(t.validated, t.campaigns),
            share(t.best, t.campaigns),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def section(found: dict[str, Tally], campaigns: int, seed: int) -> str:
    """What stands between the marks of docs/coverage.md."""
    own = 1.96 * np.sqrt(0.05 * 0.95 / found[NONE].campaigns)
    return f"""{MARKS[0]}

Made by `python tests/pull_faults.py --campaigns {campaigns} --seed {seed} --write`:

{table(found)}

Percentages are of campaigns in which a check prints LOOK or a pull is rejected. The
first row, the false alarms, has an uncertainty of {own:.1%}.

{MARKS[1]}"""


def main() -> int:
    """Measure, print, write; 1 where a fault is missed too often, or none is found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS, help="of each fault")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--write", action="store_true", help="write docs/coverage.md")
    given = parser.parse_args()
    found = {}
    for fault in FAULTS:
        # false alarms are few, and counted on more campaigns
        count = given.campaigns * (FAULTLESS if fault.name == NONE else 1)
        found[fault.name] = measure(
            fault, count, given.seed, lambda s: print(s, file=sys.stderr, flush=True)
        )
        print(table({fault.name: found[fault.name]}).splitlines()[-1], flush=True)
    if given.write:
        text = PAGE.read_text(encoding="utf-8")
        before, rest = text.split(MARKS[0])
        made = section(found, given.campaigns, given.seed)
        PAGE.write_text(before + made + rest.split(MARKS[1])[1], encoding="utf-8")
    wrong = [
        f"{fault.name}: {t.found / t.campaigns:.1%}"
        for fault in FAULTS
        if (t := found[fault.name])
        and (
            (fault.strong and t.found < MUST * t.campaigns)
            or (fault.name == NONE and t.found > ALARMS * t.campaigns)
        )
    ]
    for line in wrong:
        print(f"not as it must be: {line}")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
