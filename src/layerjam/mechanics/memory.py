"""The enclosure under changing slip and vacuum: Masing's rule with memory of turning points (ours).

First loading follows the backbone f. Whatever happens later starts where the strip is and moves it
against a *change* of friction: 2 q after a turn, because friction reverses, so that
F = F_r -/+ g(|x - x_r|, 2 q) with g the backbone of that friction (Masing's 2 f(dx/2)). When an
older loop is met it goes on as if it had not been left: of all remembered branches the lowest
counts in loading, the highest in unloading, so that one formula serves every history. Heat and
stored energy are exact integrals over the branches passed.

A change of vacuum at rest changes the friction that is there to be used: see `at_vacuum`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import (
    EnclosureLaw,
    backbone,
    backbone_dissipated,
    backbone_stored,
    backbone_work,
    enclosure_at,
    enclosure_of,
    inverse_backbone,
    slipped_area,
)
from layerjam.mechanics.law import law, safe_sqrt, within
from layerjam.mechanics.rubber_strip import along_slip

DEPTH = 16
"""Turning points remembered in either direction, nested loops one inside the other."""
NEAR = 1e-9
"""Share within which two numbers count as equal. Histories reach equalities exactly (a loop that
closes, a strip that just slides), and rounding must not decide what comes then."""
NEAR_IN_SINGLE = 1e-4
"""The same in single precision, whose rounding is coarser."""


class Turns(NamedTuple):
    """Remembered turning points, outermost first, and how many count."""

    slip: Any
    force: Any
    strength: Any
    """Change of friction the branch from here moves against [N/m]."""
    count: Any


class Memory(NamedTuple):
    """State of both faces of the enclosure."""

    slip: Any
    force: Any
    origin: Any
    """Slip at which the backbone starts [m]; moved where the strip's state is not known."""
    base: Turns
    """Where loading starts after a change of vacuum: one point, with its strength (shape ())."""
    join: Any
    """Slip at which that branch reaches the backbone [m]."""
    down: Any
    """Strength of unloading from here, if this point has not been left since the change [N/m]."""
    grip: Any
    """Friction [N/m] under which the strip last slid, if that was first loading and it has only
    been held harder since; negative otherwise."""
    highs: Turns
    lows: Turns
    loading: Any
    stored: Any
    heat: Any
    overflow: Any
    """True once more nested turns were made than `DEPTH` holds."""


def at_rest() -> Memory:
    """A relaxed enclosure."""
    none, zero, no = jnp.zeros(DEPTH), jnp.array(0.0), jnp.array(False)
    turns = Turns(none, none, none, jnp.array(0))
    base = Turns(zero, zero, zero, jnp.array(0))
    yes, void = jnp.array(True), jnp.array(-1.0)
    return Memory(zero, zero, zero, base, zero, zero, void, turns, turns, yes, zero, zero, no)


def near(number: Any) -> float:
    """Share within which two numbers of this precision count as equal."""
    return NEAR if jnp.result_type(number) == jnp.float64 else NEAR_IN_SINGLE


def branch(strength: Any, enclosure: EnclosureLaw) -> EnclosureLaw:
    """The strip as it answers a move against a change of friction `strength` [N/m]."""
    return enclosure_of(enclosure.stiffness, strength, enclosure.reach)


def _push(turns: Turns, slip: Any, force: Any, strength: Any, when: Any) -> Turns:
    here = (jnp.arange(DEPTH) == turns.count) & when
    return Turns(
        jnp.where(here, slip, turns.slip),
        jnp.where(here, force, turns.force),
        jnp.where(here, strength, turns.strength),
        turns.count + when,
    )


def _innermost(turns: Turns, otherwise: Any) -> Any:
    """Strength of the innermost turn, if there is one."""
    last = jnp.arange(DEPTH) == turns.count - 1
    return jnp.where(turns.count > 0, jnp.where(last, turns.strength, 0.0).sum(), otherwise)


def _unmoved(state: Memory) -> Any:
    """The strip has not moved since the vacuum was changed."""
    return (state.base.count > 0) & (
        jnp.abs(state.slip - state.base.slip) <= near(state.slip) * state.slip
    )


def _sliding_back(state: Memory) -> Any:
    """The whole strip slides back: it rests on the force that friction just fails to hold."""
    on = _unmoved(state) & (state.down == 0)
    return on & (state.highs.count == 0) & (state.lows.count == 0)


def facing(state: Memory, loading: bool, enclosure: EnclosureLaw) -> Memory:
    """The state with its present point remembered as a turn, if the direction changes."""
    turned = state.loading != loading
    full = (state.lows if loading else state.highs).count >= DEPTH
    # loops inside a loop move against the same change of friction, so that they close where they
    # opened; the outermost knows whether it starts where the vacuum was changed
    turn = jnp.where(_unmoved(state) & (not loading), state.down, 2 * enclosure.friction)
    turned = turned & ~(_sliding_back(state) & (not loading))
    if loading:
        turn = _innermost(state.highs, turn)
        changed = state._replace(lows=_push(state.lows, state.slip, state.force, turn, turned))
    else:
        turn = _innermost(state.lows, turn)
        changed = state._replace(highs=_push(state.highs, state.slip, state.force, turn, turned))
    return changed._replace(
        loading=jnp.full_like(state.loading, loading), overflow=state.overflow | (turned & full)
    )


def first_force(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Any:
    """Force of the outermost loading: from the base up to `join`, then the backbone."""
    ahead = jnp.maximum(slip - state.base.slip, 0.0)
    start = state.base.force + backbone(ahead, branch(state.base.strength, enclosure))
    after = backbone(jnp.maximum(slip - state.origin, 0.0), enclosure)
    return jnp.where(slip < state.join, start, after)


def loading_force(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Any:
    """Force at a slip beyond the present one, for a state that faces loading."""
    ahead = jnp.maximum(slip - state.lows.slip, 0.0)
    branches = state.lows.force + backbone(ahead, branch(state.lows.strength, enclosure))
    branches = jnp.where(jnp.arange(DEPTH) < state.lows.count, branches, jnp.inf)
    inside = (state.lows.count > 0) & (slip < state.highs.slip[0])
    first = jnp.where(inside, jnp.inf, first_force(state, slip, enclosure))
    return jnp.minimum(first, branches.min())


def unloading_force(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Any:
    """Force at a slip below the present one, for a state that faces unloading."""
    behind = jnp.maximum(state.highs.slip - slip, 0.0)
    branches = state.highs.force - backbone(behind, branch(state.highs.strength, enclosure))
    return jnp.where(jnp.arange(DEPTH) < state.highs.count, branches, -jnp.inf).max()


def first_work(state: Memory, start: Any, end: Any, enclosure: EnclosureLaw) -> tuple[Any, Any]:
    """Work and heat [J] of the outermost loading from slip `start` to `end`."""
    base = state.base
    joined = jnp.clip(state.join, start, end)
    on, strip = joined > start, branch(base.strength, enclosure)
    a, b = (jnp.where(on, x - base.slip, 0.0) for x in (start, joined))
    work = jnp.where(on, base.force * (joined - start), 0.0)
    work = work + backbone_work(b, strip) - backbone_work(a, strip)
    heat = enclosure.friction * (slipped_area(b, strip) - slipped_area(a, strip))
    a, b = (jnp.maximum(x - state.origin, 0.0) for x in (joined, end))
    work = work + backbone_work(b, enclosure) - backbone_work(a, enclosure)
    return work, heat + backbone_dissipated(b, enclosure) - backbone_dissipated(a, enclosure)


def _along(
    turns: Turns, on: Any, start: Any, end: Any, friction: Any, enclosure: EnclosureLaw
) -> tuple[Any, Any]:
    """Work and heat over branches from slip `start` to `end`, each measured from its turn.

    `friction` [N/m] rubs on what slips. Out and back over a loop it must add up to the loop's
    strength, which is the work the loop takes: q going back, the rest going out.
    """
    strip = branch(turns.strength, enclosure)
    a = jnp.where(on, jnp.abs(start - turns.slip), 0.0)
    b = jnp.where(on, jnp.abs(end - turns.slip), 0.0)
    work = jnp.where(on, turns.force * (end - start), 0.0)
    work = work + backbone_work(b, strip) - backbone_work(a, strip)
    heat = friction * (slipped_area(b, strip) - slipped_area(a, strip))
    return work.sum(), heat.sum()


def load_to(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Memory:
    """Stretch to `slip` >= the present one; the state faces loading."""
    index = jnp.arange(DEPTH)
    lows, highs = state.lows, state.highs
    on = index < lows.count
    inner = jnp.where(index + 1 < lows.count, jnp.roll(highs.slip, -1), state.slip)
    start = jnp.clip(inner, state.slip, slip)
    end = jnp.where(on, jnp.clip(highs.slip, start, slip), start)
    work, heat = _along(lows, on, start, end, lows.strength - enclosure.friction, enclosure)
    first = jnp.where(lows.count > 0, jnp.clip(highs.slip[0], state.slip, slip), state.slip)
    more, warmer = first_work(state, first, slip, enclosure)
    work, heat = work + more, heat + warmer
    left = ((highs.slip * (1 - near(slip)) > slip) & (index < highs.count)).sum()
    return state._replace(
        slip=slip,
        force=jnp.where(slip > state.slip, loading_force(state, slip, enclosure), state.force),
        highs=highs._replace(count=left),
        lows=lows._replace(count=jnp.minimum(lows.count, left)),
        stored=state.stored + work - heat,
        heat=state.heat + heat,
    )


def unload_to(state: Memory, slip: Any, enclosure: EnclosureLaw) -> Memory:
    """Let shrink to `slip` <= the present one; the state faces unloading."""
    index = jnp.arange(DEPTH)
    lows, highs = state.lows, state.highs
    on = index < highs.count
    start = jnp.clip(jnp.where(index < lows.count, lows.slip, state.slip), slip, state.slip)
    outer = jnp.where(index > 0, jnp.roll(lows.slip, 1), slip)
    end = jnp.where(on, jnp.clip(outer, slip, start), start)
    work, heat = _along(highs, on, start, end, enclosure.friction, enclosure)
    left = ((lows.slip < slip * (1 - near(slip))) & (index < lows.count)).sum()
    # a strip that slides back as a whole takes its base along
    slides = _sliding_back(state)
    distance = state.slip - slip
    fallen = state.force - enclosure.stiffness * distance / enclosure.reach
    force = jnp.where(slides, fallen, unloading_force(state, slip, enclosure))
    force = jnp.where(distance > 0, force, state.force)
    work = jnp.where(slides, -distance * (state.force + fallen) / 2, work)
    heat = jnp.where(slides, enclosure.friction * enclosure.reach * distance, heat)
    base = state.base._replace(
        slip=jnp.where(slides, slip, state.base.slip),
        force=jnp.where(slides, force, state.base.force),
    )
    return state._replace(
        slip=slip,
        force=force,
        base=base,
        join=jnp.where(slides, _crossing(slip, force, enclosure), state.join),
        lows=lows._replace(count=left),
        highs=highs._replace(count=jnp.minimum(highs.count, left + 1)),
        loading=state.loading | slides,
        stored=state.stored + work - heat,
        heat=state.heat + heat,
    )


def at_vacuum(state: Memory, before: EnclosureLaw, after: EnclosureLaw) -> Memory:
    """The same slip under another vacuum; turns are forgotten.

    Raising it leaves the force, lowering it caps the force at the new backbone. How the strip
    goes on is exact in three cases. In first loading, raised: it has q' - q to spare where it
    slid and joins the new backbone where the old sliding zone ends; backwards it moves against
    q + q'; as long as it rests, another vacuum is counted from q again, since a strip at rest
    cannot know how often the gauge was read. In first loading, lowered: it is on the new
    backbone. Lowered so far that friction no longer holds a strip that was let back: it slides
    to EA x/l - q'l. In every other state the strip goes on along a backbone that starts later,
    from a force whose first loading would store no more energy than there is: softer than the
    strip, but nothing is won by pumping. An enclosure that pushes (force < 0) is let go.
    """
    slip, new, share = state.slip, after.friction, near(state.slip)
    straight = (state.highs.count == 0) & (state.lows.count == 0)
    gripped = _unmoved(state) & straight & (state.grip >= 0)
    q = jnp.where(gripped, state.grip, before.friction)
    raised = new > q
    first = state.loading & (state.lows.count == 0) & (slip >= state.join * (1 - share))
    first = first & (jnp.abs(state.origin) <= share * slip)
    whole = after.stiffness * slip / after.reach
    # without friction turns mean nothing, and the strip is stretched evenly
    even = (q == 0) & (jnp.abs(state.force - whole) <= share * whole)
    known = first | gripped | even
    least = whole - new * after.reach
    slid_back = _slid_back_stored(least, after)
    back = ~known & (least > share * whole) & (state.force <= least + share * whole)
    back = back & (state.stored >= slid_back * (1 - share))
    most = backbone(slip, after)
    held = jnp.minimum(jnp.minimum(state.force, most), _force_of_stored(state.stored, after))
    unsure = jnp.maximum(jnp.where(raised, state.force, held), 0.0)
    force = jnp.where(known, jnp.where(raised, state.force, most), jnp.where(back, least, unsure))
    there = inverse_backbone(unsure, after)
    stored = jnp.where(raised, state.stored, backbone_stored(there, after))
    stored = jnp.where(state.force < -share * whole, 0.0, stored)
    stored = jnp.where(back, slid_back, stored)
    exact = jnp.where(raised, state.stored, backbone_stored(slip, after))
    stored = jnp.minimum(jnp.where(known, exact, stored), state.stored)
    zone = jnp.where(q > 0, state.force / 2 / jnp.where(q > 0, q, 1.0), after.reach)
    ends = inverse_backbone(force + 2 * (new - q) * jnp.minimum(zone, after.reach), after)
    spare = known & raised & (slip > share * after.reach)
    join = jnp.where(spare, ends, jnp.where(back, _crossing(slip, force, after), slip))
    changed = state._replace(
        force=force,
        origin=jnp.where(known | back, 0.0, slip - there),
        base=Turns(slip, force, jnp.where(spare, new - q, 2 * new), jnp.ones_like(DEPTH)),
        join=join,
        down=jnp.where(spare, new + q, jnp.where(back, 0.0, 2 * new)),
        grip=jnp.where(spare, q, -1.0),
        highs=state.highs._replace(count=jnp.zeros_like(state.highs.count)),
        lows=state.lows._replace(count=jnp.zeros_like(state.lows.count)),
        loading=jnp.full_like(state.loading, True),
        stored=stored,
        heat=state.heat + state.stored - stored,
    )
    return jax.tree.map(lambda a, b: jnp.where(new != before.friction, a, b), changed, state)


def _slid_back_stored(force: Any, enclosure: EnclosureLaw) -> Any:
    """Elastic energy [J] of a strip whose tension rises by q from its ends to the middle."""
    face, full = force / 2, enclosure.friction * enclosure.reach
    return 2 * enclosure.reach * (face**2 + face * full + full**2 / 3) / enclosure.stiffness


def _crossing(slip: Any, force: Any, enclosure: EnclosureLaw) -> Any:
    """Where a branch of strength 2 q from (slip, force) meets the saturated backbone [m].

    EA x/l + q l = F + 2 sqrt(2 EA q dx): only a strip that slid back as a whole starts one.
    """
    root, slope = jnp.sqrt(2.0) * enclosure.root, enclosure.stiffness / enclosure.reach
    short = jnp.maximum(slope * slip + enclosure.friction * enclosure.reach - force, 0.0)
    rest = safe_sqrt(jnp.maximum(root**2 - 4 * slope * short, 0.0))
    return slip + ((root - rest) / (2 * slope)) ** 2


def _force_of_stored(stored: Any, enclosure: EnclosureLaw) -> Any:
    """The inverse of `backbone_stored` over the force [N]."""
    stored = jnp.maximum(stored, 0.0)
    positive = stored * enclosure.root > 0
    spread = jnp.cbrt(jnp.where(positive, 3 * stored * enclosure.root**2, 1.0))
    spread = jnp.where(positive, spread, 0.0)
    full = enclosure.friction * enclosure.reach
    square = 2 * stored * enclosure.stiffness / enclosure.reach - full**2 / 3
    whole = full + safe_sqrt(jnp.maximum(square, 0.0))
    return jnp.where(spread < 2 * full, spread, whole)


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

    def step(carry: tuple[Memory, Any], point: tuple[Any, Any]) -> Any:
        state, pressure = carry
        target, new = point
        state = at_vacuum(state, enclosure_at(pressure, brake), enclosure_at(new, brake))
        enclosure = enclosure_at(new, brake)
        ahead, behind = facing(state, True, enclosure), facing(state, False, enclosure)
        more = load_to(ahead, jnp.maximum(target, state.slip), enclosure)
        less = unload_to(behind, jnp.minimum(target, state.slip), enclosure)
        up, down = target > state.slip, target < state.slip
        state = jax.tree.map(
            lambda m, n, s: jnp.where(up, m, jnp.where(down, n, s)), more, less, state
        )
        fine = ~state.overflow & (target >= 0) & (new >= 0)
        out = tuple(within(fine, v) for v in (state.force, state.stored, state.heat))
        return (state, new), out

    _, out = jax.lax.scan(step, (at_rest(), vacuum[0]), (slip, vacuum))
    return out
