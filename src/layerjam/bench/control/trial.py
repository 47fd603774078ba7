"""Trial of the detectors: a pump at full command until they report a fault."""

import math

from layerjam.bench.control.exact import Rates, step_factors
from layerjam.bench.control.law import detect
from layerjam.bench.control.sample import advance_plant

LONG_AGO = 1e9
"""Samples since pump and vent last switched, as in `law.fresh`."""


def run_trial(
    plant: Rates,
    watch: tuple[float, ...],
    memory: tuple[float, ...],
    vacuum: float,
    side: float,
    gauge: float,
    dt: float,
    lag: float,
    steps: int,
    offset: float,
) -> tuple[float, float]:
    """Return (number of the sample with the first report, its fault code); zeros if there is none.

    Vacuums of chamber, side and sensor [Pa] are those at the fault. `offset` [Pa] is added to the
    sensor's reading.
    """
    drive = (0.0, 1.0, 0.0, LONG_AGO, LONG_AGO, 0.0, 0.0, 0.0)
    lag_gain = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
    factors = step_factors(plant, 1.0, 0.0, dt, lag, lag_gain)
    for n in range(steps):
        vacuum, side, gauge = advance_plant(vacuum, side, gauge, factors, plant, dt, lag, lag_gain)
        fault, _reading, memory = detect(watch, memory, drive, gauge + offset, 0.0)
        if fault != 0.0:
            return n + 1.0, fault
    return 0.0, 0.0
