"""Header of a table: its columns with units, and the quantities that a reader requires."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.options import ColumnEntry
from layerjam.laboratory.measure.readers import words
from layerjam.laboratory.measure.readers.column_names import (
    find_role,
    rank_name,
    separate_words,
    shorten,
)
from layerjam.laboratory.measure.readers.stamps import STAMPS, unwrap_stamps
from layerjam.laboratory.measure.readers.unit_words import (
    convert_unit,
    force_unit_for,
    is_other_unit,
)
from layerjam.laboratory.measure.readers.words import normalise_name
from layerjam.laboratory.measure.trace import Array


@dataclass(frozen=True)
class Want:
    """A required quantity: its SI unit, its possible units and its possible column names.

    `words` is a pattern for lower-case names without accents, `avoid` one for names with a
    different meaning. An `optional` quantity may be missing. A pure number (SI unit "1") may have
    no unit, but must have a name: a column in % may be anything.
    """

    role: str
    si: str
    words: str
    units: tuple[str, ...]
    optional: bool = False
    avoid: str = ""

    @property
    def unit_names(self) -> str:
        """Accepted units, as text."""
        units = [f"'{unit}'" for unit in self.units]
        return " or ".join([", ".join(units[:-1]), units[-1]] if len(units) > 1 else units)

    def can_be_named(self, name: str) -> bool:
        """Return whether a name may denote this quantity."""
        return re.search(self.words, separate_words(name)) is not None

    def rank_name(self, name: str) -> int | None:
        """Return the rank of a name, 0 for the best; None if it has a different meaning."""
        if self.avoid and re.search(self.avoid, separate_words(name)):
            return None
        is_name = self.can_be_named(name)
        return None if self.si == "1" and not is_name else int(not is_name)


@dataclass(frozen=True)
class MachineWant(Want):
    """A quantity in files of test machines, with column names in many languages."""

    def can_be_named(self, name: str) -> bool:
        """Return whether the name alone identifies this quantity."""
        return find_role(name) == self.role

    def rank_name(self, name: str) -> int | None:
        """Return the rank of a name, 0 for the best; None if it has a different meaning."""
        return rank_name(self.role, name)


PULL = (
    MachineWant("time", "s", words.TIME, ("s", "ms"), optional=True),
    MachineWant("elongation", "m", words.ROLE["elongation"], ("mm", "in")),
    MachineWant("force", "N", words.FORCE, ("N", "kN", "lbf")),
)
"""Quantities of a pull or friction test."""
TIMED = tuple(replace(w, optional=w.role == "elongation") for w in PULL)
"""Quantities of a test whose elongation may be speed times time."""


@dataclass(frozen=True)
class Column:
    """A selected column: index, name and unit as written or given, and conversion to SI."""

    role: str
    index: int
    name: str
    unit: str
    factor: Fraction
    offset: float = 0.0
    given: bool = False
    """Whether the user named this column."""

    def si(self, values: Array) -> Array:
        """Return values in SI units; a factor such as 1/1000 is a division, to round only once."""
        if self.unit in STAMPS:
            return unwrap_stamps(values, self.unit)
        factor = self.factor
        if factor.numerator == 1:
            values = values / factor.denominator if factor.denominator != 1 else values
        else:
            values = values * float(factor)
        return values + self.offset if self.offset else values

    def describe(self, others: "Sequence[Column]" = (), by_unit: bool = False) -> str:
        """Describe the interpretation of the column, and the columns to which it was preferred."""
        text = f"{self.role} is the column '{shorten(self.name)}'"
        text += STAMPS.get(self.unit) or (f" in {self.unit}" if self.unit else ", a pure number")
        text += ", as given" if self.given else " (by its unit)" if by_unit else ""
        if others:
            text += ", not " + " or ".join(
                f"'{shorten(c.name)}'" + (f" in {c.unit}" if c.name == self.name else "")
                for c in others[:4]
            )
        return text


@dataclass(frozen=True)
class Header:
    """Columns of a table: names and units as written, and the line of the names.

    `style` is the position of the units: "bracket row", "plain row", "names", "units", "units
    above", "stated" or "" (none). `label` has the fields of the line above, which may contain
    specimen numbers.
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    style: str
    line: int
    label: tuple[str, ...] = ()
    path: str = ""

    @property
    def columns(self) -> list[tuple[str, str | None]]:
        """Return (name, unit) of each column."""
        return list(zip(self.names, self.units, strict=True))

    def select(self, indices: Collection[int]) -> "Header":
        """Return the header with only some columns; names and units of the others are empty."""
        names = tuple(n if i in indices else "" for i, n in enumerate(self.names))
        units = tuple(u if i in indices else None for i, u in enumerate(self.units))
        return replace(self, names=names, units=units)

    def error(self, reason: str, remedy: str = "", asks: str = "columns") -> FileError:
        """Return an error about these columns; `remedy` names the option that resolves it."""
        return FileError(self.path, reason, self.line, how=remedy, asks=asks if remedy else "")

    def describe(self) -> str:
        """Return the list of columns, for the end of an error message."""
        names = [
            f"'{shorten(n)}' [{shorten(u)}]" if u else f"'{shorten(n)}'"
            for n, u in self.columns[:8]
        ]
        return f"its columns are {', '.join(names)}" + (" and more" if self.names[8:] else "")

    def candidates(self, want: Want, entry: ColumnEntry | None = None) -> list[tuple[int, Column]]:
        """Return (rank of the name, column) of all columns that may contain the quantity."""
        candidates = []
        indices = None if entry is None else self.find_columns(entry.name or "")
        for index, (name, file_unit) in enumerate(self.columns):
            if indices is not None and index not in indices:
                continue
            unit = (entry.unit if entry else "") or file_unit or ""
            scale, rank = convert_unit(unit, want.si) if unit else None, want.rank_name(name)
            if not unit and want.si == "1" and (entry is not None or want.can_be_named(name)):
                scale = Fraction(1), 0.0
            if scale and (rank is not None or entry is not None):
                column = Column(want.role, index, name, unit, *scale, entry is not None)
                candidates.append((rank or 0, column))
        # of several columns with the name that the user gives, the unit decides
        agreeing = [c for c in candidates if entry and not find_conflict(self, c[1], want.si)]
        return agreeing or candidates

    def find_columns(self, name: str) -> list[int]:
        """Return the indices of the columns that a name given by the user means.

        A name may include its unit, as in the file. If several columns have one name,
        NAME#2 is the second; #3 is the third column of the file.
        """
        wanted_name = normalise_name(name)
        names = [normalise_name(n) for n in self.names]
        if wanted_name in names:
            return [i for i, n in enumerate(names) if n == wanted_name]
        base, mark, number = wanted_name.rpartition("#")
        if mark and number.isdigit():
            matches = [i for i, n in enumerate(names) if n == base.strip() or not base]
            return matches[int(number) - 1 : int(number)] if int(number) else []
        return [
            i
            for i, (n, u) in enumerate(self.columns)
            if u and _keep_letters(n + u) == _keep_letters(name)
        ]

    def name_column(self, index: int) -> str:
        """Return a name by which `find_columns` finds only this column, short enough to type."""
        name = " ".join(self.names[index].split())
        if not name or len(name) > 40 or not name.isprintable() or set(name) & set(',="#'):
            return f"#{index + 1}"
        indices = self.find_columns(name)
        return name if len(indices) == 1 else f"{name}#{indices.index(index) + 1}"


def _keep_letters(name: str) -> str:
    """Return the letters and digits of a name, to compare 'Load (kN)' with 'Load_kN'."""
    return re.sub(r"[^\w%°µ]|_", "", normalise_name(name))


def find_conflict(header: Header, column: Column, si: str) -> str | None:
    """Return the conflict between a column's unit in the file and the user's unit, or None."""
    file_unit = header.units[column.index]
    if not file_unit or not column.unit or not is_other_unit(file_unit, column.unit, si):
        return None
    name = shorten(header.names[column.index])
    weight = force_unit_for(file_unit) if si == "N" else None
    note = f", which as a force is {weight}" if weight else ""
    return f"column '{name}' is in '{shorten(file_unit)}'{note}, not in '{column.unit}' as given"
