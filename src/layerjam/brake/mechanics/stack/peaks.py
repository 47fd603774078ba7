"""Pull of many stacks to their peak, one after another, without history."""

from typing import NamedTuple

import numpy as np

from layerjam.brake.mechanics.stack.enclosure import CHATTER, DONE, SNAPPED
from layerjam.brake.mechanics.stack.history import advance
from layerjam.brake.mechanics.stack.lasso import Array
from layerjam.brake.mechanics.stack.solve import (
    ELONGATION,
    FORCE,
    TOP,
    TOP_ELONGATION,
    TOP_SLIP,
    VALUES,
    Stack,
    State,
    Trial,
)

COARSE, PARTS, LEVELS = 16, 6, 3
"""Increments up to the sum of all friction, then around the peak, each level PARTS/2 finer."""
MAX_STEPS = 200
RESULTS = 5
"""Number of results of a stack: peak, its elongation and slip, stiffness, onset."""


class Curve(NamedTuple):
    """Points of a pull; arrays of MAX_STEPS + 2."""

    elongation: Array
    """Elongation [m]."""
    force: Array
    """Force [N]."""


def _reset_state(n: int, state: State) -> None:
    """Bring a state back to rest."""
    for i in range(n - 1):
        state.past[i], state.slides[i], state.moving[i] = 0.0, 0, False
        state.interface[i] = 0.0
    for i in range(n):
        state.sheets[i] = 0.0
    for i in range(VALUES):
        state.values[i] = 0.0
    for e in range(2):
        state.faces.counts[e], state.faces.heading[e] = 0, 1
        state.faces.gap[e], state.faces.push[e], state.faces.energy[e] = 0.0, 0.0, 0.0


def _copy_state(n: int, new: State, old: State) -> None:
    """Copy `old` into `new` without turning points, because a pull has none."""
    for i in range(n - 1):
        new.past[i], new.slides[i], new.moving[i] = old.past[i], old.slides[i], old.moving[i]
        new.interface[i] = old.interface[i]
    for i in range(n):
        new.sheets[i] = old.sheets[i]
    for i in range(VALUES):
        new.values[i] = old.values[i]
    for e in range(2):
        new.faces.gap[e], new.faces.push[e] = old.faces.gap[e], old.faces.push[e]
        new.faces.energy[e] = old.faces.energy[e]


def _onset_factor(stack: Stack, state: State) -> float:
    """Return the factor on the load at which the first interface slips, if all forces scale."""
    share = np.inf
    for i in range(stack.sheet_count - 1):
        if state.interface[i] != 0.0:
            limit = stack.ratio[i] * stack.friction[i]
            share = min(share, limit / abs(state.interface[i]))
    return share


def _elongation(force: float, track: Curve, points: int) -> float:
    """Return the elongation at which a track first carries `force`, interpolated linearly."""
    k = 1
    while track.force[k] < force and k < points:
        k += 1
    part = (force - track.force[k - 1]) / (track.force[k] - track.force[k - 1])
    return float(track.elongation[k - 1] + part * (track.elongation[k] - track.elongation[k - 1]))


def _pull_to_peak(
    probe: float,
    end: float,
    stack: Stack,
    state: State,
    last: State,
    before: State,
    t: Trial,
    track: Curve,
    place: int,
    out: Array,
) -> int:
    """Pull one stack to its peak; `probe` is a small elongation, `end` the last one."""
    n = stack.sheet_count
    code = advance(probe, stack, state, t)
    onset = probe * _onset_factor(stack, state)
    for i in range(n - 1):
        onset = 0.0 if state.slides[i] != 0 else onset
    if onset > 0.0 and code == DONE:
        code = advance(max(0.9 * onset, probe), stack, state, t)
        out[place + 4] = state.values[FORCE] * _onset_factor(stack, state)
    if code != DONE:
        return code
    strength = 0.0
    for i in range(stack.sheet_count - 1):
        strength += stack.ratio[i] * stack.friction[i]
    unit = strength * state.values[ELONGATION] / state.values[FORCE]
    step, falling, top = unit / COARSE, 0, 0.0
    _copy_state(n, before, state)
    wide, points = step, 1
    track.elongation[0], track.force[0] = 0.0, 0.0
    for _ in range(MAX_STEPS):
        _copy_state(n, last, state)
        track.elongation[points], track.force[points] = (
            state.values[ELONGATION],
            state.values[FORCE],
        )
        points += 1
        target = min(state.values[ELONGATION] + step, end)
        code = advance(target, stack, state, t)
        if code != DONE:
            return code
        if state.values[TOP] > top:
            top, falling, wide = state.values[TOP], 0, 2 * step
            _copy_state(n, before, last)
        else:
            falling += 1
        past = state.values[ELONGATION] > 1.1 * unit
        if target == end or (falling >= 2 and past):
            break
        step *= 1.2 if past else 1.0
    for _ in range(LEVELS):
        _copy_state(n, state, before)
        goal = min(before.values[ELONGATION] + wide, end)
        step, top = (goal - before.values[ELONGATION]) / PARTS, state.values[TOP]
        for part in range(PARTS):
            _copy_state(n, last, state)
            code = advance(goal - (PARTS - 1 - part) * step, stack, state, t)
            if code != DONE:
                return code
            if state.values[TOP] > top:
                top = state.values[TOP]
                _copy_state(n, before, last)
                out[place], out[place + 1] = top, state.values[TOP_ELONGATION]
                out[place + 2] = state.values[TOP_SLIP]
        wide = 2 * step
    track.elongation[points], track.force[points] = before.values[ELONGATION], before.values[FORCE]
    low, high = _elongation(0.2 * top, track, points), _elongation(0.8 * top, track, points)
    out[place + 3] = 0.6 * top / (high - low)
    return code


def follow_peaks(
    first: int,
    last: int,
    probe: float,
    end: float,
    friction: Array,
    length: Array,
    stack: Stack,
    state: State,
    earlier: State,
    before: State,
    t: Trial,
    track: Curve,
    out: Array,
) -> None:
    """Pull stacks `first` to before `last` to their peak, with RESULTS numbers each in `out`.

    `friction` and `length` are flat arrays with the interfaces of all stacks. They replace those in
    the arrays of `stack`.
    """
    n = stack.sheet_count
    for j in range(first, last):
        for i in range(n - 1):
            stack.friction[i] = friction[(n - 1) * j + i]
            stack.length[i] = length[(n - 1) * j + i]
        for k in range(RESULTS):
            out[RESULTS * j + k] = np.nan
        _reset_state(n, state)
        _reset_state(n, earlier)
        _reset_state(n, before)
        code = _pull_to_peak(probe, end, stack, state, earlier, before, t, track, RESULTS * j, out)
        if code != DONE:
            for k in range(RESULTS):
                out[RESULTS * j + k] = np.nan if code in (SNAPPED, CHATTER) else -1.0
