"""A vacuum line's TOML file, from the catalogue or the user's own.

`part = "NAME"` in [pump], [valve] or [sensor] takes a part of the catalogue with its sources; what
stands beside it in the table comes before the part's own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from layerjam.device.shipped import shipped, text_of
from layerjam.device.source import Source
from layerjam.device.toml import Reader, line_of, parse_toml
from layerjam.errors import FileError, LayerjamError
from layerjam.fluid.curve import CURVE
from layerjam.fluid.line import Line, validate
from layerjam.fluid.parts import FAMILIES, part_entries
from layerjam.units import QuantitySpec, build, quantities

_FIELDS: dict[str, tuple[QuantitySpec, bool]] = {p: (m, r) for p, m, r in quantities(Line)}
_FIELDS["pump.curve"] = (CURVE, False)
_DUE = ("chamber.volume", "pump.flow")


@dataclass(frozen=True, kw_only=True)
class LineFile:
    """A line with its name, and where each of its numbers comes from."""

    name: str
    line: Line
    sources: Mapping[str, Source] = field(repr=False)
    text: str = field(repr=False)
    title: str = ""
    parts: Mapping[str, str] = field(default_factory=dict)
    """Parts of the catalogue, by table."""

    def warnings(self) -> list[str]:
        """What every result made with this line has to say about its numbers."""
        out = []
        for kind, word in (("inferred", "inferred"), ("assumed", "assumed values")):
            paths = [p for p, s in self.sources.items() if s.kind == kind]
            if paths:
                out.append(f"{', '.join(paths)} of {self.name}: {word}, not measured")
        return out


def _texts() -> dict[str, str]:
    return shipped("layerjam.fluid", "catalogue", "lines")


def lines() -> list[str]:
    """Names of the lines in the catalogue."""
    return list(_texts())


def load_line(line: str | Path) -> LineFile:
    """A line by catalogue name, or from the path of its TOML file.

    Raises UnknownNameError (with the nearest names) or FileError.
    """
    return read_line(*text_of("line", line, _texts()))


def read_line(text: str, path: object) -> LineFile:
    """A LineFile from TOML text; FileError with file and line for what it cannot be."""
    tables: dict[str, Any] = parse_toml(text, path)
    reader = Reader(text, path, _FIELDS)
    parts = _with_parts(tables, reader)
    reader.take(tables)
    due = [p for p in _DUE if p not in reader.values]
    if "pump.curve" in reader.values and "pump.flow" in due:
        due.remove("pump.flow")
    for table in {p.split(".")[0] for p in reader.values if "." in p}:
        due += [
            p for p, (_, r) in _FIELDS.items()
            if r and p.startswith(f"{table}.") and p not in reader.values and p not in due
        ]  # fmt: skip
    if due:
        what = ", ".join(f"{p} ({_FIELDS[p][0].text})" for p in due[:4])
        raise FileError(path, f"{what} {'is' if len(due) == 1 else 'are'} missing")
    try:
        line = build(Line, reader.values)
        validate(line)
    except LayerjamError as err:
        raise FileError(path, str(err), line_of(text, str(err).split(":")[0])) from None
    name = tables.get("name")
    if not isinstance(name, str) or not name.strip():
        raise FileError(path, "name is missing", line_of(text, "name"))
    return LineFile(
        name=name, line=line, sources=reader.sources, text=text, parts=parts,
        title=str(tables.get("title", "")),
    )  # fmt: skip


def _with_parts(tables: dict[str, Any], reader: Reader) -> dict[str, str]:
    """Replace `part` in a line's tables by the part's entries; gives the names."""
    found = {}
    for family in FAMILIES:
        table = tables.get(family)
        if not isinstance(table, dict) or "part" not in table:
            continue
        beside = {k: v for k, v in table.items() if k != "part"}
        try:
            tables[family] = part_entries(family, table["part"], beside)
        except LayerjamError as err:
            raise reader.fail(f"{family}.part", str(err)) from None
        found[family] = table["part"]
    return found
