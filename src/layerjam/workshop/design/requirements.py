"""Requirements of a design: constraints, objectives, and a stated scatter."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.simulate import prediction
from layerjam.brake.simulate.quantities import SEED
from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.values import AsItIs
from layerjam.core.units import QuantitySpec, exact_text, like, parse, quantity, show
from layerjam.workshop.design.bill import Draw
from layerjam.workshop.design.grid import Evaluation, Grid
from layerjam.workshop.design.merit import DRAWN_MERITS, MERITS, VARIABLES

NAMEABLE: Mapping[str, QuantitySpec] = MappingProxyType({**MERITS, **VARIABLES})
"""Quantities that a constraint may name."""


@dataclass(frozen=True)
class Constraint:
    """Upper or lower `limit` (SI) of the quantity `name`."""

    name: str
    most: bool
    limit: float

    @property
    def unit(self) -> str:
        """SI unit of the limit."""
        return NAMEABLE[self.name].unit

    def __str__(self) -> str:
        return (
            self.name if self == BUILDABLE else self.format_with_limit(show(self.limit, self.unit))
        )

    def format_with_limit(self, limit: str) -> str:
        """Return the constraint as text, with the limit as written in the argument."""
        return f"{self.name} {'<=' if self.most else '>='} {limit}"

    def is_met(self, value: Any) -> Any:
        """Return whether a value meets the constraint, up to rounding of 1e-12; NaN never does."""
        slack = 1e-12 * abs(self.limit)
        return value <= self.limit + slack if self.most else value >= self.limit - slack

    def shortfall(self, value: float) -> float:
        """Return the relative shortfall of a value, which is 0 if the value meets the limit."""
        excess = value - self.limit if self.most else self.limit - value
        return max(excess, 0.0) / abs(self.limit) if self.limit else math.inf


BUILDABLE = Constraint("buildable", False, 1.0)
"""Constraint that `build` accepts the design and finds it strong enough."""
DEFAULTS = ("buildable", "drawn_mass")
"""Names with which a request disables `BUILDABLE`, or limits on the mass as drawn."""


@dataclass(frozen=True)
class Objective:
    """Objective to minimise or maximise `name`; `weight` times ln(name) is part of the score."""

    name: str
    least: bool
    weight: float = 1.0

    def __str__(self) -> str:
        return f"{'minimise' if self.least else 'maximise'} {self.name}"

    @property
    def sign(self) -> float:
        """1 to minimise, -1 to maximise."""
        return 1.0 if self.least else -1.0


@dataclass(frozen=True)
class ConstraintSpec(AsItIs):
    """Form of a constraint in a file: 'mass <= 30 g'."""

    text: str = "constraint, such as 'mass <= 30 g'"

    def limits(self) -> str:
        """Return examples of the form."""
        return "'mass <= 30 g' or 'holding_force >= 300 N'"

    def read(self, text: object, name: str) -> Constraint:
        """Return the constraint; errors quote its text."""
        pattern = r"\s*(\w+)\s*(<=|>=)\s*(.+?)\s*"
        quantity, sense, limit = _match_form(pattern, text, name, "constraint", self.limits())
        unit = _quantity_spec("constraint", quantity, text).unit
        try:
            return Constraint(quantity, sense == "<=", parse(limit, unit, quantity))
        except QuantityError as err:
            err.quantity = str(text)
            raise

    def to_toml(self, value: Constraint) -> object:
        """Return text that `read` turns back into the constraint."""
        limit = repr(value.limit) if value.unit == "1" else exact_text(value.limit, value.unit)
        return value.format_with_limit(limit)


@dataclass(frozen=True)
class ObjectiveSpec(AsItIs):
    """Form of an objective in a file: 'minimise mass'."""

    text: str = "objective, such as 'minimise mass'"

    def limits(self) -> str:
        """Return examples of the form."""
        return "'minimise mass' or 'maximise force_density'"

    def read(self, text: object, name: str) -> Objective:
        """Return the objective with weight 1; errors quote its text."""
        pattern = r"\s*(minimi[sz]e|maximi[sz]e)\s+(\w+)\s*"
        sense, quantity = _match_form(pattern, text, name, "objective", self.limits())
        _quantity_spec("objective", quantity, text)
        return Objective(quantity, sense.startswith("min"))

    def to_toml(self, value: Objective) -> object:
        """Return the text; the weights are in a separate list."""
        return str(value)


def _match_form(pattern: str, text: object, name: str, kind: str, form: str) -> tuple[str, ...]:
    """Return the parts of a text; raises QuantityError if the text does not match the pattern."""
    if not isinstance(text, str):
        raise QuantityError.of(name, "must be a list of quoted strings")
    match = re.fullmatch(pattern, text)
    if not match:
        raise QuantityError(f"{kind} '{text[:60]}' is not of the form {form}", quantity=text)
    return match.groups()


def _quantity_spec(kind: str, quantity: str, text: object) -> QuantitySpec:
    specs = NAMEABLE if kind == "constraint" else MERITS
    if quantity not in specs:
        raise UnknownNameError(kind, quantity, specs, quantity=str(text))
    return specs[quantity]


_SD = "relative standard deviation of the {} friction"


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """[scatter]: SD of the friction; None means that its tests or its source determine it."""

    static: float | None = quantity("1", _SD.format("static"), hi=1, default=None)
    kinetic: float | None = quantity("1", _SD.format("kinetic"), hi=1, default=None)
    samples: int = quantity(
        "1", "number of samples", lo=100, hi=10_000_000, whole=True, default=prediction.SAMPLES
    )
    seed: int = like(SEED, default=prediction.SEED)


@dataclass(frozen=True)
class DesignSpecification:
    """Specification whose files have been read and checked: designs, constraints and objectives."""

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
    """Names of DEFAULTS that do not apply."""
    films: Mapping[str, BrakeFile] = field(default_factory=dict, repr=False)
    """Brake from which each film comes, by the film's name; films of the catalogue have none."""
    confidence: float = 0.0
    """Share of brakes that should meet all constraints; 0 if only the average brake should."""

    def set_drawing(self, draw: Draw) -> "DesignSpecification":
        """Return the specification with a function that draws brakes, and with two more rules.

        Each design must be `BUILDABLE`, and a limit on the mass applies to the mass as drawn.
        """
        rules = self.constraints
        if "drawn_mass" not in self.without:
            rules = tuple(
                evolve(c, name="drawn_mass") if c.name == "mass" and c.most else c for c in rules
            )
        if "buildable" not in self.without and BUILDABLE not in rules:
            rules = (*rules, BUILDABLE)
        return evolve(
            self,
            constraints=tuple(dict.fromkeys(rules)),
            evaluation=evolve(self.evaluation, draw=draw),
        )

    @property
    def drawn_merits(self) -> tuple[str, ...]:
        """Return the merits of the drawn brake that constraints or objectives name."""
        names = {c.name for c in self.constraints} | {o.name for o in self.objectives}
        return tuple(name for name in DRAWN_MERITS if name in names)

    @property
    def merits(self) -> tuple[str, ...]:
        """Return every merit that is computed for designs, in the order of the rows."""
        return (*self.evaluation.all_names, *self.drawn_merits)
