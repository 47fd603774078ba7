"""Assignment of columns to quantities, by units first, then by names in several languages.

A unit has priority over a name: a column in s is the time, whatever its name. Among several columns
of one dimension, the name determines the choice (standard travel before absolute crosshead
position), and the trace states the choice. If neither identifies it, the file is rejected.
"""

import re
import unicodedata
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from layerjam.errors import FileError
from layerjam.measure.options import SKIP, ColumnEntry
from layerjam.measure.readers import words
from layerjam.measure.readers.unit_words import (
    common_unit,
    convert_unit,
    is_other_unit,
    unit_role,
    weight_unit,
)
from layerjam.measure.readers.words import normalise_name
from layerjam.measure.trace import Array


@dataclass(frozen=True)
class Want:
    """A required quantity: its SI unit, its possible units and its possible column names.

    `words` is a pattern for lower-case names without accents, `avoid` one for names with a
    different meaning. An `optional` quantity may be missing. A pure number (SI unit "1") has no
    unit.
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
        return int(not self.can_be_named(name))


def separate_words(name: str) -> str:
    """Return a name in lower case with its words separated by blanks, such as "p abs"."""
    return normalise_name(name).replace("_", " ")


@dataclass(frozen=True)
class MachineWant(Want):
    """A quantity in files of test machines, with column names in many languages."""

    def can_be_named(self, name: str) -> bool:
        """Return whether the name alone identifies this quantity."""
        return find_role(name) == self.role

    def rank_name(self, name: str) -> int | None:
        """Return the rank of a name, 0 for the best; None if it has a different meaning."""
        return _rank_name(self.role, name)


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
        factor = self.factor
        if factor.numerator == 1:
            values = values / factor.denominator if factor.denominator != 1 else values
        else:
            values = values * float(factor)
        return values + self.offset if self.offset else values

    def describe(self, others: "Sequence[Column]" = (), by_unit: bool = False) -> str:
        """Describe the interpretation of the column, and the columns to which it was preferred."""
        text = f"{self.role} is the column '{shorten(self.name)}'"
        text += f" in {self.unit}" if self.unit else ", a pure number"
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
        for index, (name, file_unit) in enumerate(self.columns):
            if entry is not None and normalise_name(name) != normalise_name(entry.name or ""):
                continue
            unit = (entry.unit if entry else "") or file_unit or ""
            scale, rank = convert_unit(unit, want.si) if unit else None, want.rank_name(name)
            if not unit and want.si == "1" and (entry is not None or want.can_be_named(name)):
                scale = Fraction(1), 0.0
            if scale and (rank is not None or entry is not None):
                column = Column(want.role, index, name, unit, *scale, entry is not None)
                candidates.append((rank or 0, column))
        return candidates


def assign_by_order(
    header: Header, wants: Sequence[Want], entries: Mapping[str, ColumnEntry], count: int
) -> "Assignment":
    """Return the columns in the user's order; raises FileError if the file has more or fewer."""
    if count != len(header.names):
        raise header.error(
            f"has {len(header.names)} columns",
            f", but --columns lists {count}; write one entry per column, '{SKIP}' for unused ones",
        )
    columns = {}
    for want in wants:
        if (entry := entries.get(want.role)) is not None and entry.index is not None:
            known = convert_unit(entry.unit, want.si) or (Fraction(1), 0.0)
            name = header.names[entry.index]
            columns[want.role] = Column(want.role, entry.index, name, entry.unit, *known, True)
        elif not want.optional:
            raise header.error(f"the list has no column of {want.role}", f": {columns_hint(wants)}")
    return columns, [column.describe() for column in columns.values()]


Assignment = tuple[dict[str, Column], list[str]]
"""{role: column}, and sentences that describe the interpretation."""


def assign_columns(
    header: Header,
    wants: Sequence[Want],
    entries: Mapping[str, ColumnEntry],
    same: Callable[[Sequence[Column]], bool] | None = None,
) -> Assignment:
    """Return the column of each required quantity, and sentences that describe the choice.

    `same` returns whether several columns are the same measurement; the first is then used. Raises
    FileError if a column is missing or ambiguous, or has no unit or a unit of the wrong dimension.
    """
    columns: dict[str, Column] = {}
    sentences = []
    for want in wants:
        candidates = header.candidates(want, entries.get(want.role))
        if not candidates:
            if want.role in entries or not want.optional:
                raise header.error(*_explain_missing(header, want, entries.get(want.role)))
            sentences += _note_unread_column(header, want)
            continue
        best = min(rank for rank, _ in candidates)
        first = [c for rank, c in candidates if rank == best]
        spare = want.optional and want.role == "time"
        if len(first) > 1 and not spare and not (same and same(first)):
            names = " or ".join(f"'{shorten(c.name)}'" for c in first[:4])
            raise header.error(
                f"does not state which column is the {want.role}: {names}; name one",
                f" (--columns {want.role}=NAME)",
            )
        columns[want.role] = column = first[0]
        if column.given and (conflict := _find_conflict(header, column, want.si)):
            raise header.error(
                f"{conflict}; give the unit that the file states",
                ", or, if the file is wrong, list its columns in order "
                f"(--columns {want.role}:{column.unit},{SKIP},...)",
            )
        others = [c for _, c in candidates if c is not column]
        by_unit = isinstance(want, MachineWant) and not want.can_be_named(column.name)
        sentences.append(column.describe(others, by_unit))
    return columns, sentences


def has_all_columns(
    header: Header, entries: Mapping[str, ColumnEntry], wants: Sequence[Want] = PULL
) -> bool:
    """Return whether there is a column for every required quantity."""
    return all(header.candidates(w, entries.get(w.role)) for w in wants if not w.optional)


def columns_hint(wants: Sequence[Want]) -> str:
    """Return a hint on how to name the columns."""
    due = ",".join(f"{w.role}:{w.units[0]}" for w in wants if not w.optional)
    return f"write --columns {due} ({SKIP}: not used)"


def _explain_missing(header: Header, want: Want, entry: ColumnEntry | None) -> tuple[str, str]:
    for name, unit in header.columns:
        if (
            entry is not None
            and normalise_name(name) == normalise_name(entry.name or "")
            and not unit
        ):
            return _explain_unit(want, name, unit)
        if entry is None and want.can_be_named(name):
            return _explain_unit(want, name, unit)
    mass_columns = [(n, u) for n, u in header.columns if u and weight_unit(u)]
    if entry is None and want.si == "N" and len(mass_columns) == 1:
        return _explain_unit(want, *mass_columns[0])
    if entry is not None:
        name = shorten(entry.name or "")
        return f"has no column '{name}' with a unit of {want.role}; {header.describe()}", ""
    return (
        f"has no column with a unit of {want.role} ({want.unit_names}); {header.describe()}",
        f" (specify it: --columns {want.role}:{want.units[0]}=NAME)",
    )


def _note_unread_column(header: Header, want: Want) -> list[str]:
    for name, unit in header.columns:
        if want.can_be_named(name):
            reason = (
                f"is in '{shorten(unit)}', which is not a unit of {want.role}"
                if unit
                else "has no unit"
            )
            return [f"the {want.role} is not read: column '{shorten(name)}' {reason}"]
    return []


def _find_conflict(header: Header, column: Column, si: str) -> str | None:
    """Return the conflict between a column's unit in the file and the user's unit, or None."""
    file_unit = header.units[column.index]
    if not file_unit or not column.unit or not is_other_unit(file_unit, column.unit, si):
        return None
    name = shorten(header.names[column.index])
    weight = weight_unit(file_unit) if si == "N" else None
    means = f", which as a force is {weight}" if weight else ""
    return f"column '{name}' is in '{shorten(file_unit)}'{means}, not in '{column.unit}' as given"


def list_unit_conflicts(
    header: Header, columns: Mapping[str, Column], wants: Sequence[Want]
) -> list[str]:
    """Return the conflicts between the units in the file and those that the user lists."""
    conflicts = [_find_conflict(header, columns[w.role], w.si) for w in wants if w.role in columns]
    return [f"{conflict}; the given unit takes precedence" for conflict in conflicts if conflict]


def _explain_unit(want: Want, name: str, unit: str | None) -> tuple[str, str]:
    role, label = want.role, shorten(name)
    if not unit:
        say = f" (specify it: --columns {role}:{want.units[0]}='{label}')"
        return f"column '{label}' has no unit; {role} needs a unit such as {want.unit_names}", say
    text = f"column '{label}' is in '{shorten(unit)}', which is not a unit of {role}"
    weight = weight_unit(unit) if want.si == "N" else None
    if weight:
        return (
            f"{text}, a unit of mass; if its weight is meant, that is {weight}",
            f" (then give --columns {role}:{weight}='{label}')",
        )
    if is_other_unit(unit, want.units[0], want.si):
        return f"{text}; name another column", f" (--columns {role}:{want.units[0]}=NAME)"
    return (
        f"{text}; it needs a unit such as {want.unit_names}",
        f" (specify it: --columns {role}:UNIT='{label}')",
    )


def shorten(text: str) -> str:
    """Return a text for a message: printable, on one line, at most forty characters."""
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return text if len(text) <= 40 else text[:37] + "..."


_BRACKETS = re.compile(r"[(\[<{【]\s*([^()\[\]<>{}【】]*?)\s*[)\]>}】]")
_LAST_WORD = re.compile(r"(.*?)(?:\s*[,:;_|\-]\s*|\s+)([^\s,:;_|\-]{1,12})", re.DOTALL)
_CAMEL = re.compile(r"(.*[a-z])(kN|mN|N|MM|mm|MS|ms|Mm|Ms)")


def split_unit(text: str) -> tuple[str, str | None]:
    """Split names such as "Force (kN)", "Kraft / kN" or "Load, N" into (name, unit or None)."""
    text = unicodedata.normalize("NFKC", text).strip()
    match = re.fullmatch(rf"(.*?)\s*{_BRACKETS.pattern}", text, re.DOTALL)
    if match and unit_role(match[2]):
        return match[1].strip(), match[2]
    for inner in _BRACKETS.finditer(text):  # for example: Load (N) Specimen 2, Time (s).1
        if unit_role(inner[1]):
            name_left = f"{text[: inner.start()].strip()} {text[inner.end() :].strip()}"
            return name_left.strip(), inner[1]
    if match:
        return match[1].strip(), match[2]
    for mark in ("/", " in "):
        name, slash, unit = text.rpartition(mark)
        if slash and (unit_role(unit) or (weight_unit(unit) and find_role(name) == "force")):
            return name.strip(), unit.strip()
    return _split_bare_unit(text)


def _split_bare_unit(text: str) -> tuple[str, str | None]:
    """Split off a unit without a bracket or slash if it suits the name."""
    if len(text) > 80:
        return text, None
    match = _LAST_WORD.fullmatch(text)
    if match and (found_role := common_unit(match[2])):
        name_role = find_role(match[1])
        strong = re.search(r"[,:;_|]\s*$", text[: match.start(2)]) is not None
        if name_role == found_role[0] or (name_role is None and strong and match[1].strip()):
            return match[1].strip(), match[2]
    if match and weight_unit(match[2]) and find_role(match[1]) == "force":
        return match[1].strip(), match[2]  # Load, g: the unit is reported as a mass
    match = _CAMEL.fullmatch(text)
    if match and (found_role := common_unit(match[2])) and find_role(match[1]) == found_role[0]:
        return match[1].strip(), match[2]
    return text, None


def _strip_origin(text: str) -> str:
    """Return a name without its reference: "extension from preload" is not a load."""
    return re.sub(r"\b(from|after|since|at|ab|bei) (pre-?load|vorkraft)\b", "", text)


def find_role(name: str) -> str | None:
    """Return the role that a column's name alone implies."""
    text = _strip_origin(normalise_name(name))
    if re.search(words.OTHER_QUANTITY, text):
        return None
    if re.search(words.TIME, text):
        return "time"
    if re.search(words.FORCE, text):
        return "force"
    if re.search(words.ROLE["elongation"], text) and not re.search(words.SENSOR, text):
        return "elongation"
    return None


def _rank_name(role: str, name: str) -> int | None:
    """Return the rank of a name for a role, 0 for the best; None if it has a different meaning."""
    text = _strip_origin(normalise_name(name))
    if role == "time":
        if re.fullmatch(r"(time|zeit|temps|tiempo|tempo|prufzeit|testzeit|temps d'essai)", text):
            return 0
        return 1 if re.search(words.TIME, text) else 2
    if role == "force":
        if re.search(words.TIME, text) or find_role(name) == "elongation":
            return None
        if not re.search(words.FORCE, text):
            return 3
        return 1 if re.search(words.OTHER_FORCE, text) else 0
    if re.search(words.NOT_TRAVEL, text) or find_role(name) in ("force", "time"):
        return None
    if re.search("absol", text):
        return 3
    if re.search(words.SENSOR, text):
        return 4
    if re.search(words.CROSSHEAD, text):
        return 1 if re.search(words.TRAVEL, text) else 2
    return 0 if re.search(words.TRAVEL, text) else 5
