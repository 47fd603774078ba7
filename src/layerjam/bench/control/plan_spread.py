"""Stops at one vacuum for uncertain mass, speed and brake: expected peak and probabilities.

Mass and speed are independent and log-normal, with the given means and standard deviations; the
uncertain numbers of the brake are those of a `Prediction`. `CUBES` independent Latin hypercubes
give the standard error of each mean. Stops are computed exactly, at constant vacuum.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.bench.control.plan import Arrival, Plan
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.stop.exact import NEVER_SLID, NOT_A_CASE, SNAPS, STOPPED, stop
from layerjam.brake.mechanics.stop.motion import rope_spring
from layerjam.brake.simulate import safe_vacuum, tuned
from layerjam.brake.simulate.prediction import (
    FEWEST_SAMPLES,
    Deviations,
    Prediction,
    change_numbers,
    draw_levels,
    find_quantiles,
    log_normal,
)
from layerjam.brake.simulate.safe_vacuum import SafeVacuum
from layerjam.core.evolve import evolve

Array = npt.NDArray[np.float64]
CUBES = 16
SAMPLES, SEED = 40_000, 1
TUNED = ("slip", "peak_force", "peak_g")
"""Keys whose intervals are stated for the tuned vacuum too, with `tuned_`."""


class Spread(NamedTuple):
    """Results for one vacuum over all arrivals and brakes; errors are standard errors."""

    peak_g: float
    """Expected ratio of peak force to weight, for stops before the end of travel."""
    peak_g_error: float
    peak_g_95: float
    """Ratio of peak force to weight that 95 % of those stops do not exceed."""
    beyond: float
    """Probability that stopping needs more slip than the travel."""
    beyond_error: float
    out: float
    """Probability that the brake's usable travel is used up (or the brake snaps)."""
    out_error: float
    end_speed: float
    """Mean speed at the end of travel [m/s] of the arrivals that use it up; 0 if none does."""
    tried: int
    """Number of stops tried."""
    samples: dict[str, Array]
    """Numbers of each stop by the keys of `plan`, in SI.

    Infinite if it snaps; slip and peaks also if it uses up the brake's travel.
    """


def _cube_size(samples: int) -> int:
    return max(-(-samples // CUBES), FEWEST_SAMPLES)


def draw_arrivals(case: Arrival, samples: int = SAMPLES, seed: int = SEED) -> tuple[Array, Array]:
    """Return masses [kg] and speeds [m/s], shape (CUBES, n)."""
    size = _cube_size(samples)
    cubes = [draw_levels(size, 2, 2 * (CUBES * seed + i)).T for i in range(CUBES)]
    mass, speed = (np.stack([find_quantiles(cube[k]) for cube in cubes]) for k in range(2))
    return (
        log_normal(mass, case.mass, case.mass_sd),
        log_normal(speed, case.speed, case.speed_sd),
    )


def draw_brakes(
    file: BrakeFile,
    vacuum: float,
    case: Arrival,
    samples: int = SAMPLES,
    seed: int = SEED,
    of_mean: bool = False,
) -> Brake:
    """Return the brake with samples of its uncertain numbers at a vacuum [Pa], shape (CUBES, n)."""
    usual = Prediction(
        *(file, vacuum, case.travel, case.speed), of_mean=of_mean, samples=_cube_size(samples)
    )
    rows = [evolve(usual, seed=2 * (CUBES * seed + i) + 1).deviations for i in range(CUBES)]
    return change_numbers(file.brake, Deviations(*map(np.stack, zip(*rows, strict=True))))


def predict_spread(
    vacuum: float,
    file: BrakeFile,
    case: Arrival,
    samples: int = SAMPLES,
    seed: int = SEED,
    of_mean: bool = False,
) -> Spread:
    """Return the expected peak and the probabilities at one vacuum [Pa]."""
    mass, speed = draw_arrivals(case, samples, seed)
    brakes = draw_brakes(file, vacuum, case, samples, seed, of_mean)
    spring = rope_spring(case.rope_stiffness, brakes)
    result = stop(mass, speed, vacuum + 0 * mass, spring, case.gravity, brakes)
    outcome, slip = np.asarray(result.outcome), np.asarray(result.slip)
    stands = (outcome == STOPPED) | (outcome == NEVER_SLID)
    g = file.brake.site.gravity
    with np.errstate(divide="ignore", invalid="ignore"):
        peak = np.asarray(result.peak_force) / (mass * g)
        peaks = np.where(stands, peak, 0.0).sum(axis=1) / stands.sum(axis=1)
    numbers = {"slip": slip, "peak_force": np.asarray(result.peak_force), "peak_g": peak}
    stop_samples = {key: np.where(stands, v, np.inf).ravel() for key, v in numbers.items()}
    has_snapped = np.isin(outcome, (SNAPS, NOT_A_CASE))
    stop_samples["dissipated_energy"] = np.where(has_snapped, np.inf, result.heat).ravel()
    exceeds = ~stands | (slip > case.travel * (1 + 1e-9))
    pace = np.asarray(result.end_speed)[~stands]
    high = float(np.quantile(peak[stands], 0.95)) if stands.any() else float("nan")
    pace_left = float(np.nanmean(pace)) if np.isfinite(pace).any() else 0.0
    least_error = 0.5 / mass.shape[1]  # all hypercubes use the same quantiles
    late_share = _mean_and_error(exceeds.mean(axis=1), least_error)
    out = _mean_and_error((~stands).mean(axis=1), least_error)
    return Spread(
        *_mean_and_error(peaks, 0.0), high, *late_share, *out, pace_left, mass.size, stop_samples
    )


def _mean_and_error(values: Array, min_error: float) -> tuple[float, float]:
    """Return the mean over the hypercubes and its standard error, which is at least `min_error`."""
    if not np.isfinite(values).all():
        return float("nan"), float("nan")
    return float(values.mean()), max(float(values.std(ddof=1)) / CUBES**0.5, min_error)


def predict_spreads(
    plan: Plan, samples: int, seed: int, of_mean: bool = False
) -> tuple[Spread, Spread]:
    """Return the spread of collisions at the full vacuum reached in time and the tuned vacuum.

    With `of_mean`, mass and speed are the estimated ones, and scatter between tests is left out.
    """
    case = _leave_out_scatter(plan.case) if of_mean else plan.case
    vacuums = (plan.reached,) if plan.capped else (plan.reached, plan.tuned.vacuum)
    spreads = [predict_spread(p, plan.brake, case, samples, seed, of_mean) for p in vacuums]
    return spreads[0], spreads[-1]


def predict_intervals(
    plan: Plan, spreads: tuple[Spread, Spread], least_vacuums: Array, of_mean: bool = False
) -> dict[str, Any]:
    """Return the intervals of both stops and of the lowest vacuum, and the basis of the first."""
    full, later = spreads
    conditions = plan.reached, plan.case.travel, plan.case.speed
    prediction = Prediction(plan.brake, *conditions, of_mean=of_mean)
    tuned_samples = {f"tuned_{key}": later.samples[key] for key in TUNED}
    return prediction.state(needed=least_vacuums, **full.samples, **tuned_samples)


def _leave_out_scatter(case: Arrival) -> Arrival:
    return evolve(case, mass_sd=0.0, speed_sd=0.0)


def find_safe_vacuum(
    plan: Plan, confidence: float, seed: int = SEED, of_mean: bool = False
) -> SafeVacuum:
    """Return the vacuum that keeps the share `confidence` of stops within the travel."""
    file, case = plan.brake, _leave_out_scatter(plan.case) if of_mean else plan.case
    mean_case = tuned.Case(
        brake=file.brake,
        mass=case.mass,
        speed=case.speed,
        travel=case.travel,
        gravity=case.gravity,
        rope=case.rope_stiffness,
    )
    vacuum = tuned.tuning_vacuum(mean_case) or plan.needed or plan.reached
    prediction = safe_vacuum.predict_decision(file, mean_case, vacuum)
    prediction = evolve(prediction, of_mean=of_mean)
    levels = draw_levels(prediction.samples, 2, seed + 1).T
    mass = log_normal(find_quantiles(levels[0]), case.mass, case.mass_sd)
    speed = log_normal(find_quantiles(levels[1]), case.speed, case.speed_sd)
    return safe_vacuum.find_safe_vacuum(
        evolve(mean_case, mass=mass, speed=speed), prediction, confidence
    )
