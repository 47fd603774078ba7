"""One pull out at one vacuum of a brake whose enclosure is hyperelastic."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import ProcedureError, QuantityError
from layerjam.mechanics.enclosure import first_loading
from layerjam.mechanics.energy import sheet_work
from layerjam.mechanics.fan import Sheets, along_tangents, force_of, tangent
from layerjam.mechanics.friction import sheets_at
from layerjam.mechanics.hyperelastic import at_slip, greatest_slip, stretched, strip_at
from layerjam.mechanics.hysteresis import Cycle
from layerjam.mechanics.law import law
from layerjam.mechanics.pull import least_stiffness, slip_at_elongation
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.speed import follows_speed
from layerjam.units import show

Array = np.ndarray[Any, np.dtype[np.float64]]


def check_first_pull(elongation: Array, vacuum: Array, brake: Brake) -> None:
    """Raise ProcedureError for what a hyperelastic enclosure has no law of."""
    if follows_speed(brake):
        raise QuantityError.of(
            "hyperelastic",
            "a pull whose friction depends on the speed takes the enclosure's one modulus only; "
            "use the brake without [hyperelastic], or without [speed_law]",
        )
    if (np.diff(elongation) < 0).any() or np.ptp(vacuum) > 0:
        raise ProcedureError(
            "procedure: a hyperelastic enclosure is followed in one pull out at one vacuum; "
            "returns, cycles and a change of vacuum need the brake without [hyperelastic]"
        )


@law
def first_events(vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Elongations [m] at onset, at the peak and at separation, in first loading.

    While part of a face rests dx/dN = 2 e/q, so that the force peaks where the strain at the ends
    is q over the fall of the sheets' friction. Without such a peak separation stands in for it.
    """
    k, overlap = working_stiffness(brake), brake.sheets.overlap
    sheets, strip = sheets_at(vacuum, brake), strip_at(vacuum, brake)
    most = strip.rubber.strain

    def strain(line: Sheets) -> Any:
        return strip.friction / jnp.where(line.c > 0, line.c, strip.friction / most)

    def top(line: Sheets) -> Any:
        return stretched(jnp.minimum(strain(line), most), strip).slip

    slip = along_tangents(top, 0.0 * vacuum, sheets)
    end = strain(tangent(slip, sheets))
    at = stretched(jnp.minimum(end, most), strip)
    inside = (end < most) & (at.force < 2 * strip.friction * strip.reach) & (at.slip < overlap)
    peak = at.slip + (force_of(at.slip, sheets) + at.force) / k
    onset = force_of(0.0, sheets) / k
    # beyond the strain that was fitted no separation is reached: the pull ends in an error before
    apart = overlap + first_loading(overlap, vacuum, brake) / k
    apart = jnp.where(jnp.isnan(apart), overlap + onset, apart)
    return onset, jnp.where(inside, peak, apart), apart


@law
def _pulled(elongation: Any, vacuum: Any, brake: Brake) -> tuple[Any, ...]:
    """Slip [m], forces of brake and enclosure [N], heat and elastic energy [J]."""
    slip = slip_at_elongation(elongation, vacuum, brake)
    k, sleeve = working_stiffness(brake), at_slip(slip, vacuum, brake)[1]
    force = k * (elongation - slip)
    heat = sheet_work(slip, vacuum, brake) + sleeve.heat
    return slip, force, sleeve.force, heat, sleeve.stored + force**2 / (2 * k)


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
        most = float(greatest_slip(pressure, brake))
        raise QuantityError.of(
            "hyperelastic.strain",
            f"at {show(pressure, 'Pa')} a slip beyond {show(most, 'm')} stretches the "
            "enclosure more than was measured; pull less far, or fit more of its curve",
        )
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
