"""The enclosure under changing slip and vacuum: piecewise tension along its strips (ours).

A point at a distance s from the driven end of half a face is coupled to that end only by the
friction in between, which carries at most q s. A move therefore clips each point's old tension to
the range N0 - q s to N0 + q s, with N0 the tension of the end. The sliding part grows from the end,
the rest does not change, and the tension is a chain of straight pieces. While the front crosses a
piece, the force follows the backbone of the change of slope there. This is 2 q after a turn at
constant vacuum (Masing's rule), and q' - q if a strip that was stretched under q is stretched
further under q'. Work and heat are exact integrals.

A rising vacuum does not change the tension. Under a falling vacuum, pieces slide that are steeper
than friction now allows (see `Memory.apply_vacuum`).
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import choose, map_leaves, repeat, scan, xp
from layerjam.brake.mechanics.cycle import Setting
from layerjam.brake.mechanics.effects import has_single_modulus
from layerjam.brake.mechanics.enclosure import EnclosureLaw, brake_enclosure, make_enclosure
from layerjam.brake.mechanics.law import compiled, keep_if, law, safe_sqrt
from layerjam.brake.mechanics.rubber_strip import Rubber, make_cells, new_strip
from layerjam.brake.mechanics.slip_effects import find_equilibrium

DEPTH = 16
"""Largest number of nested turning points in each direction that are stored."""
PIECES = 2 * DEPTH + 5
"""Largest number of pieces of tension that are stored, including the middle of the face."""
CLOSE = 1e-9
"""Relative difference within which two numbers count as equal. Histories reach equality exactly
(a loop that closes), and rounding must not affect the next step."""
CLOSE_IN_SINGLE = 1e-4
"""The same for single precision."""


class Memory(NamedTuple):
    """State of both faces of the enclosure."""

    slip: Any
    force: Any
    ends: Any
    """Distance of the pieces from the driven end, relative to half the free length; the innermost
    first, shape (PIECES, ...). The first has no length: it is the middle of the face.
    """
    slopes: Any
    """Slope of their tension versus that distance [N/m]; -q if the strip was pulled out."""
    count: Any
    stored: Any
    heat: Any
    overflow: Any
    """True once there were more nested turns than `DEPTH`."""

    @property
    def is_invalid(self) -> Any:
        """Return whether there were too many turns for valid numbers."""
        return self.overflow

    def find_slip(self, elongation: Any, direction: Any, setting: Setting) -> Any:
        """Return the slip at which spring, enclosure, friction balance; direction 1 out, -1 back.

        It solves k (u - x) = F_e(x) + F_f(x), or - F_f(x) in unloading; if the present slip is
        already beyond the solution, it is returned.
        """
        ready = face_direction(self, direction, setting.enclosure)
        path = find_path(ready, direction, setting.enclosure)
        is_bounded = xp.isfinite(path.end)
        ends = self.slip + direction * xp.where(is_bounded, path.end, 0.0)

        def solve_line(line: Setting) -> Any:
            def drive(slip: Any, force: Any) -> Any:
                pull = direction * (line.k * (elongation - slip) - force)
                return pull - line.c * (line.overlap - slip)

            is_passed = is_bounded & ((path.end <= 0) | (drive(ends, path.end_force) > 0))
            place = ready.count - 2 - is_passed.sum(axis=0)
            start, strength = pick_piece(path.slip, place), pick_piece(path.strength, place)
            strip = branch(strength, line.enclosure)
            pull, spring = drive(start, pick_piece(path.force, place)), line.k - direction * line.c
            return start + direction * strip.find_slip(pull, spring)

        slip = find_equilibrium(solve_line, self.slip, setting)
        return xp.where(direction * (slip - self.slip) > 0, xp.maximum(slip, 0.0), self.slip)

    def balance(self, elongation: Any, out: Any, returns: Any, setting: Setting) -> "Memory":
        """Return the enclosure after a move to an elongation [m], if it slides out or returns."""
        direction = xp.where(returns, -1.0, 1.0)

        def slide(tries: Any, slip: Any) -> Any:
            # a brake that has become slack has slid back without the spring
            slack = (tries == 1) & returns & (elongation < slip)
            pull = setting._replace(k=xp.where(slack, 0.0, setting.k))
            is_sliding = (tries == 0) | slack
            return choose(
                is_sliding, lambda: self.find_slip(elongation, direction, pull), lambda: slip
            )

        slip = choose(out | returns, lambda: repeat(2, slide, self.slip), lambda: self.slip)
        return self.slide_to(slip, setting.enclosure)

    def slide_to(self, slip: Any, enclosure: EnclosureLaw) -> "Memory":
        """Return the enclosure after a move out or back to a slip [m], with its work and heat."""
        new = _grow_piece(self, slip, enclosure)
        is_full = new.count >= len(self.ends)  # leave room for the next turning point
        return choose(
            xp.any(is_full),
            lambda s: _choose(is_full, _join_pieces(s, enclosure), s),
            lambda s: s,
            new,
        )

    def apply_vacuum(self, enclosure: EnclosureLaw) -> "Memory":
        """Return the state under a different vacuum at the same slip; only a lower one changes it.

        Runs of pieces of one direction that are steeper than friction now allows become flatter,
        from the innermost to the driven end, until they are as steep as allowed. The stretch of the
        strip beyond the near end of a run does not change. This is exact for one run (a strip that
        was only pulled out), and close to the effect of a slowly falling vacuum for several runs.
        The stored energy never increases.
        """
        is_steep = (_piece_indices(self) < self.count) & (xp.abs(self.slopes) > enclosure.friction)
        return choose(
            xp.any(is_steep),
            lambda s: _choose(xp.any(is_steep, axis=0), _slide_steep_pieces(s, enclosure), s),
            lambda s: s,
            self,
        )


class Path(NamedTuple):
    """Branch of each piece for a move in one direction; arrays of the shape of `ends`."""

    slip: Any
    """Start of the branch, as if the whole move had crossed this piece [m]."""
    force: Any
    strength: Any
    """Change of friction against which the branch moves [N/m]."""
    begin: Any
    """Move from the present slip until the front reaches the piece [m], and its far end; infinite
    beyond the middle.
    """
    end: Any
    end_force: Any
    """Force with the front at the far end [N]."""


def new_memory(shape: tuple[int, ...] = ()) -> Memory:
    """Return a relaxed enclosure, or an array of them."""
    zero = xp.zeros(shape)
    zeros = xp.zeros((PIECES, *shape))
    middle = xp.concatenate([zeros[:2] + 1.0, zeros[2:]])
    return Memory(zero, zero, middle, zeros, xp.full(shape, 2), zero, zero, zero > 0)


def branch(strength: Any, enclosure: EnclosureLaw) -> EnclosureLaw:
    """Return the response of the strip to a move against a change of friction `strength` [N/m]."""
    return make_enclosure(enclosure.stiffness, strength, enclosure.reach)


def _piece_indices(state: Memory) -> Any:
    return xp.arange(len(state.ends)).reshape((-1,) + (1,) * xp.ndim(state.count))


def pick_piece(values: Any, place: Any) -> Any:
    """Return the entry of an array over the pieces, at one index for each strip."""
    places = xp.arange(len(values)).reshape((-1,) + (1,) * xp.ndim(place))
    return xp.where(places == place, values, 0.0).sum(axis=0)


def _sum_nearer(values: Any) -> Any:
    """Return for each piece the sum over the pieces nearer to the driven end."""
    return xp.flip(xp.cumsum(xp.flip(values, 0), axis=0), 0) - values


def _with_piece(state: Memory, place: Any, end: Any, slope: Any) -> Memory:
    """Return the state with a piece at an index; that index becomes the last valid one."""
    is_place = _piece_indices(state) == place
    return state._replace(
        ends=xp.where(is_place, end, state.ends),
        slopes=xp.where(is_place, slope, state.slopes),
        count=place + 1,
    )


def face_direction(state: Memory, direction: Any, enclosure: EnclosureLaw) -> Memory:
    """Return the state with a new piece growing from the driven end: direction 1 out, -1 back."""
    slope = -direction * enclosure.friction
    turned = pick_piece(state.slopes, state.count - 1) != slope
    return _choose(turned, _with_piece(state, state.count, 0.0, slope), state)


def find_path(state: Memory, direction: Any, enclosure: EnclosureLaw) -> Path:
    """Return the branches ahead of a state from `face_direction`."""
    places = _piece_indices(state)
    is_active = places < state.count - 1
    slope = -direction * enclosure.friction
    strength = xp.where(is_active & (places > 0), xp.abs(slope - state.slopes), 0.0)
    strip, near_end = branch(strength, enclosure), xp.roll(state.ends, -1, axis=0)
    near_end, far_end = xp.where(is_active, near_end, 0.0), xp.where(is_active, state.ends, 0.0)
    longer = strip.saturation * (far_end**2 - near_end**2)
    harder = 2 * strength * enclosure.reach * (far_end - near_end)
    begin, force = _sum_nearer(longer), state.force + direction * _sum_nearer(harder)
    return Path(
        slip=state.slip + direction * (begin - strip.saturation * near_end**2),
        force=force - direction * 2 * strength * enclosure.reach * near_end,
        strength=strength,
        begin=xp.where(is_active, begin, 0.0),
        end=xp.where(is_active & (places > 0), begin + longer, xp.inf),
        end_force=force + direction * harder,
    )


def sliding_fraction(state: Memory) -> Any:
    """Return how far the last move reached from the driven end, relative to half the length [-].

    The force then rises by EA over that length.
    """
    return pick_piece(state.ends, state.count - 1)


def _grow_piece(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Memory:
    """Return the same, possibly with one piece more than the limit."""
    direction = xp.where(slip < state.slip, -1.0, 1.0)
    distance = xp.abs(slip - state.slip)
    ready = face_direction(state, direction, enclosure)
    path = find_path(ready, direction, enclosure)
    places = _piece_indices(state)
    is_active = places < ready.count - 1
    # a loop counts as closed if it closes within rounding
    branch_way = path.end - direction * (path.slip - state.slip)
    tolerance = CLOSE if xp.result_type(distance) == xp.float64 else CLOSE_IN_SINGLE
    is_reached = path.end - tolerance * xp.where(path.end < xp.inf, branch_way, 0.0) <= distance
    is_reached = ~is_active | is_reached | ((path.strength <= 0) & (places > 0))
    is_passed = is_active & xp.flip(xp.cumprod(xp.flip(is_reached, 0), axis=0), 0).astype(bool)
    place = ready.count - 2 - is_passed.sum(axis=0)
    start, strength = pick_piece(path.slip, place), pick_piece(path.strength, place)
    advance, strip = xp.maximum(direction * (slip - start), 0.0), branch(strength, enclosure)
    spread = xp.where(strip.saturation > 0, strip.saturation, 1.0)
    share = xp.where(strip.saturation > advance, safe_sqrt(advance / spread), 1.0)
    near_end = pick_piece(xp.where(is_active, xp.roll(ready.ends, -1, axis=0), 0.0), place)
    end = xp.clip(share, near_end, pick_piece(ready.ends, place))
    new = _with_piece(ready, place + 1, end, -direction * enclosure.friction)

    strips = branch(path.strength, enclosure)
    first, last = xp.minimum(path.begin, distance), xp.minimum(path.end, distance)
    is_crossed = is_active & (last > first)
    a, b = (
        xp.where(is_crossed, xp.maximum(w - direction * (path.slip - state.slip), 0.0), 0.0)
        for w in (first, last)
    )
    work = xp.where(is_crossed, direction * path.force * (b - a), 0.0)
    work = (work + strips.work(b) - strips.work(a)).sum(axis=0)
    heat = (strips.slipped_area(b) - strips.slipped_area(a)).sum(axis=0) * enclosure.friction
    new = new._replace(
        slip=slip,
        force=pick_piece(path.force, place) + direction * strip.force(advance),
        stored=ready.stored + work - heat,
        heat=ready.heat + heat,
    )
    return _choose(slip != state.slip, new, state)


def _choose(condition: Any, yes: Memory, no: Memory) -> Memory:
    return map_leaves(lambda a, b: xp.where(condition, a, b), yes, no)


class _Tension(NamedTuple):
    """Tension of both faces by pieces; arrays of the shape of `ends`."""

    start: Any
    """Tension of both faces at the near end [N], and its rise up to the far end."""
    rise: Any
    slip: Any
    """Contribution of the piece's stretch to the slip [m]."""
    stored: Any


def _piece_tension(state: Memory, enclosure: EnclosureLaw) -> _Tension:
    places = _piece_indices(state)
    last = state.count - 1
    start = xp.where(places < last, xp.roll(state.ends, -1, axis=0), 0.0)
    length = xp.where((places > 0) & (places <= last), state.ends - start, 0.0) * enclosure.reach
    rise = 2 * state.slopes * length
    start = state.force + _sum_nearer(rise)
    slip = length * (start + rise / 2) / enclosure.stiffness
    square = start**2 + start * rise + rise**2 / 3
    return _Tension(start, rise, slip, length * square / (2 * enclosure.stiffness))


def _book_loss(state: Memory, new: Memory, enclosure: EnclosureLaw) -> Memory:
    """Return the new pieces at the old slip; the loss of stored energy becomes heat."""
    before, after = (_piece_tension(s, enclosure).stored.sum(axis=0) for s in (state, new))
    loss = xp.maximum(before - after, 0.0)
    return new._replace(slip=state.slip, stored=state.stored - loss, heat=state.heat + loss)


def _join_pieces(state: Memory, enclosure: EnclosureLaw) -> Memory:
    """Return the state with one piece fewer: join the two whose union changes the tension least.

    The two must have the same direction. The piece before them is lengthened so that the slip does
    not change. Tension then only moves from high to low, which stores less energy. If all
    neighbours have opposite directions, the last turn is dropped and reported.
    """
    places = _piece_indices(state)
    near_end, nearer = (xp.roll(state.ends, -k, axis=0) for k in (1, 2))
    a, b = near_end - nearer, state.ends - near_end
    deep, middle, top = (xp.roll(state.slopes, -k, axis=0) for k in (0, 1, 2))
    first, second = middle - top, deep - middle
    bow = (first * second >= 0) & (deep * top >= 0)
    bow = bow & (places > 0) & (places < state.count - 2)
    cost = xp.where(bow, a * b * xp.abs(second), xp.inf)
    place = xp.argmin(cost, axis=0)
    bend = first * a + (second + first) * b
    extension = xp.where(bend != 0, a * b * second / xp.where(bend != 0, bend, 1.0), 0.0)
    remainder = a + b - extension
    slope = (middle * a + deep * b - top * extension) / xp.where(remainder > 0, remainder, 1.0)
    is_place, shift = places == place, places > place
    ends = xp.where(is_place, state.ends, xp.where(shift, near_end, state.ends))
    new = state._replace(
        ends=xp.where(places == place + 1, pick_piece(nearer + extension, place), ends),
        slopes=xp.where(is_place, slope, xp.where(shift, middle, state.slopes)),
        count=state.count - 1,
    )
    has_bow = pick_piece(bow, place) > 0
    forgotten = state._replace(count=state.count - 1, overflow=state.overflow | ~has_bow)
    return _choose(has_bow, _book_loss(state, new, enclosure), forgotten)


def _slide_steep_pieces(state: Memory, enclosure: EnclosureLaw) -> Memory:
    """Apply the lower vacuum if anything slides, from the innermost piece to the driven end."""
    places, q, tension = _piece_indices(state), enclosure.friction, _piece_tension(state, enclosure)
    real = (places > 0) & (places < state.count)
    is_steep = real & (xp.abs(state.slopes) > q)
    near_end = xp.where(places < state.count - 1, xp.roll(state.ends, -1, axis=0), 0.0)
    stretch = state.slip - _sum_nearer(tension.slip)
    continues = xp.roll(state.slopes, -1, axis=0) * state.slopes > 0
    last = is_steep & ~(continues & (places < state.count - 1))
    first = state.count - is_steep.sum(axis=0)
    end = pick_piece(state.ends, first)
    start = state._replace(
        slip=pick_piece(stretch - tension.slip, first),
        force=pick_piece(tension.start + tension.rise, first),
        slopes=xp.clip(state.slopes, -q, q),
        count=xp.maximum(first, 2),
    )

    def turn(place: Any, carry: tuple[Memory, Any]) -> tuple[Memory, Any]:
        is_turn = last[place] & (near_end[place] < 1)
        return choose(xp.any(is_turn), turn_at, lambda *_: carry, place, is_turn, carry)

    def turn_at(place: Any, is_turn: Any, carry: tuple[Memory, Any]) -> tuple[Memory, Any]:
        outer, position = carry
        border, aim = near_end[place], stretch[place]
        share_left = xp.where(border < 1, 1 - border, 1.0)
        slope = pick_piece(outer.slopes, outer.count - 1)
        length = (position - border) * enclosure.reach
        slip = outer.slip + (outer.force - slope * length) * length / enclosure.stiffness
        local = outer._replace(
            slip=slip,
            force=outer.force - 2 * slope * length,
            ends=(outer.ends - border) / share_left,
        )
        strip = make_enclosure(enclosure.stiffness, q, enclosure.reach * share_left)
        new = _grow_piece(local, aim, strip)
        new = _choose(is_turn, new._replace(ends=border + share_left * new.ends), outer)
        return new, xp.where(is_turn, border, position)

    result, _ = repeat(len(state.ends), turn, (start, end), first=1)
    return _book_loss(state, result, enclosure)


def relaxed_enclosure(path: Any, vacuum: Any, brake: Brake) -> Memory | Rubber:
    """Return a new enclosure for a history of slip or elongation [m] and of vacuum [Pa]."""
    if has_single_modulus(brake):
        return new_memory()
    return new_strip(make_cells(path.max(), vacuum.min(), vacuum.max(), brake))


@law
@compiled
def enclosure_cycle(slip: Any, vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Return force [N], stored energy and heat [J] of the enclosure along a slip history [m], (N,).

    The enclosure starts relaxed at zero slip; `vacuum` [Pa] is one number or a history of the same
    shape, applied before each move. NaN after more than `DEPTH` nested turns, or where slip or
    vacuum are negative. A hyperelastic enclosure is divided into cells: NaN once the vacuum falls
    while it is stretched, or if it would have to be pushed.
    """
    slip = xp.atleast_1d(slip)
    vacuum = xp.broadcast_to(vacuum, slip.shape)

    def step(state: Memory | Rubber, point: tuple[Any, Any]) -> Any:
        enclosure: Any = brake_enclosure(point[1], brake)
        state = state.apply_vacuum(enclosure).slide_to(point[0], enclosure)
        is_valid = ~state.is_invalid & (point[0] >= 0) & (point[1] >= 0)
        return state, tuple(keep_if(is_valid, v) for v in (state.force, state.stored, state.heat))

    return scan(step, relaxed_enclosure(slip, vacuum, brake), (slip, vacuum))[1]
