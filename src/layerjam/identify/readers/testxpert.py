"""Zwick testXpert .TRA: lines about the specimen, then names in quotes, then plain units."""

from __future__ import annotations

import re

from layerjam.identify.columns import Choices
from layerjam.identify.readers.assemble import assemble
from layerjam.identify.readers.source import Source
from layerjam.identify.readers.table import Table
from layerjam.identify.trace import Trace

NAME = "Zwick testXpert"
_SPECIMEN = re.compile(rb'"[^"\n]*"[,;\t](?:[-+.,\deE]*|"[^"\n]*")[,;\t]"[^"\n]*"\n')


def why_not(source: Source, table: Table | None) -> str | None:
    """None where the file has this layout, else the reason."""
    if table is None:
        return "no row of column names in quotes"
    if table.style == "plain row":
        return None
    if table.style == "" and _SPECIMEN.match(source.data):
        return None  # the lines about the specimen are there: reading it says what is missing
    return "no row of units without parentheses below the column names"


def read(source: Source, table: Table | None, choices: Choices) -> Trace:
    """The trace; FileError where a column, a unit or a row is not as it must be."""
    assert table is not None
    return assemble(source, table, choices, NAME)
