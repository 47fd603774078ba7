"""Instron Bluehill: names over units in parentheses, or units within the names, as CSV.

A results block may stand above the raw data; fields may all be in quotes, with decimal commas.
"""

from __future__ import annotations

from layerjam.identify.columns import Choices, named_role
from layerjam.identify.readers.assemble import assemble
from layerjam.identify.readers.source import Source
from layerjam.identify.readers.table import Table
from layerjam.identify.trace import Trace

NAME = "Instron Bluehill"


def why_not(source: Source, table: Table | None) -> str | None:
    """None where the file has this layout, else the reason."""
    if table is None:
        return "no row of column names"
    if table.style in ("bracket row", "names"):
        return None
    if table.style == "" and any(named_role(n) for n in table.names):
        return None  # names it would use, without units: reading it says so
    return "no column names with units in parentheses, in the names or in a row below"


def read(source: Source, table: Table | None, choices: Choices) -> Trace:
    """The trace; FileError where a column, a unit or a row is not as it must be."""
    assert table is not None
    return assemble(source, table, choices, NAME)
