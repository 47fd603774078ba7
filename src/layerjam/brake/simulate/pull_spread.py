"""Scatter of a pull: its numbers for samples of the brake's uncertain numbers.

For one pull from rest at constant vacuum, laws solve all samples at once; sheet by sheet, they are
scaled to the numbers of that pull. Other procedures are repeated for a few brakes, and interpolated
for the samples.
"""

import functools
import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.effects import depends_on_slip, has_single_modulus
from layerjam.brake.mechanics.energy import slip_heat, slip_work
from layerjam.brake.mechanics.pull import brake_force, force_at_elongation, peak, slip_at_elongation
from layerjam.brake.mechanics.speed_effects import fix_speed
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.prediction import SAMPLES, Prediction
from layerjam.brake.simulate.procedure import Evacuate, Procedure, Pull, Return, parse_procedure
from layerjam.brake.simulate.record import Outcome, TensileRecord
from layerjam.brake.simulate.repeated_runs import interpolate_samples
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.evolve import evolve

Array = npt.NDArray[np.float64]
BAND_POINTS, BAND_SAMPLES = 24, 400
"""Number of elongations in each of three parts of a band, and of samples of the brake."""
FEWER_SAMPLES = 250
"""Number of samples of a pull whose friction is a quadrature, as for fanned sheets."""


class PullBand(NamedTuple):
    """95 % interval of the force of the next pull [N], at some elongations [m]."""

    elongation: Array
    low: Array
    high: Array
    tested_end: float
    """Elongation up to which tests cover the pull [m]: 0, or infinite for all of it."""


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
    pull: Callable[[BrakeFile], TensileRecord] | None = None,
    has_static: bool = False,
) -> tuple[Prediction, dict[str, Array]]:
    """Return the prediction of a pull with its numbers for all samples, by `pull_numbers`.

    `leak_time` [s] is that of the record. `pull` repeats a pull sheet by sheet, `has_static` if it
    has static friction. A sample that snaps has infinite numbers; there are none if the record
    itself snaps.
    """
    speeds = [step.speed for step in procedure.steps if isinstance(step, Pull | Return)]
    pace, vacuum = max(speeds, default=0.0), procedure.highest_vacuum()
    device = fix_speed(pace, file.brake)
    slip = float(record.slip.max(initial=0.0))
    count = FEWER_SAMPLES if depends_on_slip(device) else SAMPLES
    conditions = (vacuum, slip, pace, device)
    prediction = Prediction(file, *conditions, of_mean=of_mean, samples=count)
    if record.outcome is Outcome.SNAPS:
        return prediction, {}
    repeat = pull or functools.partial(tensile, procedure=procedure, leak_time=leak_time)

    def run(brake: Brake) -> dict[str, float]:
        repetition = repeat(evolve(file, brake=brake))
        numbers = pull_numbers(repetition)
        snaps = repetition.outcome is Outcome.SNAPS
        return dict.fromkeys(numbers, np.inf) if snaps else numbers

    single = None if leak_time is not None else _find_single_pull(procedure)
    as_tested, samples = evolve(prediction, device=None), None
    if single is not None and has_single_modulus(device):
        samples = _solve_samples(prediction.brakes, single.until, vacuum)
        if pull is None:
            return prediction, samples
        usual, true = _solve_samples(device, single.until, vacuum), pull_numbers(record)
        samples = {
            key: values * (true[key] / float(usual[key]) if usual[key] else 1.0)
            for key, values in samples.items()
        }
        if not has_static:
            return prediction, samples
    samples = interpolate_samples(as_tested, run, has_static, samples)
    return prediction, {name: np.maximum(values, 0.0) for name, values in samples.items()}


def find_pull_band(record: TensileRecord) -> PullBand | None:
    """Return the band of a pull; None except for one lumped pull at constant vacuum from rest."""
    procedure = parse_procedure(record.procedure)
    single, vacuum = _find_single_pull(procedure), procedure.highest_vacuum()
    if single is None or record.model != "lumped" or np.ptp(record.vacuum):
        return None
    device = fix_speed(single.speed, record.brake.brake)
    if not has_single_modulus(device) or not len(record.elongation):
        return None
    u = np.asarray(record.elongation, float)
    top = float(u[int(np.argmax(record.force))])
    # include the peak itself, where the force has a kink, with more points near it than beyond
    ends = 0.0, top, min(2 * top, (top + u[-1]) / 2), u[-1]
    parts = [np.linspace(a, b, BAND_POINTS, endpoint=False) for a, b in pairwise(ends)]
    elongation = np.concatenate((*parts, u[-1:]))
    slip = np.interp(elongation, u, record.slip)
    conditions = (vacuum, slip, single.speed, device)
    prediction = Prediction(record.brake, *conditions, samples=BAND_SAMPLES)
    interval = prediction.interval(force_at_elongation(elongation, vacuum, prediction.brakes))
    end = _find_tested_part(prediction, elongation, slip)
    return PullBand(elongation, interval["low"], interval["high"], end)


def _find_tested_part(prediction: Prediction, elongation: Array, slip: Array) -> float:
    """Return the elongation [m] up to which the conditions of a pull were tested."""
    if prediction.basis.word != "extrapolated":
        return math.inf
    ends = {e.quantity: e.high for e in prediction.basis.extrapolations}
    if set(ends) - {"slip", "strain"}:
        return 0.0
    return float(elongation[slip <= ends["slip"]].max(initial=0.0))


def _find_single_pull(procedure: Procedure) -> Pull | None:
    """Return the pull of a procedure that evacuates at rest and then only pulls."""
    first, *others = procedure.steps
    if isinstance(first, Evacuate) and len(others) == 1 and isinstance(others[0], Pull):
        return others[0]
    return None


def _solve_samples(brakes: Brake, elongation: float, vacuum: float) -> dict[str, Array]:
    """Return the numbers of brakes, pulled to an elongation [m] at a vacuum [Pa]."""
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
