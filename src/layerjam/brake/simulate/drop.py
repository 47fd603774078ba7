"""Drop of a mass on the brake (paper, section III-E), exact at constant vacuum.

The rope becomes taut at time zero. Without a brake, the mass hangs on the rope alone.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.effects import has_single_modulus
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.energy import slip_heat
from layerjam.brake.mechanics.pull import brake_force, least_stiffness, peak
from layerjam.brake.mechanics.speed_effects import depends_on_speed
from layerjam.brake.mechanics.stop.exact import (
    BOTTOMED_OUT,
    NEVER_SLID,
    SNAPS,
    STOPPED,
    Stop,
    speed_at_slip,
    stop,
    stop_course,
    time_at_slip,
)
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.brake.mechanics.stop.paced import ROWS
from layerjam.brake.mechanics.stop.paced_tune import is_held
from layerjam.brake.simulate.first_pull import first_peak, overstretch_error
from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.brake.simulate.speed import list_stop_notices
from layerjam.core.errors import FitError, Notice, make_notices
from layerjam.core.units import show

OUTCOMES = {
    STOPPED: Outcome.STOPPED,
    NEVER_SLID: Outcome.NEVER_SLID,
    BOTTOMED_OUT: Outcome.BOTTOMED_OUT,
    SNAPS: Outcome.SNAPS,
}
SAMPLES = 400
Array = np.ndarray[Any, np.dtype[np.float64]]


class TimedStop(NamedTuple):
    """Result of a stop in SI units: values at the first standstill or at the end of travel."""

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
    reason: str | None = None
    """Reason for the snap, or None."""
    least_stiffness: float | None = None
    """Stiffness above which the brake cannot snap, at the vacuum of the snap [N/m]."""


def series_spring(brake: Brake, rope_stiffness: float | None) -> float:
    """Return the stiffness of rope and brake in series [N/m]."""
    return float(rope_spring(rope_stiffness, brake))


def drop(
    file: BrakeFile,
    *,
    mass: float,
    speed: float,
    vacuum: float,
    rope_stiffness: float | None = None,
    gravity: float | None = None,
) -> tuple[TimedStop, DropRecord]:
    """Stop a mass [kg] that arrives with `speed` [m/s] at a constant vacuum [Pa].

    `gravity` [m/s^2] acts along the pull: by default that of the site, 0 for a horizontal stop. The
    first result contains the exact values; the second is the record. The outcome is STOPPED,
    NEVER_SLID, BOTTOMED_OUT (the travel was used up with the mass still moving) or SNAPS. With a
    speed law the stop is integrated and cannot snap; a notice states the accuracy.
    """
    brake = file.brake
    pull = brake.site.gravity if gravity is None else gravity
    spring = series_spring(brake, rope_stiffness)
    case = (mass, speed, vacuum, spring, pull, brake)
    result = Stop(*(float(v) for v in stop(*case)))
    if int(result.outcome) not in OUTCOMES:
        if not has_single_modulus(brake):
            raise overstretch_error(vacuum, brake)
        raise FitError("speed_law: the stop takes more steps than can be computed")
    outcome = OUTCOMES[int(result.outcome)]
    columns, notes = _compute_columns(result.slip, *case), []
    if depends_on_speed(brake) and result.slip > 0:
        columns, fastest, error = _append_slide(columns, *case)
        notes = list_stop_notices(file, fastest, error)
        if outcome is Outcome.STOPPED and not is_held(result.slip, vacuum, mass * pull, brake):
            notes.append(
                Notice(
                    "the mass stops only for a moment: the sheets cannot hold its weight "
                    f"of {show(mass * pull, 'N')} there, and it slides on",
                    "slides-on",
                )
            )
    time = float(columns["time"][-1])
    timed_stop = TimedStop(
        *result[:-1], time, outcome, slip_at_end=result.slip, outcome_at_end=outcome
    )
    inputs: dict[str, Any] = {"mass": mass, "speed": speed, "vacuum": vacuum, "gravity": pull}
    inputs["rope_stiffness"] = rope_stiffness
    notes = notes or list_stop_notices(file)
    return make_record(file, timed_stop, spring, vacuum, columns, inputs, after=notes)


def solve_stop_with_speed(brake: Brake, record: DropRecord) -> TimedStop:
    """Return the stop of a record by a brake with a speed law and other numbers."""
    spring = series_spring(brake, record.rope_stiffness)
    case = (record.mass, record.speed, record.vacuum, spring, record.gravity, brake)
    result = Stop(*(float(v) for v in stop(*case)))
    first, course = stop_course(*case)
    time, outcome = float(first) + float(course.end[0]), OUTCOMES.get(int(result.outcome))
    ends = (outcome or Outcome.FINISHED, result.slip, outcome or Outcome.FINISHED)
    return TimedStop(*result[:-1], time, *ends)


def make_record(
    file: BrakeFile,
    result: TimedStop,
    spring: float,
    vacuum: float,
    columns: Mapping[str, Any],
    inputs: Mapping[str, Any],
    *,
    before: Sequence[str] = (),
    after: Sequence[str] = (),
) -> tuple[TimedStop, DropRecord]:
    """Return a stop with its reason if it snapped, and its record with all warnings.

    `spring` [N/m] is the stiffness in series with the brake, `vacuum` [Pa] the vacuum of the stop.
    `before` and `after` are put before and after the warnings of the stop itself.
    """
    brake = file.brake
    if result.outcome is Outcome.SNAPS:
        min_stiffness = float(least_stiffness(vacuum, brake))
        is_damped = inputs.get("rope_damping")
        springs = "the brake has" if is_damped else "rope and brake together have"
        reason = (
            f"{springs} a stiffness of {show(spring, 'N/m')}; at a slip of {show(result.slip, 'm')}"
            " the force of the sliding brake falls faster than that, and the brake snaps. With at "
            f"least {show(min_stiffness, 'N/m')} it cannot snap at any slip"
        )
        result = result._replace(reason=reason, least_stiffness=min_stiffness)
    warnings = make_notices((*before, *_stop_warnings(result, brake), *after))
    record = DropRecord(
        **columns,
        **inputs,
        outcome=result.outcome,
        brake=file,
        warnings=(*file.warnings(), *warnings),
    )
    return result, record


def _stop_warnings(result: TimedStop, brake: Brake) -> list[str]:
    words = [result.reason] if result.reason else []
    if result.outcome is Outcome.BOTTOMED_OUT:
        travel = show(brake.sheets.usable_travel, "m")
        speed = show(result.end_speed, "m/s")
        words.append(f"the brake used up its travel of {travel} with the mass at {speed}")
    if Outcome.CLOSED_BY_SLEEVE in (result.outcome, result.outcome_at_end):
        words.append(
            "the run ends when friction no longer holds the enclosure, which then closes the brake"
        )
    if result.slip_at_end > result.slip * (1 + 1e-9):
        words.append(
            f"after the first standstill at {show(result.slip, 'm')} the brake slid on to "
            f"{show(result.slip_at_end, 'm')}"
        )
    return words


def _compute_columns(
    end: float,
    mass: float,
    speed: float,
    vacuum: float,
    spring: float,
    gravity: float,
    brake: Brake,
) -> dict[str, Array]:
    """Return a DropRecord's columns: elastic, equally spaced in time, then the slide to `end`."""
    case = (mass, speed, vacuum, spring, gravity, brake)
    paced = end > 0 and depends_on_speed(brake)
    is_sliding = end > 0 and not paced
    slid = _slip_samples(end, vacuum, brake) if is_sliding else np.zeros(SAMPLES)
    if paced:
        first = float(stop_course(*case)[0])
    else:
        times, speeds, forces, heats = np.asarray(_compute_slide(np.append(0.0, slid), *case))
        first = float(times[0])
    omega = (spring / mass) ** 0.5
    time = np.linspace(0, first, SAMPLES // 4 + 1)
    sag, swing = gravity / omega**2, speed / omega
    travel = sag * (1 - np.cos(omega * time)) + swing * np.sin(omega * time)
    moving = sag * omega * np.sin(omega * time) + speed * np.cos(omega * time)
    slip = np.zeros_like(time)
    force, heat = spring * travel, np.zeros_like(time)
    if is_sliding:
        time, moving = np.append(time, times[1:]), np.append(moving, speeds[1:])
        travel = np.append(travel, slid + forces[1:] / spring)
        slip, force = np.append(slip, slid), np.append(force, forces[1:])
        heat = np.append(heat, heats[1:])
    return {
        "time": time,
        "displacement": travel,
        "speed_of_mass": moving,
        "force": force,
        "slip": slip,
        "vacuum_in_time": np.full_like(time, vacuum),
        "dissipated_energy": heat,
    }


def _compute_slide(slip: Any, *case: Any) -> tuple[Any, ...]:
    """Return time [s], speed of the mass [m/s], force [N] and heat [J] at each slip [m]."""
    vacuum, brake = case[2], case[-1]
    return (
        time_at_slip(slip, *case),
        speed_at_slip(slip, *case),
        brake_force(slip, vacuum, brake),
        slip_heat(slip, vacuum, brake),
    )


def _append_slide(
    elastic: Mapping[str, Array], *case: Any
) -> tuple[dict[str, Array], float, float]:
    """Return the columns with the integrated slide of a stop with a speed law.

    Also returns the highest sliding speed [m/s], and the relative difference in slip, time and
    force from a run with longer steps.
    """
    vacuum, spring, brake = case[2], case[3], case[5]
    first, course = stop_course(*case)
    rows = np.vstack([np.asarray(course.rows)[: min(int(course.count), ROWS)], course.end])
    time, slip, speed, pace, friction_heat, force = rows[np.append(np.diff(rows[:, 0]) > 0, True)].T
    exact, coarse = np.asarray(course.end)[[0, 1, 5]], np.asarray(course.coarse)[[0, 1, 5]]
    enclosure_heat = enclosure_law(vacuum, brake).heat(slip)
    slid = {
        "time": float(first) + time,
        "displacement": slip + force / spring,
        "speed_of_mass": speed,
        "force": force,
        "slip": slip,
        "vacuum_in_time": np.full_like(time, vacuum),
        "dissipated_energy": friction_heat + np.asarray(enclosure_heat),
    }
    columns = {name: np.append(elastic[name], column) for name, column in slid.items()}
    return columns, float(pace.max()), float(np.max(abs(exact - coarse) / abs(exact)))


def _slip_samples(end: float, vacuum: float, brake: Brake) -> Array:
    """Return slips [m] up to `end`, dense at both ends, where the force bends and the speed drops.

    They include the slip of the largest force. Their number is always SAMPLES, so that the laws
    compile once.
    """
    if not has_single_modulus(brake):
        slip_at_peak, _, is_inside = first_peak(vacuum, brake)
        top = float(slip_at_peak) if is_inside else 0.0
    else:
        top = float(peak(vacuum, brake.sheets.usable_travel, brake).slip)
    peaks = [top / end] if 0 < top < end else []
    share = np.sin(np.linspace(0, np.pi / 2, SAMPLES + 1 - len(peaks))[1:]) ** 2
    return end * np.unique(np.append(share, peaks))
