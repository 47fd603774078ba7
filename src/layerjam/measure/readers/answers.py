"""Answers to what a file leaves open: given with a command, or in its sidecar's `[read]` table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from layerjam.device.toml import line_of, parse_toml, read_text
from layerjam.errors import FileError, LayerjamError, QuantityError, UnknownNameError
from layerjam.measure.readers.columns import Choices
from layerjam.measure.readers.own import Own
from layerjam.measure.readers.specimens import Specimen
from layerjam.measure.sidecar import READ, sidecar_path
from layerjam.measure.trace import Trace

KEYS = ("negative", "column", "decimal", "columns", "specimen", "sheet")
"""Of the table, named as the options of the commands."""
_MANY = ("negative", "column")


def choices_of(
    negative: Sequence[str] = (),
    column: Sequence[str] = (),
    decimal: str | None = None,
    columns: str | None = None,
    specimen: int | None = None,
    sheet: str | None = None,
) -> Choices:
    """Choices in the words of the options; LayerjamError for what is none.

    `column` entries are ROLE[:UNIT]=NAME, `columns` is ROLE:UNIT,skip,... in the file's order.
    """
    names, units = {}, {}
    for entry in column:
        said, equals, name = entry.partition("=")
        role, colon, unit = said.partition(":")
        if not (equals and name):
            raise QuantityError(f"--column: '{said}' is not of the form force='Standard force'")
        names[role] = name
        if colon:
            units[role] = unit
    return Choices(
        negative=tuple(negative), columns=names, decimal=decimal, units=units,
        places=tuple(e.strip() for e in columns.split(",")) if columns else (),
        specimen=specimen, sheet=sheet,
    )  # fmt: skip


def answers_beside(path: str | Path) -> Choices:
    """What the `[read]` table of the file's sidecar answers; nothing where there is none.

    Raises FileError, with file and line, for an unknown key or a value that is none.
    """
    beside = sidecar_path(path)
    try:
        if not beside.exists():
            return Choices()
    except (OSError, ValueError):  # a name too long or with a NUL is no sidecar either
        return Choices()
    text = read_text(beside)
    table = parse_toml(text, beside).get(READ)
    if table is None:
        return Choices()
    try:
        return _choices(table)
    except LayerjamError as err:
        raise FileError(beside, str(err), line_of(text, READ)) from None


def _choices(table: object) -> Choices:
    if not isinstance(table, Mapping):
        raise QuantityError(f"{READ} is a table: [{READ}], and below it lines such as decimal")
    said: dict[str, Any] = {}
    for key, value in table.items():
        if key not in KEYS:
            raise UnknownNameError(f"key in [{READ}]", key, KEYS)
        said[key] = _value(key, value)
    return choices_of(**said)


def _value(key: str, value: object) -> Any:
    if key in _MANY:
        several = [value] if isinstance(value, str) else value
        if not isinstance(several, list) or not all(isinstance(v, str) for v in several):
            raise QuantityError(f"{key} must be a text in quotes or a list of such")
        return several
    if key == "specimen":
        if isinstance(value, bool) or not isinstance(value, int):
            raise QuantityError("specimen must be a whole number, 1 or more")
        return value
    if not isinstance(value, str):
        raise QuantityError(f"{key} must be a text in quotes")
    return value


def over(given: Choices, beside: Choices) -> Choices:
    """The answers of both; where both speak, `given` counts."""
    return replace(beside, **{f.name: v for f in fields(Choices) if (v := getattr(given, f.name))})


@dataclass(frozen=True)
class Opened:
    """A specimen of a file that is not read yet, and what the sidecar answers of it."""

    one: Specimen | Own
    beside: Choices

    @property
    def label(self) -> str:
        """What the file calls it."""
        return self.one.label

    def read(self, choices: Choices) -> Trace:
        """The trace; FileError as the readers raise it."""
        trace = self.one.read(over(choices, self.beside))
        if self.beside == Choices():
            return trace
        said = (*trace.understood, f"read with the answers in [{READ}] of its sidecar")
        return replace(trace, understood=said)
