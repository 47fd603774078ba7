"""One step of a mass that slides on a spring: force laws, motion, and changes of state.

Friction is R(x, v) = (level - fall x)(1 + rise s(v) + viscous v) + base + enclosure(x), with s the
fraction of the static excess left at speed v; s = 1 gives the bound at rest. Spring and damper are
parallel and only pull.
"""

from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.enclosure import EnclosureLaw
from layerjam.brake.mechanics.roots import rising_zero
from layerjam.brake.mechanics.speed_effects import brake_growth
from layerjam.brake.mechanics.stick_slip.laws import static_fraction

STUCK, TAUT, SLACK = 0, 1, 2
"""States of the mass and its spring."""

_A = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
_C = (0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1)
_B = np.array([35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0])
_B4 = np.array([5179 / 57600, 0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40])


class Slide(NamedTuple):
    """A pulled mass; every entry is a number, or an array for a batch."""

    mass: Any
    """Mass [kg]."""
    spring: Any
    """Stiffness of the spring [N/m]."""
    damping: Any
    """Damping parallel to the spring [N s/m]."""
    speed: Any
    """Speed of the crosshead until `ramp` [m/s], then zero."""
    ramp: Any
    """Time at which the crosshead stops [s]."""
    end: Any
    """End of the run [s]."""
    step: Any
    """Longest step [s]; infinite for no limit."""
    level: Any
    """Kinetic friction of the sheets at zero slip [N]."""
    fall: Any
    """Decrease of the kinetic friction per unit of slip [N/m]."""
    rise: Any
    """(mu_s - mu_k)/mu_k."""
    stribeck: Any
    """v_s [m/s]; 0 means that the static excess vanishes immediately."""
    exponent: Any
    viscous: Any
    """Growth with speed, as a fraction of kinetic friction [s/m]."""
    base: Any
    """Resistance without static excess [N]."""
    enclosure: EnclosureLaw | None
    """None if `base` contains its force."""
    overlap: Any
    """Slip at which the sheets separate [m]."""
    start: Any
    """Slip at the start [m], where the spring has no force."""
    events: Any
    """Number of slip events after which the run ends."""
    tolerance: Any
    """Relative error tolerance of a step; 0 means steps of `step`, whatever the error."""
    paced_brake: Brake | None = None
    """The brake if its friction depends on the speed; `level` is that at the test speed."""


class State(NamedTuple):
    """State of a run."""

    time: Any
    slip: Any
    velocity: Any
    work: Any
    heat: Any
    mode: Any
    next_step: Any
    count: Any
    """Events so far."""
    high: Any
    low: Any
    broke: Any
    """Time, slip and force at which the mass last broke loose, shape (3,)."""
    table: Any
    """(events, 6), columns EVENT_COLUMNS."""
    trace: Any
    """(samples, 8), columns TRACE_COLUMNS."""
    written: Any
    actions: Any
    deviation: Any
    """Latest deviation from steady sliding, as a speed [m/s]."""
    reason: Any


class Trial(NamedTuple):
    """Result of a trial step."""

    travel: Any
    velocity: Any
    work: Any
    heat: Any
    error: Any


def static_bound(slip: Any, case: Slide) -> Any:
    """Return the largest force that leaves the mass at rest [N]."""
    return xp.maximum(case.level - case.fall * slip, 0.0) * (1 + case.rise) + base_drag(slip, case)


def base_drag(slip: Any, case: Slide) -> Any:
    """Return the resistance other than that of the sheets [N]."""
    if case.enclosure is None:
        return case.base
    # a trial step may start before the origin, where the enclosure has no branch
    return case.base + case.enclosure.force(xp.maximum(slip, case.start))


def resistance(slip: Any, velocity: Any, case: Slide) -> Any:
    """Return the friction of the sliding mass [N].

    A trial step may end at a negative speed before the stop is located. The excess is then mirrored
    about its value at rest, which keeps it smooth.
    """
    left = static_fraction(velocity, case.stribeck, case.exponent)
    left = xp.where(velocity < 0, 2 - left, left)
    # with the jump law, sliding begins at once
    left = xp.where(case.stribeck > 0, left, 0.0)
    sheets = xp.maximum(case.level - case.fall * slip, 0.0)
    kinetic, excess = 1.0, case.rise
    if case.paced_brake is not None:  # the bound at rest remains static friction
        kinetic = brake_growth(xp.maximum(velocity, 0.0), case.paced_brake)
        excess = 1 + case.rise - brake_growth(0.0, case.paced_brake)
    return sheets * (kinetic + excess * left + case.viscous * velocity) + base_drag(slip, case)


def spring_stretch(time: Any, slip: Any, case: Slide) -> Any:
    """Return the stretch of the spring [m] at a time [s]; negative if it is slack."""
    return case.start + case.speed * xp.minimum(time, case.ramp) - slip


def crosshead_speed(time: Any, case: Slide) -> Any:
    """Return the speed of the crosshead [m/s]; zero after the ramp."""
    return xp.where(time < case.ramp, case.speed, 0.0)


def spring_force(extension: Any, rate: Any, case: Slide) -> Any:
    """Return the combined force of the spring and the damper [N]; both can only pull."""
    force = case.spring * extension + case.damping * rate
    return xp.where(extension > 0, xp.maximum(force, 0.0), 0.0)


def runge_kutta(state: State, h: Any, case: Slide) -> Trial:
    """Return one Dormand–Prince step: new state, speed, work and heat."""
    e0, drive = spring_stretch(state.time, state.slip, case), crosshead_speed(state.time, case)
    taut = state.mode == TAUT

    def rate(s: Any, y: Any) -> Any:
        travel, v = y[0], y[1]
        e = e0 + drive * s - travel
        pull = xp.where(taut, case.spring * e + case.damping * (drive - v), 0.0)
        resist = resistance(state.slip + travel, v, case)
        loss = xp.where(taut, case.damping * (drive - v) ** 2, 0.0)
        return xp.stack([v, (pull - resist) / case.mass, pull * drive, resist * v + loss])

    y0 = xp.stack([0.0 * h, state.velocity, 0.0 * h, 0.0 * h])
    slopes: list[Any] = []
    for node, row in zip(_C, _A, strict=True):
        y = y0
        for weight, slope in zip(row, slopes, strict=True):
            y = y + h * weight * slope
        slopes.append(rate(node * h, y))
    table = xp.stack(slopes)
    y = y0 + h * xp.tensordot(xp.asarray(_B), table, axes=1)
    difference = h * xp.tensordot(xp.asarray(_B - _B4), table, axes=1)
    omega = xp.sqrt(case.spring / case.mass)
    norm = xp.maximum(xp.abs(y[1]), xp.abs(state.velocity)) + 1e-3 * slip_speed(state.slip, case)
    error = xp.maximum(xp.abs(difference[1]), omega * xp.abs(difference[0])) / norm
    # a spring that transmits no force but is still stretched relaxes into its damper
    energy = xp.maximum(e0, 0.0) ** 2 - xp.maximum(e0 + drive * h - y[0], 0.0) ** 2
    heat = y[3] + xp.where(taut, 0.0, case.spring / 2 * energy)
    return Trial(y[0], y[1], y[2], heat, error)


def exact_step(state: State, h: Any, case: Slide) -> Trial:
    """Return the same step in closed form, for constant friction."""
    drive = crosshead_speed(state.time, case)
    resist = resistance(state.slip, 1.0, case)
    balance = resist / case.spring
    e0 = spring_stretch(state.time, state.slip, case)
    z0, u0 = e0 - balance, drive - state.velocity
    decay = case.damping / (2 * case.mass)
    square = case.spring / case.mass - decay**2
    root = xp.sqrt(xp.abs(xp.where(square == 0, 1.0, square)))
    cosine = xp.where(square > 0, xp.cos(root * h), xp.cosh(root * h))
    sine = xp.where(square > 0, xp.sin(root * h), xp.sinh(root * h)) / root
    cosine, sine = xp.where(square == 0, 1.0, cosine), xp.where(square == 0, h, sine)
    fade = xp.exp(-decay * h)
    z = fade * (z0 * cosine + (u0 + decay * z0) * sine)
    u = fade * (u0 * cosine - (case.spring / case.mass * z0 + decay * u0) * sine)
    taut = state.mode == TAUT
    brake = resist / case.mass
    velocity = xp.where(taut, drive - u, state.velocity - brake * h)
    travel = xp.where(taut, drive * h - (z - z0), state.velocity * h - brake * h**2 / 2)
    gain = velocity - state.velocity
    work = xp.where(taut, drive * (resist * h + case.mass * gain), 0.0)
    e1 = e0 + drive * h - travel
    energy = case.spring / 2 * (xp.maximum(e1, 0.0) ** 2 - xp.maximum(e0, 0.0) ** 2)
    moving = case.mass / 2 * (velocity**2 - state.velocity**2)
    return Trial(travel, velocity, work, work - energy - moving, 0.0 * h)


def slip_speed(slip: Any, case: Slide) -> Any:
    """Return a typical speed during a slip [m/s]."""
    drop = xp.maximum(case.level - case.fall * slip, 0.0) * case.rise
    return drop / xp.sqrt(case.spring * case.mass) + case.speed


def hermite_root(h: Any, f0: Any, d0: Any, f1: Any, d1: Any) -> tuple[Any, Any]:
    """Return (crosses, first zero in (0, h]) of the cubic with these ends and slopes, f0 >= 0.

    It also detects a dip below zero between two positive ends.
    """

    def cubic(s: Any) -> Any:
        r = 1 - s
        return r * r * ((1 + 2 * s) * f0 + s * h * d0) + s * s * ((3 - 2 * s) * f1 - r * h * d1)

    turn = xp.clip(d0 / xp.where(d0 == d1, 1.0, d0 - d1), 0.0, 1.0)
    dips = (f0 > 0) & (d0 < 0) & (d1 > 0) & (cubic(turn) < 0)
    crosses = (f1 < 0) | dips
    high = xp.where(dips & (f1 >= 0), turn, 1.0)
    last = -cubic(high)
    ends = xp.where(f0 > 0, -f0, -xp.abs(last)), last
    return crosses, rising_zero(lambda s: -cubic(s), xp.zeros_like(high), high, 48, ends) * h


def hermite_range(h: Any, f0: Any, d0: Any, f1: Any, d1: Any) -> tuple[Any, Any]:
    """Return the largest and the smallest value over a step, from ends and slopes."""
    turn = xp.clip(d0 / xp.where(d0 == d1, 1.0, d0 - d1), 0.0, 1.0)
    r = 1 - turn
    inner = r * r * ((1 + 2 * turn) * f0 + turn * h * d0)
    inner = inner + turn * turn * ((3 - 2 * turn) * f1 - r * h * d1)
    inner = xp.where((d0 * d1 < 0) & xp.isfinite(inner), inner, f1)
    return xp.maximum(xp.maximum(f0, f1), inner), xp.minimum(xp.minimum(f0, f1), inner)
