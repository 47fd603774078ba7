"""Notice for a comparison of calibrated and uncalibrated brakes; this module does not load JAX."""

from collections.abc import Sequence

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.errors import Notice

WITH_FACTOR = ("max_force", "holding_force", "force_density", "energy_capacity", "peak_vacuum")
"""Quantities of a brake that depend on its scale factor."""


def _split_names(files: Sequence[BrakeFile]) -> tuple[list[str], list[str]]:
    """Return the names of the calibrated brakes, and those of the others."""
    with_pulls, others = (
        list(dict.fromkeys(f.name for f in files if f.is_calibrated is is_so))
        for is_so in (True, False)
    )
    return with_pulls, others


def describe_calibration(files: Sequence[BrakeFile]) -> str | None:
    """Return which of the compared brakes are calibrated; None if all or none are."""
    with_pulls, without_pulls = _split_names(files)
    if not (with_pulls and without_pulls):
        return None
    return f"{', '.join(with_pulls)} calibrated; {', '.join(without_pulls)} not calibrated"


def calibration_notices(files: Sequence[BrakeFile]) -> list[Notice]:
    """Return a notice if only some of the compared brakes are calibrated."""
    with_pulls, without_pulls = _split_names(files)
    if not (with_pulls and without_pulls):
        return []
    is_single = len(without_pulls) == 1
    return [
        Notice(
            f"{', '.join(with_pulls)} {'is' if len(with_pulls) == 1 else 'are'} calibrated, but "
            f"{', '.join(without_pulls)} {'is' if is_single else 'are'} not: the forces of "
            f"{'that brake' if is_single else 'those brakes'} use an unfitted scale "
            "factor (the paper's: 0.875 and 1.24), so differences of about 20 % are meaningless",
            "calibrated-with-uncalibrated",
        )
    ]
