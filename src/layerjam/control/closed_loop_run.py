"""The compiled closed loop: one run of regulator, sensor and plant, sample by sample.

The regulator is the law's own text, compiled. Between samples plant and sensor are exact: with
the slope a - b v of the vacuum a sample of length T adds slope (1 - exp(-b T))/b, and a sensor of
first order shows the part of it that its lag lets through. A plant with a tube is integrated.
"""

import math
import types
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from layerjam.control import exact, law
from layerjam.control.noise import key_of, normal
from layerjam.control.through_tube import advanced
from layerjam.mechanics.compiled import stamp_of
from layerjam.mechanics.threads import once

READS, STANDS, SHOWS = 0, 1, 2
"""What the sensor does: it reads, keeps its last number, or shows a number of its own."""
Array = np.ndarray[Any, np.dtype[np.float64]]


class Chain(NamedTuple):
    """From the vacuum to a reading [Pa]."""

    highest: float
    lowest: float
    noise: float
    step: float
    offset: float


class Course(NamedTuple):
    """What happens when; counts are samples."""

    dt: float
    """Length of a sample [s]."""
    lag: float
    """Of the sensor [s]."""
    samples: int
    ends: Array
    """Sample at which each target ends; behind the last they begin again."""
    levels: Array
    """Targets [Pa]."""
    onset: int
    """Sample from which on plant and sensor are the broken ones."""
    sensor: int
    """What the broken sensor does."""
    shown: float
    """What it shows where it shows a number of its own [Pa]."""
    steady: int
    """Sample from which on steady error and ripple are taken."""


def _law() -> dict[str, Any]:
    """The law's functions compiled, by name; no rounding is changed."""
    names: dict[str, Any] = {k: v for k, v in vars(law).items() if isinstance(v, int | float)}
    helpers = (
        "moved",
        "switched",
        "safe",
        "command",
        "given",
        "expected",
        "excess",
        "pump_fault",
        "vented",
        "held",
    )
    for name in (*helpers, "detect", "step"):
        plain = types.FunctionType(getattr(law, name).__code__, names, name)
        names[name] = numba.njit(error_model="numpy", forceinline=True)(plain)
    return names


_LAW = _law()
compiled_step, compiled_detect = _LAW["step"], _LAW["detect"]
"""The law's `step` and `detect` for numba."""


factors = numba.njit(error_model="numpy", forceinline=True)(exact.factors)
"""That of `exact.py` for numba."""


@numba.njit(error_model="numpy", forceinline=True)  # type: ignore[untyped-decorator]
def _reading(shown, noise, chain):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Offset, noise, steps and range."""
    y = shown + chain.offset + chain.noise * noise
    if chain.step > 0.0:
        y = np.rint(y / chain.step) * chain.step
    return min(max(y, chain.lowest), chain.highest)


@once
def loop() -> Any:
    """The compiled loop: some seconds when its files or the law have changed, else from cache."""
    here = Path(__file__).parent
    names = ("law.py", "noise.py", "exact.py", "closed_loop_run.py", "through_tube.py")
    stamp = stamp_of(here / name for name in names)

    @numba.njit(cache=True, nogil=True, error_model="numpy")
    def run(  # type: ignore[no-untyped-def]
        key, settings, fresh, plants, chains, course, out, history
    ):  # pragma: no cover
        len(stamp)
        key = key_of(key[0], key[1])
        dt, lag, state = course.dt, course.lag, fresh
        left = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        vacuum = side = shown = reading = total = on = 0.0
        least, most, over, when = math.inf, -math.inf, -math.inf, math.nan
        low, high = math.nan, math.nan
        phase, stage, target = 0, 0, course.levels[0]
        for n in range(course.samples):
            broken = 1 if n >= course.onset else 0
            does = course.sensor if broken else READS
            if does == READS:
                chain = chains[broken]
                noise = normal(key, n) if chain.noise > 0.0 else 0.0
                reading = _reading(shown, noise, chain)
            elif does == SHOWS:
                reading = course.shown
            state, pump, vent, fault = compiled_step(settings, state, reading, target)
            if len(history) > 0:
                history[n, 0], history[n, 1] = vacuum, reading
                history[n, 2], history[n, 3] = target, pump
                history[n, 4], history[n, 5] = vent, fault
            on += abs(pump)
            if fault != 0 and when != when:
                when = n * dt
            if n >= course.steady:
                total += vacuum - target
                least, most = min(least, vacuum), max(most, vacuum)
            a, b, gain, sensed = factors(plants[broken], pump, float(vent), dt, lag, left)
            if plants[0].side > 0.0:
                b -= plants[broken].leak  # that is in the chamber
                after, side, shown = advanced(vacuum, side, shown, a, b, plants[broken], dt, lag)
            else:
                slope = a - b * vacuum
                after = vacuum + slope * gain
                if after > plants[0].top:
                    after, slope = plants[0].top, (plants[0].top - vacuum) / gain
                shown = shown + left * (vacuum - shown) + slope * sensed if lag > 0.0 else after
            if n < course.ends[0]:
                if low != low and after >= 0.1 * target:
                    low = n + (0.1 * target - vacuum) / (after - vacuum)
                if high != high and after >= 0.9 * target:
                    high = n + (0.9 * target - vacuum) / (after - vacuum)
                over = max(over, after - target)
            vacuum = after
            phase += 1
            if phase >= course.ends[stage]:
                stage += 1
                if phase >= course.ends[-1]:
                    phase, stage = 0, 0
                target = course.levels[stage]
        out[0], out[1] = (high - low) * dt, over
        out[2], out[3] = total / max(course.samples - course.steady, 1), most - least
        out[4], out[5], out[6] = on * dt, state[0][5], state[0][6]
        out[7], out[8] = state[1][13], when

    return run
