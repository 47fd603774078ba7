"""Brake pulled sheet by sheet: staggered onset, rounded peak, load of each sheet."""

from collections.abc import Callable
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.kernel.stack import pull_stack
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.mechanics.speed_effects import fix_speed
from layerjam.brake.mechanics.stack.history import StackPull
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.procedure import Evacuate, Hold, Procedure, Pull, Return
from layerjam.brake.simulate.record import Outcome, TensileRecord
from layerjam.brake.simulate.speed import list_stack_notices
from layerjam.brake.simulate.stack_layout import (
    Housing,
    Interfaces,
    make_fanned_friction,
    make_stack,
)
from layerjam.brake.simulate.tensile import outcome_warnings
from layerjam.core.errors import ProcedureError, make_notices
from layerjam.core.evolve import evolve

FINE, COARSE = 2400, 1200
_NUMBERS = 50_000_000
Array = np.ndarray[Any, np.dtype[np.float64]]


def _split_procedure(procedure: Procedure) -> tuple[Evacuate, list[Pull | Return | Hold]]:
    """Return the evacuation and the later steps; raises ProcedureError for unsupported steps."""
    first, *others = procedure.steps
    if not isinstance(first, Evacuate) or not any(isinstance(s, Pull) for s in others):
        raise ProcedureError(
            "procedure: the stack model starts with an evacuation and then pulls at least once"
        )
    moves = []
    for step in others:
        if not isinstance(step, Pull | Return | Hold):
            raise ProcedureError(
                f"procedure: the stack model keeps the vacuum it starts with; '{step.text()}' "
                "needs the lumped model"
            )
        moves.append(step)
    return first, moves


def _sample_path(
    first: Evacuate, steps: list[Pull | Return | Hold], brake: Brake
) -> tuple[Array, Array]:
    """Return time and elongation of every sample, dense while sheets begin to slip one by one."""
    top = float(peak(first.to, brake.sheets.overlap, brake).force)
    rise = 2.0 * top / float(working_stiffness(brake))
    move_count = sum(not isinstance(s, Hold) for s in steps)
    # a stack of thousands of sheets is smooth, and its long history would be large
    limit = _NUMBERS // (4 * int(brake.sheets.count) * move_count)
    fine, coarse = (max(50, min(n, limit * n // (FINE + COARSE))) for n in (FINE, COARSE))
    times, positions = [np.array([first.hold])], [np.array([0.0])]
    for step in steps:
        clock, start = float(times[-1][-1]), float(positions[-1][-1])
        if isinstance(step, Hold):
            times.append(np.array([clock + step.duration]))
            positions.append(np.array([start]))
            continue
        end, span = step.end, abs(step.end - start)
        dense, sparse = np.linspace(0, min(span, rise), fine + 1), np.linspace(0, span, coarse + 1)
        distance = np.union1d(dense, sparse)[1:]
        times.append(clock + distance / step.speed)
        positions.append(np.append(start + distance[:-1] * np.sign(end - start), end))
    return np.concatenate(times), np.concatenate(positions)


def fix_sliding_speed(speed: float, brake: Brake) -> Brake:
    """Return the brake with kinetic friction at a speed [m/s], and no lower static friction."""
    sliding = fix_speed(speed, brake)
    static = max(float(brake.film.static), float(sliding.film.kinetic))
    return evolve(sliding, film=evolve(sliding.film, static=static))


def tensile_stack(
    file: BrakeFile,
    procedure: Procedure,
    *,
    interfaces: Interfaces | None = None,
    housing: Housing | None = None,
    static: bool = False,
    one_by_one: bool = False,
    progress: Callable[[float], None] | None = None,
) -> tuple[TensileRecord, StackPull]:
    """Pull a brake sheet by sheet: one evacuation, then pulls, returns and holds.

    Returns the record (with the interfaces' mean slip) and the motion of all sheets and interfaces.
    Outcomes are those of the lumped brake; CLOSED_BY_SLEEVE if every interface slides back when
    unloaded. `interfaces`, `housing`, `static` and `one_by_one` are as in `make_stack`. `progress`
    is called with the completed fraction. With a speed law, every interface has the friction at the
    first move's speed. Raises ProcedureError if the procedure changes the vacuum or does not pull.
    """
    first_step, later_moves = _split_procedure(procedure)
    speeds = [step.speed for step in later_moves if not isinstance(step, Hold)]
    brake = fix_sliding_speed(speeds[0], file.brake)
    vacuum = first_step.to
    layout: Any = {"interfaces": interfaces, "housing": housing, "static": static}
    stack = make_stack(brake, vacuum, one_by_one=one_by_one, **layout)
    lengths, fan = stack.length.copy(), make_fanned_friction(brake, vacuum, interfaces, static)
    time, path = _sample_path(first_step, later_moves, brake)
    if fan is not None:
        lengths[stack.ends[0] : stack.ends[1]] = fan.length
    result = pull_stack(path, stack, progress, fan.put if fan is not None else None)
    count = len(result.force)
    first, last = stack.ends
    slip = result.slip[:, first:last]
    outcome = Outcome.FINISHED
    if result.snapped:
        outcome = Outcome.SNAPS
    elif (slip[-1] >= lengths[first:last] * (1 - 1e-9)).all():
        outcome = Outcome.SEPARATED
    elif _is_closed(slip, result.slack, brake):
        outcome = Outcome.CLOSED_BY_SLEEVE
    record = TensileRecord(
        time=time[:count],
        elongation=path[:count],
        force=result.force,
        slip=slip.mean(axis=1),
        sleeve_force=result.faces.sum(axis=1),
        vacuum=np.full(count, vacuum),
        work=result.work,
        dissipated_energy=result.heat,
        stored_energy=result.stored,
        outcome=outcome,
        procedure=procedure.text(),
        brake=file,
        model="stack",
        warnings=(
            *file.warnings(),
            *make_notices(outcome_warnings(outcome, vacuum, path[:count], slip, brake)),
            *list_stack_notices(file, speeds),
        ),
    )
    return record, result


def _is_closed(slip: Array, slack: Any, brake: Brake) -> bool:
    """Return whether all interfaces, not only the outer ones, slid back without load."""
    if not slack.any():
        return False
    slid_back = np.maximum.accumulate(slip, axis=0) - slip
    return bool((slid_back[slack].min(axis=1) > 1e-9 * brake.sheets.overlap).any())
