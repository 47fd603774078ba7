"""Breakaway of a sled: first maximum, start of sliding and effect of inertia."""

from dataclasses import dataclass

import numpy as np

from layerjam.laboratory.identify.statistics import fit_line
from layerjam.laboratory.measure.noise import noise_sd, running_mean
from layerjam.laboratory.measure.trace import Array

FALL = 0.02
"""Drop in force that identifies the maximum before it, relative to the sliding force."""
STANDS_OUT = 6.0
"""The same drop, in standard deviations of the noise."""
LEAST = 0.2
"""Smallest first maximum, relative to the sliding force; smaller ones are slack being taken up."""
RISE = (0.2, 0.8)
"""Range of force, relative to the first maximum, in which the pull's stiffness is fitted."""


@dataclass(frozen=True, kw_only=True)
class Breakaway:
    """The first maximum of a friction record and the start of sliding, in SI units.

    `index` and `sliding` are indices. `distinct` is False if sliding begins without a peak; `force`
    is then the sliding force at the end of the rise. `noise` is that of one sample [N].
    """

    index: int
    sliding: int
    force: float
    distinct: bool
    noise: float


@dataclass(frozen=True, kw_only=True)
class Inertia:
    """Force due to the acceleration of the sled, in SI units.

    If a spring of stiffness k accelerates a sled of mass m from rest to the speed V, the force
    overshoots the friction by at most V sqrt(k m). This is `bound` [N], the limit of the error of
    the static force. During breakaway the force differs from friction by m a. The `acceleration` a
    [m/s^2] is from the record; it is None if the force drops too fast for the sampling rate.
    """

    stiffness: float
    bound: float
    acceleration: float | None


def find_breakaway(travel: Array, force: Array) -> Breakaway:
    """Find the breakaway in travel [m] and force [N], arrays of shape (N,).

    It is the first maximum from which the force drops by six standard deviations of the noise and
    by 2 % of the sliding force, without a higher value in between.
    """
    noise = noise_sd(force)
    level = float(np.median(force[travel >= 0.3 * travel.max()]))
    # a single outlier is not a maximum; a mean over three samples preserves a sharp peak
    smooth = running_mean(force, 3) if noise > 0.002 * abs(level) else force
    is_above = smooth >= LEAST * level
    begin = int(np.argmax(is_above))
    highest = np.maximum.accumulate(smooth[begin:])
    drop = highest - smooth[begin:] > max(STANDS_OUT * noise, FALL * abs(level))
    if not drop.any():
        return _find_bend(force, level, noise)
    fall_end = begin + int(np.argmax(drop))
    index = begin + int(np.argmax(force[begin : fall_end + 1]))
    return Breakaway(
        index=index,
        sliding=_find_first_sliding_sample(travel, smooth, index, noise),
        force=float(force[index]),
        distinct=True,
        noise=noise,
    )


def _find_bend(force: Array, level: float, noise: float) -> Breakaway:
    """Return the breakaway of a record in which sliding begins without a first maximum."""
    sliding = np.flatnonzero(force >= level - 2 * noise)
    index = int(sliding[0]) if len(sliding) else len(force) - 1
    return Breakaway(index=index, sliding=index, force=level, distinct=False, noise=noise)


def _find_first_sliding_sample(travel: Array, smooth: Array, index: int, noise: float) -> int:
    """Return the index of the first sample after the maximum at the level of the later force."""
    travel_after = travel - travel[index]
    later = (travel_after >= 2e-3) & (travel_after <= 30e-3)
    if later.sum() < 5:
        later = travel_after > 0
    if not later.any():
        return index
    level = float(np.median(smooth[later]))
    down = np.flatnonzero(smooth[index:] <= level + max(3 * noise, 0.005 * abs(level)))
    return index + (int(down[0]) if len(down) else 0)


def inertia_effect(
    travel: Array, force: Array, time: Array | None, breakaway: Breakaway, mass: float, speed: float
) -> Inertia | None:
    """Return the effect of the sled's inertia; None if the record has no rise.

    `mass` [kg] is that of the sled, `speed` [m/s] that of the crosshead.
    """
    rise = force[: breakaway.index + 1]
    is_below = rise <= RISE[0] * breakaway.force
    start = int(np.flatnonzero(is_below)[-1]) if is_below.any() else 0
    past = np.flatnonzero(rise[start:] >= RISE[1] * breakaway.force)
    stop = start + int(past[0]) if len(past) else breakaway.index
    part = slice(start, stop + 1)
    line = fit_line(travel[part], force[part]) if stop - start >= 3 else None
    if line is None or line.slope <= 0:
        return None
    return Inertia(
        stiffness=line.slope,
        bound=speed * (line.slope * mass) ** 0.5,
        acceleration=_estimate_acceleration(force, time, breakaway, line.slope),
    )


def _estimate_acceleration(
    force: Array, time: Array | None, breakaway: Breakaway, stiffness: float
) -> float | None:
    """Return the sled's mean acceleration from the maximum to the steepest drop [m/s^2], or None.

    The sled is faster than the crosshead by -F'/k. The drop must have at least four samples.
    """
    if time is None or not breakaway.distinct:
        return None
    fall = force[
        breakaway.index : breakaway.index + 1 + 4 * max(breakaway.sliding - breakaway.index, 1)
    ]
    trough = int(np.argmin(fall))
    clock = time[breakaway.index : breakaway.index + trough + 1]
    if trough < 4 or not (np.diff(clock) > 0).all():
        return None
    rate = np.gradient(fall[: trough + 1], clock)
    steepest = int(np.argmin(rate))
    if steepest < 2 or fall[0] - fall[trough] < 10 * breakaway.noise:
        return None
    return float(-rate[steepest] / stiffness / (clock[steepest] - clock[0]))
