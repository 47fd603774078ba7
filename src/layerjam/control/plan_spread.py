"""Stops at one vacuum for uncertain mass and speed: expected peak and probabilities.

Mass and speed are independent and log-normal, with the given means and standard deviations. Means
are taken over a Fibonacci lattice of quantiles, shifted at random (Cranley and Patterson 1976)
`SHIFTS` times; the shifts give the standard error. Stops are computed exactly, at constant vacuum.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.control.plan import Arrival
from layerjam.device.brake import Brake
from layerjam.mechanics.stop.exact import NEVER_SLID, STOPPED, stop
from layerjam.simulate.drop import series_spring

Array = npt.NDArray[np.float64]
SHIFTS = 16
SAMPLES, SEED = 40_000, 1


class Spread(NamedTuple):
    """Results for one vacuum over all possible arrivals; errors are standard errors."""

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
    """Number of pairs of mass and speed tried."""


def lattice_points(samples: int, seed: int) -> Array:
    """Return about `samples` pairs of quantiles, shape (SHIFTS, n, 2); n is a Fibonacci number."""
    before, n = 1, 2
    while n * SHIFTS < samples:
        before, n = n, before + n
    i = np.arange(n)
    shifts = np.random.default_rng(seed).random((SHIFTS, 1, 2))
    points = (np.stack([i / n, i * before % n / n], axis=-1) + shifts) % 1.0
    return np.asarray(np.clip(points, 2.0**-54, 1 - 2.0**-53))


def log_normal(quantile: Array, mean: float, sd: float) -> Array:
    """Return the values of a log-normal quantity at these quantiles."""
    from scipy.special import ndtri

    if sd == 0:
        return np.full_like(quantile, mean)
    width = np.log1p((sd / mean) ** 2)
    return np.asarray(mean * np.exp(np.sqrt(width) * ndtri(quantile) - width / 2))


def draw_arrivals(case: Arrival, samples: int = SAMPLES, seed: int = SEED) -> tuple[Array, Array]:
    """Return masses [kg] and speeds [m/s], shape (SHIFTS, n)."""
    points = lattice_points(samples, seed)
    return (
        log_normal(points[..., 0], case.mass, case.mass_sd),
        log_normal(points[..., 1], case.speed, case.speed_sd),
    )


def predict_spread(
    vacuum: float, brake: Brake, case: Arrival, samples: int = SAMPLES, seed: int = SEED
) -> Spread:
    """Return the expected peak and the probabilities at one vacuum [Pa]."""
    mass, speed = draw_arrivals(case, samples, seed)
    result = stop(
        mass, speed, vacuum, series_spring(brake, case.rope_stiffness), case.gravity, brake
    )
    outcome, slip = np.asarray(result.outcome), np.asarray(result.slip)
    stands = (outcome == STOPPED) | (outcome == NEVER_SLID)
    g = brake.site.gravity
    with np.errstate(divide="ignore", invalid="ignore"):
        peak = np.asarray(result.peak_force) / (mass * g)
        peaks = np.where(stands, peak, 0.0).sum(axis=1) / stands.sum(axis=1)
    exceeds = ~stands | (slip > case.travel * (1 + 1e-9))
    pace = np.asarray(result.end_speed)[~stands]
    high = float(np.quantile(peak[stands], 0.95)) if stands.any() else float("nan")
    pace_left = float(np.nanmean(pace)) if np.isfinite(pace).any() else 0.0
    least = 1.0 / mass.size
    late, out = (
        _mean_and_error(exceeds.mean(axis=1), least),
        _mean_and_error((~stands).mean(axis=1), least),
    )
    return Spread(*_mean_and_error(peaks, 0.0), high, *late, *out, pace_left, mass.size)


def _mean_and_error(values: Array, least: float) -> tuple[float, float]:
    """Return the mean over the shifts and its standard error, which is at least `least`."""
    if not np.isfinite(values).all():
        return float("nan"), float("nan")
    return float(values.mean()), max(float(values.std(ddof=1)) / SHIFTS**0.5, least)
