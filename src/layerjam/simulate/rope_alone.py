"""A mass on the rope alone, without a brake: every number in closed form (ours).

The rope is a spring and a damper side by side that only pull. With d = c/2M and w0^2 = k/M speed,
acceleration and jerk of the mass all obey x'' + 2 d x' + w0^2 x = 0, under-, critically or
overdamped, and (a^2 + 2 d a v + w0^2 v^2) e^(2 d t) does not change: that gives force and heat at
the standstill without what is between.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
SAMPLES = 2000
FADED = 1e-7
"""Part of the weight within which a force that creeps to it counts as there."""
_INSTANT = 1e-9
"""Before this the rope was slack [s]."""


class BareDrop(NamedTuple):
    """What an accelerometer on the mass feels, shape (N,), until the rope is slack or at rest."""

    time: Array
    acceleration: Array
    """Specific force, force over mass [m/s^2]."""
    gravity: float
    """The site's [m/s^2], what a reading in g counts in."""
    travel: Array
    """Displacement of the mass from the taut rope [m]."""
    mass: float
    along: float
    """Gravity along the pull [m/s^2]."""

    @property
    def force(self) -> Array:
        """Of the rope on the mass [N]."""
        return self.mass * self.acceleration

    @property
    def deceleration(self) -> Array:
        """Of the mass [m/s^2]: force over mass less gravity along the pull."""
        return self.acceleration - self.along


class Damped(NamedTuple):
    """Constants of a mass on a spring with a damper beside it."""

    decay: float
    """d [1/s]"""
    square: float
    """w0^2 - d^2 [1/s^2], negative where overdamped."""
    stiff: float
    """w0^2 [1/s^2]"""


def damped(mass: float, spring: float, damping: float) -> Damped:
    """Return the constants of a mass [kg] on a spring [N/m] and a damper [N s/m]."""
    decay, natural = damping / (2 * mass), math.sqrt(spring / mass)
    return Damped(decay, (natural - decay) * (natural + decay), natural**2)


def course(time: Any, start: float, slope: float, of: Damped) -> Any:
    """x(t) from x(0) and x'(0); time [s] may be an array."""
    time = np.asarray(time, float)
    push = slope + of.decay * start
    if of.square > 0:
        swing = math.sqrt(of.square)
        shape = start * np.cos(swing * time) + push * time * np.sinc(swing * time / np.pi)
        return np.exp(-of.decay * time) * shape
    split = math.sqrt(-of.square)
    slow = of.stiff / (of.decay + split)
    fast = np.exp(-2 * split * time)
    rise = time if split == 0 else -np.expm1(-2 * split * time) / (2 * split)
    return np.exp(-slow * time) * (start * (1 + fast) / 2 + push * rise)


def standstill(mass: float, speed: float, spring: float, damping: float, gravity: float) -> float:
    """Time [s] of the first standstill from above zero, infinite where there is none.

    Overdamped there is one only if speed (d - sqrt(d^2 - w0^2)) > g: a slower mass creeps down to
    where its weight hangs and never swings beyond.
    """
    of = damped(mass, spring, damping)
    if speed == 0 and gravity == 0:
        return 0.0
    lean = of.decay * speed - gravity
    if of.square > 0:
        swing = math.sqrt(of.square)
        return math.atan2(speed * swing, lean) / swing
    split = math.sqrt(-of.square)
    excess = speed * of.stiff / (of.decay + split) - gravity
    if excess <= 0:
        return math.inf
    return speed / lean if split == 0 else math.log1p(2 * speed * split / excess) / (2 * split)


def time_of_peak(mass: float, speed: float, of: Damped, gravity: float, stands: float) -> float:
    """Time [s] of a greatest force between start and standstill; 0 where there is none."""
    if of.square > 0:
        swing = math.sqrt(of.square)
        return max(stands - 2 * math.asin(of.decay / math.sqrt(of.stiff)) / swing, 0.0)
    if math.isfinite(stands):
        return 0.0
    split = math.sqrt(-of.square)
    # speed = A e^(-slow t) + B e^(-fast t); the jerk passes zero once where B < 0 < A
    slow = of.stiff / (of.decay + split)
    against = gravity - (of.decay + split) * speed
    if against <= 0:
        return 0.0
    if split == 0:
        return max(2 / of.decay - speed / against, 0.0)
    ratio = math.log(against / (gravity - slow * speed)) / (2 * split)
    return max(ratio + 2 * math.atanh(split / of.decay) / split, 0.0)


def damped_rope_only(
    mass: float, speed: float, spring: float, damping: float, gravity: float
) -> tuple[float, float, float]:
    """Peak force [N], time to the first standstill [s] and heat [J] of a mass on a damped rope.

    The time is infinite where the mass never stands still (`standstill`); then peak and heat are
    those of all the time to come. Mass [kg], speed [m/s], spring [N/m], damping [N s/m], gravity
    along the pull [m/s^2]; all closed.
    """
    of, weight = damped(mass, spring, damping), mass * gravity
    time = standstill(mass, speed, spring, damping, gravity)
    top = time_of_peak(mass, speed, of, gravity, time)
    ends = [damping * speed, float(_force([top], mass, speed, of, gravity)[0])]
    sag = gravity**2 / of.stiff
    if math.isinf(time):
        return max(*ends, weight), time, mass * (speed**2 + sag) / 2
    left = math.exp(-2 * of.decay * time)
    cross = 2 * gravity * of.decay * speed / of.stiff
    held = max(speed**2 + sag - cross, 0.0) * of.stiff
    ends.append(weight + mass * math.sqrt(held * left))
    heat = mass / 2 * ((speed**2 + sag) * -math.expm1(-2 * of.decay * time) + cross * left)
    return max(ends), time, heat


def _force(time: Any, mass: float, speed: float, of: Damped, gravity: float) -> Array:
    """Force of the rope [N] while it is taut."""
    start = gravity - 2 * of.decay * speed
    slope = -2 * of.decay * start - of.stiff * speed
    return np.asarray(mass * (gravity - course(time, start, slope, of)))


def felt(
    mass: float, speed: float, spring: float, damping: float, gravity: float, site: float
) -> BareDrop:
    """The specific force of a bare drop until the rope is slack again or hangs at rest.

    Free fall before counts as 0, bounces after the first are left out. `site` [m/s^2] is what g
    means there.
    """
    of = damped(mass, spring, damping)
    # as long as it takes to be slack, half a swing and the return, or to fade
    slow = of.decay if of.square > 0 else of.stiff / (of.decay + math.sqrt(-of.square))
    fades = math.inf if slow == 0 else -math.log(FADED) / slow
    period = math.inf if of.square <= 0 else 2 * math.pi / math.sqrt(of.square)
    last = min(fades + 4 / math.sqrt(of.stiff), period)
    # dense where the damper answers, even where that is soon over
    fine = np.append(np.linspace(0, 1, SAMPLES)[1:-1], np.geomspace(1e-12, 1, SAMPLES))
    time = np.append(0.0, np.unique(fine) * last)
    force = _force(time, mass, speed, of, gravity)
    below = np.flatnonzero(force[1:] <= 0)
    if len(below):
        at = int(below[0]) + 1
        before = force[at - 1]
        share = before / (before - force[at]) if before > force[at] else 1.0
        slack = time[at - 1] + share * (time[at] - time[at - 1])
        time, force = np.append(time[:at], slack), np.append(force[:at], 0.0)
    keep = np.append(True, np.diff(time) > 0)
    time, force = time[keep], force[keep]
    if force[0] > 0:
        time, force = np.append(-_INSTANT, time), np.append(0.0, force)
    sag = gravity / of.stiff
    travel = sag + course(np.maximum(time, 0.0), -sag, speed, of)
    return BareDrop(time, force / mass, site, travel, mass, gravity)
