"""The verdict on a machine: every limit with its value, the one that decides, and by how much."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from layerjam.errors import Notice
from layerjam.simulate.speed import beyond
from layerjam.studies.machines.restraint import gathered
from layerjam.studies.machines.scenario import Scenario, kind_of
from layerjam.units import get, record, show


@dataclass(frozen=True, kw_only=True)
class Limit:
    """A value beside what it may be: at most `limit`, or at least where `least` is set.

    SI; a `value` that is not finite says that it is never reached.
    """

    name: str
    value: float
    limit: float
    unit: str
    least: bool = False

    @property
    def met(self) -> bool:
        """Whether it is kept."""
        if math.isnan(self.value):
            return False
        return self.value >= self.limit if self.least else self.value <= self.limit

    @property
    def factor(self) -> float:
        """By what factor it is missed; below 1 where it is met."""
        top, bottom = (self.limit, self.value) if self.least else (self.value, self.limit)
        if math.isnan(self.value):
            return math.inf
        if bottom <= 0:
            return math.inf if top > 0 else 0.0
        return top / bottom

    def row(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self) | {"met": self.met}

    def sentence(self) -> str:
        """What it is, what it may be, and the factor."""
        value = show(self.value, self.unit) if math.isfinite(self.value) else "never reached"
        side = "at least" if self.least else "at most"
        said = f"{self.name} is {value}, {side} {show(self.limit, self.unit)} is allowed"
        if self.met or not math.isfinite(self.factor):
            return said
        return f"{said} (missed by a factor of {self.factor:.3g})"


def deciding(limits: Sequence[Limit]) -> Limit:
    """The limit missed by the greatest factor, or the tightest where all are met."""
    return max(limits, key=lambda limit: (not limit.met, limit.factor))


@dataclass(kw_only=True)
class Result:
    """What was found of a machine. `own` holds its own keys in SI, `units` theirs.

    `bounding` holds what no result shows, but a limit is about; `record` is drawn.
    """

    scenario: Scenario
    own: dict[str, Any] = field(default_factory=dict)
    bounding: dict[str, Any] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    limits: list[Limit] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    brakes_needed: int | None = None
    """How many brakes it would take, None where no number does."""
    needed: str = ""
    """What would be needed, as a sentence."""
    record: Any = field(default=None, repr=False)

    def __post_init__(self) -> None:
        self.bound("kg", mass=self.mass)

    @property
    def mass(self) -> float:
        """Of all brakes of the scenario [kg]."""
        return float(self.scenario.brakes.count * self.scenario.mass)

    @property
    def own_units(self) -> dict[str, str]:
        """{key: SI unit} of its own keys that have one."""
        return {key: self.units[key] for key in self.own if self.units[key] != "1"}

    def add(self, unit: str, **values: Any) -> None:
        """Results of one unit."""
        self.own |= values
        self.units |= dict.fromkeys(values, unit)

    def take(self, group: str, values: Mapping[str, Any], prefix: str) -> None:
        """The results of a group that is declared, with a prefix; what is not there is None."""
        for key, unit in kind_of(self.scenario.machine)["results"][group].items():
            self.add(unit, **{prefix + key: values.get(key)})

    def bound(self, unit: str, **values: Any) -> None:
        """Values that only limits are about, of one unit."""
        self.bounding |= values
        self.units |= dict.fromkeys(values, unit)

    def judge(self) -> None:
        """Add the limits that are declared for this kind of machine, with their values."""
        known = self.own | self.bounding
        allowed = known | vars(get(self.scenario, "limits"))
        self.limits += [
            Limit(
                name=bound["name"],
                value=float(known[bound["fact"]]),
                limit=float(allowed[bound["limit"]]),
                unit=self.units[bound["fact"]],
                least=bound.get("least", False),
            )
            for bound in kind_of(self.scenario.machine)["limits"]
        ]

    @property
    def feasible(self) -> bool:
        """Whether every limit is met."""
        return all(limit.met for limit in self.limits)

    @property
    def reason(self) -> str:
        """The number that decides."""
        return deciding(self.limits).sentence()

    @property
    def verdict(self) -> str:
        """The verdict as a sentence or two."""
        if self.feasible:
            return f"Feasible: of all limits the tightest is met, {self.reason}. {self.needed}"
        missed = sum(not limit.met for limit in self.limits)
        count = "one limit is" if missed == 1 else f"{missed} of {len(self.limits)} limits are"
        return f"Not feasible: {count} missed; {self.reason}. {self.needed}"


@record
class Machine(Scenario):
    """A scenario that says what its machine does, needs and may."""

    def analyse(self) -> Result:
        """The machine's answer; each machine says how."""
        raise NotImplementedError

    def slid(self, slip: float, pace: Any) -> list[Notice]:
        """What to say of chains that slipped [m] at paces [m/s]; None: speed does not count."""
        law = self.brake.brake.speed_law
        if pace is None or law is None:
            return []
        series, brake = self.brakes.series, self.brake.brake
        said = beyond(self.brake, float(np.max(pace)) / series)
        if series > 1:
            times = gathered(law, slip, series, brake)
            words = (
                f"the {series} equal brakes of a chain share its slip, as friction that grows with "
                f"speed has it; a difference between two of them grows {times:.3g} times by the "
                "end, and where that makes it large they slip one after the other, at a force that "
                "falls in between"
            )
            said.append(Notice(words, "speed-law-chain"))
        return said
