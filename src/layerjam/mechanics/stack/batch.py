"""Many stacks pulled in parallel on all cores: peak, stiffness and onset, without history.

Each stack is independent of the others, so neither their number nor the threads change its result.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layerjam.mechanics.compilation import compile_loop
from layerjam.mechanics.stack.enclosure import CHATTER, DONE, SNAPPED
from layerjam.mechanics.stack.lasso import kernel
from layerjam.mechanics.stack.pull import advance, check_stack, kernel_stamp, make_work, rest_state
from layerjam.mechanics.stack.solve import (
    ELONGATION,
    FORCE,
    TOP,
    TOP_ELONGATION,
    TOP_SLIP,
    Stack,
    State,
    Trial,
)
from layerjam.mechanics.threads import Workers, cache_threadsafe

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

COARSE, PARTS, LEVELS = 16, 6, 3
"""Increments up to the sum of all friction, then around the peak, each level PARTS/2 finer."""
_MAX_STEPS = 200


@dataclass(frozen=True)
class Peaks:
    """Results of M stacks; arrays of shape (M,).

    NaN if a mount was too soft, or if static friction broke and recovered endlessly.
    """

    peak: Array = field(repr=False)
    """Largest force of each pull [N]."""
    elongation: Array = field(repr=False)
    """Elongation at that force [m]."""
    slip: Array = field(repr=False)
    """Mean slip of the interfaces at that force [m]."""
    stiffness: Array = field(repr=False)
    """Secant stiffness between 1/5 and 4/5 of that force [N/m], as used in a calibration."""
    onset: Array = field(repr=False)
    """Force at which the first interface slips [N]."""


@kernel
def _copy_state(new: State, old: State) -> None:  # pragma: no cover
    """Copy `old` into `new` without turning points, because a pull has none."""
    for i in range(len(old.past)):
        new.past[i], new.slides[i], new.moving[i] = old.past[i], old.slides[i], old.moving[i]
        new.interface[i] = old.interface[i]
    for i in range(len(old.sheets)):
        new.sheets[i] = old.sheets[i]
    for i in range(len(old.values)):
        new.values[i] = old.values[i]
    for e in range(2):
        new.faces.gap[e], new.faces.push[e] = old.faces.gap[e], old.faces.push[e]
        new.faces.energy[e] = old.faces.energy[e]


@kernel
def _onset_factor(stack: Stack, state: State) -> float:  # pragma: no cover
    """Return the factor on the load at which the first interface slips, if all forces scale."""
    share = np.inf
    for i in range(len(stack.friction)):
        if state.interface[i] != 0.0:
            limit = stack.ratio[i] * stack.friction[i]
            share = min(share, limit / abs(state.interface[i]))
    return share


@kernel
def _elongation(force: float, track: Array, points: int) -> float:  # pragma: no cover
    """Return the elongation at which a track first carries `force`, interpolated linearly."""
    k = 1
    while track[1, k] < force and k < points:
        k += 1
    part = (force - track[1, k - 1]) / (track[1, k] - track[1, k - 1])
    return float(track[0, k - 1] + part * (track[0, k] - track[0, k - 1]))


@kernel
def _pull_to_peak(
    probe: float,
    end: float,
    stack: Stack,
    states: tuple[State, State, State],
    room: tuple[Trial, Flags],
    track: Array,
    out: Array,
) -> int:  # pragma: no cover
    """Pull one stack to its peak; `probe` is a small elongation, `end` the last one."""
    (state, last, before), (trial, overload) = states, room
    code = advance(probe, stack, state, trial, overload)
    onset = probe * _onset_factor(stack, state)
    for i in range(len(state.past)):
        onset = 0.0 if state.slides[i] != 0 else onset
    if onset > 0.0 and code == DONE:
        code = advance(max(0.9 * onset, probe), stack, state, trial, overload)
        out[4] = state.values[FORCE] * _onset_factor(stack, state)
    if code != DONE:
        return code
    strength = 0.0
    for i in range(len(stack.friction)):
        strength += stack.ratio[i] * stack.friction[i]
    unit = strength * state.values[ELONGATION] / state.values[FORCE]
    step, falling, top = unit / COARSE, 0, 0.0
    _copy_state(before, state)
    wide, points = step, 1
    track[0, 0], track[1, 0] = 0.0, 0.0
    for _ in range(_MAX_STEPS):
        _copy_state(last, state)
        track[0, points], track[1, points] = state.values[ELONGATION], state.values[FORCE]
        points += 1
        target = min(state.values[ELONGATION] + step, end)
        code = advance(target, stack, state, trial, overload)
        if code != DONE:
            return code
        if state.values[TOP] > top:
            top, falling, wide = state.values[TOP], 0, 2 * step
            _copy_state(before, last)
        else:
            falling += 1
        past = state.values[ELONGATION] > 1.1 * unit
        if target == end or (falling >= 2 and past):
            break
        step *= 1.2 if past else 1.0
    for _ in range(LEVELS):
        _copy_state(state, before)
        goal = min(before.values[ELONGATION] + wide, end)
        step, top = (goal - before.values[ELONGATION]) / PARTS, state.values[TOP]
        for part in range(PARTS):
            _copy_state(last, state)
            code = advance(goal - (PARTS - 1 - part) * step, stack, state, trial, overload)
            if code != DONE:
                return code
            if state.values[TOP] > top:
                top = state.values[TOP]
                _copy_state(before, last)
                out[0], out[1], out[2] = top, state.values[TOP_ELONGATION], state.values[TOP_SLIP]
        wide = 2 * step
    track[0, points], track[1, points] = before.values[ELONGATION], before.values[FORCE]
    low, high = _elongation(0.2 * top, track, points), _elongation(0.8 * top, track, points)
    out[3] = 0.6 * top / (high - low)
    return code


@cache_threadsafe
def _compile_loop() -> Any:
    stamp = kernel_stamp()

    @compile_loop(nogil=True, error_model="numpy")
    def pull_all(
        probe: float, end: float, friction: Array, length: Array, stack: Stack, out: Array
    ) -> None:  # pragma: no cover
        len(stamp)
        track = np.zeros((2, _MAX_STEPS + 2))
        springs, right, _, ratio, _, mount, ends, face, one_by_one = stack
        for j in range(len(friction)):
            single = Stack(
                springs, right, friction[j], ratio, length[j], mount, ends, face, one_by_one
            )
            states = rest_state(single), rest_state(single), rest_state(single)
            code = _pull_to_peak(probe, end, single, states, make_work(single), track, out[j])
            if code != DONE:
                for k in range(5):
                    out[j, k] = np.nan if code in (SNAPPED, CHATTER) else -1.0

    return pull_all


def find_peaks(stack: Stack, friction: Array, length: Array, end: float) -> Peaks:
    """Pull stacks from rest to their peak, at most to the elongation `end` [m].

    They are identical to `stack` except for `friction` [N] and `length` [m], shape (M, n - 1).
    Breaks of static friction are located exactly. Otherwise the peak is found by increments: COARSE
    of them up to the sum of all friction, then LEVELS x PARTS around the largest.
    """
    check_stack(stack)
    out = np.full((len(friction), 5), np.nan)
    strength = float(stack.springs.sum()) / 4
    soft = 1 / strength + (0.0 if np.isinf(stack.mount) else 1 / stack.mount)
    probe = 0.01 * float(stack.friction.sum()) * soft
    friction, length = np.ascontiguousarray(friction), np.ascontiguousarray(length)

    def pull_share(first: int, last: int) -> None:
        part = slice(first, last)
        _compile_loop()(probe, end, friction[part], length[part], stack, out[part])

    with Workers() as pool:
        pool.share(len(out), pull_share)
    return Peaks(*out.T)
