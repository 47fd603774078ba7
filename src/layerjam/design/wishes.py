"""What is wanted of a design: constraints, objectives, and the scatter it must stand."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from layerjam.design.grid import Asked, Grid
from layerjam.design.merit import MERITS, VARIABLES
from layerjam.device.file import BrakeFile
from layerjam.fluid.file import LineFile
from layerjam.units import show

EVERY = {**MERITS, **VARIABLES}
"""What a constraint or an objective may name."""


@dataclass(frozen=True)
class Constraint:
    """`name` at most or at least `limit` (SI)."""

    name: str
    most: bool
    limit: float

    @property
    def unit(self) -> str:
        """SI unit of the limit."""
        return EVERY[self.name].unit

    def __str__(self) -> str:
        return f"{self.name} {'<=' if self.most else '>='} {show(self.limit, self.unit)}"

    def holds(self, value: Any) -> Any:
        """Where it holds; NaN never does. A rounding of 1e-12 is let pass."""
        slack = 1e-12 * abs(self.limit)
        return value <= self.limit + slack if self.most else value >= self.limit - slack

    def short(self, value: float) -> float:
        """How far a value misses it, over the limit; 0 where it holds."""
        over = value - self.limit if self.most else self.limit - value
        return max(over, 0.0) / abs(self.limit) if self.limit else math.inf


@dataclass(frozen=True)
class Objective:
    """`name` as small or as large as can be; `weight` times ln(name) counts in the choice."""

    name: str
    least: bool
    weight: float = 1.0

    def __str__(self) -> str:
        return f"{'minimise' if self.least else 'maximise'} {self.name}"

    @property
    def sign(self) -> float:
        """1 for the least, -1 for the most."""
        return 1.0 if self.least else -1.0


@dataclass(frozen=True)
class Scatter:
    """Relative SD of static and kinetic friction, independent of each other; where from."""

    static: float
    kinetic: float
    source: str
    samples: int = 20_000
    seed: int = 1


@dataclass(frozen=True)
class Spec:
    """A specification, read and checked."""

    name: str
    brake: BrakeFile
    line: LineFile | None
    grid: Grid
    asked: Asked
    constraints: tuple[Constraint, ...]
    objectives: tuple[Objective, ...]
    scatter: Scatter | None
    text: str = field(repr=False)
    notes: tuple[str, ...] = ()
