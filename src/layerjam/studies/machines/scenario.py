"""A scenario file: who wears the machine, what happens to it, its brakes, and what may not be.

TOML, read with the same reader as brakes and lines: every number with its unit, its kind and its
source. Beside numbers there are words (one of several, or a path) and curves ("0 2.5 4 deg").
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.device.brake import mass
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.errors import FileError, QuantityError, UnknownNameError
from layerjam.fluid.file import LineFile, load_line
from layerjam.records.changes import paths_of
from layerjam.records.reader import Reader
from layerjam.records.source import Source
from layerjam.records.toml import line_of, parse_toml
from layerjam.records.values import Entry, TextSpec, entries
from layerjam.units import (
    QuantitySpec,
    check,
    get,
    parse,
    quantities,
    quantity,
    record,
    show,
)

Array = npt.NDArray[np.float64]
_ROW = re.compile(r"((?:[-+.\deE]+(?:\s+|$))+)(.*)")


@record
class Brakes:
    """Equal brakes: `parallel` chains side by side, each of `series` brakes end to end."""

    parallel: int = quantity("1", "chains of brakes side by side", lo=1, hi=10000, whole=True)
    series: int = quantity(
        "1", "brakes end to end in a chain", lo=1, hi=1000, whole=True, default=1
    )
    vacuum: float = quantity("Pa", "vacuum the brakes are used at", lo=1, hi=1.2e5)

    @property
    def count(self) -> int:
        """Brakes in all."""
        return self.parallel * self.series


@dataclass(frozen=True, kw_only=True)
class Word(TextSpec):
    """A word of the file: one of `choices`, or any text where there are none."""

    blank: bool = False


@dataclass(frozen=True, kw_only=True)
class Curve(QuantitySpec):
    """Numbers in a row with one unit at the end, such as "0 2.5 4 deg"."""

    def read(self, text: object, name: str) -> Any:
        """The SI values, shape (N,); raises QuantityError for what is no such row."""
        row = _ROW.fullmatch(text.strip()) if isinstance(text, str) and len(text) < 20_000 else None
        words, unit = (row.group(1).split(), row.group(2)) if row else ([], "")
        if len(words) < 2:
            raise QuantityError.of(name, "must be numbers and a unit in one text, '0 2.5 4 deg'")
        return np.array([self.check(parse(f"{w} {unit}", self.unit, name), name) for w in words])


@dataclass(frozen=True, kw_only=True)
class Kind:
    """What the file of one machine holds: a record of numbers, and words and curves by path."""

    numbers: type
    words: Mapping[str, Word] = field(default_factory=dict)
    curves: Mapping[str, Curve] = field(default_factory=dict)
    line: bool = True
    """Whether it needs a vacuum line."""
    regulated: bool = False
    """Whether a regulator runs, whose safe state must then be declared."""
    together: Callable[[Scenario], None] | None = None
    """Raises QuantityError for values that contradict each other."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scenario:
    """One scenario; `numbers` is the record of its machine, in SI units."""

    name: str
    machine: str
    numbers: Any
    words: Mapping[str, str]
    curves: Mapping[str, Array]
    sources: Mapping[str, Source] = field(repr=False)
    brake: BrakeFile
    line: LineFile | None = None
    title: str = ""
    text: str = field(default="", repr=False)
    folder: Path = field(default=Path(), repr=False)

    def warnings(self) -> list[str]:
        """What every result has to say about the scenario's numbers, the brake's and the line's."""
        out = []
        for kind in ("assumed", "inferred", "unstated"):
            paths = [p for p in paths_of(self.sources, kind) if p not in _NAMES]
            if paths:
                word = {"unstated": "no source is stated"}.get(kind, f"{kind}, not measured")
                out.append(f"scenario: {', '.join(paths)}: {word}")
        line = [] if self.line is None else self.line.warnings()
        return [*out, *self.brake.warnings(), *line]

    def cited(self) -> list[tuple[str, str, str]]:
        """(path, value with unit, where it is from) of every entry."""
        made = []
        for path, source in self.sources.items():
            spec = dict((p, m) for p, m, _ in quantities(type(self.numbers))).get(path)
            if spec is not None:
                value = show(float(get(self.numbers, path)), spec.unit)
            elif path in self.curves:
                value = f"{len(self.curves[path])} values"
            else:
                value = self.words[path]
            made.append((path, value, source.sentence()))
        return made

    @property
    def known_line(self) -> LineFile:
        """The vacuum line of a machine that needs one; raises QuantityError for any other."""
        if self.line is None:
            raise QuantityError.of("line", f"a {self.machine} has no vacuum line")
        return self.line

    @property
    def mass(self) -> float:
        """Mass of one brake [kg]."""
        return mass(self.brake.brake)

    @property
    def mass_of_all(self) -> float:
        """Mass of all brakes [kg]."""
        return float(self.numbers.brakes.count * self.mass)


_NAMES = ("machine", "brake", "line", "safe_state")
_HEAD = {
    "machine": Word(text="which machine"),
    "brake": Word(text="catalogue name or path of a brake"),
    "line": Word(text="catalogue name or path of a vacuum line"),
    "safe_state": Word(text="where a fault ends", choices=("release", "hold")),
}


def read_scenario(
    text: str, path: object, kinds: Mapping[str, Kind], folder: Path | None = None
) -> Scenario:
    """A Scenario from TOML text; FileError with file and line for what it cannot be.

    `folder` is where paths inside the file start from.
    """
    tables: dict[str, Any] = parse_toml(text, path)
    named = tables.get("machine")
    if isinstance(named, dict):
        named = named.get("value")
    if named is None:
        raise FileError(path, f"machine ({_HEAD['machine'].text}: {', '.join(kinds)}) is missing")
    if not isinstance(named, str) or named not in kinds:
        reason = str(UnknownNameError("machine", str(named), kinds))
        raise FileError(path, reason, line_of(text, "machine"))
    kind = kinds[named]
    head = {p: w for p, w in _HEAD.items() if p != "line" or kind.line}
    fields = dict(entries(kind.numbers))
    fields |= {p: Entry(word, True) for p, word in kind.words.items()}
    fields |= {p: Entry(curve, True) for p, curve in kind.curves.items()}
    fields |= {p: Entry(w, p != "safe_state" or kind.regulated) for p, w in head.items()}
    reader = Reader(text, path, fields)
    reader.take(tables)
    reader.require()
    values, where = reader.values, folder or Path()
    with reader.located():
        numbers: Any = reader.record(kind.numbers)
        check(numbers)
        scenario = Scenario(
            name=reader.words.get("name", str(path)),
            machine=named,
            numbers=numbers,
            words={p: values[p] for p in (*kind.words, *head) if p in values},
            curves={p: values[p] for p in kind.curves},
            sources=reader.sources,
            brake=load(_placed(values["brake"], where)),
            line=load_line(_placed(values["line"], where)) if kind.line else None,
            title=reader.words.get("title", ""),
            text=text,
            folder=where,
        )
        _check_vacuum(scenario)
        if kind.together is not None:
            kind.together(scenario)
    return scenario


def _check_vacuum(scenario: Scenario) -> None:
    """Raise QuantityError for a vacuum above the atmosphere of the brake's site."""
    vacuum, most = scenario.numbers.brakes.vacuum, scenario.brake.brake.site.atmosphere
    if vacuum > most:
        raise QuantityError.of(
            "brakes.vacuum",
            f"{show(vacuum, 'Pa', 6)} is more than the atmosphere, "
            f"{show(most, 'Pa', 6)}; a vacuum is at most that",
        )


def _placed(name: str, folder: Path) -> str:
    """A path beside the scenario file where there is one, else the name as it stands."""
    beside = folder / name
    return str(beside) if name.endswith(".toml") and beside.is_file() else name
