"""Vacuum, or speed, at which stops with a speed law end after a given slip.

No energy balance can be solved beforehand, because friction depends on the speeds during the whole
stop. The search therefore evaluates the stop itself, for many cases at once.
"""

from collections.abc import Callable
from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import without_gradient, xp
from layerjam.brake.mechanics.law import law
from layerjam.brake.mechanics.pull import brake_force, holding_vacuum
from layerjam.brake.mechanics.roots import false_position
from layerjam.brake.mechanics.speed_effects import fix_speed
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, stop

CLOSE = 1e-8
"""Relative distance of the stop from the target slip at which the search ends."""
FARTHEST = 1e-6
"""Largest relative distance of an accepted stop from the target."""
ROUNDS = 62
LEAST = 1e-4
"""Lowest vacuum tried, relative to the atmosphere; without friction there would be no stop."""
FASTEST = 1e3
"""Highest arrival speed tried [m/s]."""


def _excess_slip(slip: Any, case: tuple[Any, Any, Any, Any, Any], brake: Brake) -> Any:
    """Return the distance of the stop beyond a slip [m], extended by the energy left at the end.

    It is continuous, and rises with the energy of the mass.
    """
    result = stop(*case, brake)
    force = xp.where(result.peak_force > 0, result.peak_force, 1.0)
    excess = case[0] * result.end_speed**2 / 2 / force + CLOSE * slip
    return result.slip - slip + xp.where(result.outcome == BOTTOMED_OUT, excess, 0.0)


def _aim(slip: Any, brake: Brake) -> Any:
    """Return the slip [m] that stops must end at: one at the end of the travel must not pass it."""
    return xp.minimum(slip, brake.sheets.usable_travel * (1 - FARTHEST))


@law
def is_held(slip: Any, vacuum: Any, weight: Any, brake: Brake) -> Any:
    """Return whether a weight [N] stays at rest at a slip [m]; full vacuum [Pa].

    The weight may stop for a moment, held by sheets that still slide, and then continue.
    """
    return brake_force(slip, vacuum, fix_speed(0.0, brake)) >= weight * (1 - 1e-6)


def block_gradient(value: Any) -> Any:
    """Return the value; differentiating this result of a search raises QuantityError."""
    return without_gradient(
        value,
        "speed_law",
        "the vacuum of a stop with a speed law is found by search and has no gradient; "
        "use finite differences",
    )


def _find_slip_root(
    rising: Callable[[Any], Any], low: Any, high: Any, slip: Any, already: float = xp.nan
) -> Any:
    """Return the point at which the distance [m] beyond a slip crosses zero.

    It is NaN if the distance does not come close enough to zero.

    The result is `already` if the distance is positive at the lower end, and NaN if it jumps over
    zero.
    """
    end = false_position(rising, low, high, CLOSE * slip, ROUNDS)
    is_close = end.is_met & (end.error <= FARTHEST * slip)
    return xp.where(is_close, end.best, xp.where(end.below > 0, already, xp.nan))


def paced_vacuum(mass: Any, speed: Any, slip: Any, spring: Any, gravity: Any, brake: Brake) -> Any:
    """Return the vacuum [Pa] at which the mass stops after a slip [m]; arrays of the same shape.

    NaN if full vacuum does not stop the mass that soon, or if the lowest vacuum stops it sooner.
    Also NaN if friction at rest does not hold the weight there, so that it would slide on.
    """
    top, slip = brake.site.atmosphere + xp.zeros_like(mass), _aim(slip, brake)

    def excess(share: Any) -> Any:
        # the slip falls as the vacuum rises, so search over the difference from full vacuum
        return _excess_slip(slip, (mass, speed, top * (1 - share), spring, gravity), brake)

    zero = xp.zeros_like(top)
    vacuum = top * (1 - _find_slip_root(excess, zero, zero + 1 - LEAST, slip))
    is_holding = is_held(slip, xp.where(xp.isnan(vacuum), 0.0, vacuum), mass * gravity, brake)
    return xp.where(is_holding, vacuum, xp.nan)


def paced_speeds(mass: Any, slip: Any, spring: Any, gravity: Any, brake: Brake) -> tuple[Any, Any]:
    """Return the speeds [m/s] that the lowest holding vacuum and full vacuum stop at the slip.

    Arrays of one shape.
    """
    weight, full_vacuum = mass * gravity, brake.site.atmosphere + xp.zeros_like(mass)
    slip = _aim(slip, brake)
    lowest = holding_vacuum(weight, slip, fix_speed(0.0, brake))
    holding = ~xp.isnan(lowest)
    min_vacuum = xp.maximum(xp.where(holding, lowest, full_vacuum), LEAST * full_vacuum)
    # both searches run at once, so that the stop is compiled once
    vacuum, case = xp.stack([min_vacuum, full_vacuum]), (mass, slip, spring, gravity)
    mass, slip, spring, gravity = (xp.stack([a, a]) + xp.zeros_like(vacuum) for a in case)

    def excess(pace: Any) -> Any:
        return _excess_slip(slip, (mass, pace, vacuum, spring, gravity), brake)

    zero = xp.zeros_like(vacuum)
    # no speed is needed at a vacuum at which the mass slides that far from rest
    speeds = _find_slip_root(excess, zero, zero + FASTEST, slip, already=0.0)
    return speeds[0], xp.where(holding, speeds[1], xp.nan)
