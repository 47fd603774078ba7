"""A mass falls on the brake (paper, section III-E): constant vacuum, exact.

Time counts from the taut rope. Without a brake the mass hangs on the rope alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.device.speed_law import SpeedLaw
from layerjam.errors import FitError, Notice
from layerjam.mechanics.enclosure import backbone_dissipated, enclosure_at
from layerjam.mechanics.energy import slip_heat
from layerjam.mechanics.pull import brake_force, least_stiffness, peak
from layerjam.mechanics.stop.exact import (
    BOTTOMED_OUT,
    NEVER_SLID,
    SNAPS,
    STOPPED,
    Stop,
    course_of,
    speed_at_slip,
    stop,
    time_at_slip,
)
from layerjam.mechanics.stop.motion import series_of
from layerjam.mechanics.stop.paced import ROWS
from layerjam.mechanics.stop.paced_tune import holds
from layerjam.simulate.first_pull import first_peak, overstretched
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.simulate.speed import follows_speed, in_a_stop
from layerjam.units import show

OUTCOMES = {
    STOPPED: Outcome.STOPPED,
    NEVER_SLID: Outcome.NEVER_SLID,
    BOTTOMED_OUT: Outcome.BOTTOMED_OUT,
    SNAPS: Outcome.SNAPS,
}
SAMPLES = 400
Array = np.ndarray[Any, np.dtype[np.float64]]


class TimedStop(NamedTuple):
    """How a stop went: the numbers at the first standstill or the end of travel, in SI."""

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
    """Why it snapped; None where it did not."""
    least_stiffness: float | None = None
    """What cannot snap at the vacuum it snapped at [N/m]."""


def spring_of(brake: Brake, rope_stiffness: float | None) -> float:
    """Rope and brake in series [N/m]."""
    return float(series_of(rope_stiffness, brake))


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

    `gravity` [m/s^2] acts along the pull; the site's unless given, 0 for a horizontal stop. The
    first result holds the exact numbers, the second is its record. The outcome is STOPPED,
    NEVER_SLID, BOTTOMED_OUT (the travel was used up, the mass still moving) or SNAPS. With a speed
    law the stop is integrated, and a notice says how exactly; it cannot snap then.
    """
    brake = file.brake
    pull = brake.site.gravity if gravity is None else gravity
    spring = spring_of(brake, rope_stiffness)
    case = (mass, speed, vacuum, spring, pull, brake)
    found = Stop(*(float(v) for v in stop(*case)))
    if int(found.outcome) not in OUTCOMES:
        if brake.hyperelastic is not None:
            raise overstretched(vacuum, brake)
        raise FitError("speed_law: the stop has more steps than can be followed")
    outcome = OUTCOMES[int(found.outcome)]
    columns, said = _course(found.slip, *case), []
    law = brake.speed_law if follows_speed(brake) else None
    if law is not None and found.slip > 0:
        columns, fastest, error = _slid(columns, law, *case)
        said = in_a_stop(file, fastest, error)
        if outcome is Outcome.STOPPED and not holds(found.slip, vacuum, mass * pull, brake):
            said.append(
                Notice(
                    "the mass stands still for a moment only: sheets at rest do not hold its "
                    f"weight of {show(mass * pull, 'N')} there, and it slides on",
                    "slides-on",
                )
            )
    time = float(columns["time"][-1])
    timed = TimedStop(*found[:-1], time, outcome, slip_at_end=found.slip, outcome_at_end=outcome)
    given: dict[str, Any] = {"mass": mass, "speed": speed, "vacuum": vacuum, "gravity": pull}
    given["rope_stiffness"] = rope_stiffness
    return concluded(file, timed, spring, vacuum, columns, given, after=said or in_a_stop(file))


def concluded(
    file: BrakeFile,
    timed: TimedStop,
    spring: float,
    vacuum: float,
    columns: Mapping[str, Any],
    given: Mapping[str, Any],
    *,
    before: Sequence[str] = (),
    after: Sequence[str] = (),
) -> tuple[TimedStop, DropRecord]:
    """A stop with why it snapped, where it did, and its record with all there is to say of it.

    `spring` [N/m] is what the brake hangs on, `vacuum` [Pa] that of the stop; `before` and `after`
    stand around the warnings of the stop itself.
    """
    brake = file.brake
    if timed.outcome is Outcome.SNAPS:
        least = float(least_stiffness(vacuum, brake))
        what = "the brake gives" if given.get("rope_damping") else "rope and brake together give"
        reason = (
            f"{what} {show(spring, 'N/m')}; at {show(timed.slip, 'm')} of slip the force of the "
            f"sliding brake falls faster than that, and it snaps. {show(least, 'N/m')} or more "
            "cannot snap at any slip"
        )
        timed = timed._replace(reason=reason, least_stiffness=least)
    warnings = (*file.warnings(), *before, *_words(timed, brake), *after)
    record = DropRecord(**columns, **given, outcome=timed.outcome, brake=file, warnings=warnings)
    return timed, record


def _words(timed: TimedStop, brake: Brake) -> list[str]:
    """What a reader of the numbers should know."""
    words = [timed.reason] if timed.reason else []
    if timed.outcome is Outcome.BOTTOMED_OUT:
        travel = show(brake.sheets.usable_travel, "m")
        speed = show(timed.end_speed, "m/s")
        words.append(f"the brake ran out of its {travel} with the mass at {speed}")
    if Outcome.CLOSED_BY_SLEEVE in (timed.outcome, timed.outcome_at_end):
        words.append(
            "the run ends where friction no longer holds the enclosure, which then closes the "
            "brake by itself"
        )
    if timed.slip_at_end > timed.slip * (1 + 1e-9):
        words.append(
            f"after the first standstill at {show(timed.slip, 'm')} the brake slid on to "
            f"{show(timed.slip_at_end, 'm')}"
        )
    return words


def _course(
    end: float,
    mass: float,
    speed: float,
    vacuum: float,
    spring: float,
    gravity: float,
    brake: Brake,
) -> dict[str, Array]:
    """Samples of the elastic part, equally spaced in time, then of the sliding one to slip `end`.

    The columns of a DropRecord.
    """
    case = (mass, speed, vacuum, spring, gravity, brake)
    law = brake.speed_law if follows_speed(brake) else None
    if law is not None and end > 0:
        first = float(course_of(law, *case)[0])
    else:
        first = float(time_at_slip(0.0, *case))
    omega = (spring / mass) ** 0.5
    time = np.linspace(0, first, SAMPLES // 4 + 1)
    sag, swing = gravity / omega**2, speed / omega
    travel = sag * (1 - np.cos(omega * time)) + swing * np.sin(omega * time)
    moving = sag * omega * np.sin(omega * time) + speed * np.cos(omega * time)
    slip = np.zeros_like(time)
    force, heat = spring * travel, np.zeros_like(time)
    if end > 0 and not law:
        # dense at both ends, where the force bends and the speed falls away; as many with the
        # peak as without, or the laws would be compiled for both
        top = _peak_share(end, vacuum, brake)
        share = np.sin(np.linspace(0, np.pi / 2, SAMPLES + 1 - len(top))[1:]) ** 2
        slid = end * np.unique(np.append(share, top))
        resist = np.asarray(brake_force(slid, vacuum, brake))
        time = np.append(time, np.asarray(time_at_slip(slid, *case)))
        moving = np.append(moving, np.asarray(speed_at_slip(slid, *case)))
        travel = np.append(travel, slid + resist / spring)
        slip, force = np.append(slip, slid), np.append(force, resist)
        heat = np.append(heat, np.asarray(slip_heat(slid, vacuum, brake)))
    return {
        "time": time,
        "travel": travel,
        "speed_of_mass": moving,
        "force": force,
        "slip": slip,
        "vacuum_in_time": np.full_like(time, vacuum),
        "dissipated_energy": heat,
    }


def _slid(
    elastic: Mapping[str, Array], law: SpeedLaw, *case: Any
) -> tuple[dict[str, Array], float, float]:
    """The columns with the sliding part of a stop with a speed law, as integrated.

    Also the fastest slip [m/s], and how much a coarser run differs in slip, time and force, as a
    share of them.
    """
    vacuum, spring, brake = case[2], case[3], case[5]
    first, course = course_of(law, *case)
    rows = np.vstack([np.asarray(course.rows)[: min(int(course.count), ROWS)], course.end])
    time, slip, speed, pace, rubbed, force = rows[np.append(np.diff(rows[:, 0]) > 0, True)].T
    exact, coarse = np.asarray(course.end)[[0, 1, 5]], np.asarray(course.coarse)[[0, 1, 5]]
    enclosure = enclosure_at(vacuum, brake)
    slid = {
        "time": float(first) + time,
        "travel": slip + force / spring,
        "speed_of_mass": speed,
        "force": force,
        "slip": slip,
        "vacuum_in_time": np.full_like(time, vacuum),
        "dissipated_energy": rubbed + np.asarray(backbone_dissipated(slip, enclosure)),
    }
    whole = {name: np.append(elastic[name], column) for name, column in slid.items()}
    return whole, float(pace.max()), float(np.max(abs(exact - coarse) / abs(exact)))


def _peak_share(slip: float, vacuum: float, brake: Brake) -> list[float]:
    """Where the greatest force lies, as a part of the whole slip."""
    if brake.hyperelastic is not None:
        slip_at_peak, _, inside = first_peak(vacuum, brake)
        top = float(slip_at_peak) if inside else 0.0
    else:
        top = float(peak(vacuum, brake.sheets.usable_travel, brake).slip)
    return [top / slip] if 0 < top < slip else []
