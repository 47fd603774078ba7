"""Stop of a mass by any brake in first loading, from its kinetic energy along the slip.

Slip, force, heat and elastic energy of a brake are explicit and smooth in one coordinate w. It is
the square root of the slip, or the strain at the ends of a hyperelastic enclosure. With Y the force
and k the spring in series, the mass M moves by z = s + Y/k, and

    dK/dw = (M g - Y) (s' + Y'/k).

So K falls until the falling force equals the weight. If rubber stiffens, K then rises until the
rising force equals the weight, and falls from there. Each of the two falls has at most one root.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, cast

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import freeze, xp
from layerjam.brake.mechanics.enclosure import EnclosureLaw, brake_enclosure
from layerjam.brake.mechanics.friction import sheet_law
from layerjam.brake.mechanics.hyperelastic import FirstLoading, Strip
from layerjam.brake.mechanics.law import keep_if, safe_sqrt
from layerjam.brake.mechanics.roots import first_fall, newton_root, sample
from layerjam.brake.mechanics.slip_effects import (
    Sheets,
    find_equilibrium,
    friction_force,
    friction_tangent,
    friction_work,
)
from layerjam.brake.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
    Setup,
    Stop,
    balance_root,
    make_setup,
    quartic,
)
from layerjam.brake.mechanics.stop.duration import (
    MARGIN,
    Course,
    Expand,
    Expansion,
    expand_course,
    expand_quartic,
    pieces_time,
)

ROUNDING = 1e-9
"""Error of a kinetic energy relative to the energy that was turned into work."""


class Mass(NamedTuple):
    """A mass that arrives on a taut rope."""

    mass: Any
    speed: Any
    k: Any
    """Stiffness of rope and brake in series [N/m]."""
    gravity: Any

    @property
    def arrival_energy(self) -> Any:
        """Return the kinetic energy on arrival [J]."""
        return self.mass * self.speed**2 / 2

    @property
    def weight(self) -> Any:
        """Return the weight [N]."""
        return self.mass * self.gravity


class Curve(NamedTuple):
    """First loading of a brake at one vacuum over the coordinate w of its enclosure."""

    sheets: Sheets
    enclosure: EnclosureLaw | Strip

    @property
    def is_quartic(self) -> bool:
        """Return whether K is a quartic in w, so that closed forms apply."""
        return not self.sheets.shapes and isinstance(self.enclosure, EnclosureLaw)

    def make_setup(self, load: Mass) -> Setup:
        """Return the constants of those closed forms for a mass."""
        c, overlap, strip = self.sheets.c, self.sheets.overlap, cast(EnclosureLaw, self.enclosure)
        return make_setup(load.mass, load.speed, c, overlap, strip, load.k, load.gravity)

    def point_at(self, w: Any) -> FirstLoading:
        """Return the brake at a coordinate, which is zero at the start."""
        enclosure = self.enclosure.point_at(w)
        slip, slope = enclosure.slip, enclosure.slip_slope
        heat = friction_work(xp.zeros_like(slip), slip, self.sheets)
        return enclosure._replace(
            force=enclosure.force + friction_force(slip, self.sheets),
            heat=enclosure.heat + heat,
            force_slope=enclosure.force_slope - friction_tangent(slip, self.sheets).c * slope,
        )

    def find_turns(self, weight: Any, w_end: Any) -> tuple[Any, Any]:
        """Return the w up to `w_end` of the lowest K for a weight [N], and of the highest K after.

        There is no gradient.
        """
        strip = self.enclosure
        if isinstance(strip, Strip):

            def excess(w: Any) -> Any:
                return self.point_at(w).force - weight

            least = first_fall(excess, xp.zeros_like(w_end), w_end)[0]
            return least, first_fall(lambda w: -excess(w), least, w_end)[0]

        def find_balance(line: Sheets) -> Any:
            # use a unit mass, with the gravity that gives it this weight
            case = make_setup(1.0, 0.0, line.c, line.overlap, strip, 1.0, weight)
            return balance_root(case, xp.inf) ** 2

        constants = freeze(self.sheets)
        least = safe_sqrt(find_equilibrium(find_balance, 0.0 * w_end, constants))
        return freeze(xp.minimum(least, w_end)), w_end

    def expand(self, load: Mass) -> Expand:
        """Return the expansion of the mass's course, in closed form if there is one."""
        if not self.is_quartic:

            def course(w: Any) -> Course:
                point = self.point_at(w)
                pace = _mass_slope(point, load)
                return Course(mass_energy(point, load), (load.weight - point.force) * pace, pace)

            return expand_course(course)
        case, strip = self.make_setup(load), cast(EnclosureLaw, self.enclosure)

        def expand_at(end: Any, sign: Any) -> Expansion:
            linear = end + sign * MARGIN * xp.maximum(end, 1e-6) > strip.kink
            stiffening = xp.where(linear, strip.stiffness / strip.reach, 0.0) - case.c
            start = xp.where(linear, 0.0, strip.root) * case.compliance
            pace = start, 2 * (1 + stiffening * case.compliance)
            return expand_quartic(quartic(case, linear), pace, end, sign)

        return expand_at


def make_curve(vacuum: Any, brake: Brake) -> Curve:
    """Return the first loading of a brake at a vacuum [Pa]."""
    return Curve(sheet_law(vacuum, brake), brake_enclosure(vacuum, brake))


def mass_energy(point: FirstLoading, load: Mass) -> Any:
    """Return the kinetic energy K of the mass [J]."""
    loss = point.work + point.force**2 / (2 * load.k)
    return load.arrival_energy + load.weight * (point.slip + point.force / load.k) - loss


def _mass_slope(point: FirstLoading, load: Mass) -> Any:
    """Return the slope of the mass's position versus the coordinate; below zero the brake snaps."""
    return point.slip_slope + point.force_slope / load.k


def solve_stop(curve: Curve, travel: Any, load: Mass) -> Stop:
    """Return the outcome within a travel [m]; all of the same shape except the brake's numbers.

    NOT_A_CASE if the mass would stretch the enclosure beyond the strain that was fitted.
    """
    constants, constant = freeze((curve, load))

    def falls(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        point = constants.point_at(state[0])
        return (
            -mass_energy(point, constant),
            (point.force - constant.weight) * _mass_slope(point, constant),
            None,
        )

    zero = 0.0 * constants.point_at(0.0 * constant.mass).force
    end = curve.enclosure.find_place(travel + zero)
    cut = xp.isnan(end)
    end = xp.where(cut, curve.enclosure.limit, end)
    last = freeze(end)
    points = constants.point_at(sample(zero, last))

    def find_fall(value: Callable[[FirstLoading], Any]) -> tuple[Any, Any]:
        return first_fall(lambda w: value(constants.point_at(w)), zero, last, value(points))

    w_end, snaps = find_fall(lambda point: _mass_slope(point, constant))
    peak = xp.minimum(find_fall(lambda point: point.force_slope)[0], w_end)
    least = xp.minimum(find_fall(lambda point: point.force - constant.weight)[0], w_end)
    early, late = (falls((w, None))[0] >= 0 for w in (least, w_end))
    stops = early | late
    low, high = xp.where(early, zero, least), xp.where(early, least, w_end)
    root = newton_root(falls, (low + high) / 2, low, high)
    point, slope = curve.point_at(root), -falls((root, None))[1]
    down = slope < 0
    root = root - xp.where(down, mass_energy(point, load) / xp.where(down, slope, -1.0), 0.0)
    onset = curve.point_at(zero).force
    elastic = load.weight + safe_sqrt(load.weight**2 + 2 * load.k * load.arrival_energy)
    slides = elastic > onset
    w = xp.where(stops, xp.maximum(root, 0.0), xp.where(snaps, w_end, end))
    final = curve.point_at(xp.where(slides, w, 0.0))
    top = xp.maximum(curve.point_at(xp.minimum(w, peak)).force, onset)
    left = xp.where(stops | ~slides, 0.0, xp.maximum(mass_energy(final, load), 0.0))
    outcome = xp.where(cut, NOT_A_CASE, BOTTOMED_OUT)
    outcome = xp.where(stops, STOPPED, xp.where(snaps, SNAPS, outcome))
    return Stop(
        final.slip,
        xp.where(slides, xp.maximum(top, final.force), elastic),
        safe_sqrt(2 * left / load.mass),
        final.heat,
        xp.where(slides, final.force, elastic) ** 2 / (2 * load.k) + final.stored,
        xp.where(slides, outcome, NEVER_SLID),
    )


def energy_left(slip: Any, curve: Curve, load: Mass) -> Any:
    """Return the kinetic energy [J] at a slip [m]; NaN if a standstill or a snap comes before.

    A standstill may lie at zero or, by rounding, slightly below.
    """
    end = curve.enclosure.find_place(slip)
    path, mass, last = freeze((curve, load, end))
    least, energy = path.find_turns(mass.weight, last)[0], mass_energy(curve.point_at(end), load)
    low = xp.minimum(mass_energy(path.point_at(least), mass), freeze(energy))
    if path.is_quartic:  # the slope has one sign after the first change, so its end tells
        is_taut = _mass_slope(path.point_at(last), mass) >= 0
    else:
        is_taut = ~first_fall(lambda w: _mass_slope(path.point_at(w), mass), 0.0 * last, last)[1]
    size = mass.arrival_energy + mass.weight * slip
    return keep_if(is_taut & (low >= -ROUNDING * size), xp.maximum(energy, 0.0))


def sliding_time(slip: Any, curve: Curve, load: Mass) -> Any:
    """Return the time [s] from the first slip to a slip [m], up to the standstill."""
    end = curve.enclosure.find_place(slip)
    turns = curve.find_turns(load.weight, end)
    kink = xp.minimum(curve.enclosure.kink, end)
    cuts = xp.stack([xp.zeros_like(end), *turns, kink, end])

    def falls(w: Any) -> Any:
        return curve.point_at(w).force > load.weight

    time = pieces_time(xp.sort(cuts, axis=0), curve.expand(load), falls, load.mass)
    return keep_if(end >= 0, time)
