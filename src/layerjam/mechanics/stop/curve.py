"""Stop of a mass by any brake in first loading, from its kinetic energy along the slip.

Slip, force, heat and elastic energy of a brake are explicit and smooth in one coordinate w. It is
the square root of the slip, or the strain at the ends of a hyperelastic enclosure. With Y the force
and k the spring in series, the mass M moves by z = s + Y/k, and

    dK/dw = (M g - Y) (s' + Y'/k).

So K falls until the falling force equals the weight. If rubber stiffens, K then rises until the
rising force equals the weight, and falls from there. Each of the two falls has at most one root.
"""

from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import EnclosureLaw, brake_enclosure
from layerjam.mechanics.fan import Sheets, fan_force, fan_tangent, fan_work, solve_fan
from layerjam.mechanics.friction import sheet_law
from layerjam.mechanics.hyperelastic import FirstLoading, Strip
from layerjam.mechanics.law import keep_if, safe_sqrt
from layerjam.mechanics.roots import first_fall, newton_root
from layerjam.mechanics.stop.algebra import (
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
from layerjam.mechanics.stop.timing import (
    MARGIN,
    Expand,
    Expansion,
    expand_energy,
    expand_quartic,
    pieces_time,
)


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
        return self.sheets.fan is None and isinstance(self.enclosure, EnclosureLaw)

    def make_setup(self, load: Mass) -> Setup:
        """Return the constants of those closed forms for a mass."""
        c, overlap, strip = self.sheets.c, self.sheets.overlap, cast(EnclosureLaw, self.enclosure)
        return make_setup(load.mass, load.speed, c, overlap, strip, load.k, load.gravity)

    def point_at(self, w: Any) -> FirstLoading:
        """Return the brake at a coordinate, which is zero at the start."""
        enclosure = self.enclosure.point_at(w)
        slip, slope = enclosure.slip, enclosure.slip_slope
        heat = fan_work(jnp.zeros_like(slip), slip, self.sheets)
        return enclosure._replace(
            force=enclosure.force + fan_force(slip, self.sheets),
            heat=enclosure.heat + heat,
            force_slope=enclosure.force_slope - fan_tangent(slip, self.sheets).c * slope,
        )

    def find_turns(self, weight: Any, w_end: Any) -> tuple[Any, Any]:
        """Return the w up to `w_end` of the lowest K for a weight [N], and of the highest K after.

        There is no gradient.
        """
        strip = self.enclosure
        if isinstance(strip, Strip):

            def excess(w: Any) -> Any:
                return self.point_at(w).force - weight

            least = first_fall(excess, jnp.zeros_like(w_end), w_end)[0]
            return least, first_fall(lambda w: -excess(w), least, w_end)[0]

        def find_balance(line: Sheets) -> Any:
            # use a unit mass, with the gravity that gives it this weight
            case = make_setup(1.0, 0.0, line.c, line.overlap, strip, 1.0, weight)
            return balance_root(case, jnp.inf) ** 2

        constants = jax.lax.stop_gradient(self.sheets)
        least = safe_sqrt(solve_fan(find_balance, 0.0 * w_end, constants))
        return jax.lax.stop_gradient(jnp.minimum(least, w_end)), w_end

    def expand(self, load: Mass) -> Expand:
        """Return the expansion of K, in closed form if there is one."""
        if not self.is_quartic:

            def slope(w: Any) -> Any:
                point = self.point_at(w)
                return (load.weight - point.force) * _mass_slope(point, load)

            return expand_energy(lambda w: mass_energy(self.point_at(w), load), slope)
        case = self.make_setup(load)

        def expand_at(end: Any, sign: Any) -> Expansion:
            inside = end + sign * MARGIN * jnp.maximum(end, 1e-6)
            return expand_quartic(quartic(case, inside > self.enclosure.kink), end, sign)

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
    constants, constant = jax.lax.stop_gradient((curve, load))

    def falls(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        point = constants.point_at(state[0])
        return (
            -mass_energy(point, constant),
            (point.force - constant.weight) * _mass_slope(point, constant),
            None,
        )

    zero = 0.0 * constants.point_at(0.0 * constant.mass).force
    end = curve.enclosure.find_place(travel + zero)
    cut = jnp.isnan(end)
    end = jnp.where(cut, curve.enclosure.limit, end)
    last = jax.lax.stop_gradient(end)
    w_end, snaps = first_fall(lambda w: _mass_slope(constants.point_at(w), constant), zero, last)
    peak = first_fall(lambda w: constants.point_at(w).force_slope, zero, w_end)[0]
    least = first_fall(lambda w: constants.point_at(w).force - constant.weight, zero, w_end)[0]
    early, late = (falls((w, None))[0] >= 0 for w in (least, w_end))
    stops = early | late
    low, high = jnp.where(early, zero, least), jnp.where(early, least, w_end)
    root = newton_root(falls, (low + high) / 2, low, high)
    point, slope = curve.point_at(root), -falls((root, None))[1]
    down = slope < 0
    root = root - jnp.where(down, mass_energy(point, load) / jnp.where(down, slope, -1.0), 0.0)
    onset = curve.point_at(zero).force
    elastic = load.weight + safe_sqrt(load.weight**2 + 2 * load.k * load.arrival_energy)
    slides = elastic > onset
    w = jnp.where(stops, jnp.maximum(root, 0.0), jnp.where(snaps, w_end, end))
    final = curve.point_at(jnp.where(slides, w, 0.0))
    top = jnp.maximum(curve.point_at(jnp.minimum(w, peak)).force, onset)
    left = jnp.where(stops | ~slides, 0.0, jnp.maximum(mass_energy(final, load), 0.0))
    outcome = jnp.where(cut, NOT_A_CASE, BOTTOMED_OUT)
    outcome = jnp.where(stops, STOPPED, jnp.where(snaps, SNAPS, outcome))
    return Stop(
        final.slip,
        jnp.where(slides, jnp.maximum(top, final.force), elastic),
        safe_sqrt(2 * left / load.mass),
        final.heat,
        jnp.where(slides, final.force, elastic) ** 2 / (2 * load.k) + final.stored,
        jnp.where(slides, outcome, NEVER_SLID),
    )


def sliding_time(slip: Any, curve: Curve, load: Mass) -> Any:
    """Return the time [s] from the first slip to a slip [m], up to the standstill."""
    end = curve.enclosure.find_place(slip)
    turns = curve.find_turns(load.weight, end)
    kink = jnp.minimum(curve.enclosure.kink, end)
    cuts = jnp.stack([jnp.zeros_like(end), *turns, kink, end])

    def pace(w: Any) -> Any:
        return _mass_slope(curve.point_at(w), load)

    def falls(w: Any) -> Any:
        return curve.point_at(w).force > load.weight

    expand = curve.expand(load)
    return keep_if(end >= 0, pieces_time(jnp.sort(cuts, axis=0), expand, falls, pace, load.mass))
