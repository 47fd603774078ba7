"""Intervals from repeats: noise within a curve says nothing about how well it repeats.

A curve is a cluster: its thousands of samples share one mounting, one friction, one slack. All
intervals here rest on the scatter between curves, with Student's t for how few they are. A
percentile bootstrap of three repeats covers 74 % where it says 95 %; it is not offered.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from layerjam.identify.repeats import LEVEL, interval_ends

RESAMPLES = 2000


def quantile(degrees: float, level: float = LEVEL) -> float:
    """Student's t that a share `level` lies within, either side."""
    return float(special.stdtrit(degrees, (1 + level) / 2))


def combine(parts: Iterable[tuple[float, float]]) -> tuple[float, float]:
    """Return the combined standard uncertainty and its effective degrees of freedom.

    `parts` are (standard uncertainty, degrees of freedom) of independent contributions in one unit:
    the root of the sum of squares (GUM, 5.1.2) and Welch and Satterthwaite's formula (GUM, annex
    G.4.1), not truncated. The degrees are infinite if every contribution is known exactly.
    """
    known = list(parts)
    whole = math.fsum(u**2 for u, _ in known)
    if whole == 0:
        return 0.0, min((degrees for _, degrees in known), default=math.inf)
    shared = math.fsum((u**2 / whole) ** 2 / degrees for u, degrees in known)
    return math.sqrt(whole), 1 / shared if shared > 0 else math.inf


def coverage_factor(parts: Sequence[tuple[float, float]]) -> float:
    """Return the expanded (95 %) over the combined standard uncertainty of what `combine` takes.

    Student's quantile for the effective degrees of freedom (GUM, annex G.4.1). It is at least so
    large that the expanded uncertainty is not below that of a contribution alone: with one or two
    degrees of freedom Welch and Satterthwaite's formula else rewards a further contribution.
    """
    whole, degrees = combine(parts)
    alone = [quantile(own) * u / whole for u, own in parts if u > 0]
    return max([quantile(degrees), *alone])


@dataclass(frozen=True, kw_only=True)
class Interval:
    """A 95 % interval with its standard error, degrees of freedom and how it was found.

    `coverage_factor` is half of its width over the standard error, if both are small.
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
    ) -> Interval:
        """Return Student's t about a value whose standard uncertainty `combine` makes of `parts`.

        That of a `positive` value is symmetric about its logarithm, so that it never reaches zero.
        """
        error, degrees = combine(parts)
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
        """Half of it, in the value's unit."""
        return (self.high - self.low) / 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Population:
    """What many curves say of the parameters they share, as a linear model of the curves' own.

    Each curve gives a few numbers that scatter about `design` (curves, r, q) times the shared
    `estimate` (q,), by `residual` (curves, r); both are divided by the standard deviation that the
    weights assume, so that the estimate is ordinary least squares. The weights are a working guess:
    they decide how well the curves are used, not whether intervals are right, which rest on how the
    residuals scatter from curve to curve.
    """

    estimate: np.ndarray
    design: np.ndarray
    residual: np.ndarray

    @property
    def count(self) -> int:
        """Curves."""
        return len(self.residual)

    def joined(self, groups: Sequence[Sequence[int]]) -> Population:
        """Return the population with the curves (their places) of each group as one curve.

        The estimate stays; intervals then rest on the scatter between groups, whatever curves of
        one group share (rows that fill up shorter groups are zero).
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
        """Of each curve about the shared parameters (curves, q, q)."""
        return np.einsum("gri,grj->gij", self.design, self.design)

    @property
    def score(self) -> np.ndarray:
        """Where each curve pulls the estimate (curves, q); their sum is zero."""
        return np.einsum("gri,gr->gi", self.design, self.residual)

    def shift(self, left_out: Sequence[int]) -> np.ndarray | None:
        """How the estimate moves (q,) without these curves; None where the rest cannot tell it."""
        out = list(left_out)
        rest = np.delete(self.information, out, axis=0).sum(axis=0)
        if not _regular(rest):
            return None
        return -np.linalg.solve(rest, self.score[out].sum(axis=0))

    def _adjusted(self) -> np.ndarray | None:
        """(I - H)^(-1/2) times the design of each curve, H its own leverage; None if that is 1."""
        information = self.information
        whole = information.sum(axis=0)
        if self.count < 2 or not _regular(whole):
            return None
        if not _regular(whole - information).all():
            return None
        own = self.design @ np.linalg.solve(whole, np.swapaxes(self.design, 1, 2))
        free, axes = np.linalg.eigh(np.eye(own.shape[1]) - own)
        root = axes / np.sqrt(np.maximum(free, 1e-12))[:, None, :] @ np.swapaxes(axes, 1, 2)
        return root @ self.design

    def standard_error(self, contrast: np.ndarray) -> tuple[float, float] | None:
        """Standard error of a linear combination (q,) of the estimate, and degrees of freedom.

        The sandwich over curves with residuals grown for their leverage (CR2), unbiased if curves
        scatter as the weights assume, with Satterthwaite's degrees of freedom under the same
        assumption (Bell and McCaffrey 2002; Pustejovsky and Tipton 2018). For curves that all weigh
        alike this is Student's t of their mean. None where a single curve carries the answer.
        """
        adjusted = self._adjusted()
        if adjusted is None:
            return None
        whole = self.information.sum(axis=0)
        lever = adjusted @ np.linalg.solve(whole, contrast)
        moves = np.einsum("gr,gr->g", lever, self.residual)
        pull = np.einsum("gri,gr->gi", self.design, lever)
        product = np.diag((lever**2).sum(axis=1)) - pull @ np.linalg.solve(whole, pull.T)
        square = float((product**2).sum())
        if not square > 0:
            return None
        degrees = float(np.trace(product)) ** 2 / square
        return float(np.sqrt((moves**2).sum())), round(degrees, 12)  # n - 1 comes out whole

    def covariance(self) -> np.ndarray:
        """Of the estimate (q, q), the same sandwich; NaN where it cannot be had."""
        adjusted = self._adjusted()
        size = len(self.estimate)
        if adjusted is None:
            return np.full((size, size), np.nan)
        moves = np.einsum("gri,gr->gi", adjusted, self.residual)
        whole = np.linalg.inv(self.information.sum(axis=0))
        return np.asarray(whole @ (moves.T @ moves) @ whole)

    def bootstrap(
        self, groups: Sequence[Sequence[int]], seed: int, resamples: int = RESAMPLES
    ) -> tuple[np.ndarray, int]:
        """Estimates (resamples, q) of resampled curves, and degrees of freedom.

        Within each group one curve fewer is drawn than it has, with replacement, so that the
        scatter of a mean over n comes out as s^2/n and not as (n-1)/n of it. Groups of one curve
        cannot be resampled: then all curves form one group.
        """
        if min(len(g) for g in groups) < 2:
            groups = [range(self.count)]
        random = np.random.Generator(np.random.PCG64(seed))
        weight = np.zeros((resamples, self.count))
        for group in groups:
            size = len(group)
            if size < 2:
                break
            drawn = random.multinomial(size - 1, np.full(size, 1 / size), size=resamples)
            weight[:, list(group)] = drawn * size / (size - 1)
        whole = np.einsum("bg,gij->bij", weight, self.information)
        fine = _regular(whole)
        moves = np.linalg.solve(whole[fine], (weight[fine] @ self.score)[..., None])[..., 0]
        return self.estimate + moves, max(self.count - len(groups), 0)


def _regular(matrices: np.ndarray) -> np.ndarray:
    """Which symmetric matrices (..., q, q) can be inverted, rows brought to one scale first."""
    scale = np.sqrt(np.maximum(np.diagonal(matrices, axis1=-2, axis2=-1), 0.0))
    if scale.shape[-1] == 1:
        return np.asarray(scale[..., 0] > 0)  # one row in its own scale is 1
    safe = np.where(scale > 0, scale, 1.0)
    inner = matrices / (safe[..., :, None] * safe[..., None, :])
    return np.asarray((scale > 0).all(axis=-1) & (np.linalg.cond(inner) < 1e10))
