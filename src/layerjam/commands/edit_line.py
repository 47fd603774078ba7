"""`edit_line`: numbers and parts of a vacuum line changed in its own text; comments stay."""

from __future__ import annotations

from collections.abc import Mapping

from layerjam.commands.answer import Answer, Quantity
from layerjam.commands.by_hand import set_by_hand
from layerjam.commands.vacuum_line import AnyLine, line_at
from layerjam.errors import QuantityError, UnknownNameError
from layerjam.fluid.line import Line
from layerjam.fluid.parts import FAMILIES, parts
from layerjam.units import QuantitySpec, quantities

FIELDS: dict[str, tuple[QuantitySpec, bool]] = {
    path: (spec, required) for path, spec, required in quantities(Line)
}
"""{dotted path: (specification, required)} of every number of a line; a flow curve is none."""


def edit_line(
    line: AnyLine,
    changes: Mapping[str, Quantity | None] | None = None,
    *,
    takes: Mapping[str, str | None] | None = None,
    name: str | None = None,
    kind: str = "assumed",
    source: str = "",
) -> Answer:
    """A line with other numbers or parts; `record` is its LineFile, `text` its file.

    `changes` maps a dotted path to text with a unit, an SI number, or None: what the part or the
    default says. `takes` maps a table to a part of the catalogue, which takes the whole table's
    place, or to None: the line has no such thing; these come first. `kind` and `source` say where
    new numbers come from. Raises UnknownNameError, QuantityError for a bad value, and FileError for
    what makes no line, such as a tube without a bore.
    """
    file = line_at(line, None)
    tables = {table: _part(table, part) for table, part in (takes or {}).items()}
    given = set_by_hand(file, changes or {}, FIELDS, kind, source)
    made = file.edited(given, name=name, tables=tables)
    values = {"name": made.name, "text": made.text}
    return Answer(values=values, units={}, warnings=made.warnings(), record=made)


def _part(table: str, part: str | None) -> dict[str, str] | None:
    """A line's table that takes a part of the catalogue; None for no such table."""
    known = {path.split(".")[0] for path in FIELDS if "." in path}
    if table not in known:
        raise UnknownNameError("table", table, known)
    if part is None:
        return None
    if table not in FAMILIES:
        raise QuantityError.of(table, f"no parts are kept; there are {', '.join(FAMILIES)}")
    if part not in parts(table):
        raise UnknownNameError(f"part for [{table}]", part, parts(table))
    return {"part": part}
