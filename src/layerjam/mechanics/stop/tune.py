"""The vacuum that stops a mass within a given slip (paper, eq. 10, and exactly)."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.energy import slip_work
from layerjam.mechanics.law import law, rising_zero, safe_sqrt, within
from layerjam.mechanics.pull import brake_force, vacuum_for_force
from layerjam.mechanics.stop.exact import STOPPED, any_speed, stop
from layerjam.mechanics.stop.motion import series_of

NEAR = 1e-6
"""Greatest distance of a stop from the wanted slip, over that slip."""


def _excess(
    vacuum: Any, mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Energy the brake takes over `slip` less what the mass brings [J], elastic parts included."""
    force = brake_force(slip, vacuum, brake)
    taken = slip_work(slip, vacuum, brake) + force**2 / (2 * spring)
    return taken - mass * speed**2 / 2 - mass * gravity * (slip + force / spring)


@law
def tuned_vacuum(mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake) -> Any:
    """Vacuum [Pa] at which a mass [kg] arriving with `speed` [m/s] stops after `slip` [m].

    `spring` [N/m] is rope and brake in series (infinite for none), `gravity` [m/s^2] acts along the
    pull. NaN where there is none: too fast for the site's full vacuum, or so slow that a brake weak
    enough to let it run that far could not hold the weight there. With a speed law NaN: no balance
    holds, and `simulate.paced_tune` tries stops.
    """
    shape = jnp.broadcast_arrays(mass, speed, slip, spring, gravity)
    mass, speed, slip, spring, gravity = shape
    balanced = _balanced_vacuum(mass, speed, slip, spring, gravity, brake)
    return within(any_speed(brake), balanced)


def _balanced_vacuum(
    mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Where the energy balance is met at the end of the slip."""
    top = brake.site.atmosphere + jnp.zeros_like(mass)
    enclosure_alone = brake_force(slip, 0.0, brake)
    held = vacuum_for_force(jnp.maximum(mass * gravity, enclosure_alone), slip, brake)
    low = jnp.where(jnp.isnan(held), top, held)

    def excess(vacuum: Any) -> Any:
        return _excess(vacuum, mass, speed, slip, spring, gravity, brake)

    feasible = ~jnp.isnan(held) & (excess(low) <= 0) & (excess(top) >= 0)
    guess = rising_zero(excess, low, top)
    value, slope = jax.jvp(excess, (guess,), (jnp.ones_like(guess),))
    slope = jax.lax.stop_gradient(jnp.where(slope > 0, slope, 1.0))
    return within(feasible, jnp.clip(guess - value / slope, low, top))


@law
def tuned_stop(mass: Any, speed: Any, slip: Any, rope: Any, gravity: Any, brake: Brake) -> Any:
    """The `tuned_vacuum` [Pa] where the stop at it ends STOPPED after `slip` [m], else NaN.

    The balance holds at the end of the slip; on a soft `rope` [N/m] (None: none) the mass may stop
    or the brake snap before it. All broadcast, the brake's numbers with them.
    """
    spring = series_of(rope, brake)
    arrays = (mass, speed, slip, spring, gravity, brake.sheets.count)
    mass, speed, slip, spring, gravity, _ = jnp.broadcast_arrays(*arrays)
    vacuum = tuned_vacuum(mass, speed, slip, spring, gravity, brake)
    made = stop(mass, speed, jnp.where(jnp.isnan(vacuum), 0.0, vacuum), spring, gravity, brake)
    there = (made.outcome == STOPPED) & (jnp.abs(made.slip - slip) <= NEAR * slip)
    return within(there, vacuum)


@law
def speed_range(mass: Any, slip: Any, rope: Any, gravity: Any, brake: Brake) -> tuple[Any, Any]:
    """Speeds [m/s] between which a `tuned_vacuum` solves its balance at a slip [m].

    The slowest belongs to the vacuum that just holds the weight there, the fastest to the site's
    full vacuum. NaN where not even that holds it, and with a speed law; a slowest above the fastest
    means no speed.
    """
    spring, full = series_of(rope, brake), brake.site.atmosphere
    weight = mass * gravity
    alone = brake_force(slip, 0.0, brake)
    held = vacuum_for_force(jnp.maximum(weight, alone), slip, brake)

    def speed(vacuum: Any) -> Any:
        force = brake_force(slip, vacuum, brake)
        taken = slip_work(slip, vacuum, brake) + force**2 / (2 * spring)
        return safe_sqrt(jnp.maximum(taken - weight * (slip + force / spring), 0.0) * 2 / mass)

    same = any_speed(brake)
    return within(same, speed(held)), within(same & ~jnp.isnan(held), speed(full))


@law
def vacuum_eq10(mass: Any, speed: Any, slip: Any, brake: Brake) -> Any:
    """The paper's tuned vacuum [Pa]: half m v^2 = E(slip, P), no gravity, no elastic part.

    NaN where the site's full vacuum is not enough.
    """
    shape = jnp.broadcast_arrays(mass, speed, slip)
    mass, speed, slip = shape
    energy = mass * speed**2 / 2
    top = brake.site.atmosphere + jnp.zeros_like(energy)

    def excess(vacuum: Any) -> Any:
        return slip_work(slip, vacuum, brake) - energy

    guess = rising_zero(excess, jnp.zeros_like(top), top)
    value, slope = jax.jvp(excess, (guess,), (jnp.ones_like(guess),))
    slope = jax.lax.stop_gradient(jnp.where(slope > 0, slope, 1.0))
    return within((excess(top) >= 0) & (excess(0.0 * top) <= 0), guess - value / slope)
