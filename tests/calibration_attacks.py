"""Campaigns of pulls that an independent generator writes: coverage, faults found, false alarms.

The pulls are those of tests/independent/pulls.py, which shares no code with the product. The table
goes to docs/coverage.md.

    python tests/calibration_attacks.py [--campaigns N] [--seed S] [--only WORD] [--write]
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import jax
import numpy as np

jax.config.update("jax_enable_x64", True)

from independent.pulls import BRAKE, OVERLAP, SCALE_FACTOR, VACUUMS, Pull, repeats  # noqa: E402
from layerjam.brake.device.load import load  # noqa: E402
from layerjam.laboratory.identify.calibration.gross import find_gross_pulls  # noqa: E402
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks  # noqa: E402
from layerjam.laboratory.identify.calibration.result import Calibration  # noqa: E402
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves  # noqa: E402
from layerjam.laboratory.identify.curves import make_curves  # noqa: E402
from layerjam.laboratory.identify.pull.features import pull_features  # noqa: E402
from layerjam.laboratory.identify.pull.summary import find_baseline  # noqa: E402
from layerjam.laboratory.measure.sidecar import Facts  # noqa: E402
from layerjam.laboratory.measure.trace import Trace  # noqa: E402

PAGE = Path(__file__).parent.parent / "docs" / "coverage.md"
MARKS = ("<!-- independent campaigns: begin -->", "<!-- independent campaigns: end -->")
CAMPAIGNS, SEED, SAMPLES = 300, 48, 2000
COVERS, FINDS, ALARMS = 0.9, 0.8, 0.025
Random = np.random.Generator
FILE = load(BRAKE)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One row: how a campaign is drawn, what its sidecars state, and the share that is required.

    `least` is the smallest share of campaigns whose interval of the scale factor contains the true
    value, `found` that in which a check fails; a healthy case has `found` None. The names of the
    files show the order of the pulls, or their start times or stated repeats do.
    """

    name: str
    draw: Callable[[Random], Sequence[Pull]]
    state: Callable[[int], Mapping[str, Any]] = lambda place: {}
    least: float | None = None
    found: float | None = None
    depth: str = "exact"
    order: str = "names"


def own_mounting(place: int) -> dict[str, Any]:
    return {"mounting": place + 1}


def scattered(
    random: Random, vacuums: Sequence[float] = VACUUMS, count: int = 4, **numbers: float
) -> list[Pull]:
    """Return pulls that scatter by 1 to 4 % (SD), each with its own mounting."""
    return list(repeats(random, vacuums, count, random.uniform(0.01, 0.04), **numbers))


def mounted(random: Random, label: Callable[[int], int], count: int = 4) -> list[Pull]:
    """Return pulls that share the friction and stiffness of their mounting, which scatter more."""
    pulls = list(repeats(random, VACUUMS, count, random.uniform(0.003, 0.02)))
    shared = 1 + random.uniform(0.01, 0.05) * random.standard_normal((len(pulls), 2))
    return [
        replace(
            pull,
            scale_factor=pull.scale_factor * shared[label(place), 0],
            stiffness=pull.stiffness * shared[label(place), 1],
        )
        for place, pull in enumerate(pulls)
    ]


def multiplied(
    random: Random, which: Sequence[int], multiplier: float, count: int = 12
) -> list[Pull]:
    """Return pulls of which some have other forces, in a random order."""
    order = random.permutation(count)
    return [
        replace(pull, multiplier=multiplier) if order[place] in which else pull
        for place, pull in enumerate(scattered(random)[:count])
    ]


def worn(random: Random, vacuums: Sequence[float], count: int, rate: float) -> list[Pull]:
    """Return pulls that lose a share `rate` of their friction each; the last has the true one."""
    pulls = list(repeats(random, vacuums, count, random.uniform(0.005, 0.02)))
    last = len(pulls) - 1
    return [
        replace(p, scale_factor=p.scale_factor * (1 - rate) ** (place - last))
        for place, p in enumerate(pulls)
    ]


def remembered(random: Random, correlation: float = 0.8) -> list[Pull]:
    """Return pulls each of which resembles the pull before (AR(1))."""
    spread, last = random.uniform(0.01, 0.04), random.standard_normal()
    pulls = []
    for pull in repeats(random, VACUUMS, 4, 0.0):
        pulls.append(replace(pull, scale_factor=pull.scale_factor * (1 + spread * last)))
        last *= correlation
        last += np.sqrt(1 - correlation**2) * random.standard_normal()
    return pulls


def misread(random: Random, gain: float = 0, zero: float = 0, tare: float = 0) -> list[Pull]:
    """Return pulls that share errors of the gauge (relative, Pa) and of the force's zero (N)."""
    share, offset, force = (random.uniform(-x, x) for x in (gain, zero, tare))
    pulls = repeats(random, VACUUMS, 4, random.uniform(0.005, 0.02))
    return [replace(p, true_vacuum=p.vacuum * (1 + share) + offset, tare=force) for p in pulls]


LABELS: dict[str, tuple[Callable[[int], int], int]] = {
    "one per pull": (lambda place: place, 4),
    "one per vacuum": (lambda place: place // 4, 4),
    "two batches": (lambda place: place // 6, 4),
    "two of three pulls each": (lambda place: place // 3, 2),
    "one in all": (lambda place: 0, 4),
}
DEPTHS = ("exact", "curves")
STATED: dict[str, Callable[[int], Mapping[str, Any]]] = {
    "names": own_mounting,
    "start times": own_mounting,
    "repeats": lambda place: {"repeat": place + 1},
}
CASES = (
    *(
        Case(name=f"healthy, {words}, {depth}", state=own_mounting, least=COVERS, depth=depth,
             draw=lambda r, v=vacuums, n=count: scattered(r, v, n))
        for depth in DEPTHS
        for words, vacuums, count in (
            ("three vacuums", VACUUMS, 4), ("one vacuum", (80e3,), 12), ("5 pulls", (80e3,), 5),
        )
    ),
    *(
        Case(name=f"mountings {'' if stated else 'not '}stated: {words}",
             draw=lambda r, f=label, n=count: mounted(r, f, n),
             state=(lambda place, f=label: {"mounting": f(place) + 1}) if stated else lambda _: {},
             least=COVERS)
        for stated in (True, False)
        for words, (label, count) in LABELS.items()
    ),
    Case(name="mountings are the repeats of each vacuum", state=STATED["repeats"],
         draw=lambda r: mounted(r, lambda n: n % 4), least=COVERS, order="repeats"),
    Case(name="gauge ± 3 %, stated", draw=lambda r: misread(r, gain=0.03), least=COVERS,
         state=lambda place: own_mounting(place) | {"gauge_limit": 2.4e3}),
    Case(name="gauge's zero ± 1 kPa, stated", draw=lambda r: misread(r, zero=1e3), least=COVERS,
         state=lambda place: own_mounting(place) | {"gauge_limit": 1e3}),
    Case(name="force's zero ± 2 N", draw=lambda r: misread(r, tare=2.0), least=COVERS,
         state=own_mounting),
    Case(name="force's zero ± 5 N", draw=lambda r: misread(r, tare=5.0), least=COVERS,
         state=own_mounting),
    *(
        Case(name=f"each pull resembles the last (ρ = 0.8), {words}", draw=remembered,
             state=state, least=COVERS, order=order)
        for words, state, order in (
            ("mountings not stated", lambda place: {}, "names"),
            ("mountings stated", own_mounting, "names"),
            ("mountings stated, order of start times", own_mounting, "start times"),
        )
    ),
    *(
        Case(name=f"forces of {number} of {count} pulls × {multiplier:g}", found=required,
             draw=lambda r, n=number, m=multiplier, c=count: multiplied(r, range(n), m, c),
             state=own_mounting)
        for number, count, multiplier, required in (
            (7, 12, 0.7, FINDS), (7, 12, 1.6, FINDS), (2, 3, 0.55, FINDS), (5, 12, 1.25, FINDS),
            (5, 12, 1.15, 0.3),
        )
    ),
    *(
        Case(name=f"wear of 3 % a pull, {words}, order of {order}", found=FINDS, order=order,
             state=STATED[order], draw=lambda r, v=vacuums, n=count: worn(r, v, n, 0.03))
        for order in ("names", "start times", "repeats")
        for words, vacuums, count in (("one vacuum", (80e3,), 12), ("three vacuums", VACUUMS, 4))
    ),
    *(
        Case(name=f"{words}, {depth}", found=FINDS, depth=depth, state=own_mounting,
             draw=lambda r, n=numbers: [replace(p, **n) for p in scattered(r)])
        for depth in DEPTHS
        for words, numbers in (
            ("static friction + 20 % over 30 mm", {"static": 0.2}),
            ("overlap 5 mm short", {"overlap": OVERLAP - 5e-3}),
        )
    ),
)  # fmt: skip


def read(case: Case, pulls: Sequence[Pull], random: Random) -> list[Any]:
    """Return the pulls as the product reads them: (record, features, vacuum).

    Unless their names show the order, the files have random names and are given by name.
    """
    used = []
    names = [f"pull-{place + 1:02d}.csv" for place in range(len(pulls))]
    if case.order != "names":
        names = [f"{name}.csv" for name in random.permutation(list("abcdefghijklmnop"))]
    repeats = Counter[float]()
    for place, (pull, path) in enumerate(zip(pulls, names, strict=False)):
        time, elongation, force = pull.record(random, SAMPLES)
        stated = dict(case.state(place))
        if "repeat" in stated:  # counted within each vacuum
            repeats[pull.vacuum] += 1
            stated["repeat"] = repeats[pull.vacuum]
        facts = Facts(vacuum=pull.vacuum, speed=pull.speed, **stated)
        start = 1e9 + 300.0 * place if case.order == "start times" else None
        trace = Trace(force, elongation, time, path, "csv", facts=facts, start=start)
        features = pull_features(trace)
        features = replace(features, baseline=find_baseline(trace, features))
        used.append((trace, features, pull.vacuum))
    return sorted(used, key=lambda row: row[0].path)


def calibrate(case: Case, random: Random) -> Calibration:
    """Return the calibration of one campaign, without the pulls that the command leaves out."""
    used = read(case, case.draw(random), random)
    out = find_gross_pulls([(pull, vacuum) for _, pull, vacuum in used], FILE.brake)
    curves = make_curves([row for place, row in enumerate(used) if place not in out])
    method = calibrate_peaks if case.depth == "exact" else calibrate_curves
    return method(curves, FILE.brake)


@dataclass
class Tally:
    """Results of one case: campaigns, intervals with the true value, failed checks, widths."""

    count: int = 0
    inside: int = 0
    failed: int = 0
    checks: Counter[str] = field(default_factory=Counter)
    widths: list[float] = field(default_factory=list)

    def add(self, fit: Calibration) -> None:
        self.count += 1
        names = {check.name for check in fit.checks if check.level == "failed"}
        self.failed += bool(names)
        self.checks.update(names)
        interval = fit.intervals["scale_factor"]
        if interval is not None:
            self.inside += interval.low <= SCALE_FACTOR <= interval.high
            self.widths.append(interval.half_width / SCALE_FACTOR)

    def row(self, case: Case) -> str:
        """The row of the table; coverage only if the case has no fault."""
        covered = f"{self.inside / self.count:.1%}" if case.found is None else "–"
        which = ", ".join(f"`{n}` {k / self.count:.0%}" for n, k in self.checks.most_common(3))
        return (
            f"| {case.name} | {self.count} | {covered} | {np.median(self.widths):.2g} | "
            f"{self.failed / self.count:.1%} | {which or '–'} |"
        )

    def is_right(self, case: Case) -> bool:
        """Whether the shares are those required, within the chance of three standard errors."""

        def reaches(part: float, least: float) -> bool:
            return part >= least - 3 * (least * (1 - least) / self.count) ** 0.5

        if case.found is not None:
            return reaches(self.failed / self.count, case.found)
        quiet = reaches(1 - self.failed / self.count, 1 - ALARMS)
        return quiet and (case.least is None or reaches(self.inside / self.count, case.least))


def measure(case: Case, campaigns: int, seed: int = SEED) -> Tally:
    tally = Tally()
    for number in range(campaigns):
        random = np.random.Generator(np.random.PCG64([seed, number, *case.name.encode()]))
        tally.add(calibrate(case, random))
    return tally


def write(rows: Sequence[str], campaigns: int, seed: int) -> None:
    """Write the section into docs/coverage.md."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(MARKS[0])
    made = f"""{MARKS[0]}

`python tests/calibration_attacks.py --campaigns {campaigns} --seed {seed} --write` writes this
table:

| campaign | number | contain the true value | half width | a check failed | which |
|---|---|---|---|---|---|
{chr(10).join(rows)}

{MARKS[1]}"""
    PAGE.write_text(before + made + rest.split(MARKS[1])[1], encoding="utf-8")


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", default="", help="word in the name of a case")
    parser.add_argument("--write", action="store_true", help="write docs/coverage.md")
    given = parser.parse_args()
    rows, wrong = [], []
    for case in CASES:
        if given.only in case.name:
            slow = case.found is not None or case.depth == "curves"
            tally = measure(case, -(-given.campaigns // (3 if slow else 1)), given.seed)
            rows.append(tally.row(case))
            print(rows[-1], flush=True)
            wrong += [case.name] * (not tally.is_right(case))
    if given.write:
        write(rows, given.campaigns, given.seed)
    if wrong:
        sys.exit(f"not as required: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
