"""Pulls that the plain law does not give: static friction that is higher, seats that give way.

The sheets' friction begins higher by a part that fades exponentially with slip; grips and caps give
way under the first load by s(F) = seating (1 - exp(-F/F1)). The elongation is slip + F/k + s(F).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.lab.faults import Faults
from layerjam.measure.trace import Array

HALVINGS = 60


def gripped(
    stretch: Array,
    vacuum: Array,
    brake: Brake,
    spring: Array,
    overshoot: Array,
    seating: Array,
    machine: Faults,
) -> tuple[Array, Array]:
    """(slip [m], force [N]) at an elongation `stretch` [m] from where the brake is taut, (M, N).

    `spring` [N/m], `overshoot` [-] and `seating` [m] have shape (M, 1). Raises QuantityError where
    the friction would fall faster than spring and seat can follow.
    """
    from layerjam.mechanics.friction import sheet_friction
    from layerjam.mechanics.pull import brake_force

    def resists(slip: Array) -> Array:
        more = overshoot * np.exp(-slip / machine.overshoot_slip)
        sheets = np.asarray(sheet_friction(slip, vacuum, brake))
        return np.asarray(brake_force(slip, vacuum, brake)) + more * sheets

    def gives(force: Array) -> Array:
        return force / spring + seating * -np.expm1(-force / machine.seating_force)

    first = resists(np.zeros_like(stretch))
    softest = 1 / spring + seating / machine.seating_force
    if (overshoot * first / machine.overshoot_slip * softest >= 1).any():
        raise QuantityError.of(
            "overshoot",
            "the friction would fall faster than the mount can follow, so that the brake snaps; "
            "let it fade over more slip (machine.overshoot_slip)",
        )
    stuck = _root(lambda force: gives(force) - stretch, np.zeros_like(stretch), first)
    slip = _root(lambda x: x + gives(resists(x)) - stretch, np.zeros_like(stretch), stretch)
    slides = gives(first) < stretch
    slip = np.where(slides, slip, 0.0)
    return slip, np.where(slides, resists(slip), stuck)


def _root(of: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Where a rising function of arrays is zero between two arrays, by bisection."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        below = of(middle) < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.asarray((low + high) / 2)
