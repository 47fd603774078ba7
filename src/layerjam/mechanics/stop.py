"""A mass stopped by the brake at constant vacuum, exactly (paper, section III-E).

The mass hangs on a spring k, rope and brake in series, and on the brake, which slips by s once the
force has reached Y(0). All is work and energy: K(s), the kinetic energy at slip s, is a closed
form, and the travel is its first root. In w = sqrt(s) it is a quartic, smooth at the start.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import (
    Sleeve,
    backbone,
    backbone_dissipated,
    backbone_stored,
    backbone_work,
    sleeve_at,
)
from layerjam.mechanics.friction import friction_per_contact
from layerjam.mechanics.law import law, safe_sqrt, within

STOPPED, NEVER_SLID, BOTTOMED_OUT, SNAPS = 0, 1, 2, 3
"""Outcome codes."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


class Stop(NamedTuple):
    """How a stop went; arrays of the broadcast shape."""

    slip: Any
    """Slip of the brake at standstill or at the end of its travel [m]."""
    peak_force: Any
    """Greatest force until then [N]."""
    end_speed: Any
    """Speed of the mass at the end of travel [m/s]; zero at a standstill."""
    heat: Any
    """Energy dissipated until then [J]."""
    stored: Any
    """Elastic energy held then in rope, sheets, mount and sleeve [J]."""
    outcome: Any
    """STOPPED, NEVER_SLID, BOTTOMED_OUT or SNAPS."""


class _Setup(NamedTuple):
    """Constants of one stop."""

    weight: Any
    c: Any
    onset: Any
    k: Any
    sleeve: Sleeve
    kinetic: Any
    """Kinetic energy when slip begins [J]."""


def _setup(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> _Setup:
    c, weight = friction_per_contact(vacuum, brake), mass * gravity
    onset = c * brake.sheets.overlap
    kinetic = mass * speed**2 / 2 + (weight * onset - onset**2 / 2) / spring
    return _Setup(weight, c, onset, spring, sleeve_at(vacuum, brake), kinetic)


def _resist(slip: Any, at: _Setup) -> Any:
    return at.onset - at.c * slip + backbone(slip, at.sleeve)


def kinetic_energy(slip: Any, at: _Setup) -> Any:
    """K(s) [J]: what is left of the mass's energy of motion at slip s [m]."""
    change = _resist(slip, at) - at.onset
    spring = (at.weight - at.onset) * change - change**2 / 2
    work = at.onset * slip - at.c * slip**2 / 2 + backbone_work(slip, at.sleeve)
    return at.kinetic + at.weight * slip - work + spring / at.k


def _falling_balance(at: _Setup, travel: Any) -> Any:
    """The slip at which the falling force meets the weight, or `travel` if that comes first.

    Up to there the kinetic energy falls (or first rises, then falls), so its first root is the
    only one.
    """
    # c x - e sqrt(x) = Y(0) - weight, the larger root; then the linear, saturated part
    over = at.onset - at.weight
    square = at.sleeve.root**2 + 4 * at.c * over
    falls = at.c > 0
    root = (at.sleeve.root + safe_sqrt(jnp.maximum(square, 0.0))) / jnp.where(falls, 2 * at.c, 1.0)
    slope = at.c - at.sleeve.stiffness / at.sleeve.reach
    linear = over + at.sleeve.friction * at.sleeve.reach
    linear = linear / jnp.where(slope > 0, slope, 1.0)
    balance = jnp.where(root**2 < at.sleeve.saturation, root**2, linear)
    rises = (slope <= 0) & (root**2 >= at.sleeve.saturation)
    heavy = square < 0
    limit = jnp.where(falls & ~rises & ~heavy, jnp.maximum(balance, 0.0), travel)
    return jnp.minimum(limit, travel)


class _Quartic(NamedTuple):
    """K(w) = a0 + a1 w + ... + a4 w^4 [J] in w = sqrt(slip), where the sleeve keeps one form."""

    a0: Any
    a1: Any
    a2: Any
    a3: Any
    a4: Any

    def at(self, w: Any) -> Any:
        return self.a0 + w * (self.a1 + w * (self.a2 + w * (self.a3 + w * self.a4)))

    def slopes(self, w: Any) -> tuple[Any, Any]:
        first = self.a1 + w * (2 * self.a2 + w * (3 * self.a3 + w * 4 * self.a4))
        return first, 2 * self.a2 + w * (6 * self.a3 + w * 12 * self.a4)


def _quartic(at: _Setup, saturated: Any) -> _Quartic:
    """The kinetic energy while the sleeve spreads, or (where `saturated`) once it moves whole."""
    c, e, k, over = at.c, at.sleeve.root, at.k, at.weight - at.onset
    slope, step = at.sleeve.stiffness / at.sleeve.reach, at.sleeve.friction * at.sleeve.reach
    fall = c - slope
    whole = at.kinetic + step * at.sleeve.saturation / 6 + (over - step / 2) * step / k
    bend = over - step + (step - over) * fall / k
    return _Quartic(
        a0=jnp.where(saturated, whole, at.kinetic),
        a1=jnp.where(saturated, 0.0, over * e / k),
        a2=jnp.where(saturated, bend, over - over * c / k - e**2 / (2 * k)),
        a3=jnp.where(saturated, 0.0, (c / k - 2 / 3) * e),
        a4=jnp.where(saturated, fall - fall**2 / k, c - c**2 / k) / 2,
    )


def _first_root(energy: _Quartic, low: Any, high: Any) -> Any:
    """sqrt of the slip in [low, high] where the kinetic energy, falling, passes zero.

    Three steps that follow slope and curvature (Euler's, cubic) from the root without a sleeve; if
    anywhere they have not settled, Newton steps kept in their bracket for all.
    """

    def curved(w: Any) -> Any:
        value, (first, second) = energy.at(w), energy.slopes(w)
        down = jnp.sqrt(jnp.maximum(first**2 - 2 * value * second, 0.0)) - first
        return jnp.clip(w + 2 * value / jnp.where(down > 0, down, 1.0), low, high)

    near = jnp.sqrt(jnp.maximum(energy.a2**2 - 4 * energy.a0 * energy.a4, 0.0)) - energy.a2
    near = 2 * energy.a0 / jnp.where(near > 0, near, 1.0)
    start = jnp.clip(jnp.sqrt(jnp.maximum(near, 0.0)), low, high)
    before = curved(curved(start))
    found = curved(before)
    settled = jnp.all(~(jnp.abs(found - before) > 1e-5 * high))
    return jax.lax.cond(settled, lambda: found, lambda: _bracketed(energy, low, high))


def _bracketed(energy: _Quartic, low: Any, high: Any) -> Any:
    def step(_: int, state: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        low, high, w = state
        value, (slope, _unused) = energy.at(w), energy.slopes(w)
        low, high = jnp.where(value > 0, w, low), jnp.where(value > 0, high, w)
        guess = w - value / jnp.where(slope != 0, slope, 1.0)
        inside = (guess > low) & (guess < high) & (slope != 0)
        return low, high, jnp.where(inside, guess, (low + high) / 2)

    return jax.lax.fori_loop(0, 60, step, (low, high, (low + high) / 2))[2]


@law
def stop(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Stop:
    """Stop a mass [kg] that arrives with `speed` [m/s] on a taut rope, at a vacuum [Pa].

    `spring` [N/m] is rope and brake in series, `gravity` [m/s^2] acts along the pull (0 for a
    horizontal one); all broadcast. Exact: closed-form work, one bracketed root, the first one.
    """
    mass, speed, vacuum, spring, gravity = jnp.broadcast_arrays(
        mass, speed, vacuum, spring, gravity
    )
    at = _setup(mass, speed, vacuum, spring, gravity, brake)
    travel = brake.sheets.usable_travel + jnp.zeros_like(at.kinetic)
    elastic = at.weight + jnp.sqrt(at.weight**2 + spring * mass * speed**2)
    slides = elastic > at.onset
    # on a spring softer than the fall of the force the brake runs on by itself from here
    soft = at.c - spring
    snap = (at.sleeve.root / (2 * jnp.where(soft > 0, soft, 1.0))) ** 2
    snap = jnp.where(soft > 0, snap, jnp.inf)
    end = jnp.minimum(_falling_balance(at, travel), snap)
    edge = jnp.minimum(at.sleeve.saturation, end)
    spread = _quartic(at, jnp.array(False))
    # beyond its saturation the sleeve has another quartic
    beyond = (spread.at(jnp.sqrt(edge)) > 0) & (edge < end)
    energy = _quartic(at, beyond)
    low, high = jnp.where(beyond, edge, 0.0), jnp.where(beyond, end, edge)
    stops = energy.at(jnp.sqrt(high)) <= 0
    constants, low, high = jax.lax.stop_gradient((energy, jnp.sqrt(low), jnp.sqrt(high)))
    root = _polished(_first_root(constants, low, high), energy)
    far = jnp.minimum(travel, snap)
    root = jnp.where(slides, jnp.where(stops, root, jnp.sqrt(far)), 0.0)
    slip = root**2
    outcome = jnp.where(stops, STOPPED, jnp.where(snap < travel, SNAPS, BOTTOMED_OUT))
    outcome = jnp.where(slides, outcome, NEVER_SLID)
    whole = slip >= at.sleeve.saturation
    sleeve = at.sleeve.stiffness * slip / at.sleeve.reach + at.sleeve.friction * at.sleeve.reach
    resist = at.onset - at.c * slip + jnp.where(whole, sleeve, at.sleeve.root * root)
    ratio = at.sleeve.root / (2 * jnp.where(at.c > 0, at.c, 1.0))
    top = jnp.where((at.c > 0) & (ratio**2 < jnp.minimum(slip, at.sleeve.saturation)), ratio, 0.0)
    highest = jnp.maximum(resist, at.onset + at.sleeve.root * top / 2)
    peak = jnp.where(slides, jnp.maximum(highest, at.onset), elastic)
    left = jnp.where(stops | ~slides, 0.0, jnp.maximum(_quartic(at, whole).at(root), 0.0))
    force = jnp.where(slides, resist, elastic)
    heat = at.onset * slip - at.c * slip**2 / 2 + backbone_dissipated(slip, at.sleeve)
    fine = (mass > 0) & (speed >= 0) & (vacuum >= 0) & (spring > 0) & (gravity >= 0)
    return Stop(
        slip=within(fine, slip),
        peak_force=within(fine, peak),
        end_speed=within(fine, safe_sqrt(2 * left / mass)),
        heat=within(fine, heat),
        stored=within(fine, force**2 / (2 * spring) + backbone_stored(slip, at.sleeve)),
        outcome=outcome,
    )


def _polished(root: Any, energy: _Quartic) -> Any:
    """The root after one more Newton step, which carries the gradient (implicit function)."""
    slope = jax.lax.stop_gradient(energy.slopes(root)[0])
    step = jnp.where(slope < 0, energy.at(root) / jnp.where(slope < 0, slope, -1.0), 0.0)
    return jnp.maximum(root - step, 0.0)


def _elastic_time(mass: Any, speed: Any, gravity: Any, at: _Setup, slides: Any) -> Any:
    """Seconds until the brake begins to slide, or (if it never does) to the first standstill."""
    omega = jnp.sqrt(at.k / mass)
    sag, swing = gravity / omega**2, speed / omega
    size = jnp.sqrt(sag**2 + swing**2)
    size = jnp.where(size > 0, size, 1.0)
    phase = jnp.arctan2(sag, swing)
    onset = jnp.arcsin(jnp.clip((at.onset / at.k - sag) / size, -1, 1))
    return (jnp.where(slides, onset, jnp.pi / 2) + phase) / omega


@law
def speed_at_slip(
    slip: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Speed of the mass [m/s] once the brake has slipped by `slip` [m]; NaN past its standstill."""
    at = _setup(mass, speed, vacuum, spring, gravity, brake)
    left = kinetic_energy(slip, at)
    # a standstill found to rounding may lie on either side of zero
    size = at.kinetic + at.weight * slip
    return safe_sqrt(jnp.where(left < -1e-9 * size, left, jnp.maximum(left, 0.0)) * 2 / mass)


@law
def time_at_slip(
    slip: Any, mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Seconds from the taut rope until the brake has slipped by `slip` [m], up to its standstill.

    The elastic part in closed form, the sliding part by 48-point Gauss quadrature of dz/v after
    s = slip sin^4(q), which takes out the singular start and, at a standstill, the singular end.
    """
    arrays = jnp.broadcast_arrays(slip, mass, speed, vacuum, spring, gravity)
    slip, mass, speed, vacuum, spring, gravity = arrays
    at = _setup(mass, speed, vacuum, spring, gravity, brake)
    slides = at.weight + jnp.sqrt(at.weight**2 + spring * mass * speed**2) > at.onset
    q = ((jnp.asarray(_NODES) + 1) * (jnp.pi / 4)).reshape((-1,) + (1,) * jnp.ndim(slip))
    part = slip * jnp.sin(q) ** 4
    # ds/dq, and d sqrt(s)/dq for the sleeve, whose slope in s is infinite at the start
    rate = 4 * jnp.sin(q) ** 3 * jnp.cos(q) * slip
    spread = at.sleeve.root * 2 * jnp.sin(q) * jnp.cos(q) * safe_sqrt(slip)
    linear = at.sleeve.stiffness / at.sleeve.reach * rate
    stretch = jnp.where(part < at.sleeve.saturation, spread, linear)
    pace = safe_sqrt(2 * jnp.maximum(kinetic_energy(part, at), 0.0) / mass)
    steps = (rate + (stretch - at.c * rate) / spring) / jnp.where(pace > 0, pace, jnp.inf)
    weights = jnp.asarray(_WEIGHTS).reshape(q.shape) * (jnp.pi / 4)
    return _elastic_time(mass, speed, gravity, at, slides) + (weights * steps).sum(axis=0)
