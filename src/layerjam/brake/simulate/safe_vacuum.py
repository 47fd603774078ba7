"""Vacuum at which a stated share of stops stays within a travel, for a brake that scatters."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.arrays import map_leaves
from layerjam.brake.mechanics.stop.exact import NEVER_SLID, STOPPED, stop
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.brake.mechanics.stop.tune import tuned_stop
from layerjam.brake.simulate.equivalent_stop import StopCase, make_linear, match_stop
from layerjam.brake.simulate.prediction import SAMPLES, Prediction
from layerjam.brake.simulate.tuned import Case

Array = npt.NDArray[np.float64]
DECISION_SAMPLES = 4 * SAMPLES
"""Number of samples for one quantile that a decision rests on: it varies by 0.3 %."""
ROUNDS = 40
"""Rounds of a bisection over the vacuum."""


class SafeVacuum(NamedTuple):
    """Vacuum [Pa] that keeps the stated share of stops within the travel, None if none does.

    `least_vacuums` [Pa] are those that the samples of the brake need: 0 if a sample always stops
    within the travel, infinite if it never does. `share` is that of the stops at the site's full
    vacuum.
    """

    vacuum: float | None
    least_vacuums: Array
    share: float


def predict_decision(file: BrakeFile, case: Case, vacuum: float | None) -> Prediction:
    """Return the prediction on which the safe vacuum of a case rests, near a vacuum [Pa].

    Mass and speed of the case are numbers. If no law solves its stop for many brakes, the samples
    are those of a brake with linear friction that slips as far at this vacuum.
    """
    mass, speed, _, rope, gravity, brake = case.values_per_brake()
    device = make_linear(brake, speed)
    if vacuum is not None and device != brake:
        stop_case = StopCase(mass, speed, vacuum, rope, gravity)
        end = stop(*stop_case.arguments(brake))
        device = match_stop(device, stop_case, float(end.slip), float(end.end_speed))
    conditions = vacuum, case.travel, case.speed, device
    return Prediction(file, *conditions, samples=DECISION_SAMPLES)


def find_safe_vacuum(case: Case, prediction: Prediction, confidence: float) -> SafeVacuum:
    """Return the vacuum that keeps the share `confidence` of stops within the travel of a case."""
    mass, speed, travel, rope, gravity, _ = case.values_per_brake()
    brakes, unit = prediction.brakes, np.ones(prediction.samples)
    least_vacuums = np.asarray(
        tuned_stop(mass * unit, speed * unit, travel * unit, rope, gravity, brakes)
    )
    atmosphere, spring = case.brake.site.atmosphere, rope_spring(rope, brakes)

    def is_within(vacuum: Any, places: Any = slice(None)) -> npt.NDArray[np.bool_]:
        """Return which samples, of those at `places`, stop within the travel at a vacuum."""

        def take(leaf: Any) -> Any:
            return leaf[places] if np.shape(leaf) == unit.shape else leaf

        full_case = (mass * unit, speed * unit, spring * unit, gravity * unit, brakes)
        m, v, k, g, few_brakes = (map_leaves(take, part) for part in full_case)
        end = stop(m, v, vacuum + 0.0 * m, k, g, few_brakes)
        stands = (end.outcome == STOPPED) | (end.outcome == NEVER_SLID)
        return np.asarray(stands & (end.slip <= travel * (1 + 1e-9)))

    is_missing = np.isnan(least_vacuums)
    if is_missing.any():
        # too slow to use up the travel, or too fast even for full vacuum
        reaches = is_within(atmosphere)
        least_vacuums = np.where(is_missing, np.where(reaches, 0.0, np.inf), least_vacuums)
        if len(places := np.flatnonzero(is_missing & reaches)):
            least_vacuums[places] = _bisect_least(lambda p: is_within(p, places), atmosphere)
    share = float(np.isfinite(least_vacuums).mean())
    vacuum = float(prediction.quantiles(least_vacuums, confidence))
    return SafeVacuum(vacuum if vacuum <= atmosphere else None, least_vacuums, share)


def _bisect_least(is_within: Any, atmosphere: float) -> Array:
    """Return the lowest vacuum at which each sample stops within the travel."""
    low, high = np.zeros(1), np.full(1, atmosphere)
    for _ in range(ROUNDS):
        midpoint = (low + high) / 2
        good = is_within(midpoint)
        low, high = np.where(good, low, midpoint), np.where(good, midpoint, high)
    return np.asarray(high)
