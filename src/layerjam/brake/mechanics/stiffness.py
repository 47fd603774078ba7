"""Stiffness of the brake before and during sliding (paper, eq. 1, 2, 6)."""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.law import law


def count_sides(brake: Brake) -> tuple[Any, Any]:
    """Return the numbers of sheets on the left and on the right cap, as floats."""
    count = xp.asarray(brake.sheets.count, xp.float64)
    return xp.ceil(count / 2), xp.floor(count / 2)


def sheet_section(brake: Brake) -> Any:
    """Return the cross-section of one sheet, W t [m^2]."""
    return brake.sheets.width * brake.sheets.thickness


@law
def stiffness_before_slip(brake: Brake) -> Any:
    """Return the stiffness of the stuck sheets alone [N/m], three springs in series (eq. 1, 2)."""
    sheets, rigidity = brake.sheets, brake.film.modulus * sheet_section(brake)
    left, right = count_sides(brake)
    flexibility = sheets.free_left / left + sheets.overlap / sheets.count
    return rigidity / (flexibility + sheets.free_right / right)


@law
def stiffness_sliding(slip: Any, brake: Brake) -> Any:
    """Return the stiffness of the sliding sheets alone [N/m] (eq. 6); slip [m].

    It is (1/k1 + 1/k3)^-1 with free lengths increased by the slip. The paper uses the lengths at
    rest: slip = 0.
    """
    sheets, rigidity = brake.sheets, brake.film.modulus * sheet_section(brake)
    left, right = count_sides(brake)
    return rigidity / ((sheets.free_left + slip) / left + (sheets.free_right + slip) / right)


def working_stiffness(brake: Brake) -> Any:
    """Return k in u = x + F/k [N/m]: as measured, otherwise that of the stuck sheets."""
    if brake.stiffness_measured is not None:
        return brake.stiffness_measured
    return stiffness_before_slip(brake)


@law
def mount_stiffness(brake: Brake) -> Any:
    """Return the stiffness of caps and rig [N/m] from 1/k = 1/k_before_slip + 1/k_mount.

    It is already part of k. Infinite if no stiffness was measured; negative if the measured one
    exceeds that of the sheets, because the film's modulus is then too low.
    """
    if brake.stiffness_measured is None:
        return xp.inf
    return 1 / (1 / brake.stiffness_measured - 1 / stiffness_before_slip(brake))
