"""Search for the lowest vacuum that is sufficient, and the margin of a safe vacuum."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
MARGIN = 0.02
"""Relative errors of mass, speed and vacuum that a safe vacuum must tolerate."""
LEVELS, GRID = 7, 65
"""Rounds of the search for the lowest vacuum, and vacuums tried in each: accurate to 2e-13 of the
range.
"""


def find_least_vacuum(stops: Callable[[Array], Any], atmosphere: float) -> float | None:
    """Return the lowest vacuum [Pa] up to `atmosphere` for which `stops` is true, or None."""
    low, high = 0.0, atmosphere
    for _ in range(LEVELS):
        vacuums = np.linspace(low, high, GRID)
        good = stops(vacuums)
        if not good.any():
            return None
        first = int(np.argmax(good))
        if first == 0:
            return float(vacuums[0])
        low, high = float(vacuums[first - 1]), float(vacuums[first])
    return high
