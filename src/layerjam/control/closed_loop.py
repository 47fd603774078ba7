"""The law and its plant in closed loop: one run with its history, or thousands over the cores.

Between samples the plant and the sensor's lag are exact (`plant.py`; the lag to 1e-11 of a sample's
rise). Noise is that of `noise.py`: a run's answer depends on its seed and number alone, not on how
many others run beside it or on which core.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.control import law
from layerjam.control.closed_loop_lanes import READS, SHOWS, STANDS, loop
from layerjam.control.noise import LANES
from layerjam.control.plant import Plant
from layerjam.control.settings import FAULTS, Regulator, validate
from layerjam.errors import QuantityError
from layerjam.fluid.line import Sensor
from layerjam.mechanics.threads import cores
from layerjam.units import show

Array = np.ndarray[Any, np.dtype[np.float64]]
COLUMNS = (
    "rise_time", "overshoot", "steady_error", "ripple", "pump_on", "pump_switches",
    "vent_switches", "fault", "fault_time",
)  # fmt: skip
SENSOR_FAULTS = {"": READS, "nan": SHOWS, "stuck": STANDS, "rail": SHOWS, "offset": READS}


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
            plant.vent * self.vent / v, plant.backwards * self.pump / v,
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
    step = float(seen.resolution)
    inverse = 1.0 / step if step else 0.0
    offsets = seen.offset, seen.offset + (upset.value if upset.sensor == "offset" else 0.0)
    sensors = tuple(
        (float(seen.range), float(regulator.lowest_reading), float(seen.noise), step, inverse, x)
        for x in offsets
    )
    wrong = math.nan if upset.sensor == "nan" else float(upset.value)
    return (
        plants, sensors, float(seen.lag), dt, steps, ends, levels, onset,
        SENSOR_FAULTS[upset.sensor], wrong, int(steps * (1 - steady)),
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
    loop()(0, seed, regulator.packed(), law.fresh(), *rest, out, history)
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
    many, packed = loop(), regulator.packed()

    def some(first: int) -> None:
        many(first, seed, packed, law.fresh(), *rest, out, none)

    # a job for each set of lanes: cores that others use as well share alike, and Ctrl-C waits for
    # the sets begun only
    with ThreadPoolExecutor(cores()) as pool:
        deque(pool.map(some, range(0, runs, LANES)), maxlen=0)
    return Runs(**dict(zip(COLUMNS, out.T, strict=True)))
