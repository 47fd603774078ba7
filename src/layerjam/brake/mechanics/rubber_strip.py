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

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.mechanics.arrays import choose, xp
from layerjam.brake.mechanics.cycle import Setting
from layerjam.brake.mechanics.hyperelastic import (
    Strip,
    make_strip,
    rubber_energy,
    rubber_slope,
    rubber_stress,
)
from layerjam.brake.mechanics.roots import newton_root
from layerjam.brake.mechanics.slip_effects import friction_force, friction_tangent
from layerjam.brake.mechanics.softening import elastic_energy, lost_energy, softening

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

    cells: Cells
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
    friction: Any
    """q at the last vacuum [N/m]."""
    is_invalid: Any
    """True once it was strained beyond the fitted range or pushed, or the vacuum fell while it was
    stretched.
    """

    @property
    def force(self) -> Any:
        """Return the force of both faces [N]."""
        return 2 * self.pull

    @property
    def overflow(self) -> Any:
        """Return False: no turns are stored."""
        return xp.zeros_like(self.is_invalid)

    def apply_vacuum(self, strip: Strip) -> "Rubber":
        """Return the state under a different vacuum at the same slip."""
        is_falling = (strip.friction < self.friction) & (self.slip > 0)
        return self._replace(friction=strip.friction, is_invalid=self.is_invalid | is_falling)

    def slide_to(self, slip: Any, strip: Strip) -> "Rubber":
        """Return the enclosure after a move to a slip [m]; it cannot be pushed."""

        def drive(pull: Any, at: Any) -> tuple[Any, Any, Any]:
            return slip - at, 0.0 * pull, -xp.ones_like(at)

        new = self._move(slip != self.slip, drive, strip)
        is_unreachable = (xp.abs(new.slip - slip) > 1e-9 * (xp.abs(slip) + self.slip)) | (slip < 0)
        return new._replace(slip=slip, is_invalid=new.is_invalid | is_unreachable)

    def balance(self, elongation: Any, out: Any, returns: Any, setting: Setting) -> "Rubber":
        """Return the enclosure after a move to an elongation [m], if it slides out or returns."""
        sign = xp.where(out, 1.0, -1.0)

        def drive(pull: Any, slip: Any) -> tuple[Any, Any, Any]:
            # when the rope is slack, the enclosure closes the brake against the sheets' friction
            taut = setting.k * (elongation - slip)
            residual = xp.maximum(taut, 0.0) - 2 * pull - sign * friction_force(slip, setting)
            fall = sign * friction_tangent(slip, setting).c
            return residual, -2.0 + 0.0 * pull, fall - xp.where(taut > 0, setting.k, 0.0)

        return self._move(out | returns, drive, setting.enclosure)

    def _move(self, moves: Any, drive: Drive, strip: Strip) -> "Rubber":
        return choose(moves, lambda: move_strip(self, drive, strip.friction), lambda: self)


def make_cells(slip: Any, lowest: Any, highest: Any, brake: Brake, count: int = CELLS) -> Cells:
    """Return cells for histories up to a slip [m], between a lowest and a highest vacuum [Pa].

    They cover the part that can move, and are small near the driven end, where reversals start.
    """
    least_strip, full_strip = make_strip(lowest, brake), make_strip(highest, brake)
    rubber, force = full_strip.rubber, full_strip.force(slip)
    top = least_strip.section * rubber_stress(rubber.strain + 0.0 * slip, rubber)
    pull = xp.where(xp.isnan(force), top, force / 2)
    rubs = least_strip.friction * least_strip.reach > pull
    moving_length = xp.where(
        rubs, pull / xp.where(rubs, least_strip.friction, 1.0), least_strip.reach
    )
    edges = moving_length * xp.linspace(0.0, 1.0, count + 1) ** 2
    return Cells((edges[1:] + edges[:-1]) / 2, xp.diff(edges), least_strip.section, rubber, top)


def new_strip(cells: Cells) -> Rubber:
    """Return a new enclosure that was never stretched."""
    no_slip, zero = xp.zeros_like(cells.place), xp.array(0.0)
    return Rubber(cells, zero, no_slip, no_slip, no_slip, zero, zero, zero, zero, xp.array(False))


def _stress(strain: Any, peak_energy: Any, rubber: Hyperelastic) -> tuple[Any, Any]:
    """Return the stress [Pa] at a strain, and its slope, of a point that has reached an energy."""
    first = rubber_stress(strain, rubber)
    eta, slope = softening(rubber_energy(strain, rubber), peak_energy, rubber)
    return eta * first, eta * rubber_slope(strain, rubber) + slope * first**2


def _solve_strain(tension: Any, peak_energy: Any, guess: Any, cells: Cells) -> Any:
    """Return the strain of the cells [-] at their tension [N]."""

    def excess(state: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        stress, slope = _stress(state[0], peak_energy, cells.rubber)
        return stress - tension / cells.section, slope, state[1]

    top = cells.rubber.strain * 1.01 + 0.0 * tension
    # the lower end is below zero only for the search, so that a strain of zero is not at the end
    strain = newton_root(excess, guess, xp.full_like(tension, -0.1), top, 0.0)
    return xp.where(tension > 0, xp.maximum(strain, 0.0), 0.0)


def move_strip(state: Rubber, drive: Drive, friction: Any) -> Rubber:
    """Return the strip after a move in one direction up to `drive`, at a friction [N/m]."""
    cells = state.cells

    def strip_at_pull(pull: Any, guess: Any) -> tuple[Any, Any]:
        bears = friction * cells.place
        tension = xp.clip(state.tension, pull - bears, pull + bears)
        return tension, _solve_strain(tension, state.peak_energy, guess, cells)

    def excess(point: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        tension, strain = strip_at_pull(*point)
        stiffness = _stress(strain, state.peak_energy, cells.rubber)[1] * cells.section
        is_moving = xp.abs(point[0] - tension) >= friction * cells.place * (1 - 1e-12)
        slip = 2 * (cells.size * strain).sum()
        tension_slope = 2 * xp.where(is_moving, cells.size / stiffness, 0.0).sum()
        residual, over_pull, over_slip = drive(point[0], slip)
        return -residual, -(over_pull + over_slip * tension_slope), strain

    pull = newton_root(excess, state.pull, xp.zeros_like(cells.top), cells.top, state.strain)
    tension, strain = strip_at_pull(pull, state.strain)
    energy = rubber_energy(strain, cells.rubber)
    peak_energy = xp.maximum(state.peak_energy, energy)
    slip, volume = 2 * (cells.size * strain).sum(), 4 * cells.section * cells.size
    rubbing = 4 * friction * xp.abs((cells.size * cells.place * (strain - state.strain)).sum())
    loss = lost_energy(peak_energy, cells.rubber) - lost_energy(state.peak_energy, cells.rubber)
    return Rubber(
        cells=cells,
        pull=pull,
        tension=tension,
        strain=strain,
        peak_energy=peak_energy,
        slip=slip,
        heat=state.heat + rubbing + (volume * loss).sum(),
        stored=(volume * elastic_energy(energy, peak_energy, cells.rubber)).sum(),
        friction=friction,
        is_invalid=state.is_invalid
        | (drive(cells.top, slip)[0] > 0) & (pull >= cells.top * (1 - 1e-9)),
    )
