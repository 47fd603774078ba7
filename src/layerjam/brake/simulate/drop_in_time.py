"""Drop of a mass on the brake in time, with a changing vacuum, a damped rope and rebound."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.mount import Rope, Site
from layerjam.brake.mechanics.arrays import map_leaves, repeat_while, xp
from layerjam.brake.mechanics.hysteresis import make_setting
from layerjam.brake.mechanics.law import compiled
from layerjam.brake.mechanics.slip_effects import friction_force
from layerjam.brake.mechanics.speed_effects import (
    depends_on_speed,
    has_speed_effects,
    remove_idle_speed_law,
)
from layerjam.brake.mechanics.stop.motion import (
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
from layerjam.brake.mechanics.stop.motion_step import (
    Load,
    Motion,
    memory_force,
    new_motion,
    rest_setting,
)
from layerjam.brake.simulate.drop import TimedStop, make_record
from layerjam.brake.simulate.quantities import ARRIVAL_SPEED, DURATION, MASS, VACUUM, check_inputs
from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.brake.simulate.speed import list_stop_notices
from layerjam.brake.simulate.vacuum_history import History
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec, get_spec, show

__all__ = ["History", "TimedStop", "drop_in_time"]
SPEED = evolve(ARRIVAL_SPEED, lo=0.0)
LIMITS = {
    "mass": MASS,
    "speed": SPEED,
    "gravity": evolve(get_spec(Site, "gravity"), text="gravity along the pull"),
    "rope_damping": get_spec(Rope, "damping"),
    "rope_stiffness": evolve(get_spec(Rope, "stiffness"), text="stiffness of the rope"),
    "duration": DURATION,
}

_COLUMNS = {
    "time": "time",
    "place": "displacement",
    "speed": "speed_of_mass",
    "force": "force",
    "slip": "slip",
    "heat": "dissipated_energy",
}
"""{field of a motion: column of a DropRecord}."""
SAMPLES = 600
CLOSE = 1e-6
"""Relative change of slip and time, after halving the step, below which a run is accepted."""
CHANGE = 0.01
"""Change of the vacuum between two samples, relative to the largest, that takes several steps."""
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


def _next_step(motion: Motion, end_time: Any, dt: Any, case: _Case) -> Any:
    """Return the next step [s]: `dt`, or the time to the end or next sample if that is less.

    A change of the vacuum by more than a hundredth between two samples is divided further if `dt`
    is halved, even if it is shorter than `dt`. Halving then shows its error.
    """
    step, vacuum = xp.minimum(dt, end_time - motion.time), case.vacuum
    if vacuum.time is None:
        return step
    # a time slightly before a sample counts as that of the sample
    index = xp.searchsorted(vacuum.time, motion.time + 1e-9 * step, side="right")
    after, before = xp.clip(index, 1, len(vacuum.time) - 1), xp.clip(index - 1, 0, None)
    distance = vacuum.time[after] - motion.time
    change = xp.abs(vacuum.pressure[after] - vacuum.pressure[before])
    share = xp.where(change > CHANGE * xp.max(vacuum.pressure), dt / _first_step(case.load), 1.0)
    part = share * (vacuum.time[after] - vacuum.time[before])
    end = xp.where(part < 0.75 * distance, part, distance)
    return xp.where(distance > 0, xp.minimum(step, end), step)


def _first_step(load: Load) -> Any:
    """Return the step [s] that is halved; both slow and fast masses need a quarter period."""
    return xp.sqrt(load.mass / load.spring) / 200


@compiled
def _march_motion(motion: Motion, max_steps: Any, end_time: Any, dt: Any, case: _Case) -> Motion:
    """Return the state at the next event, or after some number of steps, or at a time [s]."""
    last = end_time - 1e-9 * dt

    def continues(state: tuple[Any, Motion]) -> Any:
        count, current = state
        return (current.outcome == MOVING) & (current.time < last) & (count < max_steps)

    def advance(state: tuple[Any, Motion]) -> tuple[Any, Motion]:
        current = state[1]
        return state[0] + 1, advance_step(
            current, _next_step(current, end_time, dt, case), *case[1:]
        )

    return repeat_while(continues, advance, (xp.asarray(0), motion))[1]


@compiled
def _next_event(motion: Motion, end_time: Any, dt: Any, case: _Case) -> Motion:
    return go_to_event(motion, _next_step(motion, end_time, dt, case), *case[1:])


def _find_event(case: _Case, dt: float, end_time: float) -> Motion:
    return _next_event(
        _march_motion(case.start, MOST_STEPS, end_time, dt, case), end_time, dt, case
    )


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
    first = _first_vacuum(vacuum)
    case = _make_case(brake, mass, speed, pull, vacuum, rope_stiffness, rope_damping)
    until = math.inf if duration is None else duration
    dt, event, warnings = _choose_step(case, step, until)
    changes = case.vacuum.time is not None
    at_event = float(case.vacuum.value_at(float(event.time))) if changes else first
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
    spring = float(case.load.spring)
    notices = [*warnings, *_speed_notices(file, states, None if step or warnings else CLOSE)]
    return make_record(
        file, result, spring, at_event, columns, inputs, before=remarks, after=notices
    )


def _first_vacuum(vacuum: float | History) -> float:
    return float(vacuum.interpolate(0.0) if isinstance(vacuum, History) else vacuum)


def _make_case(
    brake: Brake,
    mass: float,
    speed: float,
    gravity: float,
    vacuum: float | History,
    rope_stiffness: float | None,
    rope_damping: float,
) -> _Case:
    history = _changing_history(vacuum, brake.site.atmosphere)
    first = _first_vacuum(vacuum)
    load = make_load(mass, gravity, rope_stiffness, rope_damping or None, brake)
    start = new_motion(
        np.float64(speed), np.float64(first), history is None, has_speed_effects(brake)
    )
    pressure = Vacuum(xp.asarray(first)) if history is None else _pad_history(history)
    return _Case(start, pressure, map_leaves(np.float64, load), brake)


def repeat_stop(
    brake: Brake, record: DropRecord, vacuum: float | History, step: float, end_time: float
) -> TimedStop:
    """Return the first standstill, by `end_time` [s], of the stop of a record with other numbers.

    `brake` and `vacuum` [Pa] replace those of the record; `step` [s] is that of the integration.
    """
    brake = remove_idle_speed_law(brake)
    ways: Any = (record.gravity, vacuum, record.rope_stiffness, record.rope_damping)
    case = _make_case(brake, record.mass, record.speed, *ways)
    event = _find_event(case, step, end_time)
    return _make_stop(event, event, case)


def _speed_notices(file: BrakeFile, states: list[Motion], error: float | None) -> list[Notice]:
    """Return notices about friction and speed; `error` is the relative error in slip and time."""
    if not depends_on_speed(file.brake):
        return list_stop_notices(file)
    return list_stop_notices(file, max(float(state.pace) for state in states), error)


def _choose_step(
    case: _Case, step: float | None, end_time: float
) -> tuple[float, Motion, list[str]]:
    """Return the step [s], the first event with it, and a warning if the step is still too long."""
    if step is not None:
        return step, _find_event(case, step, end_time), []
    dt = float(_first_step(case.load))
    event_time = _find_event(case, dt, end_time)
    change = last = math.inf
    for halving in range(MOST_HALVINGS):
        dt /= 2
        event = _find_event(case, dt, end_time)
        if bool(event.outcome == MOVING) and math.isinf(end_time):
            return dt, event, []
        change = max(
            abs(float(getattr(event, name) - getattr(event_time, name)))
            / max(float(getattr(event, name)), 1e-9)
            for name in ("slip", "time")
        )
        # extrapolate the remaining error, which is at best of second order
        ratio = min(last / change, 4.0) if change else 4.0
        event_time, last = event, change
        if change <= CLOSE or (ratio > 2.5 and change <= CLOSE * (ratio - 1)):
            return dt, event, []
        if halving > 2 and ratio < 1.2:
            break
    words = f"steps of {show(dt, 's')} give slip and time with a relative error of {change:.1e}"
    return dt, event_time, [words]


def _follow_motion(
    case: _Case, dt: float, end_time: float, event: Motion, progress: Callable[[float], None] | None
) -> list[Motion]:
    """Return states along the run, through every standstill up to a finite `end_time` [s]."""
    span = float(event.time) if math.isinf(end_time) else end_time
    stride = max(1, math.ceil(span / dt / SAMPLES))
    states, state = [case.start], case.start
    while True:
        state = _march_motion(state, stride, end_time, dt, case)
        if math.isfinite(end_time) and _is_hanging(state, case):
            # at rest the state stays the same, bit for bit
            states += [state, state._replace(time=np.float64(end_time))]
            if progress is not None:
                progress(end_time)
            return states
        if float(state.time) > float(states[-1].time):
            states.append(state)
        if progress is not None:
            progress(min(float(state.time), end_time))
        if float(state.time) >= end_time - 1e-9 * dt:
            return states
        if int(state.outcome) == MOVING:
            continue
        state = _next_event(state, end_time, dt, case)
        if float(state.time) > float(states[-1].time):
            states.append(state)
        else:
            states[-1] = state
        if math.isinf(end_time) or int(state.outcome) != STANDSTILL:
            return states
        state = state._replace(outcome=xp.zeros_like(state.outcome))


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
    hold = float(friction_force(state.slip, rest_setting(setting)) + strip)
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
        evolve(VACUUM, hi=atmosphere).check(vacuum, "vacuum")
        return None
    vacuum.check_site(atmosphere)
    later = np.append(vacuum.interpolate(0.0), vacuum.vacuum[vacuum.time > 0])
    return vacuum if np.ptp(later) > 0 else None


def _pad_history(history: History) -> Vacuum:
    """Return samples of a history, padded to a power of two so that few lengths compile."""
    padding = (1 << max(4, math.ceil(math.log2(len(history.time))))) - len(history.time)
    later_times = history.time[-1] + np.arange(1, padding + 1) * max(1.0, abs(history.time[-1]))
    return Vacuum(
        np.append(history.vacuum, np.full(padding, history.vacuum[-1])),
        np.append(history.time, later_times),
    )
