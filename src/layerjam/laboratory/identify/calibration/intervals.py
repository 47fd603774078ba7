"""Intervals from repeats, and how further pulls would narrow them.

The noise within a curve does not show repeatability. A curve is a cluster: its thousands of samples
share one mounting, one friction and one slack. All intervals are based on the scatter between
curves, with Student's t for the number of curves. A percentile bootstrap of three repeats covers
74 % instead of 95 % and is not available.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from layerjam.laboratory.identify.statistics import LEVEL, interval_ends

RESAMPLES = 2000
SURE = 0.8
"""Probability that `RequiredPulls.sure` further pulls are enough."""
PULL_LIMIT = 1000
"""Largest number of further pulls considered."""


def quantile(degrees: float, level: float = LEVEL) -> float:
    """Return Student's t of a two-sided interval that contains the fraction `level`."""
    return float(special.stdtrit(degrees, (1 + level) / 2))


def combine_uncertainties(parts: Iterable[tuple[float, float]]) -> tuple[float, float]:
    """Return the combined standard uncertainty and its effective degrees of freedom.

    `parts` are (standard uncertainty, degrees of freedom) of independent contributions in one unit.
    The result is the root of the sum of squares (GUM, 5.1.2) and the Welch-Satterthwaite value
    (GUM, annex G.4.1), not truncated; it is infinite if every contribution is known exactly.
    """
    inputs = list(parts)
    variance = math.fsum(u**2 for u, _ in inputs)
    if variance == 0:
        return 0.0, min((degrees for _, degrees in inputs), default=math.inf)
    inverse_degrees = math.fsum((u**2 / variance) ** 2 / degrees for u, degrees in inputs)
    return math.sqrt(variance), 1 / inverse_degrees if inverse_degrees > 0 else math.inf


def coverage_factor(parts: Sequence[tuple[float, float]]) -> float:
    """Return the ratio of expanded (95 %) to combined uncertainty of `parts`.

    It is Student's quantile for the effective degrees of freedom (GUM, annex G.4.1). The expanded
    uncertainty is never below that of any single contribution; with one or two degrees of freedom,
    the Welch-Satterthwaite formula alone could make a further contribution reduce it.
    """
    total, degrees = combine_uncertainties(parts)
    contributions = [quantile(freedom) * u / total for u, freedom in parts if u > 0]
    return max([quantile(degrees), *contributions])


@dataclass(frozen=True, kw_only=True)
class Interval:
    """A 95 % coverage interval with its standard error, degrees of freedom and method.

    `coverage_factor` is the ratio of its half-width to the standard error, if both are small.
    """

    low: float
    high: float
    standard_error: float
    degrees_of_freedom: float
    coverage_factor: float
    method: str

    @classmethod
    def about(
        cls, value: float, parts: Sequence[tuple[float, float]], method: str, positive: bool
    ) -> "Interval":
        """Return a Student's t interval about a value; `parts` are its standard uncertainties.

        The interval of a `positive` value is symmetric about its logarithm, so it excludes zero.
        """
        error, degrees = combine_uncertainties(parts)
        factor = coverage_factor(parts)
        low, high = interval_ends(value, factor * error, positive)
        return cls(
            low=low,
            high=high,
            standard_error=error,
            degrees_of_freedom=degrees,
            coverage_factor=factor,
            method=method,
        )

    @property
    def half_width(self) -> float:
        """Half-width of the interval, in the value's unit."""
        return (self.high - self.low) / 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Population:
    """Linear model of the parameters that many curves share.

    Each curve yields a few numbers that scatter about `design` (curves, r, q) times the shared
    `estimate` (q,), by `residual` (curves, r). Both are divided by the standard deviation that the
    weights assume, so that the estimate is ordinary least squares. The weights only affect how
    efficiently the curves are used. Intervals are right for any weights, because they use the
    scatter of the residuals from curve to curve.
    """

    estimate: np.ndarray
    design: np.ndarray
    residual: np.ndarray

    @property
    def count(self) -> int:
        """Number of curves."""
        return len(self.residual)

    def join_groups(self, groups: Sequence[Sequence[int]]) -> "Population":
        """Return the population with the curves (indices) of each group joined into one.

        The estimate stays the same; intervals are then based on the scatter between groups,
        whatever the curves within a group share. Rows of zeros pad shorter groups.
        """
        rows, unknowns = self.design.shape[1:]
        size = rows * max(map(len, groups))
        design, residual = np.zeros((len(groups), size, unknowns)), np.zeros((len(groups), size))
        for place, group in enumerate(groups):
            end = rows * len(group)
            design[place, :end] = self.design[list(group)].reshape(end, unknowns)
            residual[place, :end] = self.residual[list(group)].reshape(end)
        return Population(estimate=self.estimate, design=design, residual=residual)

    @property
    def information(self) -> np.ndarray:
        """Information of each curve about the shared parameters, shape (curves, q, q)."""
        return np.einsum("gri,grj->gij", self.design, self.design)

    @property
    def score(self) -> np.ndarray:
        """Score of each curve at the estimate, shape (curves, q); the scores sum to zero."""
        return np.einsum("gri,gr->gi", self.design, self.residual)

    def shift(self, left_out: Sequence[int]) -> np.ndarray | None:
        """Return the shift of the estimate (q,) without these curves; None if undetermined."""
        out = list(left_out)
        other_information = np.delete(self.information, out, axis=0).sum(axis=0)
        if not _is_invertible(other_information):
            return None
        return -np.linalg.solve(other_information, self.score[out].sum(axis=0))

    def _adjust_design(self) -> np.ndarray | None:
        """Return (I - H)^(-1/2) times each curve's design, H its leverage; None if H is 1."""
        information = self.information
        total = information.sum(axis=0)
        if self.count < 2 or not _is_invertible(total):
            return None
        if not _is_invertible(total - information).all():
            return None
        leverage = self.design @ np.linalg.solve(total, np.swapaxes(self.design, 1, 2))
        free, axes = np.linalg.eigh(np.eye(leverage.shape[1]) - leverage)
        root = axes / np.sqrt(np.maximum(free, 1e-12))[:, None, :] @ np.swapaxes(axes, 1, 2)
        return root @ self.design

    def standard_error(self, contrast: np.ndarray) -> tuple[float, float] | None:
        """Return a linear combination's (q,) standard error and degrees of freedom, or None.

        It is the sandwich estimator over curves, with residuals scaled for their leverage (CR2). It
        is unbiased if the curves scatter as the weights assume. The degrees of freedom are
        Satterthwaite's under the same assumption (Bell and McCaffrey 2002; Pustejovsky and Tipton
        2018). For equally weighted curves this is Student's t for their mean. None if one curve
        alone determines the combination.
        """
        designs = self._adjust_design()
        if designs is None:
            return None
        total = self.information.sum(axis=0)
        lever = designs @ np.linalg.solve(total, contrast)
        shifts = np.einsum("gr,gr->g", lever, self.residual)
        pull = np.einsum("gri,gr->gi", self.design, lever)
        product = np.diag((lever**2).sum(axis=1)) - pull @ np.linalg.solve(total, pull.T)
        square = float((product**2).sum())
        if not square > 0:
            return None
        degrees = float(np.trace(product)) ** 2 / square
        # remove rounding errors, so that n - 1 is a whole number
        return float(np.sqrt((shifts**2).sum())), round(degrees, 12)

    def covariance(self) -> np.ndarray:
        """Return the sandwich covariance of the estimate (q, q); NaN if unknown."""
        designs = self._adjust_design()
        size = len(self.estimate)
        if designs is None:
            return np.full((size, size), np.nan)
        shifts = np.einsum("gri,gr->gi", designs, self.residual)
        inverse = np.linalg.inv(self.information.sum(axis=0))
        return np.asarray(inverse @ (shifts.T @ shifts) @ inverse)

    def bootstrap(
        self, groups: Sequence[Sequence[int]], seed: int, resamples: int = RESAMPLES
    ) -> tuple[np.ndarray, int]:
        """Return the estimates (resamples, q) from resampled curves, and their degrees of freedom.

        From each group of n, n - 1 curves are drawn with replacement. The variance of their mean is
        then s^2/n, not (n-1)/n of that. If any group has only one curve, all curves form one group.
        """
        if min(len(g) for g in groups) < 2:
            groups = [range(self.count)]
        random = np.random.Generator(np.random.PCG64(seed))
        weight = np.zeros((resamples, self.count))
        for group in groups:
            size = len(group)
            if size < 2:
                break
            draws = random.multinomial(size - 1, np.full(size, 1 / size), size=resamples)
            weight[:, list(group)] = draws * size / (size - 1)
        totals = np.einsum("bg,gij->bij", weight, self.information)
        is_invertible = _is_invertible(totals)
        shifts = np.linalg.solve(
            totals[is_invertible], (weight[is_invertible] @ self.score)[..., None]
        )[..., 0]
        return self.estimate + shifts, max(self.count - len(groups), 0)


def _is_invertible(matrices: np.ndarray) -> np.ndarray:
    """Return which symmetric matrices (..., q, q) are invertible once their rows are scaled."""
    scale = np.sqrt(np.maximum(np.diagonal(matrices, axis1=-2, axis2=-1), 0.0))
    if scale.shape[-1] == 1:
        return np.asarray(scale[..., 0] > 0)  # scale the diagonal to one
    safe = np.where(scale > 0, scale, 1.0)
    inner = matrices / (safe[..., :, None] * safe[..., None, :])
    return np.asarray((scale > 0).all(axis=-1) & (np.linalg.cond(inner) < 1e10))


@dataclass(frozen=True, kw_only=True)
class RequiredPulls:
    """Number of further pulls under one condition that narrow an interval to a target width.

    `likely` assumes the scatter of the existing pulls. `sure` is enough with a probability of 80 %,
    given that the scatter of a few pulls is itself uncertain. None if 1000 are not enough.
    """

    condition: str
    likely: int | None
    sure: int | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Further:
    """The 95 % interval of one value, and the effect of further similar pulls on it.

    A further pull has the mean weight of the existing pulls under its condition (vacuum and speed).
    Its scatter is that of all existing pulls, with their degrees of freedom.
    """

    information: np.ndarray
    """Information of all pulls about the shared parameters, from the weights, shape (q, q)."""
    contrast: np.ndarray
    """The value as a linear combination of the parameters, shape (q,)."""
    one_more: Mapping[str, np.ndarray]
    """{condition: information of one more pull}, each of shape (q, q)."""
    scatter: float
    """Ratio of the value's relative standard deviation to the value that the weights assume."""
    degrees: float
    shared: float = 0.0
    """Relative standard uncertainty that further pulls do not reduce."""

    def half_width(
        self,
        condition: str = "",
        added_pulls: int | np.ndarray = 0,
        chance: float | None = None,
    ) -> np.ndarray:
        """Return the relative half-width of the interval with `added_pulls` under a condition.

        `added_pulls` broadcasts. With `chance`, it is the half-width not exceeded with that
        probability; otherwise further pulls are assumed to scatter like the existing ones.
        """
        count = np.asarray(added_pulls, float)
        information = self.one_more[condition] if condition else np.zeros_like(self.information)
        total_information = self.information + count[..., None, None] * information
        unit = np.linalg.solve(total_information, self.contrast[:, None])[..., 0] @ self.contrast
        total, growth = self.degrees + count, np.ones_like(count)
        if chance is not None:
            # the ratio of the variances of future and existing pulls follows F
            ratio = special.fdtri(np.maximum(count, 1.0), self.degrees, chance)
            growth = (self.degrees + count * ratio) / total
        square = self.scatter**2 * growth * unit
        whole_square = square + self.shared**2
        effective = total * (whole_square / square) ** 2  # Welch and Satterthwaite (GUM, G.4.1)
        # but not below the scatter alone, as in `coverage_factor`
        widths = [
            special.stdtrit(degrees, (1 + LEVEL) / 2) * np.sqrt(part)
            for degrees, part in ((effective, whole_square), (total, square))
        ]
        return np.maximum(*widths)

    def after_one(self) -> dict[str, float]:
        """Return {condition: half-width with one more pull under it}, narrowest first."""
        widths = {condition: float(self.half_width(condition, 1)) for condition in self.one_more}
        return dict(sorted(widths.items(), key=lambda item: item[1]))

    def required_pulls(self, target: float) -> RequiredPulls:
        """Return the number of pulls under the best condition that reach a target half-width."""
        best = next(iter(self.after_one()))

        def smallest_count(chance: float | None) -> int | None:
            enough = self.half_width(best, np.arange(PULL_LIMIT + 1), chance) <= target
            return int(enough.argmax()) if enough.any() else None

        return RequiredPulls(condition=best, likely=smallest_count(None), sure=smallest_count(SURE))


def predict_further_pulls(
    population: Population,
    contrasts: Mapping[str, np.ndarray],
    groups: Mapping[str, Sequence[int]],
    sizes: Mapping[str, float],
    common: Mapping[str, float] | None = None,
    units: Population | None = None,
) -> dict[str, Further | None]:
    """Return the effect of further pulls on each value; None if it has no interval yet.

    `groups` lists the indices of the curves of each condition. `sizes` {name: divisor of the
    interval's width} is 1 for a value whose logarithm is estimated. `common` {name: relative
    standard uncertainty} does not change with further pulls. `units` is the population of the
    mountings, if pulls share one; a further pull then has a new mounting.
    """
    information = population.information
    total = information.sum(axis=0)
    per_condition = {
        words: information[list(places)].mean(axis=0) for words, places in groups.items()
    }
    results: dict[str, Further | None] = {}
    for name, contrast in contrasts.items():
        error = (units or population).standard_error(contrast)
        if error is None or not error[0] > 0:
            results[name] = None
            continue
        unit = float(np.sqrt(contrast @ np.linalg.solve(total, contrast)))
        results[name] = Further(
            information=total,
            contrast=contrast,
            one_more=per_condition,
            scatter=error[0] / unit / abs(sizes[name]),
            degrees=error[1],
            shared=(common or {}).get(name, 0.0),
        )
    return results
