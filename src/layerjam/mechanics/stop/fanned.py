"""A mass stopped by sheets that fan out: the same balance of energy, with a root to be searched.

The friction of a fan is no straight line, so that the kinetic energy K(s) is no quartic; its work
is a quadrature. K falls where the sliding brake's force exceeds the weight, until that force has
fallen to it: up to there the first root is the only one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.mechanics.enclosure import (
    EnclosureLaw,
    backbone,
    backbone_dissipated,
    backbone_stored,
    backbone_work,
)
from layerjam.mechanics.fan import Sheets, along_tangents, force_of, tangent, work_of
from layerjam.mechanics.law import safe_sqrt
from layerjam.mechanics.pull import searched_peak
from layerjam.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    SNAPS,
    STOPPED,
    Stop,
    balance_root,
    setup,
)
from layerjam.mechanics.stop.timing import expand_energy, pieces_time

_PARTS = 64


class Case(NamedTuple):
    """Constants of one stop; SI, all of one shape but what the brake says."""

    mass: Any
    arriving: Any
    """Kinetic energy on arrival [J]."""
    weight: Any
    k: Any
    sheets: Sheets
    enclosure: EnclosureLaw


def case_of(
    mass: Any, speed: Any, spring: Any, gravity: Any, sheets: Sheets, enclosure: EnclosureLaw
) -> Case:
    """The constants of a stop."""
    return Case(mass, mass * speed**2 / 2, mass * gravity, spring, sheets, enclosure)


def force(slip: Any, at: Case) -> Any:
    """Y(s) [N], the force of the sliding brake."""
    return force_of(slip, at.sheets) + backbone(slip, at.enclosure)


def energy(slip: Any, at: Case) -> Any:
    """K(s) [J]: what is left of the mass's energy of motion at slip s [m]."""
    pull = force(slip, at)
    work = work_of(jnp.zeros_like(slip), slip, at.sheets) + backbone_work(slip, at.enclosure)
    return at.arriving + at.weight * (slip + pull / at.k) - work - pull**2 / (2 * at.k)


def _firmness(slip: Any, at: Case) -> Any:
    """k + Y'(s) [N/m]: below zero the force falls faster than the spring gives."""
    e = at.enclosure
    rises = e.root / (2 * jnp.sqrt(jnp.where(slip > 0, slip, 1.0)))
    rises = jnp.where(slip < e.saturation, rises, e.stiffness / e.reach)
    rises = jnp.where(slip > 0, rises, jnp.where(e.root > 0, jnp.inf, 0.0))
    return at.k - tangent(slip, at.sheets).c + rises


def _falls_through(
    function: Callable[[Any], Any], low: Any, high: Any, level: Any
) -> tuple[Any, Any]:
    """First sqrt of the slip in [low, high] at which `function` falls below `level`, if it does."""
    shape = jnp.shape(low + high)
    parts = jnp.linspace(0.0, 1.0, _PARTS + 1).reshape((-1,) + (1,) * len(shape))
    below = function((low + parts * (high - low)) ** 2) < level
    first = jnp.argmax(below, axis=0)
    width = (high - low) / _PARTS
    start = low + jnp.maximum(first - 1, 0) * width
    return halved(lambda root: function(root**2) - level, start, low + first * width), below.any(0)


def halved(function: Callable[[Any], Any], low: Any, high: Any) -> Any:
    """Where a falling function passes zero between two arrays, by 60 halvings."""

    def halve(_: int, bounds: tuple[Any, Any]) -> tuple[Any, Any]:
        middle = (bounds[0] + bounds[1]) / 2
        above = function(middle) > 0
        return jnp.where(above, middle, bounds[0]), jnp.where(above, bounds[1], middle)

    low, high = jax.lax.fori_loop(0, 60, halve, (low, high))
    return (low + high) / 2


def _ends(at: Case, travel: Any, top: Any) -> tuple[Any, Any]:
    """Up to which slip [m] a standstill is looked for, and from which the brake snaps."""
    far, zero = jnp.sqrt(travel), jnp.zeros_like(travel)
    root, runs = _falls_through(lambda slip: _firmness(slip, at), zero, far, 0.0)
    snap = jnp.where(runs, root**2, jnp.inf)
    root, meets = _falls_through(lambda slip: force(slip, at), jnp.sqrt(top), far, at.weight)
    balance = jnp.where(meets, root**2, travel)
    return jnp.minimum(balance, snap), snap


def stop_of(at: Case, travel: Any) -> Stop:
    """How it ends; `travel` [m] of the shape of the case. The last Newton step has the gradient."""
    zero = jnp.zeros_like(travel)
    fixed = jax.lax.stop_gradient(at)
    top = jnp.minimum(searched_peak(travel, fixed.sheets, fixed.enclosure)[1], travel)
    end, snap = jax.lax.stop_gradient(_ends(fixed, travel, jax.lax.stop_gradient(top)))
    onset = force(zero, at)
    elastic = at.weight + safe_sqrt(at.weight**2 + 2 * at.k * at.arriving)
    slides, stops = elastic > onset, energy(end, fixed) <= 0
    root = halved(lambda w: energy(w**2, fixed), zero, jnp.sqrt(end))
    root = jax.lax.stop_gradient(root)
    left, slope = jax.jvp(lambda slip: energy(slip, fixed), (root**2,), (jnp.ones_like(root),))
    down = slope < 0
    slope = jax.lax.stop_gradient(jnp.where(down, slope, -1.0))
    stood = jnp.maximum(root**2 - jnp.where(down, energy(root**2, at) / slope, 0.0), 0.0)
    slip = jnp.where(slides, jnp.where(stops, stood, jnp.minimum(travel, snap)), 0.0)
    outcome = jnp.where(stops, STOPPED, jnp.where(snap < travel, SNAPS, BOTTOMED_OUT))
    resist = force(slip, at)
    highest = jnp.maximum(searched_peak(slip, at.sheets, at.enclosure)[0], onset)
    rest = stops | ~slides
    left = jnp.where(rest, 0.0, jnp.maximum(energy(slip, at), 0.0))
    heat = work_of(zero, slip, at.sheets) + backbone_dissipated(slip, at.enclosure)
    pull = jnp.where(slides, resist, elastic)
    return Stop(
        slip,
        jnp.where(slides, highest, elastic),
        safe_sqrt(2 * left / at.mass),
        heat,
        pull**2 / (2 * at.k) + backbone_stored(slip, at.enclosure),
        jnp.where(slides, outcome, NEVER_SLID),
    )


def sliding_time(slip: Any, at: Case) -> Any:
    """Return the seconds [s] from the first slip to a slip [m], up to the standstill."""
    end, strip = safe_sqrt(slip), at.enclosure

    def meets_weight(line: Sheets) -> Any:
        speed, gravity = jnp.sqrt(2 * at.arriving / at.mass), at.weight / at.mass
        case = setup(at.mass, speed, line.c, line.overlap, strip, at.k, gravity)
        return balance_root(case, jnp.inf) ** 2

    def pace(w: Any) -> Any:
        # ds/dw, and d sqrt(s)/dw of the enclosure, whose slope in s is infinite at the start
        stretch = jnp.where(
            w**2 < strip.saturation, strip.root, 2 * w * strip.stiffness / strip.reach
        )
        return 2 * w + (stretch - 2 * w * tangent(w**2, at.sheets).c) / at.k

    def kinetic(w: Any) -> Any:
        return energy(w**2, at)

    fixed = jax.lax.stop_gradient(at.sheets)
    balance = jax.lax.stop_gradient(safe_sqrt(along_tangents(meets_weight, 0.0 * slip, fixed)))
    whole = jnp.minimum(safe_sqrt(strip.saturation + jnp.zeros_like(end)), end)
    cuts = [
        jnp.zeros_like(end),
        jnp.clip(balance, 0.0, whole),
        whole,
        jnp.clip(balance, whole, end),
        end,
    ]
    expand = expand_energy(kinetic, lambda w: (at.weight - force(w**2, at)) * pace(w))
    return pieces_time(cuts, expand, lambda w: w < balance, pace, at.mass)
