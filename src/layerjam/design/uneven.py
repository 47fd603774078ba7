"""Calibrated brakes beside brakes that are not: what that does to a comparison. Loads no JAX."""

from __future__ import annotations

from collections.abc import Sequence

from layerjam.device.file import BrakeFile
from layerjam.errors import Notice

WITH_FACTOR = ("max_force", "holding_force", "force_density", "energy_capacity", "peak_vacuum")
"""Numbers of a brake that its scale factor moves."""


def uneven(files: Sequence[BrakeFile]) -> list[Notice]:
    """Said where brakes are compared of which some are calibrated and some are not."""
    with_pulls, without = (
        list(dict.fromkeys(f.name for f in files if f.calibrated is is_so))
        for is_so in (True, False)
    )
    if not (with_pulls and without):
        return []
    one = len(without) == 1
    return [
        Notice(
            f"{', '.join(with_pulls)} {'is' if len(with_pulls) == 1 else 'are'} calibrated, "
            f"{', '.join(without)} {'is' if one else 'are'} not: the forces of "
            f"{'that brake' if one else 'those brakes'} rest on a scale factor that no pull has "
            "shown (the paper's two are 0.875 and 1.24), so a difference of some 20 % says nothing",
            "calibrated-with-uncalibrated",
        )
    ]
