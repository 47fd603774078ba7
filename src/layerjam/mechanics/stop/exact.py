"""A mass stopped by the brake at constant vacuum, exactly (paper, section III-E).

The mass hangs on a spring k, rope and brake in series, and on the brake, which slips by s once the
force has reached Y(0). All is work and energy: K(s), the kinetic energy at slip s, is a closed
form, and the travel is its first root. In w = sqrt(s) it is a quartic, smooth at the start.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import backbone, backbone_work, enclosure_at
from layerjam.mechanics.friction import friction_per_contact
from layerjam.mechanics.law import law, safe_sqrt, within
from layerjam.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
    Quartic,
    Setup,
    Stop,
    curved,
    end_of,
    guess,
    polished,
    search,
    setup,
    slope_of,
    value,
)

__all__ = ["BOTTOMED_OUT", "NEVER_SLID", "NOT_A_CASE", "SNAPS", "STOPPED"]
__all__ += ["Stop", "kinetic_energy", "speed_at_slip", "stop", "time_at_slip"]
SETTLED = 1e-5
"""Last step of the root's search, over its bracket, below which the next one changes nothing."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


def _setup(mass: Any, speed: Any, vacuum: Any, spring: Any, gravity: Any, brake: Brake) -> Setup:
    c, enclosure = friction_per_contact(vacuum, brake), enclosure_at(vacuum, brake)
    return setup(mass, speed, c, brake.sheets.overlap, enclosure, spring, gravity)


def kinetic_energy(slip: Any, at: Setup) -> Any:
    """K(s) [J]: what is left of the mass's energy of motion at slip s [m]."""
    change = backbone(slip, at.enclosure) - at.c * slip
    spring = (at.weight - at.onset) * change - change**2 / 2
    work = at.onset * slip - at.c * slip**2 / 2 + backbone_work(slip, at.enclosure)
    return at.kinetic + at.weight * slip - work + spring / at.k


def _first_root(energy: Quartic, low: Any, high: Any) -> Any:
    """sqrt of the slip in [low, high] where the kinetic energy, falling, passes zero.

    Three curved steps from the root without an enclosure; if anywhere they have not settled, Newton
    steps kept in their bracket for all.
    """
    before = guess(energy, low, high)
    for _ in range(2):
        before = curved(energy, before, low, high)
    found = curved(energy, before, low, high)
    settled = jnp.all(~(jnp.abs(found - before) > SETTLED * high))
    return jax.lax.cond(settled, lambda: found, lambda: _bracketed(energy, low, high))


def _bracketed(energy: Quartic, low: Any, high: Any) -> Any:
    def step(_: int, state: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
        low, high, w = state
        here, slope = value(energy, w), slope_of(energy, w)
        low, high = jnp.where(here > 0, w, low), jnp.where(here > 0, high, w)
        near = w - here / jnp.where(slope != 0, slope, 1.0)
        inside = (near > low) & (near < high) & (slope != 0)
        return low, high, jnp.where(inside, near, (low + high) / 2)

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
    found = search(at, travel)
    # the search is not differentiated: the polishing step carries the gradient of the root
    energy, low, high = jax.lax.stop_gradient((found.energy, found.low, found.high))
    root = _first_root(energy, low, high)
    root = polished(found.energy, root, jax.lax.stop_gradient(slope_of(energy, root)))
    end = end_of(at, found, root, travel)
    fine = (mass > 0) & (speed >= 0) & (vacuum >= 0) & (spring > 0) & (gravity >= 0)
    fine = fine & (at.onset + at.enclosure.root >= 0)
    outcome = jnp.where(fine, end.outcome, NOT_A_CASE)
    return Stop(*(within(fine, x) for x in end))._replace(outcome=outcome)


def _elastic_time(mass: Any, speed: Any, gravity: Any, at: Setup, slides: Any) -> Any:
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
    # ds/dq, and d sqrt(s)/dq for the enclosure, whose slope in s is infinite at the start
    rate = 4 * jnp.sin(q) ** 3 * jnp.cos(q) * slip
    spread = at.enclosure.root * 2 * jnp.sin(q) * jnp.cos(q) * safe_sqrt(slip)
    linear = at.enclosure.stiffness / at.enclosure.reach * rate
    stretch = jnp.where(part < at.enclosure.saturation, spread, linear)
    pace = safe_sqrt(2 * jnp.maximum(kinetic_energy(part, at), 0.0) / mass)
    steps = (rate + (stretch - at.c * rate) / spring) / jnp.where(pace > 0, pace, jnp.inf)
    weights = jnp.asarray(_WEIGHTS).reshape(q.shape) * (jnp.pi / 4)
    return _elastic_time(mass, speed, gravity, at, slides) + (weights * steps).sum(axis=0)
