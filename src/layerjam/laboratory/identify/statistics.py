"""Means over repeats with 95 % intervals, and straight lines through samples.

The unit of an interval is the repeat, not the sample.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import NamedTuple

import numpy as np

from layerjam.laboratory.measure.trace import Array

LEVEL = 0.95
COVERAGE = 1.96
"""Coverage factor of a normal distribution at that level."""


@dataclass(frozen=True, kw_only=True)
class OverRepeats:
    """Statistics of `repeats` values of one quantity, in its unit.

    `sd` is the sample standard deviation. `low` and `high` are the mean's 95 % limits, by Student's
    t with `repeats` - 1 degrees of freedom. Except `mean`, all are None for one repeat.
    """

    mean: float
    sd: float | None
    standard_error: float | None
    low: float | None
    high: float | None
    repeats: int

    def describe_interval(self) -> str:
        """Return the interval as text."""
        if self.low is None or self.high is None:
            return "one repeat"
        return f"95 % interval {self.low:.4g} to {self.high:.4g} (t, {self.repeats} repeats)"

    interval_words = describe_interval  # former name

    def as_dict(self) -> dict[str, float | int | None]:
        """Return the fields by name, for JSON."""
        return asdict(self) | {"level": LEVEL}


def interval_ends(value: float, reach: float, positive: bool = True) -> tuple[float, float]:
    """Return the ends of an interval that extends by `reach` on either side of a value.

    The interval of a positive quantity is symmetric about the value's logarithm, so that it never
    reaches zero; if `reach` is small, the two forms agree. For a negative value, such as an outward
    flow, the absolute value is used.
    """
    if not positive or value == 0:
        return value - reach, value + reach
    spread = math.exp(min(reach / abs(value), 500.0))
    low, high = sorted((value / spread, value * spread))
    return low, high


def summarise_repeats(
    values: Sequence[float], positive: bool = True, limit: float = 0.0
) -> OverRepeats:
    """Return mean, SD, standard error and 95 % t interval of at least one value, one per repeat.

    `positive` means that the quantity cannot be negative. `limit` is the largest error that all
    repeats share, such as half of an instrument's step. It is a rectangular distribution of that
    half-width (GUM 4.3.7) and is added in quadrature.
    """
    from scipy.special import stdtrit

    numbers = np.asarray(values, float)
    mean, count = float(numbers.mean()), len(numbers)
    if count < 2:
        return OverRepeats(
            mean=mean, sd=None, standard_error=None, low=None, high=None, repeats=count
        )
    sd = float(numbers.std(ddof=1))
    error = sd / count**0.5
    half_width = math.hypot(
        float(stdtrit(count - 1, 0.5 + LEVEL / 2)) * error, COVERAGE * limit / math.sqrt(3)
    )
    low, high = interval_ends(mean, half_width, positive)
    return OverRepeats(mean=mean, sd=sd, standard_error=error, low=low, high=high, repeats=count)


class StraightLine(NamedTuple):
    """Least-squares line through N points, in the units of the points.

    It passes through the mean of the points (`x`, `y`). `slope_se` is from their scatter about the
    line with `freedom` = N - 2, and is 0 for fewer than three points.
    """

    slope: float
    slope_se: float
    x: float
    y: float
    freedom: int

    def value_at(self, x: float) -> float:
        """Return the line's value at `x`."""
        return self.y + self.slope * (x - self.x)

    def meets(self, y: float) -> float:
        """Return the x at which the line has the value `y`."""
        return self.x + (y - self.y) / self.slope


def fit_line(x: Array, y: Array) -> StraightLine | None:
    """Return the line through points, arrays of shape (N,); None if x does not vary."""
    if len(x) < 2 or not np.ptp(x) > 0:
        return None
    mean_x, mean_y = float(x.mean()), float(y.mean())
    offsets = x - mean_x
    spread = float(offsets @ offsets)
    slope = float(offsets @ (y - mean_y)) / spread
    residuals = y - mean_y - slope * offsets
    freedom = len(x) - 2
    error = float(np.sqrt(residuals @ residuals / freedom / spread)) if freedom > 0 else 0.0
    return StraightLine(slope, error, mean_x, mean_y, freedom)
