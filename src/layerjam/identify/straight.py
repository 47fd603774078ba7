"""Straight lines through samples: slope, its standard error, and where the line meets a value."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from layerjam.measure.trace import Array


class StraightLine(NamedTuple):
    """A least-squares line through N points, in their own units.

    It passes through the points' mean (`x`, `y`); `slope_se` rests on their scatter about the line
    with `freedom` = N - 2, and is 0 for fewer than three points.
    """

    slope: float
    slope_se: float
    x: float
    y: float
    freedom: int

    def at(self, x: float) -> float:
        """The line's value at `x`."""
        return self.y + self.slope * (x - self.x)

    def meets(self, y: float) -> float:
        """Where the line has the value `y`."""
        return self.x + (y - self.y) / self.slope


def straight_line(x: Array, y: Array) -> StraightLine | None:
    """The line through points, arrays of shape (N,); None where x does not vary."""
    if len(x) < 2 or not np.ptp(x) > 0:
        return None
    mean_x, mean_y = float(x.mean()), float(y.mean())
    run = x - mean_x
    spread = float(run @ run)
    slope = float(run @ (y - mean_y)) / spread
    rest = y - mean_y - slope * run
    freedom = len(x) - 2
    error = float(np.sqrt(rest @ rest / freedom / spread)) if freedom > 0 else 0.0
    return StraightLine(slope, error, mean_x, mean_y, freedom)
