"""The law and its plant in closed loop: one run with its history, or thousands in parallel.

Between samples the plant and the sensor's lag are solved exactly (`exact.py`; the lag to 1e-11 of a
sample's rise); with a tube they are integrated numerically (`through_tube.py`). With the noise of
`noise.py`, the result of a run depends only on its seed and number, not on other runs or cores.
"""

import functools
import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Any

import numpy as np

from layerjam.bench.control.closed_loop_run import READS, SHOWS, STANDS, Chain, Course
from layerjam.bench.control.engine import run_loop
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.noise import make_key
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import FAULTS, Regulator, validate
from layerjam.brake.fluid.line import Sensor
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError
from layerjam.core.threads import Workers
from layerjam.core.units import show

Array = np.ndarray[Any, np.dtype[np.float64]]
SENSOR_FAULTS = {"": READS, "nan": SHOWS, "stuck": STANDS, "rail": SHOWS, "offset": READS}
Targets = Sequence[tuple[float, float]]
"""Pairs of duration [s] and vacuum [Pa]."""


@dataclass(frozen=True, kw_only=True)
class Runs:
    """Results of M closed loops, shape (M,), computed from the true vacuum, not the reading."""

    rise_time: Any
    """Time from 10 to 90 % of the first target [s]; NaN if it ends before 90 % is reached."""
    overshoot: Any
    """Maximum vacuum during the first target minus that target [Pa]; negative if not reached."""
    steady_error: Any
    """Mean of vacuum minus target in the last part of the run [Pa]."""
    ripple: Any
    """Highest minus lowest vacuum in the last part of the run [Pa]."""
    pump_on: Any
    """Time integral of the pump command [s]."""
    pump_switches: Any
    vent_switches: Any
    fault: Any
    """Code of the first fault, or 0 if healthy; the names are in `settings.FAULTS`."""
    fault_time: Any
    """Detection time of that fault [s]; NaN if there is none."""


COLUMNS = tuple(Runs.__dataclass_fields__)


@brief
@dataclass(frozen=True, kw_only=True)
class ClosedLoop(Runs):
    """One closed loop: the values of `Runs`, and arrays of shape (N,) with one entry per sample."""

    time: Array = field(repr=False)
    vacuum: Array = field(repr=False)
    """True vacuum [Pa]."""
    measured: Array = field(repr=False)
    """Reading of the sensor [Pa]; NaN if there is none."""
    target: Array = field(repr=False)
    pump: Array = field(repr=False)
    vent: Array = field(repr=False)
    fault: Array = field(repr=False)
    """Fault code at each sample."""
    outcome: str
    """HEALTHY, or the name of the fault."""


def simulate_run(
    regulator: Regulator,
    targets: Targets,
    *,
    duration: float | None = None,
    plant: Plant | None = None,
    sensor: Sensor | None = None,
    injected: FaultInjection | None = None,
    seed: int = 0,
    steady: float = 0.25,
) -> ClosedLoop:
    """Simulate one run from zero vacuum, and keep its history.

    `targets` are pairs (duration [s], vacuum [Pa]), repeated if `duration` is longer. `plant` and
    `sensor` are the true plant and sensor, if they differ from the controller's settings. `steady`
    is the fraction of the run, at its end, that yields steady error and ripple. Raises
    QuantityError for settings that `settings.validate` rejects.
    """
    loop_of = _Loop(regulator, plant, sensor, injected or FaultInjection())
    course = loop_of.make_course(targets, duration, steady)
    out, history = np.zeros(len(COLUMNS)), np.zeros((course.samples, 6))
    loop_of.run(course, seed, 0, out, history)
    numbers: dict[str, Any] = dict(zip(COLUMNS, out.tolist(), strict=True))
    counts = {name: int(numbers[name]) for name in ("pump_switches", "vent_switches", "fault")}
    names = ("vacuum", "measured", "target", "pump", "vent", "fault")
    return ClosedLoop(
        **{**numbers, **counts, **dict(zip(names, history.T, strict=True))},
        time=np.arange(course.samples) * np.float64(regulator.sample_time),
        outcome=FAULTS[counts["fault"]],
    )


simulate = simulate_run  # former name


def simulate_runs(
    regulator: Regulator,
    targets: Targets,
    *,
    runs: int,
    duration: float | None = None,
    plant: Plant | None = None,
    sensor: Sensor | None = None,
    injected: FaultInjection | None = None,
    seed: int = 0,
    steady: float = 0.25,
) -> Runs:
    """Simulate `runs` runs with independent noise on all cores; run j uses stream j of `seed`.

    Raises QuantityError as `simulate_run` does.
    """
    loop_of = _Loop(regulator, plant, sensor, injected or FaultInjection())
    course = loop_of.make_course(targets, duration, steady)
    out, no_events = np.zeros((runs, len(COLUMNS))), np.zeros((0, 6))
    # one task per run: cores share the work evenly, and Ctrl-C waits only for started runs
    with Workers() as pool:
        task = functools.partial(loop_of.run, course, seed, history=no_events)
        deque(pool.map(task, range(runs), out), maxlen=0)
    return Runs(**dict(zip(COLUMNS, out.T, strict=True)))


@dataclass(frozen=True)
class _Loop:
    """A controller with the true plant, the true sensor and the injected fault."""

    regulator: Regulator
    plant: Plant | None
    sensor: Sensor | None
    injected: FaultInjection

    def make_course(self, targets: Targets, duration: float | None, steady: float) -> Course:
        """Return the schedule of a run; raises QuantityError if it is impossible."""
        if not targets or min(lasting for lasting, _ in targets) <= 0:
            raise QuantityError("targets: each needs a duration above zero")
        validate(self.regulator, max(level for _, level in targets))
        fault, dt = self.injected, self.regulator.sample_time
        if fault.sensor not in SENSOR_FAULTS:
            raise QuantityError(f"sensor: '{fault.sensor}' is not a sensor fault")
        length = sum(lasting for lasting, _ in targets) if duration is None else duration
        count = round(length / dt)
        if count < 1:
            raise QuantityError(f"duration: {show(length, 's')} is shorter than one sample")
        return Course(
            dt=dt,
            lag=float((self.sensor or self.regulator.sensor).lag),
            samples=count,
            stages=len(targets),
            ends=tuple(accumulate(max(round(lasting / dt), 1) for lasting, _ in targets)),
            levels=tuple(float(level) for _, level in targets),
            onset=count if math.isinf(fault.at) else math.ceil(fault.at / dt - 1e-9),
            sensor=SENSOR_FAULTS[fault.sensor],
            shown=math.nan if fault.sensor == "nan" else float(fault.value),
            steady=int(count * (1 - steady)),
        )

    def run(self, course: Course, seed: int, number: int, out: Array, history: Array) -> None:
        """Write one run to `out` and, if `history` is not empty, its samples to `history`."""
        plant, sensor = self.plant or self.regulator.plant, self.sensor or self.regulator.sensor
        lowest = float(self.regulator.lowest_reading)
        sound = Chain(
            float(sensor.range),
            lowest,
            float(sensor.noise),
            float(sensor.resolution),
            float(sensor.offset),
        )
        offset = self.injected.value if self.injected.sensor == "offset" else 0.0
        chains = (sound, sound._replace(offset=sound.offset + offset))
        plants = (FaultInjection().break_plant(plant), self.injected.break_plant(plant))
        key, settings = make_key(seed, number), self.regulator.pack()
        run_loop(key, settings, plants, chains, course, out, history)
