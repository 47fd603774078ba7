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


class Expansion(NamedTuple):
    """Kinetic energy near the slow end of a piece; `far` is the distance from that end."""

    end_energy: Any
    """Kinetic energy at the end [J]."""
    first: Any
    """First derivative with respect to the distance."""
    second: Any
    energy: Callable[[Any], Any]
    """Function that returns the kinetic energy [J] at a distance."""


Expand = Callable[[Any, Any], Expansion]
"""Function of the slow end of a piece and the direction away from it (1 or -1)."""


def expand_energy(energy: Callable[[Any], Any], rate: Callable[[Any], Any]) -> Expand:
    """Return the expansion of any kinetic energy [J] in w, given its derivative `rate`.

    The derivative is (weight - force) dz/dw. The second one only places nodes, so a difference is
    enough for it.
    """

    def expand(end: Any, sign: Any) -> Expansion:
        def energy_at(gap: Any) -> Any:
            return energy(end + sign * gap)

        # start slightly inside the piece, because at w = 0 the slip's square root has no derivative
        interior_point = end + sign * MARGIN * xp.maximum(xp.abs(end), 1e-6)
        first, gap = rate(interior_point), sign * GAP * (xp.abs(end) + 1e-3)
        second = (rate(interior_point + gap) - first) / gap
        energy_there = energy(end)
        end_energy = xp.maximum(energy_there, 0.0)
        return Expansion(
            end_energy, sign * first, second, lambda far: energy_at(far) - energy_there + end_energy
        )

    return expand


def expand_quartic(part: Quartic, end: Any, sign: Any) -> Expansion:
    """Return a quartic's expansion from its exact derivatives, without loss of digits near zero.

    It starts at `end`, in the direction `sign` (1 or -1).
    """
    end_energy, first = xp.maximum(quartic_value(part, end), 0.0), sign * quartic_slope(part, end)
    second = 2 * part.a2 + end * (6 * part.a3 + end * 12 * part.a4)
    third, fourth = sign * (6 * part.a3 + 24 * part.a4 * end), part.a4

    def energy(gap: Any) -> Any:
        return end_energy + gap * (first + gap * (second / 2 + gap * (third / 6 + gap * fourth)))

    return Expansion(end_energy, first, second, energy)


def piece_time(
    low: Any, high: Any, expand: Expand, falls: Any, pace: Callable[[Any], Any], mass: Any
) -> Any:
    """Return the time [s] from w = `low` to `high`; the mass is slowest at one of these ends.

    `falls` is true if the slow end is `high`; `pace` is the derivative of the mass's displacement
    with respect to w, dz/dw. The nodes are w = end -+ (high - low) (sinh(a cos q)/sinh a)^2, with a
    from the distance of the next complex root of the energy. This removes the square root at a
    standstill, and the sharp peak next to a near standstill.
    """
    width = xp.maximum(high - low, 0.0)
    length = xp.where(width > 0, width, 1.0)
    end, sign = xp.where(falls, high, low), xp.where(falls, -1.0, 1.0)
    series = expand(end, sign)
    curve = xp.where(series.second != 0, xp.abs(series.second), 1.0)
    margin = (
        xp.maximum(xp.sqrt(2 * series.end_energy / curve), xp.abs(series.first) / curve) / length
    )
    margin = xp.where(series.second != 0, xp.clip(margin, NEAREST, FARTHEST), FARTHEST)
    sharp = freeze(xp.arcsinh(1 / xp.sqrt(margin)))
    q = ((xp.asarray(_NODES) + 1) * (xp.pi / 4)).reshape((-1,) + (1,) * xp.ndim(width))
    # compute sinh and cosh of a cos q from one exponential, which halves the time
    growth = xp.expm1(sharp * xp.cos(q))
    sine, scale = (growth + growth / (1 + growth)) / 2, xp.sinh(sharp)
    share = sine / scale
    rate = 2 * share * sharp * xp.sin(q) * (sine + 1 / (1 + growth)) / scale
    gap = width * share**2
    speed = safe_sqrt(2 * xp.maximum(series.energy(gap), 0.0) / mass)
    steps = width * rate * pace(end + sign * gap)
    weights = xp.asarray(_WEIGHTS).reshape(q.shape) * (xp.pi / 4)
    return (weights * steps / xp.where(speed > 0, speed, xp.inf)).sum(axis=0)


def pieces_time(
    cuts: Any,
    expand: Expand,
    falls: Callable[[Any], Any],
    pace: Callable[[Any], Any],
    mass: Any,
) -> Any:
    """Return the time [s] over the pieces between rising `cuts`, stacked along the first axis.

    `falls` is true if the energy falls at the middle of a piece.
    """

    def duration(low: Any, high: Any) -> Any:
        return piece_time(low, high, expand, falls((low + high) / 2), pace, mass)

    def add_piece(index: Any, total: Any) -> Any:
        low, high = (xp.take(cuts, place, axis=0) for place in (index, index + 1))
        # most stops end before the last cuts, for which nothing is computed
        return total + choose(
            xp.any(high > low), duration, lambda low, _: xp.zeros_like(low), low, high
        )

    return repeat(len(cuts) - 1, add_piece, xp.zeros_like(cuts[0]))
