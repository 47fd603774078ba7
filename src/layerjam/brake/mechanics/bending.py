"""Bending of a brake between its caps or by a transverse force, with and without vacuum.

Sheets that slide freely bend separately, with n E I. Sheets held together by friction bend as one
beam, n^2 times as stiff (Narang, Vlassak and Howe 2018, Adv. Funct. Mater. 28, 1707136). Between
the two states the interfaces slip, each against the shear flow q = a mu_k W P [N/m], while they
stay pressed together. The transition loads are those of Caruso et al. 2023
(10.1016/j.ijmecsci.2023.108325, eqs. 8 to 11).

There are two loads. One is a transverse force at the end of sheets that are all held at the other
end (exact within beam theory). The other is a pair of opposite moments on the caps, while the brake
may shorten freely. The enclosure bends with the sheets as a tube. All formulas are for loading from
the straight, unjammed state.

Sheets without spacers amplify their friction in a pull, where all of a side are in tension. In
bending, the outer sheets are in tension and the inner ones compressed: the fan unloads one half of
the interfaces as much as it loads the other. To first order the sum does not change, so friction is
that of flat sheets. Only the lever changes (see `_fan_stiffness`).
"""

from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.effects import remove_slip_effects
from layerjam.brake.mechanics.friction import friction_per_contact
from layerjam.brake.mechanics.law import keep_if, law
from layerjam.brake.mechanics.roots import implicit_root
from layerjam.brake.mechanics.stiffness import count_sides, sheet_section


def _sheet_stiffness(brake: Brake) -> Any:
    """Return E I of a single sheet [N m^2]."""
    return brake.film.modulus * sheet_section(brake) * brake.sheets.thickness**2 / 12


def _shear_flow(vacuum: Any, brake: Brake) -> Any:
    """Return the shear flow q [N/m], the friction of one interface per metre."""
    return friction_per_contact(vacuum, remove_slip_effects(brake)) / (brake.sheets.count - 1)


@law
def enclosure_bending_stiffness(brake: Brake) -> Any:
    """Return E I of the enclosure alone [N m^2], as a rectangular tube close around the stack.

    It uses the brake's single modulus, stated at 100 % stretch; below it silicone is stiffer.
    """
    wall, width = brake.enclosure.wall, brake.sheets.width
    height = brake.sheets.count * brake.sheets.thickness
    outer = (width + 2 * wall) * (height + 2 * wall) ** 3
    return brake.enclosure.modulus * (outer - width * height**3) / 12


@law
def bending_stiffness_free(brake: Brake) -> Any:
    """Return E I of the overlap [N m^2] while the sheets slide: n E W t^3/12, and the tube.

    This is the bending stiffness without vacuum, assumed to be without friction.
    """
    return brake.sheets.count * _sheet_stiffness(brake) + enclosure_bending_stiffness(brake)


@law
def bending_stiffness_jammed(brake: Brake) -> Any:
    """Return E I of the overlap [N m^2] before any slip: E W (n t)^3/12 plus that of the tube."""
    return brake.sheets.count**3 * _sheet_stiffness(brake) + enclosure_bending_stiffness(brake)


# a transverse force: Narang, Vlassak and Howe


def _curvature_at_first_slip(flow: Any, brake: Brake) -> Any:
    """Return the curvature per distance from the force [1/m^2] at which the first interfaces slip.

    It is 8 q/(E W t^2 n^2) for even n, with one interface in the middle. For odd n the two
    interfaces next to the middle sheet carry less, by 1 - 1/n^2.
    """
    sheets = brake.sheets
    count = xp.asarray(sheets.count, xp.float64)
    square = xp.where(xp.mod(count, 2) == 0, count**2, count**2 - 1)
    return 8 * flow / (brake.film.modulus * sheet_section(brake) * sheets.thickness * square)


def _shear_force(bend: Any, flow: Any, brake: Brake) -> Any:
    """Return the sheets' transverse force [N] at a curvature per distance from the force [1/m^2].

    At a force V the axial strains are those of a total-variation problem over the sheets. The
    interfaces slip from the middle outwards, and two outer blocks of m sheets each stay stuck. Then
    V = E I (n + 2 m (m^2 - 1)) g + q t (n - m), where m (m + 1) just exceeds 2 q/(E W t^2 g).
    """
    count, t, sheet = brake.sheets.count, brake.sheets.thickness, _sheet_stiffness(brake)
    sticks = bend <= _curvature_at_first_slip(flow, brake)
    safe = xp.where(sticks | (bend <= 0), 1.0, bend)
    share = flow / (brake.film.modulus * sheet_section(brake) * t * safe)
    block = xp.maximum(xp.ceil((xp.sqrt(1 + 8 * share) - 1) / 2), 1.0)
    slipping = sheet * safe * (count + 2 * block * (block**2 - 1)) + flow * t * (count - block)
    return xp.where(sticks, count**3 * sheet * bend, slipping)


@law
def shear_at_first_slip(vacuum: Any, brake: Brake) -> Any:
    """Return the transverse force [N] at which the innermost interfaces slip at a vacuum [Pa].

    It is (2/3) a mu_k P W n t, divided by 1 - 1/n^2 for odd n: the parabolic shear stress in a beam
    reaches the friction in the middle. The enclosure bends with the sheets and carries its share.
    """
    bend = _curvature_at_first_slip(_shear_flow(vacuum, brake), brake)
    return keep_if(vacuum >= 0, bend * bending_stiffness_jammed(brake))


@law
def shear_at_full_slip(vacuum: Any, brake: Brake) -> Any:
    """Return the transverse force [N] above which all interfaces slip at a vacuum [Pa].

    It is q t (13 n/12 - 1) for three sheets and more; above it a beam is as soft as without vacuum.
    """
    flow = _shear_flow(vacuum, brake)
    outermost = flow / (brake.film.modulus * sheet_section(brake) * brake.sheets.thickness)
    bend = xp.maximum(outermost, _curvature_at_first_slip(flow, brake))
    force = _shear_force(bend * (1 + 1e-15), flow, brake) + bend * enclosure_bending_stiffness(
        brake
    )
    return keep_if(vacuum >= 0, force)


@law
def cantilever_force(deflection: Any, length: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the transverse force [N] that deflects the end of a jammed stack by a deflection [m].

    All sheets are held at one end, and the force acts at a length [m] from there. A beam on two
    supports with the force F in its middle is two such halves with F/2. The formula is for small
    deflections, without elastic shear. NaN for a negative deflection.
    """
    bend = 3 * deflection / length**3
    force = _shear_force(bend, _shear_flow(vacuum, brake), brake)
    fine = (deflection >= 0) & (length > 0) & (vacuum >= 0)
    return keep_if(fine, force + bend * enclosure_bending_stiffness(brake))


@law
def cantilever_deflection(force: Any, length: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the end deflection [m] under a transverse force [N]: inverse `cantilever_force`."""

    def excess(deflection: Any) -> Any:
        return cantilever_force(deflection, length, vacuum, brake) - force

    rigid = length**3 / (3 * bending_stiffness_jammed(brake))
    soft = length**3 / (3 * bending_stiffness_free(brake))
    fine = (force >= 0) & (length > 0) & (vacuum >= 0) & (vacuum < xp.inf)
    load = xp.where(fine, force, 0.0) + xp.zeros(xp.shape(length * vacuum))
    # the Newton step stays within the straight piece
    root = implicit_root(excess, load * rigid * (1 - 1e-12), load * soft * (1 + 1e-12))
    return keep_if(fine, root)


# caps that rotate


def _stack_bending(count: Any, pitch: Any, brake: Brake) -> Any:
    """Return E I [N m^2] of sheets at a pitch [m] that each bend about their own middle."""
    axial = brake.film.modulus * sheet_section(brake) * pitch**2 * count * (count**2 - 1) / 12
    return axial + count * _sheet_stiffness(brake)


def _fan_stiffness(count: Any, brake: Brake) -> tuple[Any, Any]:
    """Return E I [N m^2] of sheets that fan out from t to 2 t, with enclosure, and their couple.

    The couple is the fraction of the moment that axial forces carry at the cap. It doubles towards
    the overlap while the moment is constant: axial forces carry Q(1 + s/L), the sheets' own bending
    M - Q(1 + s/L). With B = own and tube and A = E W t^3 count (count^2 - 1)/12, minimum energy
    gives Q/M = 9 A/(14 A + 6 B) and E I = B/(1 - 27 A/(28 A + 12 B)). Forces along lines that meet
    in one point cannot balance a pure moment, so E I is at most 28 B, however stiff the sheets are.
    """
    bending = count * _sheet_stiffness(brake) + enclosure_bending_stiffness(brake)
    axial = brake.film.modulus * sheet_section(brake) * brake.sheets.thickness**2
    axial = axial * count * (count**2 - 1) / 12
    stiffness = bending / (1 - 27 * axial / (28 * axial + 12 * bending))
    return stiffness, 9 * axial / (14 * axial + 6 * bending)


def _free_length_stiffness(count: Any, brake: Brake) -> Any:
    """Return E I [N m^2] of a jammed brake's free length, without that of the enclosure."""
    spread = _stack_bending(count, 2 * brake.sheets.thickness, brake)
    if brake.mount.spacers is None:
        return spread
    fan = _fan_stiffness(count, brake)[0] - enclosure_bending_stiffness(brake)
    return xp.where(xp.asarray(brake.mount.spacers) > 0, spread, fan)


def _lever(slip: Any, brake: Brake) -> Any:
    """Return the ratio of the slip of a fan's interfaces to that of flat sheets, once all slip [-].

    In an evenly bent free length, the sheets of a fan slip by 3/4 of the distance of flat sheets.
    """
    if brake.mount.spacers is None:
        return 1.0
    tube, sheet = enclosure_bending_stiffness(brake), _sheet_stiffness(brake)
    (left, right), (a, b, c) = count_sides(brake), _part_lengths(slip, brake)
    middle = brake.sheets.count * sheet + tube
    parts = a / (left * sheet + tube), b / middle, c / (right * sheet + tube)
    fan = (0.75 * (parts[0] + parts[2]) + parts[1]) / (parts[0] + parts[1] + parts[2])
    return xp.where(xp.asarray(brake.mount.spacers) > 0, 1.0, fan)


def _part_lengths(slip: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Return the left free length, the overlap and the right free length [m] at a slip [m]."""
    sheets = brake.sheets
    return sheets.free_left + slip, sheets.overlap - slip, sheets.free_right + slip


def _join_parts(slip: Any, stiffness: tuple[Any, Any, Any], brake: Brake) -> Any:
    tube = enclosure_bending_stiffness(brake)
    parts = zip(_part_lengths(slip, brake), stiffness, strict=True)
    return 1 / sum(length / (stiff + tube) for length, stiff in parts)


def _is_valid(slip: Any, brake: Brake) -> Any:
    return (slip >= 0) & (slip < brake.sheets.overlap)


@law
def turning_stiffness_free(slip: Any, brake: Brake) -> Any:
    """Return the moment per angle between the caps [N m/rad] without vacuum, at a slip [m].

    Left free sheets, overlap and right free sheets are in series; each sheet bends separately.
    """
    left, right = count_sides(brake)
    sheet = _sheet_stiffness(brake)
    stiffness = _join_parts(slip, (left * sheet, brake.sheets.count * sheet, right * sheet), brake)
    return keep_if(_is_valid(slip, brake), stiffness)


@law
def turning_stiffness_jammed(slip: Any, brake: Brake) -> Any:
    """Return the moment per angle between the caps [N m/rad] at a slip [m] with stuck interfaces.

    In the free lengths spacers hold the sheets of one side two thicknesses apart, so that outer
    sheets stretch and inner ones shorten. In the overlap all sheets bend as one beam. Without
    spacers the sheets fan out towards the overlap, and the free lengths are several times softer.
    """
    left, right = count_sides(brake)
    overlap = brake.sheets.count**3 * _sheet_stiffness(brake)
    parts = (_free_length_stiffness(left, brake), overlap, _free_length_stiffness(right, brake))
    return keep_if(_is_valid(slip, brake), _join_parts(slip, parts, brake))


@law
def slip_moment(slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the part of the caps' moment [N m] from friction once every interface slips.

    It is F_f (n - 1) t/4, with F_f the friction of flat sheets in a pull. An interface slips by its
    distance from the middle times the angle; without spacers, by 3/4 of that, with the angle taken
    over the free lengths. Zero for a brake that slides along its pull.
    """
    force = friction_per_contact(vacuum, remove_slip_effects(brake)) * (brake.sheets.overlap - slip)
    moment = force * (brake.sheets.count - 1) * brake.sheets.thickness / 4 * _lever(slip, brake)
    return keep_if(_is_valid(slip, brake) & (vacuum >= 0), moment)


@law
def buckling_moment(slip: Any, brake: Brake) -> Any:
    """Return the moment [N m] at which the first compressed sheet of a jammed brake buckles.

    It is Euler's formula for a free length with both ends held, for the outermost sheet of the side
    that buckles first. The enclosure and the other sheets support it, so that the true moment is
    somewhat higher.
    """
    t, sheet = brake.sheets.thickness, _sheet_stiffness(brake)
    stretch = brake.film.modulus * sheet_section(brake)
    lengths = _part_lengths(slip, brake)

    def lowest_moment(count: Any, length: Any) -> Any:
        edge = (count - 1) * t
        strain = edge / (_stack_bending(count, 2 * t, brake) + enclosure_bending_stiffness(brake))
        if brake.mount.spacers is not None:
            couple = _fan_stiffness(count, brake)[1] * 6 / (stretch * t * count * (count + 1))
            strain = xp.where(xp.asarray(brake.mount.spacers) > 0, strain, couple)
        is_single = count < 2
        moment = 4 * xp.pi**2 * sheet / length**2 / xp.where(is_single, 1.0, strain * stretch)
        return xp.where(is_single, xp.inf, moment)

    left, right = count_sides(brake)
    least = xp.minimum(lowest_moment(left, lengths[0]), lowest_moment(right, lengths[2]))
    return keep_if(_is_valid(slip, brake), least)


@law
def turning_moment(angle: Any, slip: Any, vacuum: Any, brake: Brake) -> Any:
    """Return the moment [N m] that turns the caps by an angle [rad] at a slip [m] and vacuum [Pa].

    The curve starts with `turning_stiffness_jammed` and ends at `slip_moment` above
    `turning_stiffness_free`. Sheets end within the overlap, so they slip from their ends
    immediately, the outer ones first. The model has fibres at all heights, each a lap joint with
    friction whose stretch is proportional to T + b T^2 until T equals its friction. The fibres'
    stiffness gives the exact initial stiffness. Both ends of the curve are exact. In between it is
    from 8 % below to 17 % above layered finite elements; from nine sheets on, 1 % below to 13 %
    above. NaN for a negative angle.
    """
    free = turning_stiffness_free(slip, brake)
    friction = slip_moment(slip, vacuum, brake)
    left, overlap, right = _part_lengths(slip, brake)
    bend = overlap / (4 * (left + right + overlap / 2))
    jams = friction > 0
    extra = turning_stiffness_jammed(slip, brake) - free
    start = 1.5 * extra * angle / xp.where(jams, friction, 1.0)
    share = xp.where(jams, _lap_joints(start, bend), 0.0)
    return keep_if((angle >= 0) & (vacuum >= 0), free * angle + friction * share)


def _lap_joints(stretch: Any, bend: Any) -> Any:
    """Return the fraction of the slip moment; `stretch` is that of the outermost fibre.

    A fibre at the fraction h of the height has T + b T^2 = h times `stretch`, up to T = 1. The
    moment is the integral of 2 h T over h, written in T.
    """
    safe = xp.where(stretch > 0, stretch, 1.0)
    pull = xp.minimum(safe, 1 + bend)
    outer = 2 * pull / (1 + xp.sqrt(1 + 4 * bend * pull))
    stuck = 2 * outer * (outer / safe) ** 2
    stuck = stuck * (1 / 3 + 3 * bend * outer / 4 + 2 * (bend * outer) ** 2 / 5)
    slipping = 1 - (pull / safe) ** 2
    return xp.where(stretch > 0, stuck + slipping, 0.0)
