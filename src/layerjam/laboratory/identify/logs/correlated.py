"""Least squares on a time log, with intervals that allow for correlated residuals.

Samples of a sensor are not independent, so a standard error based on their number is too small. The
log is averaged into bins and fitted by ordinary least squares, which remains close to the log even
if the model is not quite correct. The bin residuals are modelled as white noise plus a first-order
drift, C = s² ((1 - w) ρ^|i-j| + w δij), with ρ and w from their restricted likelihood (Patterson
and Thompson 1971). Because ρ and w are uncertain, the covariance of the parameters, (JᵀJ)⁻¹ JᵀCJ
(JᵀJ)⁻¹, is the mean over a grid of both, weighted by that likelihood.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from layerjam.core.errors import FitError
from layerjam.core.units import show
from layerjam.laboratory.identify.statistics import interval_ends
from layerjam.laboratory.measure.trace import Array

BINS = 150
LEAST = 20
_RHO = (0.0, 0.3, 0.6, 0.8, 0.9, 0.95, 0.98, 0.99)
_WHITE = (0.0, 0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95)


@dataclass(frozen=True, kw_only=True)
class Series:
    """Model fitted to a log; `values` and `covariance` are in the units of the parameters.

    `correlation` is that of neighbouring bins, `freedom` the effective degrees of freedom, `rmse`
    that of the samples, `noise` the scatter from sample to sample (divided by √2). `residuals` are
    those of the bins (bins,); `whiten` (bins, bins) makes them independent with unit variance.
    """

    values: Array
    covariance: Array
    correlation: float
    freedom: float
    rmse: float
    noise: float
    residuals: Array
    whiten: Array

    def excess_over(self, rival: "Series") -> float:
        """Return by how much the sum of squares exceeds that of `rival`, relative to its noise.

        It is twice the difference in log likelihood.
        """
        this_sum, rival_sum = (
            float(np.sum((rival.whiten @ s.residuals) ** 2)) for s in (self, rival)
        )
        return this_sum - rival_sum

    @property
    def standard_errors(self) -> Array:
        """Standard errors of the parameters."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def quantile(self, level: float = 0.95) -> float:
        """Return the half-width of an interval, in standard errors (Student's t)."""
        from scipy.stats import t

        return float(t.ppf(0.5 + level / 2, self.freedom))

    def interval(
        self, function: Callable[[Array], float], level: float = 0.95, positive: bool = False
    ) -> tuple[float, float]:
        """Return the first-order interval of a function of the parameters."""
        half_width = self.quantile(level) * self.error(function)
        return interval_ends(float(function(self.values)), half_width, positive)

    def error(self, function: Callable[[Array], float]) -> float:
        """Return the standard error of a function of the parameters, to first order."""
        slope = np.zeros(len(self.values))
        for i, step in enumerate(1e-3 * self.standard_errors):
            if step > 0:
                move = np.zeros(len(self.values))
                move[i] = step
                slope[i] = (function(self.values + move) - function(self.values - move)) / (
                    2 * step
                )
        return float(np.sqrt(max(float(slope @ self.covariance @ slope), 0.0)))


def average_bins(values: Array, bins: int = BINS) -> Array:
    """Return means over `bins` runs of nearly equal length, or all values if there are fewer."""
    edges = np.linspace(0, len(values), min(bins, len(values)) + 1).astype(int)
    return np.asarray(np.add.reduceat(values, edges[:-1]) / np.diff(edges))


def check_resolution(log_values: Array, final: float, duration: float) -> None:
    """Raise FitError if a pressure [Pa] reaches its final level within the first bin of a fit.

    `duration` [s] is that of the log. A fit would state a rate that depends on its start.
    """
    decay = np.abs(average_bins(log_values) - final)
    if np.count_nonzero(decay > 0.1 * decay.max()) < 2:
        first = show(duration / len(decay), "s")
        raise FitError(
            f"the pressure reaches its final level within the first of {len(decay)} sections that "
            f"are fitted ({first}): end the window earlier (--to), or log more samples per second"
        )


def fit_series(
    model: Callable[[Array], Array],
    log_values: Array,
    start: Sequence[float],
    scale: Sequence[float],
    bounds: tuple[Sequence[float], Sequence[float]] | None = None,
) -> Series:
    """Fit the parameters of `model` (parameters to values at every sample, shape (N,)) to a log.

    `scale` is the typical size of each parameter. The model is averaged over the bins like the
    samples, so that binning does not reduce accuracy. Raises FitError for fewer than 20 samples or
    if the model has no finite value.
    """
    if len(log_values) < LEAST:
        raise FitError(f"a fit needs at least {LEAST} samples; there are {len(log_values)}")
    bins = average_bins(log_values)
    size = max(float(np.ptp(bins)), 1e-9 * float(np.max(np.abs(bins))), 1e-300)
    values, jacobian = _fit_bins(model, bins, np.array(start, float), scale, bounds, size)
    left = bins - average_bins(model(values))
    noise = _Noise.estimate(jacobian, left, 1e-10 * size, np.array(scale, float))
    residuals = model(values) - log_values
    return Series(
        values=values,
        covariance=noise.covariance,
        correlation=noise.correlation,
        freedom=max(noise.effective - len(values), 2.0),
        rmse=float(np.sqrt(np.mean(residuals**2))),
        noise=float(np.std(np.diff(residuals)) / np.sqrt(2)),
        residuals=-left,
        whiten=noise.whiten,
    )


def _fit_bins(
    model: Callable[[Array], Array],
    bins: Array,
    start: Array,
    scale: Sequence[float],
    bounds: tuple[Sequence[float], Sequence[float]] | None,
    size: float,
) -> tuple[Array, Array]:
    """Return (values, Jacobian of the bins) at the minimum of the sum of squares."""
    from scipy.optimize import least_squares

    def residual(values: Array) -> Array:
        deviation = average_bins(model(values)) - bins
        if not np.isfinite(deviation).all():
            deviation = np.full_like(deviation, 1e3 * size)
        return np.asarray(deviation / size)

    limits = bounds if bounds is not None else (-np.inf, np.inf)
    solution = least_squares(
        residual,
        start,
        x_scale=np.array(scale, float),
        bounds=limits,
        xtol=1e-11,
        ftol=1e-12,
        gtol=1e-14,
        jac="3-point",
        max_nfev=100,
    )
    if not np.isfinite(average_bins(model(solution.x))).all():
        raise FitError("the model gives no finite values near this log")
    return solution.x, solution.jac * size


@lru_cache(maxsize=4)
def _make_whitening(count: int) -> list[tuple[float, Array, float, float, Array]]:
    """Return (correlation, whitening matrix, log determinant, effective number, C) of a grid."""
    distance = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    out = []
    for rho in _RHO:
        for white in _WHITE if rho else (0.0,):
            spread = (1 - white) * float(rho) ** distance + white * np.eye(count)
            lower = np.linalg.cholesky(spread)
            whiten = np.linalg.solve(lower, np.eye(count))
            log_size = 2 * float(np.sum(np.log(np.diag(lower))))
            out.append(
                ((1 - white) * rho, whiten, log_size, count**2 / float(spread.sum()), spread)
            )
    return out


@dataclass(frozen=True, kw_only=True)
class _Noise:
    """Correlation of the residuals and the resulting covariance of the parameters."""

    covariance: Array
    correlation: float
    effective: float
    whiten: Array

    @classmethod
    def estimate(cls, jacobian: Array, left: Array, floor: float, scale: Array) -> "_Noise":
        """Estimate both from the bins' residuals `left`, (bins,), and the Jacobian (bins, P)."""
        count, unknowns = jacobian.shape
        unit_jacobian = jacobian * scale
        project = np.linalg.pinv(unit_jacobian)
        scores, spreads, sizes = [], [], []
        for _, whiten, log_size, _, spread in _make_whitening(count):
            columns, white_residuals = whiten @ unit_jacobian, whiten @ left
            move = np.linalg.lstsq(columns, white_residuals, rcond=None)[0]
            total = float(np.sum((white_residuals - columns @ move) ** 2)) + count * floor**2
            _, log_columns = np.linalg.slogdet(columns.T @ columns + 1e-30 * np.eye(unknowns))
            variance = total / (count - unknowns)
            scores.append(-0.5 * (log_size + log_columns + (count - unknowns) * np.log(variance)))
            spreads.append(variance * project @ spread @ project.T)
            sizes.append(variance)
        weight = np.exp(np.array(scores) - max(scores))
        weight /= weight.sum()
        covariance = np.einsum("k,kij->ij", weight, np.array(spreads))
        grid, best = _make_whitening(count), int(np.argmax(scores))
        return cls(
            covariance=covariance * np.outer(scale, scale),
            correlation=float(weight @ np.array([g[0] for g in grid])),
            effective=float(weight @ np.array([g[3] for g in grid])),
            whiten=grid[best][1] / np.sqrt(sizes[best]),
        )
