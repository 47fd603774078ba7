"""The compiled closed loop: one run of controller, sensor and plant, sample by sample.

The controller is the law's own source text, compiled. Between samples, plant and sensor are solved
exactly. At a slope a - b v of the vacuum, a sample of length T adds slope (1 - exp(-b T))/b. A
first-order sensor shows the fraction that its lag passes. A tube requires numerical integration.
"""

import math
import types
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from layerjam.control import exact, law
from layerjam.control.noise import make_key, normal
from layerjam.control.through_tube import advance
from layerjam.mechanics.compilation import compile_loop, hash_files
from layerjam.mechanics.threads import cache_threadsafe

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
    ends: Array
    """Sample at which each target ends; after the last target they repeat from the first."""
    levels: Array
    """Targets [Pa]."""
    onset: int
    """Sample from which the injected fault affects the plant and the sensor."""
    sensor: int
    """State of the broken sensor."""
    shown: float
    """Value that a broken sensor shows [Pa]."""
    steady: int
    """First sample included in the steady error and the ripple."""


def _compile_law() -> dict[str, Any]:
    """Return the compiled functions of the law, by name, without any change of rounding."""
    names: dict[str, Any] = {k: v for k, v in vars(law).items() if isinstance(v, int | float)}
    helpers = (
        "move_drive",
        "switch_pump",
        "make_safe_drive",
        "compute_drive",
        "healthy_rise",
        "healthy_rises",
        "update_surplus",
        "check_pump",
        "watch_vent",
        "watch_target",
    )
    for name in (*helpers, "detect", "step"):
        plain = types.FunctionType(getattr(law, name).__code__, names, name)
        names[name] = numba.njit(error_model="numpy", forceinline=True)(plain)
    return names


_LAW = _compile_law()
compiled_step, compiled_detect = _LAW["step"], _LAW["detect"]
"""The law's `step` and `detect`, compiled by numba."""


factors = numba.njit(error_model="numpy", forceinline=True)(exact.step_factors)
"""`factors` of `exact.py`, compiled by numba."""


@numba.njit(error_model="numpy", forceinline=True)  # type: ignore[untyped-decorator]
def _read_sensor(value, noise, chain):  # type: ignore[no-untyped-def]  # pragma: no cover
    y = value + chain.offset + chain.noise * noise
    if chain.step > 0.0:
        y = np.rint(y / chain.step) * chain.step
    return min(max(y, chain.lowest), chain.highest)


@cache_threadsafe
def compile_loop_of_runs() -> Any:
    """Return the compiled loop, which is cached; a changed law takes a few seconds to compile."""
    folder = Path(__file__).parent
    names = ("law.py", "noise.py", "exact.py", "closed_loop_run.py", "through_tube.py")
    stamp = hash_files(folder / name for name in names)

    @compile_loop(nogil=True, error_model="numpy")
    def run_loop(  # type: ignore[no-untyped-def]
        key, settings, fresh, plants, chains, course, out, history
    ):  # pragma: no cover
        len(stamp)
        key = make_key(key[0], key[1])
        dt, lag, state = course.dt, course.lag, fresh
        left = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        vacuum = side = gauge = reading = total = pump_time = 0.0
        least, greatest, overshoot, fault_time = math.inf, -math.inf, -math.inf, math.nan
        low, high = math.nan, math.nan
        phase, stage, target = 0, 0, course.levels[0]
        for n in range(course.samples):
            case = 1 if n >= course.onset else 0
            does = course.sensor if case else READS
            if does == READS:
                chain = chains[case]
                noise = normal(key, n) if chain.noise > 0.0 else 0.0
                reading = _read_sensor(gauge, noise, chain)
            elif does == SHOWS:
                reading = course.shown
            state, pump, vent, fault = compiled_step(settings, state, reading, target)
            if len(history) > 0:
                history[n, 0], history[n, 1] = vacuum, reading
                history[n, 2], history[n, 3] = target, pump
                history[n, 4], history[n, 5] = vent, fault
            pump_time += abs(pump)
            if fault != 0 and fault_time != fault_time:
                fault_time = n * dt
            if n >= course.steady:
                total += vacuum - target
                least, greatest = min(least, vacuum), max(greatest, vacuum)
            a, b, gain, effect = factors(plants[case], pump, float(vent), dt, lag, left)
            if plants[0].side > 0.0:
                b -= plants[case].leak  # this is the vacuum in the chamber
                after, side, gauge = advance(vacuum, side, gauge, a, b, plants[case], dt, lag)
            else:
                slope = a - b * vacuum
                after = vacuum + slope * gain
                if after > plants[0].top:
                    after, slope = plants[0].top, (plants[0].top - vacuum) / gain
                gauge = gauge + left * (vacuum - gauge) + slope * effect if lag > 0.0 else after
            if n < course.ends[0]:
                if low != low and after >= 0.1 * target:
                    low = n + (0.1 * target - vacuum) / (after - vacuum)
                if high != high and after >= 0.9 * target:
                    high = n + (0.9 * target - vacuum) / (after - vacuum)
                overshoot = max(overshoot, after - target)
            vacuum = after
            phase += 1
            if phase >= course.ends[stage]:
                stage += 1
                if phase >= course.ends[-1]:
                    phase, stage = 0, 0
                target = course.levels[stage]
        out[0], out[1] = (high - low) * dt, overshoot
        out[2], out[3] = total / max(course.samples - course.steady, 1), greatest - least
        out[4], out[5], out[6] = pump_time * dt, state[0][5], state[0][6]
        out[7], out[8] = state[1][13], fault_time

    return run_loop
