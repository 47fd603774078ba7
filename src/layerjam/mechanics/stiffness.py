"""Stiffness of the brake before and during sliding (paper, eq. 1, 2, 6)."""

from typing import Any

import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.law import law


def sides(brake: Brake) -> tuple[Any, Any]:
    """Sheets on the left cap and on the right one, as floats."""
    count = jnp.asarray(brake.sheets.count, jnp.float64)
    return jnp.ceil(count / 2), jnp.floor(count / 2)


def sheet_section(brake: Brake) -> Any:
    """Cross-section of one sheet, W t [m^2]."""
    return brake.sheets.width * brake.sheets.thickness


@law
def stiffness_before_slip(brake: Brake) -> Any:
    """Sheets alone, stuck [N/m]: three springs in series (eq. 1, 2), A1 = ceil(n/2) W t."""
    sheets, rigidity = brake.sheets, brake.film.modulus * sheet_section(brake)
    left, right = sides(brake)
    flexibility = sheets.free_left / left + sheets.overlap / sheets.count
    return rigidity / (flexibility + sheets.free_right / right)


@law
def stiffness_sliding(slip: Any, brake: Brake) -> Any:
    """Sheets alone, sliding [N/m] (eq. 6): (1/k1 + 1/k3)^-1 with free lengths grown by slip [m].

    The paper takes the lengths at rest: slip = 0.
    """
    sheets, rigidity = brake.sheets, brake.film.modulus * sheet_section(brake)
    left, right = sides(brake)
    return rigidity / ((sheets.free_left + slip) / left + (sheets.free_right + slip) / right)


def working_stiffness(brake: Brake) -> Any:
    """k in u = x + F/k [N/m]: as measured, if it was; otherwise that of the stuck sheets."""
    if brake.stiffness_measured is not None:
        return brake.stiffness_measured
    return stiffness_before_slip(brake)


@law
def mount_stiffness(brake: Brake) -> Any:
    """Stiffness of caps and rig [N/m] from 1/k = 1/k_before_slip + 1/k_mount; already part of k.

    Infinite if no stiffness was measured; negative if the measured one exceeds that of the sheets,
    which means that the film's modulus is too low.
    """
    if brake.stiffness_measured is None:
        return jnp.inf
    return 1 / (1 / brake.stiffness_measured - 1 / stiffness_before_slip(brake))
