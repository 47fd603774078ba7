"""`edit_line`: numbers and parts of a vacuum line changed in its own text; comments stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from layerjam.commands.answer import Answer, Quantity, si
from layerjam.commands.by_hand import what_it_was
from layerjam.commands.vacuum_line import AnyLine, line_at
from layerjam.errors import QuantityError, UnknownNameError
from layerjam.fluid.file import LineFile, read_line
from layerjam.fluid.line import Line
from layerjam.fluid.parts import FAMILIES, parts
from layerjam.records.source import KINDS
from layerjam.units import QuantitySpec, exact_text, quantities

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
    import tomlkit

    file = line_at(line, None)
    if kind not in KINDS:
        raise UnknownNameError("kind", kind, KINDS)
    document: Any = tomlkit.parse(file.text)
    for table, part in (takes or {}).items():
        _take(document, table, part)
    for path, value in (changes or {}).items():
        if path not in FIELDS:
            raise UnknownNameError("key", path, FIELDS)
        document = _changed(document, file, path, value, kind, source)
    if name is not None:
        document["name"] = name
    text = tomlkit.dumps(document)
    made = read_line(text, f"line {name or file.name}"[:80])
    return Answer(
        values={"name": made.name, "text": text}, units={}, warnings=made.warnings(), record=made
    )


def _take(document: Any, table: str, part: str | None) -> None:
    import tomlkit

    known = {path.split(".")[0] for path in FIELDS if "." in path}
    if table not in known:
        raise UnknownNameError("table", table, known)
    if part is None:
        document.pop(table, None)
        return
    if table not in FAMILIES:
        raise QuantityError(f"{table}: no parts are kept; there are {', '.join(FAMILIES)}")
    if part not in parts(table):
        raise UnknownNameError(f"part for [{table}]", part, parts(table))
    made = tomlkit.table()
    made["part"] = part
    document[table] = made


def _changed(
    document: Any, file: LineFile, path: str, value: Quantity | None, kind: str, source: str
) -> Any:
    import tomlkit

    table, _, key = path.rpartition(".")
    if table and table not in document:
        document[table] = tomlkit.table()
    place = document[table] if table else document
    if value is None:
        if key not in place:
            raise QuantityError(f"{path}: a part or the default says it; give another value")
        place.remove(key)
        return document
    spec = FIELDS[path][0]
    item = tomlkit.inline_table()
    item["value"] = _written(si(value, spec, path), spec)
    item["kind"] = kind
    item["source"] = source or what_it_was(file.line, file.sources, path, spec)
    if table or key in place:
        place[key] = item
        return document
    # a key of the whole line stands before the tables
    return tomlkit.parse(f"{key} = {item.as_string()}\n{tomlkit.dumps(document)}")


def _written(value: float, spec: QuantitySpec) -> Any:
    if spec.whole:
        return int(value)
    return value if spec.unit == "1" else exact_text(value, spec.unit)
