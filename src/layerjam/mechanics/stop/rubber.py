"""A mass stopped by a brake whose enclosure is hyperelastic: one first loading, by its energy.

Everything is explicit in the strain e at the ends of the enclosure: slip, force, heat and elastic
energy, so that the kinetic energy K(e) is too. K falls where the sliding brake's force exceeds the
weight. That force rises to its peak, falls, and rises again where the rubber stiffens: K has one
root at most up to where the falling force meets the weight, and one at most beyond.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.mechanics.fan import Sheets, force_of, tangent, work_of
from layerjam.mechanics.hyperelastic import Stretched, Strip, end_strain, stretched
from layerjam.mechanics.law import safe_sqrt
from layerjam.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
    Stop,
)
from layerjam.mechanics.stop.fanned import halved
from layerjam.mechanics.stop.timing import expand_energy, extremum, pieces_time

_PARTS = 64


class Case(NamedTuple):
    """Constants of one stop; SI, all of one shape but what the brake says."""

    mass: Any
    arriving: Any
    """Kinetic energy on arrival [J]."""
    weight: Any
    k: Any
    sheets: Sheets
    strip: Strip


def drawn(strain: Any, at: Case) -> Stretched:
    """The enclosure at a strain of its ends [-]; all is zero at zero, without vacuum too."""
    moves = strain > 0
    made = stretched(jnp.where(moves, strain, 1e-9), at.strip)
    return jax.tree.map(lambda part: jnp.where(moves, part, 0.0), made)


def force(made: Stretched, at: Case) -> Any:
    """Y [N], the force of the sliding brake."""
    return force_of(made.slip, at.sheets) + made.force


def energy(made: Stretched, at: Case) -> Any:
    """K [J]: what is left of the mass's energy of motion."""
    pull = force(made, at)
    work = work_of(jnp.zeros_like(made.slip), made.slip, at.sheets) + made.stored + made.heat
    return at.arriving + at.weight * (made.slip + pull / at.k) - work - pull**2 / (2 * at.k)


def _rise(made: Stretched, at: Case) -> Any:
    """Slope of the sliding brake's force over the strain at the ends [N]."""
    slip, pull = made.rise
    return pull - tangent(made.slip, at.sheets).c * slip


def _falls(function: Callable[[Any], Any], low: Any, high: Any) -> tuple[Any, Any]:
    """First strain in [low, high] from which `function` is below zero, and whether it ever is."""
    shape = jnp.shape(low + high)
    parts = jnp.linspace(0.0, 1.0, _PARTS + 1).reshape((-1,) + (1,) * len(shape))
    below = function(low + parts * (high - low)) < 0
    first = jnp.argmax(below, axis=0)
    width = (high - low) / _PARTS
    start = low + jnp.maximum(first - 1, 0) * width
    return halved(function, start, low + first * width), below.any(axis=0)


def strain_at(slip: Any, at: Case) -> Any:
    """Strain at the ends of the enclosure [-] at a slip [m]; NaN beyond what was fitted."""
    return end_strain(slip, jnp.ones_like(slip), 0.0, at.strip)


class _Ends(NamedTuple):
    far: Any
    """Strain at the end of travel, at the snap or at the greatest that was fitted [-]."""
    snaps: Any
    cut: Any
    """The far strain is the greatest that was fitted."""
    peak: Any
    balance: Any


def _ends(at: Case, travel: Any) -> _Ends:
    zero, most = jnp.zeros_like(travel), at.strip.rubber.strain + jnp.zeros_like(travel)
    end = strain_at(travel, at)
    cut = jnp.isnan(end)
    far = jnp.where(cut, most, end)

    def firm(strain: Any) -> Any:
        made = drawn(strain, at)
        return at.k * made.rise[0] + _rise(made, at)

    snap, snaps = _falls(firm, 1e-9 * far, far)
    far = jnp.where(snaps, snap, far)

    def rise(strain: Any) -> Any:
        return _rise(drawn(strain, at), at)

    top, falls = _falls(rise, zero, far)
    peak = jnp.where(falls, top, far)
    # where the force rises again, if it does; at the peak itself its slope is rounding
    beyond = peak + 1e-6 * (far - peak)
    again, rises = _falls(lambda strain: -rise(strain), beyond, far)
    least = jnp.where(rises, again, far)

    def over(strain: Any) -> Any:
        return force(drawn(strain, at), at) - at.weight

    meets = over(least) < 0
    balance = jnp.where(meets, halved(over, peak, least), far)
    return _Ends(far, snaps, cut & ~snaps, peak, balance)


def stop_of(at: Case, travel: Any) -> Stop:
    """How it ends; `travel` [m] of the shape of the case. The last Newton step has the gradient.

    NOT_A_CASE where the mass would stretch the enclosure beyond the strain that was fitted.
    """
    fixed = jax.lax.stop_gradient(at)
    ends = jax.lax.stop_gradient(_ends(fixed, travel))

    def left(strain: Any, case: Case) -> Any:
        return energy(drawn(strain, case), case)

    zero = jnp.zeros_like(travel)
    first, last = left(ends.balance, fixed) <= 0, left(ends.far, fixed) <= 0
    stops = first | last
    low = jnp.where(first, zero, ends.balance)
    high = jnp.where(first, ends.balance, ends.far)
    root = jax.lax.stop_gradient(halved(lambda e: left(e, fixed), low, high))
    slope = jax.jvp(lambda e: left(e, fixed), (root,), (jnp.ones_like(root),))[1]
    down = slope < 0
    step = jnp.where(down, left(root, at) / jax.lax.stop_gradient(jnp.where(down, slope, -1.0)), 0)
    onset = force(drawn(zero, at), at)
    elastic = at.weight + safe_sqrt(at.weight**2 + 2 * at.k * at.arriving)
    slides = elastic > onset
    early = ends.snaps | ends.cut
    at_travel = jnp.where(early, ends.far, strain_at(jnp.where(early, 0.0, travel), at))
    strain = jnp.where(stops, root - step, at_travel)
    strain = jnp.where(slides, jnp.maximum(strain, 0.0), 0.0)
    made = drawn(strain, at)
    resist = force(made, at)
    top = force(drawn(jnp.minimum(strain, ends.peak), at), at)
    moving = jnp.where(stops | ~slides, 0.0, jnp.maximum(energy(made, at), 0.0))
    outcome = jnp.where(stops, STOPPED, jnp.where(ends.snaps, SNAPS, BOTTOMED_OUT))
    outcome = jnp.where(~stops & ends.cut, NOT_A_CASE, outcome)
    pull = jnp.where(slides, resist, elastic)
    return Stop(
        made.slip,
        jnp.where(slides, jnp.maximum(jnp.maximum(top, resist), onset), elastic),
        safe_sqrt(2 * moving / at.mass),
        work_of(zero, made.slip, at.sheets) + made.heat,
        pull**2 / (2 * at.k) + made.stored,
        jnp.where(slides, outcome, NEVER_SLID),
    )


def sliding_time(slip: Any, at: Case) -> Any:
    """Return the seconds [s] from the first slip to a slip [m], up to the standstill."""
    end = jnp.where(slip > 0, strain_at(slip, at), 0.0)

    def kinetic(strain: Any) -> Any:
        return energy(drawn(strain, at), at)

    def pace(strain: Any) -> Any:
        made = drawn(strain, at)
        return made.rise[0] + _rise(made, at) / at.k

    zero, fixed = jnp.zeros_like(end), jax.lax.stop_gradient(at)

    def search(low: Any, sign: float) -> Any:
        return extremum(lambda e: energy(drawn(e, fixed), fixed), low, end, sign)

    # the energy falls to the balance and rises from there, until the rubber stiffens
    balance = search(zero, 1.0)
    greatest = search(balance, -1.0)
    cuts = [zero, balance, greatest, end]
    return pieces_time(
        cuts,
        expand_energy(kinetic, lambda e: (at.weight - force(drawn(e, at), at)) * pace(e)),
        lambda strain: (strain < balance) | (strain > greatest),
        pace,
        at.mass,
    )
