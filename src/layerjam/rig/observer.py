"""One fault on a virtual board: what is drawn for it, and the plant's log of the outputs."""

from __future__ import annotations

import itertools
import math
import random
import threading
from dataclasses import dataclass, replace

from layerjam.control.plant import Plant
from layerjam.control.settings import KINDS as LAWS
from layerjam.control.settings import Regulator
from layerjam.fluid.line import Sensor
from layerjam.rig.kinds import DRIFTS, KINDS, LEASES, STALLS, Case, FaultKind, Moment
from layerjam.rig.plant import Hardware, VirtualPlant

SPREAD = 1.4
"""Factor by which a line's pump, leak and vent are drawn greater or smaller."""
TARGETS = (0.25, 0.75)
"""Of the vacuum that the pump reaches, and of the sensor's range."""
LEVELS = (0.02, 0.6)
"""Share of the target at which a fault of the pumping begins."""
FULL = 1.5
"""Errors that saturate a PI regulator: the distance from the target at which its pump runs full."""
WAITS = (0.2, 5.0)
"""Time [s] for which a vacuum is held before a fault."""
PATIENCE = 120.0
"""Time [s] of the plant after which a moment that has not come does not come, nor a host's word."""
FLOODED = 15.0
"""Time [s] in which a board reads what a deaf host asks, until its 4 kB wait to be sent."""
MARGIN = 2.0
"""Time [s] beyond twice the deadline for which a fault is watched."""
LONGEST = 600.0
"""Time [s] for which a fault is watched that nothing is promised for."""
TENTH = 0.1
"""Share of the target whose loss is noted."""
GONE = 0.02
"""Share of the target below which the vacuum is gone."""
SLOW = 1e-3
"""Host's time [s] of a sample while the host has something to do."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A fault as drawn: of which kind, on which line, at which moment."""

    name: str
    number: int
    behind: Hardware
    case: Case
    moment: Moment
    level: float
    """Vacuum [Pa] at which it begins while pumping."""
    wait: float
    """Time [s] after which it begins while holding."""
    phase: float
    """Share of a sample that it begins after one."""
    seed: int

    @property
    def kind(self) -> FaultKind:
        """What it is."""
        return KINDS[self.name]


def highest_target(plant: Plant, sensor: Sensor) -> float:
    """The highest vacuum [Pa] that is asked for, with room above it for pump and sensor."""
    highest = TARGETS[1] * min(plant.reach, sensor.range)
    return highest if plant.passage is None else min(highest, plant.passage.vacuum)


def drawn(behind: Hardware, name: str, number: int, seed: int, size: float | None = None) -> Plan:
    """The `number`-th run of a fault: the same for the same seed, whatever else is run.

    The line is drawn around the one behind the board, the regulator is made for the line drawn.
    `size` is the fault's, drawn unless given.
    """
    draw = random.Random(f"{seed} {name} {number}")

    def around() -> float:
        return math.exp(draw.uniform(-1, 1) * math.log(SPREAD))

    plant = replace(
        behind.plant,
        rate=behind.plant.rate * around(),
        leak=behind.plant.leak * around(),
        vent=behind.plant.vent * around(),
    )
    regulator = Regulator(
        plant=plant,
        sensor=behind.sensor,
        kind=draw.choice(list(LAWS)),
        safe_state="release" if behind.normally_open else "hold",
    )
    target = draw.uniform(TARGETS[0] / TARGETS[1], 1.0) * highest_target(plant, behind.sensor)
    band = regulator.half_band if regulator.kind == "bang-bang" else 1 / regulator.gains().gain
    highest = min(LEVELS[1] * target, target - FULL * band)
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
        second=behind.second,
        size=sizes.get(name, 1.0) if size is None else size,
    )
    return Plan(
        name=name,
        number=number,
        behind=replace(behind, plant=plant),
        case=case,
        moment=draw.choice(KINDS[name].moments),
        level=level,
        wait=draw.uniform(*WAITS),
        phase=draw.random(),
        seed=draw.randrange(1 << 30),
    )


class Observer:
    """Breaks the plant at its moment and watches the outputs; called in the plant's thread.

    `done` is set when the outputs have been safe for long enough, or the time is over.
    """

    def __init__(self, plant: VirtualPlant, plan: Plan) -> None:
        self.plant, self.plan = plant, plan
        self.done = threading.Event()
        self.struck: float | None = None
        """When the plant was broken [s]."""
        self.event: float | None = None
        """From when on the deadline counts [s]."""
        self.since: float | None = None
        """Since when the outputs are safe [s]."""
        self.lost: float | None = None
        """When a tenth of the target was missing [s]."""
        self.vacuum = math.nan
        """True vacuum at the end [Pa]."""
        self.began: float | None = None
        self._safe = (0.0, plan.behind.normally_open)
        self._held: float | None = None
        self._armed = False
        self._first = 0
        self._times: list[float] = []
        self._deadline = plan.kind.deadline(plan.case)
        self._settle = plan.case.regulator.settles_in + 0.1

    def __call__(self) -> None:
        """One sample."""
        now, plan = self.plant.time, self.plan
        if self.done.is_set():
            return
        if self.struck is not None:
            self._times.append(now)
            self._look(now)
        elif self.began is None:
            if self.plant.outputs[0] > 0:
                self.began = now
                self.plant.reseed(plan.seed)
        elif not self._armed:
            if self._is_moment(now):
                self._armed = True
                self.plant.at(now + plan.phase * plan.case.regulator.sample_time, self._strike)
            elif now - self.began > PATIENCE:
                self._end()

    def _is_moment(self, now: float) -> bool:
        plan, plant = self.plan, self.plant
        if plan.moment == "pumping":
            return plant.outputs[0] >= 1.0 and plant.vacuum >= plan.level
        if self._held is None:
            if abs(plant.vacuum - plan.case.target) <= plan.case.regulator.vents_above:
                self._held = now
            return False
        return now - self._held >= plan.wait

    def _strike(self) -> None:
        plant = self.plant
        self.struck = plant.time
        self._first = plant.asked + 1
        plant.trace = [(plant.time, *plant.outputs, plant.vacuum)]
        if self.plan.kind.host == "talks":
            self.event = plant.time
        else:
            plant.pace = SLOW
        self.plan.kind.breaks(self.plan.case, plant)

    def _look(self, now: float) -> None:
        plant, case = self.plant, self.plan.case
        if self.lost is None and plant.vacuum < (1 - TENTH) * case.target:
            self.lost = now
        if plant.outputs != self._safe:
            self.since = None
        elif self.since is None and plant.trace:
            self.since = plant.trace[-1][0]
        begun = self.struck if self.event is None else self.event
        passed = now - begun if begun is not None else 0.0
        if not math.isfinite(self._deadline):
            if passed > LONGEST or plant.vacuum < GONE * case.target:
                self._end()
        elif self.since is None or now - self.since < self._settle:
            more = MARGIN if self.event is not None else PATIENCE
            if passed > 2 * self._deadline + self._settle + more:
                self._end()
        elif self._known:  # what is safe by itself has to be named too
            more = 0.0 if self.event is not None else FLOODED
            if passed >= self._deadline + self._settle + more:
                self._end()

    @property
    def _known(self) -> bool:
        """Whether the event is, or will be when a deaf host reads its answers."""
        return self.event is not None or self.plan.kind.host == "deaf"

    def _end(self) -> None:
        self.vacuum = self.plant.vacuum
        self.plant.pace = SLOW
        self.done.set()

    def time_of(self, seq: int) -> float | None:
        """When the board took its sample `seq` [s], None where that was not watched."""
        place = seq + 1 - self._first
        if place < 0:
            return self.struck
        return self._times[place] if place < len(self._times) else None

    @property
    def safe_after(self) -> float | None:
        """Time [s] from the event to outputs that were safe and stayed so."""
        if self.since is None or self.event is None:
            return None
        return max(self.since - self.event, 0.0)

    def openings(self, count: int, within: float) -> float | None:
        """Time [s] until the vent had opened so often within so long, None where it did not."""
        if self.struck is None or self.plant.trace is None:
            return None
        rows = self.plant.trace
        opened = [
            after[0] for before, after in itertools.pairwise(rows) if after[2] and not before[2]
        ]
        for first, last in zip(opened, opened[count - 1 :], strict=False):
            if last - first <= within:
                return last - self.struck
        return None
