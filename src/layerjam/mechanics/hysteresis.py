"""The brake under a moving crosshead: sheets that stick and slide, the enclosure with its memory.

Tension only: in compression the sheets buckle, the brake carries nothing, and its slip stays where
it is while friction holds the enclosure; otherwise the enclosure closes the brake until it does.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.device.speed_law import SpeedLaw
from layerjam.mechanics.cycle import Cycle
from layerjam.mechanics.enclosure import EnclosureLaw, enclosure_at, one_modulus
from layerjam.mechanics.fan import Fan, along_tangents, force_of, grown, tangent, work_of
from layerjam.mechanics.friction import growth_of, sheets_at
from layerjam.mechanics.law import law
from layerjam.mechanics.memory import (
    DEPTH,
    Memory,
    Turns,
    at_rest,
    at_vacuum,
    branch,
    facing,
    load_to,
    unload_to,
)
from layerjam.mechanics.pull import rising_root
from layerjam.mechanics.rubber_cycle import rubber_cycle
from layerjam.mechanics.stiffness import working_stiffness


class State(NamedTuple):
    """The brake between two moves."""

    enclosure: Memory
    elongation: Any
    force: Any
    work: Any
    heat: Any
    vacuum: Any
    closed: Any
    snapped: Any
    growth: Any = None
    """Friction over that at the speed law's test speed; None without a speed."""


class Setting(NamedTuple):
    """Constants of a move at one vacuum."""

    c: Any
    k: Any
    overlap: Any
    enclosure: EnclosureLaw
    fan: Fan | None = None
    law: SpeedLaw | None = None
    """How friction depends on the sliding speed; `c` is that at the law's test speed."""


def setting_of(vacuum: Any, spring: Any, brake: Brake, growth: Any = None) -> Setting:
    """What resists at a vacuum [Pa] on a spring [N/m], friction multiplied by a `growth`."""
    sheets, enclosure = sheets_at(vacuum, brake), enclosure_at(vacuum, brake)
    if growth is not None:
        sheets = grown(sheets, growth)
    return Setting(sheets.c, spring, sheets.overlap, enclosure, sheets.fan, brake.speed_law)


def first_slip(memory: Memory, elongation: Any, at: Setting) -> Any:
    """Slip where k (u - x) = F_e(x) + F_f(x) on the outermost loading; -inf where it is not met."""
    return along_tangents(lambda line: _first_slip(memory, elongation, line), memory.slip, at)


def _first_slip(memory: Memory, elongation: Any, at: Setting) -> Any:
    onset = at.k * (elongation - memory.origin) - at.c * (at.overlap - memory.origin)
    first = memory.origin + rising_root(onset, at.k - at.c, at.enclosure)
    # before the backbone is joined the base leads there; one that lies ahead, behind a loop, is
    # not reached while it drives nothing
    base = memory.base
    drive = at.k * (elongation - base.slip) - base.force - at.c * (at.overlap - base.slip)
    start = base.slip + rising_root(drive, at.k - at.c, branch(base.strength, at.enclosure))
    start = jnp.where(drive >= 0, jnp.minimum(start, memory.join), -jnp.inf)
    return jnp.where(first >= memory.join, first, start)


def _slide_out(memory: Memory, elongation: Any, at: Setting) -> Any:
    """Slip where k (u - x) = F_e(x) + F_f(x): the farthest root over all loading branches."""

    def root(turns: Turns) -> Any:
        drive = at.k * (elongation - turns.slip) - turns.force
        drive = drive - at.c * (at.overlap - turns.slip)
        return turns.slip + rising_root(drive, at.k - at.c, branch(turns.strength, at.enclosure))

    branches = jnp.where(jnp.arange(DEPTH) < memory.lows.count, root(memory.lows), -jnp.inf)
    first = _first_slip(memory, elongation, at)
    inside = (memory.lows.count > 0) & (first < memory.highs.slip[0])
    first = jnp.where(inside, -jnp.inf, first)
    return jnp.maximum(jnp.maximum(first, branches.max()), memory.slip)


def _slide_back(memory: Memory, elongation: Any, at: Setting) -> Any:
    """Slip where k (u - x) = F_e(x) - F_f(x), or F_e = F_f once the brake is slack."""
    highs = memory.highs

    def root(spring: Any, pull: Any) -> Any:
        drive = highs.force - at.c * (at.overlap - highs.slip) - pull
        strip = branch(highs.strength, at.enclosure)
        slip = highs.slip - rising_root(drive, spring + at.c, strip)
        slip = jnp.where(jnp.arange(DEPTH) < highs.count, slip, jnp.inf).min()
        # a strip that slides back as a whole falls by EA/l
        drive = memory.force - at.c * (at.overlap - memory.slip)
        drive = drive - spring * (elongation - memory.slip)
        whole = drive / (spring + at.c + at.enclosure.stiffness / at.enclosure.reach)
        slip = jnp.where(highs.count > 0, slip, memory.slip - jnp.maximum(whole, 0.0))
        return jnp.clip(slip, 0.0, memory.slip)

    taut = root(at.k, at.k * (elongation - highs.slip))
    return jnp.where(elongation >= taut, taut, root(0.0, 0.0))


def _rubbed(start: Any, end: Any, at: Setting) -> Any:
    """Heat of the sheets' friction over a move [J]; past the end of the overlap nothing counts."""
    if at.fan is not None:
        return jnp.abs(work_of(start, end, at))
    return jnp.abs(end - start) * at.c * (at.overlap - (end + start) / 2)


def move(state: State, elongation: Any, at: Setting) -> State:
    """Move the crosshead at constant vacuum; work and heat are exact."""
    memory = state.enclosure
    trial = at.k * (elongation - memory.slip)
    hold = force_of(memory.slip, at)
    out = trial > memory.force + hold
    back = jnp.maximum(trial, 0.0) < memory.force - hold

    def outward(memory: Memory) -> tuple[Any, Memory]:
        opening = facing(memory, True, at.enclosure)
        far = along_tangents(lambda line: _slide_out(opening, elongation, line), memory.slip, at)
        return far, load_to(opening, far, at.enclosure)

    def inward(memory: Memory) -> tuple[Any, Memory]:
        closing = facing(memory, False, at.enclosure)
        near = along_tangents(lambda line: _slide_back(closing, elongation, line), memory.slip, at)
        return near, unload_to(closing, near, at.enclosure)

    direction = jnp.where(out, 0, jnp.where(back, 1, 2))
    slip, new = jax.lax.switch(direction, [outward, inward, lambda m: (m.slip, m)], memory)
    force = jnp.maximum(at.k * (elongation - slip), 0.0)
    rubbed = _rubbed(memory.slip, slip, at)
    heat = rubbed + new.heat - memory.heat
    elastic = (force**2 - state.force**2) / (2 * at.k)
    return State(
        enclosure=new,
        elongation=elongation,
        force=force,
        work=state.work + heat + (new.stored - memory.stored) + elastic,
        heat=state.heat + heat,
        vacuum=state.vacuum,
        growth=state.growth,
        closed=state.closed | (memory.slip - slip > 1e-12 * at.overlap),
        snapped=state.snapped | (out & (at.k <= tangent(memory.slip, at).c)),
    )


def change_vacuum(state: State, vacuum: Any, before: Setting, after: Setting) -> State:
    """Another vacuum at a fixed crosshead: no work is done, what is released becomes heat."""
    held = at_vacuum(state.enclosure, before.enclosure, after.enclosure)
    moved = move(state._replace(enclosure=held), state.elongation, after)
    spring = (state.force**2 - moved.force**2) / (2 * after.k)
    released = state.enclosure.stored - moved.enclosure.stored + spring
    return moved._replace(work=state.work, heat=state.heat + released, vacuum=vacuum)


@law
def brake_cycle(elongation: Any, vacuum: Any, brake: Brake, speed: Any = None) -> Cycle:
    """The brake along an elongation history [m], shape (N,), from rest at zero elongation.

    `vacuum` [Pa] is one number or a history of the same shape, taken over before each move.
    Sheets stick at k and slide at F_f; the enclosure follows Masing's rule. Once the brake starts
    to slide on a k that is not above c (`least_stiffness`) it snaps, and forces from there are NaN.
    A hyperelastic enclosure is followed as cells, at a vacuum that never falls (NaN from there).
    With `speed` [m/s], that of the crosshead as a number or a history, a speed law counts: the
    crosshead's speed stands for that of the slip, which is 1/(1 + F'/k) of it.
    """
    if brake.hyperelastic is not None:
        if speed is not None:
            one_modulus(brake)
        elongation = jnp.atleast_1d(elongation)
        return rubber_cycle(elongation, jnp.broadcast_to(vacuum, elongation.shape), brake)
    if speed is not None:
        return _paced_cycle(elongation, vacuum, brake, speed)
    return _cycle(elongation, vacuum, None, brake)


def _paced_cycle(elongation: Any, vacuum: Any, brake: Brake, speed: Any) -> Cycle:
    grown = jnp.broadcast_to(growth_of(speed, brake), jnp.shape(jnp.atleast_1d(elongation)))
    return _cycle(elongation, vacuum, grown, brake)


def _cycle(elongation: Any, vacuum: Any, grown: Any, brake: Brake) -> Cycle:
    elongation = jnp.atleast_1d(elongation)
    vacuum = jnp.broadcast_to(vacuum, elongation.shape)
    spring = jnp.asarray(working_stiffness(brake), jnp.float64)

    def step(state: State, point: tuple[Any, Any, Any]) -> tuple[State, Cycle]:
        return stepped(state, *point, spring, brake)

    start = untouched(vacuum[0], None if grown is None else grown[0])
    return jax.lax.scan(step, start, (elongation, vacuum, grown))[1]


def untouched(vacuum: Any, growth: Any = None) -> State:
    """A brake that was never pulled, at a vacuum [Pa]."""
    zero, no = jnp.array(0.0), jnp.array(False)
    return State(at_rest(), zero, zero, zero, zero, vacuum, no, no, growth)


def stepped(
    state: State, target: Any, pressure: Any, growth: Any, spring: Any, brake: Brake
) -> tuple[State, Cycle]:
    """The brake after it took a vacuum [Pa] and moved to an elongation [m], on a spring [N/m]."""
    after = setting_of(pressure, spring, brake, growth)
    same = pressure == state.vacuum
    if growth is not None:
        same = same & (growth == state.growth)
    # most of a history stays at one vacuum: the other branch is not computed there
    state = jax.lax.cond(
        same,
        lambda s: s,
        lambda s: change_vacuum(
            s, pressure, setting_of(s.vacuum, spring, brake, s.growth), after
        )._replace(growth=growth),
        state,
    )
    state = move(state, target, after)
    enclosure = state.enclosure
    fine = (target >= 0) & (pressure >= 0) & ~(enclosure.overflow | state.snapped)
    force = jnp.where(fine, state.force, jnp.nan)
    return state, Cycle(
        force=force,
        slip=enclosure.slip,
        sleeve_force=enclosure.force,
        work=state.work,
        heat=state.heat,
        stored=enclosure.stored + state.force**2 / (2 * after.k),
        slack=(state.force <= 0) & (target < enclosure.slip),
        closed=state.closed,
        separated=enclosure.slip >= brake.sheets.overlap * (1 - 1e-12),
        overflow=enclosure.overflow,
        snapped=state.snapped,
    )
