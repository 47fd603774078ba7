"""Faults of a campaign: their times, the names that the board may report, and deadlines.

A deadline runs from the event to safe outputs. The deadlines of the law's own faults are its
`detection_times`; those of the others follow from the controller's settings.
"""

import functools
import math
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import Literal

from layerjam.bench.control.detection import IN_NOISE, detection_times
from layerjam.bench.control.faults import OFFSET, FaultInjection, make_injection
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.virtual_plant import COUNTS, VirtualPlant

Moment = Literal["pumping", "holding"]
Host = Literal["talks", "releases", "silent", "deaf"]
ESTOP_SAMPLES, SUPPLY_SAMPLES = 2, 3
"""Number of samples after which the firmware reacts to an open stop, and to a low supply."""
SENSOR_GAP = 0.05
"""Maximum difference between two sensors, as a fraction of the range."""
DRIFTS = (200.0, 130.0, 100.0, 50.0)
"""Drift rates of a sensor [Pa/s]."""
STALLS = (0.12, 1.0)
"""Shortest and longest time [s] without samples."""
LEASES = (0.2, 5.0)


@dataclass(frozen=True, kw_only=True)
class Case:
    """Controller of one line, and the random values of one fault."""

    regulator: Regulator
    target: float
    lease: float
    second: bool
    size: float
    """Size of the fault: the sensor's drift [Pa/s], the time [s] without samples, the rail's
    sign."""

    @functools.cached_property
    def promised_times(self) -> Mapping[str, float]:
        """Detection times [s] that the law guarantees up to this target."""
        return detection_times(self.regulator, self.target)

    @property
    def loss_threshold(self) -> float:
        """Vacuum [Pa] below which every reading indicates a loss, despite noise and zero error."""
        regulator = self.regulator
        noise = IN_NOISE * regulator.greatest_noise + regulator.sensor.resolution
        return self.target - regulator.loss_margin - noise - regulator.zero_error

    @property
    def vented_vacuum(self) -> float:
        """Vacuum [Pa] above which the controller has certainly opened the vent."""
        return self.target + self.regulator.vent_threshold + self.regulator.zero_error

    @functools.cached_property
    def strongest_plant(self) -> Plant:
        """Return the plant with the strongest pump and the weakest vent within the tolerances."""
        plant, tolerances = self.regulator.plant.lumped_plant, self.regulator.tolerances
        return replace(
            plant, rate=plant.rate * (1 + tolerances.pump), vent=plant.vent * (1 - tolerances.vent)
        )

    def fall_time(self, rate: float, end: float) -> float:
        """Return the time [s] for a fall towards `end` [Pa] at a rate [1/s] to leave the band."""
        if not rate > 0 or not self.loss_threshold > end:
            return math.inf
        return math.log((self.vented_vacuum - end) / (self.loss_threshold - end)) / rate


@dataclass(frozen=True)
class FaultKind:
    """A kind of fault: its description (`text`), its possible onsets and its required result.

    `breaks` applies it to the plant. `host` is the host's behaviour; if the host acts, the deadline
    runs from its release command, or from the last line that the board received. `answers` names
    the fault whose guaranteed time applies; if there is none, `promise` returns the deadline. The
    board may report any of `names`.
    """

    text: str
    moments: tuple[Moment, ...]
    answers: str
    breaks: Callable[[Case, VirtualPlant], None]
    names: frozenset[str]
    promise: Callable[[Case], float] | None
    host: Host

    def deadline(self, case: Case) -> float:
        """Return the time [s] to safe outputs, infinite if nothing is guaranteed."""
        return case.promised_times[self.answers] if self.promise is None else self.promise(case)

    def accepts_name(self, name: str | None, case: Case) -> bool:
        """Return whether the board may report this name; a second sensor may be faster."""
        disagree = case.second and name == "SENSORS_DISAGREE" and "SENSOR" in str(self.names)
        return name in self.names or disagree


def _make_injection(name: str) -> Callable[[Case, VirtualPlant], None]:
    """Return a function that injects a fault just large enough for the detectors."""

    def inject(case: Case, plant: VirtualPlant) -> None:
        plant.injected = make_injection(name, 0.0, case.regulator, case.target)[0]

    return inject


def _make_setter(**changes: object) -> Callable[[Case, VirtualPlant], None]:
    """Return a function that sets attributes of the plant; it sets none if only the host fails."""

    def inject(_: Case, plant: VirtualPlant) -> None:
        for name, value in changes.items():
            setattr(plant, name, value)

    return inject


def _make_rail_fault(share: Callable[[Case], float]) -> Callable[[Case, VirtualPlant], None]:
    """Return a function that fixes the sensor's output at a fraction of its range."""

    def inject(case: Case, plant: VirtualPlant) -> None:
        value = share(case) * case.regulator.sensor.range
        plant.injected = FaultInjection(sensor="rail", value=value)

    return inject


def _stick_vent_open(_: Case, plant: VirtualPlant) -> None:
    plant.injected = FaultInjection(leak=plant.behind.plant.vent)


def _leak_deadline(case: Case) -> float:
    """Return the time until the normal leak causes a loss of vacuum that is reported."""
    leak = case.regulator.plant.lumped_plant.leak
    return case.fall_time(leak, 0.0) + case.promised_times["VACUUM_LOST"]


def _loss_deadline(case: Case) -> float:
    """Return the time until a loss is visible although the pump runs at full power."""
    plant, pump = case.regulator.plant.lumped_plant, case.strongest_plant.rate
    half_target = case.target / 2
    inflow = max(plant.rate * (plant.top - plant.weight * half_target) / half_target, plant.leak)
    rate = pump * plant.weight + inflow
    return case.fall_time(rate, pump * plant.top / rate) + case.promised_times["VACUUM_LOST"]


def _open_vent_deadline(case: Case) -> float:
    """Return the time until the open vent limits the rise to that of a weak pump.

    Near zero vacuum, little air flows through the open vent, and the pump seems to work normally.
    """
    regulator = case.regulator
    plant, flow_share = case.strongest_plant, 1 - regulator.weak_ratio / 2
    out = plant.vent + plant.leak
    ends = plant.rate * plant.top / (plant.rate * plant.weight + out)
    weak = flow_share * plant.rate * plant.top / (flow_share * plant.rate * plant.weight + out)
    rise_time = -math.log(1 - weak / ends) / (plant.rate * plant.weight + out)
    return rise_time + case.promised_times["WEAK_PUMP"]


def _sample_deadline(time: Callable[[Case], float]) -> Callable[[Case], float]:
    """Return the deadline one sample after a time [s]."""
    return lambda case: time(case) + case.regulator.sample_time


def _drift_deadline(case: Case) -> float:
    """Return infinity for one sensor; for two, the time until they differ by more than noise."""
    if not case.second:
        return math.inf
    regulator, sensor = case.regulator, case.regulator.sensor
    noise = 2 * IN_NOISE * regulator.greatest_noise + sensor.resolution
    differ = SENSOR_GAP * sensor.range + noise + 2 * regulator.zero_error
    return differ / case.size + (regulator.confirm + 1) * regulator.sample_time


_BREAKS: dict[str, Callable[[Case, VirtualPlant], None]] = {
    "sensor-rail": _make_rail_fault(lambda case: math.copysign(1.0, case.size)),
    # the sensor's output is at zero counts
    "sensor-disconnected": _make_rail_fault(lambda _: 2 * (-COUNTS[0] / COUNTS[1]) - 1),
    "sensor-drift": lambda case, plant: setattr(plant, "drift", case.size),
    "pump-dead-holding": _make_injection("pump-dead"),
    "vent-stuck-open": _stick_vent_open,
    "vent-stuck-closed": _make_setter(injected=FaultInjection(vent=0.0)),
    "host-silent": _make_setter(),
    "host-deaf": _make_setter(),
    "tick-late": lambda case, plant: setattr(plant, "stall", case.size),
    "e-stop": _make_setter(estop=True),
    "supply-low": _make_setter(supply_low=True),
}
"""{fault: change of the plant}, for faults that the law does not have under the same name."""
_PROMISES: dict[str, Callable[[Case], float]] = {
    "sensor-drift": _drift_deadline,
    "pump-dead-holding": _leak_deadline,
    "vent-stuck-open": _open_vent_deadline,
    "leak": _loss_deadline,
    "host-silent": _sample_deadline(lambda case: case.lease),
    "host-deaf": _sample_deadline(lambda case: case.lease),
    "tick-late": _sample_deadline(lambda case: case.size),
    "e-stop": lambda case: ESTOP_SAMPLES * case.regulator.sample_time,
    "supply-low": lambda case: SUPPLY_SAMPLES * case.regulator.sample_time,
}
"""{fault: deadline}, for faults whose time the law does not guarantee."""


def _read_kinds() -> Iterator[tuple[str, FaultKind]]:
    """Yield (name, kind) of every fault in kinds.toml."""
    text = files("layerjam.bench.rig").joinpath("kinds.toml").read_text(encoding="utf-8")
    for name, row in tomllib.loads(text).items():
        kind = FaultKind(
            text=row["text"].format(offset=f"{OFFSET:g}"),
            moments=tuple(row["moments"]),
            answers=row["answers"],
            breaks=_BREAKS.get(name) or _make_injection(name),
            names=frozenset(row.get("names", [row["answers"]])),
            promise=_PROMISES.get(name),
            host=row.get("host", "talks"),
        )
        yield name, kind


KINDS = dict(_read_kinds())
NOTHING = "nothing"
"""Name of a fault-free run, which ends with the release of the vacuum."""
HEALTHY = FaultKind(
    text="no fault",
    moments=("holding",),
    answers="",
    breaks=_make_setter(),
    names=frozenset(),
    promise=lambda _: math.inf,
    host="releases",
)
NOT_HERE = {"core-locked": "a virtual board has no watchdog; the emulated board has one"}
"""{fault in the specification that a virtual board cannot have: reason}."""
