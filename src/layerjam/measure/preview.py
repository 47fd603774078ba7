"""How a file looks: its columns as written, its first rows, and what is made of each column now."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.log import reference_of
from layerjam.measure.options import SKIP, ReadingOptions, options_beside
from layerjam.measure.readers.columns import PULL, Column, Header, assign
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.lines import Lines, read_lines
from layerjam.measure.readers.numbers import read_columns, same
from layerjam.measure.readers.rows import Rows, Table
from layerjam.measure.readers.source import load_sources
from layerjam.measure.readers.table import Block, bare_table, blocks_of, under_one_head
from layerjam.measure.readers.unit_words import ROLES, convert
from layerjam.measure.trace import Array

ROWS, LETTERS, MOST = 6, 40, 40
"""Rows, letters of a cell, and columns that are shown."""


@dataclass(frozen=True)
class Preview:
    """The largest table of a file.

    `names` and `units` as written, "column 1" and "" where nothing is; `rows` its first ones as
    text; `taken` {index of a column: (role, unit) that it is read as}. `sheets` are those of a
    workbook. `ours`: written by this program, whose columns need no correction.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    taken: Mapping[int, tuple[str, str]] = field(default_factory=dict)
    sheets: tuple[str, ...] = ()
    ours: bool = False

    def columns(self, index: int, role: str, unit: str) -> str:
        """The option `columns` where the column `index` is `role` in `unit` too; no role: ignored.

        Another column that had the role loses it; empty where no column is left.
        """
        said = {i: one for i, one in self.taken.items() if i != index and one[0] != role}
        if role:
            said[index] = (role, unit)
        entries = [":".join(said[i]) if i in said else SKIP for i in range(len(self.names))]
        return ",".join(entries) if said else ""


def preview(path: str | Path, options: ReadingOptions | None = None) -> Preview:
    """The table of a file as a page shows it; FileError where it holds no row of numbers."""
    every = (options or ReadingOptions()).over(options_beside(path))
    sources = load_sources(path, every.sheet)
    source = max(sources, key=lambda s: len(s.data))
    lines, block = _largest(source)
    header = _header(lines, block)
    rows: list[tuple[str, ...]] = []
    for line in range(block.first, block.last + 1):
        if len(rows) == ROWS:
            break
        if not lines.blank[line]:
            rows.append(tuple(_cut(cell) for cell in lines.fields(line)[: block.width]))
    sheets = tuple(s.sheet for s in sources if s.sheet) if len(sources) > 1 else ()
    return Preview(
        tuple(_cut(name) for name in header.names),
        tuple(_cut(unit or "") for unit in header.units),
        tuple(rows),
        _taken(source, _table(lines, block, header), every),
        sheets,
        source.data.startswith(b"# layerjam"),
    )


def column_of(
    path: str | Path, index: int, unit: str, si: str, decimal: str | None = None
) -> Array:
    """The numbers of one column of a file's largest table, in SI units.

    Raises FileError where they are none, or the unit is none of the quantity.
    """
    source = max(load_sources(path), key=lambda s: len(s.data))
    lines, block = _largest(source)
    known = convert(unit, si)
    if known is None or not 0 <= index < block.width:
        raise FileError(path, f"has no column {index + 1} in '{unit[:20]}'")
    rows = Rows(source, _table(lines, block, _header(lines, block)))
    column = Column("value", index, f"column {index + 1}", unit, *known, True)
    (values,) = read_columns(rows, [column], decimal or source.decimal)
    return values


def vacuum_columns(shown: Preview) -> list[tuple[int, str]]:
    """(index, unit) of columns whose name says vacuum and whose unit is one of pressure."""
    found = []
    for index, (name, unit) in enumerate(zip(shown.names, shown.units, strict=True)):
        known = convert(unit, "Pa") if unit else None
        if known and reference_of(Column("pressure", index, name, unit, *known)) == "vacuum":
            found.append((index, unit))
    return found


def _largest(source: Source) -> tuple[Lines, Block]:
    lines = read_lines(source)
    blocks = list(under_one_head(lines, blocks_of(lines)))
    if not blocks:
        raise FileError(source.path, "holds no row of numbers")
    return lines, max(blocks, key=lambda b: (b.width >= 2, b.rows))


def _header(lines: Lines, block: Block) -> Header:
    """The names and units of a block, as many as its rows have fields."""
    bare = bare_table(lines, block).header
    if block.table is None:
        return bare
    head = block.table.header
    count = min(len(head.names), block.width)
    names = head.names[:count] + bare.names[count:]
    units = head.units[:count] + bare.units[count:]
    return Header(names, units, head.style, head.line, path=head.path)


def _table(lines: Lines, block: Block, header: Header) -> Table:
    bare = bare_table(lines, block)
    return Table(header, bare.separator, bare.first, bare.last, bare.rows)


def _taken(source: Source, table: Table, options: ReadingOptions) -> dict[int, tuple[str, str]]:
    """What each column is read as, role by role; a role that no column has is left out."""
    said = options.entries(ROLES)
    if options.by_order is not None:
        listed = {e.index: (e.role, e.unit) for e in said.values() if e.index is not None}
        return {i: one for i, one in listed.items() if i < len(table.header.names)}
    alike = partial(same, Rows(source, table), decimal=options.decimal or source.decimal)
    made: dict[int, tuple[str, str]] = {}
    for want in PULL:
        try:
            found, _ = assign(table.header, [want], said, alike)
        except LayerjamError:
            continue
        for column in found.values():
            made.setdefault(column.index, (want.role, column.unit))
    return made


def _cut(text: str) -> str:
    """A cell for a page: printable, in one line, not long."""
    plain = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return plain if len(plain) <= LETTERS else plain[: LETTERS - 1] + "…"
