"""Friction of the jammed sheets (paper, eq. 4 and 7), and effects on its coefficient."""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import (
    depends_on_slip,
    friction_factor,
    is_proportional,
    list_effects,
    list_shapes,
    pressure_on_sheets,
)
from layerjam.brake.mechanics.law import keep_if, law
from layerjam.brake.mechanics.slip_effects import Sheets, friction_force, scale_friction
from layerjam.brake.mechanics.speed_effects import brake_growth, fix_speed


def friction_per_contact(vacuum: Any, brake: Brake) -> Any:
    """Return the friction per metre of overlap c [N/m] of all interfaces together.

    It includes the calibration factor and `friction_factor`. With a `speed_law` the value applies
    at its `test_speed`; multiply it by `growth` for a different speed.
    """
    c = brake.scale_factor * brake.film.kinetic * (brake.sheets.count - 1)
    c = c * brake.sheets.width
    if not list_effects(brake):
        return c * vacuum
    c = c * pressure_on_sheets(vacuum, brake) * friction_factor(vacuum, brake)
    return c if is_proportional(brake) else xp.where(vacuum > 0, c, 0.0)


def sheet_law(vacuum: Any, brake: Brake) -> Sheets:
    """Return the friction law of the sheets at a vacuum [Pa]."""
    c: Any = friction_per_contact(vacuum, brake)
    shapes = list_shapes(friction_factor(vacuum, brake), brake) if depends_on_slip(brake) else ()
    return Sheets(c, brake.sheets.overlap, shapes)


def static_law(vacuum: Any, brake: Brake) -> Sheets:
    """Return the same law with static friction, which the fan amplifies more."""
    sheets: Sheets = scale_friction(
        sheet_law(vacuum, brake), brake.film.static / brake.film.kinetic
    )
    return sheets


def slides(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return whether a brake can slide at a slip [m] and vacuum [Pa]: not beyond the overlap."""
    end = brake.sheets.overlap * (1 + 1e-9)  # rounding may exceed the end of the overlap
    return (slip >= 0) & (slip <= end) & (vacuum >= 0)


@law(of_points=True)
def sheet_friction(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the jammed sheets' kinetic friction [N] (eq. 4, 7) at a slip [m] and vacuum [Pa].

    It is zero once the overlap is used up; NaN for a negative slip or vacuum.
    """
    force = friction_force(slip, sheet_law(vacuum, brake))
    return keep_if((slip >= 0) & (vacuum >= 0), force)


@law
def sheet_friction_at(slip: Any, speed: Any, vacuum: Any, brake: Brake) -> Any:
    """Return `sheet_friction` [N] at a sliding speed [m/s]; slip [m] and vacuum [Pa] broadcast.

    NaN for a negative speed. Without a speed law the speed has no effect.
    """
    sheets = scale_friction(sheet_law(vacuum, brake), brake_growth(xp.abs(speed), brake))
    return keep_if((slip >= 0) & (vacuum >= 0) & (speed >= 0), friction_force(slip, sheets))


@law(of_points=True)
def holding_force(vacuum: Any, brake: Brake) -> Any:
    """Return the static friction of the sheets [N] at a vacuum [Pa], which a load must exceed.

    The scale factor multiplies static and kinetic friction alike (ours).
    """
    return keep_if(vacuum >= 0, friction_force(0.0, static_law(vacuum, brake)))


sheets_at, static_at, growth_of, at_speed = sheet_law, static_law, brake_growth, fix_speed
