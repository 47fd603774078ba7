"""Ageing: while films rest under load, static friction grows with the logarithm of the hold.

It is included only if the brake states the growth (`film.ageing`, with the hold `film.static_hold`
after which its static friction was measured); `layerjam ageing` fits it. The load during the hold
is assumed to equal that of the pull; a slip is assumed to erase the growth.
"""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.friction import holding_force
from layerjam.brake.mechanics.law import keep_if, law
from layerjam.core.evolve import evolve


def _grow_static_friction(hold: Any, brake: Brake) -> Any:
    film = brake.film
    if film.ageing is None or film.static_hold is None:
        return film.static + xp.zeros(xp.shape(hold))
    rested = hold > 0
    decades = xp.log10(xp.where(rested, hold, 1.0) / film.static_hold)
    friction = xp.maximum(film.static + film.ageing * decades, film.kinetic)
    # the logarithm diverges for a hold of zero, so static friction is kept at or above kinetic
    return xp.where(rested, friction, xp.where(film.ageing > 0, film.kinetic, film.static))


@law
def aged_static(hold: Any, brake: Brake) -> Any:
    """Return static friction [-] after a hold [s]: mu_s + B log10(hold/static_hold), at least mu_k.

    It is mu_s at every hold if the brake does not state its ageing. NaN for a negative hold.
    """
    return keep_if(hold >= 0, _grow_static_friction(hold, brake))


@law
def aged_holding_force(hold: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the sheets' static friction [N] after resting for a hold [s] at a vacuum [Pa].

    This is `holding_force` with the increased static friction. Sheets without spacers amplify it
    more, since their factor grows with friction. NaN for a negative hold or vacuum.
    """
    aged_brake = evolve(brake, film=evolve(brake.film, static=_grow_static_friction(hold, brake)))
    return keep_if(hold >= 0, holding_force(vacuum, aged_brake))
