"""Pull of a stack along a history of elongations: which sheet slides at which elongation.

One increment is a weighted one-dimensional fused lasso (`solve`); the enclosure's faces are in
`enclosure`. If static friction exceeds kinetic friction, breakaway is a jump, not another bound.
The first interface to reach its static bound drops to the kinetic one at that elongation, and the
stack is solved again, until none breaks. Interfaces that a break overloads slip together, or one at
a time, the most overloaded first. An interface returns to static friction when its sliding stops:
when it has not slid and its force has fallen below its kinetic friction. Between jumps heat and
stored energy are exact for any increment, because a sliding interface slides at its bound
throughout.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from layerjam.errors import LayerjamError, ProcedureError, QuantityError
from layerjam.mechanics.compilation import compile_loop, hash_files
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
    is_held,
    margin,
    solve_increment,
    stiffness_sum,
)
from layerjam.mechanics.threads import cache_threadsafe

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

BLOCK = 200_000
"""Number of sheets times increments between two progress reports."""
_ROUNDS = 100
AT_BOUND = -1e-9
"""Relative distance from its bound within which an interface counts as being at it."""
_LEAST = 1e-12  # smallest increment, as a fraction of the elongation
_BREAKS = 500  # breaks in one increment, per sheet


@kernel
def _largest_overload(
    level: float, stack: Stack, state: State, t: Trial, marks: Flags
) -> float:  # pragma: no cover
    """Return the largest relative excess over a static bound; `marks` are those > `level`."""
    worst, stiff = -1.0, stiffness_sum(stack)
    reach = 2 * abs(t.values[CAP]) + abs(state.values[ELONGATION])
    for i in range(len(stack.friction)):
        if is_held(i, stack, state):
            limit = stack.ratio[i] * bound(i, state.past[i], stack)
            excess = (abs(t.force[i]) - margin(i, reach, stiff, stack)) / limit - 1.0
            worst = max(worst, excess)
            marks[i] = excess > level
        else:
            marks[i] = False
    return worst


@kernel
def _accept_trial(
    target: float, jump: float, stack: Stack, state: State, t: Trial
) -> int:  # pragma: no cover
    """Accept the trial as the new state, with its work and heat.

    A sliding interface slides at its bound throughout, at any point of the increment, so its heat
    is exact, and so are the other energies. A jump does no work; its energy becomes heat.
    """
    n = len(stack.springs)
    values, face_energy = state.values, state.faces.energy
    friction_heat, work, elastic = 0.0, face_energy[0] + face_energy[1] - values[STORED], 0.0
    for i in range(n - 1):
        if t.slides[i] != 0:
            slid = abs(t.slip[i] - state.past[i])
            old, new = bound(i, state.past[i], stack), bound(i, t.slip[i], stack)
            if old + new > 0.0 and (old == 0.0 or new == 0.0):  # until the overlap ends
                slid = min(slid, max(old, new) * stack.length[i] / stack.friction[i])
            friction_heat += slid * (old + new) / 2
    heat = friction_heat
    for e in range(2):
        face_work, face_heat, code = move_face(t.push[e], e, state.faces, stack.face)
        if code != DONE:
            return code
        work += face_work
        heat += face_heat
        face_energy[e] += face_work - face_heat
    for i in range(n):
        stretch = t.sheets[i] - (t.values[CAP] if stack.right[i] else 0.0)
        elastic += stack.springs[i] * stretch * stretch / 2
    if not np.isinf(stack.mount):
        elastic += t.values[FORCE] ** 2 / (2 * stack.mount)
    total = elastic + face_energy[0] + face_energy[1]
    values[HEAT] += values[STORED] - total if jump > 0.0 else heat
    values[WORK] += 0.0 if jump > 0.0 else friction_heat + work + elastic
    values[STORED] = total
    values[CAP], values[FORCE], values[ELONGATION] = t.values[CAP], t.values[FORCE], target
    for i in range(n):
        state.sheets[i] = t.sheets[i]
    for i in range(n - 1):
        state.past[i], state.slides[i] = t.slip[i], t.slides[i]
        state.interface[i] = t.force[i]
        # at a jump, rounding alone would determine whether an interface at its bound has stopped
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
def _solve_tension(target: float, stack: Stack, state: State, t: Trial) -> int:  # pragma: no cover
    """Solve in tension only: a brake that would be in compression rests without force."""
    code = solve_increment(target, 0.0, stack, state, t)
    state.values[SLACK] = 0.0
    if code == DONE and t.values[FORCE] < 0.0:
        code = solve_increment(target, 1.0, stack, state, t)
        t.values[FORCE] = 0.0
        state.values[SLACK] = 1.0
    return code


@kernel
def _find_break(
    target: float, marks: Flags, stack: Stack, state: State, t: Trial
) -> tuple[int, float]:  # pragma: no cover
    """Return the point before `target`, the first interface reaches its static bound (Illinois)."""
    low, high = state.values[ELONGATION], target
    above = _largest_overload(AT_BOUND, stack, state, t, marks)
    for i in range(len(t.force)):
        t.force[i] = state.interface[i]
    below, side, point = _largest_overload(AT_BOUND, stack, state, t, marks), 0, target
    for _ in range(_ROUNDS):
        if below >= 0.0 or above == below:
            point = low
        else:
            point = (low * above - high * below) / (above - below)
        code = _solve_tension(point, stack, state, t)
        excess = _largest_overload(AT_BOUND, stack, state, t, marks)
        if code != DONE or (excess <= 0.0 and excess > -1e-11) or point in (low, high):
            # rounding may end the search just short of the bound: the nearest interface breaks
            _largest_overload(min(excess, 0.0) - 1e-9, stack, state, t, marks)
            return code, point
        if excess > 0.0:
            high, above = point, excess
            below = below / 2 if side == 1 else below
            side = 1
        else:
            low, below = point, excess
            above = above / 2 if side == -1 else above
            side = -1
    return STALLED, point


@kernel
def _release_interfaces(marks: Flags, state: State) -> None:  # pragma: no cover
    """Assign kinetic friction to interfaces that have reached their static bound."""
    for i in range(len(marks)):
        if marks[i]:
            state.moving[i] = True


@kernel
def advance(
    target: float, stack: Stack, state: State, t: Trial, marks: Flags
) -> int:  # pragma: no cover
    """Move the crosshead to `target`, stopping at each break of static friction."""
    values = state.values
    if target == values[ELONGATION] or (values[SLACK] > 0.0 and target <= values[CAP]):
        values[ELONGATION] = target
        return DONE
    goal, jump, brittle = target, 0.0, False
    for i in range(len(stack.ratio)):
        brittle |= stack.ratio[i] > 1.0
    for _ in range(_BREAKS * len(stack.springs)):
        code = _solve_tension(goal, stack, state, t)
        short = abs(goal - values[ELONGATION]) <= _LEAST * abs(goal)
        if code in (STALLED, SNAPPED) and jump == 0.0 and not short:
            goal = (
                values[ELONGATION] + (goal - values[ELONGATION]) / 2
            )  # fewer interfaces change state
            continue
        if code != DONE:
            return code
        excess = _largest_overload(AT_BOUND, stack, state, t, marks) if brittle else -1.0
        if excess > 0.0 and jump > 0.0:
            if stack.one_by_one:
                # other interfaces remain as this break left them; identical ones break together
                _largest_overload(excess + AT_BOUND, stack, state, t, marks)
                code = _accept_trial(goal, jump, stack, state, t)
                if code != DONE:
                    return code
            _release_interfaces(marks, state)
            continue
        if excess > 0.0:
            code, goal = _find_break(target, marks, stack, state, t)
            code = code if code != DONE else _accept_trial(goal, jump, stack, state, t)
            if code != DONE:
                return code
            _release_interfaces(marks, state)
            jump = 1.0
            continue
        code = _accept_trial(goal, jump, stack, state, t)
        if code != DONE or goal == target:
            return code
        goal, jump = target, 0.0
    return CHATTER


@register_jitable
def rest_state(stack: Stack) -> State:  # pragma: no cover
    """Return the state of a stack at rest."""
    n = len(stack.springs)
    turns, counts, heading = np.zeros((2, 2, DEPTH)), np.zeros(2, np.int64), np.ones(2, np.int64)
    faces = Faces(turns, counts, heading, np.zeros(2), np.zeros(2), np.zeros(2))
    slides, moving = np.zeros(n - 1, np.int64), np.zeros(n - 1, np.bool_)
    past, interface = np.zeros(n - 1), np.zeros(n - 1)
    return State(past, slides, moving, np.zeros(n), interface, np.zeros(10), faces)


@register_jitable
def make_work(stack: Stack) -> tuple[Trial, Flags]:  # pragma: no cover
    """Return work arrays for its increments."""
    n = len(stack.springs)
    trial = Trial(
        np.zeros(n - 1, np.int64), np.zeros(n), np.zeros(n), np.zeros(n - 1), np.zeros(n - 1),
        np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(n), np.zeros(n - 1), np.zeros(n),
        np.zeros(n, np.int64), np.zeros(n), np.zeros(n), np.zeros((n, 4)), np.zeros((4, 2 * n)),
    )  # fmt: skip
    return trial, np.zeros(n - 1, np.bool_)


@kernel
def is_separated(stack: Stack, state: State) -> bool:  # pragma: no cover
    """Return whether all interfaces that can lose their overlap have lost it."""
    can_separate = False
    for i in range(len(stack.friction)):
        if not np.isinf(stack.length[i]):
            can_separate = True
            slip = -state.past[i] if stack.right[i] else state.past[i]
            if slip < stack.length[i]:
                return False
    return can_separate


class StackPull(NamedTuple):
    """Motion of a stack along N elongations; the walls of a housing count as sheets."""

    force: Array
    """(N,) force at the crosshead [N]."""
    cap: Array
    """(N,) displacement of the moving cap [m]."""
    sheets: Array
    """(N, n) displacement of each sheet [m]."""
    interface: Array
    """(N, n - 1) force of each interface [N]."""
    slip: Array
    """(N, n - 1) slip of each interface, positive as the brake lengthens [m]."""
    sliding: Flags
    """(N, n - 1) True if the interface slides."""
    faces: Array
    """(N, 2) force of the enclosure's faces [N]."""
    work: Array
    """(N,) work done at the crosshead so far [J]."""
    heat: Array
    """(N,) energy dissipated so far [J]: friction, enclosure, and breaks of static friction."""
    stored: Array
    """(N,) elastic energy in sheets, mount and enclosure [J]."""
    slack: Flags
    """(N,) True if the brake is slack: longer than the distance to the crosshead."""
    snapped: bool
    """True if the mount was too soft to continue; the arrays end before it."""


def kernel_stamp() -> str:
    """Return the stamp that validates the cache of a loop over stacks."""
    return hash_files(Path(__file__).parent.glob("*.py"))


@cache_threadsafe
def _compile_follow() -> Any:
    stamp = kernel_stamp()

    @compile_loop(error_model="numpy")
    def follow(
        path: Array, stack: Stack, state: State, room: tuple[Trial, Flags], tracks: StackPull
    ) -> tuple[int, int]:  # pragma: no cover
        len(stamp)
        n, (trial, marks) = len(stack.springs), room
        for step in range(len(path)):
            code = advance(path[step], stack, state, trial, marks)
            if code != DONE:
                return step, code
            values = state.values
            tracks.force[step], tracks.cap[step] = values[FORCE], values[CAP]
            tracks.work[step], tracks.heat[step] = values[WORK], values[HEAT]
            tracks.stored[step], tracks.slack[step] = values[STORED], values[SLACK] > 0.0
            for e in range(2):
                tracks.faces[step, e] = state.faces.push[e]
            for i in range(n):
                tracks.sheets[step, i] = state.sheets[i]
            for i in range(n - 1):
                tracks.interface[step, i] = state.interface[i]
                tracks.slip[step, i] = -state.past[i] if stack.right[i] else state.past[i]
                tracks.sliding[step, i] = state.slides[i] != 0
            if is_separated(stack, state):
                return step + 1, DONE
        return len(path), DONE

    return follow


def check_stack(stack: Stack) -> None:
    """Raise QuantityError for a stack whose arrays do not fit together."""
    n = len(stack.springs)
    rows = (stack.friction, stack.ratio, stack.length)
    if n < 2 or len(stack.right) != n or any(len(a) != n - 1 for a in rows):
        raise QuantityError(f"stack: {n} sheets need {n - 1} interfaces, at least one")
    if not ((stack.friction >= 0).all() and (stack.ratio >= 1).all()):
        raise QuantityError("stack: friction is negative, or static friction is below kinetic")


def pull_stack(
    path: Array,
    stack: Stack,
    progress: Callable[[float], None] | None = None,
    renew: Callable[[Array, Stack], bool] | None = None,
) -> StackPull:
    """Move the crosshead along `path` [m], shape (N,), from rest; it may turn.

    The motion is for tension only: if the crosshead would have to push, the brake rests without
    load, its force is zero, and `slack` is set until the crosshead returns. Buckling of single
    sheets is not checked. The arrays end when no interface overlaps any more, or before the mount
    is too soft to continue. The length of an increment has no effect while interfaces rest or slide
    in one direction. If they reverse within an increment, the heat is that of its net slip.

    `renew` is called before each increment with the slip of the interfaces [m], shape (n - 1,), and
    may change the friction in the stack's arrays; False ends the pull. `progress` is called with
    the completed fraction (0 to 1). Raises QuantityError for a stack whose arrays do not fit
    together and ProcedureError for more nested turns than can be stored.
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
    motion = StackPull(**tracks, snapped=False)
    state, room = rest_state(stack), make_work(stack)
    block, first, code = 1 if renew else max(1, BLOCK // n), 0, DONE
    report_every = max(1, BLOCK // n)
    while first < count and code == DONE:
        if renew and not renew(np.where(stack.right[:-1], -state.past, state.past), stack):
            break
        part = slice(first, min(first + block, count))
        steps, code = _compile_follow()(path[part], stack, state, room, _trim_motion(motion, part))
        first += steps
        if progress and (first % report_every == 0 or not renew):
            progress(1.0 if first < part.stop else first / count)
        if first < part.stop:
            break
    if code == OVERFLOW:
        raise ProcedureError(
            f"procedure: more than {DEPTH} nested reversals; the enclosure's memory "
            "cannot store more"
        )
    if code == CHATTER:
        raise LayerjamError(
            f"stack: static friction breaks and recovers endlessly near {path[first]:.6g} "
            "m; use smaller increments or kinetic friction only"
        )
    if code not in (DONE, SNAPPED):
        raise LayerjamError(
            f"stack: no equilibrium was found at an elongation of {path[first]:.6g} m; please "
            "report this brake"
        )
    return _trim_motion(motion, slice(first), code == SNAPPED)


def _trim_motion(motion: StackPull, part: slice, snapped: bool = False) -> StackPull:
    return StackPull._make([*(track[part] for track in motion[:-1]), snapped])
