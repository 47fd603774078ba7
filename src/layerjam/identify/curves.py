"""Measured pulls as a fit over many of them sees them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from layerjam.errors import FitError
from layerjam.identify.pull.features import LINEAR, PullFeatures
from layerjam.measure.trace import Trace
from layerjam.units import show

ALIKE = 0.03
"""Part by which neighbouring vacuums or speeds of one condition may differ."""
SHORTEST = 50
"""Samples a curve needs from a fifth of its greatest force on."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """The loading branch of one pull, SI units; its crosshead's zero is where the rise begins.

    `speed` is None where neither the file nor its sidecar tells it, `recorded_speed` where the file
    has no time. `repeat` numbers the pull among those at the same vacuum and speed; `pull` holds
    the features it was reduced to.
    """

    elongation: np.ndarray
    force: np.ndarray
    vacuum: float
    speed: float | None
    repeat: int | None
    path: str
    pull: PullFeatures
    specimen: str = ""
    recorded_speed: float | None = None
    mounting: int | None = None
    """Number of the mounting that it was pulled in, as its sidecar states it."""
    synthetic: bool = False
    """Whether a program wrote the file."""

    @property
    def name(self) -> str:
        """The file's name without its folder, and the specimen where the file holds several."""
        name = Path(self.path).name
        return f"{name}, specimen {self.specimen}" if self.specimen else name


def speed_of(trace: Trace) -> float | None:
    """Crosshead speed [m/s]: as stated, else as recorded; None if unknown."""
    return recorded_speed(trace) if trace.facts.speed is None else trace.facts.speed


def recorded_speed(trace: Trace) -> float | None:
    """Crosshead speed [m/s] from the time of the loading branch; None where there is no time.

    The middle half of the branch counts, so that acceleration and a return do not.
    """
    if trace.time is None:
        return None
    end = int(np.argmax(trace.elongation)) + 1
    first, last = end // 4, max(3 * end // 4, end // 4 + 1)
    if last >= end or not trace.time[last] > trace.time[first]:
        return None
    rate = (trace.elongation[last] - trace.elongation[first]) / (
        trace.time[last] - trace.time[first]
    )
    return float(rate) if rate > 0 else None


def curve_of(pull: PullFeatures, vacuum: float, trace: Trace | None = None) -> Curve:
    """The curve of a pull at a vacuum [Pa]; its `trace` tells speed and specimen."""
    return Curve(
        elongation=pull.elongation,
        force=pull.force,
        vacuum=vacuum,
        speed=None if trace is None else speed_of(trace),
        repeat=None,
        path=pull.path,
        pull=pull,
        specimen="" if trace is None else trace.specimen,
        recorded_speed=None if trace is None else recorded_speed(trace),
        mounting=None if trace is None else trace.facts.mounted,
        synthetic=trace is not None and trace.synthetic,
    )


def curves_of(pulls: Iterable[tuple[Trace, PullFeatures, float]]) -> tuple[Curve, ...]:
    """Curves from traces, their features and their vacuums [Pa], repeats numbered in this order."""
    return numbered([curve_of(pull, vacuum, trace) for trace, pull, vacuum in pulls])


def conditions(curves: Sequence[Curve]) -> list[tuple[int, ...]]:
    """Which curves (their places) were pulled alike: vacuum and speed within `ALIKE` each."""
    vacuums = levels([c.vacuum for c in curves])
    speeds = levels([c.speed or 0.0 for c in curves])
    members: dict[tuple[int, int], list[int]] = {}
    for place, key in enumerate(zip(vacuums, speeds, strict=True)):
        members.setdefault(key, []).append(place)
    return [tuple(m) for m in members.values()]


def levels(values: Sequence[float]) -> list[int]:
    """Number of the level each value belongs to; a gap of more than `ALIKE` begins one."""
    order = np.argsort(values)
    level, last, out = 0, None, [0] * len(values)
    for place in order:
        value = values[place]
        if last is not None and value > last * (1 + ALIKE) + 1e-12:
            level += 1
        out[place], last = level, value
    return out


def condition_words(curve: Curve) -> str:
    """Vacuum and speed, such as 94.5 kPa, 13 mm/s."""
    words = show(curve.vacuum, "Pa")
    return words if curve.speed is None else f"{words}, {show(curve.speed, 'm/s')}"


def numbered(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """The curves with `repeat` counted from 1 within each condition."""
    counts = {place: n for group in conditions(curves) for n, place in enumerate(group, 1)}
    return tuple(replace(curve, repeat=counts[i]) for i, curve in enumerate(curves))


def fitted_part(curve: Curve) -> slice:
    """The samples a fit of the whole curve uses: from a fifth of the greatest force on.

    Below, grips settle and slack is taken up, which no brake's law describes.
    """
    height = curve.pull.peak_force
    rise = curve.force[: int(np.argmax(curve.force)) + 1]
    below = np.flatnonzero(rise <= LINEAR[0] * height)
    return slice(int(below[-1]) + 1 if len(below) else 0, len(curve.force))


def usable(pull: PullFeatures, vacuum: float) -> None:
    """Raise FitError for a pull that least squares over whole curves cannot use."""
    if vacuum <= 0:
        raise FitError.of(pull.path, f"at {show(vacuum, 'Pa')} of vacuum no sheet is jammed")
    above = int((pull.force > LINEAR[0] * pull.peak_force).sum())
    if above < SHORTEST:
        raise FitError.of(
            pull.path,
            f"has {above} samples above {LINEAR[0]:.0%} of its greatest force; at "
            f"least {SHORTEST} are needed to fit its curve",
        )
