"""Stop requirement of a design, with exact stops for brakes in parallel.

Brakes in series are assumed to be rigid.
"""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.law import keep_if, law
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, SNAPS, stop
from layerjam.brake.simulate.prediction import Deviations, change_numbers
from layerjam.brake.simulate.quantities import ARRIVAL_SPEED, MASS, STOP_TRAVEL
from layerjam.core.toml_files.values import value
from layerjam.core.units import FlagSpec, like, quantity, record
from layerjam.workshop.design.merit import Point, StickSlipPull, is_buildable, make_brake, merits

RIGID = 1e12
"""Stiffness [N/m] of a brake in series: so high that the elastic energy is negligible."""


@record
class StopRequirement:
    """[stop]: a mass to be stopped; `travel` is the slip, as in `drop`, or None for no limit."""

    mass: float = like(MASS, "mass to stop")
    speed: float = like(ARRIVAL_SPEED, "speed of the mass")
    travel: float | None = like(STOP_TRAVEL, "allowed slip", default=None)
    force: float | None = quantity("N", "maximum allowed force", open_lo=True, hi=1e9, default=None)
    horizontal: bool = value(FlagSpec(text="whether the mass moves horizontally"), False)


def gravity_along_pull(need: StopRequirement, base: Brake) -> Any:
    """Return the acceleration of gravity along the pull [m/s^2]."""
    return xp.where(need.horizontal, 0.0, base.site.gravity)


def run_stops(
    point: Point,
    base: Brake,
    need: StopRequirement,
    max_series: int,
    deviations: Deviations | None = None,
) -> dict[str, Any]:
    """Return `stop_slip` [m] and `stop_peak` [N] at each design's vacuum; NaN without a stop.

    Identical brakes in parallel share mass and force equally. In series, they slip one after
    another, each to the end of its travel, and count as rigid. `max_series`: largest `series`.
    """
    brake = change_numbers(make_brake(point, base), deviations)
    valid = is_buildable(point, brake)
    share = need.mass / point.parallel
    zero = xp.zeros_like(share + brake.sheets.usable_travel + point.series)
    spring = xp.where(point.series > 1, RIGID, working_stiffness(brake)) + zero
    fall = gravity_along_pull(need, base)
    speed, slip, peak = need.speed + zero, zero, zero
    is_moving, is_stopped = zero == 0, zero > 0
    for index in range(max_series):
        result = stop(share + zero, speed, point.vacuum + zero, spring, fall + zero, brake)
        slip = slip + xp.where(is_moving, result.slip, 0.0)
        peak = xp.maximum(peak, xp.where(is_moving, result.peak_force, 0.0))
        at_end = result.outcome == BOTTOMED_OUT
        is_stopped = is_stopped | (is_moving & ~at_end & (result.outcome != SNAPS))
        is_moving = is_moving & at_end & (index + 1 < point.series)
        speed = xp.where(is_moving, result.end_speed, 0.0)
    return {
        "stop_slip": keep_if(valid & is_stopped, slip),
        "stop_peak": keep_if(valid & is_stopped, peak * point.parallel),
    }


def all_merits(
    point: Point,
    base: Brake,
    stick_slip: StickSlipPull | None,
    need: StopRequirement | None,
    max_series: int,
    deviations: Deviations | None = None,
) -> dict[str, Any]:
    """Return all figures of merit of designs, including those of a stop if required."""
    extra_merits = {} if need is None else run_stops(point, base, need, max_series, deviations)
    return merits(point, base, stick_slip, deviations) | extra_merits


@law
def least_peak(mass: Any, speed: Any, travel: Any, gravity: Any) -> Any:
    """Return the lowest possible peak force [N] of a stop within a travel [m], M (v^2/2z + g)."""
    return mass * (speed**2 / (2 * travel) + gravity)
