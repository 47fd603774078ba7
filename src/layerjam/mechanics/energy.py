"""Work and energy of a pull at constant vacuum (paper, eq. 10)."""

from typing import Any

import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import brake_enclosure
from layerjam.mechanics.fan import fan_work
from layerjam.mechanics.friction import sheet_law
from layerjam.mechanics.law import keep_if, law
from layerjam.mechanics.pull import slip_at_elongation
from layerjam.mechanics.stiffness import working_stiffness


def sheet_work(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the work of the sheets' friction over a slip [J], all of which is heat."""
    return fan_work(jnp.zeros_like(slip), slip, sheet_law(vacuum, brake))


@law
def slip_work(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return E(d, P) [J], the external work to slip the brake by d [m] at P [Pa] (eq. 10)."""
    work = sheet_work(slip, vacuum, brake) + brake_enclosure(vacuum, brake).work(slip)
    return keep_if((slip >= 0) & (vacuum >= 0), work)


@law
def slip_heat(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the part of `slip_work` that becomes heat [J]; the enclosure stores the rest."""
    heat = sheet_work(slip, vacuum, brake) + brake_enclosure(vacuum, brake).heat(slip)
    return keep_if((slip >= 0) & (vacuum >= 0), heat)


@law
def pull_work(elongation: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the external work [J] of a pull from rest to an elongation [m], including F^2/2k."""
    slip = slip_at_elongation(elongation, vacuum, brake)
    k = working_stiffness(brake)
    return slip_work(slip, vacuum, brake) + k * (elongation - slip) ** 2 / 2


@law
def energy_capacity(brake: Brake) -> Any:
    """Return E for the usable travel at the site's full vacuum [J]."""
    return slip_work(brake.sheets.usable_travel, brake.site.atmosphere, brake)
