"""The stop a design is wanted for: exact for brakes side by side, rigid ones one after another."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from layerjam.design.merit import Point, StickSlipPull, brake_of, can_be_built, merits
from layerjam.device.brake import Brake
from layerjam.mechanics.law import law, within
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.mechanics.stop.exact import BOTTOMED_OUT, SNAPS, stop
from layerjam.records.values import value
from layerjam.simulate.quantities import ARRIVAL_SPEED, MASS, STOP_TRAVEL
from layerjam.units import FlagSpec, like, quantity, record

RIGID = 1e12
"""Stiffness [N/m] of a brake in a row: what its spring stores is left out."""


@record
class StopRequirement:
    """[stop]: a mass to be stopped; `travel` is slip, as in `drop`, None where nothing is asked."""

    mass: float = like(MASS, "mass to stop")
    speed: float = like(ARRIVAL_SPEED, "speed of the mass")
    travel: float | None = like(STOP_TRAVEL, "slip it may take", default=None)
    force: float | None = quantity(
        "N", "greatest force allowed", open_lo=True, hi=1e9, default=None
    )
    horizontal: bool = value(FlagSpec(text="whether the mass moves level"), False)


def gravity(wanted: StopRequirement, base: Brake) -> Any:
    """Gravity along the pull [m/s^2]."""
    return jnp.where(wanted.horizontal, 0.0, base.site.gravity)


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
    fall = gravity(wanted, base)
    speed, slip, peak = wanted.speed + zero, zero, zero
    going, stands = zero == 0, zero > 0
    for turn in range(most_in_row):
        now = stop(share + zero, speed, point.vacuum + zero, spring, fall + zero, made)
        slip = slip + jnp.where(going, now.slip, 0.0)
        peak = jnp.maximum(peak, jnp.where(going, now.peak_force, 0.0))
        ends = now.outcome == BOTTOMED_OUT
        stands = stands | (going & ~ends & (now.outcome != SNAPS))
        going = going & ends & (turn + 1 < point.series)
        speed = jnp.where(going, now.end_speed, 0.0)
    return {
        "stop_slip": within(fine & stands, slip),
        "stop_peak": within(fine & stands, peak * point.parallel),
    }


def judged(
    point: Point,
    base: Brake,
    pulled: StickSlipPull | None,
    wanted: StopRequirement | None,
    most_in_row: int,
) -> dict[str, Any]:
    """Every figure of merit of designs, those of the stop where one is `wanted`."""
    stopped = {} if wanted is None else stops(point, base, wanted, most_in_row)
    return merits(point, base, pulled) | stopped


@law
def least_peak(mass: Any, speed: Any, travel: Any, gravity: Any) -> Any:
    """Force [N] that no stop within a travel [m] can stay below: M (v^2/2z + g)."""
    return mass * (speed**2 / (2 * travel) + gravity)
