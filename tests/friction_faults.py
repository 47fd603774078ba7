"""How often faulty friction tests are found, and faultless ones called faulty; `make coverage`.

Campaigns of the virtual laboratory: three to five tests of Kapton or PTFE; into one of them, or
into all, one fault is put. Faults of the load cell and of the rig are put into campaigns of a rig
that shares no code with layerjam (tests/independent/sled_rig.py). The table goes to
docs/coverage.md.

    python tests/friction_faults.py [--campaigns N] [--seed S] [--write]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from independent import sled_rig
from layerjam.brake.device.load import load
from layerjam.core.errors import LayerjamError
from layerjam.laboratory.campaigns.campaign import campaign
from layerjam.laboratory.campaigns.spec import FrictionTests, Spec, Truth
from layerjam.laboratory.identify.friction.agreement import Reference, find_reference
from layerjam.laboratory.identify.friction.reduction import FrictionResult, pool, reduce_repeat
from layerjam.laboratory.identify.friction.standards import PAPER
from layerjam.laboratory.measure.trace import Trace, check_trace

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- faulty friction tests: begin -->", "<!-- faulty friction tests: end -->")
CAMPAIGNS, SEED = 300, 2018
MUST, ALARMS = 0.95, 0.025
NONE, NONE_OF_RIG = "nothing", "nothing, on the independent rig"
LEVELS = ("passed", "note", "warning", "failed")
NORMAL = 0.25 * 9.80665
POUND, GRAM, INCH = 4.4482216, 9.80665e-3, 25.4
SPIKE = {"spike": 1.0}
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
    rig: dict[str, float] | None = None
    """Faults of all tests on the independent rig: {field: value}. Forces are relative to kinetic
    friction; `limit` is drawn near its value."""
    level: str = "failed"
    """Level of a check, at least, that finds it."""
    right: float | None = None
    """Largest relative error of static friction, if the fault is corrected and only named."""

    @property
    def healthy(self) -> bool:
        """Whether nothing is wrong."""
        return self.name in (NONE, NONE_OF_RIG)


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
    Fault(name=NONE_OF_RIG, gross=False, rig={}),
    Fault(name="forces of all tests × 0.5, friction measured before", rig={"gain": 0.5}),
    Fault(name="forces of all tests × 2, friction measured before", rig={"gain": 2.0}),
    Fault(name="forces of all tests × 4, friction measured before", rig={"gain": 4.0}),
    Fault(name="forces of all tests × 0.9", rig={"gain": 0.9}, gross=False),
    Fault(name="load cell with steps of 0.8 of the kinetic force", rig={"step": 0.8}),
    Fault(name="load cell with steps of 1.6 of the kinetic force", rig={"step": 1.6}),
    Fault(name="load cell with steps of 0.2 of the kinetic force", rig={"step": 0.2}),
    Fault(name="a spike of one sample in each test", rig=SPIKE, right=0.05),
    Fault(name="a spike of three samples in each test", rig=SPIKE | {"spike_width": 3}, right=0.05),
    Fault(name="a zero error of 15 %", rig={"zero": 0.15}),
    Fault(name="a zero error of −20 %", rig={"zero": -0.2}),
    Fault(name="a zero error of 5 % (warning)", rig={"zero": 0.05}, level="warning"),
    Fault(name="a zero that drifts by 13 % up to the window", rig={"drift": 0.13}),
    Fault(name="a zero that drifts by −13 %", rig={"drift": -0.13}),
    Fault(name="a zero that drifts by 6 % (warning)", rig={"drift": 0.06}, level="warning"),
    Fault(name="a rig that is not level, 15 % (warning)", rig={"tilt": 0.15}, level="warning"),
    Fault(name="saturated at 0.7 to 0.9 of the kinetic force", rig={"limit": 0.8}),
    Fault(name="saturated between kinetic and static force", rig={"limit": 1.2}, gross=False),
    Fault(name="a string with 45 mm of slack", rig={"slack": 0.045}),
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


def drawn_on_rig(fault: Fault, seed: Sequence[int]) -> tuple[Reference, list[Trace], list[Trace]]:
    """The friction measured before, the tests, and the same tests without the fault."""
    random = np.random.Generator(np.random.PCG64(list(seed)))
    kinetic = random.uniform(0.05, 0.4) * NORMAL
    static = kinetic * random.uniform(1.1, 1.6)
    scatters = random.uniform(0.02, 0.08), random.uniform(0.01, 0.05)
    common = {
        "stiffness": random.uniform(100, 500),
        "rate": float(random.choice([20, 50, 100])),
        "texture": random.uniform(0.005, 0.02),
        "noise": random.uniform(1e-3, 4e-3),
        "slack": random.uniform(0, 5e-3),
        "home": float(random.choice([0, 4])),
    }
    made: list[Trace] = []
    clean: list[Trace] = []
    for number in range(int(random.integers(3, 6))):
        factors = [1 + scatter * random.standard_normal() for scatter in scatters]
        sled = sled_rig.Rig(static=static * factors[0], kinetic=kinetic * factors[1], **common)
        where = {"spike_at": random.uniform(0.02, 0.95), "clip": random.uniform(-1, 1)}
        run_seed = int(random.integers(1 << 31))
        for rig, out in ((faulty_rig(fault, sled, kinetic, static, where), made), (sled, clean)):
            time, travel, force = sled_rig.run(rig, run_seed)
            out.append(Trace(force, travel, time, f"test-{number}.csv", "rig"))
    # the lot differs from the one measured before as much as repeats do
    lot = 1 + np.array(scatters) * random.standard_normal(2)
    own = {
        "static": (static * lot[0] / NORMAL, scatters[0]),
        "kinetic": (kinetic * lot[1] / NORMAL, scatters[1]),
    }
    return Reference(earlier=own), made, clean


def faulty_rig(
    fault: Fault, sled: sled_rig.Rig, kinetic: float, static: float, where: dict[str, float]
) -> sled_rig.Rig:
    """The rig with a fault, whose forces are relative to kinetic friction [N]."""
    given = dict(fault.rig or {})
    middle = sled.rest + 0.070 / sled.speed  # time at the middle of the window
    if "limit" in given:
        between = (kinetic + static) / 2 + 0.1 * where["clip"] * (static - kinetic)
        low = (0.8 + 0.1 * where["clip"]) * kinetic
        given["limit"] = low if given["limit"] < 1 else between
        given["noise"] = 1.5e-3
    for name in ("zero", "step", "spike"):
        if name in given:
            given[name] *= kinetic
    if "drift" in given:
        given["drift"] *= kinetic / middle
    if "tilt" in given:
        given["tilt"] *= kinetic / 0.070
    if "spike" in given:
        given["spike_at"] = where["spike_at"]
    whole = {"spike_width": int(given.pop("spike_width", 1))}
    return replace(sled, **given, **whole)  # type: ignore[arg-type]


def judged(reference: Reference, traces: Sequence[Trace]) -> FrictionResult | None:
    """The result of the tests; None if one of them is refused."""
    try:
        repeats = [reduce_repeat(check_trace(trace, lambda _: None), NORMAL) for trace in traces]
    except LayerjamError:
        return None
    return pool(repeats, [], NORMAL, None, PAPER, False, reference)


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
        place = (seed, FAULTS.index(fault), number)
        if fault.rig is not None:
            reference, traces, clean = drawn_on_rig(fault, place)
            faulty: set[int] = set()
        else:
            name, traces, faulty = drawn(fault, place)
            reference, clean = find_reference(load(name)), []
        result = judged(reference, traces)
        if result is None:  # the command refuses the file by its name
            tally.found += 1
            tally.named += 1
            continue
        failed = [c for c in result.checks if LEVELS.index(c.level) >= LEVELS.index(fault.level)]
        tally.found += is_corrected(fault, result, clean) if fault.right else bool(failed)
        told = " ".join(c.sentence for c in failed)
        named = {place for place, trace in enumerate(traces) if trace.path in told}
        tally.named += named == faulty
    return tally


def is_corrected(fault: Fault, result: FrictionResult, clean: Sequence[Trace]) -> bool:
    """Whether every test is as without its spike, and the spike is named."""
    right = [reduce_repeat(trace, NORMAL).static for trace in clean]
    ratios = [repeat.static / true for repeat, true in zip(result.repeats, right, strict=True)]
    named = all(any("spike" in w for w in repeat.warnings) for repeat in result.repeats)
    return named and max(abs(ratio - 1) for ratio in ratios) <= (fault.right or 0)


def table(found: dict[str, Tally]) -> str:
    """The table in Markdown."""
    lines = ["| fault | campaigns | found | named |", "|---|---|---|---|"]
    for fault in FAULTS:
        if fault.name in found:
            tally = found[fault.name]
            name = f"**{fault.name}**" if fault.gross else fault.name
            named = "–" if fault.of_all or fault.healthy or fault.rig else share(tally.named, tally)
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
        (fault.gross and part < MUST) or (fault.healthy and part > ALARMS)
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
