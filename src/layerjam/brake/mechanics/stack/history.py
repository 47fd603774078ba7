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

from typing import NamedTuple

import numpy as np

from layerjam.brake.mechanics.stack.enclosure import (
    CHATTER,
    DONE,
    SNAPPED,
    STALLED,
    Signs,
    move_face,
)
from layerjam.brake.mechanics.stack.lasso import Array
from layerjam.brake.mechanics.stack.solve import (
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
    Flags,
    Stack,
    State,
    Trial,
    bound,
    is_held,
    margin,
    solve_increment,
    stiffness_sum,
)

_ROUNDS = 100
AT_BOUND = -1e-9
"""Relative distance from its bound within which an interface counts as being at it."""
_LEAST = 1e-12  # smallest increment, as a fraction of the elongation
_BREAKS = 500  # breaks in one increment, per sheet


def _largest_overload(level: float, stack: Stack, state: State, t: Trial) -> float:
    """Return the largest relative excess over a static bound; mark those > `level`."""
    worst, stiff = -1.0, stiffness_sum(stack)
    reach = 2 * abs(t.values[CAP]) + abs(state.values[ELONGATION])
    for i in range(stack.sheet_count - 1):
        if is_held(i, stack, state):
            limit = stack.ratio[i] * bound(i, state.past[i], stack)
            excess = (abs(t.force[i]) - margin(i, reach, stiff, stack)) / limit - 1.0
            worst = max(worst, excess)
            t.marks[i] = excess > level
        else:
            t.marks[i] = False
    return worst


def _accept_trial(target: float, jump: float, stack: Stack, state: State, t: Trial) -> int:
    """Accept the trial as the new state, with its work and heat.

    A sliding interface slides at its bound throughout, at any point of the increment, so its heat
    is exact, and so are the other energies. A jump does no work; its energy becomes heat.
    """
    n = stack.sheet_count
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
        elastic += t.values[FORCE] * t.values[FORCE] / (2 * stack.mount)
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
        if t.slides[i] != 0:
            state.moving[i] = True
        elif state.moving[i]:
            # at a jump, rounding alone would determine whether one at its bound has stopped
            least = (1.0 + AT_BOUND) * bound(i, t.slip[i], stack)
            state.moving[i] = abs(t.force[i]) >= least
    if values[FORCE] > values[TOP]:
        values[TOP], values[TOP_ELONGATION] = values[FORCE], target
        first, last = stack.ends
        slip = 0.0
        for i in range(first, last):
            slip += -t.slip[i] if stack.right[i] else t.slip[i]
        values[TOP_SLIP] = slip / (last - first)
    return DONE


def _solve_tension(target: float, stack: Stack, state: State, t: Trial) -> int:
    """Solve in tension only: a brake that would be in compression rests without force."""
    code = solve_increment(target, 0.0, stack, state, t)
    state.values[SLACK] = 0.0
    if code == DONE and t.values[FORCE] < 0.0:
        code = solve_increment(target, 1.0, stack, state, t)
        t.values[FORCE] = 0.0
        state.values[SLACK] = 1.0
    return code


def _find_break(target: float, stack: Stack, state: State, t: Trial) -> tuple[int, float]:
    """Return the point before `target`, the first interface reaches its static bound (Illinois)."""
    low, high = state.values[ELONGATION], target
    above = _largest_overload(AT_BOUND, stack, state, t)
    for i in range(stack.sheet_count - 1):
        t.force[i] = state.interface[i]
    below, side, point = _largest_overload(AT_BOUND, stack, state, t), 0, target
    for _ in range(_ROUNDS):
        if below >= 0.0 or above == below:
            point = low
        else:
            point = (low * above - high * below) / (above - below)
        code = _solve_tension(point, stack, state, t)
        excess = _largest_overload(AT_BOUND, stack, state, t)
        if code != DONE or (excess <= 0.0 and excess > -1e-11) or point in (low, high):
            # rounding may end the search just short of the bound: the nearest interface breaks
            _largest_overload(min(excess, 0.0) - 1e-9, stack, state, t)
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


def _release_interfaces(stack: Stack, state: State, t: Trial) -> None:
    """Assign kinetic friction to interfaces that have reached their static bound."""
    for i in range(stack.sheet_count - 1):
        if t.marks[i]:
            state.moving[i] = True


def advance(target: float, stack: Stack, state: State, t: Trial) -> int:
    """Move the crosshead to `target`, stopping at each break of static friction."""
    values = state.values
    if target == values[ELONGATION] or (values[SLACK] > 0.0 and target <= values[CAP]):
        values[ELONGATION] = target
        return DONE
    goal, jump, brittle = target, 0.0, False
    for i in range(stack.sheet_count - 1):
        brittle |= stack.ratio[i] > 1.0
    for _ in range(_BREAKS * stack.sheet_count):
        code = _solve_tension(goal, stack, state, t)
        short = abs(goal - values[ELONGATION]) <= _LEAST * abs(goal)
        if code in (STALLED, SNAPPED) and jump == 0.0 and not short:
            # fewer interfaces change state
            goal = values[ELONGATION] + (goal - values[ELONGATION]) / 2
            continue
        if code != DONE:
            return code
        excess = _largest_overload(AT_BOUND, stack, state, t) if brittle else -1.0
        if excess > 0.0 and jump > 0.0:
            if stack.one_by_one:
                # other interfaces remain as this break left them; identical ones break together
                _largest_overload(excess + AT_BOUND, stack, state, t)
                code = _accept_trial(goal, jump, stack, state, t)
                if code != DONE:
                    return code
            _release_interfaces(stack, state, t)
            continue
        if excess > 0.0:
            code, goal = _find_break(target, stack, state, t)
            code = code if code != DONE else _accept_trial(goal, jump, stack, state, t)
            if code != DONE:
                return code
            _release_interfaces(stack, state, t)
            jump = 1.0
            continue
        code = _accept_trial(goal, jump, stack, state, t)
        if code != DONE or goal == target:
            return code
        goal, jump = target, 0.0
    return CHATTER


def is_separated(stack: Stack, state: State) -> bool:
    """Return whether all interfaces that can lose their overlap have lost it."""
    can_separate = False
    for i in range(stack.sheet_count - 1):
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


def follow_path(
    first: int,
    last: int,
    path: Array,
    stack: Stack,
    state: State,
    t: Trial,
    motion: StackPull,
    codes: Signs,
) -> int:
    """Follow a path from point `first` to before `last`; return the first point not reached.

    The arrays of `motion` are flat. `codes` has one number, which becomes the result of the last
    increment. The pull also ends once no interface overlaps any more.
    """
    n, values = stack.sheet_count, state.values
    for step in range(first, last):
        codes[0] = advance(path[step], stack, state, t)
        if codes[0] != DONE:
            return step
        motion.force[step], motion.cap[step] = values[FORCE], values[CAP]
        motion.work[step], motion.heat[step] = values[WORK], values[HEAT]
        motion.stored[step], motion.slack[step] = values[STORED], values[SLACK] > 0.0
        for e in range(2):
            motion.faces[2 * step + e] = state.faces.push[e]
        for i in range(n):
            motion.sheets[n * step + i] = state.sheets[i]
        for i in range(n - 1):
            place = (n - 1) * step + i
            motion.interface[place] = state.interface[i]
            motion.slip[place] = -state.past[i] if stack.right[i] else state.past[i]
            motion.sliding[place] = state.slides[i] != 0
        if is_separated(stack, state):
            return step + 1
    return last
