"""The lumped brake in a test machine: quasi-static, any procedure of pulls, returns and vacuum."""

from __future__ import annotations

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import ProcedureError, QuantityError
from layerjam.mechanics.enclosure import enclosure_force
from layerjam.mechanics.friction import sheet_friction
from layerjam.mechanics.hysteresis import Cycle, brake_cycle
from layerjam.mechanics.law import law
from layerjam.mechanics.memory import DEPTH
from layerjam.mechanics.pull import least_stiffness, peak
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.procedure import Evacuate, Hold, Procedure, Pull, Return, Vent
from layerjam.simulate.record import Outcome, TensileRecord
from layerjam.units import show

SAMPLES = 400
RISE = 80
_BLOCK = 512


@law
def _events(vacuum: float, brake: Brake) -> tuple[float, float, float]:
    """Elongations of a first pull at onset, at the peak and at separation."""
    k, overlap = working_stiffness(brake), brake.sheets.overlap
    onset = sheet_friction(0.0, vacuum, brake) / k
    apart = overlap + enclosure_force(overlap, vacuum, brake) / k
    return onset, peak(vacuum, overlap, brake).elongation, apart


def _path(procedure: Procedure, brake: Brake) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, elongation and vacuum at every sample; onset, peak and separation are samples."""
    rows: list[tuple[float, float, float]] = [(0.0, 0.0, 0.0)]
    for step in procedure.steps:
        time, place, vacuum = rows[-1]
        if isinstance(step, Evacuate):
            # the first evacuation stands at the start: a record need not show two times zero
            rows = [] if len(rows) == 1 else rows
            rows.append((time, place, step.to))
            if step.hold:
                rows.append((time + step.hold, place, step.to))
        elif isinstance(step, Vent):
            rows.append((time, place, 0.0))
        elif isinstance(step, Hold):
            rows.append((time + step.duration, place, vacuum))
        elif isinstance(step, Pull | Return):
            end = step.until if isinstance(step, Pull) else step.to
            if isinstance(step, Pull):
                events = np.array([float(e) for e in _events(vacuum, brake)])
                # past separation nothing is simulated: the grid need not reach the end of travel
                end = min(end, max(place, *events) * 1.001 + 1e-9)
            places = np.linspace(place, end, SAMPLES + 1)[1:]
            if isinstance(step, Pull):
                events = events[(events > place) & (events < end)]
                # the rise to the peak takes a millimetre or two: enough samples to measure it on
                near = np.linspace(place, min(end, 2 * float(_events(vacuum, brake)[1])), RISE + 1)
                places = np.union1d(np.union1d(places, events), near[near > place])
            rows += [(time + abs(p - place) / step.speed, float(p), vacuum) for p in places]
    times, elongations, vacuums = np.array(rows).T
    return times, elongations, vacuums


def _run(elongation: np.ndarray, vacuum: np.ndarray, brake: Brake) -> Cycle:
    """`brake_cycle` with the history padded to whole blocks, so that few shapes are compiled."""
    count = len(elongation)
    pad = -count % _BLOCK
    result = brake_cycle(
        np.pad(elongation, (0, pad), mode="edge"), np.pad(vacuum, (0, pad), mode="edge"), brake
    )
    return Cycle(*(np.asarray(values)[:count] for values in result))


def _fell(slip: np.ndarray) -> float:
    """How far the slip came back from its greatest value so far [m]; rounding is no closing."""
    return float((np.maximum.accumulate(slip) - slip).max())


def tensile(file: BrakeFile, procedure: Procedure) -> TensileRecord:
    """Pull a brake through a procedure.

    The outcome is FINISHED, SEPARATED (the overlap was used up; the record ends there),
    CLOSED_BY_SLEEVE (unloaded, the sleeve drew the brake back by itself) or SNAPS (the rig is
    softer than the brake's softening; the record ends before it). Raises QuantityError for a
    vacuum above the site's atmosphere and ProcedureError where the nested turns exceed what the
    sleeve's memory holds.
    """
    brake = file.brake
    highest, atmosphere = procedure.highest_vacuum(), brake.site.atmosphere
    if highest > atmosphere:
        raise QuantityError(
            f"vacuum: {show(highest, 'Pa')} is more than the atmosphere, {show(atmosphere, 'Pa')}"
        )
    time, elongation, vacuum = _path(procedure, brake)
    cycle = _run(elongation, vacuum, brake)
    warnings = list(file.warnings())
    end, outcome = len(time), Outcome.FINISHED
    if cycle.overflow.any():
        raise ProcedureError(
            f"procedure: more than {DEPTH} turns nested in each other; the sleeve remembers no more"
        )
    if cycle.snapped.any():
        end, outcome = int(np.argmax(cycle.snapped)), Outcome.SNAPS
        least = float(least_stiffness(highest, brake))
        warnings.append(
            f"the brake softens by {show(least, 'N/m')} once it slides: on a rig of "
            f"{show(float(working_stiffness(brake)), 'N/m')} it snaps; needed is more than that"
        )
    elif cycle.separated.any():
        end, outcome = int(np.argmax(cycle.separated)) + 1, Outcome.SEPARATED
        warnings.append(
            f"the sheets came apart at {show(float(elongation[end - 1]), 'm')} of elongation; the "
            "record ends there"
        )
    elif cycle.closed.any() and _fell(cycle.slip) > 1e-9 * brake.sheets.overlap:
        outcome = Outcome.CLOSED_BY_SLEEVE
    if outcome is not Outcome.SEPARATED and cycle.slip[:end].max() > brake.sheets.usable_travel:
        warnings.append(
            f"slip {show(float(cycle.slip[:end].max()), 'm')} is beyond the usable travel of "
            f"{show(brake.sheets.usable_travel, 'm')}"
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
        warnings=tuple(warnings),
    )
