"""What a user says of a file where the file leaves something open: one record, one syntax.

The same words serve as options of the commands and as the `[read]` table of a sidecar.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

from layerjam.errors import QuantityError
from layerjam.measure.readers.unit_words import ROLES, convert, weight_unit
from layerjam.measure.sidecar import READ, places, text_of
from layerjam.records.reader import Reader
from layerjam.records.toml import parse_toml
from layerjam.records.values import ListSpec, TextSpec, entries, value
from layerjam.simulate.quantities import CROSSHEAD_SPEED
from layerjam.units import like, quantity

SKIP = "skip"
REFERENCES = ("absolute", "gauge", "vacuum")
"""What a pressure may count from: nothing, the atmosphere upwards, the atmosphere downwards."""


@dataclass(frozen=True)
class ColumnEntry:
    """What the user says of one column: its role, its unit, and its name or its index."""

    role: str
    unit: str
    name: str | None
    index: int | None


@dataclass(frozen=True, kw_only=True)
class ReadingOptions:
    """Answers to what a file leaves open; what is empty or None is left to the file.

    `negative`: of "force" and "elongation", those the machine counts the other way round. `columns`
    says what each column is, in order (``time:ms,skip,force:N``) or by name
    (``force:N=Load,time=Zeit``); an entry of `column` does so for one name. `decimal`: "." or ",".
    `specimen`: which of several in a file, from 1. `sheet`: of a workbook, by name. `names`: what
    the names of the files say, such as "pull_{vacuum}_{speed:mm/s}_*". `speed` [m/s]: of the
    crosshead, where nothing else states it; where a file holds no elongation, that is speed times
    time. `reading`: the reference of a pressure, one of `REFERENCES`.
    """

    negative: Sequence[str] = value(ListSpec(each=TextSpec(choices=tuple(ROLES)), single=True), ())
    column: Sequence[str] = value(ListSpec(each=TextSpec(), single=True), ())
    columns: str | None = value(TextSpec(), None)
    decimal: str | None = value(TextSpec(choices=(".", ",")), None)
    specimen: int | None = quantity("1", "number of the specimen", lo=1, whole=True, default=None)
    sheet: str | None = value(TextSpec(), None)
    names: str | None = value(TextSpec(), None)
    speed: float | None = like(CROSSHEAD_SPEED, default=None)
    reading: str | None = value(TextSpec(choices=REFERENCES), None)

    def __post_init__(self) -> None:
        for name, entry in entries(ReadingOptions):
            given = getattr(self, name)
            if isinstance(entry.spec, ListSpec):
                given = (given,) if isinstance(given, str) else tuple(given)
                object.__setattr__(self, name, entry.spec.check(given, name))
            elif given is not None:
                entry.spec.check(given, name)

    def over(self, beside: ReadingOptions) -> ReadingOptions:
        """The options of both; where both speak, these count."""
        own = {f.name: v for f in fields(self) if (v := getattr(self, f.name))}
        if (
            self.column and beside.by_order
        ):  # a name that is given outranks an order beside the file
            own["columns"] = self.columns
        return replace(beside, **own)

    @property
    def by_order(self) -> list[str] | None:
        """The entries of `columns` where they follow the file's order, else None."""
        if self.columns is None or "=" in self.columns:
            return None
        return [entry.strip() for entry in self.columns.split(",")]

    def entries(self, roles: Mapping[str, str]) -> dict[str, ColumnEntry]:
        """{role: what is said of its column}; `roles` are the ones that are wanted, with SI units.

        Raises QuantityError for an entry that is none, for a unit that is none of its role, and
        for a role that is given twice.
        """
        order, out = self.by_order, {}
        named = [*self.column, *_named(self.columns or "")] if order is None else [*self.column]
        for index, text in [*enumerate(order or ()), *((None, text) for text in named)]:
            if index is not None and text == SKIP:
                continue
            entry = _entry(text, index, roles)
            if entry.role in out:
                raise QuantityError(f"columns: {entry.role} is given twice")
            out[entry.role] = entry
        if self.columns is not None and not out:
            raise QuantityError(f"columns: '{self.columns[:40]}' names no column; {_known(roles)}")
        return out


def _named(columns: str) -> list[str]:
    """ROLE=NAME entries; a part without "=" belongs to the name before it, which holds a comma."""
    out: list[str] = []
    for part in columns.split(",") if columns else ():
        if out and "=" not in part:
            out[-1] += "," + part
        else:
            out.append(part)
    return out


def _entry(text: str, index: int | None, roles: Mapping[str, str]) -> ColumnEntry:
    said, _, name = text.partition("=")
    role, _, unit = (part.strip() for part in said.partition(":"))
    if role not in roles or (index is None and not name.strip()):
        form = "ROLE:UNIT or skip" if index is not None else "ROLE:UNIT=NAME"
        raise QuantityError(f"columns: '{text[:40]}' is not of the form {form}; {_known(roles)}")
    si = roles[role]
    if convert(unit, si) is None and (unit or (index is not None and si != "1")):
        what = f"'{unit[:20]}' is no unit of {role}" if unit else f"{role} has no unit"
        weight = weight_unit(unit) if si == "N" else None
        what += ", a unit of mass" if weight else ""
        raise QuantityError(f"columns: {what}; give one such as {role}:{weight or si}")
    return ColumnEntry(role, unit, name.strip() if index is None else None, index)


def _known(roles: Mapping[str, str]) -> str:
    return f"roles are {', '.join(roles)}"


KEYS = tuple(f.name for f in fields(ReadingOptions))
"""Of the `[read]` table, named as the options of the commands."""
_FIELDS = dict(entries(ReadingOptions, f"{READ}."))


def options_beside(path: str | Path) -> ReadingOptions:
    """What the `[read]` table of the file's sidecar says, or that of its folder's conditions.toml.

    Raises FileError, with file and line, for an unknown key or a value that is none.
    """
    of_all, own = (_read(place) for place in places(path))
    return own.over(of_all)


def _read(place: Path) -> ReadingOptions:
    text = text_of(place)
    reader = Reader(text, place, _FIELDS)
    reader.take({k: v for k, v in parse_toml(text, place).items() if k == READ})
    options = reader.record(ReadingOptions, f"{READ}.")
    with reader.locate_errors(READ):
        options.entries(ROLES)
    return options
