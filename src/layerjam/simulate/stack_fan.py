"""The friction of each interface of a stack whose sheets fan out, as a line that touches it.

The middle interfaces are pressed most: each has the mean of exp(alpha (1 - s^2)) over its share of
the stack's half height s, so that all together have the factor of the lumped law. The stack model
takes friction that falls along a straight line with the slip; it is given, increment by increment,
the line that touches the interface's own friction where it has slipped to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.mechanics.fan import Fan, is_flat
from layerjam.mechanics.friction import sheets_at, static_at
from layerjam.mechanics.stack.solve import Stack

Array = np.ndarray[Any, np.dtype[np.float64]]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class FannedFriction:
    """Interfaces between sheets that fan out; arrays of shape (n - 1,)."""

    rest: Array
    """Kinetic friction at rest without a fan [N]."""
    length: Array
    """Overlap at rest [m]."""
    ratio: float
    """Static over kinetic friction, of the film."""
    kinetic: Fan
    static: Fan
    """The same fan under static friction."""

    def lines(self, slip: Any) -> tuple[Array, Array, Array]:
        """Friction [N] and length [m] of the lines that touch it at a slip [m], and static/kinetic.

        A line is friction (1 - slip/length).
        """
        slip = np.clip(slip, 0.0, self.length * (1 - 1e-12))
        factor, shrink = _of_interfaces(slip, self.kinetic)
        factor, shrink = factor / self.kinetic.held, shrink / self.kinetic.held
        left = self.length - slip
        unit = self.rest / self.length
        steep = factor + left * shrink
        reach = slip + left * factor / steep
        if self.ratio > 1:
            most = _of_interfaces(slip, self.static)[0] / self.static.held
            return unit * steep * reach, reach, self.ratio * most / factor
        return unit * steep * reach, reach, np.ones_like(reach)

    def put(self, slip: Any, stack: Stack) -> bool:
        """The lines at a slip [m] into the stack's arrays; a housing's walls keep theirs.

        `slip` has an entry for every interface of the stack. False once no sheets overlap.
        """
        first, last = stack.ends
        friction, length, ratio = self.lines(slip[first:last])
        stack.friction[first:last], stack.length[first:last] = friction, length
        if self.ratio > 1:
            stack.ratio[first:last] = ratio
        return bool((slip[first:last] < self.length * (1 - 1e-9)).any())


def _of_interfaces(slip: Array, fan: Fan) -> tuple[Array, Array]:
    """The factor of each interface at its slip [m], and what of it each metre of slip takes."""
    count = len(slip)
    middle = (2 * np.arange(count) + 1) / count - 1
    depth = 1 - (middle[:, None] + _NODES / count) ** 2
    left, right = fan.left + slip, fan.right + slip
    alpha = fan.strength * (1 / left + 1 / right)
    fades = fan.strength * (1 / left**2 + 1 / right**2)
    each = np.exp(alpha[:, None] * depth)
    return (each * _WEIGHTS).sum(1) / 2, fades * (each * depth * _WEIGHTS).sum(1) / 2


def fanned_friction(
    brake: Brake, vacuum: float, rest: Array, length: Array, static: bool
) -> FannedFriction | None:
    """The friction of interfaces that hold `rest` [N] over `length` [m] without a fan.

    None for a brake that does not say whether it has spacers. Scatter and missing vacuum change an
    interface's own friction, not how its neighbours press it. Raises QuantityError for a fan
    steeper than 45 degrees.
    """
    kinetic, still = sheets_at(vacuum, brake).fan, static_at(vacuum, brake).fan
    if kinetic is None or still is None:
        return None
    if not bool(is_flat(brake)):
        raise QuantityError.of("mount.spacers", "the sheets leave their caps at over 45 degrees")
    ratio = float(brake.film.static / brake.film.kinetic) if static else 1.0
    plain, most = (Fan(*map(float, fan)) for fan in (kinetic, still))
    return FannedFriction(rest, length, ratio, plain, most if static else plain)
