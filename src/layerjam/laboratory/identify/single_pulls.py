"""Comparison of each pull with the others: outliers among the pulls, and the quantity that differs.

`factor` is the scale factor of a pull's peak, `slope` its stiffness. `shape` compares the scale
factor after the peak with that of the peak. `vacuum` and `speed` compare the scale factors of the
pulls at one vacuum or speed with the others, and the recorded crosshead speed with the stated one.
`seating` states whether the rise is straight. A verdict is "ok", "odd" or, if too little is known,
"untold".

A single pull with a different friction looks like one with a different vacuum. Only the enclosure
could distinguish them, but its sixth of the force scatters too much.
"""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from layerjam.core.units import show
from layerjam.laboratory.identify.calibration.pull_fit import PullFit
from layerjam.laboratory.identify.curves import ALIKE, Curve, Turn, group_places, number_levels
from layerjam.laboratory.identify.fit_checks import format_percent
from layerjam.laboratory.identify.odd import (
    FEWEST,
    find_outliers,
    find_shifted_group,
    mean_without_outliers,
)
from layerjam.laboratory.measure.trace import Array

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
"""{test: fraction of faultless campaigns that it may reject}; together below 5 %.

The factor has the largest share: a film's friction scatters by a few percent, so a deviation of 15
% can be detected only by a sensitive test. Faults in the other quantities far exceed their scatter.
"""
LEAST: Mapping[str, float] = {
    "factor": 0.02,
    "slope": 0.03,
    "shape": 0.015,
    "vacuum": 0.03,
    "speed": 0.03,
    "seating": 0.05,
}
"""Relative difference up to which a pull is never an outlier, however significant."""
DEVIATION_LIMIT = 0.125
"""Limit of the deviation of a scale factor or stiffness, whatever the scatter of the others: two
and a half times the limit for repeats (`checks.REPEATABLE`)."""
OVERSHOOT = 0.1
"""Largest relative deviation of the curve after the peak from its own peak."""


class SlidingFit(NamedTuple):
    """Fit of the part of a pull after its peak, with sheets and enclosure free.

    `excess` is the relative deviation of the scale factor from that of the peak, `enclosure` the
    factor on the enclosure's force.
    """

    excess: float
    enclosure: float


@dataclass(frozen=True, kw_only=True)
class SinglePull:
    """Results of one pull, in SI units; None if unknown.

    `factor` and `stiffness` are from its peak and its slope. `shape` is the relative deviation of
    the scale factor after the peak from that of the peak. `seating` is the relative excess of the
    slope in the rise's upper half over that in its lower half. `enclosure` is the factor on the
    enclosure's force after the peak. `recorded_speed` is from its time column. At `vacuum_of_peak`
    it would have the others' scale factor. `verdicts` covers `TESTS`.
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
    mounting: int | None = None
    enclosure: float | None = None
    turn: Turn = Turn()

    @property
    def is_outlier(self) -> bool:
        """Return whether any verdict is "odd"."""
        return "odd" in self.verdicts.values()


@dataclass
class _Findings:
    verdicts: list[dict[str, str]]
    sentences: dict[int, list[str]]

    def known_values(
        self, test: str, values: Sequence[float | None], fewest: int = FEWEST
    ) -> tuple[Array, list[int]]:
        """Return the known values and their pulls; mark these "ok" if there are enough."""
        indices = [i for i, value in enumerate(values) if value is not None]
        for i in indices if len(indices) >= fewest else ():
            self.verdicts[i][test] = "ok"
        return np.array([value for value in values if value is not None]), indices

    def add_outlier(self, test: str, pull: int, words: str) -> None:
        """Record that one pull is an outlier in this test."""
        self.verdicts[pull][test] = "odd"
        if words not in self.sentences[pull]:
            self.sentences[pull].append(words)


def make_single_pulls(
    curves: Sequence[Curve],
    fits: Sequence[PullFit | None],
    parts: Sequence["SlidingFit | None"],
    law_factors: Array | None = None,
) -> tuple[SinglePull, ...]:
    """Return one row per curve; `fits` and `parts` are None for curves that have no peak.

    `law_factors` (curves,) are the relative factors of a fitted law of vacuum or speed; scale
    factors are divided by them before they are compared.
    """
    scale_factors = [None if f is None else f.scale_factor for f in fits]
    shapes = [None if part is None else part.excess for part in parts]
    law = np.ones(len(curves)) if law_factors is None else law_factors
    factors = [
        None if f is None else f / float(ratio) for f, ratio in zip(scale_factors, law, strict=True)
    ]
    springs = [c.stiffness if c.straight else None for c in curves]
    seatings = [c.seating for c in curves]
    findings = _Findings([dict.fromkeys(TESTS, "untold") for _ in curves], defaultdict(list))
    typical = float(np.median([f for f in factors if f is not None])) if any(factors) else None
    shifts = _compare_groups(findings, factors, curves)
    _compare_factors(findings, factors, shifts, [c.vacuum for c in curves])
    _compare_pulls(
        findings, "slope", _to_log(springs), "stiffness {} vs. the others", limit=DEVIATION_LIMIT
    )
    _compare_shapes(findings, shapes)
    _compare_speeds(findings, curves)
    _compare_seating(findings, curves)
    return tuple(
        SinglePull(
            file=curve.name,
            vacuum=curve.vacuum,
            vacuum_of_peak=None if not (typical and f) else curve.vacuum * f / typical,
            speed=curve.speed,
            recorded_speed=curve.recorded_speed,
            factor=scale_factors[i],
            stiffness=springs[i],
            shape=shapes[i],
            seating=None if (bend := seatings[i]) is None else float(np.expm1(bend)),
            verdicts=findings.verdicts[i],
            sentence=", ".join(findings.sentences[i]),
            mounting=curve.mounting,
            enclosure=None if (part := parts[i]) is None else part.enclosure,
            turn=curve.turn,
        )
        for i, (curve, f) in enumerate(zip(curves, factors, strict=True))
    )


def _to_log(values: Sequence[float | None]) -> list[float | None]:
    return [None if v is None else float(np.log(v)) for v in values]


def _compare_pulls(
    findings: _Findings,
    test: str,
    pull_values: Sequence[float | None],
    words: str,
    *,
    fewest: int = FEWEST,
    limit: float = float("inf"),
) -> None:
    """Compare one value of each pull with the others; `words` describes its deviation."""
    values, indices = findings.known_values(test, pull_values, fewest)
    out = find_outliers(values, ALARMS[test], LEAST[test], limit)
    for place in out:
        deviation = float(np.expm1(values[place] - mean_without_outliers(values, out)))
        findings.add_outlier(test, indices[place], words.format(format_percent(deviation)))


def _compare_factors(
    findings: _Findings, factors: Sequence[float | None], shifts: Array, vacuums: Sequence[float]
) -> None:
    """Find peaks that differ from the others, with the vacuum that would explain them.

    `shifts` (curves,) are those of groups that are outliers as a whole, not pull by pull.
    """
    logs, indices = findings.known_values("factor", _to_log(factors))
    logs = logs - shifts[indices]
    out = find_outliers(logs, ALARMS["factor"], LEAST["factor"], DEVIATION_LIMIT)
    for place in out:
        deviation = float(np.expm1(logs[place] - mean_without_outliers(logs, out)))
        vacuum = show(vacuums[indices[place]] * (1 + deviation), "Pa", 3)
        words = f"scale factor {format_percent(deviation)} vs. the others, as if at {vacuum}"
        findings.add_outlier("factor", indices[place], words)


def _compare_shapes(findings: _Findings, shapes: Sequence[float | None]) -> None:
    """Find curves whose part after the peak deviates from the others or from their own peak."""
    words = "after the peak {} vs. its own peak, unlike the others"
    logs = [None if s is None else float(np.log1p(max(s, -0.99))) for s in shapes]
    _compare_pulls(findings, "shape", logs, words, fewest=1)
    for place, deviation in enumerate(shapes):
        if deviation is not None and abs(deviation) > OVERSHOOT:
            findings.verdicts[place]["shape"] = "odd"
            if not any(text.startswith("after the peak") for text in findings.sentences[place]):
                findings.add_outlier(
                    "shape", place, f"after the peak {format_percent(deviation)} vs. its own peak"
                )


def _compare_groups(
    findings: _Findings, factors: Sequence[float | None], curves: Sequence[Curve]
) -> Array:
    """Find groups of pulls at one vacuum or speed whose scale factor differs from the others.

    Returns the shift of the logarithm of the factor (curves,), 0 for pulls in no such group.
    """
    shifts = np.zeros(len(curves))
    quantities: tuple[tuple[str, str, Callable[[Curve], float | None]], ...] = (
        ("vacuum", "Pa", lambda c: c.vacuum),
        ("speed", "m/s", lambda c: c.speed),
    )
    for test, unit, read_quantity in quantities:
        pull_quantities = [read_quantity(c) for c in curves]
        log_factors = [
            None if o is None else f for o, f in zip(pull_quantities, _to_log(factors), strict=True)
        ]
        if len(set(number_levels([o for o in pull_quantities if o is not None]))) < 2:
            continue
        values, indices = findings.known_values(test, log_factors)
        levels_of_pulls = [v for i in indices if (v := pull_quantities[i]) is not None]
        groups = group_places(number_levels(levels_of_pulls))
        result = find_shifted_group(values, groups, ALARMS[test], LEAST[test])
        if result is None:
            continue
        group, shift = result
        level = show(float(np.mean([levels_of_pulls[i] for i in group])), unit, 3)
        alternative = " (or the others are wrong)" if len(groups) == 2 else ""
        change = format_percent(float(np.expm1(shift)))
        words = f"at {level}, scale factors differ by {change} from the others{alternative}"
        for place in group:
            findings.add_outlier(test, indices[place], words)
            shifts[indices[place]] += shift
    return shifts


def _compare_speeds(findings: _Findings, curves: Sequence[Curve]) -> None:
    """Find pulls whose recorded speed differs from the stated speed."""
    for place, curve in enumerate(curves):
        stated_speed, recorded_speed = curve.speed, curve.recorded_speed
        if stated_speed is None or recorded_speed is None:
            continue
        if abs(recorded_speed / stated_speed - 1) > ALIKE:
            stated_text, moved_text = (show(v, "m/s", 3) for v in (stated_speed, recorded_speed))
            words = f"moved at {moved_text}; the stated speed is {stated_text}"
            findings.add_outlier("speed", place, words)
        elif findings.verdicts[place]["speed"] == "untold":
            findings.verdicts[place]["speed"] = "ok"


def _compare_seating(findings: _Findings, curves: Sequence[Curve]) -> None:
    bends, indices = findings.known_values("seating", [c.seating for c in curves], 1)
    if not indices:
        return
    has_soft_seat = is_seat_soft(bends.tolist())
    # weight each by its own error: at low vacuum the rise is short and its bend uncertain
    errors = np.hypot([curves[i].seating_se for i in indices], LEAST["seating"] / 4)
    middle = float(np.average(bends, weights=errors**-2))
    out = find_outliers((bends - middle) / errors, ALARMS["seating"], 0.0)
    for place, (bend, error) in enumerate(zip(bends, errors, strict=True)):
        is_outlier = place in out and abs(bend - middle) > LEAST["seating"]
        is_bent = len(bends) < FEWEST and bend - 4 * error > LEAST["seating"]
        if is_outlier or is_bent or has_soft_seat:
            words = f"its rise is {format_percent(float(np.expm1(bend)))} steeper in its upper half"
            findings.add_outlier("seating", indices[place], words)


def is_seat_soft(bends: Sequence[float]) -> bool:
    """Return whether the rises bend, on average over the pulls, as on a yielding seat."""
    from scipy.special import stdtrit

    values = np.asarray(bends)
    mean, count = float(values.mean()), len(values)
    if count < 2 or mean <= LEAST["seating"]:
        return False
    error = float(values.std(ddof=1)) / count**0.5
    return mean > float(stdtrit(count - 1, 1 - ALARMS["seating of all"])) * error


def find_common_conditions(rows: Sequence[SinglePull]) -> dict[str, float]:
    """Return {"vacuum": Pa, "speed": m/s}, the conditions common to all pulls."""
    common = {}
    for quantity in ("vacuum", "speed"):
        values = [getattr(row, quantity) for row in rows]
        if None not in values and len(set(number_levels(values))) == 1:
            common[quantity] = float(np.mean(values))
    return common
