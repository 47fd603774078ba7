"""Algebra of a stop, element by element: JAX runs it on arrays, and the kernel prints it as C.

It uses only arithmetic, comparisons and `where`, `sqrt`, `maximum`, `minimum`, `inf` of `jnp`, see
`tests/c_printers`. GCC vectorises nothing if a condition is combined with one that it infers.
"""

from typing import Any, NamedTuple

from layerjam.brake.mechanics.arrays import xp
from layerjam.brake.mechanics.enclosure import EnclosureLaw

STOPPED, NEVER_SLID, BOTTOMED_OUT, SNAPS, NOT_A_CASE = 0, 1, 2, 3, -1
"""Outcome codes; NOT_A_CASE if a quantity is outside the domain; all numbers are then NaN."""


class Setup(NamedTuple):
    """Constants of one stop."""

    mass: Any
    arriving: Any
    """Kinetic energy on arrival [J]."""
    weight: Any
    c: Any
    onset: Any
    k: Any
    compliance: Any
    """1/k [m/N], stored because a division is slower than several products."""
    enclosure: EnclosureLaw
    kinetic: Any
    """Kinetic energy when slip begins [J]."""


class Quartic(NamedTuple):
    """K(w) = a0 + a1 w + ... + a4 w^4 [J] in w = sqrt(slip), while the enclosure keeps one form."""

    a0: Any
    a1: Any
    a2: Any
    a3: Any
    a4: Any


class Search(NamedTuple):
    """Bracket of the first root, in w = sqrt(slip)."""

    energy: Quartic
    low: Any
    high: Any
    stops: Any
    limit: Any
    """End of the slide if the mass does not stop: end of the travel, or the snap."""
    snaps: Any


class Stop(NamedTuple):
    """Outcome of a stop; arrays of the broadcast shape."""

    slip: Any
    """Slip of the brake at standstill or at the end of its travel [m]."""
    peak_force: Any
    """Largest force up to that point [N]."""
    end_speed: Any
    """Speed of the mass at the end of travel [m/s]; zero at a standstill."""
    heat: Any
    """Energy dissipated up to that point [J]."""
    stored: Any
    """Elastic energy stored at that point in rope, sheets, mount and enclosure [J]."""
    outcome: Any
    """STOPPED, NEVER_SLID, BOTTOMED_OUT, SNAPS (0 to 3), or NOT_A_CASE (-1): all else is NaN."""


def make_setup(
    mass: Any, speed: Any, c: Any, overlap: Any, enclosure: EnclosureLaw, spring: Any, gravity: Any
) -> Setup:
    """Return the constants of a stop from the friction per contact c [N/m] and the enclosure."""
    weight, onset = mass * gravity, c * overlap
    arriving, compliance = mass * speed * speed / 2, 1 / spring
    kinetic = arriving + (weight * onset - onset * onset / 2) * compliance
    return Setup(mass, arriving, weight, c, onset, spring, compliance, enclosure, kinetic)


def positive_root(square: Any) -> Any:
    """Return the square root of a positive value, otherwise 0 with zero gradient."""
    positive = square > 0
    return xp.where(positive, xp.sqrt(xp.where(positive, square, 1.0)), 0.0)


def balance_root(case: Setup, limit: Any) -> Any:
    """Return sqrt of the slip at which the falling force equals the weight, at most `limit`.

    Up to there the kinetic energy falls (or first rises, then falls), so it has only one root.
    """
    # c w^2 - e w = Y(0) - weight, the larger root; or (c - EA/l) w^2 = Y(0) - weight + q l in the
    # linear, saturated part. Either is (a + sqrt(b)) / d: one root and one division for both.
    margin = case.onset - case.weight
    slope = case.c - case.enclosure.stiffness / case.enclosure.reach
    linear = margin + case.enclosure.friction * case.enclosure.reach
    is_falling = slope > 0
    spreads = is_falling & (slope * case.enclosure.saturation > linear)
    square = case.enclosure.root * case.enclosure.root + 4 * case.c * margin
    radicand = xp.where(spreads, square, slope * linear)
    root = xp.where(spreads, case.enclosure.root, 0.0) + positive_root(radicand)
    root = root / xp.where(spreads, 2 * case.c, xp.where(is_falling, slope, 1.0))
    return xp.minimum(xp.where(is_falling & (radicand >= 0), root, limit), limit)


def quartic(case: Setup, linear: Any) -> Quartic:
    """Return the kinetic energy while slip spreads over the enclosure, or `linear`: after that."""
    c, e = case.c, case.enclosure.root
    compliance, excess = case.compliance, case.weight - case.onset
    slope = case.enclosure.stiffness / case.enclosure.reach
    step = case.enclosure.friction * case.enclosure.reach
    fall, sixth = c - slope, case.enclosure.saturation * (1 / 6)
    base = case.kinetic + step * sixth + (excess - step / 2) * step * compliance
    bend = excess - step + (step - excess) * fall * compliance
    return Quartic(
        xp.where(linear, base, case.kinetic),
        xp.where(linear, 0.0, excess * e * compliance),
        xp.where(linear, bend, excess - excess * c * compliance - e * e * compliance / 2),
        xp.where(linear, 0.0, (c * compliance - 2 / 3) * e),
        xp.where(linear, fall - fall * fall * compliance, c - c * c * compliance) / 2,
    )


def quartic_value(p: Quartic, w: Any) -> Any:
    """Return K(w) [J]."""
    return p.a0 + w * (p.a1 + w * (p.a2 + w * (p.a3 + w * p.a4)))


def quartic_slope(p: Quartic, w: Any) -> Any:
    """Return dK/dw."""
    return p.a1 + w * (2 * p.a2 + w * (3 * p.a3 + w * 4 * p.a4))


def snap_root(soft: Any, enclosure: EnclosureLaw) -> Any:
    """Return sqrt of the slip from which the brake snaps, infinite if it never does.

    There the force falls as fast as the spring relaxes, 1 + Y'/k = 0; `soft` is c - k [N/m]. The
    enclosure's part of Y' falls to EA/l and remains constant: a spring above c - EA/l never snaps.
    """
    runs = soft > enclosure.stiffness / enclosure.reach
    return xp.where(runs, enclosure.root / (2 * xp.where(runs, soft, 1.0)), xp.inf)


def snap_slip(soft: Any, enclosure: EnclosureLaw) -> Any:
    """Return the slip [m] that corresponds to `snap_root`."""
    snap = snap_root(soft, enclosure)
    runs = snap < xp.inf
    finite = xp.where(runs, snap, 0.0)
    return xp.where(runs, finite * finite, xp.inf)


def bracket_root(case: Setup, travel: Any) -> Search:
    """Return the slips between which the kinetic energy crosses zero, and its quartic there."""
    all_of_it, snap = positive_root(travel), snap_root(case.c - case.k, case.enclosure)
    # the saturation slip's root, sqrt(q l^2/EA), from e = 2 sqrt(EA q)
    saturation = case.enclosure.root * (case.enclosure.reach / (2 * case.enclosure.stiffness))
    end = xp.minimum(balance_root(case, all_of_it), snap)
    edge = xp.minimum(saturation, end)
    start = quartic(case, case.c < 0)
    # beyond saturation the enclosure follows a different quartic; without vacuum from the start,
    # where a mass at rest has no energy. GCC does not vectorise a second condition here.
    linear = xp.where(edge < end, quartic_value(start, edge), -1.0) >= 0
    energy = quartic(case, linear)
    low, high = xp.where(linear, edge, 0.0), xp.where(linear, end, edge)
    limit = xp.minimum(all_of_it, snap)
    return Search(energy, low, high, quartic_value(energy, high) <= 0, limit, snap < all_of_it)


def guess_root(p: Quartic, low: Any, high: Any) -> Any:
    """Return the root without the enclosure's part, within the bracket; its end if none falls."""
    down = positive_root(p.a2 * p.a2 - 4 * p.a0 * p.a4) - p.a2
    is_falling = down > 0
    guess = positive_root(2 * p.a0 / xp.where(is_falling, down, 1.0))
    return xp.minimum(xp.maximum(xp.where(is_falling, guess, high), low), high)


def curvature_step(p: Quartic, w: Any, low: Any, high: Any) -> Any:
    """Make one step that uses slope and curvature (Euler's, cubic), limited to the bracket.

    Where the energy rises, which it does only before its fall, the step goes to the end.
    """
    first, second = quartic_slope(p, w), 2 * p.a2 + w * (6 * p.a3 + w * 12 * p.a4)
    energy = quartic_value(p, w)
    down = positive_root(first * first - 2 * energy * second) - first
    is_falling = down > 0
    new = xp.where(is_falling, w + 2 * energy / xp.where(is_falling, down, 1.0), high)
    return xp.minimum(xp.maximum(new, low), high)


def polish_root(p: Quartic, root: Any, slope: Any) -> Any:
    """Return the root after one more Newton step, with a slope that may be held fixed."""
    down = slope < 0
    step = xp.where(down, quartic_value(p, root) / xp.where(down, slope, -1.0), 0.0)
    return xp.maximum(root - step, 0.0)


def make_stop(case: Setup, bracket: Search, root: Any) -> Stop:
    """Return the outcome: a stop at `root` (sqrt of the slip), end of travel, or no slip."""
    mass, enclosure = case.mass, case.enclosure
    # without slip the force swings up to weight + sqrt(swing)
    swing, lack = case.weight * case.weight + 2 * case.k * case.arriving, case.onset - case.weight
    is_sliding = (lack < 0) | (swing > lack * lack)
    is_stopped = bracket.stops
    w = xp.where(is_sliding, xp.where(is_stopped, root, bracket.limit), 0.0)
    slip = w * w
    outcome = xp.where(is_stopped, STOPPED, xp.where(bracket.snaps, SNAPS, BOTTOMED_OUT))
    outcome = xp.where(is_sliding, outcome, NEVER_SLID)
    linear = slip >= enclosure.saturation
    push = enclosure.friction * enclosure.reach
    line = enclosure.stiffness / enclosure.reach * slip + push
    pull = xp.where(linear, line, enclosure.root * w)
    resist = case.onset - case.c * slip + pull
    is_falling = case.c > 0
    ratio = enclosure.root / (2 * xp.where(is_falling, case.c, 1.0))
    is_passed = is_falling & (ratio * ratio < xp.minimum(slip, enclosure.saturation))
    top = case.onset + enclosure.root * xp.where(is_passed, ratio, 0.0) / 2
    highest = xp.maximum(xp.maximum(resist, top), case.onset)
    # while slip spreads, half of the enclosure's work is heat; afterwards, friction q over l is
    spread = enclosure.root * slip * w * (1 / 3)
    linear_heat = push * (slip - enclosure.saturation) + 2 * push * enclosure.saturation * (1 / 3)
    face = line / 2
    linear_energy = face * face - face * push + push * push * (1 / 3)
    linear_energy = 2 * enclosure.reach / enclosure.stiffness * linear_energy
    heat = case.onset * slip - case.c * slip * slip / 2 + xp.where(linear, linear_heat, spread)
    energy = resist * resist * case.compliance / 2 + xp.where(linear, linear_energy, spread)
    # the remaining energy gives a speed if the drop slides, else a swing: one root for both
    energy_left = case.arriving + case.weight * (slip + resist * case.compliance) - heat - energy
    pace = positive_root(
        xp.where(is_sliding, xp.where(is_stopped, 0.0, 2 * energy_left / mass), swing)
    )
    elastic = case.weight + pace
    return Stop(
        slip,
        xp.where(is_sliding, highest, elastic),
        xp.where(is_sliding, pace, 0.0),
        heat,
        xp.where(is_sliding, energy, elastic * elastic * case.compliance / 2),
        outcome,
    )
