"""Duration of the slip of a stop, from the kinetic energy along the path.

The slip is followed in a variable w in which force and energy are smooth at the start (the square
root of the slip, or the strain of the enclosure). The mass may almost stop where the sliding force
equals its weight, so pieces are split there and nodes are denser towards their slow end.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics.arrays import choose, freeze, repeat, xp
from layerjam.brake.mechanics.law import safe_sqrt
from layerjam.brake.mechanics.stop.algebra import Quartic, quartic_slope, quartic_value

NEAREST, FARTHEST = 1e-14, 1e6
"""Largest relative distance of a complex root of the kinetic energy to which the nodes adapt."""
MARGIN = 1e-9
"""Relative distance from the end of a piece that still counts as that end."""
GAP = 1e-6
"""Relative distance over which a difference stands for a derivative."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


class Course(NamedTuple):
    """Kinetic energy of the mass at a coordinate w, its slope, and that of the displacement z."""

    energy: Any
    """Kinetic energy [J]."""
    rate: Any
    """Derivative of the energy with respect to w."""
    pace: Any
    """dz/dw."""


class Expansion(NamedTuple):
    """Course near the slow end of a piece; `gap` is the distance from that end."""

    end_energy: Any
    """Kinetic energy at the end [J]."""
    first: Any
    """First derivative with respect to the distance."""
    second: Any
    follow: Callable[[Any], tuple[Any, Any]]
    """Function that returns the kinetic energy [J] and dz/dw at a distance."""


Expand = Callable[[Any, Any], Expansion]
"""Function of the slow end of a piece and the direction away from it (1 or -1)."""


def expand_course(course: Callable[[Any], Course]) -> Expand:
    """Return the expansion of any course in w.

    The second derivative only places nodes, so a difference is enough for it.
    """

    def expand(end: Any, sign: Any) -> Expansion:
        # start slightly inside the piece, because at w = 0 the slip's square root has no derivative
        interior_point = end + sign * MARGIN * xp.maximum(xp.abs(end), 1e-6)
        first, gap = course(interior_point).rate, sign * GAP * (xp.abs(end) + 1e-3)
        second = (course(interior_point + gap).rate - first) / gap
        energy_there = course(end).energy
        end_energy = xp.maximum(energy_there, 0.0)

        def follow(gap: Any) -> tuple[Any, Any]:
            place = course(end + sign * gap)
            return place.energy - energy_there + end_energy, place.pace

        return Expansion(end_energy, sign * first, second, follow)

    return expand


def expand_quartic(part: Quartic, pace: tuple[Any, Any], end: Any, sign: Any) -> Expansion:
    """Return a quartic's expansion from its exact derivatives, without loss of digits near zero.

    It starts at `end`, in the direction `sign` (1 or -1). dz/dw is pace[0] + pace[1] w.
    """
    end_energy, first = xp.maximum(quartic_value(part, end), 0.0), sign * quartic_slope(part, end)
    second = 2 * part.a2 + end * (6 * part.a3 + end * 12 * part.a4)
    half, third, fourth = second / 2, sign * (part.a3 + 4 * part.a4 * end), part.a4
    end_pace, change = pace[0] + pace[1] * end, pace[1] * sign

    def follow(gap: Any) -> tuple[Any, Any]:
        energy = end_energy + gap * (first + gap * (half + gap * (third + gap * fourth)))
        return energy, end_pace + change * gap

    return Expansion(end_energy, first, second, follow)


def piece_time(low: Any, high: Any, expand: Expand, falls: Any, mass: Any) -> Any:
    """Return the time [s] from w = `low` to `high`; the mass is slowest at one of these ends.

    `falls` is true if the slow end is `high`. The nodes are w = end -+ (high - low) (sinh(a cos q)
    / sinh a)^2, with a from the distance of the next complex root of the energy. This removes the
    square root at a standstill, and the sharp peak next to a near standstill.
    """
    width = xp.maximum(high - low, 0.0)
    length = xp.where(width > 0, width, 1.0)
    series = expand(xp.where(falls, high, low), xp.where(falls, -1.0, 1.0))
    curve = xp.where(series.second != 0, xp.abs(series.second), 1.0)
    margin = (
        xp.maximum(xp.sqrt(2 * series.end_energy / curve), xp.abs(series.first) / curve) / length
    )
    margin = xp.where(series.second != 0, xp.clip(margin, NEAREST, FARTHEST), FARTHEST)
    sharp = freeze(xp.arcsinh(1 / xp.sqrt(margin)))
    q = ((_NODES + 1) * (np.pi / 4)).reshape((-1,) + (1,) * xp.ndim(width))
    # compute sinh and cosh of a cos q from one exponential, which halves the time
    growth = xp.expm1(sharp * np.cos(q))
    inverse = 1 / (1 + growth)
    double_sine = growth + growth * inverse
    scale = xp.sinh(sharp)
    energy, pace = series.follow(width / (4 * scale**2) * double_sine**2)
    speed = safe_sqrt(xp.maximum(energy, 0.0))
    steps = double_sine * (double_sine / 2 + inverse) * pace / xp.where(speed > 0, speed, xp.inf)
    weights = (_WEIGHTS * (np.pi / 4)).reshape(q.shape) * np.sin(q)
    return (weights * steps).sum(axis=0) * xp.sqrt(mass / 2) * width * sharp / scale**2


def pieces_time(cuts: Any, expand: Expand, falls: Callable[[Any], Any], mass: Any) -> Any:
    """Return the time [s] over the pieces between rising `cuts`, stacked along the first axis.

    `falls` is true if the energy falls at the middle of a piece.
    """

    def duration(low: Any, high: Any) -> Any:
        return piece_time(low, high, expand, falls((low + high) / 2), mass)

    def add_piece(index: Any, total: Any) -> Any:
        low, high = (xp.take(cuts, place, axis=0) for place in (index, index + 1))
        # most stops end before the last cuts, for which nothing is computed
        return total + choose(
            xp.any(high > low), duration, lambda low, _: xp.zeros_like(low), low, high
        )

    return repeat(len(cuts) - 1, add_piece, xp.zeros_like(cuts[0]))
