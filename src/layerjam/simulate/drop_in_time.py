"""A mass falls on the brake, in time: a vacuum that changes, a rope that damps, the rebound."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.mechanics.motion import (
    CLOSED,
    MOVING,
    SNAPPED,
    STANDSTILL,
    TRAVEL_USED,
    Load,
    Motion,
    Vacuum,
    at_start,
    ended,
    load_of,
    step_on,
    stored_energy,
)
from layerjam.mechanics.pull import least_stiffness
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.units import show

SAMPLES = 600
CLOSE = 1e-6
"""Relative change of slip and time when the step is halved, below which a run is taken."""
MOST_HALVINGS, MOST_STEPS = 7, 4_000_000
Array = np.ndarray[Any, np.dtype[np.float64]]


class History(NamedTuple):
    """A vacuum that changes: samples [Pa] over time from the taut rope [s], straight in between."""

    time: Array
    vacuum: Array


class TimedStop(NamedTuple):
    """A stop marched in time: the numbers at the first standstill or the end of travel, in SI."""

    slip: float
    peak_force: float
    end_speed: float
    heat: float
    stored: float
    time: float
    outcome: Outcome
    slip_at_end: float
    """Slip at the end of the record, after a rebound [m]."""
    outcome_at_end: Outcome


class _Case(NamedTuple):
    start: Motion
    vacuum: Vacuum
    load: Load
    brake: Brake
    damped: bool


@functools.partial(jax.jit, static_argnames=("damped",))
def _march(
    motion: Motion, most: Any, until: Any, dt: Any, vacuum: Vacuum, load: Load, brake: Brake,
    damped: bool,
) -> Motion:  # fmt: skip
    """Steps up to an event, a number of steps or a time [s]."""

    def going(state: tuple[Any, Motion]) -> Any:
        count, now = state
        return (now.outcome == MOVING) & (now.time < until) & (count < most)

    def on(state: tuple[Any, Motion]) -> tuple[Any, Motion]:
        return state[0] + 1, step_on(state[1], dt, vacuum, load, brake, damped)

    return jax.lax.while_loop(going, on, (jnp.array(0), motion))[1]


_ended = jax.jit(ended, static_argnames=("damped",))


def _to_event(case: _Case, dt: float, until: float) -> Motion:
    start, *rest = case
    return _ended(_march(start, MOST_STEPS, until, dt, *rest), dt, *rest)


def drop_in_time(
    file: BrakeFile,
    *,
    mass: float,
    speed: float,
    vacuum: float | History,
    rope_stiffness: float | None = None,
    rope_damping: float = 0.0,
    gravity: float | None = None,
    duration: float | None = None,
    step: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[TimedStop, DropRecord]:
    """Stop a mass [kg] that arrives with `speed` [m/s], marched in time; all in SI.

    `vacuum` is one number or a History. With `duration` [s] it goes on after the first standstill
    (rebound, slack rope) up to that time; the numbers remain those of the first. Without `step`
    [s] the step is halved until slip and time change by less than 1e-6. `progress` is called with
    the time reached [s]; KeyboardInterrupt from it ends the run. Raises QuantityError for damping
    without a rope, and where the mass does not come to rest in 4 million steps.
    """
    if rope_damping and rope_stiffness is None:
        raise QuantityError("rope damping: there is no rope; give its stiffness too")
    brake = file.brake
    pull = brake.site.gravity if gravity is None else gravity
    history = vacuum if isinstance(vacuum, History) else None
    first = float(history.vacuum[0]) if history is not None else float(vacuum)  # type: ignore[arg-type]
    load = load_of(mass, pull, rope_stiffness, rope_damping or None, brake)
    load = Load(*(np.float64(v) for v in load))
    start = _strong(at_start(np.float64(speed), np.float64(first), history is None))
    given = Vacuum(jnp.asarray(first))
    if history is not None:
        given = Vacuum(jnp.asarray(history.vacuum), jnp.asarray(history.time))
    case = _Case(start, given, load, brake, bool(rope_damping))
    until = math.inf if duration is None else duration
    dt, event, warnings = _chosen(case, step, until)
    numbers = _numbers(event, case)
    if event.outcome == MOVING and duration is None:
        raise QuantityError(
            f"duration: the mass still moves at {show(float(event.time), 's')}; give the time to "
            "stop at"
        )
    states = _followed(case, dt, until if duration is not None else math.inf, event, progress)
    last = states[-1]
    timed = TimedStop(*numbers, slip_at_end=float(last.slip), outcome_at_end=_name(last))
    warnings = [*file.warnings(), *_words(timed, brake, first, load), *warnings]
    record = DropRecord(
        time=_column(states, "time"),
        travel=_column(states, "place"),
        speed_of_mass=_column(states, "speed"),
        force=_column(states, "force"),
        slip=_column(states, "slip"),
        vacuum_in_time=_vacuum(_column(states, "time"), vacuum),
        dissipated_energy=_column(states, "heat"),
        mass=mass,
        speed=speed,
        vacuum=first,
        rope_stiffness=rope_stiffness,
        rope_damping=rope_damping,
        gravity=pull,
        step=dt,
        outcome=timed.outcome,
        brake=file,
        warnings=tuple(warnings),
    )
    return timed, record


def _chosen(case: _Case, step: float | None, until: float) -> tuple[float, Motion, list[str]]:
    """The step [s], the first event it leads to, and a warning where it is still too long."""
    if step is not None:
        return step, _to_event(case, step, until), []
    load = case.load
    # a slow mass on a stiff spring and a fast one on a soft spring: both need a quarter period
    dt = float(jnp.sqrt(load.mass / load.spring)) / 200
    before = _to_event(case, dt, until)
    change = math.inf
    for _ in range(MOST_HALVINGS):
        dt /= 2
        event = _to_event(case, dt, until)
        if bool(event.outcome == MOVING):
            return dt, event, []
        change = max(
            abs(float(getattr(event, name) - getattr(before, name)))
            / max(float(getattr(event, name)), 1e-9)
            for name in ("slip", "time")
        )
        before = event
        if change <= CLOSE:
            return dt, event, []
    words = f"steps of {show(dt, 's')} give slip and time to {change:.1e} of their value"
    return dt, before, [words]


def _followed(
    case: _Case, dt: float, until: float, event: Motion, progress: Callable[[float], None] | None
) -> list[Motion]:
    """States along the run, through every standstill up to `until` [s] if that is finite."""
    start, *rest = case
    span = float(event.time) if math.isinf(until) else until
    stride = max(1, math.ceil(span / dt / SAMPLES))
    states, now = [start], start
    while True:
        now = _march(now, stride, until, dt, *rest)
        if float(now.time) > float(states[-1].time):
            states.append(now)
        if progress is not None:
            progress(min(float(now.time), until))
        if float(now.time) >= until:
            return states
        if int(now.outcome) == MOVING:
            continue
        now = _ended(now, dt, *rest)
        if float(now.time) > float(states[-1].time):
            states.append(now)
        else:
            states[-1] = now
        if math.isinf(until) or int(now.outcome) != STANDSTILL:
            return states
        now = _strong(now._replace(outcome=jnp.zeros_like(now.outcome)))


def _strong(motion: Motion) -> Motion:
    """The same state without weak types, which would have everything compiled once more."""
    return jax.tree.map(np.asarray, motion)


def _numbers(
    event: Motion, case: _Case
) -> tuple[float, float, float, float, float, float, Outcome]:
    stored = float(stored_energy(event, case.load, case.brake))
    return (
        float(event.slip), float(event.peak), float(event.speed), float(event.heat), stored,
        float(event.time), _name(event),
    )  # fmt: skip


def _name(state: Motion) -> Outcome:
    code = int(state.outcome)
    if code == STANDSTILL:
        return Outcome.STOPPED if float(state.slip) > 0 else Outcome.NEVER_SLID
    names = {TRAVEL_USED: Outcome.BOTTOMED_OUT, CLOSED: Outcome.CLOSED_BY_SLEEVE}
    return (names | {SNAPPED: Outcome.SNAPS}).get(code, Outcome.FINISHED)


def _words(timed: TimedStop, brake: Brake, vacuum: float, load: Load) -> list[str]:
    """What a reader of the numbers should know."""
    words = []
    if timed.outcome is Outcome.SNAPS:
        least = show(float(least_stiffness(vacuum, brake)), "N/m")
        words.append(
            f"rope and brake together give {show(float(load.spring), 'N/m')}; the sliding brake "
            f"softens faster and snaps. Needed is more than {least}"
        )
    if timed.outcome is Outcome.BOTTOMED_OUT:
        words.append(
            f"the brake ran out of its {show(brake.sheets.usable_travel, 'm')} with the mass at "
            f"{show(timed.end_speed, 'm/s')}"
        )
    if Outcome.CLOSED_BY_SLEEVE in (timed.outcome, timed.outcome_at_end):
        words.append(
            "the run ends where friction no longer holds the sleeve, which then pulls the brake "
            "shut by itself"
        )
    if timed.slip_at_end > timed.slip * (1 + 1e-9):
        words.append(
            f"after the first standstill at {show(timed.slip, 'm')} the brake slid on to "
            f"{show(timed.slip_at_end, 'm')}"
        )
    return words


def _column(states: list[Motion], name: str) -> Array:
    return np.array([float(getattr(state, name)) for state in states])


def _vacuum(time: Array, vacuum: float | History) -> Array:
    if isinstance(vacuum, History):
        return np.interp(time, vacuum.time, vacuum.vacuum)
    return np.full_like(time, vacuum)
