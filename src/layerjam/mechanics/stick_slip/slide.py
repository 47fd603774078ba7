"""A mass pulled through a spring against friction, in time, with true stick (ours).

The stuck state is a state of its own: while it lasts the slip is not updated at all, so that it
stays the same bit for bit however long and in whatever steps time passes; only the moment at which
the spring reaches the static bound is computed, in closed form. While the mass slides the motion
is exact where friction is constant, otherwise by Dormand and Prince's pair of order 5 (4). Changes
of state (the mass stops, the spring goes slack or tightens) are located, never stepped over.

The force laws stand in `slide_step`.
"""

import math
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.mechanics.law import in_double_precision
from layerjam.mechanics.stick_slip.slide_step import (
    SLACK,
    STUCK,
    TAUT,
    Slide,
    State,
    Trial,
    crosshead_speed,
    exactly,
    extension_at,
    hermite_range,
    hermite_root,
    passive,
    resistance,
    runge_kutta,
    slip_speed,
    spring_force,
    static_bound,
)

AT_END, ENOUGH_EVENTS, STEADY, SEPARATED, CLOSED, TOO_LONG = 1, 2, 3, 4, 5, 6
"""Why a run ended; 0 while it runs."""
EVENT_COLUMNS = ("break_time", "stick_time", "force_at_break", "force_high", "force_low", "slip")
TRACE_COLUMNS = ("time", "crosshead", "force", "slip", "speed", "work", "heat", "sliding")
BLOCK = 32
"""Cases that run side by side; all wait for the slowest, and any number is compiled once."""
CALM = 0.02
"""A deviation from steady sliding below this share of the pulling speed counts as steady."""


def _bound(state: State, at: Slide) -> tuple[Any, Any, Any]:
    """Longest step from here, the next instant that no step may pass, and whether it is near."""
    limit = jnp.where(state.time < at.ramp, jnp.minimum(at.ramp, at.end), at.end)
    left = limit - state.time
    return jnp.minimum(left, at.step), limit, left <= at.step


def _stay(state: State, at: Slide) -> State:
    """Stuck: time passes until the spring's force reaches the static bound; the slip stays."""
    drive, e0 = crosshead_speed(state.time, at), extension_at(state.time, state.slip, at)
    span, limit, whole = _bound(state, at)
    bound = static_bound(state.slip, at)
    needed = jnp.maximum(bound - at.damping * drive, 0.0) / at.spring - e0
    wait = jnp.where(drive > 0, needed / jnp.where(drive > 0, drive, 1.0), jnp.inf)
    wait = jnp.where((needed <= 0) & (at.spring * e0 >= bound), 0.0, jnp.maximum(wait, 0.0))
    breaks = wait <= span
    stays = jnp.where(whole, limit, state.time + span)
    time = jnp.where(breaks, state.time + wait, stays)
    e1 = jnp.maximum(extension_at(time, state.slip, at), 0.0)
    stretched = e1 - jnp.maximum(e0, 0.0)
    lost = at.damping * drive * stretched
    gained = at.spring / 2 * (e1**2 - jnp.maximum(e0, 0.0) ** 2) + lost
    force = spring_force(e1, drive, at)
    here = jnp.stack([time, state.slip, force])
    soonest = 1 / jnp.sqrt(at.spring / at.mass)
    layer = at.mass * at.stribeck / jnp.maximum(at.level * at.rise, 1e-300)
    first = jnp.minimum(soonest, jnp.where(at.stribeck > 0, layer, soonest))
    return state._replace(
        time=time,
        work=state.work + gained,
        heat=state.heat + lost,
        mode=jnp.where(breaks, TAUT, STUCK),
        next_step=jnp.where(breaks, 0.02 * first, state.next_step),
        high=jnp.where(breaks, force, jnp.maximum(state.high, force)),
        low=jnp.where(breaks, force, jnp.minimum(state.low, force)),
        broke=jnp.where(breaks, here, state.broke),
    )


class _Step(NamedTuple):
    """A step tried, and what would change in it."""

    slip: Any
    extension: Any
    trial: Trial
    stopped: Any
    """The mass is at rest at its end."""
    turned: Any
    """The spring has become slack or taut at its end."""
    late: Any
    """It leads past a change, which lies about `sooner` from its start."""
    sooner: Any
    tiny: Any
    wrong: Any
    """Rounding lost a change of the spring before the step."""
    high: Any
    low: Any


def _tried(state: State, h: Any, at: Slide, exact: bool) -> _Step:
    """Step by `h` and look for changes of state in it."""
    drive, e0 = crosshead_speed(state.time, at), extension_at(state.time, state.slip, at)
    omega = jnp.sqrt(at.spring / at.mass)
    trial = (exactly if exact else runge_kutta)(state, h, at)
    slip, e1 = state.slip + trial.moved, e0 + drive * h - trial.moved
    taut = state.mode == TAUT
    force0, slope0, gain0 = _forces(e0, state.slip, state.velocity, drive, taut, at)
    force1, slope1, gain1 = _forces(e1, slip, trial.velocity, drive, taut, at)
    stops, stop_at = hermite_root(h, state.velocity, gain0, trial.velocity, gain1)
    # a taut spring turns slack at no force, a slack one tightens once it is stretched and pulls
    reach0, pace0 = _least(force0, slope0, at.spring * e0, at.spring * (drive - state.velocity))
    reach1, pace1 = _least(force1, slope1, at.spring * e1, at.spring * (drive - trial.velocity))
    f0, d0 = jnp.where(taut, force0, -reach0), jnp.where(taut, slope0, -pace0)
    f1, d1 = jnp.where(taut, force1, -reach1), jnp.where(taut, slope1, -pace1)
    turns, turn_at = hermite_root(h, f0, d0, f1, d1)
    # close enough to count as the event itself
    strong = 1e-12 * (static_bound(state.slip, at) + at.spring / omega * at.speed)
    inside = (f0 > strong) | (d0 > 0)
    turns = turns & inside
    tiny = h <= 4e-16 * jnp.maximum(state.time, 1 / omega)
    resting = jnp.abs(trial.velocity) <= 1e-12 * slip_speed(state.slip, at)
    stopped = resting & (gain1 < 0) | (stops & tiny)
    turned = inside & (jnp.abs(f1) <= strong) & (d1 < 0) | (turns & tiny)
    wrong = (f0 < -strong) | ((f0 <= strong) & (d0 < 0) & (f1 < -strong))
    pulls = [jnp.where(taut, v, 0.0) for v in (force0, slope0, force1, slope1)]
    high, low = hermite_range(h, *pulls)
    late = (stops & ~stopped) | (turns & ~turned)
    sooner = jnp.minimum(jnp.where(stops, stop_at, h), jnp.where(turns, turn_at, h))
    return _Step(slip, e1, trial, stopped, turned, late, sooner, tiny, wrong, high, low)


def _forces(e: Any, x: Any, v: Any, drive: Any, taut: Any, at: Slide) -> tuple[Any, Any, Any]:
    """Spring and damper as if they could push [N], how fast that changes, acceleration."""
    force = at.spring * e + at.damping * (drive - v)
    gain = (jnp.where(taut, force, 0.0) - resistance(x, v, at)) / at.mass
    return force, at.spring * (drive - v) - at.damping * gain, gain


def _least(a: Any, slope_a: Any, b: Any, slope_b: Any) -> tuple[Any, Any]:
    return jnp.where(b < a, b, a), jnp.where(b < a, slope_b, slope_a)


def _move(state: State, at: Slide, exact: bool) -> tuple[State, Any, Any]:
    """Sliding: one step tried; taken, cut short at a change of state, or tried again shorter.

    Gives the state, whether time has passed, and whether the mass has just come to rest.
    """
    drive, omega = crosshead_speed(state.time, at), jnp.sqrt(at.spring / at.mass)
    span, limit, whole = _bound(state, at)
    fixed = at.tolerance == 0
    wanted = jnp.where(fixed, jnp.minimum(state.next_step, at.step), state.next_step)
    h = jnp.minimum(jnp.minimum(wanted, (0.5 if exact else 0.2) / omega), span)
    to = _tried(state, h, at, exact)
    error = jnp.where(jnp.isfinite(to.trial.error), to.trial.error, jnp.inf)
    taken = (fixed | (error <= at.tolerance) | to.tiny) & ~to.late
    growth = jnp.clip(0.9 * (at.tolerance / jnp.maximum(error, 1e-300)) ** 0.2, 0.2, 5.0)
    other = jnp.where(state.mode == TAUT, SLACK, TAUT)
    time = jnp.where(whole & (h == span), limit, state.time + h)
    new = state._replace(
        time=time,
        slip=to.slip,
        velocity=jnp.where(to.stopped, 0.0, to.trial.velocity),
        work=state.work + to.trial.work,
        heat=state.heat + to.trial.heat,
        mode=jnp.where(to.stopped, STUCK, jnp.where(to.turned, other, state.mode)),
        next_step=jnp.where(fixed, at.step, growth * h),
        high=jnp.maximum(state.high, to.high),
        low=jnp.minimum(state.low, jnp.maximum(to.low, 0.0)),
        deviation=_deviation(to.extension, to.slip, to.trial.velocity, drive, at),
    )
    again = state._replace(next_step=jnp.where(to.late, jnp.maximum(to.sooner, 0.0), growth * h))
    # a mass that does not move off at all stays where it is for this step
    held = (state.velocity <= 0) & (to.trial.velocity <= 0)
    rest = state._replace(time=time, mode=jnp.asarray(STUCK))
    chosen = _where(held, rest, _where(taken, new, again))
    chosen = _where(to.wrong, state._replace(mode=other), chosen)
    return chosen, (taken | held) & ~to.wrong, taken & to.stopped & ~held & ~to.wrong


def _deviation(extension: Any, slip: Any, velocity: Any, drive: Any, at: Slide) -> Any:
    """How far from sliding along with the crosshead, as a speed [m/s]."""
    omega = jnp.sqrt(at.spring / at.mass)
    off = extension - (resistance(slip, drive, at)) / at.spring
    return jnp.sqrt((velocity - drive) ** 2 + (omega * off) ** 2)


def _where(choose: Any, a: State, b: State) -> State:
    """One of two states; the tables, which neither has touched, are not copied."""
    kept = ("table", "trace")
    values = {
        name: getattr(a, name) if name in kept else jnp.where(choose, x, getattr(b, name))
        for name, x in a._asdict().items()
    }
    return State(**values)


def _written(old: State, new: State, passed: Any, rests: Any, at: Slide) -> State:
    """The event and the sample of this action set down in their tables."""
    extension, drive = extension_at(new.time, new.slip, at), crosshead_speed(new.time, at)
    pull = spring_force(extension, drive - new.velocity, at)
    force = jnp.where(new.mode == SLACK, 0.0, pull)
    broke, begin, at_break = old.broke
    slipped, low = new.slip - begin, jnp.minimum(new.low, force)
    event = jnp.stack((broke, new.time, at_break, new.high, low, slipped))
    crosshead, sliding = extension + new.slip, jnp.where(new.mode == STUCK, 0.0, 1.0)
    row = (new.time, crosshead, force, new.slip, new.velocity, new.work, new.heat, sliding)
    # the last row of a table takes what is not to be kept: a slice is written in place
    last, end = old.table.shape[0] - 1, old.trace.shape[0] - 1
    place = jnp.where(rests, jnp.minimum(old.count, last), last)
    line = jnp.where(passed, old.written, end)
    return new._replace(
        count=old.count + rests,
        table=jax.lax.dynamic_update_slice(old.table, event[None], (place, 0)),
        trace=jax.lax.dynamic_update_slice(old.trace, jnp.stack(row)[None], (line, 0)),
        written=jnp.minimum(old.written + passed, end),
        actions=old.actions + 1,
    )


def _ended(state: State, at: Slide, most: int) -> Any:
    """Why the run is over, 0 while it is not."""
    force = spring_force(
        extension_at(state.time, state.slip, at), crosshead_speed(state.time, at), at
    )
    sheets = static_bound(state.slip, at) - passive(state.slip, at)
    closed = (state.mode == STUCK) & (passive(state.slip, at) - at.base - force > sheets)
    drive = crosshead_speed(state.time, at)
    slope = jax.jvp(lambda v: resistance(state.slip, v, at), (drive,), (jnp.ones_like(drive),))[1]
    calm = (state.mode == TAUT) & (state.deviation < CALM * drive) & (at.damping + slope > 0)
    full = (state.actions >= most) | (
        (state.written >= state.trace.shape[0] - 1) & (state.trace.shape[0] > 2)
    )
    reason = jnp.where(full, TOO_LONG, 0)
    reason = jnp.where(calm, STEADY, reason)
    reason = jnp.where(state.count >= at.events, ENOUGH_EVENTS, reason)
    reason = jnp.where(state.time >= at.end, AT_END, reason)
    reason = jnp.where(closed, CLOSED, reason)
    return jnp.where(state.slip >= at.overlap, SEPARATED, reason)


@partial(jax.jit, static_argnames=("exact", "events", "samples", "most"))
def _run(at: Slide, exact: bool, events: int, samples: int, most: int) -> State:
    zero, none = jnp.zeros(()), jnp.asarray(0)
    first = jnp.stack([zero, at.start, zero, at.start, zero, zero, zero, zero])
    still = State(**dict.fromkeys(State._fields, zero))
    state = still._replace(
        slip=at.start,
        mode=jnp.asarray(STUCK),
        count=none,
        broke=jnp.zeros(3),
        table=jnp.full((events + 1, 6), jnp.nan),
        trace=jnp.zeros((samples + 1, 8)).at[0].set(first),
        written=jnp.asarray(1),
        actions=none,
        deviation=zero + jnp.inf,
        reason=none,
    )

    def act(state: State) -> State:
        stuck = state.mode == STUCK
        moved, passed, rests = _move(state, at, exact)
        new = _where(stuck, _stay(state, at), moved)
        new = _written(state, new, stuck | passed, ~stuck & rests, at)
        return new._replace(reason=_ended(new, at, most))

    state = jax.lax.while_loop(lambda s: s.reason == 0, act, state)
    return state._replace(table=state.table[:events], trace=state.trace[:samples])


@partial(jax.jit, static_argnames=("exact", "events", "samples", "most"))
def _runs(at: Slide, exact: bool, events: int, samples: int, most: int) -> State:
    return jax.vmap(lambda one: _run(one, exact, events, samples, most))(at)


def constant(at: Slide) -> bool:
    """Whether friction depends on neither slip nor speed, so that the motion is exact."""
    plain = (at.fall, at.stribeck, at.viscous)
    return (
        at.enclosure is None
        and at.law is None
        and not any(np.any(np.asarray(v) != 0) for v in plain)
    )


@in_double_precision
def slide(
    at: Slide, *, events: int = 64, samples: int = 1, most: int = 200_000, exact: bool | None = None
) -> State:
    """Run from rest with a loose spring until the end, the last event, or steady sliding.

    Entries of `at` may be arrays of one shape: all cases then run at once. `events` and `samples`
    size the tables, `most` bounds the actions. `exact` is by default what `constant` says.
    """
    at = jax.tree.map(lambda v: np.asarray(v, np.float64), at)
    shape = np.broadcast_shapes(*(v.shape for v in jax.tree.leaves(at)))
    closed = constant(at) if exact is None else exact
    if not shape:
        return _run(at, closed, events, samples, most)
    flat = jax.tree.map(lambda v: np.broadcast_to(v, shape).ravel(), at)
    count, parts = math.prod(shape), []
    for first in range(0, count, BLOCK):
        # the last block is filled up with its last case
        chosen = np.minimum(np.arange(first, first + BLOCK), count - 1)
        block = jax.tree.map(lambda v, chosen=chosen: v[chosen], flat)
        parts.append(_runs(block, closed, events, samples, most))
    many = jax.tree.map(lambda *some: np.concatenate(some)[:count], *parts)
    return jax.tree.map(lambda v: v.reshape(shape + v.shape[1:]), many)
