"""Friction of the sheets versus slip: linear in the overlap, times the factors of effects.

An effect that depends on slip (see `SlipShape`) changes the factor. Solvers use a force, its
tangent and its work, and do not know which effects there are.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics.arrays import freeze, repeat, xp

_STEPS = 8
"""Newton steps on a convex curve; convergence is quadratic, so the last ones change nothing."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(32)


class Sheets(NamedTuple):
    """The sheets' friction at a vacuum, c (overlap - x), times the factors of its shapes."""

    c: Any
    overlap: Any
    shapes: tuple[Any, ...] = ()
    """Factors versus slip, one for each effect that depends on it (`device.effect.SlipShape`)."""


def friction_force(slip: Any, sheets: Any) -> Any:
    """Return the friction [N] at a slip [m] of `Sheets`, or any object with their three fields."""
    force = sheets.c * xp.maximum(sheets.overlap - slip, 0.0)
    for shape in sheets.shapes:
        force = force * shape.factor(slip)
    return force


def scale_friction(sheets: Any, factor: Any) -> Any:
    """Return the sheets with `factor` times the friction coefficient, which a fan amplifies.

    All interfaces slide at the same speed, so a speed-dependent coefficient is the same for all,
    and the derivation of the fan remains valid.
    """
    shapes = tuple(shape.scale(factor) for shape in sheets.shapes)
    return sheets._replace(c=sheets.c * factor, shapes=shapes)


def log_slope(slip: Any, sheets: Any) -> Any:
    """Return the slope of friction versus the logarithm of its coefficient [N]."""
    force = friction_force(slip, sheets)
    if not sheets.shapes:
        return force
    return force * (1 + sum(shape.gain(slip) for shape in sheets.shapes))


def friction_tangent(slip: Any, sheets: Any) -> Any:
    """Return the sheets, without shapes, whose friction is tangent to this one at a slip [m]."""
    if not sheets.shapes:
        return sheets
    slip = xp.clip(slip, 0.0, sheets.overlap)
    left = sheets.overlap - slip
    ratio: Any = 1.0
    fall: Any = 0.0
    for shape in sheets.shapes:
        factor = shape.factor(slip)
        ratio, fall = ratio * factor, fall * factor + ratio * shape.fall_over(left, slip)
    steep = ratio + fall
    return sheets._replace(c=sheets.c * steep, overlap=slip + left * ratio / steep, shapes=())


def friction_work(start: Any, end: Any, sheets: Any) -> Any:
    """Return the work of friction [J] between two slips [m]; the overlap may end in between."""
    start, end = xp.minimum(start, sheets.overlap), xp.minimum(end, sheets.overlap)
    if not sheets.shapes:
        return sheets.c * (end - start) * (sheets.overlap - (start + end) / 2)
    # one slip may belong to many frictions
    none = 0.0 * sheets.c
    return _integrate(lambda slip: friction_force(slip, sheets), start + none, end + none, sheets)


def growing_work(start: Any, end: Any, sheets: Any, c: Any) -> Any:
    """Return the same if c changes linearly from `c` [N/m] to that of `sheets` over the slip."""
    slide = end - start
    if not sheets.shapes:
        work = sheets.c * slide * (sheets.overlap - (end + start) / 2)
        if c is sheets.c:
            return work
        return work - (sheets.c - c) * slide * ((sheets.overlap - start) / 2 - slide / 6)
    part = xp.where(slide != 0, slide, 1.0)

    def force(slip: Any) -> Any:
        friction = c + (sheets.c - c) * (slip - start) / part
        return friction_force(slip, sheets._replace(c=friction))

    return _integrate(force, start, end, sheets)


def _integrate(force: Callable[[Any], Any], start: Any, end: Any, sheets: Any) -> Any:
    """Return the integral [J] by 32-point Gauss quadrature over ln(L + x), which is smooth."""
    least: Any = xp.inf
    for bend in sheets.shapes:
        least = xp.minimum(least, bend.length)
    low, high = xp.broadcast_arrays(xp.log(least + start), xp.log(least + end))
    shape = (-1,) + (1,) * low.ndim
    nodes, weights = (xp.asarray(a).reshape(shape) for a in (_NODES, _WEIGHTS))
    half = (high - low) / 2
    place = xp.exp(low + half * (nodes + 1))
    return (weights * half * place * force(place - least)).sum(axis=0)


def find_equilibrium(solve: Callable[[Any], Any], start: Any, sheets: Any) -> Any:
    """Return the slip at which `solve` finds an equilibrium, for friction along any curve.

    `solve` assumes a linear friction; each step uses the tangent at the result of the previous one.
    The search is not differentiated; only the last step carries the gradient of the root.
    """
    if not sheets.shapes:
        return solve(sheets)

    def step(_: int, slip: Any) -> Any:
        return solve(friction_tangent(slip, sheets)) + xp.zeros_like(slip)

    first = solve(friction_tangent(start, sheets))
    root = repeat(_STEPS, step, first)
    return solve(friction_tangent(freeze(root), sheets))
