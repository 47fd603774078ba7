"""Pull by pull: what each says beside the others, which are unlike them, and in what.

Six things of a pull are looked at. `factor`: the scale factor of its peak. `slope`: its stiffness.
`shape`: whether the curve after the peak has the peak's scale factor. `vacuum` and `speed`: whether
the pulls at one vacuum, or at one speed, have another scale factor than the rest, and whether the
crosshead moved as fast as is stated. `seating`: whether the rise is straight. A verdict is "ok",
"odd", or "untold" where too little is known.

A single pull whose friction was another and one whose vacuum was another look alike: the enclosure,
which would tell them apart, carries a sixth of the force and scatters more than that takes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.identify.calibration.pull_fit import PullFit
from layerjam.identify.checks import Check, check, no_trend, percent, repeats, shape
from layerjam.identify.curves import ALIKE, Curve, levels
from layerjam.identify.odd import FEWEST, group_apart, middle_of_others, odd_ones
from layerjam.measure.trace import Array
from layerjam.units import show

TESTS = ("factor", "slope", "shape", "vacuum", "speed", "seating")
ALARMS: Mapping[str, float] = {
    "factor": 0.015,
    "slope": 0.003,
    "shape": 0.003,
    "vacuum": 0.004,
    "speed": 0.003,
    "seating": 0.002,
    "seating of all": 0.002,
    "shape of all": 0.002,
}
"""Share of faultless campaigns that each test may call faulty; together below 5 %.

Most goes to the factor: a film's friction scatters by some percent, so that a pull 15 % off needs a
sharp test; what the others look for stands far out of their scatter.
"""
LEAST: Mapping[str, float] = {
    "factor": 0.02,
    "slope": 0.03,
    "shape": 0.015,
    "vacuum": 0.03,
    "speed": 0.03,
    "seating": 0.05,
}
"""Relative difference up to which a pull is never odd, however sure the difference is."""
MOST = 0.125
"""A scale factor or stiffness further off the others' middle is odd whatever they scatter: two and
a half times what repeats may (`checks.repeats`)."""
OVERSHOOT = 0.1
"""Part by which the curve after the peak may lie off one pull's peak whatever the others do."""
SOFT = 0.08
"""Scatter between stiffnesses (SD, relative) up to which they agree."""


@dataclass(frozen=True, kw_only=True)
class SinglePull:
    """What one pull says, SI units; None where it does not tell.

    `factor` and `stiffness` are those of its peak and its slope; `shape` is the part by which the
    scale factor after the peak lies off the peak's, `seating` the one by which its rise is steeper
    in the upper half than in the lower; `recorded_speed` is from its time. At `vacuum_of_peak` its
    peak would have the others' scale factor. `verdicts` has all of `TESTS`.
    """

    file: str
    vacuum: float
    vacuum_of_peak: float | None
    speed: float | None
    recorded_speed: float | None
    factor: float | None
    stiffness: float | None
    shape: float | None
    seating: float | None
    verdicts: Mapping[str, str]
    sentence: str

    @property
    def odd(self) -> bool:
        """Whether anything about it is."""
        return "odd" in self.verdicts.values()


@dataclass
class _Findings:
    """Verdicts and sentences while the tests go over the pulls."""

    verdicts: list[dict[str, str]]
    said: dict[int, list[str]]

    def known(
        self, test: str, of: Sequence[float | None], fewest: int = FEWEST
    ) -> tuple[Array, list[int]]:
        """Values that are known, and whose they are; they begin as "ok" where enough tell."""
        whose = [i for i, value in enumerate(of) if value is not None]
        for i in whose if len(whose) >= fewest else ():
            self.verdicts[i][test] = "ok"
        return np.array([value for value in of if value is not None]), whose

    def odd(self, test: str, which: int, words: str) -> None:
        """One pull is odd in this test."""
        self.verdicts[which][test] = "odd"
        if words not in self.said[which]:
            self.said[which].append(words)


def single_pulls(
    curves: Sequence[Curve],
    fits: Sequence[PullFit | None],
    shapes: Sequence[float | None],
    expected: Array | None = None,
) -> tuple[SinglePull, ...]:
    """The table: one row a curve, with `fits` of those that have a peak and their `shapes`.

    `expected` (curves,) are the factors to within a common one, where a law of vacuum or speed was
    fitted: what is left beside them is compared.
    """
    known = [None if f is None else f.scale_factor for f in fits]
    law = np.ones(len(curves)) if expected is None else expected
    factors = [None if f is None else f / float(one) for f, one in zip(known, law, strict=True)]
    springs = [c.pull.stiffness if c.pull.straight else None for c in curves]
    rises = [c.pull.seating for c in curves]
    found = _Findings([dict.fromkeys(TESTS, "untold") for _ in curves], defaultdict(list))
    typical = float(np.median([f for f in factors if f is not None])) if any(factors) else None
    shifts = _groups(found, factors, curves)
    _factor(found, factors, shifts, [c.vacuum for c in curves])
    _each(found, "slope", _logs(springs), "stiffness {} off the others'", most=MOST)
    _shape(found, shapes)
    _speed(found, curves)
    _seating(found, curves)
    return tuple(
        SinglePull(
            file=curve.name,
            vacuum=curve.vacuum,
            vacuum_of_peak=None if not (typical and f) else curve.vacuum * f / typical,
            speed=curve.speed,
            recorded_speed=curve.recorded_speed,
            factor=known[i],
            stiffness=springs[i],
            shape=shapes[i],
            seating=None if (bend := rises[i]) is None else float(np.expm1(bend)),
            verdicts=found.verdicts[i],
            sentence=", ".join(found.said[i]),
        )
        for i, (curve, f) in enumerate(zip(curves, factors, strict=True))
    )


def _logs(values: Sequence[float | None]) -> list[float | None]:
    return [None if v is None else float(np.log(v)) for v in values]


def _each(
    found: _Findings,
    test: str,
    of: Sequence[float | None],
    words: str,
    *,
    fewest: int = FEWEST,
    most: float = float("inf"),
) -> None:
    """Each pull against the others in one number; `words` say by how much it is off them."""
    values, whose = found.known(test, of, fewest)
    out = odd_ones(values, ALARMS[test], LEAST[test], most)
    for place in out:
        off = float(np.expm1(values[place] - middle_of_others(values, out)))
        found.odd(test, whose[place], words.format(percent(off)))


def _factor(
    found: _Findings, factors: Sequence[float | None], shifts: Array, vacuums: Sequence[float]
) -> None:
    """Peaks unlike the others', with the vacuum that would explain them.

    `shifts` (curves,) are those of groups that are odd as a whole: their pulls are not.
    """
    logs, whose = found.known("factor", _logs(factors))
    logs = logs - shifts[whose]
    out = odd_ones(logs, ALARMS["factor"], LEAST["factor"], MOST)
    for place in out:
        off = float(np.expm1(logs[place] - middle_of_others(logs, out)))
        at = show(vacuums[whose[place]] * (1 + off), "Pa", 3)
        words = f"scale factor {percent(off)} off the others', as at {at}"
        found.odd("factor", whose[place], words)


def _shape(found: _Findings, shapes: Sequence[float | None]) -> None:
    """Curves after the peak that are unlike the others', or too far off their own peak."""
    words = "after the peak {} off its own peak, unlike the others"
    logs = [None if s is None else float(np.log1p(max(s, -0.99))) for s in shapes]
    _each(found, "shape", logs, words, fewest=1)
    for place, off in enumerate(shapes):
        if off is not None and abs(off) > OVERSHOOT:
            found.verdicts[place]["shape"] = "odd"
            if not any(said.startswith("after the peak") for said in found.said[place]):
                found.odd("shape", place, f"after the peak {percent(off)} off its own peak")


def _groups(found: _Findings, factors: Sequence[float | None], curves: Sequence[Curve]) -> Array:
    """The pulls at one vacuum, or at one speed, that have another scale factor than the rest.

    By how much their logarithm is off is returned (curves,), 0 for pulls of no such group.
    """
    shifts = np.zeros(len(curves))
    what: tuple[tuple[str, str, Callable[[Curve], float | None]], ...] = (
        ("vacuum", "Pa", lambda c: c.vacuum),
        ("speed", "m/s", lambda c: c.speed),
    )
    for test, unit, of in what:
        own = [of(c) for c in curves]
        told = [None if o is None else f for o, f in zip(own, _logs(factors), strict=True)]
        if len(grouped([o for o in own if o is not None])) < 2:
            continue
        values, whose = found.known(test, told)
        known = [v for i in whose if (v := own[i]) is not None]
        groups = grouped(known)
        apart = group_apart(values, groups, ALARMS[test], LEAST[test])
        if apart is None:
            continue
        group, off = apart
        at = show(float(np.mean([known[i] for i in group])), unit, 3)
        both = " (or those are wrong)" if len(groups) == 2 else ""
        words = f"at {at} scale factors are {percent(float(np.expm1(off)))} off the others'{both}"
        for place in group:
            found.odd(test, whose[place], words)
            shifts[whose[place]] += off
    return shifts


def grouped(values: Sequence[float]) -> list[list[int]]:
    """Indices of values that are alike."""
    members: dict[int, list[int]] = defaultdict(list)
    for place, level in enumerate(levels(values) if values else ()):
        members[level].append(place)
    return list(members.values())


def _speed(found: _Findings, curves: Sequence[Curve]) -> None:
    """Crossheads that moved otherwise than stated."""
    for place, curve in enumerate(curves):
        stated, recorded = curve.speed, curve.recorded_speed
        if stated is None or recorded is None:
            continue
        if abs(recorded / stated - 1) > ALIKE:
            words = f"moved at {show(recorded, 'm/s', 3)}, stated is {show(stated, 'm/s', 3)}"
            found.odd("speed", place, words)
        elif found.verdicts[place]["speed"] == "untold":
            found.verdicts[place]["speed"] = "ok"


def _seating(found: _Findings, curves: Sequence[Curve]) -> None:
    """Rises that bend, unlike the others' or in all pulls alike."""
    bends, whose = found.known("seating", [c.pull.seating for c in curves], 1)
    if not whose:
        return
    soft = _soft(bends.tolist())
    # at little vacuum the rise is short and its bend less sure: each counts in its own error
    errors = np.hypot([curves[i].pull.seating_se for i in whose], LEAST["seating"] / 4)
    middle = float(np.average(bends, weights=errors**-2))
    out = odd_ones((bends - middle) / errors, ALARMS["seating"], 0.0)
    for place, (bend, error) in enumerate(zip(bends, errors, strict=True)):
        apart = place in out and abs(bend - middle) > LEAST["seating"]
        alone = len(bends) < FEWEST and bend - 4 * error > LEAST["seating"]
        if apart or alone or soft:
            words = f"its rise is {percent(float(np.expm1(bend)))} steeper in its upper half"
            found.odd("seating", whose[place], words)


def _soft(bends: Sequence[float]) -> bool:
    """Whether rises bend as on a seat that yields, on the mean over the pulls."""
    from scipy.special import stdtrit

    values = np.asarray(bends)
    mean, count = float(values.mean()), len(values)
    if count < 2 or mean <= LEAST["seating"]:
        return False
    error = float(values.std(ddof=1)) / count**0.5
    return mean > float(stdtrit(count - 1, 1 - ALARMS["seating of all"])) * error


def pull_checks(
    rows: Sequence[SinglePull], half_width: float | None = None, end: Check | None = None
) -> tuple[Check, ...]:
    """Whether any pull is odd, or all are alike in shape and rise, and what their slopes say.

    `half_width` is the relative one of the scale factor's 95 % interval and `end` the check at the
    curves' end, as in `checks.shape`.
    """
    odd = [f"{row.file}: {row.sentence}" for row in rows if row.odd]
    fine = f"none of {len(rows)} pulls is unlike the others"
    if len(rows) < 3:
        fine = "too few pulls to say which is unlike the others: three tell"
    shapes = [row.shape for row in rows if row.shape is not None]
    alarms, least = ALARMS["shape of all"], LEAST["shape"]
    checks: list[Check | None] = [
        shape(shapes, half_width, alarms=alarms, least=least, end=end),
        check("pull by pull", not odd, "; ".join(odd) if odd else fine),
        _straight(rows),
    ]
    springs = [(r.stiffness, r.vacuum) for r in rows if r.stiffness is not None]
    if len(springs) > 1:
        values = np.array([k for k, _ in springs])
        spread = float(values.std(ddof=1) / values.mean())
        used = f"{len(values)} pulls"
        checks.append(repeats(spread, 0.0, used, "stiffness repeats", "stiffnesses", SOFT))
        over = [vacuum for _, vacuum in springs]
        checks.append(no_trend(values.tolist(), over, "vacuum", "Pa", "stiffness"))
    return tuple(c for c in checks if c is not None)


def _straight(rows: Sequence[SinglePull]) -> Check | None:
    """The rises of all pulls are straight: no seat yields under the first load."""
    bends = [float(np.log1p(row.seating)) for row in rows if row.seating is not None]
    if not bends:
        return None
    soft = _soft(bends) or (
        len(rows) < FEWEST and any(r.verdicts["seating"] == "odd" for r in rows)
    )
    sentence = (
        f"the upper half of the rises is {percent(float(np.mean(bends)))} steeper than the lower"
    )
    why = ": something yields as the load comes on, a grip or a cap in its seat"
    return check("seating", not soft, sentence, f"{why}; the stiffness is not the brake's")


def alike(rows: Sequence[SinglePull]) -> dict[str, float]:
    """{"vacuum": Pa, "speed": m/s} of what all pulls have alike: no trend over it can show."""
    one = {}
    for what in ("vacuum", "speed"):
        values = [getattr(row, what) for row in rows]
        if None not in values and len(grouped(values)) == 1:
            one[what] = float(np.mean(values))
    return one
