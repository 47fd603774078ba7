"""The law and its plant in closed loop: one run with its history, or thousands over the cores.

Between samples the plant and the sensor's lag are exact (`plant.py`; the lag to 1e-11 of a sample's
rise). Noise is that of `noise.py`: a run's answer depends on its seed and number alone, not on how
many others run beside it or on which core.
"""

from __future__ import annotations

import hashlib
import math
import types
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numba
import numpy as np

from layerjam.control import law
from layerjam.control.noise import key_of, normal
from layerjam.control.plant import Plant
from layerjam.control.settings import FAULTS, Regulator, validate
from layerjam.errors import QuantityError
from layerjam.fluid.line import Sensor
from layerjam.mechanics.threads import cores, shared
from layerjam.units import show

Array = np.ndarray[Any, np.dtype[np.float64]]
_INNER: dict[str, Any] = {"error_model": "numpy", "forceinline": True, "_nrt": False}
_FUSED: dict[str, Any] = {"fastmath": {"contract"}, **_INNER}
"""For the plant; the law's roundings are the same everywhere and are left alone."""
COLUMNS = (
    "rise_time", "overshoot", "steady_error", "ripple", "pump_on", "pump_switches",
    "vent_switches", "fault", "fault_time",
)  # fmt: skip
SENSOR_FAULTS = {"": 0, "nan": 1, "stuck": 2, "rail": 3, "offset": 4}


def _law() -> Any:
    """`law.step` compiled, with the functions it calls; no rounding is changed."""
    names = {k: v for k, v in vars(law).items() if isinstance(v, int | float)}
    for name in ("moved", "switched", "safe", "command", "detect", "step"):
        code = getattr(law, name).__code__
        plain = types.FunctionType(code, names, name)
        names[name] = numba.njit(**_INNER)(plain)
    return names["step"]


compiled_step = _law()
"""The law's `step` for numba."""


@numba.njit(**_FUSED)  # type: ignore[untyped-decorator]
def _decayed(x):  # type: ignore[no-untyped-def]  # pragma: no cover
    """(1 - exp(-x))/x; below 0.01, where a pump's sample lies, a series to the last digit."""
    if x > 0.01:
        return -math.expm1(-x) / x
    square = x * x  # in pairs, which do not wait for one another
    return (1.0 - 0.5 * x) + square * (
        (1.0 / 6.0 - x * (1.0 / 24.0)) + square * (1.0 / 120.0 - x * (1.0 / 720.0))
    )


@numba.njit(**_FUSED)  # type: ignore[untyped-decorator]
def _factors(plant, pump, vent, dt, lag, left):  # type: ignore[no-untyped-def]  # pragma: no cover
    """(slope's constant a, decay b, effect of a sample's first slope on v, on the sensor).

    The slope is a - b v; `left` is 1 - exp(-dt/lag).
    """
    rate, top, weight, leak, venting, back = plant
    a, b = back * pump, leak
    if pump > 0.0:
        a, b = rate * pump * top, leak + rate * pump * weight
    if vent != 0.0:
        b += venting
    gain = dt * _decayed(b * dt)
    if lag == 0.0:
        return a, b, gain, gain
    ratio = dt / lag
    d = ratio - b * dt
    if abs(d) > 1e-3:
        return a, b, gain, (ratio * gain - dt * left) * (1.0 / d)
    phi = (1.0 - left) * ratio * (math.expm1(d) / d if d != 0.0 else 1.0)
    return a, b, gain, (left - phi) / b if b > 0.0 else dt - lag * left


@numba.njit(**_INNER)  # type: ignore[untyped-decorator]
def _reading(shown, mode, wrong, held, sensor, key, n):  # type: ignore[no-untyped-def]  # pragma: no cover
    """What the sensor gives: offset, noise, range and steps, or its fault."""
    highest, lowest, noise, step, steps, offset = sensor
    y = shown + offset
    if noise > 0.0:
        y += noise * normal(key, n)
    if mode == 4:
        y += wrong
    if step > 0.0:
        y = np.rint(y * steps) * step
    y = min(max(y, lowest), highest)
    if mode == 1:
        return math.nan
    if mode == 2:
        return held
    return wrong if mode == 3 else y


def _compiled(stamp: str) -> Any:
    """The loop over runs; its cache is valid for this stamp only."""

    @numba.njit(cache=True, nogil=True, error_model="numpy")
    def many(  # type: ignore[no-untyped-def]
        first, last, seed, settings, fresh, plants, sensor, lag, dt, steps, ends, levels, onset,
        mode, wrong, steady, out, history,
    ):  # pragma: no cover  # fmt: skip
        len(stamp)
        period = ends[-1]
        left = -math.expm1(-dt / lag) if lag > 0.0 else 1.0
        for j in range(first, last):
            key, state = key_of(seed, j), fresh
            v, shown, held = 0.0, 0.0, 0.0
            pump, vent, was_pump, was_vent, was_broken = 0.0, 0, -9.0, -9, False
            a, b, gain, sensed = 0.0, 0.0, 0.0, 0.0
            phase, stage, target = 0, 0, levels[0]
            low, high, over = -1.0, -1.0, -math.inf
            total, count, least, most, on = 0.0, 0, math.inf, -math.inf, 0.0
            fault, when = 0, math.nan
            for n in range(steps):
                broken = n >= onset
                y = _reading(shown, mode if broken else 0, wrong, held, sensor, key, n)
                if not broken:
                    held = y
                state, pump, vent, code = compiled_step(settings, state, y, target)
                if code != 0 and fault == 0:
                    fault, when = code, n * dt
                if len(history) > 0:
                    history[n, 0], history[n, 1], history[n, 2] = v, y, target
                    history[n, 3], history[n, 4], history[n, 5] = pump, vent, code
                if n >= steady:
                    total += v - target
                    count += 1
                    least, most = min(least, v), max(most, v)
                on += abs(pump)
                if pump != was_pump or vent != was_vent or broken != was_broken:
                    plant = plants[1] if broken else plants[0]
                    a, b, gain, sensed = _factors(plant, pump, vent, dt, lag, left)
                    was_pump, was_vent, was_broken = pump, vent, broken
                slope, before = a - b * v, v
                shown += left * (v - shown) + slope * sensed if lag > 0.0 else 0.0
                v = min(v + slope * gain, plants[0][1])
                if lag == 0.0:
                    shown = v
                if n < ends[0]:
                    if low < 0.0 and v >= 0.1 * target:
                        low = n + (0.1 * target - before) / (v - before)
                    if high < 0.0 and v >= 0.9 * target:
                        high = n + (0.9 * target - before) / (v - before)
                    over = max(over, v - target)
                phase += 1
                if phase >= ends[stage]:
                    stage += 1
                    if phase >= period:
                        phase, stage = 0, 0
                    target = levels[stage]
            row = out[j - first] if len(history) > 0 else out[j]
            row[0] = (high - low) * dt if high >= 0.0 else math.nan
            row[1], row[2], row[3] = over, total / max(count, 1), most - least
            row[4], row[5], row[6] = on * dt, state[0][5], state[0][6]
            row[7], row[8] = fault, when

    return many


_many: list[Any] = []


def _loop() -> Any:
    """The compiled loop: some seconds when its file or the law has changed, else from the cache."""
    if not _many:
        here = Path(__file__).parent
        files = (here / "law.py", here / "noise.py", here / "closed_loop.py")
        stamp = hashlib.sha256(b"".join(f.read_bytes() for f in files)).hexdigest()
        _many.append(_compiled(stamp))
    return _many[0]


@dataclass(frozen=True, kw_only=True)
class Upset:
    """What breaks at the time `at` [s]: factors on the plant, or the sensor.

    `pump` multiplies the pump's flow, `leak` [1/s] adds to the leak, `volume` multiplies the volume
    (a blocked line leaves a small one), `vent` multiplies the vent's flow. `sensor` is one of
    "nan", "stuck", "rail" (it shows `value`), "offset" (it shows `value` too much) [Pa].
    """

    at: float = math.inf
    pump: float = 1.0
    leak: float = 0.0
    volume: float = 1.0
    vent: float = 1.0
    sensor: str = ""
    value: float = 0.0

    def on(self, plant: Plant) -> tuple[float, ...]:
        """The broken plant for the loop."""
        v = self.volume
        return (
            plant.rate * self.pump / v, plant.top, plant.weight, (plant.leak + self.leak) / v,
            plant.vent * self.vent / v, plant.backwards / v,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Runs:
    """M closed loops; arrays of shape (M,). All vacuum is the true one, not the reading."""

    rise_time: Array
    """10 to 90 % of the first target [s], NaN where not reached in its time."""
    overshoot: Array
    """Greatest vacuum less the first target, while that stands [Pa]; negative where not reached."""
    steady_error: Array
    """Mean of vacuum less target in the last part of the run [Pa]."""
    ripple: Array
    """Highest less lowest vacuum there [Pa]."""
    pump_on: Array
    """Integral of the pump's command [s]."""
    pump_switches: Array
    vent_switches: Array
    fault: Array
    """Code of the first fault, 0 = healthy; names in `settings.FAULTS`."""
    fault_time: Array
    """When it was said [s], NaN where none."""


@dataclass(frozen=True, kw_only=True)
class ClosedLoop:
    """One run: arrays of shape (N,), at the samples."""

    time: Array
    vacuum: Array
    """True [Pa]."""
    measured: Array
    """The sensor's reading [Pa]; NaN where it gave none."""
    target: Array
    pump: Array
    vent: Array
    fault: Array
    """Code at each sample."""
    rise_time: float
    overshoot: float
    steady_error: float
    ripple: float
    pump_on: float
    pump_switches: int
    vent_switches: int
    outcome: str
    """HEALTHY or the name of the fault."""
    fault_time: float


def _arguments(
    regulator: Regulator, targets: Sequence[tuple[float, float]], duration: float,
    plant: Plant | None, sensor: Sensor | None, upset: Upset, steady: float,
) -> tuple[Any, ...]:  # fmt: skip
    """What the loop takes between `fresh` and `out`; validates."""
    if not targets or min(lasting for lasting, _ in targets) <= 0:
        raise QuantityError("targets: each needs a duration of more than zero")
    validate(regulator, max(level for _, level in targets))
    if upset.sensor not in SENSOR_FAULTS:
        raise QuantityError(f"sensor: '{upset.sensor}' is no fault a sensor is given here")
    dt = regulator.sample_time
    steps = round(duration / dt)
    if steps < 1:
        raise QuantityError(f"duration: {show(duration, 's')} is less than a sample")
    real = plant or regulator.plant
    seen = sensor or regulator.sensor
    ends = np.cumsum([max(round(lasting / dt), 1) for lasting, _ in targets])
    levels = np.array([level for _, level in targets], float)
    onset = steps if math.isinf(upset.at) else math.ceil(upset.at / dt - 1e-9)
    plants = (Upset().on(real), upset.on(real))
    step = seen.resolution
    inverse = 1.0 / step if step else 0.0
    shown = (seen.range, regulator.lowest_reading, seen.noise, step, inverse, seen.offset)
    sensor_numbers = tuple(float(x) for x in shown)
    return (
        plants, sensor_numbers, float(seen.lag), dt, steps, ends, levels, onset,
        SENSOR_FAULTS[upset.sensor], float(upset.value), int(steps * (1 - steady)),
    )  # fmt: skip


def simulate(
    regulator: Regulator,
    targets: Sequence[tuple[float, float]],
    *,
    duration: float | None = None,
    plant: Plant | None = None,
    sensor: Sensor | None = None,
    upset: Upset | None = None,
    seed: int = 0,
    steady: float = 0.25,
) -> ClosedLoop:
    """One run from no vacuum, with its history.

    `targets` are pairs (duration [s], vacuum [Pa]), begun again at their end if `duration` is
    longer. `plant` and `sensor` are the true ones where they differ from what the regulator was
    told. `steady`: last part of the run over which steady error and ripple are taken.
    Raises QuantityError for what `settings.validate` refuses.
    """
    length = sum(lasting for lasting, _ in targets) if duration is None else duration
    rest = _arguments(regulator, targets, length, plant, sensor, upset or Upset(), steady)
    steps = rest[4]
    out, history = np.zeros((1, len(COLUMNS))), np.zeros((steps, 6))
    _loop()(0, 1, seed, regulator.packed(), law.fresh(), *rest, out, history)
    rise, over, error, ripple, on, pumps, vents, fault, when = (float(x) for x in out[0])
    return ClosedLoop(
        time=np.arange(steps) * regulator.sample_time, vacuum=history[:, 0],
        measured=history[:, 1], target=history[:, 2], pump=history[:, 3], vent=history[:, 4],
        fault=history[:, 5], rise_time=rise, overshoot=over, steady_error=error, ripple=ripple,
        pump_on=on, pump_switches=int(pumps), vent_switches=int(vents),
        outcome=FAULTS[int(fault)], fault_time=when,
    )  # fmt: skip


def simulate_many(
    regulator: Regulator,
    targets: Sequence[tuple[float, float]],
    *,
    runs: int,
    duration: float | None = None,
    plant: Plant | None = None,
    sensor: Sensor | None = None,
    upset: Upset | None = None,
    seed: int = 0,
    steady: float = 0.25,
) -> Runs:
    """The same `runs` times with noise of their own, over the cores; run j is stream j of `seed`.

    Raises QuantityError as `simulate` does.
    """
    length = sum(lasting for lasting, _ in targets) if duration is None else duration
    rest = _arguments(regulator, targets, length, plant, sensor, upset or Upset(), steady)
    out, none = np.zeros((runs, len(COLUMNS))), np.zeros((0, 6))
    packed = regulator.packed()

    def some(first: int, last: int) -> None:
        _loop()(first, last, seed, packed, law.fresh(), *rest, out, none)

    some(0, 0)
    with ThreadPoolExecutor(cores()) as pool:
        shared(pool, runs, some)
    return Runs(**dict(zip(COLUMNS, out.T, strict=True)))
