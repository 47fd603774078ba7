"""Vacuum that stops a mass after a given slip: by the paper's eq. 10, and exactly."""

import functools
from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import map_leaves, xp
from layerjam.brake.mechanics.effects import has_single_modulus, is_proportional
from layerjam.brake.mechanics.enclosure import brake_enclosure, enclosure_law
from layerjam.brake.mechanics.energy import slip_work
from layerjam.brake.mechanics.friction import sheet_law
from layerjam.brake.mechanics.law import keep_if, law, safe_sqrt
from layerjam.brake.mechanics.pull import holding_vacuum
from layerjam.brake.mechanics.roots import crossing
from layerjam.brake.mechanics.slip_effects import friction_force, friction_work
from layerjam.brake.mechanics.speed_effects import depends_on_speed, has_speed_effects, ignore_speed
from layerjam.brake.mechanics.stop.algebra import (
    Quartic,
    polish_root,
    quartic_slope,
    quartic_value,
)
from layerjam.brake.mechanics.stop.energy_curve import Mass
from layerjam.brake.mechanics.stop.exact import STOPPED, first_root, stop
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.brake.mechanics.stop.paced_tune import (
    FARTHEST,
    block_gradient,
    paced_speeds,
    paced_vacuum,
)

ROOM = 1e-13
"""Relative increase of a vacuum that stops a mass at the end of the travel."""


def _absorbed_energy(vacuum: Any, weight: Any, slip: Any, spring: Any, brake: Brake) -> Any:
    """Return the kinetic energy of a mass that a vacuum [Pa] stops after a slip [m], in [J]."""
    sheets, enclosure = sheet_law(vacuum, brake), brake_enclosure(vacuum, brake)
    force = friction_force(slip, sheets) + enclosure.force(slip)
    work = friction_work(0.0 * slip, slip, sheets) + enclosure.work(slip)
    return work + force**2 / (2 * spring) - weight * (slip + force / spring)


@law(of_points=True)
def tuned_vacuum(mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake) -> Any:
    """Vacuum [Pa] at which a mass [kg] arriving with `speed` [m/s] stops after `slip` [m].

    `spring` [N/m] is rope and brake in series (infinite for none), `gravity` [m/s^2] acts along the
    pull. NaN if there is none. The mass may be too fast for the site's full vacuum, or so slow that
    a brake weak enough for that slip could not hold the weight there. With a speed law (of a power
    above 0) there is no energy balance: stops are computed until one ends within 1e-6 of the slip,
    or 2e-6 at the end of the travel. This takes a thousand times as long, needs a finite spring,
    and a derivative raises QuantityError.
    """
    shape = xp.broadcast_arrays(mass, speed, slip, spring, gravity, brake.sheets.count)
    mass, speed, slip, spring, gravity, _ = shape
    balance = _balanced_vacuum(mass, speed, slip, spring, gravity, brake)
    if not has_speed_effects(brake):
        return balance
    case = map_leaves(block_gradient, (mass, speed, slip, spring, gravity, brake))
    return xp.where(depends_on_speed(brake), paced_vacuum(*case), balance)


def _balanced_vacuum(
    mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake
) -> Any:
    """Return the vacuum that meets the energy balance at the end of the slip."""
    top = brake.site.atmosphere + xp.zeros_like(mass)
    holding = holding_vacuum(mass * gravity, slip, brake)
    low = xp.where(xp.isnan(holding), top, holding)

    def excess(vacuum: Any) -> Any:
        return _absorbed_energy(vacuum, mass * gravity, slip, spring, brake) - mass * speed**2 / 2

    if is_proportional(brake) and has_single_modulus(brake):
        balance = _make_balance(Mass(mass, speed, spring, gravity), slip, brake)
        vacuum = crossing(excess, low, top, functools.partial(_find_balance, balance))
    else:
        vacuum = crossing(excess, low, top)
    return keep_if(~xp.isnan(holding), vacuum)


class _Balance(NamedTuple):
    """Kinetic energy left after a slip, as quartics in the square root of the vacuum."""

    linear: Quartic
    """Energy while the whole enclosure moves."""
    spread: Quartic
    """Energy while the slip spreads over the enclosure."""
    edge: Any
    """Square root of the vacuum up to which the whole enclosure moves."""


def _make_balance(load: Mass, slip: Any, brake: Brake) -> _Balance:
    """Return the energy if friction is proportional to the vacuum, with one modulus."""
    sheets, unit, compliance = sheet_law(1.0, brake), enclosure_law(1.0, brake), 1 / load.k
    force, work = friction_force(slip, sheets), friction_work(0.0 * slip, slip, sheets)
    start, none = load.arrival_energy + load.weight * slip, 0.0 * force
    grip, step = unit.root * safe_sqrt(slip), unit.friction * unit.reach
    spread = Quartic(
        start + none,
        load.weight * grip * compliance - grip * slip * (2 / 3),
        load.weight * force * compliance - work - grip**2 * compliance / 2,
        -force * grip * compliance,
        -(force**2) * compliance / 2,
    )
    strip_force, both = unit.stiffness * slip / unit.reach, force + step
    linear = Quartic(
        start + (load.weight - strip_force / 2) * strip_force * compliance - strip_force * slip / 2,
        none,
        (load.weight - strip_force) * both * compliance - work - step * slip,
        none,
        unit.saturation * step / 6 - both**2 * compliance / 2,
    )
    return _Balance(linear, spread, safe_sqrt(slip / unit.saturation))


def _find_balance(balance: _Balance, low: Any, high: Any) -> Any:
    """Return the vacuum between two vacuums [Pa] at which no kinetic energy is left."""
    low, high = safe_sqrt(low), safe_sqrt(high)
    edge = xp.clip(xp.where(balance.edge >= 0, balance.edge, high), low, high)
    ends_early = quartic_value(balance.linear, edge) <= 0
    energy = Quartic(*(xp.where(ends_early, *pair) for pair in zip(*balance[:2], strict=True)))
    low, high = xp.where(ends_early, low, edge), xp.where(ends_early, edge, high)
    root = first_root(energy, low, high)
    return polish_root(energy, root, quartic_slope(energy, root)) ** 2


@law
def tuned_stop(mass: Any, speed: Any, slip: Any, rope: Any, gravity: Any, brake: Brake) -> Any:
    """Return the `tuned_vacuum` [Pa] if its stop ends as STOPPED after `slip` [m], or NaN.

    The balance holds at the end of the slip; on a soft `rope` [N/m] (None: no rope) the mass may
    stop or the brake snap earlier. All arguments broadcast, including the brake's numbers.
    """
    spring = rope_spring(rope, brake)
    arrays = (mass, speed, slip, spring, gravity, brake.sheets.count)
    mass, speed, slip, spring, gravity, _ = xp.broadcast_arrays(*arrays)
    vacuum = tuned_vacuum(mass, speed, slip, spring, gravity, brake)
    # a stop at the end of the travel has no room for rounding, which would make it bottom out
    is_at_end = slip >= brake.sheets.usable_travel * (1 - ROOM)
    margin_vacuum = xp.minimum(vacuum * (1 + ROOM), brake.site.atmosphere)
    is_at_end = is_at_end & ~xp.asarray(depends_on_speed(brake))
    vacuum = xp.where(is_at_end, margin_vacuum, vacuum)
    constant_brake = ignore_speed(brake)
    result = stop(
        mass, speed, xp.where(xp.isnan(vacuum), 0.0, vacuum), spring, gravity, constant_brake
    )
    is_met = (result.outcome == STOPPED) & (xp.abs(result.slip - slip) <= FARTHEST * slip)
    # a vacuum of `paced_vacuum` has already been tried
    return keep_if(is_met | xp.asarray(depends_on_speed(brake)), vacuum)


@law
def speed_range(mass: Any, slip: Any, rope: Any, gravity: Any, brake: Brake) -> tuple[Any, Any]:
    """Return the speeds [m/s] between which `tuned_vacuum` solves its balance at a slip [m].

    The slowest belongs to the vacuum that just holds the weight there, the fastest to the site's
    full vacuum. NaN if even that cannot hold it; if the slowest exceeds the fastest, there is no
    such speed. With a speed law stops are tried, as in `tuned_vacuum`.
    """
    spring, full_vacuum = rope_spring(rope, brake), brake.site.atmosphere
    min_vacuum = holding_vacuum(mass * gravity, slip, brake)

    def speed(vacuum: Any) -> Any:
        energy = _absorbed_energy(vacuum, mass * gravity, slip, spring, brake)
        return safe_sqrt(xp.maximum(energy, 0.0) * 2 / mass)

    low, high = speed(min_vacuum), keep_if(~xp.isnan(min_vacuum), speed(full_vacuum))
    if not has_speed_effects(brake):
        return low, high
    arrays = xp.broadcast_arrays(mass, slip, spring, gravity, brake.sheets.count)[:4]
    slowest, fastest = paced_speeds(*map_leaves(block_gradient, (*arrays, brake)))
    has_speed = depends_on_speed(brake)
    return xp.where(has_speed, slowest, low), xp.where(has_speed, fastest, high)


@law
def vacuum_eq10(mass: Any, speed: Any, slip: Any, brake: Brake) -> Any:
    """Return the paper's tuned vacuum [Pa]: half m v^2 = E(slip, P), no gravity, no elastic part.

    NaN if the site's full vacuum is not enough.
    """
    shape = xp.broadcast_arrays(mass, speed, slip)
    mass, speed, slip = shape
    energy = mass * speed**2 / 2
    top = brake.site.atmosphere + xp.zeros_like(energy)

    def excess(vacuum: Any) -> Any:
        return slip_work(slip, vacuum, brake) - energy

    return crossing(excess, xp.zeros_like(top), top)
