"""First pull of a brake with a hyperelastic enclosure at one vacuum; rejects all other cases."""

from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.cycle import Cycle
from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.energy import sheet_work
from layerjam.brake.mechanics.friction import sheet_law
from layerjam.brake.mechanics.hyperelastic import largest_slip, make_strip
from layerjam.brake.mechanics.law import law
from layerjam.brake.mechanics.pull import least_stiffness, slip_at_elongation
from layerjam.brake.mechanics.slip_effects import (
    Sheets,
    find_equilibrium,
    friction_force,
    friction_tangent,
)
from layerjam.brake.mechanics.speed_effects import depends_on_speed
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.errors import ProcedureError, QuantityError
from layerjam.core.units import show

Array = np.ndarray[Any, np.dtype[np.float64]]


def check_hyperelastic(vacuum: Array, brake: Brake) -> None:
    """Raise ProcedureError or QuantityError for cases that the hyperelastic law does not cover."""
    if depends_on_speed(brake):
        raise QuantityError.of(
            "hyperelastic",
            "a pull whose friction depends on the speed supports only an enclosure with "
            "a single modulus; use the brake without [hyperelastic], or without "
            "[speed_law]",
        )
    if (np.diff(vacuum) < 0).any():
        raise ProcedureError(
            "procedure: the vacuum falls, which a hyperelastic enclosure does not "
            "support; keep or raise it, or use the brake without [hyperelastic]"
        )


def is_first_pull(elongation: Array, vacuum: Array) -> bool:
    """Return whether the brake is only pulled out, at one vacuum, so that closed forms apply."""
    return bool((np.diff(elongation) >= 0).all() and np.ptp(vacuum) == 0)


@law
def first_peak(vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Return slip [m] and force [N] at the peak, and whether part of the enclosure still rests.

    While part of a face rests, dx/dN = 2 e/q, with slip x, force N, end strain e and friction q per
    length. The force then peaks at e = q divided by the fall of the sheets' friction with slip.
    """
    sheets, strip = sheet_law(vacuum, brake), make_strip(vacuum, brake)
    limit = strip.rubber.strain

    def strain(line: Sheets) -> Any:
        return strip.friction / xp.where(line.c > 0, line.c, strip.friction / limit)

    def top(line: Sheets) -> Any:
        return strip.point_at(xp.minimum(strain(line), limit)).slip

    slip = find_equilibrium(top, 0.0 * vacuum, sheets)
    end = strain(friction_tangent(slip, sheets))
    state = strip.point_at(xp.minimum(end, limit))
    is_inside = (end < limit) & (state.force < 2 * strip.friction * strip.reach)
    is_inside = is_inside & (state.slip < brake.sheets.overlap)
    return state.slip, friction_force(state.slip, sheets) + state.force, is_inside


@law
def first_events(vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Return elongations [m] of onset, peak and separation in first loading.

    If there is no peak while part of the enclosure rests, the peak is at separation.
    """
    k, overlap = working_stiffness(brake), brake.sheets.overlap
    slip, force, inside = first_peak(vacuum, brake)
    onset = friction_force(0.0, sheet_law(vacuum, brake)) / k
    # beyond the fitted strain there is no separation, because the pull fails first
    separation = overlap + enclosure_force(overlap, vacuum, brake) / k
    separation = xp.where(xp.isnan(separation), overlap + onset, separation)
    return onset, xp.where(inside, slip + force / k, separation), separation


@law
def _first_pull_state(elongation: Any, vacuum: Any, brake: Brake) -> tuple[Any, ...]:
    """Return slip [m], forces of brake and enclosure [N], heat and elastic energy [J]."""
    slip = slip_at_elongation(elongation, vacuum, brake)
    k, sleeve = working_stiffness(brake), make_strip(vacuum, brake).load_to(slip)
    force = k * (elongation - slip)
    heat = sheet_work(slip, vacuum, brake) + sleeve.heat
    return slip, force, sleeve.force, heat, sleeve.stored + force**2 / (2 * k)


def overstretch_error(vacuum: float, brake: Brake) -> QuantityError:
    """Return the error to raise for a pull beyond the fitted strain, at a vacuum [Pa]."""
    slip = float(largest_slip(vacuum, brake))
    return QuantityError.of(
        "hyperelastic.strain",
        f"at {show(vacuum, 'Pa')} a slip beyond {show(slip, 'm')} stretches the enclosure "
        "beyond the measured range; reduce the travel, or fit more of its curve",
    )


def first_pull(elongation: Array, vacuum: Array, brake: Brake) -> Cycle:
    """Return the state of a brake along a rising elongation [m], shape (N,), at one vacuum [Pa].

    Raises QuantityError if the enclosure is stretched beyond the fitted strain.
    """
    pressure, k = float(vacuum[0]), float(working_stiffness(brake))
    slip, force, sleeve, heat, energy = map(
        np.asarray, _first_pull_state(elongation, pressure, brake)
    )
    never = np.zeros(len(elongation), bool)
    is_snapped = never
    if k <= float(least_stiffness(pressure, brake)):
        # with too soft a rig, the pull is elastic up to the onset and undefined beyond
        is_snapped = elongation > float(first_events(pressure, brake)[0])
        slip = sleeve = heat = np.where(is_snapped, np.nan, 0.0)
        force = k * elongation + slip
        energy = force**2 / (2 * k)
    elif np.isnan(slip).any():
        raise overstretch_error(pressure, brake)
    return Cycle(
        force=force,
        slip=slip,
        sleeve_force=sleeve,
        work=heat + energy,
        heat=heat,
        stored=energy,
        slack=never,
        closed=never,
        separated=slip >= brake.sheets.overlap * (1 - 1e-12),
        overflow=never,
        snapped=is_snapped,
    )
