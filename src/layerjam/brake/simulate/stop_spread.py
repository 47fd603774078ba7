"""Scatter of a stop: its numbers for samples of the brake's uncertain numbers.

The exact law of linear friction solves all samples at once. Any other stop is replaced by an
equivalent one, whose numbers are scaled to those of the stop itself.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.stop.exact import NOT_A_CASE, SNAPS, stop, time_at_slip
from layerjam.brake.simulate.drop import TimedStop
from layerjam.brake.simulate.equivalent_stop import StopCase, make_linear, match_stop
from layerjam.brake.simulate.prediction import Prediction
from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.core.errors import Notice
from layerjam.core.evolve import evolve
from layerjam.core.units import show

Array = npt.NDArray[np.float64]
LEAST_SHARE = 0.995
"""Share of stops within the usable travel below which a notice states it."""
ENDED = (Outcome.STOPPED, Outcome.NEVER_SLID, Outcome.BOTTOMED_OUT)
KEYS = {
    "slip": "slip",
    "peak_force": "peak_force",
    "end_speed": "end_speed",
    "dissipated_energy": "heat",
    "stopping_time": "time",
}
"""{key of `drop`: field of a stop}."""


class StopSpread(NamedTuple):
    """Numbers of a stop for samples of a brake, {key of `drop`: values in SI}; empty if unknown.

    A sample that snaps has infinite values.
    """

    prediction: Prediction
    samples: dict[str, Array]

    def state(self, peaks: Callable[[Array], Mapping[str, Any]]) -> dict[str, Any]:
        """Return the fields of a `PredictionResult`; `peaks` gives the keys of a peak force [N]."""
        samples: dict[str, Any] = dict(self.samples)
        if samples:
            samples |= peaks(samples["peak_force"])
        return self.prediction.state(**{k: v for k, v in samples.items() if v is not None})

    def find_share(self, travel: float) -> float:
        """Return the share of the samples that stand still within a slip [m]."""
        slip, speed = self.samples["slip"], self.samples["end_speed"]
        return float(((slip <= travel * (1 + 1e-9)) & (speed <= 0)).mean())

    def notices(self, travel: float | None, outcome: Outcome) -> list[Notice]:
        """Return notices about the share of stops within a tuned or the usable `travel` [m]."""
        notices, usable = self.prediction.notices(), self.prediction.file.brake.sheets.usable_travel
        if not self.samples:
            return notices
        share = self.find_share(travel or usable)
        if self.prediction.of_mean:
            return notices
        if travel is not None:
            sentence = (
                f"at the tuned vacuum {share:.0%} of such stops stay within {show(travel, 'm')}, "
                "because friction and mounting scatter; `tune` prints the safe vacuum"
            )
            notices.append(Notice(sentence, "share-within-travel"))
        elif outcome is not Outcome.BOTTOMED_OUT and share < LEAST_SHARE:
            sentence = (
                f"friction and mounting scatter: {share:.0%} of such stops stay within the usable "
                f"travel of {show(usable, 'm')}"
            )
            notices.append(Notice(sentence, "may-use-up-travel"))
        return notices


def spread_stop(
    file: BrakeFile, end: TimedStop, record: DropRecord, of_mean: bool, *, sampled: bool = True
) -> StopSpread:
    """Return the scatter of a stop with this end and record, or only its basis if not `sampled`.

    The samples have slip, peak force, end speed, dissipated energy and stopping time. They are
    unknown if the stop snaps or is not over at the end of the record.
    """
    changes = bool(np.ptp(record.vacuum_in_time))
    vacuum = _weigh_vacuum(record) if changes else record.vacuum
    linear = make_linear(file.brake, record.speed)
    prediction = Prediction(file, vacuum, end.slip, record.speed, device=linear, of_mean=of_mean)
    if end.outcome not in ENDED or not sampled:
        return StopSpread(prediction, {})
    case = StopCase(record.mass, record.speed, vacuum, record.rope_stiffness, record.gravity)
    if changes or record.rope_damping or linear != file.brake:
        device = match_stop(linear, case, end.slip, end.end_speed)
        usual = _solve_stops(device, case)
        samples = _solve_stops(evolve(prediction, device=device).brakes, case)
        return StopSpread(prediction, _correct_samples(samples, usual, end, record))
    return StopSpread(prediction, _solve_stops(prediction.brakes, case))


def _correct_samples(
    samples: dict[str, Array], usual: Mapping[str, Array], end: TimedStop, record: DropRecord
) -> dict[str, Array]:
    """Return samples of equivalent stops, scaled from the usual one of them to the true end.

    The energy that is not dissipated is scaled instead of the heat, so that energy is balanced.
    """

    def release(slip: Any, end_speed: Any) -> Any:
        pace = record.speed**2 - end_speed**2
        return record.mass * (pace / 2 + record.gravity * slip)

    def find_stored(numbers: Mapping[str, Array]) -> Any:
        return release(numbers["slip"], numbers["end_speed"]) - numbers["dissipated_energy"]

    factor = _divide(release(end.slip, end.end_speed) - end.heat, find_stored(usual))
    heat = release(samples["slip"], samples["end_speed"]) - factor * find_stored(samples)
    corrections = {
        key: samples[key] * _divide(getattr(end, KEYS[key]), usual[key])
        for key in ("peak_force", "stopping_time")
    }
    return {**samples, **corrections, "dissipated_energy": np.maximum(heat, 0.0)}


def _divide(value: float, usual: Any) -> float:
    """Return a ratio to a value of shape (1,); 1 if it is undefined."""
    ratio = value / usual.item() if usual.item() else math.nan
    return ratio if math.isfinite(ratio) else 1.0


def _weigh_vacuum(record: DropRecord) -> float:
    """Return the mean of a changing vacuum [Pa] over the slip, on which the friction acts."""
    slip_steps = np.gradient(record.slip)
    total = float(slip_steps.sum())
    mean = float((record.vacuum_in_time * slip_steps).sum()) / total if total > 0 else record.vacuum
    return max(mean, 0.0)


def _solve_stops(brakes: Brake, case: StopCase) -> dict[str, Array]:
    """Return the numbers of the exact stops of brakes, shape (N,)."""
    *numbers, _ = case.arguments(brakes)
    unit = np.ones(np.shape(brakes.scale_factor) or 1)
    arguments = (*(value * unit for value in numbers), brakes)
    end = stop(*arguments)
    has_snapped = (end.outcome == SNAPS) | (end.outcome == NOT_A_CASE)
    values = {**end._asdict(), "time": time_at_slip(end.slip, *arguments)}
    return {key: np.where(has_snapped, np.inf, values[name]) for key, name in KEYS.items()}
