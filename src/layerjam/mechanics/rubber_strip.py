"""The enclosure with a hyperelastic law under any slip, as a strip of cells that stick and slide.

A cell at a distance s from the driven end of a half face is coupled to that end only by the
friction in between, which carries at most q s. Its tension follows the end tension N0 with play,

N(s) = the old N(s), kept between N0 - q s and N0 + q s,

for every law in which a cell's tension rises with its strain and depends on nothing else (Masing's
rule is the special case of a strain linear in the tension). So no contact problem has to be solved
for a move: the only unknown is N0. A cell's strain follows from its tension and from its largest
strain so far. The cells act as springs with Coulomb friction between them, so that work, heat and
elastic energy balance exactly. The error falls with the square of the number of cells.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.device.hyperelastic import Hyperelastic
from layerjam.mechanics.cycle import Cycle
from layerjam.mechanics.fan import fan_force, fan_tangent, fan_work
from layerjam.mechanics.friction import sheet_law
from layerjam.mechanics.hyperelastic import (
    make_strip,
    rubber_energy,
    rubber_slope,
    rubber_stress,
)
from layerjam.mechanics.roots import newton_root
from layerjam.mechanics.softening import elastic_energy, lost_energy, softening
from layerjam.mechanics.stiffness import working_stiffness

CELLS = 240
"""Number of cells in half a face."""
Drive = Callable[[Any, Any], tuple[Any, Any, Any]]
"""Function of end tension [N] and slip [m] that returns a falling residual and its two slopes."""


class Cells(NamedTuple):
    """Half of one face."""

    place: Any
    """Distance of the cells' middles from the driven end [m], shape (cells,)."""
    size: Any
    """Lengths of the cells [m]."""
    section: Any
    rubber: Hyperelastic
    top: Any
    """Tension of the end at the largest fitted strain [N]."""


class Rubber(NamedTuple):
    """State of the enclosure: half a face, representative of all four halves."""

    pull: Any
    """Tension of the end of a face [N]."""
    tension: Any
    """Tensions of the cells [N], shape (cells,)."""
    strain: Any
    """Strains of the cells [-]."""
    peak_energy: Any
    """Highest energy density of the cells so far [Pa]."""
    slip: Any
    heat: Any
    """Friction heat, and energy lost by softening [J]."""
    stored: Any
    is_exceeded: Any
    """True once the rubber was strained beyond the fitted range."""


def make_cells(slip: Any, least: Any, highest: Any, brake: Brake, count: int = CELLS) -> Cells:
    """Return cells for histories up to a slip [m], between a lowest and a highest vacuum [Pa].

    They cover the part that can move, and are small near the driven end, where reversals start.
    """
    strip, full = make_strip(least, brake), make_strip(highest, brake)
    rubber, force = full.rubber, full.force(slip)
    top = strip.section * rubber_stress(rubber.strain + 0.0 * slip, rubber)
    pull = jnp.where(jnp.isnan(force), top, force / 2)
    rubs = strip.friction * strip.reach > pull
    moves = jnp.where(rubs, pull / jnp.where(rubs, strip.friction, 1.0), strip.reach)
    edges = moves * jnp.linspace(0.0, 1.0, count + 1) ** 2
    return Cells((edges[1:] + edges[:-1]) / 2, jnp.diff(edges), strip.section, rubber, top)


def new_strip(cells: Cells) -> Rubber:
    """Return a new enclosure that was never stretched."""
    none, zero = jnp.zeros_like(cells.place), jnp.array(0.0)
    return Rubber(zero, none, none, none, zero, zero, zero, jnp.array(False))


def _stress(strain: Any, peak_energy: Any, rubber: Hyperelastic) -> tuple[Any, Any]:
    """Return the stress [Pa] at a strain, and its slope, of a point that has reached an energy."""
    first = rubber_stress(strain, rubber)
    eta, steep = softening(rubber_energy(strain, rubber), peak_energy, rubber)
    return eta * first, eta * rubber_slope(strain, rubber) + steep * first**2


def _solve_strain(tension: Any, peak_energy: Any, guess: Any, cells: Cells) -> Any:
    """Return the strain of the cells [-] at their tension [N]."""

    def excess(state: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        stress, slope = _stress(state[0], peak_energy, cells.rubber)
        return stress - tension / cells.section, slope, state[1]

    top = cells.rubber.strain * 1.01 + 0.0 * tension
    # the lower end is below zero only for the search, so that a strain of zero is not at the end
    strain = newton_root(excess, guess, jnp.full_like(tension, -0.1), top, 0.0)
    return jnp.where(tension > 0, jnp.maximum(strain, 0.0), 0.0)


def move_strip(state: Rubber, drive: Drive, friction: Any, cells: Cells) -> Rubber:
    """Return the strip after a move in one direction up to `drive`, at a friction [N/m]."""

    def strip_at_pull(pull: Any, guess: Any) -> tuple[Any, Any]:
        bears = friction * cells.place
        tension = jnp.clip(state.tension, pull - bears, pull + bears)
        return tension, _solve_strain(tension, state.peak_energy, guess, cells)

    def excess(point: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        tension, strain = strip_at_pull(*point)
        steep = _stress(strain, state.peak_energy, cells.rubber)[1] * cells.section
        moves = jnp.abs(point[0] - tension) >= friction * cells.place * (1 - 1e-12)
        slip = 2 * (cells.size * strain).sum()
        rises = 2 * jnp.where(moves, cells.size / steep, 0.0).sum()
        residual, over_pull, over_slip = drive(point[0], slip)
        return -residual, -(over_pull + over_slip * rises), strain

    pull = newton_root(excess, state.pull, jnp.zeros_like(cells.top), cells.top, state.strain)
    tension, strain = strip_at_pull(pull, state.strain)
    energy = rubber_energy(strain, cells.rubber)
    peak_energy = jnp.maximum(state.peak_energy, energy)
    slip, volume = 2 * (cells.size * strain).sum(), 4 * cells.section * cells.size
    rubbing = 4 * friction * jnp.abs((cells.size * cells.place * (strain - state.strain)).sum())
    loss = lost_energy(peak_energy, cells.rubber) - lost_energy(state.peak_energy, cells.rubber)
    return Rubber(
        pull=pull,
        tension=tension,
        strain=strain,
        peak_energy=peak_energy,
        slip=slip,
        heat=state.heat + rubbing + (volume * loss).sum(),
        stored=(volume * elastic_energy(energy, peak_energy, cells.rubber)).sum(),
        is_exceeded=state.is_exceeded
        | (drive(cells.top, slip)[0] > 0) & (pull >= cells.top * (1 - 1e-9)),
    )


def follow_slip(slip: Any, vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Return force [N], elastic energy and heat [J] along a slip history [m], both of shape (N,).

    NaN once the vacuum [Pa] falls on a stretched strip, if the strip would have to be pushed, or if
    the strain exceeds the fitted range.
    """
    cells = make_cells(slip.max(), vacuum.min(), vacuum.max(), brake)

    def step(carry: tuple[Rubber, Any, Any], point: tuple[Any, Any]) -> Any:
        state, before, bad = carry
        target, pressure = point

        def drive(pull: Any, slip: Any) -> tuple[Any, Any, Any]:
            return target - slip, 0.0 * pull, -jnp.ones_like(slip)

        friction = make_strip(pressure, brake).friction
        strip = jax.lax.cond(
            target == state.slip, lambda: state, lambda: move_strip(state, drive, friction, cells)
        )
        bad = bad | strip.is_exceeded | ((pressure < before) & (state.slip > 0)) | (target < 0)
        bad = bad | (jnp.abs(strip.slip - target) > 1e-9 * (jnp.abs(target) + state.slip))
        out = tuple(jnp.where(bad, jnp.nan, v) for v in (2 * strip.pull, strip.stored, strip.heat))
        return (strip._replace(slip=target), pressure, bad), out

    start = (new_strip(cells), vacuum[0], jnp.array(False))
    return jax.lax.scan(step, start, (slip, vacuum))[1]


class _State(NamedTuple):
    enclosure: Rubber
    force: Any
    work: Any
    heat: Any
    vacuum: Any
    has_closed: Any
    has_snapped: Any
    is_invalid: Any
    """True once the vacuum has fallen under load, or the strain is outside the fitted range."""


def rubber_cycle(elongation: Any, vacuum: Any, brake: Brake) -> Cycle:
    """Return the brake along an elongation history [m] at a vacuum [Pa] that never falls, (N,).

    Like `brake_cycle` for one modulus. NaN once the vacuum has fallen on a brake that is not
    relaxed, or once the enclosure is stretched beyond the fitted strain.
    """
    k, overlap = jnp.asarray(working_stiffness(brake), jnp.float64), brake.sheets.overlap
    cells = make_cells(elongation.max(), vacuum.min(), vacuum.max(), brake)

    def step(state: _State, point: tuple[Any, Any]) -> tuple[_State, Cycle]:
        target, pressure = point
        before, sheets = state.enclosure, sheet_law(pressure, brake)
        friction = make_strip(pressure, brake).friction
        trial, hold = k * (target - before.slip), fan_force(before.slip, sheets)
        out = trial > 2 * before.pull + hold
        returns = jnp.maximum(trial, 0.0) < 2 * before.pull - hold
        sign = jnp.where(out, 1.0, -1.0)

        def drive(pull: Any, slip: Any) -> tuple[Any, Any, Any]:
            # when the rope is slack, the enclosure closes the brake against the sheets' friction
            taut = k * (target - slip)
            residual = jnp.maximum(taut, 0.0) - 2 * pull - sign * fan_force(slip, sheets)
            over_slip = sign * fan_tangent(slip, sheets).c - jnp.where(taut > 0, k, 0.0)
            return residual, -2.0 + 0.0 * pull, over_slip

        strip = jax.lax.cond(
            out | returns, lambda: move_strip(before, drive, friction, cells), lambda: before
        )
        force = jnp.maximum(k * (target - strip.slip), 0.0)
        heat = jnp.abs(fan_work(before.slip, strip.slip, sheets)) + strip.heat - before.heat
        elastic = (force**2 - state.force**2) / (2 * k)
        falls = (pressure < state.vacuum) & ((before.slip > 0) | (state.force > 0))
        new = _State(
            enclosure=strip,
            force=force,
            work=state.work + heat + (strip.stored - before.stored) + elastic,
            heat=state.heat + heat,
            vacuum=pressure,
            has_closed=state.has_closed | (before.slip - strip.slip > 1e-12 * overlap),
            has_snapped=state.has_snapped | (out & (k <= fan_tangent(before.slip, sheets).c)),
            is_invalid=state.is_invalid | falls | strip.is_exceeded,
        )
        fine = (target >= 0) & (pressure >= 0) & ~(new.has_snapped | new.is_invalid)
        return new, Cycle(
            force=jnp.where(fine, force, jnp.nan),
            slip=strip.slip,
            sleeve_force=2 * strip.pull,
            work=new.work,
            heat=new.heat,
            stored=strip.stored + force**2 / (2 * k),
            slack=(force <= 0) & (target < strip.slip),
            closed=new.has_closed,
            separated=strip.slip >= overlap * (1 - 1e-12),
            overflow=jnp.array(False),
            snapped=new.has_snapped,
        )

    zero, no = jnp.array(0.0), jnp.array(False)
    start = _State(new_strip(cells), zero, zero, zero, vacuum[0], no, no, no)
    return jax.lax.scan(step, start, (elongation, vacuum))[1]
