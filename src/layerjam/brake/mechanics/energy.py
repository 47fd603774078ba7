"""Work and energy of a pull at constant vacuum (paper, eq. 10)."""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.enclosure import brake_enclosure
from layerjam.brake.mechanics.friction import sheet_law, slides
from layerjam.brake.mechanics.law import keep_if, law
from layerjam.brake.mechanics.pull import force_at_elongation, slip_at_elongation
from layerjam.brake.mechanics.slip_effects import friction_work
from layerjam.brake.mechanics.stiffness import working_stiffness


def sheet_work(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the work of the sheets' friction over a slip [J], all of which is heat."""
    return friction_work(xp.zeros_like(slip), slip, sheet_law(vacuum, brake))


@law
def slip_work(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return E(d, P) [J], the external work to slip the brake by d [m] at P [Pa] (eq. 10).

    NaN for a negative slip or vacuum, and beyond the overlap, where the sheets are apart.
    """
    return keep_if(slides(slip, vacuum, brake), work_to(slip, vacuum, brake))


def work_to(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return `slip_work` [J] without its domain: beyond the overlap the enclosure goes on."""
    return sheet_work(slip, vacuum, brake) + brake_enclosure(vacuum, brake).work(slip)


@law
def slip_heat(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the part of `slip_work` that becomes heat [J]; the enclosure stores the rest."""
    heat = sheet_work(slip, vacuum, brake) + brake_enclosure(vacuum, brake).heat(slip)
    return keep_if(slides(slip, vacuum, brake), heat)


@law
def pull_work(elongation: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the external work [J] of a pull from rest to an elongation [m], including F^2/2k.

    Beyond the overlap the sheets are apart, and the work on the enclosure goes on.
    """
    slip = slip_at_elongation(elongation, vacuum, brake)
    force = force_at_elongation(elongation, vacuum, brake)
    return work_to(slip, vacuum, brake) + force**2 / (2 * working_stiffness(brake))


@law
def energy_capacity(brake: Brake) -> Any:
    """Return E for the usable travel at the site's full vacuum [J]."""
    return slip_work(brake.sheets.usable_travel, brake.site.atmosphere, brake)
