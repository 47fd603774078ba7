"""A mass on a rope and the brake in time: any vacuum, rope damping, rebound, slack rope (ours).

The brake's force depends on its path alone, so one step asks: by how much is the brake drawn out
that its mean force over the step, work over distance, is the one that slows the mass? Work and heat
are exact along the path, so that energy is kept to rounding at any step; time is of second order.

Without rope damping rope and brake are one spring, as in the exact stop. With it the rope is a
spring and a damper side by side (it only pulls) in series with the brake.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.enclosure import backbone_stored, enclosure_at
from layerjam.mechanics.fan import force_of, tangent
from layerjam.mechanics.hysteresis import Setting, setting_of
from layerjam.mechanics.law import law, within
from layerjam.mechanics.memory import NEAR, sliding_share
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.mechanics.stop.algebra import NOT_A_CASE
from layerjam.mechanics.stop.motion_step import (
    Load,
    Motion,
    ahead,
    at_start,
    force_of_enclosure,
    pump,
    resting,
)

MOVING, STANDSTILL, TRAVEL_USED, CLOSED, SNAPPED = 0, 1, 2, 3, 4
"""How far it got: still moving, first standstill, end of travel, enclosure closes the brake, snaps.

NOT_A_CASE (-1) where a quantity lies outside the domain and all numbers are NaN."""
LONGEST = 0.25
"""Longest step over sqrt(M/k): longer ones pass over a standstill."""


def _event(old: Motion, new: Motion, at: Setting, travel: Any) -> Any:
    """What happened in a step that the run must not go past."""
    hold = force_of(new.slip, resting(at))
    enclosure = force_of_enclosure(new, at.enclosure)
    closes = enclosure * (1 - 1e-9) - new.force > hold
    code = jnp.where((old.speed > 0) & (new.speed <= 0), STANDSTILL, MOVING)
    code = jnp.where(new.slip >= travel, TRAVEL_USED, code)
    code = jnp.where((new.slip > 0) & closes, CLOSED, code)
    return jnp.where(_snaps(old, new, at), SNAPPED, code)


def _snaps(old: Motion, new: Motion, at: Setting) -> Any:
    """Whether in sliding from `old` to `new` the force fell faster than the spring gives.

    1 + Y'/k > 0 must hold where it got to, and the brake must hold the spring there. Friction that
    grows with speed holds any spring.
    """
    if at.law is not None:
        return jnp.zeros_like(new.slack)
    strip = at.enclosure
    slides = new.slip if new.enclosure is None else sliding_share(new.enclosure)
    part = jnp.where(slides > 0, slides, 1.0)
    if new.enclosure is None:
        steep = jnp.maximum(strip.root / (2 * jnp.sqrt(part)), strip.stiffness / strip.reach)
    else:
        steep = strip.stiffness / (strip.reach * part)
    steep = jnp.where(slides > 0, steep, jnp.inf)
    soft = tangent(new.slip, at).c - at.k
    hold = force_of(new.slip, at) + force_of_enclosure(new, strip)
    torn = (new.force > hold * (1 + 1e-6)) & (soft > 0)
    falls = soft >= steep * (1 - 1e-9)
    return ((new.slip > old.slip) & (falls | torn)) | (jnp.isnan(new.force) & (soft > 0))


class Vacuum(NamedTuple):
    """A vacuum [Pa], or its samples over time [s], shape (H,), joined by straight lines."""

    pressure: Any
    time: Any = None

    def at(self, time: Any) -> Any:
        """Before the first and after the last sample it stays as it is."""
        return jnp.interp(time, self.time, self.pressure)


def _ready(
    motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake
) -> tuple[Motion, Setting, Any]:
    """What a step of `dt` [s] starts from, what resists in it, and friction at its start [N/m].

    A vacuum that falls does so between steps, by what puts its mean right. One that rises does so
    while the brake slides: at rest the force could not follow. Where it has fallen up to now, half
    of the last step's fall is still to come: it comes first, or what slips then would be lost.
    """
    if motion.enclosure is None:
        return motion, setting_of(vacuum.pressure, load.spring, brake), None
    begin, end = vacuum.at(motion.time), vacuum.at(motion.time + dt)
    falls = end < begin
    behind = begin < motion.vacuum * (1 - NEAR)
    started = jnp.where(behind, begin, motion.vacuum)
    if brake.speed_law is not None:  # the force follows by itself, as fast as the sheets can slide
        falls = jnp.zeros_like(falls)
    level = jnp.where(falls, (begin + end) / 2, end)

    def on(stage: Any, now: Motion) -> Motion:
        target = jnp.where((stage == 0) & ~falls, started, level)
        return _pumped(target != now.vacuum, now, target, load, brake)

    pumped = jax.lax.fori_loop(0, 2, on, motion)
    at = setting_of(level, load.spring, brake)
    return pumped, at, jnp.where(falls, at.c, setting_of(started, load.spring, brake).c)


def _pumped(where: Any, motion: Motion, vacuum: Any, load: Load, brake: Brake) -> Motion:
    """Another vacuum [Pa] where it changes.

    A branch of its own, else the compiler works it out anew for every number that follows from it:
    three times the code, and a start three times as long.
    """

    def change(motion: Motion) -> Motion:
        new = pump(motion, vacuum, setting_of(vacuum, load.spring, brake))
        return _chosen(where, new, motion)

    return jax.lax.cond(jnp.any(where), change, lambda still: still, motion)  # type: ignore[no-any-return]


def step_on(motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake) -> Motion:
    """One step of `dt` [s]; a state whose next step holds an event stays, with its outcome."""
    ready, at, c = _ready(motion, dt, vacuum, load, brake)
    new = ahead(ready, dt, at, c, load)
    code = _event(motion, new, at, brake.sheets.usable_travel)
    going = (motion.outcome == MOVING) & (code == MOVING)
    still = motion._replace(outcome=jnp.where(motion.outcome == MOVING, code, motion.outcome))
    return jax.tree.map(lambda a, b: jnp.where(going, a, b), new, still)


def ended(motion: Motion, dt: Any, vacuum: Vacuum, load: Load, brake: Brake) -> Motion:
    """Go to the standstill, end of travel or snap that the next step holds, by 60 halvings."""
    travel = brake.sheets.usable_travel

    def reached(time: Any) -> tuple[Motion, Any]:
        ready, at, c = _ready(motion, time, vacuum, load, brake)
        new = ahead(ready, time, at, c, load)
        snaps = _snaps(motion, new, at)
        if new.enclosure is None:
            return new, snaps
        # what is left of a fall of the vacuum when it stands
        now = vacuum.at(new.time)
        return _pumped(now < new.vacuum, new, now, load, brake), snaps

    def halve(_: int, state: _Halved) -> _Halved:
        middle = (state.low + state.high) / 2
        there, snaps = reached(middle)
        over = (there.speed <= 0) | (there.slip >= travel) | snaps
        return _Halved(
            jnp.where(over, state.low, middle),
            jnp.where(over, middle, state.high),
            _chosen(over, state.before, there),
            _chosen(over, there, state.after),
            jnp.where(over, snaps, state.snaps),
        )

    # the first of them is the whole step, known to hold the event
    least, no = jnp.zeros_like(motion.time), jnp.zeros_like(motion.slack)
    end = jax.lax.fori_loop(0, 60, halve, _Halved(least, least + 2 * dt, motion, motion, no))
    last = _chosen(end.snaps, end.before, end.after)
    used = ~end.snaps & (last.slip >= travel)
    code = jnp.where(end.snaps, SNAPPED, jnp.where(used, TRAVEL_USED, STANDSTILL))
    last = last._replace(
        speed=jnp.where(used | end.snaps, last.speed, 0.0),
        slip=jnp.where(used, travel, last.slip),
        outcome=code.astype(motion.outcome.dtype),
    )
    on = (motion.outcome == STANDSTILL) | (motion.outcome == TRAVEL_USED)
    return _chosen(on | (motion.outcome == SNAPPED), last, motion)


class _Halved(NamedTuple):
    """The two times [s] between which something happens, and the states there."""

    low: Any
    high: Any
    before: Motion
    after: Motion
    snaps: Any


def _chosen(condition: Any, yes: Motion, no: Motion) -> Motion:
    """One state or the other, drop by drop."""
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), yes, no)


def stored_energy(motion: Motion, load: Load, brake: Brake) -> Any:
    """Elastic energy [J] in rope, sheets, mount and enclosure."""
    if motion.enclosure is None:
        enclosure = backbone_stored(motion.slip, enclosure_at(motion.vacuum, brake))
    else:
        enclosure = motion.enclosure.stored
    rope = jnp.zeros_like(motion.stretch)
    if load.rope is not None:
        rope = jnp.where(jnp.isfinite(load.rope), load.rope * motion.stretch**2 / 2, 0.0)
    return motion.force**2 / (2 * load.spring) + rope + enclosure


def load_of(mass: Any, gravity: Any, rope: Any, damping: Any, brake: Brake) -> Load:
    """The load of a mass [kg] on a rope [N/m] (None: on the brake alone) with damping [N s/m]."""
    if damping is not None:
        return Load(mass, gravity, working_stiffness(brake), rope, damping)
    return Load(mass, gravity, series_of(rope, brake), None, None)


def series_of(rope: Any, brake: Brake) -> Any:
    """Rope [N/m] (None: no rope) and brake in series [N/m]."""
    own = working_stiffness(brake)
    return own if rope is None else 1 / (1 / own + 1 / rope)


@law
def stop_in_time(
    mass: Any,
    speed: Any,
    vacuum: Any,
    times: Any,
    rope: Any,
    damping: Any,
    gravity: Any,
    step: Any,
    steps: Any,
    brake: Brake,
) -> Motion:
    """March a mass [kg] arriving with `speed` [m/s] to its first standstill or the end of travel.

    `vacuum` [Pa] broadcasts with the rest where `times` is None; with `times` [s], shape (H,), it
    holds samples of a history. `rope` [N/m] and `damping` [N s/m] may be None. `step` [s] may
    differ from drop to drop, `steps` is the most that are taken (the greatest where several are
    given); the outcome is MOVING where they were not enough. Energy is kept to rounding, time and
    slip are of second order in the step (slip exact at constant vacuum without damping). NaN and
    NOT_A_CASE outside the domain, to which a step longer than a quarter of sqrt(M/k) belongs, k of
    rope and brake in series: it may pass over events.
    """
    steady = times is None
    history = Vacuum(vacuum, times)
    first = vacuum if steady else history.at(0.0)
    load = load_of(mass, gravity, rope, damping, brake)
    parts = jax.tree.leaves((load, setting_of(first, load.spring, brake), speed, step))
    speed = jnp.broadcast_to(speed, jnp.broadcast_shapes(*(jnp.shape(a) for a in parts)))
    start = at_start(speed, first, steady, brake.speed_law is not None)
    setting = setting_of(first, load.spring, brake)
    fine = (mass > 0) & (speed >= 0) & (gravity >= 0) & (step > 0) & (jnp.min(vacuum) >= 0)
    fine = fine & (force_of(0.0, setting) + setting.enclosure.root >= 0)
    fine = fine & (step <= LONGEST * jnp.sqrt(mass / series_of(rope, brake)))

    def going(state: tuple[Any, Motion]) -> Any:
        return (state[0] < jnp.max(steps)) & jnp.any(fine & (state[1].outcome == MOVING))

    def on(state: tuple[Any, Motion]) -> tuple[Any, Motion]:
        return state[0] + 1, step_on(state[1], step, history, load, brake)

    last = jax.lax.while_loop(going, on, (jnp.array(0), start))[1]
    last = ended(last, step, history, load, brake)
    last = last._replace(outcome=jnp.where(fine, last.outcome, NOT_A_CASE))
    return jax.tree.map(lambda a: within(fine, a) if a.dtype == jnp.float64 else a, last)
