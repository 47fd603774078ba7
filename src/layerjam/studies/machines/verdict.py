"""The verdict on a machine: every limit with its value, the one that decides, and by how much."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from layerjam.studies.machines.scenario import Scenario
from layerjam.units import quantities, show


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


@dataclass(frozen=True)
class Bound:
    """A limit as a machine declares it: its name, the fact it bounds, and the limit by its name.

    The limit is an entry of the scenario's `limits`, or another fact.
    """

    name: str
    fact: str
    limit: str
    least: bool = False


class Facts:
    """What a machine found: `values` by key, SI, with their `units`.

    `bounding` holds what no result shows, but a limit is about.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.values: dict[str, Any] = {}
        self.bounding: dict[str, Any] = {"mass": scenario.mass_of_all}
        self.units = {"mass": "kg"}

    def add(self, unit: str, **values: Any) -> None:
        """Results of one unit."""
        self.values |= values
        self.units |= dict.fromkeys(values, unit)

    def bound(self, unit: str, **values: Any) -> None:
        """Values that only limits are about, of one unit."""
        self.bounding |= values
        self.units |= dict.fromkeys(values, unit)

    def limits(self, bounds: Sequence[Bound]) -> list[Limit]:
        """Every bound with its values."""
        limits = self.scenario.numbers.limits
        known = self.values | self.bounding
        own = known | {path: getattr(limits, path) for path, _, _ in quantities(type(limits))}
        return [
            Limit(
                name=bound.name,
                value=float(known[bound.fact]),
                limit=float(own[bound.limit]),
                unit=self.units[bound.fact],
                least=bound.least,
            )
            for bound in bounds
        ]

    def result(self, limits: Sequence[Limit], **more: Any) -> Result:
        """The machine's result; `more` are its other entries."""
        units = {k: unit for k, unit in self.units.items() if k in self.values and unit != "1"}
        given: dict[str, Any] = {
            "own": self.values,
            "units": units,
            "mass": self.scenario.mass_of_all,
        }
        return Result(scenario=self.scenario, limits=limits, **given, **more)


def deciding(limits: Sequence[Limit]) -> Limit:
    """The limit missed by the greatest factor, or the tightest where all are met."""
    return max(limits, key=lambda limit: (not limit.met, limit.factor))


@dataclass(frozen=True, kw_only=True)
class Result:
    """A machine's answer. `own` holds its own keys in SI, `units` theirs; `record` is drawn.

    `brakes_needed` is how many brakes it would take, None where no number does.
    """

    scenario: Scenario
    limits: Sequence[Limit]
    brakes_needed: int | None
    needed: str
    """What would be needed, as a sentence."""
    mass: float
    """Of all brakes of the scenario [kg]."""
    own: Mapping[str, Any]
    units: Mapping[str, str]
    warnings: Sequence[str] = ()
    record: Any = field(default=None, repr=False)

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
