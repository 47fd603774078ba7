"""Measured pulls, prepared for a joint fit."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from layerjam.core.errors import FitError, count_text
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.laboratory.identify.pull.features import LINEAR, PullFeatures, select_loading
from layerjam.laboratory.measure.trace import Trace

ALIKE = 0.03
"""Relative gap between sorted vacuums or speeds below which they count as one condition."""
SHORTEST = 50
"""Minimum number of samples of a curve above a fifth of its maximum force."""


class Turn(NamedTuple):
    """Statements about the place of a pull in a campaign; None if not stated.

    `start` [s since 1970] is the start of the test, `repeat` and `mounting` are numbers.
    """

    start: float | None = None
    repeat: int | None = None
    mounting: int | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve(PullFeatures):
    """One pull with its features and conditions, in SI units.

    `speed` is None if neither the file nor its sidecar states it, `recorded_speed` if the file has
    no time. `repeat` is the pull's number among those at the same vacuum and speed.
    """

    vacuum: float
    speed: float | None = None
    repeat: int | None = None
    specimen: str = ""
    recorded_speed: float | None = None
    mounting: int | None = None
    """Number of the mounting, from the pull's sidecar."""
    limits: Mapping[str, float | None] = field(default_factory=dict)
    """Error limits of the "load_cell" (relative) and the "gauge" [Pa], from the sidecar."""
    synthetic: bool = False
    """Whether a program generated the file."""
    turn: Turn = Turn()
    """Place of the pull in the campaign, as far as it is stated."""

    @property
    def name(self) -> str:
        """File name without its folder, with the specimen if the file has several."""
        name = Path(self.path).name
        return f"{name}, specimen {self.specimen}" if self.specimen else name

    @property
    def pull(self) -> PullFeatures:
        """The curve itself, whose features were a record of their own in earlier versions."""
        return self


def crosshead_speed(trace: Trace) -> float | None:
    """Return the crosshead speed [m/s], stated or else recorded; None if unknown."""
    return recorded_speed(trace) if trace.facts.speed is None else trace.facts.speed


def recorded_speed(trace: Trace) -> float | None:
    """Return the crosshead speed [m/s] over the loading branch; None if the record has no time.

    Only the middle half of the branch is used, to exclude acceleration and a return.
    """
    if trace.time is None:
        return None
    end = len(select_loading(trace)[0])
    first, last = end // 4, max(3 * end // 4, end // 4 + 1)
    if last >= end or not trace.time[last] > trace.time[first]:
        return None
    rate = (trace.elongation[last] - trace.elongation[first]) / (
        trace.time[last] - trace.time[first]
    )
    return float(rate) if rate > 0 else None


def make_curve(pull: PullFeatures, vacuum: float, trace: Trace | None = None) -> Curve:
    """Return the curve of a pull at a vacuum [Pa], with speed and specimen from its `trace`."""
    conditions: dict[str, Any] = {}
    if trace is not None:
        conditions = {
            "speed": crosshead_speed(trace),
            "specimen": trace.specimen,
            "recorded_speed": recorded_speed(trace),
            "mounting": trace.facts.mounting_number,
            "limits": trace.facts.instrument_limits,
            "synthetic": trace.synthetic,
            "turn": Turn(trace.start, trace.facts.repeat, trace.facts.mounting),
        }
    features = {f.name: getattr(pull, f.name) for f in fields(PullFeatures)}
    return Curve(**features, vacuum=vacuum, **conditions)


def make_curves(pulls: Iterable[tuple[Trace, PullFeatures, float]]) -> tuple[Curve, ...]:
    """Return curves from traces, features and vacuums [Pa]; repeats are numbered in this order."""
    return number_repeats([make_curve(pull, vacuum, trace) for trace, pull, vacuum in pulls])


def group_conditions(curves: Sequence[Curve]) -> list[tuple[int, ...]]:
    """Return the indices of curves under the same conditions: vacuum and speed within `ALIKE`."""
    return group_places(number_conditions(curves))


def number_conditions(pulls: Sequence[Any]) -> list[int]:
    """Return the number of each pull's `vacuum` and `speed`, counted as they first appear."""
    vacuums = number_levels([pull.vacuum for pull in pulls])
    speeds = number_levels([pull.speed or 0.0 for pull in pulls])
    numbers: dict[tuple[int, int], int] = {}
    return [numbers.setdefault(key, len(numbers)) for key in zip(vacuums, speeds, strict=True)]


def group_places(numbers: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the indices of equal numbers, in the order in which these first appear."""
    members: dict[int, list[int]] = {}
    for place, number in enumerate(numbers):
        members.setdefault(number, []).append(place)
    return [tuple(places) for places in members.values()]


def number_levels(values: Sequence[float]) -> list[int]:
    """Return the index of each value's level; a gap of more than `ALIKE` begins a new level."""
    order = np.argsort(values)
    level, last, out = 0, None, [0] * len(values)
    for place in order:
        value = values[place]
        if last is not None and value > last * (1 + ALIKE) + 1e-12:
            level += 1
        out[place], last = level, value
    return out


def describe_condition(curve: Curve) -> str:
    """Return the vacuum and speed as text, such as 94.5 kPa, 13 mm/s."""
    words = show(curve.vacuum, "Pa")
    return words if curve.speed is None else f"{words}, {show(curve.speed, 'm/s')}"


def number_repeats(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """Return the curves with `repeat` counted from 1 within each condition."""
    counts = {place: n for group in group_conditions(curves) for n, place in enumerate(group, 1)}
    return tuple(evolve(curve, repeat=counts[i]) for i, curve in enumerate(curves))


def select_fitted_part(curve: Curve) -> slice:
    """Return the samples that a whole-curve fit uses: from a fifth of the maximum force onwards.

    Below that, the grips settle and slack is taken up, which the law does not describe.
    """
    height = curve.peak_force
    rise = curve.force[: int(np.argmax(curve.force)) + 1]
    indices_below = np.flatnonzero(rise <= LINEAR[0] * height)
    return slice(int(indices_below[-1]) + 1 if len(indices_below) else 0, len(curve.force))


def require_usable_pull(pull: PullFeatures, vacuum: float) -> None:
    """Raise FitError if a pull cannot be used in a fit to whole curves."""
    if vacuum <= 0:
        raise FitError.of(pull.path, f"a vacuum of {show(vacuum, 'Pa')} jams no sheet")
    sample_count = int((pull.force > LINEAR[0] * pull.peak_force).sum())
    if sample_count < SHORTEST:
        raise FitError.of(
            pull.path,
            f"has {count_text(sample_count, 'sample')} above {LINEAR[0]:.0%} of its maximum force; "
            f"at least {SHORTEST} are needed to fit its curve",
        )
