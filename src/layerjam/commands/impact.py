"""`drop`: what the brake does to a moving mass, and what is seen and felt of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at, si, vacuum_of
from layerjam.commands.tuning import MASS, TRAVEL, arrival, rope_of, tune
from layerjam.device.file import BrakeFile
from layerjam.device.mount import Rope
from layerjam.errors import QuantityError
from layerjam.measure.history import read_history
from layerjam.measure.options import ReadingOptions
from layerjam.mechanics.pull import least_stiffness
from layerjam.simulate.drop import damped_rope_only, snap_reason, spring_of
from layerjam.simulate.drop import drop as run_drop
from layerjam.simulate.drop_in_time import drop_in_time
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.simulate.rope_alone import felt
from layerjam.simulate.vacuum_history import History
from layerjam.units import QuantitySpec, show, spec_of

DURATION = QuantitySpec("s", "time to simulate", open_lo=True, hi=3600)
DROP_UNITS = {
    "slip": "m", "peak_force": "N", "peak_deceleration": "m/s^2", "peak_g": "1",
    "stopping_time": "s", "dissipated_energy": "J", "end_speed": "m/s", "vacuum": "Pa",
    "speed": "m/s", "least_stiffness": "N/m", "slip_at_end": "m",
}  # fmt: skip


def drop(
    brake: AnyBrake,
    *,
    mass: Quantity,
    speed: Quantity | None = None,
    height: Quantity | None = None,
    vacuum: Quantity | None = None,
    travel: Quantity | None = None,
    rope_stiffness: Quantity | None = None,
    rope_damping: Quantity | None = None,
    vacuum_history: str | Path | History | None = None,
    reading: str | None = None,
    columns: str | None = None,
    decimal: str | None = None,
    duration: Quantity | None = None,
    no_brake: bool = False,
    horizontal: bool = False,
    atmosphere: Quantity | None = None,
    progress: Callable[[float], None] | None = None,
) -> Answer:
    """Stop a falling mass with the brake, at a vacuum or at ``"tuned"`` for a travel (slip).

    Without `rope_stiffness` the mass hangs on the brake alone; with `no_brake` on the rope alone.
    Slip, peak and time refer to the first standstill or the end of travel. Exact at constant
    vacuum; with `rope_damping`, a `vacuum_history` (a file with time and vacuum, or a History) or a
    `duration` (to follow the rebound) it is marched in time. `reading` says what a file's pressure
    counts from (absolute, gauge or vacuum) where its column does not; `columns` and `decimal` are
    as for every log. A mass that has not stopped
    when `duration` is over has the outcome FINISHED and no `stopping_time`; one that creeps to rest
    on an overdamped rope has neither. `record` is the DropRecord (BareDrop without a brake);
    `observed` says what is measured and felt of it.
    """
    file = brake_at(brake, atmosphere)
    weighs, rope = si(mass, MASS, "mass"), rope_of(rope_stiffness)
    damping = _damping(rope_damping, rope)
    g = file.brake.site.gravity
    arrives = arrival(speed, height, horizontal, g)
    along = 0.0 if horizontal else g
    until = None if duration is None else si(duration, DURATION, "duration")
    if no_brake:
        if vacuum_history is not None or until is not None:
            raise QuantityError("vacuum: without a brake there is none, and no time to follow it")
        return _without_brake(weighs, arrives, rope, damping, along, g, vacuum, travel)
    if vacuum_history is not None:
        if vacuum is not None or travel is not None:
            raise QuantityError("vacuum: a history is given; leave vacuum and travel out")
        how = (reading, columns, decimal)
        history = _history(vacuum_history, file.brake.site.atmosphere, how)
        return _in_time(file, weighs, arrives, history, rope, damping, along, until, progress)
    if (reading, columns, decimal) != (None, None, None):
        raise QuantityError(
            "reading, columns and decimal: they go only with the file of a vacuum history"
        )
    if vacuum is None:
        raise QuantityError("vacuum: missing; give one, or 'tuned' together with travel")
    if isinstance(vacuum, str) and vacuum != "tuned" and vacuum.strip().lower() == "tuned":
        raise QuantityError(f"vacuum: '{vacuum}' is not known; did you mean 'tuned'?")
    pressure = 0.0 if vacuum == "tuned" else vacuum_of(vacuum, file.brake)
    if vacuum == "tuned":
        if travel is None:
            raise QuantityError("travel: missing; a tuned vacuum needs the slip to stop within")
        found = tune(
            file, mass=weighs, speed=arrives, travel=travel, rope_stiffness=rope,
            horizontal=horizontal,
        )  # fmt: skip
        if not found.feasible:
            return _cannot(arrives, found.reason, found.warnings)
        pressure = float(found.vacuum)
    else:
        if travel is not None:
            raise QuantityError("travel: goes only with a tuned vacuum")
    if damping or until is not None:
        answer = _in_time(file, weighs, arrives, pressure, rope, damping, along, until, progress)
        if damping and vacuum == "tuned" and answer.slip is not None:
            wanted = si(travel or 0.0, TRAVEL, "travel")
            said = (
                "the vacuum is tuned for a rope without damping; with it the brake slips "
                f"{show(answer.slip, 'm')}, not {show(wanted, 'm')}"
            )
            answer = replace(answer, warnings=[*answer.warnings, said])
        return answer
    result, record = run_drop(
        file, mass=weighs, speed=arrives, vacuum=pressure, rope_stiffness=rope, gravity=along
    )
    if record.outcome is Outcome.SNAPS:
        least = float(least_stiffness(pressure, file.brake))
        why = snap_reason(spring_of(file.brake, rope), result.slip, pressure, file.brake)
        return _cannot(arrives, why, record.warnings, pressure, least, record)
    numbers: dict[str, float | None] = {
        "slip": result.slip, "peak_force": result.peak_force, "end_speed": result.end_speed,
        "dissipated_energy": result.heat, "stopping_time": float(record.time[-1]),
    }  # fmt: skip
    return _stopped(numbers, record, pressure, arrives, along, g)


def _stopped(
    numbers: dict[str, float | None], record: DropRecord, vacuum: float | None, speed: float,
    along: float, g: float, at_end: tuple[float, str] | tuple[None, None] = (None, None),
) -> Answer:  # fmt: skip
    force, file = float(numbers["peak_force"] or 0.0), record.brake
    values: dict[str, object] = {
        **numbers,
        "peak_deceleration": force / record.mass - along,
        "peak_g": force / (record.mass * g) if g else None,
        "vacuum": vacuum,
        "outcome": str(record.outcome),
        "speed": speed,
        "feasible": True,
        "reason": None,
        "least_stiffness": float(least_stiffness(record.vacuum, file.brake)),
        "slip_at_end": at_end[0],
        "outcome_at_end": at_end[1],
    }
    return Answer(values=values, units=DROP_UNITS, warnings=record.warnings, record=record)


def _in_time(
    file: BrakeFile, mass: float, speed: float, vacuum: float | History, rope: float | None,
    damping: float, along: float, until: float | None, progress: Callable[[float], None] | None,
) -> Answer:  # fmt: skip
    """The answer of the solver in time."""
    timed, record = drop_in_time(
        file, mass=mass, speed=speed, vacuum=vacuum, rope_stiffness=rope, rope_damping=damping,
        gravity=along, duration=until, progress=progress,
    )  # fmt: skip
    pressure = None if isinstance(vacuum, History) else vacuum
    if record.outcome is Outcome.SNAPS:
        least, why = timed.least_stiffness, timed.reason or ""
        return _cannot(speed, why, record.warnings, pressure, least, record)
    moves = timed.outcome is Outcome.FINISHED
    numbers = {
        "slip": timed.slip, "peak_force": timed.peak_force, "end_speed": timed.end_speed,
        "dissipated_energy": timed.heat, "stopping_time": None if moves else timed.time,
    }  # fmt: skip
    end = (timed.slip_at_end, str(timed.outcome_at_end)) if until is not None else (None, None)
    return _stopped(numbers, record, pressure, speed, along, file.brake.site.gravity, end)


def _damping(damping: Quantity | None, rope: float | None) -> float:
    if damping is None:
        return 0.0
    if rope is None:
        raise QuantityError("rope damping: there is no rope; give its stiffness too")
    return si(damping, spec_of(Rope, "damping"), "rope damping")


def _options(reading: str | None, columns: str | None, decimal: str | None) -> ReadingOptions:
    return ReadingOptions(reading=reading, columns=columns, decimal=decimal)


def _history(
    source: str | Path | History, atmosphere: float, how: tuple[str | None, str | None, str | None]
) -> History:
    if not isinstance(source, History):
        return read_history(source, atmosphere, _options(*how))
    if how != (None, None, None):
        raise QuantityError("reading: goes only with a file; a History holds the vacuum itself")
    return source


def _cannot(
    speed: float, reason: str, warnings: Sequence[str], vacuum: float | None = None,
    least: float | None = None, record: object = None,
) -> Answer:  # fmt: skip
    """The answer "cannot": no numbers for what does not happen."""
    nothing = dict.fromkeys(("slip", "peak_force", "peak_deceleration", "peak_g", "stopping_time"))
    values = {
        **nothing, "dissipated_energy": None, "end_speed": None, "vacuum": vacuum,
        "outcome": str(Outcome.SNAPS) if record is not None else None, "speed": speed,
        "feasible": False, "reason": reason, "least_stiffness": least,
        "slip_at_end": None, "outcome_at_end": None,
    }  # fmt: skip
    others = [said for said in warnings if said != reason]
    return Answer(values=values, units=DROP_UNITS, warnings=others, record=record)


def _without_brake(
    mass: float, speed: float, rope: float | None, damping: float, along: float, g: float,
    vacuum: Quantity | None, travel: Quantity | None,
) -> Answer:  # fmt: skip
    if rope is None:
        raise QuantityError(
            "rope stiffness: missing; without a brake the mass hangs on the rope, and the command "
            "takes its stiffness (--rope-stiffness), not the brake's file"
        )
    if vacuum is not None or travel is not None:
        raise QuantityError("vacuum: without a brake there is none to give, nor a travel")
    force, time, heat = damped_rope_only(mass, speed, rope, damping, along)
    stands = math.isfinite(time)
    reason = None if stands else (
        f"on a rope damped by {show(damping, 'N s/m')} the mass never stands still: it creeps to "
        f"{show(mass * along / rope, 'm')}, where its weight hangs; peak and heat are those of all "
        "the time to come"
    )  # fmt: skip
    return Answer(
        values={
            "slip": None,
            "peak_force": force,
            "peak_deceleration": force / mass - along,
            "peak_g": force / (mass * g) if g else None,
            "stopping_time": time if stands else None,
            "dissipated_energy": heat,
            "end_speed": 0.0 if stands else None,
            "vacuum": None,
            "outcome": str(Outcome.STOPPED) if stands else None,
            "speed": speed,
            "feasible": True,
            "reason": reason,
            "least_stiffness": None,
            "slip_at_end": None,
            "outcome_at_end": None,
        },
        units=DROP_UNITS,
        record=felt(mass, speed, rope, damping, along, g),
    )
