"""Which sheet slides when (ours): a stack followed along a history of elongations.

One increment is a weighted one-dimensional fused lasso (`solve`), the enclosure's faces are in
`enclosure`. Static over kinetic friction is a jump, not another bound: where the first interface
reaches its static bound it drops to the kinetic one at that elongation, the rest is solved again,
until none breaks. What a break overloads lets go together, or one by one, the most overloaded
first. An interface returns to static friction when its sliding stops: when it has not slid and its
force has fallen below its kinetic friction. Between jumps heat and
stored energy are exact whatever the increment: an interface that slides does so at its bound
throughout.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from numba.extending import register_jitable

from layerjam.errors import LayerjamError, ProcedureError, QuantityError
from layerjam.mechanics.compiled import stamp_of
from layerjam.mechanics.stack.enclosure import (
    CHATTER,
    DEPTH,
    DONE,
    OVERFLOW,
    SNAPPED,
    STALLED,
    Faces,
    move_face,
)
from layerjam.mechanics.stack.lasso import kernel
from layerjam.mechanics.stack.solve import (
    CAP,
    ELONGATION,
    FORCE,
    HEAT,
    SLACK,
    STORED,
    TOP,
    TOP_ELONGATION,
    TOP_SLIP,
    WORK,
    Stack,
    State,
    Trial,
    bound,
    holds,
    margin,
    solve,
    stiffness_sum,
)
from layerjam.mechanics.threads import once

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

BLOCK = 200_000
"""Sheets times increments that are followed before anyone hears of it."""
_ROUNDS = 100
AT_BOUND = -1e-9
"""Share of its bound by which an interface may fall short of it and be at it."""
_LEAST = 1e-12  # of the elongation: no increment is cut to less
_BREAKS = 500  # times the sheets, in one increment


@kernel
def _overload(
    level: float, stack: Stack, state: State, t: Trial, which: Flags
) -> float:  # pragma: no cover
    """The most by which an interface exceeds its static bound, over that; marks those > `level`."""
    worst, stiff = -1.0, stiffness_sum(stack)
    reach = 2 * abs(t.values[CAP]) + abs(state.values[ELONGATION])
    for i in range(len(stack.friction)):
        if holds(i, stack, state):
            most = stack.ratio[i] * bound(i, state.past[i], stack)
            over = (abs(t.force[i]) - margin(i, reach, stiff, stack)) / most - 1.0
            worst = max(worst, over)
            which[i] = over > level
        else:
            which[i] = False
    return worst


@kernel
def _accept(
    target: float, jump: float, stack: Stack, state: State, t: Trial
) -> int:  # pragma: no cover
    """Make the trial the state, with its work and heat.

    An interface that slid did so at its bound throughout, whenever in the increment that was: its
    heat is exact, and so is the rest. A jump does no work; what it releases is heat.
    """
    n = len(stack.springs)
    values, held = state.values, state.faces.held
    rubbed, work, stored = 0.0, held[0] + held[1] - values[STORED], 0.0
    for i in range(n - 1):
        if t.slides[i] != 0:
            slid = abs(t.slip[i] - state.past[i])
            old, new = bound(i, state.past[i], stack), bound(i, t.slip[i], stack)
            if old + new > 0.0 and (old == 0.0 or new == 0.0):  # only as far as there is overlap
                slid = min(slid, max(old, new) * stack.length[i] / stack.friction[i])
            rubbed += slid * (old + new) / 2
    heat = rubbed
    for e in range(2):
        done, lost, code = move_face(t.push[e], e, state.faces, stack.face)
        if code != DONE:
            return code
        work += done
        heat += lost
        held[e] += done - lost
    for i in range(n):
        stretch = t.sheets[i] - (t.values[CAP] if stack.right[i] else 0.0)
        stored += stack.springs[i] * stretch * stretch / 2
    if not np.isinf(stack.mount):
        stored += t.values[FORCE] ** 2 / (2 * stack.mount)
    whole = stored + held[0] + held[1]
    values[HEAT] += values[STORED] - whole if jump > 0.0 else heat
    values[WORK] += 0.0 if jump > 0.0 else rubbed + work + stored
    values[STORED] = whole
    values[CAP], values[FORCE], values[ELONGATION] = t.values[CAP], t.values[FORCE], target
    for i in range(n):
        state.sheets[i] = t.sheets[i]
    for i in range(n - 1):
        state.past[i], state.slides[i] = t.slip[i], t.slides[i]
        state.interface[i] = t.force[i]
        # at a jump rounding would say whether one that slid and is still at its bound has stopped
        least = (1.0 + AT_BOUND) * bound(i, t.slip[i], stack)
        state.moving[i] = t.slides[i] != 0 or (state.moving[i] and abs(t.force[i]) >= least)
    if values[FORCE] > values[TOP]:
        values[TOP], values[TOP_ELONGATION] = values[FORCE], target
        slip, (first, last) = 0.0, stack.ends
        for i in range(first, last):
            slip += -t.slip[i] if stack.right[i] else t.slip[i]
        values[TOP_SLIP] = slip / (last - first)
    return DONE


@kernel
def _load(target: float, stack: Stack, state: State, t: Trial) -> int:  # pragma: no cover
    """`solve` in tension only: where the crosshead would push, the brake rests without force."""
    code = solve(target, 0.0, stack, state, t)
    state.values[SLACK] = 0.0
    if code == DONE and t.values[FORCE] < 0.0:
        code = solve(target, 1.0, stack, state, t)
        t.values[FORCE] = 0.0
        state.values[SLACK] = 1.0
    return code


@kernel
def _breaking(
    target: float, which: Flags, stack: Stack, state: State, t: Trial
) -> tuple[int, float]:  # pragma: no cover
    """Where before `target` the first interface reaches its static bound, by Illinois steps."""
    low, high = state.values[ELONGATION], target
    above = _overload(AT_BOUND, stack, state, t, which)
    for i in range(len(t.force)):
        t.force[i] = state.interface[i]
    below, side, at = _overload(AT_BOUND, stack, state, t, which), 0, target
    for _ in range(_ROUNDS):
        if below >= 0.0 or above == below:
            at = low
        else:
            at = (low * above - high * below) / (above - below)
        code = _load(at, stack, state, t)
        over = _overload(AT_BOUND, stack, state, t, which)
        if code != DONE or (over <= 0.0 and over > -1e-11) or at in (low, high):
            # rounding may leave the bracket closed a little short of the bound: the nearest breaks
            _overload(min(over, 0.0) - 1e-9, stack, state, t, which)
            return code, at
        if over > 0.0:
            high, above = at, over
            below = below / 2 if side == 1 else below
            side = 1
        else:
            low, below = at, over
            above = above / 2 if side == -1 else above
            side = -1
    return STALLED, at


@kernel
def _release(which: Flags, state: State) -> None:  # pragma: no cover
    """Interfaces that have reached their static bound go on with kinetic friction."""
    for i in range(len(which)):
        if which[i]:
            state.moving[i] = True


@kernel
def advance(
    target: float, stack: Stack, state: State, t: Trial, which: Flags
) -> int:  # pragma: no cover
    """Move the crosshead to `target`, from break to break of static friction."""
    values = state.values
    if target == values[ELONGATION] or (values[SLACK] > 0.0 and target <= values[CAP]):
        values[ELONGATION] = target
        return DONE
    at, jump, brittle = target, 0.0, False
    for i in range(len(stack.ratio)):
        brittle |= stack.ratio[i] > 1.0
    for _ in range(_BREAKS * len(stack.springs)):
        code = _load(at, stack, state, t)
        short = abs(at - values[ELONGATION]) <= _LEAST * abs(at)
        if code in (STALLED, SNAPPED) and jump == 0.0 and not short:
            at = (
                values[ELONGATION] + (at - values[ELONGATION]) / 2
            )  # fewer interfaces change their minds
            continue
        if code != DONE:
            return code
        over = _overload(AT_BOUND, stack, state, t, which) if brittle else -1.0
        if over > 0.0 and jump > 0.0:
            if stack.one_by_one:
                # the rest stays as this break left it; interfaces that tie go together
                _overload(over + AT_BOUND, stack, state, t, which)
                code = _accept(at, jump, stack, state, t)
                if code != DONE:
                    return code
            _release(which, state)
            continue
        if over > 0.0:
            code, at = _breaking(target, which, stack, state, t)
            code = code if code != DONE else _accept(at, jump, stack, state, t)
            if code != DONE:
                return code
            _release(which, state)
            jump = 1.0
            continue
        code = _accept(at, jump, stack, state, t)
        if code != DONE or at == target:
            return code
        at, jump = target, 0.0
    return CHATTER


@register_jitable
def at_rest(stack: Stack) -> State:  # pragma: no cover
    """A stack at rest."""
    n = len(stack.springs)
    turns, counts, heading = np.zeros((2, 2, DEPTH)), np.zeros(2, np.int64), np.ones(2, np.int64)
    faces = Faces(turns, counts, heading, np.zeros(2), np.zeros(2), np.zeros(2))
    slides, moving = np.zeros(n - 1, np.int64), np.zeros(n - 1, np.bool_)
    past, interface = np.zeros(n - 1), np.zeros(n - 1)
    return State(past, slides, moving, np.zeros(n), interface, np.zeros(10), faces)


@register_jitable
def room_for(stack: Stack) -> tuple[Trial, Flags]:  # pragma: no cover
    """Room to move it in."""
    n = len(stack.springs)
    trial = Trial(
        np.zeros(n - 1, np.int64), np.zeros(n), np.zeros(n), np.zeros(n - 1), np.zeros(n - 1),
        np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(n), np.zeros(n - 1), np.zeros(n),
        np.zeros(n, np.int64), np.zeros(n), np.zeros(n), np.zeros((n, 4)), np.zeros((4, 2 * n)),
    )  # fmt: skip
    return trial, np.zeros(n - 1, np.bool_)


@kernel
def apart(stack: Stack, state: State) -> bool:  # pragma: no cover
    """No interface that can lose its overlap has any left."""
    some = False
    for i in range(len(stack.friction)):
        if not np.isinf(stack.length[i]):
            some = True
            slipped = -state.past[i] if stack.right[i] else state.past[i]
            if slipped < stack.length[i]:
                return False
    return some


class StackPull(NamedTuple):
    """What a stack did along N elongations; a housing's walls count as sheets."""

    force: Array
    """(N,) at the crosshead [N]."""
    cap: Array
    """(N,) displacement of the moving cap [m]."""
    sheets: Array
    """(N, n) displacement of each sheet [m]."""
    interface: Array
    """(N, n - 1) force of each interface [N]."""
    slip: Array
    """(N, n - 1) slip of each interface, positive as the brake lengthens [m]."""
    sliding: Flags
    """(N, n - 1) True where the interface slides."""
    faces: Array
    """(N, 2) force of the enclosure's faces [N]."""
    work: Array
    """(N,) work done at the crosshead so far [J]."""
    heat: Array
    """(N,) energy dissipated so far [J]: friction, enclosure, and what breaks of static friction
    release."""
    stored: Array
    """(N,) elastic energy in sheets, mount and enclosure [J]."""
    slack: Flags
    """(N,) True where the crosshead has come closer than the brake is long."""
    snapped: bool
    """True where the mount was too soft to go on; the arrays end before it."""


def kernel_stamp() -> str:
    """What the cache of a loop over stacks is valid for."""
    return stamp_of(Path(__file__).parent.glob("*.py"))


@once
def _follow() -> Any:
    """The loop over a path."""
    stamp = kernel_stamp()

    @numba.njit(cache=True, error_model="numpy")
    def follow(
        path: Array, stack: Stack, state: State, room: tuple[Trial, Flags], made: StackPull
    ) -> tuple[int, int]:  # pragma: no cover
        len(stamp)
        n, (trial, which) = len(stack.springs), room
        for step in range(len(path)):
            code = advance(path[step], stack, state, trial, which)
            if code != DONE:
                return step, code
            values = state.values
            made.force[step], made.cap[step] = values[FORCE], values[CAP]
            made.work[step], made.heat[step] = values[WORK], values[HEAT]
            made.stored[step], made.slack[step] = values[STORED], values[SLACK] > 0.0
            for e in range(2):
                made.faces[step, e] = state.faces.push[e]
            for i in range(n):
                made.sheets[step, i] = state.sheets[i]
            for i in range(n - 1):
                made.interface[step, i] = state.interface[i]
                made.slip[step, i] = -state.past[i] if stack.right[i] else state.past[i]
                made.sliding[step, i] = state.slides[i] != 0
            if apart(stack, state):
                return step + 1, DONE
        return len(path), DONE

    return follow


def check_stack(stack: Stack) -> None:
    """Raise QuantityError for a stack whose arrays do not fit together."""
    n = len(stack.springs)
    each = (stack.friction, stack.ratio, stack.length)
    if n < 2 or len(stack.right) != n or any(len(a) != n - 1 for a in each):
        raise QuantityError(f"stack: {n} sheets need {n - 1} interfaces, at least one")
    if not ((stack.friction >= 0).all() and (stack.ratio >= 1).all()):
        raise QuantityError("stack: friction must not be negative, nor static below kinetic")


def pull_stack(
    path: Array,
    stack: Stack,
    progress: Callable[[float], None] | None = None,
    renew: Callable[[Array, Stack], bool] | None = None,
) -> StackPull:
    """Move the crosshead along `path` [m], shape (N,), from rest; it may turn.

    Tension only: where the crosshead would have to push, the brake stays as it is without load, its
    force is zero, and `slack` says so until the crosshead is back. Whether a single sheet would
    buckle is not asked. The arrays end where no interface overlaps any more, or before the mount is
    too soft to go on. Where interfaces are at rest or slide in one direction, the length of an
    increment changes nothing; where they turn within one, heat is counted for the slip between its
    ends.

    `renew` is called before each increment with the slip of the interfaces [m], shape (n - 1,), and
    may put other friction into the stack's arrays; False ends the pull. `progress` is called with
    the share done (0 to 1). Raises QuantityError for a stack whose
    arrays do not fit together and ProcedureError for more nested turns than are remembered.
    """
    check_stack(stack)
    n, count = len(stack.springs), len(path)
    path = np.ascontiguousarray(path, float)
    wide = {"sheets": n, "faces": 2, **dict.fromkeys(("interface", "slip", "sliding"), n - 1)}
    tracks: dict[str, Any] = {
        name: np.zeros(
            (count, wide[name]) if name in wide else count,
            bool if name in ("sliding", "slack") else float,
        )
        for name in StackPull._fields[:-1]
    }
    made = StackPull(**tracks, snapped=False)
    state, room = at_rest(stack), room_for(stack)
    block, done, code = 1 if renew else max(1, BLOCK // n), 0, DONE
    heard = max(1, BLOCK // n)
    while done < count and code == DONE:
        if renew and not renew(np.where(stack.right[:-1], -state.past, state.past), stack):
            break
        part = slice(done, min(done + block, count))
        steps, code = _follow()(path[part], stack, state, room, _cut(made, part))
        done += steps
        if progress and (done % heard == 0 or not renew):
            progress(1.0 if done < part.stop else done / count)
        if done < part.stop:
            break
    if code == OVERFLOW:
        raise ProcedureError(
            f"procedure: more than {DEPTH} turns nested in each other; the enclosure remembers no "
            "more"
        )
    if code == CHATTER:
        raise LayerjamError(
            f"stack: static friction breaks and heals without end around {path[done]:.6g} m; take "
            "smaller increments or kinetic friction only"
        )
    if code not in (DONE, SNAPPED):
        raise LayerjamError(
            f"stack: no equilibrium was found at an elongation of {path[done]:.6g} m; please "
            "report this brake"
        )
    return _cut(made, slice(done), code == SNAPPED)


def _cut(made: StackPull, part: slice, snapped: bool = False) -> StackPull:
    """A stretch of the increments."""
    return StackPull._make([*(track[part] for track in made[:-1]), snapped])
