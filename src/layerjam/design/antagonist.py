"""Two brakes over a pulley: a brake that works both ways (paper, section II-A).

Turning the pulley by an angle pulls one brake and slackens the other. Tension only: a slack brake
carries nothing.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.kernel.engine import follow_history
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.units import QuantitySpec

RADIUS = QuantitySpec("m", "radius of the pulley", open_lo=True, hi=10)
STRETCH = QuantitySpec("m", "elongation of both brakes at no angle", hi=1)


class Pair(NamedTuple):
    """An antagonistic pair along a history of angles, each of shape (N,)."""

    angle: np.ndarray
    """[rad]"""
    torque: np.ndarray
    """Resisting the turn, (F1 - F2) r [N m]: positive where brake 1 pulls the harder."""
    forces: np.ndarray
    """[N], shape (N, 2)"""
    slips: np.ndarray
    """[m], shape (N, 2)"""
    work: np.ndarray
    """Work done on the pair by the shaft and, before, by the pretension [J]."""
    heat: np.ndarray
    """Energy dissipated so far [J]."""
    stored: np.ndarray
    """Elastic energy held now [J]."""


def pair(
    brakes: tuple[Brake, Brake],
    vacuums: tuple[float, float],
    angle: Any,
    radius: float,
    pretension: float = 0.0,
) -> Pair:
    """Turn a pulley of a radius [m] through a history of angles [rad], slowly.

    Both brakes start stretched by `pretension` [m of elongation] at angle zero; then
    u1 = pretension + r angle and u2 = pretension - r angle, and the torque is (F1 - F2) r. With
    both taut and stuck the stiffness about neutral is (k1 + k2) r^2. What slips, sticks and turns
    is the brake's own law with its memory (`brake_cycle`), at constant vacuums [Pa].

    Raises QuantityError for angles not finite, a radius or pretension out of bounds, a vacuum
    above the site's atmosphere, or where a brake comes apart or snaps.
    """
    RADIUS.check(radius, "radius")
    STRETCH.check(pretension, "pretension")
    turns = np.atleast_1d(np.asarray(angle, float))
    if turns.ndim != 1 or not np.isfinite(turns).all():
        raise QuantityError("angle: a list of finite angles in radians is needed")
    made = []
    for number, (brake, vacuum, sign) in enumerate(zip(brakes, vacuums, (1, -1), strict=True), 1):
        most = brake.site.atmosphere
        QuantitySpec("Pa", "vacuum up to the atmosphere", hi=most).check(vacuum, f"vacuum {number}")
        # from no load to the pretension, then the angles
        elongation = np.concatenate([[0.0, pretension], pretension + sign * radius * turns])
        # shorter than at rest it is slack, as at rest: nothing of it moves there
        elongation = np.maximum(elongation, 0.0)
        cycle, _ = follow_history(elongation, np.full(len(elongation), float(vacuum)), brake)
        wrong = {"comes apart": cycle.separated, "snaps on its stiffness": cycle.snapped}
        for what, where in wrong.items():
            if where.any():
                raise QuantityError(f"angle: brake {number} {what} on this history")
        if cycle.overflow.any():
            raise QuantityError(f"angle: too many turns nested in each other for brake {number}")
        made.append(cycle)
    one, two = made
    forces = np.column_stack([one.force, two.force])[2:]
    return Pair(
        turns,
        (forces[:, 0] - forces[:, 1]) * radius,
        forces,
        np.column_stack([one.slip, two.slip])[2:],
        (one.work + two.work)[2:],
        (one.heat + two.heat)[2:],
        (one.stored + two.stored)[2:],
    )


def neutral_stiffness(brakes: tuple[Brake, Brake], radius: float) -> float:
    """(k1 + k2) r^2 [N m/rad]: both taut and stuck; radius [m]."""
    RADIUS.check(radius, "radius")
    return sum(float(working_stiffness(b)) for b in brakes) * radius**2
