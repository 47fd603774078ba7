"""Friction of a brake as a function of the sliding speed, from all effects that depend on it."""

import math
from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import list_effects
from layerjam.core.evolve import evolve


def brake_growth(speed: Any, brake: Brake) -> Any:
    """Return the friction at a speed [m/s] >= 0, relative to that in the tests of all effects."""
    factor: Any = 1.0
    for effect in list_effects(brake):
        factor = factor * effect.growth(speed, brake)
    return factor


def growth_slope(speed: Any, brake: Brake) -> Any:
    """Return the slope of the logarithm of `brake_growth` versus the speed [s/m] at a speed [m/s].

    Without a dependence on speed it is that of friction proportional to v_0 + v, so that a solver
    ends also in those cases of a batch that it does not use.
    """
    slope: Any = 0.0
    for effect in list_effects(brake):
        slope = slope + effect.growth_slope(speed, brake)
    return xp.where(slope > 0, slope, 1 / (rest_speed(brake) + speed))


def rest_speed(brake: Brake) -> Any:
    """Return the speed [m/s] far below which the friction no longer depends on the speed."""
    slowest: Any = xp.inf
    for effect in list_effects(brake):
        slowest = xp.minimum(slowest, effect.rest_speed(brake))
    return slowest


def has_speed_effects(brake: Brake) -> bool:
    """Return whether the brake states an effect of the speed, even one of a power of 0."""
    return any(effect.depends_on_speed for effect in list_effects(brake))


def name_speed_effects(brake: Brake) -> str:
    """Return the tables that state how friction depends on speed, "[speed_law]"; "" for none."""
    return " and ".join(f"[{e.table}]" for e in list_effects(brake) if e.depends_on_speed)


def test_speed(brake: Brake) -> float:
    """Return the highest speed [m/s] at which friction has the film's coefficient."""
    return max((e.test_speed(brake) for e in list_effects(brake) if e.depends_on_speed), default=0)


def fastest_speed(brake: Brake) -> float:
    """Return the highest speed [m/s] up to which friction was measured; infinite if unstated."""
    return min((effect.fastest_speed(brake) for effect in list_effects(brake)), default=math.inf)


def depends_on_speed(brake: Brake) -> Any:
    """Return whether the friction depends on the sliding speed; numbers may be arrays."""
    active: Any = False
    for effect in list_effects(brake):
        if effect.depends_on_speed:
            active = active | effect.is_active(brake)
    return active


def fix_speed(speed: Any, brake: Brake) -> Brake:
    """Return the brake with the sheets' friction fixed at its value for a speed [m/s]."""
    for effect in list_effects(brake):
        if effect.depends_on_speed:
            kinetic: Any = effect.growth(speed, brake) * brake.film.kinetic
            brake = effect.remove(evolve(brake, film=evolve(brake.film, kinetic=kinetic)))
    return brake


def ignore_speed(brake: Brake) -> Brake:
    """Return the brake with the friction of the test speed at every speed."""
    for effect in list_effects(brake):
        if effect.depends_on_speed:
            brake = effect.remove(brake)
    return brake


def remove_idle_speed_law(brake: Brake) -> Brake:
    """Return the brake without a dependence on speed that has no effect."""
    return brake if depends_on_speed(brake) else ignore_speed(brake)
