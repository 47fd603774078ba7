"""The sleeve under changing slip: Masing's rule with memory of turning points (ours).

First loading follows the backbone f; after a turn at (x_r, F_r) the force is F_r -/+
2 f(|x - x_r|/2) until an older loop is met, which then goes on as if it had not been left. Of all
remembered branches the lowest counts in loading, the highest in unloading, so that one formula
serves every history. Heat and stored energy are exact integrals over the branches passed.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import (
    Sleeve,
    backbone,
    backbone_dissipated,
    backbone_stored,
    backbone_work,
    inverse_backbone,
    sleeve_at,
)
from layerjam.mechanics.law import law, safe_sqrt, within

DEPTH = 16
"""Turning points remembered in either direction, nested loops one inside the other."""


class Turns(NamedTuple):
    """Remembered turning points, outermost first: slip and force of each, and how many count."""

    slip: Any
    force: Any
    count: Any


class Memory(NamedTuple):
    """State of both faces of the sleeve."""

    slip: Any
    force: Any
    origin: Any
    """Slip at which the backbone starts; moved by a rise of vacuum [m]."""
    highs: Turns
    lows: Turns
    loading: Any
    stored: Any
    heat: Any
    overflow: Any
    """True once more nested turns were made than `DEPTH` holds."""


def at_rest() -> Memory:
    """A relaxed sleeve."""
    none = jnp.zeros(DEPTH)
    turns = Turns(none, none, jnp.array(0))
    zero = jnp.array(0.0)
    no = jnp.array(False)
    return Memory(zero, zero, zero, turns, turns, jnp.array(True), zero, zero, no)


def _push(turns: Turns, slip: Any, force: Any, when: Any) -> Turns:
    here = (jnp.arange(DEPTH) == turns.count) & when
    return Turns(
        jnp.where(here, slip, turns.slip),
        jnp.where(here, force, turns.force),
        turns.count + when,
    )


def facing(state: Memory, loading: bool) -> Memory:
    """The state with its present point remembered as a turn, if the direction changes."""
    turned = state.loading != loading
    full = (state.lows if loading else state.highs).count >= DEPTH
    if loading:
        lows = _push(state.lows, state.slip, state.force, turned)
        changed = state._replace(lows=lows)
    else:
        highs = _push(state.highs, state.slip, state.force, turned)
        changed = state._replace(highs=highs)
    return changed._replace(
        loading=jnp.full_like(state.loading, loading), overflow=state.overflow | (turned & full)
    )


def loading_force(state: Memory, slip: Any, sleeve: Sleeve) -> Any:
    """Force at a slip beyond the present one, for a state that faces loading."""
    ahead = jnp.maximum(slip - state.lows.slip, 0.0) / 2
    branches = state.lows.force + 2 * backbone(ahead, sleeve)
    branches = jnp.where(jnp.arange(DEPTH) < state.lows.count, branches, jnp.inf)
    first = backbone(jnp.maximum(slip - state.origin, 0.0), sleeve)
    return jnp.minimum(first, branches.min())


def unloading_force(state: Memory, slip: Any, sleeve: Sleeve) -> Any:
    """Force at a slip below the present one, for a state that faces unloading."""
    behind = jnp.maximum(state.highs.slip - slip, 0.0) / 2
    branches = state.highs.force - 2 * backbone(behind, sleeve)
    return jnp.where(jnp.arange(DEPTH) < state.highs.count, branches, -jnp.inf).max()


def load_to(state: Memory, slip: Any, sleeve: Sleeve) -> Memory:
    """Stretch to `slip` >= the present one; the state faces loading."""
    index = jnp.arange(DEPTH)
    lows, highs = state.lows, state.highs
    on = index < lows.count
    inner = jnp.where(index + 1 < lows.count, jnp.roll(highs.slip, -1), state.slip)
    start = jnp.clip(inner, state.slip, slip)
    end = jnp.where(on, jnp.clip(highs.slip, start, slip), start)
    a, b = (start - lows.slip) / 2, (end - lows.slip) / 2
    a, b = jnp.where(on, a, 0.0), jnp.where(on, b, 0.0)
    work = jnp.where(on, lows.force, 0.0) * jnp.where(on, end - start, 0.0)
    work = work + 4 * (backbone_work(b, sleeve) - backbone_work(a, sleeve))
    heat = 2 * (backbone_dissipated(b, sleeve) - backbone_dissipated(a, sleeve))
    first = jnp.where(lows.count > 0, jnp.clip(highs.slip[0], state.slip, slip), state.slip)
    a, b = first - state.origin, slip - state.origin
    work = work.sum() + backbone_work(b, sleeve) - backbone_work(a, sleeve)
    heat = heat.sum() + backbone_dissipated(b, sleeve) - backbone_dissipated(a, sleeve)
    left = ((highs.slip > slip) & (index < highs.count)).sum()
    return state._replace(
        slip=slip,
        force=jnp.where(slip > state.slip, loading_force(state, slip, sleeve), state.force),
        highs=highs._replace(count=left),
        lows=lows._replace(count=jnp.minimum(lows.count, left)),
        stored=state.stored + work - heat,
        heat=state.heat + heat,
    )


def unload_to(state: Memory, slip: Any, sleeve: Sleeve) -> Memory:
    """Let shrink to `slip` <= the present one; the state faces unloading."""
    index = jnp.arange(DEPTH)
    lows, highs = state.lows, state.highs
    on = index < highs.count
    start = jnp.clip(jnp.where(index < lows.count, lows.slip, state.slip), slip, state.slip)
    outer = jnp.where(index > 0, jnp.roll(lows.slip, 1), slip)
    end = jnp.where(on, jnp.clip(outer, slip, start), start)
    a, b = (highs.slip - start) / 2, (highs.slip - end) / 2
    a, b = jnp.where(on, a, 0.0), jnp.where(on, b, 0.0)
    work = jnp.where(on, highs.force * (end - start), 0.0)
    work = work + 4 * (backbone_work(b, sleeve) - backbone_work(a, sleeve))
    heat = 2 * (backbone_dissipated(b, sleeve) - backbone_dissipated(a, sleeve))
    left = ((lows.slip < slip) & (index < lows.count)).sum()
    return state._replace(
        slip=slip,
        force=jnp.where(slip < state.slip, unloading_force(state, slip, sleeve), state.force),
        lows=lows._replace(count=left),
        highs=highs._replace(count=jnp.minimum(highs.count, left + 1)),
        stored=state.stored + work.sum() - heat.sum(),
        heat=state.heat + heat.sum(),
    )


def at_vacuum(state: Memory, before: Sleeve, after: Sleeve) -> Memory:
    """The same slip under another vacuum.

    Raising it leaves the force. Lowering it caps the force at the new backbone, and at the force
    of which the stored energy is a first loading's: no state holds a force with less energy, so
    nothing is won by pumping. A sleeve that pushes (force < 0) is let go. Turns are forgotten.
    """
    changed = before.friction != after.friction
    lowered = after.friction < before.friction
    cap = jnp.minimum(backbone(state.slip, after), _force_of_stored(state.stored, after))
    force = jnp.where(lowered, jnp.minimum(state.force, cap), state.force)
    force = jnp.maximum(force, 0.0)
    slip_there = inverse_backbone(force, after)
    stored = jnp.where(lowered, backbone_stored(slip_there, after), state.stored)
    stored = jnp.where(state.force < 0, 0.0, jnp.minimum(stored, state.stored))
    none = jnp.zeros_like(state.highs.count)
    new = state._replace(
        force=force,
        origin=state.slip - slip_there,
        highs=state.highs._replace(count=none),
        lows=state.lows._replace(count=none),
        loading=jnp.full_like(state.loading, True),
        stored=stored,
        heat=state.heat + state.stored - stored,
    )
    return jax.tree.map(lambda a, b: jnp.where(changed, a, b), new, state)


def _force_of_stored(stored: Any, sleeve: Sleeve) -> Any:
    """The inverse of `backbone_stored` over the force [N]."""
    stored = jnp.maximum(stored, 0.0)
    positive = stored * sleeve.root > 0
    spread = jnp.cbrt(jnp.where(positive, 3 * stored * sleeve.root**2, 1.0))
    spread = jnp.where(positive, spread, 0.0)
    full = sleeve.friction * sleeve.reach
    square = 2 * stored * sleeve.stiffness / sleeve.reach - full**2 / 3
    whole = full + safe_sqrt(jnp.maximum(square, 0.0))
    return jnp.where(spread < 2 * full, spread, whole)


@law
def enclosure_cycle(slip: Any, vacuum: Any, brake: Brake) -> tuple[Any, Any, Any]:
    """Force [N], stored energy and heat [J] of the sleeve along a slip history [m], shape (N,).

    The sleeve starts relaxed at zero slip; `vacuum` [Pa] is one number or a history of the same
    shape, taken over before each move. NaN from the point where more than `DEPTH` nested turns
    were made, or where slip or vacuum are negative.
    """
    slip = jnp.atleast_1d(slip)
    vacuum = jnp.broadcast_to(vacuum, slip.shape)

    def step(carry: tuple[Memory, Any], point: tuple[Any, Any]) -> Any:
        state, pressure = carry
        target, new = point
        state = at_vacuum(state, sleeve_at(pressure, brake), sleeve_at(new, brake))
        sleeve = sleeve_at(new, brake)
        more = load_to(facing(state, True), jnp.maximum(target, state.slip), sleeve)
        less = unload_to(facing(state, False), jnp.minimum(target, state.slip), sleeve)
        up, down = target > state.slip, target < state.slip
        state = jax.tree.map(
            lambda m, n, s: jnp.where(up, m, jnp.where(down, n, s)), more, less, state
        )
        fine = ~state.overflow & (target >= 0) & (new >= 0)
        out = tuple(within(fine, v) for v in (state.force, state.stored, state.heat))
        return (state, new), out

    _, out = jax.lax.scan(step, (at_rest(), vacuum[0]), (slip, vacuum))
    return out
