"""Seconds that a mass takes over the slip of a stop, from its kinetic energy along the way.

The slip is followed in a variable w in which force and energy are smooth at the start (the square
root of the slip, or the strain of the enclosure). The mass may all but stand where the sliding
force meets its weight, so that pieces are cut there and nodes crowd towards their slow end.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.mechanics.law import safe_sqrt

NEAREST, FARTHEST = 1e-14, 1e6
"""Distance of a complex root of the kinetic energy, over the piece, that the nodes answer to."""
_PARTS, _STEPS = 64, 8
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


class Expansion(NamedTuple):
    """Kinetic energy from the slow end of a piece on; `far` is the distance from that end."""

    rest: Any
    """At the end [J]."""
    first: Any
    """First derivative over the distance."""
    second: Any
    energy: Callable[[Any], Any]
    """Kinetic energy [J] at a distance."""


Expand = Callable[[Any, Any], Expansion]
"""From the slow end of a piece and the direction away from it (1 or -1)."""


def expand_energy(energy: Callable[[Any], Any], slope: Callable[[Any], Any]) -> Expand:
    """Return the expansion of any kinetic energy [J] over w with its derivative `slope`.

    The derivative is (weight - force) dz/dw; the second one follows by differentiation.
    """

    def expand(end: Any, way: Any) -> Expansion:
        def along(far: Any) -> Any:
            return energy(end + way * far)

        # a hair inside the piece: at w = 0 the root of the slip has no derivative
        inside = end + way * 1e-9 * jnp.maximum(jnp.abs(end), 1e-6)
        first, second = jax.jvp(slope, (inside,), (jnp.ones_like(inside),))
        here = energy(end)
        rest = jnp.maximum(here, 0.0)
        return Expansion(rest, way * first, second, lambda far: along(far) - here + rest)

    return expand


def piece_time(
    low: Any, high: Any, expand: Expand, falls: Any, pace: Callable[[Any], Any], mass: Any
) -> Any:
    """Return the seconds [s] from w = `low` to `high`, between which the energy has one slow end.

    `falls` says that the slow end is `high`; `pace` is the displacement of the mass over w,
    dz/dw. The nodes are w = end -+ (high - low) (sinh(a cos q)/sinh a)^2. With a from the distance
    of the next complex root of the energy that takes out the square root at a standstill, and the
    peak if it is passed by a hair's breadth.
    """
    width = jnp.maximum(high - low, 0.0)
    length = jnp.where(width > 0, width, 1.0)
    end, way = jnp.where(falls, high, low), jnp.where(falls, -1.0, 1.0)
    at = expand(end, way)
    curve = jnp.where(at.second != 0, jnp.abs(at.second), 1.0)
    near = jnp.maximum(jnp.sqrt(2 * at.rest / curve), jnp.abs(at.first) / curve) / length
    near = jnp.where(at.second != 0, jnp.clip(near, NEAREST, FARTHEST), FARTHEST)
    sharp = jax.lax.stop_gradient(jnp.arcsinh(1 / jnp.sqrt(near)))
    q = ((jnp.asarray(_NODES) + 1) * (jnp.pi / 4)).reshape((-1,) + (1,) * jnp.ndim(width))
    share = jnp.sinh(sharp * jnp.cos(q)) / jnp.sinh(sharp)
    rate = 2 * share * sharp * jnp.sin(q) * jnp.cosh(sharp * jnp.cos(q)) / jnp.sinh(sharp)
    far = width * share**2
    speed = safe_sqrt(2 * jnp.maximum(at.energy(far), 0.0) / mass)
    steps = width * rate * pace(end + way * far)
    weights = jnp.asarray(_WEIGHTS).reshape(q.shape) * (jnp.pi / 4)
    return (weights * steps / jnp.where(speed > 0, speed, jnp.inf)).sum(axis=0)


def pieces_time(
    cuts: list[Any],
    expand: Expand,
    falls: Callable[[Any], Any],
    pace: Callable[[Any], Any],
    mass: Any,
) -> Any:
    """Return the seconds [s] over the pieces between rising `cuts`; `falls` says which fall."""
    total: Any = jnp.zeros_like(cuts[0])

    def seconds(low: Any, high: Any) -> Any:
        return piece_time(low, high, expand, falls((low + high) / 2), pace, mass)

    for low, high in pairwise(cuts):
        # most stops end before the last cuts: nothing is computed there
        total = total + jax.lax.cond(
            jnp.any(high > low), seconds, lambda low, _: jnp.zeros_like(low), low, high
        )
    return total


def extremum(energy: Callable[[Any], Any], low: Any, high: Any, sign: float) -> Any:
    """Return w of the least (`sign` 1) or greatest (-1) energy between two arrays.

    The best of 64 parts, then Newton steps for the slope's root within its neighbours.
    """
    parts = jnp.linspace(0.0, 1.0, _PARTS + 1).reshape((-1,) + (1,) * jnp.ndim(low))
    best = jnp.argmin(sign * energy(low + parts * (high - low)), axis=0)
    width = (high - low) / _PARTS
    least = low + jnp.maximum(best - 1, 0) * width
    most = low + jnp.minimum(best + 1, _PARTS) * width

    def slope(w: Any) -> Any:
        return jax.jvp(energy, (w,), (jnp.ones_like(w),))[1]

    def step(_: int, w: Any) -> Any:
        here, bend = jax.jvp(slope, (w,), (jnp.ones_like(w),))
        move = jnp.where(bend * sign > 0, here / jnp.where(bend != 0, bend, 1.0), 0.0)
        return jnp.clip(w - move, least, most)

    found = jax.lax.fori_loop(0, _STEPS, step, low + best * width)
    return jax.lax.stop_gradient(found)
