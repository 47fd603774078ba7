"""Motion in time of a mass pulled through a spring against friction, with true sticking (ours).

While the mass is stuck the slip is not updated at all, so that it stays the same bit for bit over
any time and number of steps. Only the moment at which the spring reaches the static bound is
computed, in closed form. The sliding motion is exact for constant friction; otherwise it is
integrated by Dormand and Prince's pair of order 5 (4). Changes of state (the mass stops, the spring
goes slack or tightens) are located, never stepped over.

The force laws are in `slide_step`.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics.arrays import derivative, leaves, map_leaves, put, repeat_while, xp
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.mechanics.stick_slip.slide_step import (
    SLACK,
    STUCK,
    TAUT,
    Slide,
    State,
    Trial,
    base_drag,
    crosshead_speed,
    exact_step,
    hermite_range,
    hermite_root,
    resistance,
    runge_kutta,
    slip_speed,
    spring_force,
    spring_stretch,
    static_bound,
)

AT_END, ENOUGH_EVENTS, STEADY, SEPARATED, CLOSED, TOO_LONG = 1, 2, 3, 4, 5, 6
"""Reasons for the end of a run; the value is 0 while it runs."""
EVENT_COLUMNS = ("break_time", "stick_time", "force_at_break", "force_high", "force_low", "slip")
TRACE_COLUMNS = ("time", "crosshead", "force", "slip", "speed", "work", "heat", "sliding")
BLOCK = 32
"""Number of cases that run in parallel; all wait for the slowest, and the code is compiled once."""
CALM = 0.02
"""Deviation from steady sliding, relative to the pulling speed, below which it counts as steady."""


def _limit_step(state: State, case: Slide) -> tuple[Any, Any, Any]:
    """Return the longest allowed step, the next instant not to cross, and whether it is near."""
    limit = xp.where(state.time < case.ramp, xp.minimum(case.ramp, case.end), case.end)
    left = limit - state.time
    return xp.minimum(left, case.step), limit, left <= case.step


def _wait_for_breakaway(state: State, case: Slide) -> State:
    """Advance the time of a stuck mass until the spring's force reaches the static bound.

    The slip is constant.
    """
    drive, e0 = crosshead_speed(state.time, case), spring_stretch(state.time, state.slip, case)
    span, limit, is_limit = _limit_step(state, case)
    bound = static_bound(state.slip, case)
    missing = xp.maximum(bound - case.damping * drive, 0.0) / case.spring - e0
    wait = xp.where(drive > 0, missing / xp.where(drive > 0, drive, 1.0), xp.inf)
    wait = xp.where((missing <= 0) & (case.spring * e0 >= bound), 0.0, xp.maximum(wait, 0.0))
    breaks = wait <= span
    stays = xp.where(is_limit, limit, state.time + span)
    time = xp.where(breaks, state.time + wait, stays)
    e1 = xp.maximum(spring_stretch(time, state.slip, case), 0.0)
    extra = e1 - xp.maximum(e0, 0.0)
    loss = case.damping * drive * extra
    gain = case.spring / 2 * (e1**2 - xp.maximum(e0, 0.0) ** 2) + loss
    force = spring_force(e1, drive, case)
    event = xp.stack([time, state.slip, force])
    soonest = 1 / xp.sqrt(case.spring / case.mass)
    layer = case.mass * case.stribeck / xp.maximum(case.level * case.rise, 1e-300)
    first = xp.minimum(soonest, xp.where(case.stribeck > 0, layer, soonest))
    return state._replace(
        time=time,
        work=state.work + gain,
        heat=state.heat + loss,
        mode=xp.where(breaks, TAUT, STUCK),
        next_step=xp.where(breaks, 0.02 * first, state.next_step),
        high=xp.where(breaks, force, xp.maximum(state.high, force)),
        low=xp.where(breaks, force, xp.minimum(state.low, force)),
        broke=xp.where(breaks, event, state.broke),
    )


class _Step(NamedTuple):
    """A trial step and the changes of state in it."""

    slip: Any
    extension: Any
    trial: Trial
    is_stopped: Any
    """Whether the mass is at rest at its end."""
    is_turned: Any
    """Whether the spring has become slack or taut at its end."""
    late: Any
    """Whether it passes a change of state, at about `sooner` from its start."""
    sooner: Any
    tiny: Any
    wrong: Any
    """Whether rounding lost a change of the spring before the step."""
    high: Any
    low: Any


def _try_step(state: State, h: Any, case: Slide, exact: bool) -> _Step:
    drive, e0 = crosshead_speed(state.time, case), spring_stretch(state.time, state.slip, case)
    omega = xp.sqrt(case.spring / case.mass)
    trial = (exact_step if exact else runge_kutta)(state, h, case)
    slip, e1 = state.slip + trial.travel, e0 + drive * h - trial.travel
    taut = state.mode == TAUT
    force0, slope0, gain0 = _net_forces(e0, state.slip, state.velocity, drive, taut, case)
    force1, slope1, gain1 = _net_forces(e1, slip, trial.velocity, drive, taut, case)
    stops, stop_at = hermite_root(h, state.velocity, gain0, trial.velocity, gain1)
    # a taut spring becomes slack at zero force; a slack one becomes taut once it is stretched and
    # pulls
    k = case.spring
    reach0, pace0 = _select_smaller(force0, slope0, k * e0, k * (drive - state.velocity))
    reach1, pace1 = _select_smaller(force1, slope1, k * e1, k * (drive - trial.velocity))
    f0, d0 = xp.where(taut, force0, -reach0), xp.where(taut, slope0, -pace0)
    f1, d1 = xp.where(taut, force1, -reach1), xp.where(taut, slope1, -pace1)
    turns, turn_at = hermite_root(h, f0, d0, f1, d1)
    # near enough to count as the event itself
    strong = 1e-12 * (static_bound(state.slip, case) + case.spring / omega * case.speed)
    inside = (f0 > strong) | (d0 > 0)
    turns = turns & inside
    tiny = h <= 4e-16 * xp.maximum(state.time, 1 / omega)
    resting = xp.abs(trial.velocity) <= 1e-12 * slip_speed(state.slip, case)
    is_stopped = resting & (gain1 < 0) | (stops & tiny)
    is_turned = inside & (xp.abs(f1) <= strong) & (d1 < 0) | (turns & tiny)
    wrong = (f0 < -strong) | ((f0 <= strong) & (d0 < 0) & (f1 < -strong))
    pulls = [xp.where(taut, v, 0.0) for v in (force0, slope0, force1, slope1)]
    high, low = hermite_range(h, *pulls)
    late = (stops & ~is_stopped) | (turns & ~is_turned)
    sooner = xp.minimum(xp.where(stops, stop_at, h), xp.where(turns, turn_at, h))
    return _Step(slip, e1, trial, is_stopped, is_turned, late, sooner, tiny, wrong, high, low)


def _net_forces(e: Any, x: Any, v: Any, drive: Any, taut: Any, case: Slide) -> tuple[Any, Any, Any]:
    """Return the force of spring and damper if they could push [N], its rate, acceleration."""
    force = case.spring * e + case.damping * (drive - v)
    gain = (xp.where(taut, force, 0.0) - resistance(x, v, case)) / case.mass
    return force, case.spring * (drive - v) - case.damping * gain, gain


def _select_smaller(a: Any, slope_a: Any, b: Any, slope_b: Any) -> tuple[Any, Any]:
    return xp.where(b < a, b, a), xp.where(b < a, slope_b, slope_a)


def _move(state: State, case: Slide, exact: bool) -> tuple[State, Any, Any]:
    """Make one trial step of a sliding mass: accept it, cut it at a change of state, or repeat it.

    Returns the state, whether time has passed, and whether the mass has just come to rest.
    """
    drive, omega = crosshead_speed(state.time, case), xp.sqrt(case.spring / case.mass)
    span, limit, is_limit = _limit_step(state, case)
    fixed = case.tolerance == 0
    goal = xp.where(fixed, xp.minimum(state.next_step, case.step), state.next_step)
    h = xp.minimum(xp.minimum(goal, (0.5 if exact else 0.2) / omega), span)
    step = _try_step(state, h, case, exact)
    error = xp.where(xp.isfinite(step.trial.error), step.trial.error, xp.inf)
    valid = (fixed | (error <= case.tolerance) | step.tiny) & ~step.late
    growth = xp.clip(0.9 * (case.tolerance / xp.maximum(error, 1e-300)) ** 0.2, 0.2, 5.0)
    new_mode = xp.where(state.mode == TAUT, SLACK, TAUT)
    time = xp.where(is_limit & (h == span), limit, state.time + h)
    new = state._replace(
        time=time,
        slip=step.slip,
        velocity=xp.where(step.is_stopped, 0.0, step.trial.velocity),
        work=state.work + step.trial.work,
        heat=state.heat + step.trial.heat,
        mode=xp.where(step.is_stopped, STUCK, xp.where(step.is_turned, new_mode, state.mode)),
        next_step=xp.where(fixed, case.step, growth * h),
        high=xp.maximum(state.high, step.high),
        low=xp.minimum(state.low, xp.maximum(step.low, 0.0)),
        deviation=_deviation(step.extension, step.slip, step.trial.velocity, drive, case),
    )
    retry = state._replace(next_step=xp.where(step.late, xp.maximum(step.sooner, 0.0), growth * h))
    # a mass that does not start to move stays in place for this step
    stays = (state.velocity <= 0) & (step.trial.velocity <= 0)
    resting = state._replace(time=time, mode=xp.asarray(STUCK))
    result = _select(stays, resting, _select(valid, new, retry))
    result = _select(step.wrong, state._replace(mode=new_mode), result)
    return (result, (valid | stays) & ~step.wrong, valid & step.is_stopped & ~stays & ~step.wrong)


def _deviation(extension: Any, slip: Any, velocity: Any, drive: Any, case: Slide) -> Any:
    """Return the deviation from sliding with the crosshead, as a speed [m/s]."""
    omega = xp.sqrt(case.spring / case.mass)
    offset = extension - (resistance(slip, drive, case)) / case.spring
    return xp.sqrt((velocity - drive) ** 2 + (omega * offset) ** 2)


def _select(choose: Any, a: State, b: State) -> State:
    tables = ("table", "trace")
    values = {
        name: getattr(a, name) if name in tables else xp.where(choose, x, getattr(b, name))
        for name, x in a._asdict().items()
    }
    return State(**values)


def _record_action(old: State, new: State, has_passed: Any, rests: Any, case: Slide) -> State:
    """Record the event and the sample of this action in their tables."""
    extension, drive = spring_stretch(new.time, new.slip, case), crosshead_speed(new.time, case)
    pull = spring_force(extension, drive - new.velocity, case)
    force = xp.where(new.mode == SLACK, 0.0, pull)
    broke, begin, at_break = old.broke
    slip, low = new.slip - begin, xp.minimum(new.low, force)
    event = xp.stack((broke, new.time, at_break, new.high, low, slip))
    crosshead, sliding = extension + new.slip, xp.where(new.mode == STUCK, 0.0, 1.0)
    row = (new.time, crosshead, force, new.slip, new.velocity, new.work, new.heat, sliding)
    # the last row of a table receives discarded values, because a slice is written in place
    last, end = old.table.shape[0] - 1, old.trace.shape[0] - 1
    place = xp.where(rests, xp.minimum(old.count, last), last)
    line = xp.where(has_passed, old.written, end)
    return new._replace(
        count=old.count + rests,
        table=put(old.table, place, event),
        trace=put(old.trace, line, xp.stack(row)),
        written=xp.minimum(old.written + has_passed, end),
        actions=old.actions + 1,
    )


def _end_reason(state: State, case: Slide, max_actions: int) -> Any:
    """Return the reason for the end of the run, 0 while it runs."""
    force = spring_force(
        spring_stretch(state.time, state.slip, case), crosshead_speed(state.time, case), case
    )
    sheets = static_bound(state.slip, case) - base_drag(state.slip, case)
    closes = (state.mode == STUCK) & (base_drag(state.slip, case) - case.base - force > sheets)
    drive = crosshead_speed(state.time, case)
    steep = derivative(lambda v: resistance(state.slip, v, case), drive)
    calm = (state.mode == TAUT) & (state.deviation < CALM * drive) & (case.damping + steep > 0)
    full = (state.actions >= max_actions) | (
        (state.written >= state.trace.shape[0] - 1) & (state.trace.shape[0] > 2)
    )
    reason = xp.where(full, TOO_LONG, 0)
    reason = xp.where(calm, STEADY, reason)
    reason = xp.where(state.count >= case.events, ENOUGH_EVENTS, reason)
    reason = xp.where(state.time >= case.end, AT_END, reason)
    reason = xp.where(closes, CLOSED, reason)
    return xp.where(state.slip >= case.overlap, SEPARATED, reason)


@compiled(static=("exact", "events", "samples", "max_actions"))
def _run(case: Slide, exact: bool, events: int, samples: int, max_actions: int) -> State:
    zero, none = xp.zeros(()), xp.asarray(0)
    first = xp.stack([zero, case.start, zero, case.start, zero, zero, zero, zero])
    still = State(**dict.fromkeys(State._fields, zero))
    state = still._replace(
        slip=case.start,
        mode=xp.asarray(STUCK),
        count=none,
        broke=xp.zeros(3),
        table=xp.full((events + 1, 6), xp.nan),
        trace=put(xp.zeros((samples + 1, 8)), 0, first),
        written=xp.asarray(1),
        actions=none,
        deviation=zero + xp.inf,
        reason=none,
    )

    def act(state: State) -> State:
        stuck = state.mode == STUCK
        moving, has_passed, rests = _move(state, case, exact)
        new = _select(stuck, _wait_for_breakaway(state, case), moving)
        new = _record_action(state, new, stuck | has_passed, ~stuck & rests, case)
        return new._replace(reason=_end_reason(new, case, max_actions))

    state = repeat_while(lambda s: s.reason == 0, act, state)
    return state._replace(table=state.table[:events], trace=state.trace[:samples])


@compiled(static=("exact", "events", "samples", "max_actions"))
def _run_batch(case: Slide, exact: bool, events: int, samples: int, max_actions: int) -> State:
    import jax

    return jax.vmap(lambda single: _run(single, exact, events, samples, max_actions))(case)


def is_constant(case: Slide) -> bool:
    """Return whether friction depends on neither slip nor speed, so that the motion is exact."""
    plain = (case.fall, case.stribeck, case.viscous)
    return (
        case.enclosure is None
        and case.paced_brake is None
        and not any(np.any(np.asarray(v) != 0) for v in plain)
    )


def slide(
    case: Slide,
    *,
    events: int = 64,
    samples: int = 1,
    max_actions: int = 200_000,
    exact: bool | None = None,
) -> State:
    """Run from rest with an unloaded spring until the end, the last event, or steady sliding.

    Entries of `case` may be arrays of the same shape: all cases then run at once. `events` and
    `samples` size the tables, `max_actions` bounds the actions. `exact` defaults to `is_constant`.
    """
    case = map_leaves(lambda v: np.asarray(v, np.float64), case)
    shape = np.broadcast_shapes(*(v.shape for v in leaves(case)))
    is_exact = is_constant(case) if exact is None else exact
    if not shape:
        return _run(case, is_exact, events, samples, max_actions)
    flat = map_leaves(lambda v: np.broadcast_to(v, shape).ravel(), case)
    count, parts = math.prod(shape), []
    for first in range(0, count, BLOCK):
        # pad the last block with its last case
        indices = np.minimum(np.arange(first, first + BLOCK), count - 1)
        block = map_leaves(lambda v, indices=indices: v[indices], flat)
        parts.append(_run_batch(block, is_exact, events, samples, max_actions))
    results = map_leaves(lambda *blocks: np.concatenate(blocks)[:count], *parts)
    return map_leaves(lambda v: v.reshape(shape + v.shape[1:]), results)
