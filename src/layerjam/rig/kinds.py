"""What breaks in a campaign, when, by which names the board may call it, and how soon it must.

A deadline runs from the event to safe outputs. Those of the law's own faults are
`detection_times`; the others are worked out from the regulator's settings.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from layerjam.control.detection import IN_NOISE, detection_times
from layerjam.control.faults import OFFSET, FaultInjection, injection_of
from layerjam.control.settings import Regulator
from layerjam.rig.plant import COUNTS, VirtualPlant

Moment = Literal["pumping", "holding"]
Host = Literal["talks", "releases", "silent", "deaf"]
BOTH: tuple[Moment, ...] = ("pumping", "holding")
PUMPING: tuple[Moment, ...] = ("pumping",)
HOLDING: tuple[Moment, ...] = ("holding",)
ESTOP_SAMPLES, SUPPLY_SAMPLES = 2, 3
"""Samples in which the firmware answers an open emergency stop and a low supply."""
APART = 0.05
"""Share of the range by which two sensors may differ."""
PUMP = frozenset({"NO_VACUUM", "WEAK_PUMP"})
"""A dead pump's last rise, in the decision that it dies in, may still call it weak; so may that of
a sensor that sticks."""
DRIFTS = (200.0, 130.0, 100.0, 50.0)
"""Pascals a second by which a drifting sensor climbs."""
STALLS = (0.12, 1.0)
"""Shortest and longest time [s] for which a core is kept from its samples."""
LEASES = (0.2, 5.0)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One line, its regulator, and what was drawn for a fault."""

    regulator: Regulator
    target: float
    lease: float
    second: bool
    size: float
    """How bad: the sensor's drift [Pa/s], the time [s] without samples, the rail's sign."""

    @functools.cached_property
    def detected(self) -> Mapping[str, float]:
        """The law's own promises [s] up to this target."""
        return detection_times(self.regulator, self.target)

    @property
    def lowest(self) -> float:
        """Vacuum [Pa] at which its loss shows in every reading, noise and all."""
        sensor = self.regulator.sensor
        return self.target - self.regulator.lost_below - IN_NOISE * sensor.noise - sensor.resolution

    @property
    def highest(self) -> float:
        """Vacuum [Pa] at which the regulator opens the vent at the latest."""
        return self.target + self.regulator.vents_above

    def falls(self, rate: float, end: float) -> float:
        """Time [s] to fall out of the band on the way to `end` [Pa] at a rate [1/s]."""
        if not rate > 0 or not self.lowest > end:
            return math.inf
        return math.log((self.highest - end) / (self.lowest - end)) / rate


@dataclass(frozen=True, kw_only=True)
class FaultKind:
    """A fault: what happens (`text`), at one of which moments, and what must come of it.

    `deadline` gives the time [s] to safe outputs, infinite where nothing is promised; `breaks` does
    it to the plant. `names` are those by which the board may call it. `host` is what the host does
    then; the deadline runs from its order to release, or from the last line that the board took.
    """

    text: str
    moments: tuple[Moment, ...]
    names: frozenset[str]
    deadline: Callable[[Case], float]
    breaks: Callable[[Case, VirtualPlant], None]
    host: Host = "talks"

    def called(self, name: str | None, case: Case) -> bool:
        """Whether the board may call it so; a second sensor may be the first to notice."""
        disagree = case.second and name == "SENSORS_DISAGREE" and "SENSOR" in str(self.names)
        return name in self.names or disagree


def _injected(name: str) -> Callable[[Case, VirtualPlant], None]:
    """Break it by the size that the detectors answer for (`control/faults.py`)."""

    def breaks(case: Case, plant: VirtualPlant) -> None:
        plant.injected = injection_of(name, 0.0, case.regulator, case.target)[0]

    return breaks


def _set(**changes: object) -> Callable[[Case, VirtualPlant], None]:
    def breaks(_: Case, plant: VirtualPlant) -> None:
        for name, value in changes.items():
            setattr(plant, name, value)

    return breaks


def _nothing(_: Case, __: VirtualPlant) -> None:
    """The plant is sound; it is the host that fails."""


def _rail(case: Case, plant: VirtualPlant) -> None:
    value = math.copysign(case.regulator.sensor.range, case.size)
    plant.injected = FaultInjection(sensor="rail", value=value)


def _disconnected(case: Case, plant: VirtualPlant) -> None:
    share = -COUNTS[0] / COUNTS[1]  # no counts at all
    value = (2 * share - 1) * case.regulator.sensor.range
    plant.injected = FaultInjection(sensor="rail", value=value)


def _stuck_open(_: Case, plant: VirtualPlant) -> None:
    plant.injected = FaultInjection(leak=plant.behind.plant.vent)


def _drifts(case: Case, plant: VirtualPlant) -> None:
    plant.drift = case.size


def _stalls(case: Case, plant: VirtualPlant) -> None:
    plant.stall = case.size


def _law(name: str) -> Callable[[Case], float]:
    return lambda case: case.detected[name]


def _samples(count: int) -> Callable[[Case], float]:
    return lambda case: count * case.regulator.sample_time


def _leak_shows(case: Case) -> float:
    """Until the healthy leak has taken the vacuum out of the band, and that is a loss."""
    return case.falls(case.regulator.plant.joined.leak, 0.0) + case.detected["VACUUM_LOST"]


def _leaks_out(case: Case) -> float:
    """As a loss, against a pump that gives all it can."""
    plant = case.regulator.plant.joined
    half = case.target / 2
    whole = plant.rate * (plant.top - plant.weight * half) / half
    rate = plant.rate * plant.weight + max(whole, plant.leak)
    return case.falls(rate, half) + case.detected["VACUUM_LOST"]


def _open_shows(case: Case) -> float:
    """Until the pump, against the open vent, raises the vacuum no more than a weak one does.

    Near no vacuum the open vent takes little, and the pump does its work.
    """
    made = case.regulator
    plant, left = made.plant.joined, 1 - made.weak_ratio / 2
    out = plant.vent + plant.leak
    ends = plant.rate * plant.top / (plant.rate * plant.weight + out)
    weak = left * plant.rate * plant.top / (left * plant.rate * plant.weight + out)
    rises = -math.log(1 - weak / ends) / (plant.rate * plant.weight + out)
    return rises + case.detected["WEAK_PUMP"]


def _lease(case: Case) -> float:
    return case.lease + case.regulator.sample_time


def _late(case: Case) -> float:
    """The first sample that comes is the last that may be late."""
    return case.size + case.regulator.sample_time


def _apart(case: Case) -> float:
    """Nothing with one sensor; with two until they differ by more than noise explains."""
    if not case.second:
        return math.inf
    made = case.regulator
    differ = APART * made.sensor.range + 2 * IN_NOISE * made.sensor.noise + made.sensor.resolution
    return differ / case.size + (made.confirm + 1) * made.sample_time


def _law_fault(
    text: str,
    moments: tuple[Moment, ...],
    says: str,
    names: set[str] | frozenset[str] = frozenset(),
) -> dict[str, Any]:
    """A fault that the law answers within its own promise for `says`."""
    return {
        "text": text,
        "moments": moments,
        "names": frozenset(names or {says}),
        "deadline": _law(says),
    }


KINDS: dict[str, FaultKind] = {
    "sensor-nan": FaultKind(
        **_law_fault("the sensor says that it is ill and gives no number", BOTH, "NOT_A_NUMBER"),
        breaks=_injected("sensor-nan"),
    ),
    "sensor-rail": FaultKind(
        **_law_fault("the sensor shows one end of its range", BOTH, "SENSOR_OUT_OF_RANGE"),
        breaks=_rail,
    ),
    "sensor-disconnected": FaultKind(
        **_law_fault("the sensor's wire is off: no counts", BOTH, "SENSOR_OUT_OF_RANGE"),
        breaks=_disconnected,
    ),
    "sensor-stuck": FaultKind(
        **_law_fault(
            "the sensor shows the same number for ever",
            BOTH,
            "SENSOR_STUCK",
            PUMP | {"SENSOR_STUCK"},
        ),
        breaks=_injected("sensor-stuck"),
    ),
    "sensor-offset": FaultKind(
        **_law_fault(
            f"the sensor shows {OFFSET:g} times what counts as none; noticed when vented",
            HOLDING,
            "SENSOR_OFFSET",
            {"SENSOR_OFFSET", "LINE_BLOCKED"},  # a jump while the pump runs is a block's
        ),
        breaks=_injected("sensor-offset"),
        host="releases",
    ),
    "sensor-drift": FaultKind(
        text="the reading climbs while the vacuum is held",
        moments=HOLDING,
        names=frozenset({"SENSORS_DISAGREE"}),
        deadline=_apart,
        breaks=_drifts,
    ),
    "pump-dead": FaultKind(
        **_law_fault("the pump stops while it pumps", PUMPING, "NO_VACUUM", PUMP),
        breaks=_injected("pump-dead"),
    ),
    "pump-weak": FaultKind(
        **_law_fault(
            "the pump gives half of the flow that counts as weak, while it pumps",
            PUMPING,
            "WEAK_PUMP",
            PUMP,
        ),
        breaks=_injected("pump-weak"),
    ),
    "pump-dead-holding": FaultKind(
        text="the pump stops while the vacuum is held; noticed when the leak shows",
        moments=HOLDING,
        names=PUMP | {"VACUUM_LOST"},
        deadline=_leak_shows,
        breaks=_injected("pump-dead"),
    ),
    "vent-stuck-open": FaultKind(
        text="the vent valve opens and stays so while the pump pumps",
        moments=PUMPING,
        names=PUMP,
        deadline=_open_shows,
        breaks=_stuck_open,
    ),
    "vent-stuck-closed": FaultKind(
        text="the vent valve stays closed when it is to release; the vacuum stays",
        moments=HOLDING,
        names=frozenset({"LINE_BLOCKED"}),
        deadline=_law("SENSOR_OFFSET"),
        breaks=_set(injected=FaultInjection(vent=0.0)),
        host="releases",
    ),
    "line-blocked": FaultKind(
        **_law_fault(
            "the line is blocked while the pump pumps: little is left for it to empty",
            PUMPING,
            "LINE_BLOCKED",
        ),
        breaks=_injected("line-blocked"),
    ),
    "leak": FaultKind(
        text="a leak opens while the vacuum is held; the full pump holds half of it",
        moments=HOLDING,
        names=PUMP | {"VACUUM_LOST"},
        deadline=_leaks_out,
        breaks=_injected("leak"),
    ),
    "host-silent": FaultKind(
        text="the host says nothing more",
        moments=BOTH,
        names=frozenset({"LEASE_EXPIRED"}),
        deadline=_lease,
        breaks=_nothing,
        host="silent",
    ),
    "host-deaf": FaultKind(
        text="the host goes on asking and reads no answer",
        moments=BOTH,
        names=frozenset({"LEASE_EXPIRED"}),
        deadline=_lease,
        breaks=_nothing,
        host="deaf",
    ),
    "tick-late": FaultKind(
        text="something keeps the core from its samples",
        moments=BOTH,
        names=frozenset({"TICK_OVERRUN"}),
        deadline=_late,
        breaks=_stalls,
    ),
    "e-stop": FaultKind(
        text="somebody opens the emergency stop, which also cuts the power of pump and valve",
        moments=BOTH,
        names=frozenset({"EMERGENCY_STOP"}),
        deadline=_samples(ESTOP_SAMPLES),
        breaks=_set(estop=True),
    ),
    "supply-low": FaultKind(
        text="the supply falls below its limit",
        moments=BOTH,
        names=frozenset({"SUPPLY_LOW"}),
        deadline=_samples(SUPPLY_SAMPLES),
        breaks=_set(supply_low=True),
    ),
}
NOT_HERE = {
    "core-locked": "a virtual board has no watchdog; the emulated board has one",
}
"""Faults of the specification that a virtual board cannot show, and why."""
