"""A brake whose enclosure is hyperelastic: one pull out at one vacuum, and what is refused."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import ProcedureError, QuantityError
from layerjam.mechanics.cycle import Cycle
from layerjam.mechanics.enclosure import first_loading
from layerjam.mechanics.energy import sheet_work
from layerjam.mechanics.fan import Sheets, along_tangents, force_of, tangent
from layerjam.mechanics.friction import sheets_at
from layerjam.mechanics.hyperelastic import at_slip, greatest_slip, stretched, strip_at
from layerjam.mechanics.law import law
from layerjam.mechanics.pull import least_stiffness, slip_at_elongation
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.speed import follows_speed
from layerjam.units import show

Array = np.ndarray[Any, np.dtype[np.float64]]


def check_hyperelastic(vacuum: Array, brake: Brake) -> None:
    """Raise ProcedureError or QuantityError for what a hyperelastic enclosure has no law of."""
    if follows_speed(brake):
        raise QuantityError.of(
            "hyperelastic",
            "a pull whose friction depends on the speed takes the enclosure's one modulus only; "
            "use the brake without [hyperelastic], or without [speed_law]",
        )
    if (np.diff(vacuum) < 0).any():
        raise ProcedureError(
            "procedure: the vacuum falls, and what a hyperelastic enclosure does then is not "
            "known; keep or raise it, or use the brake without [hyperelastic]"
        )


def is_first_pull(elongation: Array, vacuum: Array) -> bool:
    """Whether the brake is only pulled out, at one vacuum: closed forms hold then."""
    return bool((np.diff(elongation) >= 0).all() and np.ptp(vacuum) == 0)


@law
def first_peak(vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Slip [m], force [N] at the peak of a first pull, and whether it comes while a part rests.

    While part of a face rests dx/dN = 2 e/q, so that the force peaks where the strain at the ends
    is q over the fall of the sheets' friction.
    """
    sheets, strip = sheets_at(vacuum, brake), strip_at(vacuum, brake)
    most = strip.rubber.strain

    def strain(line: Sheets) -> Any:
        return strip.friction / jnp.where(line.c > 0, line.c, strip.friction / most)

    def top(line: Sheets) -> Any:
        return stretched(jnp.minimum(strain(line), most), strip).slip

    slip = along_tangents(top, 0.0 * vacuum, sheets)
    end = strain(tangent(slip, sheets))
    at = stretched(jnp.minimum(end, most), strip)
    inside = (end < most) & (at.force < 2 * strip.friction * strip.reach)
    inside = inside & (at.slip < brake.sheets.overlap)
    return at.slip, force_of(at.slip, sheets) + at.force, inside


@law
def first_events(vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Elongations [m] at onset, at the peak and at separation, in first loading.

    Without a peak while a part of the enclosure rests, separation stands in for it.
    """
    k, overlap = working_stiffness(brake), brake.sheets.overlap
    slip, force, inside = first_peak(vacuum, brake)
    onset = force_of(0.0, sheets_at(vacuum, brake)) / k
    # beyond the strain that was fitted no separation is reached: the pull ends in an error before
    apart = overlap + first_loading(overlap, vacuum, brake) / k
    apart = jnp.where(jnp.isnan(apart), overlap + onset, apart)
    return onset, jnp.where(inside, slip + force / k, apart), apart


@law
def _pulled(elongation: Any, vacuum: Any, brake: Brake) -> tuple[Any, ...]:
    """Slip [m], forces of brake and enclosure [N], heat and elastic energy [J]."""
    slip = slip_at_elongation(elongation, vacuum, brake)
    k, sleeve = working_stiffness(brake), at_slip(slip, vacuum, brake)[1]
    force = k * (elongation - slip)
    heat = sheet_work(slip, vacuum, brake) + sleeve.heat
    return slip, force, sleeve.force, heat, sleeve.stored + force**2 / (2 * k)


def overstretched(vacuum: float, brake: Brake) -> QuantityError:
    """That a pull goes beyond the strain that was fitted, at a vacuum [Pa]."""
    most = float(greatest_slip(vacuum, brake))
    return QuantityError.of(
        "hyperelastic.strain",
        f"at {show(vacuum, 'Pa')} a slip beyond {show(most, 'm')} stretches the "
        "enclosure more than was measured; pull less far, or fit more of its curve",
    )


def first_pull(elongation: Array, vacuum: Array, brake: Brake) -> Cycle:
    """The brake along a rising elongation [m], shape (N,), at one vacuum [Pa].

    Raises QuantityError where the enclosure is stretched beyond the strain that was fitted.
    """
    pressure, k = float(vacuum[0]), float(working_stiffness(brake))
    slip, force, sleeve, heat, stored = map(np.asarray, _pulled(elongation, pressure, brake))
    no = np.zeros(len(elongation), bool)
    snapped = no
    if k <= float(least_stiffness(pressure, brake)):
        # too soft a rig: elastic up to the onset, and nothing is told beyond
        snapped = elongation > float(first_events(pressure, brake)[0])
        slip = sleeve = heat = np.where(snapped, np.nan, 0.0)
        force = k * elongation + slip
        stored = force**2 / (2 * k)
    elif np.isnan(slip).any():
        raise overstretched(pressure, brake)
    return Cycle(
        force=force,
        slip=slip,
        sleeve_force=sleeve,
        work=heat + stored,
        heat=heat,
        stored=stored,
        slack=no,
        closed=no,
        separated=slip >= brake.sheets.overlap * (1 - 1e-12),
        overflow=no,
        snapped=snapped,
    )
