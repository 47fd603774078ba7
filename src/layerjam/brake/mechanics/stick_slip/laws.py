"""Friction that falls with speed, and its effect on a mass pulled through a spring (ours).

A mass m is pulled through a spring k at a constant speed V against friction. The static bound F_s
holds it at rest, and the kinetic force F_k resists its motion. Stribeck's curve connects the two,

mu(v) = mu_k + (mu_s - mu_k) exp(-(|v|/v_s)^delta) + c |v|,

and v_s = 0 is the limit in which static friction vanishes immediately (the jump law). All closed
forms below are for the jump law unless stated otherwise. Forces are per brake, not per sheet.
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.friction import sheet_law
from layerjam.brake.mechanics.law import keep_if, law, safe_sqrt
from layerjam.brake.mechanics.roots import rising_zero
from layerjam.brake.mechanics.slip_effects import friction_force, scale_friction
from layerjam.brake.mechanics.stick_slip.stribeck import Stribeck


def film_curve(brake: Brake, speed: Any = 0.0, exponent: Any = 1.0, viscous: Any = 0.0) -> Stribeck:
    """Return static and kinetic friction of a brake's film with a Stribeck speed [m/s]."""
    film = brake.film
    return Stribeck(
        static=film.static, kinetic=film.kinetic, speed=speed, exponent=exponent, viscous=viscous
    )


def static_fraction(speed: Any, stribeck_speed: Any, exponent: Any) -> Any:
    """Return the fraction of the static excess at a speed: exp(-(|v|/v_s)^delta), 1 at rest."""
    weakens = (stribeck_speed > 0) & (speed != 0)
    ratio = xp.abs(speed) / xp.where(weakens, stribeck_speed, 1.0)
    power = xp.where(weakens, ratio, 1.0) ** exponent
    return xp.where(speed == 0, 1.0, xp.where(weakens, xp.exp(-power), 0.0))


@law
def stribeck_friction(speed: Any, curve: Stribeck) -> Any:
    """Return the friction coefficient at a sliding speed [m/s]; the static bound at rest.

    It is even in speed. At zero speed, where it has a kink for delta <= 1, the gradient is taken as
    0, the mean of both sides. NaN if the kinetic coefficient is above the static one.
    """
    static_share = static_fraction(speed, curve.speed, curve.exponent)
    friction = curve.kinetic + (curve.static - curve.kinetic) * static_share
    friction = friction + curve.viscous * xp.abs(speed)
    return keep_if((curve.kinetic >= 0) & (curve.static >= curve.kinetic), friction)


@law
def sliding_force(slip: Any, speed: Any, vacuum: Any, brake: Brake, curve: Stribeck) -> Any:
    """Return the force of steady sliding [N]; slip [m], speed [m/s], vacuum [Pa] broadcast.

    The sheets' part follows `curve` in place of the film's kinetic friction; the enclosure's does
    not depend on speed. Equal to `brake_force` for a flat curve with the film's kinetic friction.
    """
    share = stribeck_friction(speed, curve) / brake.film.kinetic
    friction = friction_force(slip, scale_friction(sheet_law(vacuum, brake), share))
    force = friction + enclosure_law(vacuum, brake).force(slip)
    return keep_if((slip >= 0) & (vacuum >= 0), force)


class Saw(NamedTuple):
    """One tooth of the stick–slip sawtooth."""

    force_high: Any
    """Largest force of the spring [N]."""
    force_low: Any
    """Smallest force [N]; zero if the spring becomes slack."""
    slip: Any
    """Slip of one event [m]."""
    period: Any
    """Time from one event to the next [s]."""
    slip_time: Any
    """Duration of the motion in each event [s]."""
    slack: Any
    """True if the spring becomes slack."""


def _is_physical(static: Any, kinetic: Any, stiffness: Any) -> Any:
    return (kinetic >= 0) & (static >= kinetic) & (stiffness > 0)


@law
def slow_saw(static: Any, kinetic: Any, stiffness: Any, mass: Any, speed: Any) -> Saw:
    """Return the sawtooth of a slow, undamped pull: F_s [N], F_k [N], k [N/m], m [kg], V [m/s].

    In the limit V -> 0 the force is between F_s and 2 F_k - F_s, with slips 2 (F_s - F_k)/k and the
    period 2 (F_s - F_k)/(k V) plus the slip's own half period. For F_s > 2 F_k the spring becomes
    slack, and friction alone stops the mass after F_s^2/(2 k F_k). This requires F_k > 0; NaN
    otherwise.
    """
    drop = static - kinetic
    slack = drop > kinetic
    drag = xp.where(kinetic > 0, kinetic, xp.nan)
    run = static**2 / (2 * stiffness * xp.where(slack, drag, 1.0))
    slip = xp.where(slack, run, 2 * drop / stiffness)
    omega = xp.sqrt(stiffness / mass)
    bound = xp.where(slack, kinetic / xp.where(slack, drop, 1.0), 1.0)
    # the mass slides against k and F_k for part of the half period, then against F_k alone
    speed_after = safe_sqrt(xp.maximum(drop**2 - kinetic**2, 0.0)) / xp.where(slack, drag, 1.0)
    time = (xp.arccos(xp.where(slack, -bound, 0.0)) + speed_after) / omega
    time = xp.where(slack, time, xp.pi / omega)
    is_valid = _is_physical(static, kinetic, stiffness) & (mass > 0) & (speed > 0)
    return Saw(
        force_high=keep_if(is_valid, static),
        force_low=keep_if(is_valid, xp.where(slack, 0.0, 2 * kinetic - static)),
        slip=keep_if(is_valid, slip),
        period=keep_if(is_valid, slip / speed + time),
        slip_time=keep_if(is_valid, time),
        slack=slack,
    )


@law
def undamped_saw(static: Any, kinetic: Any, stiffness: Any, mass: Any, speed: Any) -> Saw:
    """Return the exact undamped sawtooth at any speed; arguments as in `slow_saw`.

    The mass always sticks again: with R = sqrt((F_s - F_k)^2 + k m V^2) the force swings by R
    around F_k and is 2 F_k - F_s when the mass stops. NaN if the spring becomes slack only because
    of the speed (R > F_k >= F_s - F_k), because it then becomes taut again before the mass has
    stopped.
    """
    drop = static - kinetic
    omega = xp.sqrt(stiffness / mass)
    swing = xp.sqrt(drop**2 + stiffness * mass * speed**2)
    slack = swing > kinetic
    is_known = ~slack | (drop > kinetic)
    hard = xp.where(drop > 0, drop, 1.0)
    taut_time = 2 * (xp.pi - xp.arctan2(drop, speed * xp.sqrt(stiffness * mass))) / omega
    taut_slip = 2 * drop / stiffness + speed * taut_time
    # until the spring is slack: from the phase of breakaway to that of zero force
    phase = xp.arccos(xp.where(slack, -kinetic / swing, 0.0))
    phase = phase + xp.arctan2(speed * xp.sqrt(stiffness * mass), hard)
    first = xp.where(slack, phase, 0.0) / omega
    pace = speed + safe_sqrt(xp.maximum(swing**2 - kinetic**2, 0.0)) / (stiffness / omega)
    drag = xp.where(slack & (kinetic > 0), kinetic, xp.where(slack, xp.nan, 1.0))
    slack_slip = static / stiffness + speed * first + mass * pace**2 / (2 * drag)
    slip = xp.where(slack, slack_slip, taut_slip)
    is_valid = _is_physical(static, kinetic, stiffness) & (mass > 0) & (speed > 0) & is_known
    return Saw(
        force_high=keep_if(is_valid, kinetic + swing),
        force_low=keep_if(is_valid, xp.where(slack, 0.0, kinetic - swing)),
        slip=keep_if(is_valid, slip),
        period=keep_if(is_valid, slip / speed),
        slip_time=keep_if(is_valid, xp.where(slack, first + mass * pace / drag, taut_time)),
        slack=slack,
    )


def _critical_share(ratio: Any) -> Any:
    """Return 1/kappa = V sqrt(k m)/(F_s - F_k) at which a mass just fails to stick again.

    From the tangent point (speed V, acceleration 0) the damped swing is followed back to the start
    of the slip, theta before it; `ratio` is the damping ratio, between 0 and 1.
    """
    inner = xp.where((ratio > 0) & (ratio < 1), ratio, 0.5)
    root = xp.sqrt(1 - inner**2)
    lean = inner / root

    def swing(theta: Any) -> Any:
        return xp.cos(theta) - lean * xp.sin(theta)

    def excess(theta: Any) -> Any:
        value = swing(theta)
        logarithm = xp.log(xp.where(value > 0, value, 1.0))
        return lean * theta + xp.where(value > 0, logarithm, -xp.inf)

    low = xp.pi + xp.arctan2(root, inner)
    theta = rising_zero(excess, low, xp.full_like(low, 2 * xp.pi))
    # a final Newton step carries the gradient; near critical damping the root is `low`
    radicand = swing(theta)
    resolved = radicand > 1e-9
    slope = -xp.sin(theta) / (root**2 * xp.where(resolved, radicand, 1.0))
    step = (lean * theta + xp.log(xp.where(resolved, radicand, 1.0))) / slope
    theta = xp.where(resolved, theta - step, low)
    return -xp.exp(-lean * theta) / xp.sin(theta) * root


@law
def critical_speed(static: Any, kinetic: Any, stiffness: Any, mass: Any, damping: Any) -> Any:
    """Return the pulling speed [m/s] above which stick–slip from rest decays immediately; jump law.

    `damping` [N s/m] acts parallel to the spring. The result is exact while the spring stays taut.
    If the spring becomes slack, the mass may stop, and stick–slip may continue above this speed. At
    a small damping ratio zeta it is (F_s - F_k)/sqrt(4 pi zeta k m). Infinite without damping, zero
    from critical damping upwards.
    """
    impedance = xp.sqrt(stiffness * mass)
    ratio = damping / (2 * impedance)
    speed = (static - kinetic) / impedance * _critical_share(ratio)
    speed = xp.where(ratio >= 1, 0.0, xp.where(ratio == 0, xp.inf, speed))
    speed = xp.where(static == kinetic, 0.0, speed)
    return keep_if(_is_physical(static, kinetic, stiffness) & (mass > 0) & (damping >= 0), speed)


@law
def stiffness_without_stick_slip(
    speed: Any, static: Any, kinetic: Any, mass: Any, damping_ratio: Any
) -> Any:
    """Return the lowest stiffness [N/m] for a pull at `speed` [m/s] without stick–slip, jump law.

    At a given damping ratio (that of the real mount) it is ((F_s - F_k)/(kappa V))^2/m. Infinite
    without damping, zero from critical damping upwards.
    """
    stiffness = ((static - kinetic) * _critical_share(damping_ratio) / speed) ** 2 / mass
    stiffness = xp.where(damping_ratio >= 1, 0.0, xp.where(damping_ratio == 0, xp.inf, stiffness))
    is_valid = (
        (kinetic >= 0) & (static >= kinetic) & (mass > 0) & (speed > 0) & (damping_ratio >= 0)
    )
    return keep_if(is_valid, stiffness)


@law
def stable_speed(drop: Any, stribeck_speed: Any, exponent: Any, damping: Any) -> Any:
    """Return the pulling speed [m/s] above which steady sliding is stable to small disturbances.

    `drop` is F_s - F_k [N], `damping` [N s/m] that of the mount plus the friction's own viscous
    slope. Stability needs damping > -dF/dv. The highest speed at which they are equal is v_s
    w^(1/d) with w - (1 - 1/d) ln w = -ln(damping v_s/(drop d)); for d = 1, v_s ln(drop/(damping
    v_s)). It is zero if sliding is stable at every speed, infinite without damping, and independent
    of stiffness and mass. Stick–slip that has begun may continue above it.
    """
    power = 1 - 1 / exponent
    share = damping * stribeck_speed / xp.where(drop > 0, drop * exponent, 1.0)
    safe_share = xp.where((share > 0) & (drop > 0), share, 1.0)
    turn = xp.maximum(power, 0.0)
    steepest = xp.where(turn > 0, xp.where(turn > 0, turn, 1.0) ** turn * xp.exp(-turn), 1.0)
    weakens = (drop > 0) & (stribeck_speed > 0) & ((share < steepest) | (power < 0))

    # solved for ln w, because below d = 1 the root may be 1e-30; w <= 1 bounds it from below
    def residual(u: Any) -> Any:
        return xp.exp(u) - power * u + xp.log(safe_share)

    slack = -xp.log(safe_share) - 1
    deep = xp.minimum(slack / xp.where(power < 0, -power, 1.0), 0.0) - 1
    low = xp.where(turn > 0, xp.log(xp.where(turn > 0, turn, 1.0)), -750.0)
    low = xp.where(power < 0, deep, low) + xp.zeros_like(safe_share)
    high = xp.log(2 * (turn + 2 + xp.abs(xp.log(safe_share)))) + xp.zeros_like(low)
    u = rising_zero(residual, low, high)
    slope = xp.exp(u) - power
    u = u - residual(u) / xp.where(slope > 0, slope, 1.0)
    speed = stribeck_speed * xp.exp(xp.where(weakens, u, 0.0) / exponent)
    speed = xp.where(weakens, xp.where(share > 0, speed, xp.inf), 0.0)
    is_valid = (drop >= 0) & (stribeck_speed >= 0) & (exponent > 0) & (damping >= 0)
    return keep_if(is_valid, speed)
