"""Preview of a file: its columns as written, its first rows, and their interpretation."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.measure.log import find_reference
from layerjam.laboratory.measure.options import SKIP, ReadingOptions, load_reading_options
from layerjam.laboratory.measure.readers.columns import assign_columns
from layerjam.laboratory.measure.readers.content import Source
from layerjam.laboratory.measure.readers.header import PULL, Column, Header
from layerjam.laboratory.measure.readers.lines import Lines, Rows, Table, read_lines
from layerjam.laboratory.measure.readers.numbers import are_equal_columns, read_columns
from layerjam.laboratory.measure.readers.source import load_sources
from layerjam.laboratory.measure.readers.table import (
    Block,
    find_blocks,
    make_bare_table,
    share_headers,
)
from layerjam.laboratory.measure.readers.unit_words import ROLES, convert_unit
from layerjam.laboratory.measure.trace import Array

ROWS, LETTERS, COLUMN_LIMIT = 6, 40, 40
"""Largest number of rows, of characters per cell and of columns."""


@dataclass(frozen=True)
class Preview:
    """The largest table of a file.

    `names` and `units` are as written, "column 1" and "" if missing. `rows` contains the first rows
    as text, `taken` {index of a column: (role, unit)} the interpretation, `sheets` the sheets of a
    workbook. `ours` means that this program wrote the file, so that its columns need no correction.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    taken: Mapping[int, tuple[str, str]] = field(default_factory=dict)
    sheets: tuple[str, ...] = ()
    ours: bool = False

    def columns(self, index: int, role: str, unit: str) -> str:
        """Return the `columns` option that gives column `index` a `role` and `unit`, or ignores it.

        Other columns with this role are then ignored. The option is empty if no column has a role.
        """
        roles = {i: pair for i, pair in self.taken.items() if i != index and pair[0] != role}
        if role:
            roles[index] = (role, unit)
        entries = [":".join(roles[i]) if i in roles else SKIP for i in range(len(self.names))]
        return ",".join(entries) if roles else ""


def preview_file(path: str | Path, options: ReadingOptions | None = None) -> Preview:
    """Return the table of a file for a page; raises FileError if it has no row of numbers."""
    every = (options or ReadingOptions()).over(load_reading_options(path))
    sources = load_sources(path, every.sheet)
    source = max(sources, key=lambda s: len(s.data))
    lines, block = _find_largest_block(source)
    header = _make_block_header(lines, block)
    rows: list[tuple[str, ...]] = []
    for line in range(block.first, block.last + 1):
        if len(rows) == ROWS:
            break
        if not lines.blank[line]:
            rows.append(tuple(_shorten(cell) for cell in lines.fields(line)[: block.width]))
    sheets = tuple(s.sheet for s in sources if s.sheet) if len(sources) > 1 else ()
    return Preview(
        tuple(_shorten(name) for name in header.names),
        tuple(_shorten(unit or "") for unit in header.units),
        tuple(rows),
        _assign_roles(source, _preview_table(lines, block, header), every),
        sheets,
        source.data.startswith(b"# layerjam"),
    )


def read_column(
    path: str | Path, index: int, unit: str, si: str, decimal: str | None = None
) -> Array:
    """Return the numbers in one column of a file's largest table, in SI units.

    Raises FileError if they are not numbers or the unit has the wrong dimension.
    """
    source = max(load_sources(path), key=lambda s: len(s.data))
    lines, block = _find_largest_block(source)
    scale = convert_unit(unit, si)
    if scale is None or not 0 <= index < block.width:
        raise FileError(path, f"has no column {index + 1} with the unit '{unit[:20]}'")
    rows = Rows(source, _preview_table(lines, block, _make_block_header(lines, block)))
    column = Column("value", index, f"column {index + 1}", unit, *scale, True)
    (values,) = read_columns(rows, [column], decimal or source.decimal)
    return values


def find_vacuum_columns(table: Preview) -> list[tuple[int, str]]:
    """Return (index, unit) of columns named "vacuum" (in part) with a unit of pressure."""
    columns = []
    for index, (name, unit) in enumerate(zip(table.names, table.units, strict=True)):
        scale = convert_unit(unit, "Pa") if unit else None
        if scale and find_reference(Column("pressure", index, name, unit, *scale)) == "vacuum":
            columns.append((index, unit))
    return columns


def _find_largest_block(source: Source) -> tuple[Lines, Block]:
    lines = read_lines(source)
    blocks = list(share_headers(lines, find_blocks(lines)))
    if not blocks:
        raise FileError(source.path, "contains no row of numbers")
    return lines, max(blocks, key=lambda b: (b.width >= 2, b.rows))


def _make_block_header(lines: Lines, block: Block) -> Header:
    """Return the names and units of a block, one for each field of its rows."""
    bare_header = make_bare_table(lines, block).header
    if block.table is None:
        return bare_header
    head = block.table.header
    count = min(len(head.names), block.width)
    names = head.names[:count] + bare_header.names[count:]
    units = head.units[:count] + bare_header.units[count:]
    return Header(names, units, head.style, head.line, path=head.path)


def _preview_table(lines: Lines, block: Block, header: Header) -> Table:
    bare_table = make_bare_table(lines, block)
    return Table(header, bare_table.separator, bare_table.first, bare_table.last, bare_table.rows)


def _assign_roles(
    source: Source, table: Table, options: ReadingOptions
) -> dict[int, tuple[str, str]]:
    """Return each column's role and unit; a role without a column is omitted."""
    entries = options.entries(ROLES)
    if options.by_order is not None:
        by_index = {e.index: (e.role, e.unit) for e in entries.values() if e.index is not None}
        return {i: pair for i, pair in by_index.items() if i < len(table.header.names)}
    are_equal = partial(
        are_equal_columns, Rows(source, table), decimal=options.decimal or source.decimal
    )
    roles: dict[int, tuple[str, str]] = {}
    for want in PULL:
        try:
            columns, _ = assign_columns(table.header, [want], entries, are_equal)
        except LayerjamError:
            continue
        for column in columns.values():
            roles.setdefault(column.index, (want.role, column.unit))
    return roles


def _shorten(text: str) -> str:
    """Return a cell for a page: printable, on one line, at most `LETTERS` characters."""
    printable = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return printable if len(printable) <= LETTERS else printable[: LETTERS - 1] + "…"
