"""Reading options for ambiguous files, as one class with one syntax.

The same names are used for options of commands and in the `[read]` table of a sidecar.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from layerjam.brake.simulate.quantities import CROSSHEAD_SPEED
from layerjam.core.errors import QuantityError, explain_arguments
from layerjam.core.toml_files.reader import Reader
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.toml_files.values import ListSpec, TextSpec, entries, value
from layerjam.core.units import like, quantity
from layerjam.laboratory.measure.readers.unit_words import (
    ROLES,
    convert_unit,
    force_unit_for,
)
from layerjam.laboratory.measure.sidecar import READ, list_fact_files, read_text_or_empty

SKIP = "skip"
REFERENCES = ("absolute", "gauge", "vacuum")
"""References of a pressure: absolute, above atmospheric, below atmospheric."""


@dataclass(frozen=True)
class ColumnEntry:
    """The user's entry for one column: its role, its unit, and its name or index."""

    role: str
    unit: str
    name: str | None
    index: int | None

    def repeats(self, first: "ColumnEntry") -> bool:
        """Return whether an entry by name repeats one that a list or another option gives."""
        same_name = first.index is not None or self.name == first.name
        return self.index is None and same_name and self.unit == first.unit


@explain_arguments
@dataclass(frozen=True, kw_only=True)
class ReadingOptions:
    """Options that resolve a file's ambiguities; if empty or None, the file determines the value.

    `negative` lists which of "force" and "elongation" the machine records with the opposite sign.
    `columns` assigns the columns, in order (``time:ms,skip,force:N``) or by name
    (``force:N=Load,time=Zeit``). An entry of `column` assigns one column by its name; in Python,
    `column` may be a mapping, {"force:N": "Load"}. `decimal` is "." or ",". `specimen` is the
    number (from 1) of a specimen if a file has several. `sheet` is the name of a worksheet. `names`
    is the pattern of file names, such as "pull_{vacuum}_{speed:mm/s}_*". `speed` [m/s] is the
    crosshead speed if nothing else states it; in a file without elongation, elongation is speed
    times time. `reading` is the reference of a pressure, one of `REFERENCES`.
    """

    negative: Sequence[str] = value(ListSpec(each=TextSpec(choices=tuple(ROLES)), single=True), ())
    column: Sequence[str] | Mapping[str, str] = value(ListSpec(each=TextSpec(), single=True), ())
    columns: str | None = value(TextSpec(), None)
    decimal: str | None = value(TextSpec(choices=(".", ",")), None)
    specimen: int | None = quantity("1", "specimen number", lo=1, whole=True, default=None)
    sheet: str | None = value(TextSpec(), None)
    names: str | None = value(TextSpec(), None)
    speed: float | None = like(CROSSHEAD_SPEED, default=None)
    reading: str | None = value(TextSpec(choices=REFERENCES), None)

    def __post_init__(self) -> None:
        for name, entry in entries(ReadingOptions):
            setting = getattr(self, name)
            if isinstance(entry.spec, ListSpec):
                if isinstance(setting, Mapping):
                    setting = [f"{role}={column}" for role, column in setting.items()]
                setting = (setting,) if isinstance(setting, str) else tuple(setting)
                object.__setattr__(self, name, entry.spec.check(setting, name))
            elif setting is not None:
                entry.spec.check(setting, name)

    @classmethod
    def complete(cls, options: Any) -> "ReadingOptions":
        """Return the options, given them or some of their fields in another record, or None."""
        if options is None or isinstance(options, ReadingOptions):
            return options or cls()
        return cls(**{f.name: getattr(options, f.name) for f in fields(options)})

    def over(self, sidecar: "ReadingOptions") -> "ReadingOptions":
        """Return these options combined with those of the `sidecar`; these take precedence."""
        settings = {f.name: v for f in fields(self) if (v := getattr(self, f.name))}
        if self.column and sidecar.by_order:  # an explicit name overrides the order in the sidecar
            settings["columns"] = self.columns
        return replace(sidecar, **settings)

    @property
    def by_order(self) -> list[str] | None:
        """Return the entries of `columns` if they are in file order, otherwise None."""
        if self.columns is None or "=" in self.columns:
            return None
        return [entry.strip() for entry in self.columns.split(",")]

    def entries(self, roles: Mapping[str, str]) -> dict[str, ColumnEntry]:
        """Return {role: entry of its column} for the required `roles` {role: SI unit}.

        Raises QuantityError for an invalid entry, a unit that does not suit the role, or a repeated
        role.
        """
        order = self.by_order
        out: dict[str, ColumnEntry] = {}
        texts = (
            [*self.column, *_split_names(self.columns or "")] if order is None else [*self.column]
        )
        for index, text in [*enumerate(order or ()), *((None, text) for text in texts)]:
            if index is not None and text == SKIP:
                continue
            entry = _parse_entry(text, index, roles)
            first = out.get(entry.role)
            if first is not None and entry.repeats(first):
                continue
            if first is not None:
                raise QuantityError(f"columns: {entry.role} is given twice")
            out[entry.role] = entry
        if self.columns is not None and not out:
            raise QuantityError(
                f"columns: '{self.columns[:40]}' does not name a column; {_list_roles(roles)}"
            )
        return out


def _split_names(columns: str) -> list[str]:
    """Return ROLE=NAME entries; a part without "=" and its comma belong to the previous name."""
    out: list[str] = []
    for part in columns.split(",") if columns else ():
        if out and "=" not in part:
            out[-1] += "," + part
        else:
            out.append(part)
    return out


def _parse_entry(text: str, index: int | None, roles: Mapping[str, str]) -> ColumnEntry:
    assignment, _, name = text.partition("=")
    role, _, unit = (part.strip() for part in assignment.partition(":"))
    if role not in roles or (index is None and not name.strip()):
        form = "ROLE:UNIT or skip" if index is not None else "ROLE:UNIT=NAME"
        raise QuantityError(
            f"columns: '{text[:40]}' is not of the form {form}; {_list_roles(roles)}"
        )
    si = roles[role]
    if convert_unit(unit, si) is None and (unit or (index is not None and si != "1")):
        fault = f"'{unit[:20]}' is not a unit of {role}" if unit else f"{role} has no unit"
        weight = force_unit_for(unit) if si == "N" else None
        fault += ", a unit of mass" if weight else ""
        raise QuantityError(f"columns: {fault}; give a unit such as {role}:{weight or si}")
    return ColumnEntry(role, unit, name.strip() if index is None else None, index)


def _list_roles(roles: Mapping[str, str]) -> str:
    return f"the allowed roles are {', '.join(roles)}"


KEYS = tuple(f.name for f in fields(ReadingOptions))
"""Keys of the `[read]` table, named like the options of the commands."""
_FIELDS = dict(entries(ReadingOptions, f"{READ}."))


def load_reading_options(path: str | Path) -> ReadingOptions:
    """Return the options in the `[read]` table of the sidecar or the folder's conditions.toml.

    Raises FileError, with file and line, for an unknown key or an invalid value.
    """
    of_all, of_file = (_read_options(place) for place in list_fact_files(path))
    return of_file.over(of_all)


def _read_options(place: Path) -> ReadingOptions:
    text = read_text_or_empty(place)
    reader = Reader(text, place, _FIELDS)
    reader.read_all({k: v for k, v in parse_toml(text, place).items() if k == READ})
    options = reader.build_record(ReadingOptions, f"{READ}.")
    with reader.locate_errors(READ):
        options.entries(ROLES)
    return options
