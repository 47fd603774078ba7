"""The enclosure in first loading with a hyperelastic law instead of a single modulus (ours).

Each half of a face is a strip of section A, pulled at its end against the friction q = mu_e W P per
unit length. The tension falls along it, dN/ds = -q, from A sigma(e0) at the end to zero, or to A
sigma(e_m) in the middle once the whole face moves. With ds = A sigma'(e) de/q the slip is

    x/2 = integral of e ds = A/q integral of e sigma'(e) de = W*(N)/q,

where W* is the complementary energy; sigma = E e gives the law of `enclosure`. Every integral over
the strip is its length times a mean over the strain with the weight sigma', which is also true
without friction. The only unknown is the strain at the end.

First loading at constant vacuum only; see `rubber_strip` for unloading and reloading.
"""

from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import (
    Hyperelastic,
    ogden_terms,
    uniaxial_slope,
    uniaxial_stress,
)
from layerjam.brake.mechanics.arrays import choose, freeze, xp
from layerjam.brake.mechanics.law import keep_if, law
from layerjam.brake.mechanics.roots import carry_gradient, newton_root, rising_zero
from layerjam.brake.mechanics.softening import lost_energy
from layerjam.core.errors import QuantityError

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_NODES, _WEIGHTS = (_NODES + 1) / 2, _WEIGHTS / 2


def rubber_stress(strain: Any, rubber: Hyperelastic) -> Any:
    """Return `uniaxial_stress` [Pa] at a strain [-], in JAX."""
    return uniaxial_stress(strain, rubber, xp)


def rubber_energy(strain: Any, rubber: Hyperelastic) -> Any:
    """Return the elastic energy per volume [Pa] of uniaxial tension at a strain [-]."""
    stretch, total = 1 + strain, xp.zeros(xp.shape(strain))
    first = strain**2 * (stretch + 2) / stretch
    for coefficient, term in (
        (rubber.c10, first),
        (rubber.c01, strain**2 * (2 * stretch + 1) / stretch**2),
        (rubber.c20, first**2),
        (rubber.c30, first**3),
    ):
        if coefficient is not None:
            total = total + coefficient * term
    log = xp.log1p(strain)
    for mu, alpha in ogden_terms(rubber):
        side = xp.exp(-alpha / 2 * log)
        change = xp.expm1(-alpha / 2 * log)
        total = total + mu / alpha * change**2 * (2 * side + 1) / side**2
    return total


class FirstLoading(NamedTuple):
    """The enclosure (both faces) or a whole brake in first loading, at a coordinate."""

    slip: Any
    """Slip [m]."""
    force: Any
    """Force [N]."""
    stored: Any
    """Elastic energy [J]."""
    heat: Any
    """Friction heat, and energy lost by softening of the rubber, since the relaxed state [J]."""
    slip_slope: Any
    """Slope of the slip versus the coordinate."""
    force_slope: Any

    @property
    def work(self) -> Any:
        """Return the external work of the first loading [J]."""
        return self.stored + self.heat


class Strip(NamedTuple):
    """Half of one face at a vacuum; the methods describe both faces in first loading.

    The coordinate is the strain at the ends of the faces.
    """

    section: Any
    """A = W w_e [m^2]."""
    friction: Any
    """q = mu_e W P [N/m]."""
    reach: Any
    """Half the free length l [m]."""
    rubber: Hyperelastic

    def load_to(self, slip: Any) -> FirstLoading:
        """Return the enclosure at a slip [m]; NaN beyond the fitted strain."""
        return self.point_at(self.find_place(slip))

    def force(self, slip: Any) -> Any:
        """Return the force [N] at a slip [m]."""
        return self.load_to(slip).force

    def work(self, slip: Any) -> Any:
        """Return the integral of the force from 0 to a slip [J]."""
        return self.load_to(slip).work

    def heat(self, slip: Any) -> Any:
        """Return the heat at a slip [J]."""
        return self.load_to(slip).heat

    def stretch(self, slip: Any) -> Any:
        """Return the strain at the ends of the faces [-]."""
        return self.find_place(slip)

    def find_slip(self, drive: Any, spring: Any) -> Any:
        """Return x >= 0 with spring x + f(x) = drive [N]; 0 for drive <= 0."""
        return self.point_at(end_strain(drive, spring, 1.0, self)).slip

    @property
    def limit(self) -> Any:
        """Return the largest fitted coordinate."""
        return self.rubber.strain

    @property
    def kink(self) -> Any:
        """Return the coordinate above which the whole enclosure moves, at most `limit`."""
        full_stress = self.friction * self.reach / self.section
        top = xp.zeros_like(full_stress) + self.rubber.strain
        return rising_zero(
            lambda e: rubber_stress(e, self.rubber) - full_stress, 0.0 * full_stress, top
        )

    def find_place(self, slip: Any) -> Any:
        """Return the coordinate at a slip [m]; NaN beyond `limit`."""
        return end_strain(slip, 1.0, 0.0, self)

    def point_at(self, strain: Any) -> FirstLoading:
        """Return the enclosure at a coordinate; zero there without NaN in the gradient."""
        rests = strain <= 0
        point = load_strip(xp.where(rests, 1e-9, strain), self)
        return FirstLoading(*(xp.where(rests, 0.0, part) for part in point))


def make_strip(vacuum: Any, brake: Brake) -> Strip:
    """Return half a face at a vacuum [Pa]; QuantityError for a brake with a single modulus."""
    if brake.hyperelastic is None:
        raise QuantityError.of(
            "hyperelastic",
            "this result needs a hyperelastic enclosure; add [hyperelastic] to the brake",
        )
    sheets = brake.sheets
    reach = (sheets.free_left + sheets.overlap + sheets.free_right) / 2
    friction = brake.film.friction_on_silicone * sheets.width * vacuum
    return Strip(sheets.width * brake.enclosure.wall, friction, reach, brake.hyperelastic)


def rubber_slope(strain: Any, rubber: Hyperelastic) -> Any:
    """Return the slope of `rubber_stress` versus strain [Pa]."""
    return uniaxial_slope(strain, rubber, xp)


def _solve_middle(end: Any, pull: Any, strip: Strip) -> tuple[Any, Any]:
    """Return the strain in the middle of a face, and the moving length [m], at an end strain.

    `pull` is the stress there [Pa].
    """
    middle_stress = pull - strip.friction * strip.reach / strip.section
    is_moving = middle_stress > 0

    def find_middle(left: Any) -> Any:
        return xp.where(
            is_moving, strain_at(xp.where(is_moving, left, 0.0), end, pull, strip.rubber), 0.0
        )

    middle = choose(xp.any(is_moving), find_middle, xp.zeros_like, middle_stress)
    rubs = xp.where(is_moving, 1.0, strip.friction)
    return middle, xp.where(is_moving, strip.reach, strip.section * pull / rubs)


def strain_at(stress: Any, end: Any, pull: Any, rubber: Hyperelastic) -> Any:
    """Return the strain at a stress [Pa], at largest `end`, where the stress is `pull`."""
    aim, top, largest, law = freeze((stress, end, pull, rubber))

    def excess(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        return rubber_stress(state[0], law) - aim, rubber_slope(state[0], law), None

    guess = newton_root(excess, top * aim / largest, 0.0 * top, top)
    return carry_gradient(lambda e: rubber_stress(e, rubber) - stress, guess, 0.0 * end, end)


def load_strip(end: Any, strip: Strip) -> FirstLoading:
    """Return the enclosure once the strain at the ends of its faces is `end`, any shape."""
    end = end + 0.0 * strip.friction
    pull = rubber_stress(end, strip.rubber)
    middle, length = _solve_middle(end, pull, strip)
    axis = (...,) + (None,) * xp.ndim(end)
    strain = middle + (end - middle) * xp.asarray(_NODES)[axis]
    weight = rubber_slope(strain, strip.rubber) * xp.asarray(_WEIGHTS)[axis]
    mean = weight.sum(axis=0)
    weight = weight / mean
    stress, energy = rubber_stress(strain, strip.rubber), rubber_energy(strain, strip.rubber)
    loss = lost_energy(energy, strip.rubber)
    elastic = ((energy - loss) * weight).sum(axis=0)
    # a point is s = A (sigma0 - sigma)/q from the end; the integral of its slip is that of e s
    heat = ((strain * (pull - stress) + loss) * weight).sum(axis=0)
    volume, stiffness = 4 * strip.section * length, rubber_slope(end, strip.rubber)
    return FirstLoading(
        slip=2 * length * (strain * weight).sum(axis=0),
        force=2 * strip.section * pull,
        stored=volume * elastic,
        heat=volume * heat,
        # dx = 2 A/q sigma' (e0 - e_m) de, and A/q is the ratio of the length to sigma0 - sigma_m
        slip_slope=2 * length * stiffness / mean,
        force_slope=2 * strip.section * stiffness,
    )


def end_strain(drive: Any, spring: Any, with_force: float, strip: Strip) -> Any:
    """Return the end strain at which spring x + with_force F(x) = drive; 0 for a drive <= 0.

    NaN beyond the fitted strain, or for NaN. One Newton step carries the gradient.
    """

    def resistance(point: FirstLoading, spring: Any) -> Any:
        return spring * point.slip + with_force * point.force

    is_moving = ~(drive <= 0)  # also for NaN
    drive = xp.where(is_moving, drive, 1.0)
    drive, spring = xp.broadcast_arrays(drive + 0.0 * strip.friction, spring)
    aim, stiff, law = freeze((drive, spring, strip))
    top = xp.zeros_like(aim) + law.rubber.strain
    largest = resistance(load_strip(top, law), stiff)
    share = aim / largest
    is_met = share <= 1

    def excess(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        point = load_strip(state[0], law)
        slope = stiff * point.slip_slope + with_force * point.force_slope
        return resistance(point, stiff) - xp.where(is_met, aim, largest), slope, None

    # exact for a slip that grows with the square of the strain
    guess = newton_root(excess, top * xp.sqrt(xp.where(is_met, share, 1.0)), 0.0 * top, top)
    point = load_strip(guess, strip)
    slope = freeze(spring * point.slip_slope + with_force * point.force_slope)
    strain = guess + (drive - resistance(point, spring)) / slope
    return xp.where(is_moving, keep_if(is_met, strain), 0.0)


@law
def largest_slip(vacuum: Any, brake: Brake) -> Any:
    """Return the slip [m] at which the ends reach the largest fitted strain."""
    strip = make_strip(vacuum, brake)
    return load_strip(strip.rubber.strain + 0.0 * vacuum, strip).slip
