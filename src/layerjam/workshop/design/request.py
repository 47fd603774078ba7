"""Design request as in its TOML file, which can be read, written, or built in code."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.mount import Site
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.changes import collect_values
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.toml_files.values import AsItIs, Entry, ListSpec, TextSpec, entries, value
from layerjam.core.toml_files.writer import plain_lines
from layerjam.core.units import QuantitySpec, get_spec, nested, show
from layerjam.workshop.design.grid import Array
from layerjam.workshop.design.merit import VARIABLES, StickSlipPull
from layerjam.workshop.design.requirements import (
    DEFAULTS,
    Constraint,
    ConstraintSpec,
    Objective,
    ObjectiveSpec,
    Scatter,
)
from layerjam.workshop.design.stopping import StopRequirement

MOST_VALUES = 1_000_000
_TEXT = TextSpec()


class Range(NamedTuple):
    """Values from the first to the last in equal steps (SI)."""

    first: float
    last: float
    step: float

    def values(self) -> Array:
        """Return all values; the last step may end below `last`."""
        steps = math.floor((self.last - self.first) / self.step * (1 + 1e-12) + 1e-9)
        # rounding to twelve digits keeps sums of steps exact, so that 13 mm stays 13 mm
        return np.array([float(f"{v:.12g}") for v in self.first + self.step * np.arange(steps + 1)])


Axis = tuple[float, ...] | Range
"""Values that one variable may have."""
_RANGE = ("from", "to", "step")


@dataclass(frozen=True)
class AxisSpec(AsItIs):
    """Form of a variable's values in a file: one value, a list, or { from, to, step }."""

    item: QuantitySpec

    @property
    def text(self) -> str:
        """Meaning of the variable."""
        return self.item.text

    def limits(self) -> str:
        """Return the limits of each value."""
        return self.item.limits()

    def read(self, text: object, name: str) -> Axis:
        """Return the values in SI; raises QuantityError for no, too many or duplicate values."""
        if not isinstance(text, dict):
            values = ListSpec(each=self.item, distinct=True, single=True).read(text, name)
            if not 0 < len(values) <= MOST_VALUES:
                raise QuantityError.of(name, f"a list must have 1 to {MOST_VALUES} values")
            return values
        if set(text) != set(_RANGE):
            raise QuantityError.of(name, "a range needs the keys from, to and step, and no others")
        spec, unit = self.item, self.item.unit
        step = QuantitySpec(unit, "step", open_lo=True, whole=spec.whole).read(text["step"], name)
        first, last = (spec.read(text[word], name) for word in _RANGE[:2])
        if last < first:
            raise QuantityError.of(
                name,
                (
                    f"from {show(first, unit)} to {show(last, unit)} is empty; 'from' must be "
                    "smaller than 'to'"
                ),
            )
        if (last - first) / step >= MOST_VALUES:
            raise QuantityError.of(name, f"more than {MOST_VALUES} values")
        return Range(first, last, step)

    def to_toml(self, value: Any) -> object:
        """Return the values as TOML stores them."""
        texts = [self.item.to_toml(v) for v in value]
        if isinstance(value, Range):
            return dict(zip(_RANGE, texts, strict=True))
        return texts if len(texts) > 1 else texts[0]


@dataclass(frozen=True, kw_only=True)
class FilmChoice:
    """[[film]]: a film from a brake or from the catalogue, with the available thicknesses."""

    use: str = value(TextSpec(text="a brake or film from the catalogue"))
    thickness: tuple[float, ...] | None = value(
        ListSpec(each=VARIABLES["thickness"], single=True), None
    )
    note: str = value(_TEXT, "")


@dataclass(frozen=True, kw_only=True)
class DesignRequest:
    """Specification file as a record: variables, constraints and objectives.

    Brake, line and films are names that are not resolved yet. `vary` maps variables to
    their values.
    """

    name: str = value(_TEXT, "")
    title: str = value(_TEXT, "")
    brake: str = value(TextSpec(text="name or path of the brake to start from"))
    line: str | None = value(TextSpec(text="name or path of a vacuum line"), None)
    atmosphere: float | None = field(
        default=None, metadata={"quantity": get_spec(Site, "atmosphere")}
    )
    constraints: tuple[Constraint, ...] = value(ListSpec(each=ConstraintSpec()), ())
    objectives: tuple[Objective, ...] = value(ListSpec(each=ObjectiveSpec()))
    without: tuple[str, ...] = value(
        ListSpec(each=TextSpec(text="constraint to disable", choices=DEFAULTS), single=True), ()
    )
    stop: StopRequirement | None = nested(StopRequirement, default=None)
    judder: StickSlipPull | None = nested(StickSlipPull, default=None)
    scatter: Scatter | None = nested(Scatter, default=None)
    film: tuple[FilmChoice, ...] = ()
    vary: Mapping[str, Axis] = field(default_factory=dict)

    def text(self) -> str:
        """Return the TOML text, which `read_request` turns back into the same request."""
        values = {**collect_values(self), "weights": tuple(o.weight for o in self.objectives)}
        lines = plain_lines(_FIELDS, values)
        for choice in self.film:
            lines += ["", "[[film]]", *plain_lines(_FILM, collect_values(choice))]
        lines += plain_lines(_VARY, {f"vary.{name}": axis for name, axis in self.vary.items()})
        return "\n".join([*lines, ""])


_WEIGHT = QuantitySpec("1", "weight of an objective", open_lo=True, hi=1e6)
_ENTRIES = dict(entries(DesignRequest))
_TABLES = {path: entry for path, entry in _ENTRIES.items() if "." in path}
_FIELDS = {p: e for p, e in _ENTRIES.items() if "." not in p} | {
    "weights": Entry(ListSpec(each=_WEIGHT)),
    **_TABLES,
}
_FILM = dict(entries(FilmChoice))
_VARY = {f"vary.{name}": Entry(AxisSpec(spec), table=True) for name, spec in VARIABLES.items()}


def open_reader(text: str, path: object) -> Reader:
    """Return a reader for the text of a specification."""
    return Reader(text, path, {**_FIELDS, **_VARY}, words={})


def read_request(reader: Reader) -> DesignRequest:
    """Return the request in the text of a specification; raises FileError with file and line."""
    tables = parse_toml(reader.text, reader.path)
    film = reader.read_rows("film", tables.pop("film", []), FilmChoice)
    reader.read_all(tables)
    reader.check_required()
    request = reader.build_record(DesignRequest)
    weights = reader.values.get("weights", (1.0,) * len(request.objectives))
    with reader.locate_errors():
        return evolve(
            request,
            name=request.name or Path(str(reader.path)).stem,
            objectives=_set_weights(request.objectives, weights),
            film=film,
            vary={p.removeprefix("vary."): reader.values[p] for p in _VARY if p in reader.values},
        )


def _set_weights(
    objectives: Sequence[Objective], weights: Sequence[float]
) -> tuple[Objective, ...]:
    if not objectives:
        raise QuantityError.of("objectives", "none is given; write, for example, ['minimise mass']")
    if len(weights) != len(objectives):
        raise QuantityError.of("weights", f"must be a list of {len(objectives)} numbers")
    if len({o.name for o in objectives}) < len(objectives):
        raise QuantityError.of("objectives", "a quantity is listed twice")
    pairs = zip(objectives, weights, strict=True)
    return tuple(evolve(o, weight=float(w)) for o, w in pairs)
