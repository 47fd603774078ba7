"""Answers to what a file leaves open: given with a command, or in its sidecar's `[read]` table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

from layerjam.errors import QuantityError
from layerjam.measure.readers.columns import Choices
from layerjam.measure.readers.own import Own
from layerjam.measure.readers.specimens import Specimen
from layerjam.measure.sidecar import READ, sidecar_path, text_beside
from layerjam.measure.trace import Trace
from layerjam.records.reader import Reader
from layerjam.records.toml import parse_toml
from layerjam.records.values import Entry, ListSpec, TextSpec
from layerjam.units import QuantitySpec

_TEXTS = ListSpec(each=TextSpec(), single=True)
_FIELDS = {
    f"{READ}.{key}": Entry(spec)
    for key, spec in (
        ("negative", _TEXTS),
        ("column", _TEXTS),
        ("decimal", TextSpec()),
        ("columns", TextSpec()),
        ("specimen", QuantitySpec("1", "number of the specimen", lo=1, whole=True)),
        ("sheet", TextSpec()),
    )
}
KEYS = tuple(path.removeprefix(f"{READ}.") for path in _FIELDS)
"""Of the table, named as the options of the commands."""


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
        negative=tuple(negative),
        columns=names,
        decimal=decimal,
        units=units,
        places=tuple(e.strip() for e in columns.split(",")) if columns else (),
        specimen=specimen,
        sheet=sheet,
    )


def answers_beside(path: str | Path) -> Choices:
    """What the `[read]` table of the file's sidecar answers; nothing where there is none.

    Raises FileError, with file and line, for an unknown key or a value that is none.
    """
    beside, text = sidecar_path(path), text_beside(path)
    reader = Reader(text, beside, _FIELDS)
    reader.take({k: v for k, v in parse_toml(text, beside).items() if k == READ})
    with reader.located(READ):
        return choices_of(**{k.removeprefix(f"{READ}."): v for k, v in reader.values.items()})


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
