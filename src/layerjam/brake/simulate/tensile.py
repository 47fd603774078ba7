"""Quasi-static simulation of a lumped brake in a test machine, for any procedure."""

from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.closed_forms import held_vacuum
from layerjam.brake.kernel.engine import Engine, follow_history, run_in_blocks
from layerjam.brake.mechanics.cycle import Cycle
from layerjam.brake.mechanics.effects import has_single_modulus
from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.law import law
from layerjam.brake.mechanics.memory import DEPTH
from layerjam.brake.mechanics.pull import least_stiffness, peak
from layerjam.brake.mechanics.speed_effects import depends_on_speed, fix_speed
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.first_pull import (
    check_hyperelastic,
    first_events,
    first_pull,
    is_first_pull,
    overstretch_error,
)
from layerjam.brake.simulate.procedure import Evacuate, Hold, Procedure, Pull, Return, Vent
from layerjam.brake.simulate.quantities import LEAK_TIME, check_inputs
from layerjam.brake.simulate.record import Outcome, TensileRecord
from layerjam.brake.simulate.speed import list_pull_notices
from layerjam.core.errors import ProcedureError, QuantityError, make_notices
from layerjam.core.units import show

SAMPLES = 400
RISE = 80
HOLDING = 100
"""Number of samples of a hold in which the vacuum leaks."""
Array = np.ndarray[Any, np.dtype[np.float64]]


@law
def _find_pull_events(vacuum: float, brake: Brake) -> tuple[float, float, float]:
    k, overlap = working_stiffness(brake), brake.sheets.overlap
    onset = sheet_friction(0.0, vacuum, brake) / k
    separation = overlap + enclosure_force(overlap, vacuum, brake) / k
    return onset, peak(vacuum, overlap, brake).elongation, separation


def _sample_path(
    procedure: Procedure, brake: Brake, leak_time: float | None
) -> tuple[Array, Array, Array, Array]:
    """Return time, elongation, vacuum and crosshead speed at every sample.

    Onset, peak and separation are samples. While the crosshead rests, the speed is that of its last
    move; before the first move, that of the first.
    """
    move_speeds = [step.speed for step in procedure.steps if isinstance(step, Pull | Return)]
    pace = move_speeds[0] if move_speeds else 0.0
    blocks: list[Array] = [_make_rows(0.0, 0.0, 0.0, pace)]
    shut = (0.0, 0.0)
    rate = None if leak_time is None else 1 / leak_time

    def remaining(clock: Array) -> Any:
        if rate is None:
            return shut[1]
        return held_vacuum(clock - shut[0], shut[1], rate, brake.site.atmosphere)

    for step in procedure.steps:
        time, start, vacuum, pace = blocks[-1][:, -1]
        if isinstance(step, Evacuate):
            # the first evacuation replaces the start, to avoid two samples at time zero
            if len(blocks) == 1 and blocks[0].shape[1] == 1:
                blocks = []
            times = [time, time + step.hold] if step.hold else [time]
            blocks.append(_make_rows(times, start, step.to, pace))
            shut = (time + step.hold, step.to)
        elif isinstance(step, Vent):
            blocks.append(_make_rows(time, start, 0.0, pace))
            shut = (time, 0.0)
        elif isinstance(step, Hold):
            samples = 1 if rate is None else HOLDING
            instants = time + step.duration * np.arange(1, samples + 1) / samples
            blocks.append(_make_rows(instants, start, remaining(instants), pace))
        else:
            positions = _sample_move(step, start, vacuum, fix_speed(step.speed, brake))
            instants = time + np.abs(positions - start) / step.speed
            blocks.append(_make_rows(instants, positions, remaining(instants), step.speed))
    times, elongations, vacuums, speeds = np.concatenate(blocks, axis=1)
    return times, elongations, vacuums, speeds


def _make_rows(time: Any, elongation: Any, vacuum: Any, speed: Any) -> Array:
    return np.array(np.broadcast_arrays(np.atleast_1d(time), elongation, vacuum, speed))


def _sample_move(step: Pull | Return, start: float, vacuum: float, brake: Brake) -> Array:
    """Return the elongations of a move's samples, including the events of a pull."""
    if isinstance(step, Return):
        return np.linspace(start, step.end, SAMPLES + 1)[1:]
    find_events = _find_pull_events if has_single_modulus(brake) else first_events
    events = np.array([float(e) for e in find_events(vacuum, brake)])
    # the grid may end after separation, as nothing is simulated beyond
    end = min(step.end, max(start, *events) * 1.001 + 1e-9)
    # sample the rise densely enough to fit a slope: it takes only one or two millimetres
    rise = np.linspace(start, min(end, 2 * events[1]), RISE + 1)
    events = events[(events > start) & (events < end)]
    grid = np.append(np.linspace(start, end, SAMPLES + 1)[1:], rise[rise > start])
    return np.union1d(grid, events)


def _run_history(
    elongation: Array, vacuum: Array, speed: Array, brake: Brake
) -> tuple[Cycle, Engine]:
    if not has_single_modulus(brake) and is_first_pull(elongation, vacuum):
        return run_in_blocks(lambda u, p: first_pull(u, p, brake), elongation, vacuum), "law"
    return follow_history(elongation, vacuum, brake, speed if depends_on_speed(brake) else None)


def _largest_return(slip: Array) -> float:
    """Return the largest decrease of the slip from an earlier maximum [m]."""
    return float((np.maximum.accumulate(slip) - slip).max())


def outcome_warnings(
    outcome: Outcome, vacuum: float, elongation: Array, slip: Array, brake: Brake
) -> list[str]:
    """Return warnings about the outcome of a pull at a vacuum [Pa], lumped or sheet by sheet."""
    texts = []
    if outcome is Outcome.SNAPS:
        minimum = show(float(least_stiffness(vacuum, brake)), "N/m")
        texts.append(
            f"the brake's force falls by {minimum} once it slides, so it snaps on a rig with a "
            f"stiffness of {show(float(working_stiffness(brake)), 'N/m')}; use more than {minimum}"
        )
    if outcome is Outcome.SEPARATED:
        texts.append(
            f"the sheets separated at an elongation of {show(float(elongation[-1]), 'm')}; "
            "the record ends there"
        )
    top, usable = float(slip.max(initial=0.0)), brake.sheets.usable_travel
    if outcome is not Outcome.SEPARATED and top > usable:
        texts.append(f"slip {show(top, 'm')} is beyond the usable travel of {show(usable, 'm')}")
    return texts


def tensile(
    file: BrakeFile, procedure: Procedure, *, leak_time: float | None = None
) -> TensileRecord:
    """Pull a brake through a procedure.

    With `leak_time` [s] the line is shut off after every evacuation and its hold, and the vacuum
    leaks (laminar, rigid chamber) until the next evacuation or vent. Otherwise the vacuum stays
    constant. The outcome is FINISHED, SEPARATED (the overlap was used up; the record ends there),
    CLOSED_BY_SLEEVE (unloaded, the enclosure pulled the brake back) or SNAPS (the brake's force
    falls faster than the rig relaxes; the record ends before it). Raises QuantityError for a vacuum
    above the site's atmosphere, and ProcedureError if nested turns exceed the memory of the
    enclosure. With a hyperelastic enclosure, a falling vacuum also raises ProcedureError.
    """
    brake = file.brake
    highest, atmosphere = procedure.highest_vacuum(), brake.site.atmosphere
    if highest > atmosphere:
        raise QuantityError.of(
            "vacuum",
            f"{show(highest, 'Pa')} exceeds atmospheric pressure, {show(atmosphere, 'Pa')}",
        )
    check_inputs({"leak time": leak_time}, {"leak time": LEAK_TIME})
    time, elongation, vacuum, speed = _sample_path(procedure, brake, leak_time)
    is_rubber = not has_single_modulus(brake)
    if is_rubber:
        check_hyperelastic(vacuum, brake)
    cycle, engine = _run_history(elongation, vacuum, speed, brake)
    if is_rubber and np.isnan(cycle.force[~cycle.snapped]).any():
        raise overstretch_error(highest, brake)
    end, outcome = len(time), Outcome.FINISHED
    is_separated = bool(cycle.separated.any())
    last = int(np.argmax(cycle.separated)) + 1 if is_separated else end
    if cycle.overflow[:last].any():
        raise ProcedureError(
            f"procedure: more than {DEPTH} nested reversals; the enclosure's memory "
            "cannot store more"
        )
    if cycle.snapped.any():
        end, outcome = int(np.argmax(cycle.snapped)), Outcome.SNAPS
    elif is_separated:
        end, outcome = last, Outcome.SEPARATED
    elif cycle.closed.any() and _largest_return(cycle.slip) > 1e-9 * brake.sheets.overlap:
        outcome = Outcome.CLOSED_BY_SLEEVE
    warnings = outcome_warnings(outcome, highest, elongation[:end], cycle.slip[:end], brake)
    if leak_time is not None:
        warnings.append(
            "the line is shut off after every evacuation; the vacuum decays with a time "
            f"constant of {show(leak_time, 's')}"
        )
    return TensileRecord(
        time=time[:end],
        elongation=elongation[:end],
        force=cycle.force[:end],
        slip=cycle.slip[:end],
        sleeve_force=cycle.sleeve_force[:end],
        vacuum=vacuum[:end],
        work=cycle.work[:end],
        dissipated_energy=cycle.heat[:end],
        stored_energy=cycle.stored[:end],
        outcome=outcome,
        procedure=procedure.text(),
        brake=file,
        engine=engine,
        warnings=tuple(
            make_notices(
                (*file.warnings(), *warnings, *list_pull_notices(file, float(speed.max())))
            )
        ),
    )
