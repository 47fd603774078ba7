"""Vacuum that stops a mass after a given slip: by the paper's eq. 10, and exactly."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.energy import slip_work
from layerjam.mechanics.law import keep_if, law, safe_sqrt
from layerjam.mechanics.pull import brake_force, holding_vacuum
from layerjam.mechanics.roots import implicit_root
from layerjam.mechanics.stop.exact import STOPPED, is_speed_independent, stop
from layerjam.mechanics.stop.motion import rope_spring
from layerjam.mechanics.stop.paced_tune import FARTHEST, block_gradient, paced_speeds, paced_vacuum


def _absorbed_energy(vacuum: Any, weight: Any, slip: Any, spring: Any, brake: Brake) -> Any:
    """Return the kinetic energy of a mass that a vacuum [Pa] stops after a slip [m], in [J]."""
    force = brake_force(slip, vacuum, brake)
    work = slip_work(slip, vacuum, brake) + force**2 / (2 * spring)
    return work - weight * (slip + force / spring)


@law
def tuned_vacuum(mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake) -> Any:
    """Vacuum [Pa] at which a mass [kg] arriving with `speed` [m/s] stops after `slip` [m].

    `spring` [N/m] is rope and brake in series (infinite for none), `gravity` [m/s^2] acts along the
    pull. NaN if there is none. The mass may be too fast for the site's full vacuum, or so slow that
    a brake weak enough for that slip could not hold the weight there. With a speed law (of a power
    above 0) there is no energy balance: stops are computed until one ends within 1e-6 of the slip,
    which takes a thousand times as long. It needs a finite spring, and a derivative raises
    QuantityError.
    """
    shape = jnp.broadcast_arrays(mass, speed, slip, spring, gravity, brake.sheets.count)
    mass, speed, slip, spring, gravity, _ = shape
    balance = _balanced_vacuum(mass, speed, slip, spring, gravity, brake)
    if brake.speed_law is None:
        return balance
    case = jax.tree.map(block_gradient, (mass, speed, slip, spring, gravity, brake))
    return jnp.where(is_speed_independent(brake), balance, paced_vacuum(*case))


def _balanced_vacuum(
    mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Return the vacuum that meets the energy balance at the end of the slip."""
    top = brake.site.atmosphere + jnp.zeros_like(mass)
    least = holding_vacuum(mass * gravity, slip, brake)
    low = jnp.where(jnp.isnan(least), top, least)

    def excess(vacuum: Any) -> Any:
        return _absorbed_energy(vacuum, mass * gravity, slip, spring, brake) - mass * speed**2 / 2

    feasible = ~jnp.isnan(least) & (excess(low) <= 0) & (excess(top) >= 0)
    return keep_if(feasible, implicit_root(excess, low, top))


@law
def tuned_stop(mass: Any, speed: Any, slip: Any, rope: Any, gravity: Any, brake: Brake) -> Any:
    """Return the `tuned_vacuum` [Pa] if its stop ends as STOPPED after `slip` [m], or NaN.

    The balance holds at the end of the slip; on a soft `rope` [N/m] (None: no rope) the mass may
    stop or the brake snap earlier. All arguments broadcast, including the brake's numbers.
    """
    spring = rope_spring(rope, brake)
    arrays = (mass, speed, slip, spring, gravity, brake.sheets.count)
    mass, speed, slip, spring, gravity, _ = jnp.broadcast_arrays(*arrays)
    vacuum = tuned_vacuum(mass, speed, slip, spring, gravity, brake)
    plain = replace(brake, speed_law=None)
    result = stop(mass, speed, jnp.where(jnp.isnan(vacuum), 0.0, vacuum), spring, gravity, plain)
    is_met = (result.outcome == STOPPED) & (jnp.abs(result.slip - slip) <= FARTHEST * slip)
    # a vacuum of `paced_vacuum` has already been tried
    return keep_if(is_met | ~is_speed_independent(brake), vacuum)


@law
def speed_range(mass: Any, slip: Any, rope: Any, gravity: Any, brake: Brake) -> tuple[Any, Any]:
    """Return the speeds [m/s] between which `tuned_vacuum` solves its balance at a slip [m].

    The slowest belongs to the vacuum that just holds the weight there, the fastest to the site's
    full vacuum. NaN if even that cannot hold it; if the slowest exceeds the fastest, there is no
    such speed. With a speed law stops are tried, as in `tuned_vacuum`.
    """
    spring, full = rope_spring(rope, brake), brake.site.atmosphere
    least = holding_vacuum(mass * gravity, slip, brake)

    def speed(vacuum: Any) -> Any:
        energy = _absorbed_energy(vacuum, mass * gravity, slip, spring, brake)
        return safe_sqrt(jnp.maximum(energy, 0.0) * 2 / mass)

    low, high = speed(least), keep_if(~jnp.isnan(least), speed(full))
    if brake.speed_law is None:
        return low, high
    wide = jnp.broadcast_arrays(mass, slip, spring, gravity, brake.sheets.count)[:4]
    slowest, fastest = paced_speeds(*jax.tree.map(block_gradient, (*wide, brake)))
    same = is_speed_independent(brake)
    return jnp.where(same, low, slowest), jnp.where(same, high, fastest)


@law
def vacuum_eq10(mass: Any, speed: Any, slip: Any, brake: Brake) -> Any:
    """Return the paper's tuned vacuum [Pa]: half m v^2 = E(slip, P), no gravity, no elastic part.

    NaN if the site's full vacuum is not enough.
    """
    shape = jnp.broadcast_arrays(mass, speed, slip)
    mass, speed, slip = shape
    energy = mass * speed**2 / 2
    top = brake.site.atmosphere + jnp.zeros_like(energy)

    def excess(vacuum: Any) -> Any:
        return slip_work(slip, vacuum, brake) - energy

    root = implicit_root(excess, jnp.zeros_like(top), top)
    return keep_if((excess(top) >= 0) & (excess(0.0 * top) <= 0), root)
