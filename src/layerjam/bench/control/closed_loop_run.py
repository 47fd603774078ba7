"""The closed loop: one run of controller, sensor and plant, sample by sample.

The loop and all that it calls are printed as C (`tests/c_printers`). Without a C compiler the same
text runs in Python (`engine.py`). Between samples, plant and sensor are solved exactly. At a slope
a - b v of the vacuum, a sample of length T adds slope (1 - exp(-b T))/b. A first-order sensor shows
the fraction that its lag passes. A tube requires numerical integration.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from layerjam.bench.control.exact import Rates, step_factors
from layerjam.bench.control.law import fresh, step
from layerjam.bench.control.noise import Layers, Word, normal
from layerjam.bench.control.sample import advance_plant

READS, STANDS, SHOWS = 0, 1, 2
"""States of the sensor: it works, repeats its last value, or returns a fixed value."""
Array = np.ndarray[Any, np.dtype[np.float64]]


class Chain(NamedTuple):
    """Measuring chain from the vacuum to a reading [Pa]."""

    highest: float
    lowest: float
    noise: float
    step: float
    offset: float


class Course(NamedTuple):
    """Schedule of a run; counts are in samples."""

    dt: float
    """Duration of a sample [s]."""
    lag: float
    """Lag of the sensor [s]."""
    samples: int
    stages: int
    """Number of targets."""
    ends: Sequence[int]
    """Sample at which each target ends; after the last target they repeat from the first."""
    levels: Sequence[float]
    """Targets [Pa]."""
    onset: int
    """Sample from which the injected fault affects the plant and the sensor."""
    sensor: int
    """State of the broken sensor."""
    shown: float
    """Value that a broken sensor shows [Pa]."""
    steady: int
    """First sample included in the steady error and the ripple."""


def read_sensor(value: float, noise: float, chain: Chain) -> float:
    """Return the reading [Pa] of a vacuum [Pa], with a standard normal number as noise."""
    y = value + chain.offset + chain.noise * noise
    if chain.step > 0.0:
        y = round(y / chain.step) * chain.step
    return min(max(y, chain.lowest), chain.highest)


def find_crossing(sample: int, level: float, before: float, after: float) -> float:
    """Return the time [samples] at which a vacuum that rises during a sample crosses a level."""
    rise = after - before
    return sample + (level - before) / rise if rise != 0.0 else math.nan


def run_loop(
    key: Word,
    settings: tuple[tuple[float, ...], tuple[float, ...]],
    plants: Sequence[Rates],
    chains: Sequence[Chain],
    course: Course,
    layers: Layers,
    out: Array,
    rows: int,
    history: Array,
) -> None:
    """Write the numbers of one run to `out`, and its first `rows` samples to `history`.

    `plants` and `chains` are those before and after the fault. The numbers are the fields of
    `closed_loop.Runs`; a sample has six numbers, see `closed_loop.ClosedLoop`.
    """
    dt, lag = course.dt, course.lag
    lag_gain = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
    vacuum = side = gauge = reading = total = pump_time = 0.0
    lowest, highest, overshoot, fault_time = math.inf, -math.inf, -math.inf, math.nan
    low, high = math.nan, math.nan
    phase, stage, target = 0, 0, course.levels[0]
    state = fresh()
    for n in range(course.samples):
        case = 1 if n >= course.onset else 0
        does = course.sensor if case == 1 else READS
        if does == READS:
            chain = chains[case]
            noise = normal(key, n, layers) if chain.noise > 0.0 else 0.0
            reading = read_sensor(gauge, noise, chain)
        elif does == SHOWS:
            reading = course.shown
        state, pump, vent, fault = step(settings, state, reading, target)
        if n < rows:
            history[6 * n], history[6 * n + 1] = vacuum, reading
            history[6 * n + 2], history[6 * n + 3] = target, pump
            history[6 * n + 4], history[6 * n + 5] = vent, fault
        pump_time += abs(pump)
        if fault != 0 and fault_time != fault_time:
            fault_time = n * dt
        if n >= course.steady:
            total += vacuum - target
            lowest, highest = min(lowest, vacuum), max(highest, vacuum)
        factors = step_factors(plants[case], pump, float(vent), dt, lag, lag_gain)
        vacuum_after, side, gauge = advance_plant(
            vacuum, side, gauge, factors, plants[case], dt, lag, lag_gain
        )
        if n < course.ends[0]:
            if low != low and vacuum_after >= 0.1 * target:
                low = find_crossing(n, 0.1 * target, vacuum, vacuum_after)
            if high != high and vacuum_after >= 0.9 * target:
                high = find_crossing(n, 0.9 * target, vacuum, vacuum_after)
            overshoot = max(overshoot, vacuum_after - target)
        vacuum = vacuum_after
        phase += 1
        if phase >= course.ends[stage]:
            stage += 1
            if stage == course.stages:
                phase, stage = 0, 0
            target = course.levels[stage]
    drive, memory = state
    out[0], out[1] = (high - low) * dt, overshoot
    out[2], out[3] = total / max(course.samples - course.steady, 1), highest - lowest
    out[4], out[5], out[6] = pump_time * dt, drive[5], drive[6]
    out[7], out[8] = memory[13], fault_time
