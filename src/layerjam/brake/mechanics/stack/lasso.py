"""One increment of the stack: a weighted one-dimensional fused lasso, solved exactly.

The loops of this folder are printed in C by `tests/c_printers`. Python runs them, much more
slowly, on machines without the compiled kernel.
"""

from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]


class Knots(NamedTuple):
    """Knots of the derivative of the cost, from the left and from the right; n sheets."""

    place: Array
    """(2 n,) positions of the knots."""
    slope: Array
    """(2 n,) change of the slope at each knot."""
    level: Array
    """(2 n,) change of the level at each knot."""
    low: Array
    """(n,) lowest z of each sheet."""
    high: Array
    """(n,) highest z of each sheet."""


def fused_lasso(n: int, d: Array, b: Array, c: Array, z: Array, knots: Knots) -> None:
    """Find z minimising 1/2 sum d (z - b)^2 + sum c |z_{i+1} - z_i|, exactly, for n sheets.

    Dynamic programming over the derivative of the cost (Johnson 2013). The cost of z_i over all
    terms to its left has a piecewise linear derivative. An interface clips this derivative to its
    bound, the box of the dual variable f_i, which adds two knots. Each knot is visited once, so the
    time is linear.
    """
    x, slope, level, low, high = knots.place, knots.slope, knots.level, knots.low, knots.high
    left, right = n - 1, n
    low[0], high[0] = b[0] - c[0] / d[0], b[0] + c[0] / d[0]
    x[left], x[right] = low[0], high[0]
    slope[left], level[left] = d[0], -d[0] * b[0] + c[0]
    slope[right], level[right] = -d[0], d[0] * b[0] + c[0]
    for k in range(1, n):
        first_slope, first_level = d[k], -d[k] * b[k] - c[k - 1]
        last_slope, last_level = -d[k], d[k] * b[k] - c[k - 1]
        bound = c[k] if k < n - 1 else 0.0
        i = left
        while i <= right and first_slope * x[i] + first_level <= -bound:
            first_slope += slope[i]
            first_level += level[i]
            i += 1
        if k == n - 1:
            z[k] = -first_level / first_slope
            break
        j = right
        while j >= i and -last_slope * x[j] - last_level >= bound:
            last_slope += slope[j]
            last_level += level[j]
            j -= 1
        low[k] = (-bound - first_level) / first_slope
        high[k] = -(bound + last_level) / last_slope
        left, right = i - 1, j + 1
        x[left], slope[left], level[left] = low[k], first_slope, first_level + bound
        x[right], slope[right], level[right] = high[k], last_slope, last_level + bound
    for k in range(n - 2, -1, -1):
        z[k] = min(max(z[k + 1], low[k]), high[k])
