"""Ageing of static friction, from pulls after hold times of different lengths.

A straight line is fitted to static friction versus the logarithm of the hold time, with one point
per pull. The scatter of the points about the line sets the intervals (Student's t, N - 2).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.core.brief import brief
from layerjam.core.errors import FitError, Notice, count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.statistics import LEVEL, fit_line, interval_ends
from layerjam.laboratory.measure.trace import Array

FEWEST = 4
NARROW = 10.0
"""Ratio of longest to shortest hold below which the slope per decade is an extrapolation."""


@brief
@dataclass(frozen=True, kw_only=True)
class AgeingFit:
    """Static friction [-] at a hold time [s], its growth per decade of time, and 95 % intervals.

    The line was fitted to `holds` [s] and `values` [-]; `sd` is the scatter about the line.
    """

    hold: float
    static: float
    static_interval: tuple[float, float]
    ageing: float
    ageing_interval: tuple[float, float]
    sd: float
    holds: Array
    values: Array
    warnings: tuple[Notice, ...]

    def static_at(self, hold: Array) -> Array:
        """Return the fitted static friction [-] at hold times [s]."""
        return np.asarray(self.static + self.ageing * np.log10(hold / self.hold))


def fit_ageing(
    holds: Sequence[float], statics: Sequence[float], hold: float | None = None
) -> AgeingFit:
    """Fit a line to static friction [-] versus hold time [s]; evaluate it at `hold` [s].

    `hold` defaults to the geometric mean of the hold times. Raises FitError for fewer than four
    pulls, or if all hold times are identical.
    """
    from scipy.special import stdtrit

    lengths, values = np.asarray(holds, float), np.asarray(statics, float)
    if len(lengths) < FEWEST:
        raise FitError(f"ageing: {count_text(len(lengths), 'pull')}; at least {FEWEST} are needed")
    if not (lengths > 0).all():
        raise FitError("ageing: holds must be longer than zero")
    decades = np.log10(lengths)
    line = fit_line(decades, values)
    if line is None:
        raise FitError(
            f"ageing: every pull follows a hold of {show(float(lengths[0]), 's')}; use "
            "holds of different lengths"
        )
    decade = line.x if hold is None else math.log10(hold)
    spread = float(np.sum((decades - line.x) ** 2))
    sd = line.slope_se * math.sqrt(spread)
    t_factor = float(stdtrit(line.freedom, 0.5 + LEVEL / 2))
    level = t_factor * sd * math.sqrt(1 / len(lengths) + (decade - line.x) ** 2 / spread)
    half_width = t_factor * line.slope_se
    static = line.value_at(decade)
    fit = AgeingFit(
        hold=10**decade,
        static=static,
        static_interval=interval_ends(static, level),
        ageing=line.slope,
        ageing_interval=(line.slope - half_width, line.slope + half_width),
        sd=sd,
        holds=lengths,
        values=values,
        warnings=(),
    )
    return AgeingFit(**{**vars(fit), "warnings": tuple(_line_notices(fit, decades))})


def _line_notices(fit: AgeingFit, decades: Array) -> Iterator[Notice]:
    low, high = fit.ageing_interval
    if low <= 0 <= high:
        yield Notice("the ageing interval contains zero: these pulls show no ageing", "no-ageing")
    if fit.holds.max() < NARROW * fit.holds.min():
        yield Notice(
            f"the holds cover only {show(float(fit.holds.min()), 's')} to "
            f"{show(float(fit.holds.max()), 's')}; also use holds ten times "
            "longer",
            "narrow-holds",
        )
    if not fit.holds.min() <= fit.hold <= fit.holds.max():
        yield Notice(
            f"a hold of {show(fit.hold, 's')} lies outside the measured holds",
            "hold-outside",
        )
    if _is_bent(fit, decades):
        yield Notice(
            "static friction is not linear in the logarithm of the hold; the line is "
            "an average within the measured holds and a guess outside them",
            "not-logarithmic",
        )


def _is_bent(fit: AgeingFit, decades: Array) -> bool:
    """Return whether a parabola fits significantly better, at the 5 % level."""
    from scipy.special import stdtrit

    freedom = len(decades) - 3
    if freedom < 1 or len(np.unique(decades)) < 3:
        return False
    rows = np.stack([np.ones_like(decades), decades, decades**2], axis=1)
    root, upper = np.linalg.qr(rows)
    parabola = np.linalg.solve(upper, root.T @ fit.values)
    residuals = fit.values - rows @ parabola
    error = math.sqrt(float(residuals @ residuals) / freedom) * abs(1 / float(upper[2, 2]))
    return abs(float(parabola[2])) > float(stdtrit(freedom, 0.975)) * error
