"""Drop of a mass on the brake in time, with a changing vacuum, a damped rope and rebound."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.mount import Rope, Site
from layerjam.errors import Notice, QuantityError
from layerjam.mechanics.fan import fan_force
from layerjam.mechanics.hysteresis import make_setting
from layerjam.mechanics.law import in_double_precision
from layerjam.mechanics.stop.motion import (
    CLOSED,
    LONGEST,
    MOVING,
    SNAPPED,
    STANDSTILL,
    TRAVEL_USED,
    Vacuum,
    advance_step,
    go_to_event,
    make_load,
    rope_spring,
    stored_energy,
)
from layerjam.mechanics.stop.motion_step import Load, Motion, memory_force, new_motion, rest_setting
from layerjam.simulate.drop import TimedStop, make_record
from layerjam.simulate.quantities import ARRIVAL_SPEED, DURATION, MASS, VACUUM, check_inputs
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.simulate.speed import list_stop_notices, remove_idle_speed_law
from layerjam.simulate.vacuum_history import History
from layerjam.units import QuantitySpec, get_spec, show

__all__ = ["History", "TimedStop", "drop_in_time"]
SPEED = replace(ARRIVAL_SPEED, lo=0.0)
LIMITS = {
    "mass": MASS,
    "speed": SPEED,
    "gravity": replace(get_spec(Site, "gravity"), text="gravity along the pull"),
    "rope_damping": get_spec(Rope, "damping"),
    "rope_stiffness": replace(get_spec(Rope, "stiffness"), text="stiffness of the rope"),
    "duration": DURATION,
}

_COLUMNS = {
    "time": "time",
    "place": "travel",
    "speed": "speed_of_mass",
    "force": "force",
    "slip": "slip",
    "heat": "dissipated_energy",
}
"""{field of a motion: column of a DropRecord}."""
SAMPLES = 600
CLOSE = 1e-6
"""Relative change of slip and time, after halving the step, below which a run is accepted."""
MOST_HALVINGS, MOST_STEPS = 7, 4_000_000
STILL = 1e-20
"""Energy below which a motion counts as rest, relative to that of the spring under the weight."""
Array = np.ndarray[Any, np.dtype[np.float64]]


class _Case(NamedTuple):
    """Start of a drop, and its loads, vacuum and brake."""

    start: Motion
    vacuum: Vacuum
    load: Load
    brake: Brake


def _next_step(motion: Motion, until: Any, dt: Any, vacuum: Vacuum) -> Any:
    """Return the next step [s]: `dt`, or the time to the end or next sample if that is less."""
    step = jnp.minimum(dt, until - motion.time)
    if vacuum.time is None:
        return step
    # a time slightly before a sample counts as that of the sample
    index = jnp.searchsorted(vacuum.time, motion.time + 1e-9 * dt, side="right")
    distance = vacuum.time[jnp.minimum(index, len(vacuum.time) - 1)] - motion.time
    return jnp.where(distance > 0, jnp.minimum(step, distance), step)


@jax.jit
def _march_motion(motion: Motion, max_steps: Any, until: Any, dt: Any, case: _Case) -> Motion:
    """Return the state at the next event, or after some number of steps, or at a time [s]."""
    last = until - 1e-9 * dt

    def continues(state: tuple[Any, Motion]) -> Any:
        count, current = state
        return (current.outcome == MOVING) & (current.time < last) & (count < max_steps)

    def advance(state: tuple[Any, Motion]) -> tuple[Any, Motion]:
        current = state[1]
        return state[0] + 1, advance_step(
            current, _next_step(current, until, dt, case.vacuum), *case[1:]
        )

    return jax.lax.while_loop(continues, advance, (jnp.array(0), motion))[1]


@jax.jit
def _next_event(motion: Motion, until: Any, dt: Any, case: _Case) -> Motion:
    return go_to_event(motion, _next_step(motion, until, dt, case.vacuum), *case[1:])


def _find_event(case: _Case, dt: float, until: float) -> Motion:
    return _next_event(_march_motion(case.start, MOST_STEPS, until, dt, case), until, dt, case)


@in_double_precision
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
    """Stop a mass [kg] that arrives with `speed` [m/s], integrated in time; all in SI.

    `vacuum` is one number or a History. With `duration` [s] the run continues after the first
    standstill (rebound, slack rope) up to that time. The values remain those of the first
    standstill; if there is none by then, the outcome is FINISHED. The integration ends once the
    mass hangs at rest. By default, the `step` [s] is halved until slip and time change by less than
    1e-6. `progress` is called with the time reached [s]; KeyboardInterrupt from it ends the run.

    Raises QuantityError for values out of bounds, for damping without a rope, for a step longer
    than a quarter of sqrt(M/k), and if the mass does not come to rest in 4 million steps.
    """
    brake = remove_idle_speed_law(file.brake)
    pull = brake.site.gravity if gravity is None else gravity
    inputs: dict[str, float | None] = {"mass": mass, "speed": speed, "gravity": pull}
    inputs |= {"rope_damping": rope_damping, "rope_stiffness": rope_stiffness}
    _check_inputs({**inputs, "duration": duration}, step, brake)
    history = _changing_history(vacuum, brake.site.atmosphere)
    first = float(vacuum.interpolate(0.0) if isinstance(vacuum, History) else vacuum)
    load = make_load(mass, pull, rope_stiffness, rope_damping or None, brake)
    load = jax.tree.map(np.float64, load)
    start = _strip_weak_types(
        new_motion(
            np.float64(speed),
            np.float64(first),
            history is None,
            brake.active_speed_law is not None,
        )
    )
    pressure = Vacuum(jnp.asarray(first)) if history is None else _pad_history(history)
    case = _Case(start, pressure, load, brake)
    until = math.inf if duration is None else duration
    dt, event, warnings = _choose_step(case, step, until)
    at_event = first if history is None else float(history.interpolate(float(event.time)))
    if event.outcome == MOVING and duration is None:
        raise QuantityError(
            f"duration: the mass still moves at {show(float(event.time), 's')}; specify how long "
            "to simulate"
        )
    states = _follow_motion(case, dt, until, event, progress)
    result = _make_stop(event, states[-1], case)
    remarks = vacuum.list_notices() if isinstance(vacuum, History) else []
    columns = {
        column: np.array([float(getattr(state, name)) for state in states])
        for name, column in _COLUMNS.items()
    }
    time = columns["time"]
    pressures = vacuum.interpolate(time) if isinstance(vacuum, History) else time * 0 + vacuum
    columns |= {"time": np.minimum(time, until), "vacuum_in_time": pressures}
    inputs |= {"vacuum": first, "step": dt}
    spring = float(load.spring)
    after = [*warnings, *_speed_notices(file, states, None if step or warnings else CLOSE)]
    return make_record(file, result, spring, at_event, columns, inputs, before=remarks, after=after)


def _speed_notices(file: BrakeFile, states: list[Motion], error: float | None) -> list[Notice]:
    """Return notices about friction and speed; `error` is the relative error in slip and time."""
    if file.brake.active_speed_law is None:
        return list_stop_notices(file)
    return list_stop_notices(file, max(float(state.pace) for state in states), error)


def _choose_step(case: _Case, step: float | None, until: float) -> tuple[float, Motion, list[str]]:
    """Return the step [s], the first event with it, and a warning if the step is still too long."""
    if step is not None:
        return step, _find_event(case, step, until), []
    load = case.load
    # both a slow mass on a stiff spring and a fast one on a soft spring need a quarter period
    dt = float(jnp.sqrt(load.mass / load.spring)) / 200
    before = _find_event(case, dt, until)
    change = last = math.inf
    for halving in range(MOST_HALVINGS):
        dt /= 2
        event = _find_event(case, dt, until)
        if bool(event.outcome == MOVING) and math.isinf(until):
            return dt, event, []
        change = max(
            abs(float(getattr(event, name) - getattr(before, name)))
            / max(float(getattr(event, name)), 1e-9)
            for name in ("slip", "time")
        )
        # extrapolate the remaining error, which is at best of second order
        ratio = min(last / change, 4.0) if change else 4.0
        before, last = event, change
        if change <= CLOSE or (ratio > 2.5 and change <= CLOSE * (ratio - 1)):
            return dt, event, []
        if halving > 2 and ratio < 1.2:
            break
    words = f"steps of {show(dt, 's')} give slip and time with a relative error of {change:.1e}"
    return dt, before, [words]


def _follow_motion(
    case: _Case, dt: float, until: float, event: Motion, progress: Callable[[float], None] | None
) -> list[Motion]:
    """Return states along the run, through every standstill up to a finite `until` [s]."""
    span = float(event.time) if math.isinf(until) else until
    stride = max(1, math.ceil(span / dt / SAMPLES))
    states, state = [case.start], case.start
    while True:
        state = _march_motion(state, stride, until, dt, case)
        if math.isfinite(until) and _is_hanging(state, case):
            # at rest the state stays the same, bit for bit
            states += [state, state._replace(time=np.float64(until))]
            if progress is not None:
                progress(until)
            return states
        if float(state.time) > float(states[-1].time):
            states.append(state)
        if progress is not None:
            progress(min(float(state.time), until))
        if float(state.time) >= until - 1e-9 * dt:
            return states
        if int(state.outcome) == MOVING:
            continue
        state = _next_event(state, until, dt, case)
        if float(state.time) > float(states[-1].time):
            states.append(state)
        else:
            states[-1] = state
        if math.isinf(until) or int(state.outcome) != STANDSTILL:
            return states
        state = _strip_weak_types(state._replace(outcome=jnp.zeros_like(state.outcome)))


def _strip_weak_types(motion: Motion) -> Motion:
    """Return the same state without weak types, which would trigger a second compilation."""
    return jax.tree.map(np.asarray, motion)


def _make_stop(event: Motion, last: Motion, case: _Case) -> TimedStop:
    elastic_energy = stored_energy(event, case.load, case.brake)
    numbers: Any = (event.slip, event.peak, event.speed, event.heat, elastic_energy, event.time)
    ends: Any = (_outcome_name(event), float(last.slip), _outcome_name(last))
    return TimedStop(*(*map(float, numbers), *ends))


def _outcome_name(state: Motion) -> Outcome:
    code = int(state.outcome)
    if code == STANDSTILL:
        return Outcome.STOPPED if float(state.slip) > 0 else Outcome.NEVER_SLID
    names = {TRAVEL_USED: Outcome.BOTTOMED_OUT, CLOSED: Outcome.CLOSED_BY_SLEEVE}
    return (names | {SNAPPED: Outcome.SNAPS}).get(code, Outcome.FINISHED)


def _is_hanging(state: Motion, case: _Case) -> bool:
    """Return whether the mass hangs at rest on a brake that holds it at a constant vacuum."""
    load, vacuum = case.load, case.vacuum
    if bool(state.slack) or int(state.outcome) != MOVING or not float(load.gravity):
        return False
    if vacuum.time is not None:
        later = np.append(
            float(vacuum.value_at(state.time)), vacuum.pressure[vacuum.time > state.time]
        )
        if np.ptp(later) > 0:
            return False
    weight = float(load.mass * load.gravity)
    energy = load.mass * state.speed**2 + (state.force - weight) ** 2 / load.spring
    setting = make_setting(state.vacuum, load.spring, case.brake)
    strip = memory_force(state, setting.enclosure)
    hold = float(fan_force(state.slip, rest_setting(setting)) + strip)
    return float(energy) <= STILL * weight**2 / float(load.spring) and hold > weight * (1 + 1e-6)


def _check_inputs(inputs: Mapping[str, float | None], step: float | None, brake: Brake) -> None:
    check_inputs(inputs, LIMITS)
    if inputs["rope_damping"] and inputs["rope_stiffness"] is None:
        raise QuantityError("rope damping: there is no rope; specify its stiffness too")
    if not (inputs["speed"] or inputs["gravity"]):
        raise QuantityError.of("speed", "0 m/s without gravity along the pull is not a drop")
    if step is not None:
        spring = float(rope_spring(inputs["rope_stiffness"], brake))
        longest = LONGEST * math.sqrt((inputs["mass"] or 0.0) / spring)
        spec = QuantitySpec("s", "step (a quarter of sqrt(M/k))", open_lo=True, hi=longest)
        spec.check(step, "step")


def _changing_history(vacuum: float | History, atmosphere: float) -> History | None:
    """Return the history if it changes after the taut rope; QuantityError for too high a vacuum."""
    if not isinstance(vacuum, History):
        replace(VACUUM, hi=atmosphere).check(vacuum, "vacuum")
        return None
    vacuum.check_site(atmosphere)
    later = np.append(vacuum.interpolate(0.0), vacuum.vacuum[vacuum.time > 0])
    return vacuum if np.ptp(later) > 0 else None


def _pad_history(history: History) -> Vacuum:
    """Return samples of a history, padded to a power of two so that few lengths compile."""
    extra = (1 << max(4, math.ceil(math.log2(len(history.time))))) - len(history.time)
    late = history.time[-1] + np.arange(1, extra + 1) * max(1.0, abs(history.time[-1]))
    return Vacuum(
        np.append(history.vacuum, np.full(extra, history.vacuum[-1])), np.append(history.time, late)
    )
