"""The enclosure with a hyperelastic law under any slip: a strip of cells that stick and slide.

A cell at the distance s from the driven end of a half face feels that end only through the friction
in between, which bears at most q s. Its tension is therefore the play of the tension N0 at the end,

    N(s) = the old N(s), kept between N0 - q s and N0 + q s,

for every law in which a cell's tension rises with its strain and nothing else (Masing's rule is
this with a strain that is linear in the tension). So the tensions of a move are known without a
contact to be solved; the one unknown is N0. A cell's strain follows from its tension and from the
greatest strain it has seen. The cells are those of springs with Coulomb friction between them, so
that work, heat and elastic energy balance exactly; what the cells leave open falls with the square
of their number.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.device.hyperelastic import Hyperelastic
from layerjam.mechanics.hyperelastic import (
    at_slip,
    rubber_energy,
    rubber_slope,
    rubber_stress,
    strip_at,
)
from layerjam.mechanics.roots import newton_root
from layerjam.mechanics.softening import elastic_energy, lost_energy, softening

CELLS = 240
"""Cells of half a face."""
Drive = Callable[[Any, Any], tuple[Any, Any, Any]]
"""(what is left over, its slopes) over the tension at the end [N] and the slip [m]; falling."""


class Cells(NamedTuple):
    """Half of one face."""

    place: Any
    """Distance of the cells' middles from the driven end [m], shape (cells,)."""
    size: Any
    """Their lengths [m]."""
    section: Any
    rubber: Hyperelastic
    most: Any
    """Tension of the end at the greatest strain that was fitted [N]."""


class Rubber(NamedTuple):
    """State of the enclosure: half a face, which the other three repeat."""

    pull: Any
    """Tension of the end of a face [N]."""
    tension: Any
    """Of the cells [N], shape (cells,)."""
    strain: Any
    """Of the cells [-]."""
    held: Any
    """Greatest energy a volume that they have held [Pa]."""
    slip: Any
    heat: Any
    """Friction heat, and what was lost in softening [J]."""
    stored: Any
    beyond: Any
    """True once more was asked for than the rubber was measured to bear."""


def cells_for(slip: Any, least: Any, highest: Any, brake: Brake, count: int = CELLS) -> Cells:
    """Cells for histories up to a slip [m], between a least and a highest vacuum [Pa].

    They cover what can move, and are small near the driven end, where every turn begins.
    """
    made = at_slip(slip, highest, brake)[1]
    strip, rubber = strip_at(least, brake), strip_at(highest, brake).rubber
    most = strip.section * rubber_stress(rubber.strain + 0.0 * slip, rubber)
    pull = jnp.where(jnp.isnan(made.force), most, made.force / 2)
    rubs = strip.friction * strip.reach > pull
    moves = jnp.where(rubs, pull / jnp.where(rubs, strip.friction, 1.0), strip.reach)
    edges = moves * jnp.linspace(0.0, 1.0, count + 1) ** 2
    return Cells((edges[1:] + edges[:-1]) / 2, jnp.diff(edges), strip.section, rubber, most)


def relaxed(cells: Cells) -> Rubber:
    """A new enclosure, never stretched."""
    none, zero = jnp.zeros_like(cells.place), jnp.array(0.0)
    return Rubber(zero, none, none, none, zero, zero, zero, jnp.array(False))


def _stress(strain: Any, held: Any, rubber: Hyperelastic) -> tuple[Any, Any]:
    """Stress [Pa] at a strain and its slope, of a point that has held an energy [Pa]."""
    first = rubber_stress(strain, rubber)
    eta, steep = softening(rubber_energy(strain, rubber), held, rubber)
    return eta * first, eta * rubber_slope(strain, rubber) + steep * first**2


def _strain_under(tension: Any, held: Any, guess: Any, cells: Cells) -> Any:
    """Strain of the cells [-] at their tension [N]."""

    def over(state: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        stress, slope = _stress(state[0], held, cells.rubber)
        return stress - tension / cells.section, slope, state[1]

    top = cells.rubber.strain * 1.01 + 0.0 * tension
    # below zero only for the search, so that no strain of rest lies at the end of the bracket
    found = newton_root(over, guess, jnp.full_like(tension, -0.1), top, 0.0)
    return jnp.where(tension > 0, jnp.maximum(found, 0.0), 0.0)


def follow(state: Rubber, drive: Drive, friction: Any, cells: Cells) -> Rubber:
    """The strip once `drive` is met at a friction [N/m]; one move in one direction."""

    def drawn(pull: Any, guess: Any) -> tuple[Any, Any]:
        bears = friction * cells.place
        tension = jnp.clip(state.tension, pull - bears, pull + bears)
        return tension, _strain_under(tension, state.held, guess, cells)

    def over(now: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        tension, strain = drawn(*now)
        steep = _stress(strain, state.held, cells.rubber)[1] * cells.section
        moves = jnp.abs(now[0] - tension) >= friction * cells.place * (1 - 1e-12)
        slip = 2 * (cells.size * strain).sum()
        rises = 2 * jnp.where(moves, cells.size / steep, 0.0).sum()
        rest, over_pull, over_slip = drive(now[0], slip)
        return -rest, -(over_pull + over_slip * rises), strain

    pull = newton_root(over, state.pull, jnp.zeros_like(cells.most), cells.most, state.strain)
    tension, strain = drawn(pull, state.strain)
    energy = rubber_energy(strain, cells.rubber)
    held = jnp.maximum(state.held, energy)
    slip, volume = 2 * (cells.size * strain).sum(), 4 * cells.section * cells.size
    rubbed = 4 * friction * jnp.abs((cells.size * cells.place * (strain - state.strain)).sum())
    lost = lost_energy(held, cells.rubber) - lost_energy(state.held, cells.rubber)
    return Rubber(
        pull=pull,
        tension=tension,
        strain=strain,
        held=held,
        slip=slip,
        heat=state.heat + rubbed + (volume * lost).sum(),
        stored=(volume * elastic_energy(energy, held, cells.rubber)).sum(),
        beyond=state.beyond | (drive(cells.most, slip)[0] > 0) & (pull >= cells.most * (1 - 1e-9)),
    )


def along_slip(slip: Any, vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Force [N], elastic energy and heat [J] along a slip history [m], both of shape (N,).

    NaN once the vacuum [Pa] falls on a stretched strip, the strip would have to be pushed, or the
    strain goes beyond what was fitted.
    """
    cells = cells_for(slip.max(), vacuum.min(), vacuum.max(), brake)

    def step(carry: tuple[Rubber, Any, Any], point: tuple[Any, Any]) -> Any:
        state, before, lost = carry
        target, pressure = point

        def drive(pull: Any, slip: Any) -> tuple[Any, Any, Any]:
            return target - slip, 0.0 * pull, -jnp.ones_like(slip)

        friction = strip_at(pressure, brake).friction
        made = jax.lax.cond(
            target == state.slip, lambda: state, lambda: follow(state, drive, friction, cells)
        )
        lost = lost | made.beyond | ((pressure < before) & (state.slip > 0)) | (target < 0)
        lost = lost | (jnp.abs(made.slip - target) > 1e-9 * (jnp.abs(target) + state.slip))
        out = tuple(jnp.where(lost, jnp.nan, v) for v in (2 * made.pull, made.stored, made.heat))
        return (made._replace(slip=target), pressure, lost), out

    start = (relaxed(cells), vacuum[0], jnp.array(False))
    return jax.lax.scan(step, start, (slip, vacuum))[1]
