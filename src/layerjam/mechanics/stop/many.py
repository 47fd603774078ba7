"""Exact stops by the million: for which brakes, and over which grid, `loops` runs."""

from typing import Any, NamedTuple

import numpy as np

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import enclosure_at
from layerjam.mechanics.friction import friction_per_contact, is_proportional

Array = np.ndarray[Any, Any]


class Axis(NamedTuple):
    """One quantity over a flat grid: drop i has `values[(i // stride) % len(values)]`."""

    values: Array
    stride: int


class Constants(NamedTuple):
    """What the loop needs of a brake; SI."""

    friction: float
    """c per pascal [N/m/Pa]."""
    drag: float
    """q per pascal [N/m/Pa]."""
    overlap: float
    travel: float
    stiffness: float
    reach: float


def constants_of(brake: Brake) -> Constants | None:
    """Return the constants of a brake for the compiled loops, or None if they lack its laws."""
    bent = (brake.speed_law, brake.hyperelastic, brake.mount.spacers)
    if any(part is not None for part in bent) or not is_proportional(brake):
        return None
    enclosure = enclosure_at(1.0, brake)
    sheets, c = brake.sheets, friction_per_contact(1.0, brake)
    values = (c, enclosure.friction, sheets.overlap, sheets.usable_travel)
    return Constants(*(float(v) for v in (*values, enclosure.stiffness, enclosure.reach)))
