"""What a design must and should do: constraints, objectives, and the scatter it must stand."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from layerjam.design.bill import Draw
from layerjam.design.grid import Evaluation, Grid
from layerjam.design.merit import DRAWN_MERITS, MERITS, VARIABLES
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError, UnknownNameError
from layerjam.fluid.file import LineFile
from layerjam.records.values import AsItIs
from layerjam.units import QuantitySpec, exact_text, parse, show

NAMEABLE: Mapping[str, QuantitySpec] = MappingProxyType({**MERITS, **VARIABLES})
"""What a constraint may name."""


@dataclass(frozen=True)
class Constraint:
    """`name` at most or at least `limit` (SI)."""

    name: str
    most: bool
    limit: float

    @property
    def unit(self) -> str:
        """SI unit of the limit."""
        return NAMEABLE[self.name].unit

    def __str__(self) -> str:
        return self.name if self == BUILDABLE else self.saying(show(self.limit, self.unit))

    def saying(self, limit: str) -> str:
        """The constraint as a sentence, its limit in the words given."""
        return f"{self.name} {'<=' if self.most else '>='} {limit}"

    def holds(self, value: Any) -> Any:
        """Where it holds; NaN never does. A rounding of 1e-12 is let pass."""
        slack = 1e-12 * abs(self.limit)
        return value <= self.limit + slack if self.most else value >= self.limit - slack

    def short(self, value: float) -> float:
        """How far a value misses it, over the limit; 0 where it holds."""
        over = value - self.limit if self.most else self.limit - value
        return max(over, 0.0) / abs(self.limit) if self.limit else math.inf


BUILDABLE = Constraint("buildable", False, 1.0)
"""Holds if `build` neither refuses a design nor finds it too weak."""
DEFAULTS = ("buildable", "drawn_mass")
"""Names by which a request turns off `BUILDABLE`, and limits on the mass as drawn."""


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
class ConstraintSpec(AsItIs):
    """How a file says a constraint: 'mass <= 30 g'."""

    text: str = "what must hold, such as 'mass <= 30 g'"

    def limits(self) -> str:
        """The form."""
        return "'mass <= 30 g' or 'holding_force >= 300 N'"

    def read(self, text: object, name: str) -> Constraint:
        """The constraint; errors are about its own text."""
        pattern = r"\s*(\w+)\s*(<=|>=)\s*(.+?)\s*"
        wanted, sense, limit = _words(pattern, text, name, "constraint", self.limits())
        unit = _known("constraint", wanted, text).unit
        try:
            return Constraint(wanted, sense == "<=", parse(limit, unit, wanted))
        except QuantityError as err:
            err.quantity = str(text)
            raise

    def to_toml(self, value: Constraint) -> object:
        """The text that `read` turns back into it."""
        limit = repr(value.limit) if value.unit == "1" else exact_text(value.limit, value.unit)
        return value.saying(limit)


@dataclass(frozen=True)
class ObjectiveSpec(AsItIs):
    """How a file says an objective: 'minimise mass'."""

    text: str = "what is wanted, such as 'minimise mass'"

    def limits(self) -> str:
        """The form."""
        return "'minimise mass' or 'maximise force_density'"

    def read(self, text: object, name: str) -> Objective:
        """The objective, of weight 1; errors are about its own text."""
        pattern = r"\s*(minimi[sz]e|maximi[sz]e)\s+(\w+)\s*"
        sense, wanted = _words(pattern, text, name, "objective", self.limits())
        _known("objective", wanted, text)
        return Objective(wanted, sense.startswith("min"))

    def to_toml(self, value: Objective) -> object:
        """The text; the weight stands in a list of its own."""
        return str(value)


def _words(pattern: str, text: object, name: str, what: str, form: str) -> tuple[str, ...]:
    """The parts of a sentence; raises QuantityError for one of another form."""
    if not isinstance(text, str):
        raise QuantityError.of(name, "must be a list of texts in quotes")
    match = re.fullmatch(pattern, text)
    if not match:
        raise QuantityError(f"{what} '{text[:60]}' is not of the form {form}", quantity=text)
    return match.groups()


def _known(what: str, wanted: str, said: object) -> QuantitySpec:
    known = NAMEABLE if what == "constraint" else MERITS
    if wanted not in known:
        raise UnknownNameError(what, wanted, known, quantity=str(said))
    return known[wanted]


@dataclass(frozen=True)
class Scatter:
    """Relative SD of static and kinetic friction, independent of each other; where from."""

    static: float
    kinetic: float
    source: str
    samples: int = 20_000
    seed: int = 1


@dataclass(frozen=True)
class DesignSpecification:
    """A specification with its files, read and checked: the designs and how they are judged."""

    name: str
    brake: BrakeFile
    line: LineFile | None
    grid: Grid
    evaluation: Evaluation
    constraints: tuple[Constraint, ...]
    objectives: tuple[Objective, ...]
    scatter: Scatter | None
    text: str = field(repr=False)
    notes: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    """Those of DEFAULTS that do not apply."""

    def drawn_by(self, draw: Draw) -> DesignSpecification:
        """Return the specification with what draws its brakes, and the constraints it allows.

        Each design must be `BUILDABLE`, and a limit on the mass applies to the mass as drawn.
        """
        rules = self.constraints
        if "drawn_mass" not in self.without:
            rules = tuple(
                replace(c, name="drawn_mass") if c.name == "mass" and c.most else c for c in rules
            )
        if "buildable" not in self.without and BUILDABLE not in rules:
            rules = (*rules, BUILDABLE)
        return replace(
            self,
            constraints=tuple(dict.fromkeys(rules)),
            evaluation=replace(self.evaluation, draw=draw),
        )

    @property
    def drawn(self) -> tuple[str, ...]:
        """Merits of the drawn brake that a constraint or an objective names."""
        named = {c.name for c in self.constraints} | {o.name for o in self.objectives}
        return tuple(name for name in DRAWN_MERITS if name in named)

    @property
    def merits(self) -> tuple[str, ...]:
        """Every merit that is computed of designs, in the order of their rows."""
        return (*self.evaluation.all_names, *self.drawn)
