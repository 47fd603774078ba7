"""Verdict on a machine: every limit and its value, and the decisive limit and its factor."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from layerjam.brake.simulate.speed import speed_notices
from layerjam.core.brief import brief
from layerjam.core.errors import Notice
from layerjam.core.units import get, record, show
from layerjam.studies.machines.restraint import difference_growth
from layerjam.studies.machines.scenario import Scenario, load_kind


@dataclass(frozen=True, kw_only=True)
class Limit:
    """A value and its `limit`, which is an upper limit, or a lower one if `least` is set.

    Both are in SI units; `value` is not finite if it is never reached.
    """

    name: str
    value: float
    limit: float
    unit: str
    least: bool = False

    @property
    def is_met(self) -> bool:
        """Whether the limit is met."""
        if math.isnan(self.value):
            return False
        return self.value >= self.limit if self.least else self.value <= self.limit

    @property
    def factor(self) -> float:
        """Factor by which the limit is missed; below 1 if it is met."""
        top, bottom = (self.limit, self.value) if self.least else (self.value, self.limit)
        if math.isnan(self.value):
            return math.inf
        if bottom <= 0:
            return math.inf if top > 0 else 0.0
        return top / bottom

    def row(self) -> dict[str, Any]:
        """Return the limit for JSON."""
        return asdict(self) | {"met": self.is_met}

    def sentence(self) -> str:
        """Return the value, limit and factor as a sentence."""
        value = show(self.value, self.unit) if math.isfinite(self.value) else "never reached"
        side = "at least" if self.least else "at most"
        sentence = f"{self.name} is {value}; {side} {show(self.limit, self.unit)} is allowed"
        if self.is_met or not math.isfinite(self.factor):
            return sentence
        return f"{sentence} (missed by a factor of {self.factor:.3g})"

    met = is_met  # former name


def find_deciding_limit(limits: Sequence[Limit]) -> Limit:
    """Return the limit missed by the largest factor or, if all are met, the tightest one."""
    return max(limits, key=lambda limit: (not limit.is_met, limit.factor))


@brief
@dataclass(kw_only=True)
class Result:
    """Result of a machine; `own` contains machine-specific results in SI units, `units` the units.

    `bounding` contains values for limits that are not results; `record` is used for drawings.
    """

    scenario: Scenario
    own: dict[str, Any] = field(default_factory=dict)
    bounding: dict[str, Any] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    limits: list[Limit] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    brakes_needed: int | None = None
    """Number of brakes required; None if no number is sufficient."""
    needed: str = ""
    """Requirements, as a sentence."""
    record: Any = field(default=None, repr=False)

    def __post_init__(self) -> None:
        self.add_bounds("kg", mass=self.mass)

    @property
    def mass(self) -> float:
        """Mass of all brakes in the scenario [kg]."""
        return float(self.scenario.brakes.count * self.scenario.mass)

    @property
    def own_units(self) -> dict[str, str]:
        """{key: SI unit} of those of the machine's own results that have a unit."""
        return {key: self.units[key] for key in self.own if self.units[key] != "1"}

    def add(self, unit: str, **values: Any) -> None:
        """Add results that have the same unit."""
        self.own |= values
        self.units |= dict.fromkeys(values, unit)

    def add_group(self, group: str, values: Mapping[str, Any], prefix: str) -> None:
        """Add the results of a group declared by the kind, with a prefix; None if missing."""
        for key, unit in load_kind(self.scenario.machine)["results"][group].items():
            self.add(unit, **{prefix + key: values.get(key)})

    def add_bounds(self, unit: str, **values: Any) -> None:
        """Add values, all in one unit, that are used only in limits."""
        self.bounding |= values
        self.units |= dict.fromkeys(values, unit)

    def add_limits(self) -> None:
        """Add the limits declared for this kind of machine, with their values."""
        values = self.own | self.bounding
        bounds = values | vars(get(self.scenario, "limits"))
        self.limits += [
            Limit(
                name=bound["name"],
                value=float(values[bound["fact"]]),
                limit=float(bounds[bound["limit"]]),
                unit=self.units[bound["fact"]],
                least=bound.get("least", False),
            )
            for bound in load_kind(self.scenario.machine)["limits"]
        ]

    @property
    def feasible(self) -> bool:
        """Whether every limit is met."""
        return all(limit.is_met for limit in self.limits)

    @property
    def reason(self) -> str:
        """Decisive limit as a sentence."""
        return find_deciding_limit(self.limits).sentence()

    @property
    def verdict(self) -> str:
        """Verdict in one or two sentences."""
        if self.feasible:
            return f"Feasible: the tightest limit is met, {self.reason}. {self.needed}"
        missed_count = sum(not limit.is_met for limit in self.limits)
        count = (
            "one limit is"
            if missed_count == 1
            else f"{missed_count} of {len(self.limits)} limits are"
        )
        return f"Not feasible: {count} missed; {self.reason}. {self.needed}"

    take, bound, judge = add_group, add_bounds, add_limits  # former names


@record
class Machine(Scenario):
    """A scenario with its analysis."""

    def analyse(self) -> Result:
        """Return the result; implemented by each machine."""
        raise NotImplementedError

    def note_slip(self, slip: float, pace: Any) -> list[Notice]:
        """Return notices about chains that slip by `slip` [m] at `pace` [m/s] with a speed law."""
        if pace is None:
            return []
        series, brake = self.brakes.series, self.brake.brake
        speed = float(np.max(pace)) / series
        notices = speed_notices(self.brake, speed)
        if series > 1:
            times = difference_growth(slip, speed, series, brake)
            words = (
                f"the {series} identical brakes of a chain are assumed to share its slip equally, "
                f"as friction grows with speed. A difference between two grows {times:.3g}-fold "
                "by the end. If it becomes large, they slip one after another, and the "
                "force falls in between"
            )
            notices.append(Notice(words, "speed-law-chain"))
        return notices

    slid = note_slip  # former name
