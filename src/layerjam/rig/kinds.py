"""What breaks in a campaign, when, by which names the board may call it, and how soon it must.

A deadline runs from the event to safe outputs. Those of the law's own faults are
`detection_times`; the others are worked out from the regulator's settings.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

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


@dataclass(frozen=True)
class FaultKind:
    """A fault: what happens (`text`), at one of which moments, and what must come of it.

    `breaks` does it to the plant. `host` is what the host does then; the deadline runs from its
    order to release, or from the last line that the board took. A fault that the law has its own
    promise for `answers` to that; `names` are those by which the board may call it, else that
    one. Where the law promises nothing, `promise` gives the deadline.
    """

    text: str
    moments: tuple[Moment, ...]
    answers: str
    breaks: Callable[[Case, VirtualPlant], None]
    names: frozenset[str] = frozenset()
    promise: Callable[[Case], float] | None = None
    host: Host = "talks"

    def deadline(self, case: Case) -> float:
        """Return the time [s] to safe outputs, infinite if nothing is promised."""
        return case.detected[self.answers] if self.promise is None else self.promise(case)

    def called(self, name: str | None, case: Case) -> bool:
        """Whether the board may call it so; a second sensor may be the first to notice."""
        names = self.names or {self.answers}
        disagree = case.second and name == "SENSORS_DISAGREE" and "SENSOR" in str(names)
        return name in names or disagree


def _injected(name: str) -> Callable[[Case, VirtualPlant], None]:
    """Break it by the size that the detectors answer for (`control/faults.py`)."""

    def breaks(case: Case, plant: VirtualPlant) -> None:
        plant.injected = injection_of(name, 0.0, case.regulator, case.target)[0]

    return breaks


def _set(**changes: object) -> Callable[[Case, VirtualPlant], None]:
    """Set attributes of the plant; none of a plant that is sound while the host fails."""

    def breaks(_: Case, plant: VirtualPlant) -> None:
        for name, value in changes.items():
            setattr(plant, name, value)

    return breaks


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


KINDS: dict[str, FaultKind] = {
    "sensor-nan": FaultKind(
        "the sensor says that it is ill and gives no number",
        BOTH,
        "NOT_A_NUMBER",
        _injected("sensor-nan"),
    ),
    "sensor-rail": FaultKind(
        "the sensor shows one end of its range", BOTH, "SENSOR_OUT_OF_RANGE", _rail
    ),
    "sensor-disconnected": FaultKind(
        "the sensor's wire is off: no counts", BOTH, "SENSOR_OUT_OF_RANGE", _disconnected
    ),
    "sensor-stuck": FaultKind(
        "the sensor shows the same number for ever",
        BOTH,
        "SENSOR_STUCK",
        _injected("sensor-stuck"),
        names=PUMP | {"SENSOR_STUCK"},
    ),
    "sensor-offset": FaultKind(
        f"the sensor shows {OFFSET:g} times what counts as none; noticed when vented",
        HOLDING,
        "SENSOR_OFFSET",
        _injected("sensor-offset"),
        # a jump while the pump runs is a block's
        names=frozenset({"SENSOR_OFFSET", "LINE_BLOCKED"}),
        host="releases",
    ),
    "sensor-drift": FaultKind(
        "the reading climbs while the vacuum is held",
        HOLDING,
        "SENSORS_DISAGREE",
        _drifts,
        promise=_apart,
    ),
    "pump-dead": FaultKind(
        "the pump stops while it pumps", PUMPING, "NO_VACUUM", _injected("pump-dead"), names=PUMP
    ),
    "pump-weak": FaultKind(
        "the pump gives half of the flow that counts as weak, while it pumps",
        PUMPING,
        "WEAK_PUMP",
        _injected("pump-weak"),
        names=PUMP,
    ),
    "pump-dead-holding": FaultKind(
        "the pump stops while the vacuum is held; noticed when the leak shows",
        HOLDING,
        "VACUUM_LOST",
        _injected("pump-dead"),
        names=PUMP | {"VACUUM_LOST"},
        promise=_leak_shows,
    ),
    "vent-stuck-open": FaultKind(
        "the vent valve opens and stays so while the pump pumps",
        PUMPING,
        "WEAK_PUMP",
        _stuck_open,
        names=PUMP,
        promise=_open_shows,
    ),
    "vent-stuck-closed": FaultKind(
        "the vent valve stays closed when it is to release; the vacuum stays",
        HOLDING,
        "SENSOR_OFFSET",
        _set(injected=FaultInjection(vent=0.0)),
        names=frozenset({"LINE_BLOCKED"}),
        host="releases",
    ),
    "line-blocked": FaultKind(
        "the line is blocked while the pump pumps: little is left for it to empty",
        PUMPING,
        "LINE_BLOCKED",
        _injected("line-blocked"),
    ),
    "leak": FaultKind(
        "a leak opens while the vacuum is held; the full pump holds half of it",
        HOLDING,
        "VACUUM_LOST",
        _injected("leak"),
        names=PUMP | {"VACUUM_LOST"},
        promise=_leaks_out,
    ),
    "host-silent": FaultKind(
        "the host says nothing more", BOTH, "LEASE_EXPIRED", _set(), promise=_lease, host="silent"
    ),
    "host-deaf": FaultKind(
        "the host goes on asking and reads no answer",
        BOTH,
        "LEASE_EXPIRED",
        _set(),
        promise=_lease,
        host="deaf",
    ),
    "tick-late": FaultKind(
        "something keeps the core from its samples", BOTH, "TICK_OVERRUN", _stalls, promise=_late
    ),
    "e-stop": FaultKind(
        "somebody opens the emergency stop, which also cuts the power of pump and valve",
        BOTH,
        "EMERGENCY_STOP",
        _set(estop=True),
        promise=_samples(ESTOP_SAMPLES),
    ),
    "supply-low": FaultKind(
        "the supply falls below its limit",
        BOTH,
        "SUPPLY_LOW",
        _set(supply_low=True),
        promise=_samples(SUPPLY_SAMPLES),
    ),
}
NOT_HERE = {
    "core-locked": "a virtual board has no watchdog; the emulated board has one",
}
"""Faults of the specification that a virtual board cannot show, and why."""
