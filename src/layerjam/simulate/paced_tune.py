"""The vacuum, or the speed, at which stops with a speed law end after a given slip.

There is no balance to solve beforehand: friction has seen the speeds of the whole stop. So the stop
itself is what the search asks, for many cases at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.device.brake import Brake
from layerjam.mechanics.friction import growth_of
from layerjam.mechanics.pull import brake_force, vacuum_for_force
from layerjam.mechanics.stop.exact import BOTTOMED_OUT, stop

Array = npt.NDArray[np.float64]
CLOSE = 1e-8
"""Distance of the stop from the wanted slip, over that slip, at which the search ends."""
NEAR = 1e-6
"""Greatest distance of a stop that counts, over that slip."""
ROUNDS = 60
LEAST = 1e-4
"""Least vacuum that is tried, over the atmosphere: without friction there is nothing to follow."""
FASTEST = 1e3
"""Fastest arrival that is tried [m/s]."""


def _beyond(slip: Array, case: tuple[Any, Any, Any, Any, Any], brake: Brake) -> Array:
    """How far the stop goes beyond a slip [m]; a mass that has run out of travel goes on the more.

    Continuous and rising with what is left of its energy.
    """
    made = stop(*case, brake)
    end, force = np.asarray(made.end_speed), np.asarray(made.peak_force)
    over = case[0] * end**2 / 2 / np.where(force > 0, force, 1.0) + CLOSE * slip
    out = np.asarray(made.outcome) == BOTTOMED_OUT
    return np.asarray(made.slip) - slip + np.where(out, over, 0.0)


def at_rest(brake: Brake) -> Brake:
    """The brake with the friction of sheets that slide ever so slowly."""
    return replace(brake, scale_factor=brake.scale_factor * growth_of(0.0, brake))


def holds(slip: Any, vacuum: Any, weight: Any, brake: Brake) -> Any:
    """Whether a weight [N] that has come to rest at a slip [m] stays there.

    It may stand still for a moment, held by sheets that still slide, and then go on.
    """
    return np.asarray(brake_force(slip, vacuum, at_rest(brake))) >= weight * (1 - 1e-6)


def _root(rising: Callable[[Array], Array], low: Array, high: Array, slip: Array) -> Array:
    """Where a rising function of arrays passes zero, by Illinois' false position; NaN for nowhere.

    Where it jumps over zero there is no slip that is near enough, and the result is NaN too.
    """
    under, above = rising(low), rising(high)
    there = (under <= 0) & (above >= 0)
    best, near = high, np.abs(above)
    for turn in range(ROUNDS):
        apart = np.abs(high - low) > 1e-12 * np.abs(high)
        if not (there & (near > CLOSE * slip) & apart).any():
            break
        share = -under / np.where(above > under, above - under, 1.0)
        # every third time in the middle: a jump is not to be crept up to
        share = np.full_like(share, 0.5) if turn % 3 == 2 else np.clip(share, 0.0, 1.0)
        x = low + (high - low) * share
        here = rising(x)
        less = here < 0
        low, high = np.where(less, x, low), np.where(less, high, x)
        under, above = np.where(less, here, under / 2), np.where(less, above / 2, here)
        best, near = np.where(np.abs(here) < near, x, best), np.minimum(near, np.abs(here))
    return np.where(there & (near <= NEAR * slip), best, np.nan)


def paced_vacuum(
    mass: Array, speed: Array, slip: Array, spring: Array, gravity: Array, brake: Brake
) -> Array:
    """Vacuum [Pa] at which the mass stops after a slip [m]; arrays of one shape.

    NaN where full vacuum does not stop it so soon, or the least one that is tried not so late; and
    where friction at rest does not hold the weight there, so that it would slide on.
    """
    top = brake.site.atmosphere + np.zeros_like(mass)

    def short(share: Array) -> Array:
        # the slip falls as the vacuum rises: the search is over what is missing to the full one
        return _beyond(slip, (mass, speed, top * (1 - share), spring, gravity), brake)

    zero = np.zeros_like(mass)
    found = top * (1 - _root(short, zero, zero + 1 - LEAST, slip))
    stays = holds(slip, np.where(np.isnan(found), 0.0, found), mass * gravity, brake)
    return np.where(stays, found, np.nan)


def paced_speeds(
    mass: Array, slip: Array, spring: Array, gravity: Array, brake: Brake
) -> tuple[Array, Array]:
    """Speeds [m/s] that the vacuum which just holds the weight there, and full vacuum, stop so."""
    weight, full = mass * gravity, brake.site.atmosphere + np.zeros_like(mass)
    rest = at_rest(brake)
    alone = np.asarray(brake_force(slip, 0.0, brake))
    held = np.asarray(vacuum_for_force(np.maximum(weight, alone), slip, rest))
    zero = np.zeros_like(mass)

    def speed(vacuum: Array) -> Array:
        def far(pace: Array) -> Array:
            return _beyond(slip, (mass, pace, vacuum, spring, gravity), brake)

        # a vacuum at which it slides that far from rest already
        return np.where(far(zero) > 0, 0.0, _root(far, zero, zero + FASTEST, slip))

    holds = ~np.isnan(held)
    least = np.maximum(np.where(holds, held, full), LEAST * full)
    return speed(least), np.where(holds, speed(full), np.nan)
