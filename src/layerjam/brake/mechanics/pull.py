"""The pulled brake: total force, peak, elongation, and the vacuum for a force.

With c the sheets' friction per metre of overlap and e the enclosure's root coefficient, F(x) = c
(L2 - x) + e sqrt(x) until the enclosure saturates.
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import freeze, leaves, xp
from layerjam.brake.mechanics.effects import depends_on_slip, is_proportional
from layerjam.brake.mechanics.enclosure import (
    EnclosureLaw,
    brake_enclosure,
    enclosure_law,
    spread_root,
)
from layerjam.brake.mechanics.friction import friction_per_contact, sheet_law, slides
from layerjam.brake.mechanics.law import keep_if, law, safe_sqrt
from layerjam.brake.mechanics.roots import implicit_root, rising_zero
from layerjam.brake.mechanics.slip_effects import (
    Sheets,
    find_equilibrium,
    friction_force,
    friction_tangent,
)
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.core.evolve import evolve

_PARTS = 64


@law(of_points=True)
def brake_force(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the force of the sliding brake [N] (eq. 3); slip [m] and vacuum [Pa] broadcast.

    At zero slip the gradient is that of the sheets alone: the enclosure's infinite slope is treated
    as zero there. NaN for a negative slip or vacuum, and beyond the overlap, where the sheets are
    apart.
    """
    return keep_if(slides(slip, vacuum, brake), sliding_resistance(slip, vacuum, brake))


def sliding_resistance(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return `brake_force` [N] without its domain: beyond the overlap that of the enclosure."""
    sheets = friction_force(slip, sheet_law(vacuum, brake))
    return sheets + brake_enclosure(vacuum, brake).force(slip)


class Peak(NamedTuple):
    """Largest force of a slow pull."""

    force: Any
    """Force [N]."""
    slip: Any
    """Slip [m]."""
    elongation: Any
    """Displacement of the test machine's crosshead, x + F/k [m]."""
    inside: Any
    """True if the force falls again within the travel; otherwise it rises to the end."""


@law
def peak(vacuum: Any, travel: Any, brake: Brake) -> Peak:
    """Return the peak of a pull over a slip `travel` [m] at a vacuum [Pa].

    It is c L2 + e^2/4c at x_p = (e/2c)^2 if that is before saturation and within the travel. At a
    lower vacuum the force rises to the end, which is then reported with inside = False. Sheets that
    fan out have no closed form: the largest force is found by a search.
    """
    sheets, enclosure = sheet_law(vacuum, brake), enclosure_law(vacuum, brake)
    if not sheets.shapes:
        force, slip, inside = _closed_peak(travel, sheets.c, sheets.overlap, enclosure)
    else:
        force, slip, inside = searched_peak(travel, sheets, enclosure)
    fine = (vacuum >= 0) & (travel >= 0)
    force, slip = keep_if(fine, force), keep_if(fine, slip)
    return Peak(force, slip, slip + force / working_stiffness(brake), inside)


def _closed_peak(
    travel: Any, c: Any, overlap: Any, enclosure: EnclosureLaw
) -> tuple[Any, Any, Any]:
    """Return force, slip and whether the peak is inside, for friction linear in slip."""
    falls = c > enclosure.stiffness / enclosure.reach
    ratio = enclosure.root / (2 * xp.where(falls, c, 1.0))
    inside = falls & (ratio**2 < travel)
    slip = xp.where(inside, ratio**2, travel)
    end = c * xp.maximum(overlap - travel, 0.0) + enclosure.force(travel)
    force = xp.where(inside, c * overlap + enclosure.root * ratio / 2, end)
    return force, slip, inside


def searched_peak(travel: Any, sheets: Sheets, enclosure: EnclosureLaw) -> tuple[Any, Any, Any]:
    """Return the same for any friction: the best of 64 slips, and the exact maximum next to it.

    The search is not differentiated, because the slope of the force vanishes at the peak.
    """

    def force(root: Any, laws: tuple[Sheets, EnclosureLaw]) -> Any:
        return friction_force(root**2, laws[0]) + laws[1].force(root**2)

    end = safe_sqrt(xp.maximum(travel, 0.0))
    end = end + sum(0.0 * part for part in leaves((sheets, enclosure)))
    root_end, constants = freeze((end, (sheets, enclosure)))
    share = xp.linspace(0.0, 1.0, _PARTS + 1).reshape((-1,) + (1,) * root_end.ndim)
    best = xp.argmax(force(share * root_end, constants), axis=0)
    low, high = (xp.clip(best + k, 0, _PARTS) * root_end / _PARTS for k in (-1, 1))

    def falls(root: Any) -> Any:
        friction, strip = constants
        return 2 * root * friction_tangent(root**2, friction).c - strip.point_at(root).force_slope

    root = rising_zero(falls, low, high)
    inside = root < root_end
    root = xp.where(inside, root, end)
    return force(root, (sheets, enclosure)), root**2, inside


@law(of_points=True)
def slip_at_elongation(elongation: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the slip [m] of a brake pulled from rest to an elongation [m] at constant vacuum [Pa].

    Solves k (u - x) = F(x) in closed form; zero while the load is below c L2. Valid for k > c
    (`least_stiffness`), NaN otherwise.
    """
    k = working_stiffness(brake)
    sheets, enclosure = sheet_law(vacuum, brake), brake_enclosure(vacuum, brake)

    def find_slip(line: Sheets) -> Any:
        return enclosure.find_slip(k * elongation - line.c * line.overlap, k - line.c)

    slip = find_equilibrium(find_slip, 0.0 * elongation, sheets)
    enclosure_slip = enclosure.find_slip(k * elongation, k)
    past = slip > brake.sheets.overlap
    slip = xp.where(past, xp.maximum(enclosure_slip, brake.sheets.overlap), slip)
    return keep_if((elongation >= 0) & (vacuum >= 0) & (k > friction_tangent(0.0, sheets).c), slip)


@law(of_points=True)
def force_at_elongation(elongation: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the force [N] at an elongation [m] and constant vacuum [Pa] from rest.

    Once the brake slides it is the sliding force, which is more accurate than k (u - x). Beyond the
    overlap the sheets are apart, and the enclosure alone carries the load.
    """
    slip = slip_at_elongation(elongation, vacuum, brake)
    elastic = working_stiffness(brake) * elongation
    return xp.where(slip > 0, sliding_resistance(slip, vacuum, brake), elastic + 0.0 * slip)


@law
def least_stiffness(vacuum: Any, brake: Brake) -> Any:
    """Return the stiffness of rig or rope [N/m] above which no pull at a vacuum [Pa] can snap: c.

    The friction of sheets that fan out falls most steeply at the start, where their free lengths
    are shortest.
    """
    return friction_tangent(0.0, sheet_law(vacuum, brake)).c


@law
def scale_factor_of_peak(force: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the scale factor a [-] with which a pull at `vacuum` [Pa] peaks at `force` [N].

    This is the exact inverse of `peak`: (F + sqrt(F^2 - e^2 L2))/(2 c_1 L2), with c_1 the friction
    per contact at a = 1. NaN for F^2 < e^2 L2, because no pull has such a low peak. For sheets that
    fan out it is found by bisection.
    """
    if depends_on_slip(brake):
        return _bisect_factor(force, vacuum, brake)
    root, overlap = enclosure_law(vacuum, brake).root, brake.sheets.overlap
    unit_friction = friction_per_contact(vacuum, brake) / brake.scale_factor
    square = force**2 - root**2 * overlap
    return (force + safe_sqrt(square)) / (2 * unit_friction * overlap)


def _bisect_factor(force: Any, vacuum: Any, brake: Brake) -> Any:
    """Return a by bisection of log a and one Newton step, as the amplification depends on a."""
    enclosure, start = enclosure_law(vacuum, brake), xp.log(xp.asarray(brake.scale_factor))
    force, vacuum, start = xp.broadcast_arrays(force, vacuum, start)

    def peak_force(log_factor: Any) -> Any:
        factor: Any = xp.exp(log_factor)
        sheets = sheet_law(vacuum, evolve(brake, scale_factor=factor))
        return searched_peak(brake.sheets.overlap, sheets, enclosure)[0]

    root = implicit_root(lambda v: peak_force(v) - force, start - 7.0, start + 5.0)
    least = enclosure.root * xp.sqrt(brake.sheets.overlap)
    is_met = xp.abs(force - freeze(peak_force(root))) < 1e-6 * force
    return keep_if((force >= least) & is_met, xp.exp(root))


@law
def scale_factor_eq8(force: Any, displacement: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the paper's a (eq. 8), with the crosshead's displacement [m] in place of the slip."""
    unit_friction = friction_per_contact(vacuum, brake) / brake.scale_factor
    enclosure = enclosure_law(vacuum, brake).force(displacement)
    return (force - enclosure) / (unit_friction * (brake.sheets.overlap - displacement))


@law
def factor_and_stiffness_of_eq8_and_eq9(
    factor: Any, stiffness: Any, vacuum: Any, brake: Brake
) -> tuple[Any, Any]:
    """Return a [-] and k [N/m] of a brake for whose pull eq. 8 and 9 give `factor`, `stiffness`.

    The paper's formulas use the peak force and displacement of one pull at `vacuum` [Pa]. Combined,
    they are a quadratic in the root of the peak force, from which a and k follow exactly. On a
    curve of the law they do not return its a and k. NaN if no pull gives these two values.
    """
    enclosure, overlap = enclosure_law(vacuum, brake), brake.sheets.overlap
    unit = friction_per_contact(vacuum, brake) / brake.scale_factor
    # F = factor one (L2 - d) + e sqrt(d) with d = F/stiffness
    square, linear = 1 + factor * unit / stiffness, enclosure.root / safe_sqrt(stiffness)
    root = (linear + safe_sqrt(linear**2 + 4 * square * factor * unit * overlap)) / (2 * square)
    force = root**2
    displacement = force / stiffness
    exact = scale_factor_of_peak(force, vacuum, brake)
    slip = (enclosure.root / (2 * exact * unit)) ** 2
    fine = (displacement < enclosure.saturation) & (slip < displacement) & (vacuum > 0)
    slope = force / xp.where(fine, displacement - slip, 1.0)
    return keep_if(fine, exact), keep_if(fine, slope)


@law(of_points=True)
def vacuum_for_force(force: Any, slip: Any, brake: Brake) -> Any:
    """Return the vacuum [Pa] at which the sliding brake resists with `force` [N] at `slip` [m].

    This is the inverse of `brake_force` in closed form. NaN if no vacuum gives the force, because
    the enclosure alone carries more or the site's full vacuum gives less.
    """
    atmosphere, unit = brake.site.atmosphere, enclosure_law(1.0, brake)
    enclosure_alone = unit.stiffness * slip / unit.reach
    top_force = brake_force(slip, atmosphere, brake)
    if is_proportional(brake):
        c1 = friction_force(slip, sheet_law(1.0, brake))
        spread = spread_root(force, c1, unit._replace(root=unit.root * safe_sqrt(slip))) ** 2
        linear = (force - enclosure_alone) / (c1 + unit.friction * unit.reach)
        saturated = linear * unit.saturation <= slip
        vacuum = xp.where(saturated & (slip > 0), linear, spread)
        vacuum = xp.minimum(vacuum, atmosphere)
    else:
        vacuum = _bisect_vacuum(force, slip, brake)
    return keep_if((force >= enclosure_alone) & (force <= top_force), vacuum)


def holding_vacuum(weight: Any, slip: Any, brake: Brake) -> Any:
    """Return the lowest vacuum [Pa] that holds a weight [N] at a slip [m]; NaN if there is none."""
    return vacuum_for_force(xp.maximum(weight, brake_force(slip, 0.0, brake)), slip, brake)


def _bisect_vacuum(force: Any, slip: Any, brake: Brake) -> Any:
    """Return the inverse by bisection if friction is not proportional to the vacuum."""
    zero = xp.zeros(xp.broadcast_shapes(xp.shape(force), xp.shape(slip)))
    top = zero + brake.site.atmosphere
    return implicit_root(lambda vacuum: sliding_resistance(slip, vacuum, brake) - force, zero, top)


@law
def force_limits(slip: Any, brake: Brake) -> tuple[Any, Any]:
    """Return the smallest and the largest force [N] that the site's vacuum allows at a slip [m]."""
    return brake_force(slip, 0.0, brake), brake_force(slip, brake.site.atmosphere, brake)


@law
def peak_vacuum(brake: Brake) -> Any:
    """Return the vacuum [Pa] below which a pull has no peak: E_e A_e/(a mu_k (n-1) W l).

    It is found by a search if the friction is not proportional to the vacuum.
    """
    unit = enclosure_law(1.0, brake)
    bound = unit.stiffness / unit.reach
    if is_proportional(brake):
        return bound / friction_tangent(0.0, sheet_law(1.0, brake)).c

    def excess(log_vacuum: Any) -> Any:
        return xp.log(friction_tangent(0.0, sheet_law(xp.exp(log_vacuum), brake)).c / bound)

    middle = 0.0 * excess(0.0)
    return xp.exp(implicit_root(excess, middle - 100.0, middle + 100.0))
