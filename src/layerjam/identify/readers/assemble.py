"""From a table found in a file to a checked trace; what all readers share."""

from __future__ import annotations

import re

from layerjam.identify.columns import Choices, Column, assign
from layerjam.identify.readers.numbers import Array, read_columns
from layerjam.identify.readers.source import Source
from layerjam.identify.readers.table import Table, read_grid
from layerjam.identify.sidecar import read_facts
from layerjam.identify.trace import Trace, checked

SYNTHETIC = re.compile(rb"(?i)\bsynthetic\b")


def assemble(
    source: Source, table: Table, choices: Choices, name: str, decimal: str | None = None
) -> Trace:
    """The trace of a table whose columns are known by unit and name."""
    taken, sentences = assign(table.names, table.units, source.path, table.line, choices)
    return trace_of(source, table, taken, sentences, choices, name, decimal or choices.decimal)


def trace_of(
    source: Source,
    table: Table,
    taken: dict[str, Column],
    sentences: list[str],
    choices: Choices,
    name: str,
    decimal: str | None,
) -> Trace:
    """The trace of columns already assigned, in SI, checked and with the sidecar's facts."""
    grid = read_grid(source, table)
    columns = list(taken.values())
    plain = table.separator == "," and b'"' not in source.data[table.first :]
    raw = read_columns(grid, [c.index for c in columns], [c.name for c in columns], decimal, plain)
    values = {c.role: _si(v, c) for c, v in zip(columns, raw, strict=True)}
    for role in ("force", "elongation"):
        if role in choices.negative:
            values[role] = -values[role]
            sentences = [*sentences, f"the sign of the {role} was turned, as asked"]
    facts, warnings = read_facts(source.path), []
    if facts.synthetic or SYNTHETIC.search(source.data[: table.first]):
        warnings.append("synthetic: written by a program, not measured")
    if not grid.ended:
        warnings.append("the last line has no line end: the file may have been cut off there")
    trace = Trace(
        values["force"],
        values["elongation"],
        values.get("time"),
        source.path,
        name,
        tuple(sentences),
        tuple(warnings),
        facts,
    )
    return checked(trace, grid.line)


def _si(values: Array, column: Column) -> Array:
    """Times the factor to SI; a factor such as 1/1000 divides, which rounds once."""
    factor = column.factor
    if factor.numerator == 1:
        return values / factor.denominator if factor.denominator != 1 else values
    return values * float(factor)
