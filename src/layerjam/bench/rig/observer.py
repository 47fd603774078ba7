"""Injection of one fault on a virtual board: its random plan, and an observer of the outputs."""

import itertools
import math
import random
import threading
from dataclasses import dataclass, replace

from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import KINDS as LAWS
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.kinds import (
    DRIFTS,
    HEALTHY,
    KINDS,
    LEASES,
    NOTHING,
    STALLS,
    Case,
    FaultKind,
    Moment,
)
from layerjam.bench.rig.uneven import draw_uneven
from layerjam.bench.rig.virtual_plant import Hardware, VirtualPlant
from layerjam.brake.fluid.line import Sensor

SPREAD = 1.4
"""Factor by which pump, leak and vent of a line are randomly scaled up or down."""
TARGETS = (0.25, 0.75)
"""Range of random targets, as fractions of the pump's highest vacuum and of the sensor's range."""
LEVELS = (0.02, 0.6)
"""Range of vacuums at which a fault during pumping begins, as fractions of the target."""
ROOM = 3.0
"""Rise at full pump power that must remain after the fault begins, in decision steps."""
FULL = 1.5
"""Error at which a PI loop surely runs the pump at full power, relative to its saturating error."""
WAITS = (0.2, 5.0)
"""Range of times [s] for which a vacuum is held before a fault."""
PATIENCE = 120.0
"""Additional plant time [s] before a trial without an event is ended."""
FLOODED = 15.0
"""Time [s] allowed until the board stops reading from a host that does not read (4 kB unsent)."""
MARGIN = 2.0
"""Time [s] for which a fault is still observed after twice its deadline."""
LONGEST = 600.0
"""Time [s] for which a fault without a deadline is observed."""
TENTH = 0.1
"""Fraction of the target whose loss is recorded."""
GONE = 0.02
"""Fraction of the target below which a trial without a deadline ends."""
SLOW = 1e-3
"""Duration of a sample [s of the host's clock] while the host is busy."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Random plan of one trial: its fault, line, controller and onset."""

    name: str
    number: int
    behind: Hardware
    case: Case
    moment: Moment
    level: float
    """Vacuum [Pa] at which the fault begins during pumping."""
    wait: float
    """Time [s] after which the fault begins during a hold."""
    phase: float
    """Delay after a sample, as a fraction of the sample time."""
    seed: int

    @property
    def kind(self) -> FaultKind:
        """Return the kind of the fault."""
        return KINDS.get(self.name, HEALTHY)


def highest_target(plant: Plant, sensor: Sensor) -> float:
    """Return the highest target vacuum [Pa], with a margin for pump and sensor."""
    highest = TARGETS[1] * min(plant.reach, sensor.range)
    return highest if plant.passage is None else min(highest, plant.passage.vacuum)


def draw_plan(
    hardware: Hardware,
    name: str,
    number: int,
    seed: int,
    size: float | None = None,
    *,
    mismatch: bool = False,
) -> Plan:
    """Return the plan of trial `number` of a fault; it depends on the seed, not on other trials.

    The line is a random variation of the board's line, and the controller is designed for it. With
    `mismatch`, the real line differs from the controller's model within the tolerances. `size` is
    the size of the fault, random by default.
    """
    draw = random.Random(f"{seed} {name} {number}")

    def _random_factor() -> float:
        return math.exp(draw.uniform(-1, 1) * math.log(SPREAD))

    plant = replace(
        hardware.plant,
        rate=hardware.plant.rate * _random_factor(),
        leak=hardware.plant.leak * _random_factor(),
        vent=hardware.plant.vent * _random_factor(),
    )
    regulator = Regulator(
        plant=plant,
        sensor=hardware.sensor,
        kind=draw.choice(list(LAWS)),
        safe_state="release" if hardware.normally_open else "hold",
    )
    target = draw.uniform(TARGETS[0] / TARGETS[1], 1.0) * highest_target(plant, hardware.sensor)
    band = regulator.half_band if regulator.kind == "bang-bang" else 1 / regulator.gains().gain
    highest = min(LEVELS[1] * target, target - FULL * band - ROOM * regulator.detection_threshold)
    level = max(draw.uniform(LEVELS[0] * target, max(highest, 0.0)), 0.0)
    sizes = {
        "sensor-drift": draw.choice(DRIFTS),
        "tick-late": round(draw.uniform(*STALLS), 3),
        "sensor-rail": draw.choice((-1.0, 1.0)),
    }
    case = Case(
        regulator=regulator,
        target=target,
        lease=round(draw.uniform(*LEASES), 3),
        second=hardware.second,
        size=sizes.get(name, 1.0) if size is None else size,
    )
    real = replace(hardware, plant=plant)
    if mismatch:
        # a deadline that depends on the leak must use the declared leak
        leak = draw.random() if name == NOTHING else 1.0
        real = draw_mismatch(real, case, leak, draw)
    return Plan(
        name=name,
        number=number,
        behind=real,
        case=case,
        moment=draw.choice(KINDS.get(name, HEALTHY).moments),
        level=level,
        wait=draw.uniform(*WAITS),
        phase=draw.random(),
        seed=draw.randrange(1 << 30),
    )


def draw_mismatch(hardware: Hardware, case: Case, leak: float, draw: random.Random) -> Hardware:
    """Return random hardware within the tolerances of a controller designed for it.

    `leak` is a factor on the largest healthy leak.
    """
    regulator, plant, sensor = case.regulator, hardware.plant, hardware.sensor
    tolerances, zero = regulator.tolerances, regulator.zero_error
    return replace(
        hardware,
        plant=replace(
            plant,
            rate=plant.rate * (1 + draw.uniform(-tolerances.pump, tolerances.pump)),
            vent=plant.vent * (1 + draw.uniform(-tolerances.vent, tolerances.vent)),
            leak=plant.leak * leak,
        ),
        sensor=replace(
            sensor,
            offset=sensor.offset + draw.uniform(-zero, zero),
            lag=draw.uniform(0.0, regulator.longest_lag),
            noise=sensor.noise * draw.uniform(1.0, tolerances.noise),
        ),
        uneven=draw_uneven(draw, case.target),
    )


class Observer:
    """Observer that injects a fault and watches the outputs; called in the plant's thread.

    `done` is set once the outputs have been safe for long enough, or at a timeout.
    """

    def __init__(self, plant: VirtualPlant, plan: Plan) -> None:
        self.plant, self.plan = plant, plan
        self.done = threading.Event()
        self.struck: float | None = None
        """Time of the fault [s]."""
        self.event: float | None = None
        """Time from which the deadline counts [s]."""
        self.since: float | None = None
        """Time since which the outputs have been safe [s]."""
        self.lost: float | None = None
        """Time at which a tenth of the target was lost [s]."""
        self.vacuum = math.nan
        """True vacuum at the end of the trial [Pa]."""
        self.began: float | None = None
        self._safe = (0.0, plan.behind.normally_open)
        self._held: float | None = None
        self._armed = False
        self._first = 0
        self._times: list[float] = []
        self._deadline = plan.kind.deadline(plan.case)
        self._settle = plan.case.regulator.settling_time + 0.1

    def __call__(self) -> None:
        """Observe one sample."""
        time, plan = self.plant.time, self.plan
        if self.done.is_set():
            return
        if self.struck is not None:
            self._times.append(time)
            self._check_progress(time)
        elif self.began is None:
            if self.plant.outputs[0] > 0:
                self.began = time
                self.plant.reseed(plan.seed)
        elif not self._armed:
            if self._is_fault_due(time):
                self._armed = True
                moment = time + plan.phase * plan.case.regulator.sample_time
                self.plant.schedule_action(moment, self._begin_fault)
            elif time - self.began > PATIENCE:
                self._end_run()

    def _is_fault_due(self, time: float) -> bool:
        plan, plant = self.plan, self.plant
        if plan.moment == "pumping":
            return plant.outputs[0] >= 1.0 and plant.vacuum >= plan.level
        if self._held is None:
            if abs(plant.vacuum - plan.case.target) <= plan.case.regulator.vent_threshold:
                self._held = time
            return False
        return time - self._held >= plan.wait

    def _begin_fault(self) -> None:
        plant = self.plant
        self.struck = plant.time
        self._first = plant.asked + 1
        plant.trace = [(plant.time, *plant.outputs, plant.vacuum)]
        if self.plan.kind.host == "talks":
            self.event = plant.time
        else:
            plant.pace = SLOW
        self.plan.kind.breaks(self.plan.case, plant)

    def _check_progress(self, time: float) -> None:
        plant, case = self.plant, self.plan.case
        if self.lost is None and plant.vacuum < (1 - TENTH) * case.target:
            self.lost = time
        if plant.outputs != self._safe:
            self.since = None
        elif self.since is None and plant.trace:
            self.since = plant.trace[-1][0]
        start = self.struck if self.event is None else self.event
        elapsed_time = time - start if start is not None else 0.0
        if self.plan.kind is HEALTHY:
            if elapsed_time > self._settle + MARGIN:
                self._end_run()
        elif not math.isfinite(self._deadline):
            if elapsed_time > LONGEST or plant.vacuum < GONE * case.target:
                self._end_run()
        elif self.since is None or time - self.since < self._settle:
            margin = MARGIN if self.event is not None else PATIENCE
            if elapsed_time > 2 * self._deadline + self._settle + margin:
                self._end_run()
        elif self._is_known:  # the fault must be reported even if the outputs are already safe
            margin = 0.0 if self.event is not None else FLOODED
            if elapsed_time >= self._deadline + self._settle + margin:
                self._end_run()

    @property
    def _is_known(self) -> bool:
        """Return whether the time of the event is known, or will be once a deaf host reads."""
        return self.event is not None or self.plan.kind.host == "deaf"

    def _end_run(self) -> None:
        self.vacuum = self.plant.vacuum
        self.plant.pace = SLOW
        self.done.set()

    def find_sample_time(self, seq: int) -> float | None:
        """Return the time of the board's sample `seq` [s], or None if it was not observed."""
        place = seq + 1 - self._first
        if place < 0:
            return self.struck
        return self._times[place] if place < len(self._times) else None

    @property
    def safe_after(self) -> float | None:
        """Return the time [s] from the event until the outputs became safe and stayed safe."""
        if self.since is None or self.event is None:
            return None
        return max(self.since - self.event, 0.0)

    @property
    def lost_after(self) -> float | None:
        """Return the time [s] from the event until a tenth of the target was lost."""
        return None if self.lost is None or self.event is None else self.lost - self.event

    def last_opening_time(self, count: int, window: float) -> float | None:
        """Return the time [s] of the last of `count` vent openings within `window` [s], or None."""
        if self.struck is None or self.plant.trace is None:
            return None
        rows = self.plant.trace
        times = [
            after[0] for before, after in itertools.pairwise(rows) if after[2] and not before[2]
        ]
        for first, last in zip(times, times[count - 1 :], strict=False):
            if last - first <= window:
                return last - self.struck
        return None
