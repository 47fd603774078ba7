"""The enclosure under changing slip and vacuum: tension along its strips, in pieces (ours).

A point at the distance s from the driven end of half a face feels that end only through the
friction in between, which bears at most q s. So a move keeps each point's old tension between
N0 - q s and N0 + q s, N0 that of the end: the part that slides grows from the end, the rest keeps
what it had, and the tension is a chain of straight pieces. While the front crosses a piece, the
force follows the backbone of the change of slope there: 2 q after a turn at one vacuum (Masing's
rule), q' - q where a strip that was stretched under q is stretched further under q'. Work and heat
are exact integrals.

A vacuum that rises changes no tension. One that falls lets the pieces slide that are steeper than
friction now holds: see `at_vacuum`.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import (
    EnclosureLaw,
    backbone,
    backbone_work,
    enclosure_at,
    enclosure_of,
    slipped_area,
)
from layerjam.mechanics.law import law, safe_sqrt, within
from layerjam.mechanics.rubber_strip import along_slip

DEPTH = 16
"""Turning points remembered in either direction, nested loops one inside the other."""
PIECES = 2 * DEPTH + 5
"""Pieces of tension that are remembered, the middle of the face included."""
NEAR = 1e-9
"""Share within which two numbers count as equal. Histories reach equalities exactly (a loop that
closes), and rounding must not decide what comes then."""
NEAR_IN_SINGLE = 1e-4
"""The same in single precision, whose rounding is coarser."""


class Memory(NamedTuple):
    """State of both faces of the enclosure."""

    slip: Any
    force: Any
    ends: Any
    """Reach of the pieces from the driven end, over half the free length, the innermost first;
    shape (PIECES, ...). The first has no length: it is the middle of the face."""
    slopes: Any
    """Slope of their tension over that distance [N/m]: -q where the strip was pulled out."""
    count: Any
    stored: Any
    heat: Any
    overflow: Any
    """True once more nested turns were made than `DEPTH` holds."""


class Path(NamedTuple):
    """The branch over each piece in a move in one direction; arrays of the shape of `ends`."""

    slip: Any
    """Start of the branch if the whole way had been over this piece [m]."""
    force: Any
    strength: Any
    """Change of friction that the branch moves against [N/m]."""
    begin: Any
    """Way from the present slip to the piece [m], and to its far end; infinite past the middle."""
    end: Any
    end_force: Any
    """Force with the front at the far end [N]."""


def at_rest(shape: tuple[int, ...] = ()) -> Memory:
    """A relaxed enclosure, or an array of them."""
    zero = jnp.zeros(shape)
    none = jnp.zeros((PIECES, *shape))
    two = jnp.full(shape, 2)
    return Memory(zero, zero, none.at[:2].set(1.0), none, two, zero, zero, zero > 0)


def branch(strength: Any, enclosure: EnclosureLaw) -> EnclosureLaw:
    """The strip as it answers a move against a change of friction `strength` [N/m]."""
    return enclosure_of(enclosure.stiffness, strength, enclosure.reach)


def _places(state: Memory) -> Any:
    return jnp.arange(len(state.ends)).reshape((-1,) + (1,) * jnp.ndim(state.count))


def piece(values: Any, place: Any) -> Any:
    """The entry of an array over the pieces at a place of each strip."""
    places = jnp.arange(len(values)).reshape((-1,) + (1,) * jnp.ndim(place))
    return jnp.where(places == place, values, 0.0).sum(axis=0)


def _sum_nearer(values: Any) -> Any:
    """For each piece the sum over those nearer to the driven end."""
    return jnp.flip(jnp.cumsum(jnp.flip(values, 0), axis=0), 0) - values


def _with_piece(state: Memory, place: Any, end: Any, slope: Any) -> Memory:
    """The state with a piece at a place, the last one that counts."""
    here = _places(state) == place
    return state._replace(
        ends=jnp.where(here, end, state.ends),
        slopes=jnp.where(here, slope, state.slopes),
        count=place + 1,
    )


def face_direction(state: Memory, direction: Any, enclosure: EnclosureLaw) -> Memory:
    """Return the state with a piece to grow at the driven end: in direction 1 out, or -1 back."""
    slope = -direction * enclosure.friction
    turned = piece(state.slopes, state.count - 1) != slope
    return _choose(turned, _with_piece(state, state.count, 0.0, slope), state)


def find_path(state: Memory, direction: Any, enclosure: EnclosureLaw) -> Path:
    """Return the branches ahead of a state from `face_direction`."""
    places = _places(state)
    under = places < state.count - 1
    slope = -direction * enclosure.friction
    strength = jnp.where(under & (places > 0), jnp.abs(slope - state.slopes), 0.0)
    strip, near = branch(strength, enclosure), jnp.roll(state.ends, -1, axis=0)
    near, far = jnp.where(under, near, 0.0), jnp.where(under, state.ends, 0.0)
    longer = strip.saturation * (far**2 - near**2)
    harder = 2 * strength * enclosure.reach * (far - near)
    begin, force = _sum_nearer(longer), state.force + direction * _sum_nearer(harder)
    return Path(
        slip=state.slip + direction * (begin - strip.saturation * near**2),
        force=force - direction * 2 * strength * enclosure.reach * near,
        strength=strength,
        begin=jnp.where(under, begin, 0.0),
        end=jnp.where(under & (places > 0), begin + longer, jnp.inf),
        end_force=force + direction * harder,
    )


def sliding_share(state: Memory) -> Any:
    """Return the reach of the last move from the driven end, over half the free length [-].

    The force then rises by EA over that length.
    """
    return piece(state.ends, state.count - 1)


def slide_to(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Memory:
    """Return the enclosure stretched or let back to a slip [m], with its work and heat."""
    moved = _grow_piece(state, slip, enclosure)
    full = moved.count >= len(state.ends)  # the next turn needs a place
    return jax.lax.cond(
        jnp.any(full), lambda s: _choose(full, _join_pieces(s, enclosure), s), lambda s: s, moved
    )


def _grow_piece(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Memory:
    """Return the same, with one piece more than may be kept."""
    direction = jnp.where(slip < state.slip, -1.0, 1.0)
    way = jnp.abs(slip - state.slip)
    ready = face_direction(state, direction, enclosure)
    path = find_path(ready, direction, enclosure)
    places = _places(state)
    under = places < ready.count - 1
    # a loop that closes but for rounding is closed
    branch_way = path.end - direction * (path.slip - state.slip)
    close = NEAR if jnp.result_type(way) == jnp.float64 else NEAR_IN_SINGLE
    reached = path.end - close * jnp.where(path.end < jnp.inf, branch_way, 0.0) <= way
    reached = ~under | reached | ((path.strength <= 0) & (places > 0))
    passed = under & jnp.flip(jnp.cumprod(jnp.flip(reached, 0), axis=0), 0).astype(bool)
    place = ready.count - 2 - passed.sum(axis=0)
    start, strength = piece(path.slip, place), piece(path.strength, place)
    ahead, strip = jnp.maximum(direction * (slip - start), 0.0), branch(strength, enclosure)
    spread = jnp.where(strip.saturation > 0, strip.saturation, 1.0)
    share = jnp.where(strip.saturation > ahead, safe_sqrt(ahead / spread), 1.0)
    near = piece(jnp.where(under, jnp.roll(ready.ends, -1, axis=0), 0.0), place)
    end = jnp.clip(share, near, piece(ready.ends, place))
    moved = _with_piece(ready, place + 1, end, -direction * enclosure.friction)

    strips = branch(path.strength, enclosure)
    first, last = jnp.minimum(path.begin, way), jnp.minimum(path.end, way)
    on = under & (last > first)
    a, b = (
        jnp.where(on, jnp.maximum(w - direction * (path.slip - state.slip), 0.0), 0.0)
        for w in (first, last)
    )
    work = jnp.where(on, direction * path.force * (b - a), 0.0)
    work = (work + backbone_work(b, strips) - backbone_work(a, strips)).sum(axis=0)
    heat = (slipped_area(b, strips) - slipped_area(a, strips)).sum(axis=0) * enclosure.friction
    moved = moved._replace(
        slip=slip,
        force=piece(path.force, place) + direction * backbone(ahead, strip),
        stored=ready.stored + work - heat,
        heat=ready.heat + heat,
    )
    return _choose(slip != state.slip, moved, state)


def _choose(condition: Any, yes: Memory, no: Memory) -> Memory:
    """One state or the other, strip by strip."""
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), yes, no)


class _Tension(NamedTuple):
    """Both faces, piece by piece; arrays of the shape of `ends`."""

    near: Any
    """Tension of both faces at the near end [N], and its rise up to the far end."""
    rise: Any
    slip: Any
    """Contribution of the stretch of the piece to the slip [m]."""
    stored: Any


def _tension_of(state: Memory, enclosure: EnclosureLaw) -> _Tension:
    places = _places(state)
    last = state.count - 1
    near = jnp.where(places < last, jnp.roll(state.ends, -1, axis=0), 0.0)
    length = jnp.where((places > 0) & (places <= last), state.ends - near, 0.0) * enclosure.reach
    rise = 2 * state.slopes * length
    near = state.force + _sum_nearer(rise)
    slip = length * (near + rise / 2) / enclosure.stiffness
    square = near**2 + near * rise + rise**2 / 3
    return _Tension(near, rise, slip, length * square / (2 * enclosure.stiffness))


def _book_loss(state: Memory, new: Memory, enclosure: EnclosureLaw) -> Memory:
    """Return the new pieces with the old slip; what they store less is heat."""
    before, after = (_tension_of(s, enclosure).stored.sum(axis=0) for s in (state, new))
    lost = jnp.maximum(before - after, 0.0)
    return new._replace(slip=state.slip, stored=state.stored - lost, heat=state.heat + lost)


def _join_pieces(state: Memory, enclosure: EnclosureLaw) -> Memory:
    """Return the state with one piece less: where that changes least, two of a bow become one.

    The piece before them is drawn out so far that the slip stays; tension then only moves from
    where it is high to where it is low, which stores less. Only turns, which are no bow: the last
    one is forgotten, and reported.
    """
    places = _places(state)
    near, nearer = (jnp.roll(state.ends, -k, axis=0) for k in (1, 2))
    a, b = near - nearer, state.ends - near
    deep, middle, top = (jnp.roll(state.slopes, -k, axis=0) for k in (0, 1, 2))
    first, second = middle - top, deep - middle
    bow = (first * second >= 0) & (deep * top >= 0)
    bow = bow & (places > 0) & (places < state.count - 2)
    cost = jnp.where(bow, a * b * jnp.abs(second), jnp.inf)
    place = jnp.argmin(cost, axis=0)
    bend = first * a + (second + first) * b
    drawn = jnp.where(bend != 0, a * b * second / jnp.where(bend != 0, bend, 1.0), 0.0)
    rest = a + b - drawn
    slope = (middle * a + deep * b - top * drawn) / jnp.where(rest > 0, rest, 1.0)
    here, shift = places == place, places > place
    ends = jnp.where(here, state.ends, jnp.where(shift, near, state.ends))
    joined = state._replace(
        ends=jnp.where(places == place + 1, piece(nearer + drawn, place), ends),
        slopes=jnp.where(here, slope, jnp.where(shift, middle, state.slopes)),
        count=state.count - 1,
    )
    found = piece(bow, place) > 0
    forgotten = state._replace(count=state.count - 1, overflow=state.overflow | ~found)
    return _choose(found, _book_loss(state, joined, enclosure), forgotten)


def at_vacuum(state: Memory, enclosure: EnclosureLaw) -> Memory:
    """The same slip under another vacuum: a higher one changes nothing, a lower one lets slide.

    Every run of pieces of one direction that are steeper than friction now holds turns, from the
    innermost to the driven end, until it is as steep as that, and the strip from its near end on
    is stretched as before. That is exact for one run (a strip that was only pulled out), and for
    more of them close to what a slowly falling vacuum does; it never stores more.
    """
    steep = (_places(state) < state.count) & (jnp.abs(state.slopes) > enclosure.friction)
    return jax.lax.cond(
        jnp.any(steep),
        lambda s: _choose(jnp.any(steep, axis=0), _slide_steep_pieces(s, enclosure), s),
        lambda s: s,
        state,
    )


def _slide_steep_pieces(state: Memory, enclosure: EnclosureLaw) -> Memory:
    """`at_vacuum` where something slides; slip and force are those beyond a place of the strip."""
    places, q, tension = _places(state), enclosure.friction, _tension_of(state, enclosure)
    real = (places > 0) & (places < state.count)
    steep = real & (jnp.abs(state.slopes) > q)
    near = jnp.where(places < state.count - 1, jnp.roll(state.ends, -1, axis=0), 0.0)
    stretch = state.slip - _sum_nearer(tension.slip)
    ahead = jnp.roll(state.slopes, -1, axis=0) * state.slopes > 0
    last = steep & ~(ahead & (places < state.count - 1))
    first = state.count - steep.sum(axis=0)
    end = piece(state.ends, first)
    start = state._replace(
        slip=piece(stretch - tension.slip, first),
        force=piece(tension.near + tension.rise, first),
        slopes=jnp.clip(state.slopes, -q, q),
        count=jnp.maximum(first, 2),
    )

    def turn(place: Any, now: tuple[Memory, Any]) -> tuple[Memory, Any]:
        beyond, at = now
        to, aim = near[place], stretch[place]
        left = jnp.where(to < 1, 1 - to, 1.0)
        slope, more = piece(beyond.slopes, beyond.count - 1), (at - to) * enclosure.reach
        slip = beyond.slip + (beyond.force - slope * more) * more / enclosure.stiffness
        here = beyond._replace(
            slip=slip, force=beyond.force - 2 * slope * more, ends=(beyond.ends - to) / left
        )
        strip = enclosure_of(enclosure.stiffness, q, enclosure.reach * left)
        new = _grow_piece(here, aim, strip)
        on = last[place] & (to < 1)
        new = _choose(on, new._replace(ends=to + left * new.ends), beyond)
        return new, jnp.where(on, to, at)

    whole, _ = jax.lax.fori_loop(1, len(state.ends), turn, (start, end))
    return _book_loss(state, whole, enclosure)


@law
def enclosure_cycle(slip: Any, vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Force [N], stored energy and heat [J] of the enclosure along a slip history [m], shape (N,).

    The enclosure starts relaxed at zero slip; `vacuum` [Pa] is one number or a history of the same
    shape, taken over before each move. NaN from the point where more than `DEPTH` nested turns
    were made, or where slip or vacuum are negative. A hyperelastic enclosure is followed as cells:
    NaN once the vacuum falls, or it would have to be pushed.
    """
    slip = jnp.atleast_1d(slip)
    vacuum = jnp.broadcast_to(vacuum, slip.shape)
    if brake.hyperelastic is not None:
        return along_slip(slip, vacuum, brake)

    def step(state: Memory, point: tuple[Any, Any]) -> Any:
        enclosure = enclosure_at(point[1], brake)
        state = slide_to(at_vacuum(state, enclosure), point[0], enclosure)
        fine = ~state.overflow & (point[0] >= 0) & (point[1] >= 0)
        return state, tuple(within(fine, v) for v in (state.force, state.stored, state.heat))

    return jax.lax.scan(step, at_rest(), (slip, vacuum))[1]
