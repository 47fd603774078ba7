"""Limits of a brake: compression, stress, travel."""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import is_proportional
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.fan import tension_ratio
from layerjam.brake.mechanics.friction import holding_force, sheet_law
from layerjam.brake.mechanics.law import keep_if, law, safe_sqrt
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.mechanics.roots import implicit_root
from layerjam.brake.mechanics.slip_effects import friction_force
from layerjam.brake.mechanics.stiffness import sheet_section


@law
def buckling_force(slip: Any, brake: Brake) -> Any:
    """Return the compression [N] at which one sheet buckles over its free length.

    Euler's formula for one free end is pi^2 E I/(4 L^2), with L the longer free length plus the
    slip [m].
    """
    sheets = brake.sheets
    inertia = sheets.width * sheets.thickness**3 / 12
    length = xp.maximum(sheets.free_left, sheets.free_right) + slip
    return xp.pi**2 * brake.film.modulus * inertia / (4 * length**2)


@law
def sheet_stress(force: Any, brake: Brake) -> Any:
    """Return the tensile stress [Pa] in the free part of the side with fewer sheets at a force [N].

    The sheets share the force equally; if they fan out, the stress is that of the middle one, which
    carries the most.
    """
    force = force * tension_ratio(brake)
    return force / (xp.floor(brake.sheets.count / 2) * sheet_section(brake))


def greatest_force(brake: Brake) -> Any:
    """Return the largest force [N] at the site's full vacuum, including static friction."""
    vacuum = brake.site.atmosphere
    top = peak(vacuum, brake.sheets.usable_travel, brake).force
    return xp.maximum(top, holding_force(vacuum, brake))


@law
def clamp_stress(force: Any, brake: Brake) -> Any:
    """Return the tensile stress [Pa] at a force [N] in the net section at that side's screw holes.

    The sheets share the force as in `sheet_stress`. The holes are side by side, so the section is
    reduced by all of them.
    """
    force, width = force * tension_ratio(brake), brake.sheets.width
    holes = brake.mount.count_screws(width) * brake.mount.screw_hole
    net = (width - holes) * brake.sheets.thickness
    return force / (xp.floor(brake.sheets.count / 2) * net)


@law
def travel_left(slip: Any, brake: Brake) -> Any:
    """Return the slip [m] that remains before the sheets separate; negative afterwards."""
    return brake.sheets.overlap - slip


@law
def self_closing_vacuum(slip: Any, brake: Brake) -> Any:
    """Return the vacuum [Pa] below which the enclosure closes an unloaded brake at a slip [m].

    It solves F_e = F_f: P = (e_1/c_1)^2 x/(L2 - x)^2 before saturation, otherwise an equation
    linear in P. Infinite if friction can never hold the enclosure.
    """
    unit = enclosure_law(1.0, brake)
    contact = xp.maximum(brake.sheets.overlap - slip, 0.0)
    if not is_proportional(brake):
        return _search_closing_vacuum(slip, brake)
    c1 = friction_force(slip, sheet_law(1.0, brake))
    spread = (unit.root * safe_sqrt(slip) / xp.where(contact > 0, c1, 1.0)) ** 2
    net_slope = c1 - unit.friction * unit.reach
    linear = unit.stiffness * slip / unit.reach / xp.where(net_slope > 0, net_slope, 1.0)
    spreads = (contact > 0) & (slip < spread * unit.saturation)
    closing = xp.where(spreads, spread, xp.where(net_slope > 0, linear, xp.inf))
    return keep_if(slip >= 0, xp.where(slip == 0, 0.0, closing))


def _search_closing_vacuum(slip: Any, brake: Brake) -> Any:
    """Return the same vacuum for other friction laws, found by a search over log P."""

    def excess_friction(log_vacuum: Any) -> Any:
        vacuum = xp.exp(log_vacuum)
        friction = friction_force(slip, sheet_law(vacuum, brake))
        return friction - enclosure_law(vacuum, brake).force(slip)

    top = xp.log(brake.site.atmosphere) + xp.zeros(xp.shape(slip))
    vacuum = xp.exp(implicit_root(excess_friction, top - 30.0, top))
    closing = xp.where(excess_friction(top) >= 0, vacuum, xp.inf)
    return keep_if(slip >= 0, xp.where(slip == 0, 0.0, closing))
