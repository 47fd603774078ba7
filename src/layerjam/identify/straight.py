"""Straight lines through samples: slope, its standard error and crossings."""

from typing import NamedTuple

import numpy as np

from layerjam.measure.trace import Array


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
