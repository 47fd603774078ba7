"""Friction of the jammed sheets (paper, eq. 4 and 7), and effects on its coefficient."""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.device.speed_law import SpeedLaw
from layerjam.mechanics.fan import Sheets, fan_force, make_fan, scale_friction
from layerjam.mechanics.law import keep_if, law


def pressure_on_sheets(vacuum: Any, brake: Brake) -> Any:
    """Return the pressure on the sheets [Pa] if the gauge reads a vacuum [Pa].

    It is lower than the vacuum if the vacuum does not reach the middle of the stack. The enclosure
    is pressed by the full vacuum, because the atmosphere acts on its other side.
    """
    return vacuum if brake.vacuum_share is None else brake.vacuum_share * vacuum


def friction_per_contact(vacuum: Any, brake: Brake) -> Any:
    """Return the friction per metre of overlap c [N/m] of all interfaces together.

    It includes the calibration factor and `friction_factor`. With a `speed_law` the value applies
    at its `test_speed`; multiply it by `growth` for a different speed.
    """
    c = brake.scale_factor * brake.film.kinetic * (brake.sheets.count - 1)
    c = c * brake.sheets.width * pressure_on_sheets(vacuum, brake)
    if is_proportional(brake):
        return c
    return jnp.where(vacuum > 0, c * friction_factor(vacuum, brake), 0.0)


def is_proportional(brake: Brake) -> bool:
    """Return whether the friction is known to be proportional to the vacuum."""
    return brake.pressure_exponent is None and not brake.effects


def friction_factor(vacuum: Any, brake: Brake) -> Any:
    """Return the friction coefficient at a vacuum [Pa] with all effects, relative to the film's."""
    factor = _pressure_factor(vacuum, brake)
    for effect in brake.effects:
        factor = factor * effect.friction_factor(vacuum, brake)
    return factor


def _pressure_factor(vacuum: Any, brake: Brake) -> Any:
    """Return the friction coefficient at a vacuum [Pa], relative to that at the test pressure.

    It is (P/P_test)^m with the pressure P on the sheets and a fitted `pressure_exponent` m (ours),
    or 1 if none was fitted. Below `lowest_pressure` it is constant.
    """
    if brake.pressure_exponent is None:
        return 1.0
    test: Any = brake.test_pressure
    pressure = jnp.where(vacuum > 0, pressure_on_sheets(vacuum, brake), test)
    if brake.lowest_pressure is not None:
        pressure = jnp.maximum(pressure, brake.lowest_pressure)
    return (pressure / test) ** brake.pressure_exponent


def sheet_law(vacuum: Any, brake: Brake) -> Sheets:
    """Return the friction law of the sheets at a vacuum [Pa]."""
    c: Any = friction_per_contact(vacuum, brake)
    fan = make_fan(brake, friction_factor(vacuum, brake))
    return Sheets(c, brake.sheets.overlap, fan)


def static_law(vacuum: Any, brake: Brake) -> Sheets:
    """Return the same law with static friction, which the fan amplifies more."""
    sheets: Sheets = scale_friction(
        sheet_law(vacuum, brake), brake.film.static / brake.film.kinetic
    )
    return sheets


def growth(speed: Any, law: SpeedLaw) -> Any:
    """Return the friction at a speed [m/s] >= 0, relative to that at the law's `test_speed`."""
    return ((law.rest_speed + speed) / (law.rest_speed + law.test_speed)) ** law.power


def brake_growth(speed: Any, brake: Brake) -> Any:
    """Return `growth` of a brake; 1 if it has no speed law."""
    return 1.0 if brake.speed_law is None else growth(speed, brake.speed_law)


def fix_speed(speed: Any, brake: Brake) -> Brake:
    """Return the brake with the sheets' friction fixed at its value for a speed [m/s]."""
    if brake.speed_law is None:
        return brake
    kinetic: Any = growth(speed, brake.speed_law) * brake.film.kinetic
    return replace(brake, film=replace(brake.film, kinetic=kinetic), speed_law=None)


@law
def sheet_friction(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the jammed sheets' kinetic friction [N] (eq. 4, 7) at a slip [m] and vacuum [Pa].

    It is zero once the overlap is used up; NaN for a negative slip or vacuum.
    """
    force = fan_force(slip, sheet_law(vacuum, brake))
    return keep_if((slip >= 0) & (vacuum >= 0), force)


@law
def sheet_friction_at(slip: Any, speed: Any, vacuum: Any, brake: Brake) -> Any:
    """Return `sheet_friction` [N] at a sliding speed [m/s]; slip [m] and vacuum [Pa] broadcast.

    NaN for a negative speed. Without a speed law the speed has no effect.
    """
    sheets = scale_friction(sheet_law(vacuum, brake), brake_growth(jnp.abs(speed), brake))
    return keep_if((slip >= 0) & (vacuum >= 0) & (speed >= 0), fan_force(slip, sheets))


@law
def holding_force(vacuum: Any, brake: Brake) -> Any:
    """Return the static friction of the sheets [N] at a vacuum [Pa], which a load must exceed.

    The scale factor multiplies static and kinetic friction alike (ours).
    """
    return keep_if(vacuum >= 0, fan_force(0.0, static_law(vacuum, brake)))


sheets_at, static_at, growth_of, at_speed = sheet_law, static_law, brake_growth, fix_speed
