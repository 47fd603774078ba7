"""A scenario file: the person, the load case, the brakes, and the limits of a machine.

The TOML file is read like those of brakes and lines: every number has a unit, a kind and a source.
Other entries are words (one of several, or a path) and curves ("0 2.5 4 deg"). `kinds/NAME.toml`
declares the content of a machine's scenario, its limits and its pictures.
"""

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from layerjam.bench.control.settings import Regulator
from layerjam.brake.device.brake import mass
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.fluid.line import Sensor
from layerjam.brake.fluid.line_file import LineFile, load_line
from layerjam.brake.simulate.speed import machine_notices
from layerjam.core.errors import FileError, QuantityError, UnknownNameError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.changes import find_paths
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.shipped import shipped_files
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import find_line, parse_toml
from layerjam.core.toml_files.values import TextSpec, entries, value
from layerjam.core.units import (
    QuantitySpec,
    check,
    get,
    get_spec,
    like,
    nested,
    parse,
    quantity,
    record,
    show,
)

S = TypeVar("S", bound="Scenario")
Array = npt.NDArray[np.float64]
_ROW = re.compile(r"((?:[-+.\deE]+(?:\s+|$))+)(.*)")


@record
class Brakes:
    """Identical brakes: `parallel` chains, each with `series` brakes in series."""

    parallel: int = quantity("1", "chains of brakes in parallel", lo=1, hi=10000, whole=True)
    series: int = quantity("1", "brakes in series in a chain", lo=1, hi=1000, whole=True, default=1)
    vacuum: float = quantity("Pa", "operating vacuum of the brakes", lo=1, hi=1.2e5)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Return a field that the machine's kind declares."""

    @property
    def count(self) -> int:
        """Total number of brakes."""
        return self.parallel * self.series


def word(text: str, *choices: str) -> Any:
    """Return a field for a word in a file: one of `choices`, or any text if that is empty."""
    return value(TextSpec(text=text, choices=choices, blank=False))


@dataclass(frozen=True, kw_only=True)
class Curve(QuantitySpec):
    """A sequence of numbers with one unit at the end, such as "0 2.5 4 deg"."""

    def read(self, text: object, name: str) -> Any:
        """Return the SI values, shape (N,); raises QuantityError for any other text."""
        row = _ROW.fullmatch(text.strip()) if isinstance(text, str) and len(text) < 20_000 else None
        words, unit = (row.group(1).split(), row.group(2)) if row else ([], "")
        if len(words) < 2:
            raise QuantityError.of(name, "must be a string such as '0 2.5 4 deg'")
        return self.check(np.array([parse(f"{w} {unit}", self.unit, name) for w in words]), name)

    def check(self, value: Any, name: str) -> Any:
        """Return the values if all are within bounds; otherwise raises QuantityError."""
        for number in value:
            super().check(float(number), name)
        return value


@record
class Scenario:
    """Content common to all scenarios, in SI units; each machine adds its own tables."""

    machine: str = word("kind of machine")
    brake: BrakeFile = word("catalogue name or path of a brake")
    line: LineFile = word("catalogue name or path of a vacuum line")
    brakes: Brakes = nested(Brakes)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Return a field that the machine's kind declares."""

    name: str = ""
    title: str = ""
    sources: Mapping[str, Source] = field(default_factory=dict, repr=False)
    folder: Path = field(default=Path(), repr=False)
    """Folder to which paths in the file are relative."""

    def together(self) -> None:
        """Raise QuantityError if values of the scenario contradict each other."""
        vacuum, atmosphere = self.brakes.vacuum, self.brake.brake.site.atmosphere
        if vacuum > atmosphere:
            raise QuantityError.of(
                "brakes.vacuum",
                f"{show(vacuum, 'Pa', 6)} exceeds atmospheric pressure, "
                f"{show(atmosphere, 'Pa', 6)}, the highest possible vacuum",
            )

    def warnings(self) -> list[str]:
        """Return the warnings about the values of the scenario, the brake and the line."""
        out = []
        for kind in ("assumed", "inferred", "unstated"):
            paths = [p for p in find_paths(self.sources, kind) if p not in _NAMES]
            if paths:
                note = {"unstated": "no source is stated"}.get(kind, f"{kind}, not measured")
                out.append(f"scenario: {', '.join(paths)}: {note}")
        return [*out, *self.brake.warnings(), *self.line.warnings(), *machine_notices(self.brake)]

    def list_sources(self) -> list[tuple[str, str, str]]:
        """Return (path, value with unit, source) of every entry."""
        specs = dict(entries(type(self)))
        return [
            (path, _describe_value(get(self, path), specs[path].spec), source.sentence())
            for path, source in self.sources.items()
        ]

    @property
    def mass(self) -> float:
        """Mass of one brake [kg]."""
        return mass(self.brake.brake)

    cited = list_sources  # former name


_NAMES = ("machine", "brake", "line", "safe_state")
_KNOWN: dict[str, type] = {"Sensor": Sensor, "Regulator": Regulator}
"""Records whose quantities a scenario may share."""


@cache
def load_kind(machine: str) -> dict[str, Any]:
    """Return the declaration of a kind of machine, from kinds/NAME.toml."""
    return tomllib.loads(shipped_files("layerjam.studies.machines", "kinds")[machine])


def declare_fields(machine: str) -> Callable[[type[S]], type[S]]:
    """Return a decorator that adds to a scenario class the fields that its kind declares."""

    def add_fields(cls: type[S]) -> type[S]:
        for name, declaration in load_kind(machine)["scenario"].items():
            new_field = _declared_field(declaration)
            if new_field is None:
                fields_ = {key: _declared_field(inner) for key, inner in declaration.items()}
                bases = (Brakes,) if name == "brakes" else ()
                types = {"__annotations__": dict.fromkeys(fields_, Any)}
                title = f"{cls.__name__}{name.capitalize()}"
                new_field = nested(record(type(title, bases, fields_ | types)))
            cls.__annotations__[name] = Any
            setattr(cls, name, new_field)
        return record(cls)

    return add_fields


def _declared_field(declaration: Mapping[str, Any]) -> Any:
    """Return the field that an entry declares, or None if the entry is a table of fields."""
    if "like" in declaration:
        owner, name = str(declaration["like"]).split(".")
        return like(get_spec(_KNOWN[owner], name))
    if not isinstance(declaration.get("text"), str):
        return None
    if "unit" not in declaration:
        return word(declaration["text"], *declaration.get("choices", ()))
    if declaration.get("row"):
        return value(Curve(**{key: entry for key, entry in declaration.items() if key != "row"}))
    return quantity(**declaration)


def _describe_value(value: Any, spec: Any) -> str:
    if isinstance(spec, Curve):
        return f"{len(value)} values"
    if isinstance(spec, QuantitySpec):
        return show(float(value), spec.unit)
    return str(spec.to_toml(value))


def read_scenario(
    text: str, path: object, machines: Mapping[str, type[S]], folder: Path | None = None
) -> S:
    """Return a scenario from TOML text, with paths relative to `folder`; raises FileError."""
    tables: dict[str, Any] = parse_toml(text, path)
    machine = tables.get("machine")
    if isinstance(machine, dict):
        machine = machine.get("value")
    if machine is None:
        raise FileError(path, f"machine (kind of machine: {', '.join(machines)}) is missing")
    if not isinstance(machine, str) or machine not in machines:
        reason = str(UnknownNameError("machine", str(machine), machines))
        raise FileError(path, reason, find_line(text, "machine"))
    reader = Reader(text, path, dict(entries(machines[machine])))
    reader.read_all(tables)
    reader.check_required()
    place = folder or Path()
    with reader.locate_errors():
        read: Any = reader.build_record(machines[machine])
        check(read)
        scenario: S = evolve(
            read,
            brake=load(_resolve_path(read.brake, place)),
            line=load_line(_resolve_path(read.line, place)),
            name=reader.words.get("name", str(path)),
            title=reader.words.get("title", ""),
            sources=reader.sources,
            folder=place,
        )
        scenario.together()
    return scenario


def _resolve_path(name: str, folder: Path) -> str:
    """Return the path next to the scenario file if it exists, otherwise the name unchanged."""
    local_file = folder / name
    return str(local_file) if name.endswith(".toml") and local_file.is_file() else name
