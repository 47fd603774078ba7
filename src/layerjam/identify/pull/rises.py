"""Records with two rises: the brake slides freely, is switched on, and the force rises again."""

from dataclasses import dataclass

import numpy as np

from layerjam.identify.stick_slip import Indices, noise_sd
from layerjam.measure.trace import Array

BLOCKS = 100
"""Number of equal parts of the travel to the peak, each with its mean force."""
LEAST_PARTS = 20
"""Minimum number of parts, of two samples each, that can show two rises."""
FEWEST = 3
"""Minimum number of initial samples whose mean is the force at the start."""
FLAT = 0.15
"""Largest slope between the rises, relative to the steepest part before and after."""
LONG = 0.15
"""Smallest fraction of the travel between the two rises."""
RAISED = 0.2
"""Smallest force before the only rise, relative to the peak, that hides the foot of the rise."""
FIRST, SECOND = 0.05, 0.2
"""Smallest fraction of the total force for each rise."""
CLEAR = 6.0
"""Smallest rise, in standard deviations of the mean over the initial samples."""


@dataclass(frozen=True, kw_only=True)
class SecondRise:
    """Second rise of a record: its start [m], and the forces [N] at its start and at its top.

    `index` is the sample at its start, in the loading branch.
    """

    start: float
    index: int
    force_before: float
    force_after: float


@dataclass(frozen=True)
class _Parts:
    """Mean forces [N] of the initial samples and of equal parts of the travel to the peak.

    For each sample up to the peak, `part` is the index of the part to which it belongs; `few` is
    the number of initial samples.
    """

    mean: Array
    part: Indices
    few: int

    @classmethod
    def divide_record(cls, elongation: Array, force: Array) -> "_Parts | None":
        top = int(np.argmax(force))
        travel = float(elongation[top] - elongation[0])
        count = min(BLOCKS, (top + 1) // 2)
        if not travel > 0 or count < LEAST_PARTS:
            return None
        share = (elongation[: top + 1] - elongation[0]) / travel
        part = np.clip((share * count).astype(np.intp), 0, count - 1)
        samples = np.bincount(part, minlength=count)
        if samples.min() < 1:
            return None
        # a steep first rise may end within the first part
        few = max(FEWEST, int(np.median(samples)) // 20)
        mean = np.bincount(part, force[: top + 1], minlength=count) / samples
        return cls(np.r_[float(force[:few].mean()), mean], part, few)


def find_raised_lead(elongation: Array, force: Array) -> float | None:
    """Return the force [N] of a flat section before a single rise, if above a fifth of the peak.

    A stiffness is fitted from that level up, so such a section would be fitted as part of the rise.
    """
    parts = _Parts.divide_record(elongation, force)
    if parts is None:
        return None
    slope = np.diff(parts.mean)
    steep = np.flatnonzero(slope >= FLAT * slope.max())
    lead = int(steep[0]) if len(steep) else 0
    mean = float(parts.mean[:lead].mean()) if lead else 0.0
    return mean if mean > RAISED * parts.mean[-1] else None


def find_second_rise(elongation: Array, force: Array) -> SecondRise | None:
    """Return the second rise of a loading branch, arrays of shape (N,); None if it has only one.

    A friction force has one rise, followed by sliding. Between two rises there is a section that is
    much flatter than the steepest parts before and after it.
    """
    parts = _Parts.divide_record(elongation, force)
    if parts is None:
        return None
    mean, least = parts.mean, CLEAR * noise_sd(force) / parts.few**0.5
    slope = np.diff(mean)
    before = np.maximum.accumulate(slope)
    after = np.maximum.accumulate(slope[::-1])[::-1]
    height = float(mean[-1] - mean[0])
    flat = slope < FLAT * np.minimum(before, after)
    edges = np.flatnonzero(np.diff(np.r_[False, flat, False].astype(int)))
    for begin, end in edges.reshape(-1, 2).tolist():
        first, second = float(mean[begin] - mean[0]), float(mean[-1] - mean[end])
        if (
            end - begin >= LONG * len(slope)
            and first > max(FIRST * height, least)
            and second > max(SECOND * height, least)
        ):
            index = int(np.argmax(parts.part >= end - 1))
            return SecondRise(
                start=float(elongation[index]),
                index=index,
                force_before=float(mean[end]),
                force_after=float(mean[-1]),
            )
    return None
