"""Stop of a mass by any brake in first loading, from its kinetic energy along the slip.

Slip, force, heat and elastic energy of a brake are explicit and smooth in one coordinate w. It is
the square root of the slip, or the strain at the ends of a hyperelastic enclosure. With Y the force
and k the spring in series, the mass M moves by z = s + Y/k, and

    dK/dw = (M g - Y) (s' + Y'/k).

So K falls until the falling force equals the weight. If rubber stiffens, K then rises until the
rising force equals the weight, and falls from there. Each of the two falls has at most one root.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import (
    backbone,
    backbone_dissipated,
    backbone_stored,
    enclosure_law,
)
from layerjam.mechanics.fan import Sheets, fan_force, fan_tangent, fan_work, solve_fan
from layerjam.mechanics.friction import sheet_law
from layerjam.mechanics.hyperelastic import (
    FirstLoading,
    end_strain,
    load_strip,
    make_strip,
    saturation_strain,
)
from layerjam.mechanics.law import keep_if, safe_sqrt
from layerjam.mechanics.roots import first_fall, newton_root
from layerjam.mechanics.stop.algebra import (
    BOTTOMED_OUT,
    NEVER_SLID,
    NOT_A_CASE,
    SNAPS,
    STOPPED,
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
    def arriving(self) -> Any:
        """Return the kinetic energy on arrival [J]."""
        return self.mass * self.speed**2 / 2

    @property
    def weight(self) -> Any:
        """Return the weight [N]."""
        return self.mass * self.gravity


class Curve(NamedTuple):
    """First loading of a brake at one vacuum over its coordinate w, which is zero at the start."""

    point: Callable[[Any], FirstLoading]
    place: Callable[[Any], Any]
    """w at a slip [m]; NaN beyond the measured range."""
    w_max: Any
    """Largest fitted w."""
    kink: Any
    """w above which the whole enclosure moves; the slopes jump there."""
    turns: Callable[[Any, Any], tuple[Any, Any]]
    """Function of a largest w that returns the w up to it of the lowest K for a weight [N], and
    the w of the highest K after that; no gradient.
    """
    expand: Callable[[Mass], Expand] | None = None
    """Expansion of K in closed form, if there is one."""


def make_curve(vacuum: Any, brake: Brake) -> Curve:
    """Return the first loading of a brake at a vacuum [Pa]."""
    sheets = sheet_law(vacuum, brake)

    def add_sheets(enclosure: FirstLoading) -> FirstLoading:
        slip, slope = enclosure.slip, enclosure.slip_slope
        heat = fan_work(jnp.zeros_like(slip), slip, sheets)
        return enclosure._replace(
            force=enclosure.force + fan_force(slip, sheets),
            heat=enclosure.heat + heat,
            force_slope=enclosure.force_slope - fan_tangent(slip, sheets).c * slope,
        )

    if brake.hyperelastic is None:
        strip = enclosure_law(vacuum, brake)

        def at_root(w: Any) -> FirstLoading:
            slip = w**2
            linear = 2 * w * strip.stiffness / strip.reach
            slope = jnp.where(slip < strip.saturation, strip.root, linear)
            elastic, heat = backbone_stored(slip, strip), backbone_dissipated(slip, strip)
            pull = backbone(slip, strip)
            return add_sheets(FirstLoading(slip, pull, elastic, heat, 2 * w, slope))

        def balance(weight: Any, w_end: Any) -> tuple[Any, Any]:
            def meets(line: Sheets) -> Any:
                # use a unit mass, with the gravity that gives it this weight
                case = make_setup(1.0, 0.0, line.c, line.overlap, strip, 1.0, weight)
                return balance_root(case, jnp.inf) ** 2

            constants = jax.lax.stop_gradient(sheets)
            least = safe_sqrt(solve_fan(meets, 0.0 * w_end, constants))
            return jax.lax.stop_gradient(jnp.minimum(least, w_end)), w_end

        def expand(load: Mass) -> Expand:
            line = (sheets.c, sheets.overlap, strip)
            case = make_setup(load.mass, load.speed, *line, load.k, load.gravity)

            def around(end: Any, sign: Any) -> Expansion:
                inside = end + sign * MARGIN * jnp.maximum(end, 1e-6)
                return expand_quartic(quartic(case, inside > kink), end, sign)

            return around

        kink, closed_form = safe_sqrt(strip.saturation), expand if sheets.fan is None else None
        return Curve(at_root, safe_sqrt, jnp.inf, kink, balance, closed_form)
    rubber = make_strip(vacuum, brake)

    def at_strain(strain: Any) -> FirstLoading:
        moves = strain > 0
        point = load_strip(jnp.where(moves, strain, 1e-9), rubber)
        return add_sheets(FirstLoading(*(jnp.where(moves, part, 0.0) for part in point)))

    def place(slip: Any) -> Any:
        return end_strain(slip, jnp.ones_like(slip), 0.0, rubber)

    def crossings(weight: Any, w_end: Any) -> tuple[Any, Any]:
        def excess(strain: Any) -> Any:
            return at_strain(strain).force - weight

        least = first_fall(excess, jnp.zeros_like(w_end), w_end)[0]
        return least, first_fall(lambda strain: -excess(strain), least, w_end)[0]

    return Curve(at_strain, place, rubber.rubber.strain, saturation_strain(rubber), crossings)


def mass_energy(point: FirstLoading, load: Mass) -> Any:
    """Return the kinetic energy K of the mass [J]."""
    loss = point.work + point.force**2 / (2 * load.k)
    return load.arriving + load.weight * (point.slip + point.force / load.k) - loss


def _mass_slope(point: FirstLoading, load: Mass) -> Any:
    """Return the slope of the mass's position versus the coordinate; below zero the brake snaps."""
    return point.slip_slope + point.force_slope / load.k


def solve_stop(vacuum: Any, brake: Brake, load: Mass) -> Stop:
    """Return the outcome at a vacuum [Pa]; all of the same shape except the numbers of the brake.

    NOT_A_CASE if the mass would stretch the enclosure beyond the strain that was fitted.
    """
    curve = make_curve(vacuum, brake)
    constants = make_curve(*jax.lax.stop_gradient((vacuum, brake)))
    constant = jax.lax.stop_gradient(load)

    def falls(state: tuple[Any, None]) -> tuple[Any, Any, None]:
        point = constants.point(state[0])
        return (
            -mass_energy(point, constant),
            (point.force - constant.weight) * _mass_slope(point, constant),
            None,
        )

    zero = 0.0 * constants.point(0.0 * constant.mass).force
    travel = brake.sheets.usable_travel + zero
    end = curve.place(travel)
    cut = jnp.isnan(end)
    end = jnp.where(cut, curve.w_max, end)
    last = jax.lax.stop_gradient(end)
    w_end, snaps = first_fall(lambda w: _mass_slope(constants.point(w), constant), zero, last)
    peak = first_fall(lambda w: constants.point(w).force_slope, zero, w_end)[0]
    least = first_fall(lambda w: constants.point(w).force - constant.weight, zero, w_end)[0]
    early, late = (falls((w, None))[0] >= 0 for w in (least, w_end))
    stops = early | late
    low, high = jnp.where(early, zero, least), jnp.where(early, least, w_end)
    root = newton_root(falls, (low + high) / 2, low, high)
    point, slope = curve.point(root), -falls((root, None))[1]
    down = slope < 0
    root = root - jnp.where(down, mass_energy(point, load) / jnp.where(down, slope, -1.0), 0.0)
    onset = curve.point(zero).force
    elastic = load.weight + safe_sqrt(load.weight**2 + 2 * load.k * load.arriving)
    slides = elastic > onset
    w = jnp.where(stops, jnp.maximum(root, 0.0), jnp.where(snaps, w_end, end))
    final = curve.point(jnp.where(slides, w, 0.0))
    top = jnp.maximum(curve.point(jnp.minimum(w, peak)).force, onset)
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
    end = curve.place(slip)
    turns = curve.turns(load.weight, end)
    cuts = jnp.stack([jnp.zeros_like(end), *turns, jnp.minimum(curve.kink, end), end])

    def pace(w: Any) -> Any:
        return _mass_slope(curve.point(w), load)

    def falls(w: Any) -> Any:
        return curve.point(w).force > load.weight

    def slope(w: Any) -> Any:
        return (load.weight - curve.point(w).force) * pace(w)

    if curve.expand is not None:
        expand = curve.expand(load)
    else:
        expand = expand_energy(lambda w: mass_energy(curve.point(w), load), slope)
    return keep_if(end >= 0, pieces_time(jnp.sort(cuts, axis=0), expand, falls, pace, load.mass))
