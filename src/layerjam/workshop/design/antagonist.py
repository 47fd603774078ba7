"""Two brakes on one pulley, which together resist rotation both ways (paper, section II-A).

Turning the pulley by an angle pulls one brake and slackens the other. A slack brake carries no
force.
"""

from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.kernel.engine import follow_history
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.errors import QuantityError
from layerjam.core.units import QuantitySpec

RADIUS = QuantitySpec("m", "radius of the pulley", open_lo=True, hi=10)
STRETCH = QuantitySpec("m", "elongation of both brakes at angle zero", hi=1)


class Pair(NamedTuple):
    """Response of an antagonistic pair to a history of N angles; shape (N,) if not stated."""

    angle: np.ndarray
    """Angle [rad]."""
    torque: np.ndarray
    """Resisting torque, (F1 - F2) r [N m]; positive if brake 1 pulls harder."""
    forces: np.ndarray
    """Forces of the two brakes [N], shape (N, 2)."""
    slips: np.ndarray
    """Slips of the two brakes [m], shape (N, 2)."""
    work: np.ndarray
    """Work done by the shaft on the pair, including the pretensioning [J]."""
    heat: np.ndarray
    """Energy dissipated so far [J]."""
    stored: np.ndarray
    """Elastic energy currently stored [J]."""


def pair(
    brakes: tuple[Brake, Brake],
    vacuums: tuple[float, float],
    angle: Any,
    radius: float,
    pretension: float = 0.0,
) -> Pair:
    """Return the response of two brakes while a pulley turns slowly through angles [rad].

    At angle zero, both brakes are already stretched by `pretension` [m]. Their elongations are u1 =
    pretension + r angle and u2 = pretension - r angle, and the torque is (F1 - F2) r, with `radius`
    r [m]. If both are taut without slip, the stiffness about angle zero is (k1 + k2) r^2. Slip and
    reversal follow each brake's own history-dependent law (`brake_cycle`), at constant vacuums
    [Pa].

    Raises QuantityError for angles that are not finite, a radius or pretension out of bounds, a
    vacuum above the site's atmosphere, or if a brake separates or snaps.
    """
    RADIUS.check(radius, "radius")
    STRETCH.check(pretension, "pretension")
    angles = np.atleast_1d(np.asarray(angle, float))
    if angles.ndim != 1 or not np.isfinite(angles).all():
        raise QuantityError("angle: expected a list of finite angles in radians")
    cycles = []
    for number, (brake, vacuum, sign) in enumerate(zip(brakes, vacuums, (1, -1), strict=True), 1):
        limit = QuantitySpec("Pa", "vacuum up to atmospheric pressure", hi=brake.site.atmosphere)
        limit.check(vacuum, f"vacuum {number}")
        # first from zero load to the pretension, then through the angles
        elongation = np.concatenate([[0.0, pretension], pretension + sign * radius * angles])
        # a brake that is shorter than at rest is slack and does not move
        elongation = np.maximum(elongation, 0.0)
        cycle, _ = follow_history(elongation, np.full(len(elongation), float(vacuum)), brake)
        failures = {"separates": cycle.separated, "snaps at this stiffness": cycle.snapped}
        for failure, samples in failures.items():
            if samples.any():
                raise QuantityError(f"angle: brake {number} {failure} at these angles")
        if cycle.overflow.any():
            raise QuantityError(f"angle: too many nested reversals for brake {number}")
        cycles.append(cycle)
    first, second = cycles
    forces = np.column_stack([first.force, second.force])[2:]
    return Pair(
        angles,
        (forces[:, 0] - forces[:, 1]) * radius,
        forces,
        np.column_stack([first.slip, second.slip])[2:],
        (first.work + second.work)[2:],
        (first.heat + second.heat)[2:],
        (first.stored + second.stored)[2:],
    )


def neutral_stiffness(brakes: tuple[Brake, Brake], radius: float) -> float:
    """Return the stiffness (k1 + k2) r^2 [N m/rad] of two taut brakes without slip; radius [m]."""
    RADIUS.check(radius, "radius")
    return sum(float(working_stiffness(b)) for b in brakes) * radius**2
