"""Scatter of a lumped pull: its numbers for samples of the brake's uncertain numbers.

For one pull from rest at constant vacuum, laws solve all samples at once. Other procedures are
repeated for a few brakes, and interpolated for the samples.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.effects import fix_speed, has_single_modulus
from layerjam.brake.mechanics.energy import slip_heat, slip_work
from layerjam.brake.mechanics.pull import brake_force, force_at_elongation, peak, slip_at_elongation
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.prediction import Prediction
from layerjam.brake.simulate.procedure import Evacuate, Procedure, Pull, Return, parse_procedure
from layerjam.brake.simulate.record import Outcome, TensileRecord
from layerjam.brake.simulate.repeated_runs import interpolate_samples
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.evolve import evolve

Array = npt.NDArray[np.float64]
BAND, BAND_SAMPLES = 160, 400
"""Number of elongations and of samples of a band."""


def pull_numbers(record: TensileRecord) -> dict[str, Any]:
    """Return the numbers of a pull by the keys of `tensile`, in SI."""
    top = int(np.argmax(record.force))
    return {
        "peak_force": float(record.force[top]),
        "peak_elongation": float(record.elongation[top]),
        "force_at_end": float(record.force[-1]),
        "work": float(record.work[-1]),
        "dissipated_energy": float(record.dissipated_energy[-1]),
    }


def spread_pull(
    file: BrakeFile,
    procedure: Procedure,
    record: TensileRecord,
    *,
    leak_time: float | None = None,
    of_mean: bool = False,
) -> tuple[Prediction, dict[str, Array]]:
    """Return the prediction of a pull with its numbers for all samples, by `pull_numbers`.

    `leak_time` [s] is that of the record. A sample that snaps has infinite numbers; there are none
    if the record itself snaps.
    """
    speeds = [step.speed for step in procedure.steps if isinstance(step, Pull | Return)]
    pace, vacuum = max(speeds, default=0.0), procedure.highest_vacuum()
    device = fix_speed(pace, file.brake)
    slip = float(record.slip.max(initial=0.0))
    prediction = Prediction(file, vacuum, slip, pace, device=device, of_mean=of_mean)
    if record.outcome is Outcome.SNAPS:
        return prediction, {}
    single = _find_single_pull(procedure) if leak_time is None else None
    if single is not None and has_single_modulus(device):
        return prediction, _solve_samples(prediction, single.until, vacuum)

    def run(brake: Brake) -> dict[str, float]:
        repetition = tensile(evolve(file, brake=brake), procedure, leak_time=leak_time)
        numbers = pull_numbers(repetition)
        snaps = repetition.outcome is Outcome.SNAPS
        return dict.fromkeys(numbers, np.inf) if snaps else numbers

    samples = interpolate_samples(evolve(prediction, device=None), run)
    return prediction, {name: np.maximum(values, 0.0) for name, values in samples.items()}


def find_pull_band(record: TensileRecord) -> tuple[Array, Array, Array, bool] | None:
    """Return elongations [m], the ends of the force's 95 % interval [N], and whether it is tested.

    None except for one lumped pull from rest at constant vacuum.
    """
    procedure = parse_procedure(record.procedure)
    single, vacuum = _find_single_pull(procedure), procedure.highest_vacuum()
    if single is None or record.model != "lumped" or np.ptp(record.vacuum):
        return None
    device = fix_speed(single.speed, record.brake.brake)
    if not has_single_modulus(device) or not len(record.elongation):
        return None
    end = float(record.elongation[-1])
    # the force has a kink at the peak
    elongation = end * np.linspace(0.0, 1.0, BAND) ** 2
    slip = float(record.slip.max())
    conditions = Prediction(record.brake, vacuum, slip, single.speed)
    prediction = evolve(conditions, slip=elongation, device=device, samples=BAND_SAMPLES)
    force = force_at_elongation(elongation, vacuum, prediction.brakes)
    ends = prediction.interval(force)
    return elongation, ends["low"], ends["high"], bool(conditions.is_tested())


def _find_single_pull(procedure: Procedure) -> Pull | None:
    """Return the pull of a procedure that evacuates at rest and then only pulls."""
    first, *others = procedure.steps
    if isinstance(first, Evacuate) and len(others) == 1 and isinstance(others[0], Pull):
        return others[0]
    return None


def _solve_samples(prediction: Prediction, elongation: float, vacuum: float) -> dict[str, Array]:
    """Return the numbers of all samples, pulled to an elongation [m] at a vacuum [Pa]."""
    brakes = prediction.brakes
    stiffness = working_stiffness(brakes)
    slip: Any = slip_at_elongation(elongation, vacuum, brakes)
    slip = np.minimum(slip, brakes.sheets.overlap)
    slides, elastic = slip > 0, stiffness * elongation
    top, end = peak(vacuum, slip, brakes), brake_force(slip, vacuum, brakes)
    force = np.where(slides, end, elastic)
    values = {
        "peak_force": np.where(slides, top.force, elastic),
        "peak_elongation": np.where(slides, top.elongation, elongation),
        "force_at_end": force,
        "work": slip_work(slip, vacuum, brakes) + force**2 / (2 * stiffness),
        "dissipated_energy": slip_heat(slip, vacuum, brakes),
    }
    return {name: np.where(np.isnan(slip), np.inf, value) for name, value in values.items()}
