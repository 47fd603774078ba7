"""The verdict on a machine: every limit with its value, the one that decides, and by how much."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from layerjam.studies.machines.scenario import Scenario
from layerjam.units import show


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
        return {
            "name": self.name, "value": self.value, "limit": self.limit, "unit": self.unit,
            "least": self.least, "met": self.met,
        }  # fmt: skip

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
