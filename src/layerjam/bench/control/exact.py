"""Exact solution of the plant between two samples.

The closed loops, which are printed as C, and a virtual board use the same source text.
"""

import math
from typing import NamedTuple


class Rates(NamedTuple):
    """Parameters of the plant for the loop; see `plant`."""

    rate: float
    top: float
    weight: float
    leak: float
    vent: float
    backwards: float
    side: float = 0.0
    """Ratio of the tube's gas volume to the chamber's volume; 0 if there is no tube."""
    passes: float = 0.0
    atmosphere: float = 0.0


def step_factors(
    plant: Rates, pump: float, vent: float, dt: float, lag: float, left: float
) -> tuple[float, float, float, float]:
    """Return (a, b, and the changes of v and of the sensor per unit of the first slope a - b v).

    `left` is 1 - exp(-dt/lag).
    """
    a = plant.rate * pump * plant.top if pump > 0.0 else plant.backwards * pump
    b = plant.leak + plant.rate * plant.weight * max(pump, 0.0) + plant.vent * vent
    x = b * dt
    # (1 - exp(-x))/x; with the vent closed, the series is exact to the last digit
    series = 1.0 / 24.0 - x * (1.0 / 120.0 - x * (1.0 / 720.0))
    series = 1.0 - x * (1.0 / 2.0 - x * (1.0 / 6.0 - x * series))
    gain = dt * (series if x < 0.01 else -math.expm1(-x) / x)
    if lag == 0.0:
        return a, b, gain, gain
    ratio = dt / lag
    d = ratio - x
    if abs(d) > 1e-3:
        return a, b, gain, (ratio * gain - dt * left) / d
    # if plant and sensor have the same rate, the singularity is removable
    phi = (1.0 - left) * ratio * (1.0 + d * (0.5 + d * (1.0 / 6.0 + d * (1.0 / 24.0))))
    return a, b, gain, (left - phi) / b if b > 0.0 else dt - lag * left
