"""How often faulty friction tests are found, and faultless ones called faulty; `make coverage`.

Campaigns of the virtual laboratory: three to five tests of Kapton or PTFE; into one of them, or
into all, one fault is put. The table goes to docs/coverage.md.

    python tests/friction_faults.py [--campaigns N] [--seed S] [--write]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from layerjam.campaigns.campaign import campaign
from layerjam.campaigns.spec import FrictionTests, Spec, Truth
from layerjam.device.load import load
from layerjam.errors import LayerjamError
from layerjam.identify.friction.agreement import film_friction_range
from layerjam.identify.friction.reduction import FrictionResult, pool, reduce_repeat
from layerjam.identify.friction.standards import PAPER
from layerjam.measure.trace import Trace

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- faulty friction tests: begin -->", "<!-- faulty friction tests: end -->")
CAMPAIGNS, SEED = 500, 2018
MUST, ALARMS = 0.95, 0.05
NONE = "nothing"
NORMAL = 0.25 * 9.80665
POUND, GRAM, INCH = 4.4482216, 9.80665e-3, 25.4
BRAKES = ("choi2018-kapton", "choi2018-ptfe")


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One row: factors on the force and the travel of one test, or of all."""

    name: str
    force: float = 1.0
    travel: float = 1.0
    first: float = 1.0
    """Factor on the force before the window of the kinetic mean."""
    other_film: bool = False
    of_all: bool = False
    gross: bool = True
    """Must be found in 95 % of campaigns."""


FAULTS = (
    Fault(name=NONE, gross=False),
    Fault(name="forces of one test / 1000 (kN read as N)", force=1e-3),
    Fault(name="forces of one test × 1000 (N read as kN)", force=1e3),
    Fault(name="forces of one test halved", force=0.5),
    Fault(name="forces of one test × 0.3", force=0.3),
    Fault(name="forces of one test × 2", force=2.0),
    Fault(name="lbf read as N in one test", force=1 / POUND),
    Fault(name="N read as lbf in one test", force=POUND),
    Fault(name="g read as N in one test", force=1 / GRAM),
    Fault(name="N read as g in one test", force=GRAM),
    Fault(name="mm read as in, in one test", travel=INCH),
    Fault(name="in read as mm, in one test", travel=1 / INCH),
    Fault(name="another film in one test", other_film=True),
    Fault(name="a third of the normal force in one test", force=1 / 3),
    Fault(name="static friction of one test × 5", first=5.0),
    Fault(name="forces of all tests / 1000", force=1e-3, of_all=True),
    Fault(name="lbf read as N in all tests", force=1 / POUND, of_all=True),
    Fault(name="another film in all tests", other_film=True, of_all=True),
    Fault(name="normal force of all tests typed five times too small", force=5.0, of_all=True),
    Fault(name="forces of one test × 1.5", force=1.5, gross=False),
    Fault(name="forces of one test × 0.7", force=0.7, gross=False),
    Fault(name="forces of one test × 1.2", force=1.2, gross=False),
)  # fmt: skip


def drawn(fault: Fault, seed: Sequence[int]) -> tuple[str, list[Trace], set[int]]:
    """The film's brake, the tests, and the places of those with the fault."""
    random = np.random.Generator(np.random.PCG64(list(seed)))
    first = int(random.integers(2))
    repeats = int(random.integers(3, 6))
    kinetic, static = random.uniform(0.01, 0.05), random.uniform(0.02, 0.1)
    factor = random.uniform(0.85, 1.2)
    noise, laboratory = random.uniform(1e-3, 1e-2), int(random.integers(1 << 31))
    faulty = set(range(repeats)) if fault.of_all else {int(random.integers(repeats))}

    def tests(name: str) -> list[Trace]:
        film = load(name).brake.film
        truth = Truth(brake=name, static=factor * film.static, kinetic=factor * film.kinetic)
        friction = FrictionTests(
            repeats=repeats,
            normal_force=NORMAL,
            kinetic_scatter=kinetic,
            static_scatter=static,
            force_noise=noise * film.kinetic * NORMAL,
        )
        spec = Spec(brakes=(truth,), seed=laboratory, friction=friction)
        return list(campaign(spec).traces("friction"))

    made = tests(BRAKES[first])
    other = tests(BRAKES[1 - first]) if fault.other_film else made
    for place in faulty if fault.name != NONE else ():
        trace = other[place]
        slid = trace.elongation - trace.elongation[0]
        peak = np.where(slid < PAPER.window[0], fault.first, 1.0)
        made[place] = replace(
            trace,
            force=trace.force * fault.force * peak,
            elongation=trace.elongation * fault.travel,
        )
    return BRAKES[first], made, faulty


def judged(name: str, traces: Sequence[Trace]) -> FrictionResult | None:
    """The result of the tests; None if one of them is refused."""
    try:
        repeats = [reduce_repeat(trace, NORMAL) for trace in traces]
    except LayerjamError:
        return None
    return pool(repeats, [], NORMAL, None, PAPER, False, film_friction_range(load(name)))


@dataclass
class Tally:
    """Campaigns, in how many a check failed or a test was refused, and the right one was named."""

    campaigns: int = 0
    found: int = 0
    named: int = 0


def measure(fault: Fault, campaigns: int, seed: int) -> Tally:
    """Counts over random campaigns."""
    tally = Tally(campaigns=campaigns)
    for number in range(campaigns):
        name, traces, faulty = drawn(fault, (seed, FAULTS.index(fault), number))
        result = judged(name, traces)
        if result is None:  # the command refuses the file by its name
            tally.found += 1
            tally.named += 1
            continue
        failed = [c for c in result.checks if c.level == "failed"]
        tally.found += bool(failed)
        told = " ".join(c.sentence for c in failed)
        named = {place for place, trace in enumerate(traces) if trace.path in told}
        tally.named += named == faulty
    return tally


def table(found: dict[str, Tally]) -> str:
    """The table in Markdown."""
    lines = ["| fault | campaigns | failed | named |", "|---|---|---|---|"]
    for fault in FAULTS:
        if fault.name in found:
            tally = found[fault.name]
            name = f"**{fault.name}**" if fault.gross else fault.name
            named = "–" if fault.of_all or fault.name == NONE else share(tally.named, tally)
            lines.append(
                f"| {name} | {tally.campaigns:,} | {share(tally.found, tally)} | {named} |"
            )
    return "\n".join(lines)


def share(count: int, tally: Tally) -> str:
    """A count as a share of the campaigns."""
    return f"{count / tally.campaigns:.1%}"


def section(found: dict[str, Tally], campaigns: int, seed: int) -> str:
    """The text between the marks of docs/coverage.md."""
    return f"""{MARKS[0]}

`python tests/friction_faults.py --campaigns {campaigns} --seed {seed} --write` writes this table:

{table(found)}

*failed* is the percentage of campaigns in which a check failed or a file was rejected. The first
row shows the false alarms. *named* is the percentage in which the faulty test, and no other, was
named. **Bold** rows must reach {MUST:.0%}.

{MARKS[1]}"""


def write(found: dict[str, Tally], campaigns: int, seed: int) -> None:
    """Write the section into docs/coverage.md."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(MARKS[0])
    made = section(found, campaigns, seed)
    PAGE.write_text(before + made + rest.split(MARKS[1])[1], encoding="utf-8")


def misses(found: dict[str, Tally]) -> list[str]:
    """Rows that are not as they must be."""
    wrong: Callable[[Fault, float], bool] = lambda fault, part: (  # noqa: E731
        (fault.gross and part < MUST) or (fault.name == NONE and part > ALARMS)
    )
    return [
        f"{fault.name}: {tally.found / tally.campaigns:.1%}"
        for fault in FAULTS
        if (tally := found.get(fault.name)) and wrong(fault, tally.found / tally.campaigns)
    ]


def main() -> int:
    """Measure, print, write; 1 if a fault is missed too often, or none is found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS, help="of each fault")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--write", action="store_true", help="write docs/coverage.md")
    given = parser.parse_args()
    found = {}
    for fault in FAULTS:
        found[fault.name] = measure(fault, given.campaigns, given.seed)
        print(table({fault.name: found[fault.name]}).splitlines()[-1], flush=True)
    if given.write:
        write(found, given.campaigns, given.seed)
    for line in misses(found):
        print(f"not as it must be: {line}")
    return int(bool(misses(found)))


if __name__ == "__main__":
    sys.exit(main())
