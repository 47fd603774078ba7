"""Scatter of a stop: its numbers for samples of the brake's uncertain numbers.

At constant vacuum the exact law solves all samples at once. A stop that is integrated is repeated
for a few brakes, and interpolated for the samples.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.arrays import map_leaves
from layerjam.brake.mechanics.effects import depends_on_slip, has_single_modulus
from layerjam.brake.mechanics.speed_effects import depends_on_speed
from layerjam.brake.mechanics.stop.exact import NOT_A_CASE, SNAPS, stop, time_at_slip
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.brake.simulate.drop import TimedStop, solve_stop_with_speed
from layerjam.brake.simulate.drop_in_time import repeat_stop
from layerjam.brake.simulate.prediction import SAMPLES, Prediction
from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.brake.simulate.repeated_runs import interpolate_samples
from layerjam.brake.simulate.vacuum_history import History
from layerjam.core.errors import Notice
from layerjam.core.units import show

Array = npt.NDArray[np.float64]
LONGER, LATEST = 8, 4
"""Ratio of the steps and of the longest time of such a run to those of the stop itself."""
FEWER_SAMPLES = 250
"""Number of samples of a stop whose work is a quadrature, as for fanned sheets or rubber."""
TIME_STRIDE, TIME_TAIL = 8, 60
"""Stride of the samples whose stopping time is exact, and number of exact ones at each end."""
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
    file: BrakeFile, end: TimedStop, record: DropRecord, vacuum: float | History, of_mean: bool
) -> StopSpread:
    """Return the scatter of a stop at a vacuum [Pa] with this end and record.

    The samples have slip, peak force, end speed, dissipated energy and stopping time. They are
    unknown if the stop snaps or is not over at the end of the record.
    """
    changes = bool(np.ptp(record.vacuum_in_time))
    mean = _weigh_vacuum(record) if changes else record.vacuum
    is_slow = depends_on_slip(file.brake) or not has_single_modulus(file.brake)
    count = FEWER_SAMPLES if is_slow else SAMPLES
    prediction = Prediction(file, mean, end.slip, record.speed, of_mean=of_mean, samples=count)
    if end.outcome not in ENDED:
        return StopSpread(prediction, {})
    if not (changes or record.rope_damping or depends_on_speed(file.brake)):
        return StopSpread(prediction, _solve_samples(prediction, record))

    def run(brake: Brake) -> dict[str, float]:
        if record.step is None:
            repetition = solve_stop_with_speed(brake, record)
        else:
            steps = (LONGER * record.step, LATEST * end.time)
            repetition = repeat_stop(brake, record, vacuum, *steps)
        ends = repetition.outcome in ENDED
        return {key: getattr(repetition, name) if ends else np.inf for key, name in KEYS.items()}

    samples = interpolate_samples(prediction, run)
    samples = {key: np.maximum(values, 0.0) for key, values in samples.items()}
    slip, travel = samples["slip"], file.brake.sheets.usable_travel
    samples["slip"] = np.where(np.isfinite(slip), np.minimum(slip, travel), np.inf)
    return StopSpread(prediction, samples)


def _weigh_vacuum(record: DropRecord) -> float:
    """Return the mean of a changing vacuum [Pa] over the slip, on which the friction acts."""
    slip_steps = np.gradient(record.slip)
    total = float(slip_steps.sum())
    mean = float((record.vacuum_in_time * slip_steps).sum()) / total if total > 0 else record.vacuum
    return max(mean, 0.0)


def _solve_samples(prediction: Prediction, record: DropRecord) -> dict[str, Array]:
    """Return the numbers of the exact stops of all samples."""
    brakes, unit = prediction.brakes, np.ones(prediction.samples)
    spring = rope_spring(record.rope_stiffness, brakes)
    case = (
        *(value * unit for value in (record.mass, record.speed, record.vacuum)),
        *(spring * unit, record.gravity * unit, brakes),
    )
    end = stop(*case)
    has_snapped = (end.outcome == SNAPS) | (end.outcome == NOT_A_CASE)
    values = {**end._asdict(), "time": _find_times(end, case)}
    return {key: np.where(has_snapped, np.inf, values[name]) for key, name in KEYS.items()}


def _find_times(end: Any, case: tuple[Any, ...]) -> Array:
    """Return the stopping times [s] of exact stops with these ends, shape (N,).

    Each is a slow quadrature, so most are interpolated by slip and speed at the end. The shortest
    and longest are exact, because an interval rests on them.
    """
    count = len(end.slip)

    def solve(places: npt.NDArray[np.int64]) -> Array:
        def take(leaf: Any) -> Any:
            return leaf[places] if np.shape(leaf) == (count,) else leaf

        return np.asarray(time_at_slip(end.slip[places], *(map_leaves(take, c) for c in case)))

    if count <= FEWER_SAMPLES:
        return solve(np.arange(count, dtype=np.int64))
    order, times = np.lexsort((end.end_speed, end.slip)), np.empty(count)
    places = order[::TIME_STRIDE]
    times[order] = np.interp(np.arange(count), np.arange(0, count, TIME_STRIDE), solve(places))
    ranks = np.argsort(times)
    # next to stops without a time, interpolation has none either
    holes = np.flatnonzero(np.isnan(times) & np.isfinite(end.slip))
    inexact = np.unique(np.concatenate((ranks[:TIME_TAIL], ranks[-TIME_TAIL:], holes)))
    times[inexact] = solve(inexact)
    return times
