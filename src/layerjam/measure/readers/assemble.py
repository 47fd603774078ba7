"""From a table found in a file to a checked trace; what all readers share."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from layerjam.errors import FileError, Notice
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.columns import Column, Taken
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.grid import Grid, Table, read_grid
from layerjam.measure.readers.lines import pieces
from layerjam.measure.readers.numbers import read_columns
from layerjam.measure.sidecar import read_facts
from layerjam.measure.trace import Array, Trace, checked

_PIECE = 24_000_000
"""Bytes of a table that are cut into fields at once."""
SYNTHETIC = re.compile(rb"(?i)\bsynthetic\b")


class Rows:
    """The rows of a table, cut into fields once for all the specimens side by side in it."""

    def __init__(self, source: Source, table: Table, shared: bool) -> None:
        self.source = source
        self.table = table
        self.shared = shared

    @cached_property
    def grid(self) -> Grid:
        """Its fields."""
        return read_grid(self.source, self.table, ragged=self.shared)

    def read(self, columns: Sequence[Column], decimal: str | None) -> tuple[list[Array], Grid]:
        """Columns in SI units, and the rows they were taken from."""
        source, table = self.source, self.table
        plain = table.separator == "," and b'"' not in source.data[table.first : table.last]
        indices, names = [c.index for c in columns], [c.name for c in columns]
        if self.shared or (table.last or len(source.data)) - table.first <= _PIECE:
            grid = self.grid.until_empty(indices) if self.shared else self.grid
            raw = read_columns(grid, indices, names, decimal, plain)
        else:
            raw, grid = self._in_pieces(indices, names, decimal, plain)
        return [c.si(v) for v, c in zip(raw, columns, strict=True)], grid

    def _in_pieces(
        self, indices: Sequence[int], names: Sequence[str], decimal: str | None, plain: bool
    ) -> tuple[list[Array], Grid]:
        """The same for a large table, of which only one piece at a time is cut into fields."""
        parts, lines = [], []
        for first, last in pieces(self.source.data, self.table.first, self.table.last):
            end = last if last < len(self.source.data) else self.table.last
            grid = read_grid(self.source, replace(self.table, first=first, last=end))
            parts.append(read_columns(grid, indices, names, decimal, plain))
            lines.append(grid.lines)
        raw = [np.concatenate(column) for column in zip(*parts, strict=True)]
        return raw, replace(grid, text=b"", lines=np.concatenate(lines))

    def same(self, columns: Sequence[Column], decimal: str | None) -> bool:
        """Whether columns differ by nothing but where they begin, to a ten-thousandth."""
        try:
            first, *others = (v - v[0] for v in self.read(columns, decimal)[0])
        except FileError:
            return False  # a column that cannot be read is another's
        range_ = float(np.ptp(first))
        return all(float(np.abs(v - first).max()) <= 1e-4 * range_ for v in others)


def trace_of(
    rows: Rows, taken: Taken, options: ReadingOptions, form: str, decimal: str | None
) -> Trace:
    """The trace of columns already taken, in SI units, checked and with the sidecar's facts."""
    source, table = rows.source, rows.table
    columns, said = list(taken[0].values()), list(taken[1])
    raw, grid = rows.read(columns, decimal)
    values = {c.role: v for c, v in zip(columns, raw, strict=True)}
    for role in ("force", "elongation"):
        if role in options.negative:
            values[role] = -values[role]
            said.append(f"the sign of the {role} was turned, as asked")
    facts = read_facts(source.path)
    warnings: list[str] = []
    if facts.synthetic or SYNTHETIC.search(source.data[: table.first]):
        facts = replace(facts, synthetic=True)
        warnings.append(Notice("synthetic: written by a program, not measured", "synthetic"))
    if not grid.ended:
        warnings.append("the last line has no line end: the file may have been cut off there")
    trace = Trace(
        values["force"],
        values["elongation"],
        values.get("time"),
        source.path,
        form,
        understood=tuple(said),
        warnings=tuple(warnings),
        facts=facts,
    )
    return checked(trace, grid.line, turned="force" in options.negative)
