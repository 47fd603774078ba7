"""Static friction grows while films rest on each other under load: a logarithm of the hold.

Off unless the brake says how much (`film.ageing`, with the hold `film.static_hold` that its static
friction was measured after); `layerjam ageing` fits it. The load of the hold is taken to be that of
the pull, and a slip to wipe the growth out.
"""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.friction import holding_force
from layerjam.mechanics.law import law, within


def _aged(hold: Any, brake: Brake) -> Any:
    film = brake.film
    if film.ageing is None or film.static_hold is None:
        return film.static + jnp.zeros(jnp.shape(hold))
    rested = hold > 0
    decades = jnp.log10(jnp.where(rested, hold, 1.0) / film.static_hold)
    friction = jnp.maximum(film.static + film.ageing * decades, film.kinetic)
    # the logarithm diverges for a hold of zero, so friction is limited to the kinetic one
    return jnp.where(rested, friction, jnp.where(film.ageing > 0, film.kinetic, film.static))


@law
def aged_static(hold: Any, brake: Brake) -> Any:
    """Static friction [-] after a hold [s]: mu_s + B log10(hold/static_hold), at least mu_k.

    mu_s at every hold where the brake does not say how it ages. NaN for a negative hold.
    """
    return within(hold >= 0, _aged(hold, brake))


@law
def aged_holding_force(hold: Any, vacuum: Any, brake: Brake) -> Any:
    """Static friction of the sheets [N] after resting jammed for a hold [s]; vacuum [Pa].

    `holding_force` with the static friction that has grown: sheets without spacers amplify it by
    more, since their factor grows with friction. NaN for a negative hold or vacuum.
    """
    aged_brake = replace(brake, film=replace(brake.film, static=_aged(hold, brake)))
    return within(hold >= 0, holding_force(vacuum, aged_brake))
