"""Mass on the rope alone, without a brake, in closed form (derived here).

The rope is a spring and a damper in parallel that only pull. With d = c/2M and w0^2 = k/M, the
speed, acceleration and jerk of the mass all obey x'' + 2 d x' + w0^2 x = 0, whether under-,
critically or overdamped. The quantity (a^2 + 2 d a v + w0^2 v^2) e^(2 d t) is constant and directly
gives force and heat at the standstill.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.core.brief import brief

Array = np.ndarray[Any, np.dtype[np.float64]]
SAMPLES = 2000
FADED = 1e-7
"""Relative difference below which a creeping force counts as equal to the weight."""
_INSTANT = 1e-9
"""Time before the rope is taut at which the record starts [s]."""


@brief
class BareDrop(NamedTuple):
    """Specific force of the mass, shape (N,), until the rope is slack or at rest."""

    time: Array
    acceleration: Array
    """Specific force: force per mass [m/s^2]."""
    gravity: float
    """Gravity of the site [m/s^2], the unit of a reading in g."""
    displacement: Array
    """Displacement of the mass since the rope became taut [m]."""
    mass: float
    along: float
    """Gravity along the pull [m/s^2]."""

    @property
    def travel(self) -> Array:
        """Former name of `displacement`."""
        return self.displacement

    @property
    def force(self) -> Array:
        """Return the force of the rope on the mass [N]."""
        return self.mass * self.acceleration

    @property
    def deceleration(self) -> Array:
        """Return the deceleration [m/s^2]: force per mass minus gravity along the pull."""
        return self.acceleration - self.along


class Oscillator(NamedTuple):
    """Constants of a mass on a spring and a damper in parallel."""

    decay: float
    """d [1/s]"""
    square: float
    """w0^2 - d^2 [1/s^2], negative if overdamped."""
    stiff: float
    """w0^2 [1/s^2]"""


def make_oscillator(mass: float, spring: float, damping: float) -> Oscillator:
    """Return the constants of a mass [kg] on a spring [N/m] and a damper [N s/m]."""
    decay, natural = damping / (2 * mass), math.sqrt(spring / mass)
    return Oscillator(decay, (natural - decay) * (natural + decay), natural**2)


def displacement(time: Any, start: float, slope: float, osc: Oscillator) -> Any:
    """Return x(t) from x(0) and x'(0); time [s] may be an array."""
    time = np.asarray(time, float)
    push = slope + osc.decay * start
    if osc.square > 0:
        swing = math.sqrt(osc.square)
        shape = start * np.cos(swing * time) + push * time * np.sinc(swing * time / np.pi)
        return np.exp(-osc.decay * time) * shape
    split = math.sqrt(-osc.square)
    slow_rate = osc.stiff / (osc.decay + split)
    fast_decay = np.exp(-2 * split * time)
    rise = time if split == 0 else -np.expm1(-2 * split * time) / (2 * split)
    return np.exp(-slow_rate * time) * (start * (1 + fast_decay) / 2 + push * rise)


def standstill_time(
    mass: float, speed: float, spring: float, damping: float, gravity: float
) -> float:
    """Return the time [s] at which the speed first falls to zero; infinite if it never does.

    An overdamped mass stops only if speed (d - sqrt(d^2 - w0^2)) > g. A slower one creeps down to
    its equilibrium and never moves beyond it.
    """
    osc = make_oscillator(mass, spring, damping)
    if speed == 0 and gravity == 0:
        return 0.0
    lean = osc.decay * speed - gravity
    if osc.square > 0:
        swing = math.sqrt(osc.square)
        return math.atan2(speed * swing, lean) / swing
    split = math.sqrt(-osc.square)
    excess = speed * osc.stiff / (osc.decay + split) - gravity
    if excess <= 0:
        return math.inf
    return speed / lean if split == 0 else math.log1p(2 * speed * split / excess) / (2 * split)


def peak_time(mass: float, speed: float, osc: Oscillator, gravity: float, end: float) -> float:
    """Return the time [s] of the largest force between start and standstill, or 0."""
    if osc.square > 0:
        swing = math.sqrt(osc.square)
        return max(end - 2 * math.asin(osc.decay / math.sqrt(osc.stiff)) / swing, 0.0)
    if math.isfinite(end):
        return 0.0
    split = math.sqrt(-osc.square)
    # speed = A e^(-slow t) + B e^(-fast t); the jerk crosses zero once if B < 0 < A
    slow_rate = osc.stiff / (osc.decay + split)
    margin = gravity - (osc.decay + split) * speed
    if margin <= 0:
        return 0.0
    if split == 0:
        return max(2 / osc.decay - speed / margin, 0.0)
    ratio = math.log(margin / (gravity - slow_rate * speed)) / (2 * split)
    return max(ratio + 2 * math.atanh(split / osc.decay) / split, 0.0)


def simulate_damped_rope(
    mass: float, speed: float, spring: float, damping: float, gravity: float
) -> tuple[float, float, float]:
    """Return peak force [N], time of the first standstill [s] and heat [J] on a damped rope.

    The time is infinite if the mass never comes to a standstill (see `standstill_time`); peak and
    heat are then those at infinite time. Mass [kg], speed [m/s], spring [N/m], damping [N s/m],
    gravity along the pull [m/s^2]; all in closed form.
    """
    osc, weight = make_oscillator(mass, spring, damping), mass * gravity
    time = standstill_time(mass, speed, spring, damping, gravity)
    top = peak_time(mass, speed, osc, gravity, time)
    ends = [damping * speed, float(_rope_force([top], mass, speed, osc, gravity)[0])]
    sag = gravity**2 / osc.stiff
    if math.isinf(time):
        return max(*ends, weight), time, mass * (speed**2 + sag) / 2
    decay = math.exp(-2 * osc.decay * time)
    cross = 2 * gravity * osc.decay * speed / osc.stiff
    initial = max(speed**2 + sag - cross, 0.0) * osc.stiff
    ends.append(weight + mass * math.sqrt(initial * decay))
    heat = mass / 2 * ((speed**2 + sag) * -math.expm1(-2 * osc.decay * time) + cross * decay)
    return max(ends), time, heat


def _rope_force(time: Any, mass: float, speed: float, osc: Oscillator, gravity: float) -> Array:
    start = gravity - 2 * osc.decay * speed
    slope = -2 * osc.decay * start - osc.stiff * speed
    return np.asarray(mass * (gravity - displacement(time, start, slope, osc)))


def simulate_bare_drop(
    mass: float, speed: float, spring: float, damping: float, gravity: float, site: float
) -> BareDrop:
    """Return the specific force of a bare drop until the rope is slack or hangs at rest.

    The reading is 0 in the free fall before; later bounces are omitted. `site` [m/s^2] is the
    gravity for readings in g.
    """
    osc = make_oscillator(mass, spring, damping)
    # long enough for the rope to become slack (half a swing and the return) or the motion to fade
    slow_rate = osc.decay if osc.square > 0 else osc.stiff / (osc.decay + math.sqrt(-osc.square))
    fades = math.inf if slow_rate == 0 else -math.log(FADED) / slow_rate
    period = math.inf if osc.square <= 0 else 2 * math.pi / math.sqrt(osc.square)
    last = min(fades + 4 / math.sqrt(osc.stiff), period)
    # sample densely within the damper's response time, even if it is short
    fractions = np.append(np.linspace(0, 1, SAMPLES)[1:-1], np.geomspace(1e-12, 1, SAMPLES))
    time = np.append(0.0, np.unique(fractions) * last)
    force = _rope_force(time, mass, speed, osc, gravity)
    slack_indices = np.flatnonzero(force[1:] <= 0)
    if len(slack_indices):
        index = int(slack_indices[0]) + 1
        force_before = force[index - 1]
        share = force_before / (force_before - force[index]) if force_before > force[index] else 1.0
        slack = time[index - 1] + share * (time[index] - time[index - 1])
        time, force = np.append(time[:index], slack), np.append(force[:index], 0.0)
    keep = np.append(True, np.diff(time) > 0)
    time, force = time[keep], force[keep]
    if force[0] > 0:
        time, force = np.append(-_INSTANT, time), np.append(0.0, force)
    sag = gravity / osc.stiff
    drop = sag + displacement(np.maximum(time, 0.0), -sag, speed, osc)
    return BareDrop(time, force / mass, site, drop, mass, gravity)


damped_rope_only = simulate_damped_rope
