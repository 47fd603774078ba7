"""Where a sled breaks away: first maximum, begin of sliding, and what its inertia adds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from layerjam.identify.stick_slip import noise_of, running_mean
from layerjam.identify.straight import straight_line
from layerjam.measure.trace import Array

FALL = 0.02
"""Fall after a maximum that makes it one, as a part of the sliding force."""
STANDS_OUT = 6.0
"""The same in standard deviations of the noise."""
LEAST = 0.2
"""A first maximum is at least this part of the sliding force; below are wiggles in the slack."""
RISE = (0.2, 0.8)
"""Part of the first maximum over which the stiffness of the pull is taken."""


@dataclass(frozen=True, kw_only=True)
class Breakaway:
    """The first maximum of a friction record and where sliding is under way, SI units.

    `at` and `sliding` are indices. `distinct` is False where the force runs into sliding without
    a peak; `force` is then the sliding force where the rise ends. `noise` is one sample's [N].
    """

    at: int
    sliding: int
    force: float
    distinct: bool
    noise: float


@dataclass(frozen=True, kw_only=True)
class Inertia:
    """What accelerating the sled adds to the force it is pulled with, SI units.

    A sled of mass m taken from rest to the speed V by a spring k overshoots the friction by at
    most V sqrt(k m): `most` [N], the bound on the error of the static force. While it breaks away
    the force differs from friction by m a; `acceleration` a [m/s^2] is the record's,
    None where the fall is too quick for the sampling.
    """

    stiffness: float
    most: float
    acceleration: float | None


def find_breakaway(travel: Array, force: Array) -> Breakaway:
    """The breakaway of a record, arrays of shape (N,): travel [m], force [N].

    The first maximum is the first one the force falls from by six standard deviations of the
    noise and by 2 % of the sliding force, without rising beyond it in between.
    """
    noise = noise_of(force)
    level = float(np.median(force[travel >= 0.3 * travel.max()]))
    # one wild sample is no maximum; a mean over three leaves a sharp peak where it is
    smooth = running_mean(force, 3) if noise > 0.002 * abs(level) else force
    above = smooth >= LEAST * level
    begin = int(np.argmax(above))
    highest = np.maximum.accumulate(smooth[begin:])
    drop = highest - smooth[begin:] > max(STANDS_OUT * noise, FALL * abs(level))
    if not drop.any():
        return _without_peak(force, level, noise)
    fallen = begin + int(np.argmax(drop))
    at = begin + int(np.argmax(force[begin : fallen + 1]))
    return Breakaway(
        at=at,
        sliding=_under_way(travel, smooth, at, noise),
        force=float(force[at]),
        distinct=True,
        noise=noise,
    )


def _without_peak(force: Array, level: float, noise: float) -> Breakaway:
    """A force that bends into sliding: there is no first maximum."""
    reached = np.flatnonzero(force >= level - 2 * noise)
    at = int(reached[0]) if len(reached) else len(force) - 1
    return Breakaway(at=at, sliding=at, force=level, distinct=False, noise=noise)


def _under_way(travel: Array, smooth: Array, at: int, noise: float) -> int:
    """First sample after the maximum where the force has come down to what follows."""
    after = travel - travel[at]
    later = (after >= 2e-3) & (after <= 30e-3)
    if later.sum() < 5:
        later = after > 0
    if not later.any():
        return at
    level = float(np.median(smooth[later]))
    down = np.flatnonzero(smooth[at:] <= level + max(3 * noise, 0.005 * abs(level)))
    return at + (int(down[0]) if len(down) else 0)


def inertia_of(
    travel: Array, force: Array, time: Array | None, found: Breakaway, mass: float, speed: float
) -> Inertia | None:
    """What the sled's inertia may add; None where the record shows no rise to tell k from.

    `mass` [kg] of the sled, `speed` [m/s] of the crosshead.
    """
    rise = force[: found.at + 1]
    below = rise <= RISE[0] * found.force
    start = int(np.flatnonzero(below)[-1]) if below.any() else 0
    past = np.flatnonzero(rise[start:] >= RISE[1] * found.force)
    stop = start + int(past[0]) if len(past) else found.at
    part = slice(start, stop + 1)
    line = straight_line(travel[part], force[part]) if stop - start >= 3 else None
    if line is None or line.slope <= 0:
        return None
    return Inertia(
        stiffness=line.slope,
        most=speed * (line.slope * mass) ** 0.5,
        acceleration=_acceleration(force, time, found, line.slope),
    )


def _acceleration(
    force: Array, time: Array | None, found: Breakaway, stiffness: float
) -> float | None:
    """Mean acceleration of the sled from the maximum to the steepest fall [m/s^2].

    The sled gains on the crosshead by -F'/k. None where the fall takes fewer than four samples.
    """
    if time is None or not found.distinct:
        return None
    fall = force[found.at : found.at + 1 + 4 * max(found.sliding - found.at, 1)]
    least = int(np.argmin(fall))
    clock = time[found.at : found.at + least + 1]
    if least < 4 or not (np.diff(clock) > 0).all():
        return None
    rate = np.gradient(fall[: least + 1], clock)
    steepest = int(np.argmin(rate))
    if steepest < 2 or fall[0] - fall[least] < 10 * found.noise:
        return None
    return float(-rate[steepest] / stiffness / (clock[steepest] - clock[0]))
