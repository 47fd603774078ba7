"""The stop a design is wanted for: exact for brakes side by side, rigid ones one after another."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp

from layerjam.design.merit import Point, brake_of, can_be_built
from layerjam.device.brake import Brake
from layerjam.mechanics.law import law, within
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.mechanics.stop.exact import BOTTOMED_OUT, SNAPS, stop

RIGID = 1e12
"""Stiffness [N/m] of a brake in a row: what its spring stores is left out."""


class StopRequirement(NamedTuple):
    """A mass to be stopped; SI. `travel` is slip, as in `drop`; None where nothing is asked."""

    mass: float
    speed: float
    travel: float | None
    force: float | None
    gravity: float
    """Along the pull; 0 for a horizontal stop."""


def stops(point: Point, base: Brake, wanted: StopRequirement, most_in_row: int) -> dict[str, Any]:
    """`stop_slip` [m] and `stop_peak` [N] at each design's vacuum; NaN where it does not stop.

    Equal brakes in parallel share mass and force. In series they slip one after another, each to
    the end of its travel: there they count as rigid. `most_in_row` is the greatest `series`.
    """
    made = brake_of(point, base)
    fine = can_be_built(point, made)
    share = wanted.mass / point.parallel
    zero = jnp.zeros_like(share + made.sheets.usable_travel + point.series)
    spring = jnp.where(point.series > 1, RIGID, working_stiffness(made)) + zero
    speed, slip, peak = wanted.speed + zero, zero, zero
    done = zero > 0
    lost = zero > 0
    for turn in range(most_in_row):
        now = stop(share + zero, speed, point.vacuum + zero, spring, wanted.gravity + zero, made)
        going = ~done & ~lost
        slip = slip + jnp.where(going, now.slip, 0.0)
        peak = jnp.maximum(peak, jnp.where(going, now.peak_force, 0.0))
        runs = (now.outcome == BOTTOMED_OUT) & (turn + 1 < point.series)
        lost = lost | (going & (now.outcome == SNAPS))
        lost = lost | (going & (now.outcome == BOTTOMED_OUT) & ~runs)
        done = done | (going & ~runs)
        speed = jnp.where(going & runs, now.end_speed, jnp.where(done, 0.0, speed))
    stands = fine & done & ~lost
    return {
        "stop_slip": within(stands, slip),
        "stop_peak": within(stands, peak * point.parallel),
    }


@law
def least_peak(mass: Any, speed: Any, travel: Any, gravity: Any) -> Any:
    """Force [N] that no stop within a travel [m] can stay below: M (v^2/2z + g)."""
    return mass * (speed**2 / (2 * travel) + gravity)
