"""Units of columns that are not in a header, but in lines above, in names or in cells."""

import re
from collections.abc import Sequence
from dataclasses import replace

from layerjam.laboratory.measure.readers import words
from layerjam.laboratory.measure.readers.column_names import find_role
from layerjam.laboratory.measure.readers.lines import Lines
from layerjam.laboratory.measure.readers.stamps import find_stamp_unit
from layerjam.laboratory.measure.readers.table import Block
from layerjam.laboratory.measure.readers.unit_words import (
    common_unit,
    force_unit_for,
    unit_role,
)
from layerjam.laboratory.measure.readers.words import normalise_name

_NAMES_TOO = ("in", "min", "mil")
"""Units that are also usual names of columns: an input, a minimum."""


def complete_units(lines: Lines, block: Block) -> Block:
    """Return a block with the units that its header does not state.

    Lines above may state them (`Force unit: kN`), or a column may be named by its unit (`millis`).
    The cells may also be time stamps.
    """
    table = block.table
    if table is None:
        return block
    head = table.header
    stated_units = find_stated_units([lines.text(n) for n in range(min(block.first, 200))])
    cells = [*lines.fields(block.first), *[""] * len(head.names)]
    units = tuple(
        _find_stamps(cell, unit)
        or unit
        or stated_units.get(find_role(name) or "")
        or _find_own_unit(name)
        for (name, unit), cell in zip(head.columns, cells, strict=False)
    )
    if units == head.units:
        return block
    header = replace(head, units=units, style=head.style or "stated")
    return replace(block, table=replace(table, header=header))


def _find_stamps(cell: str, unit: str | None) -> str | None:
    """Return the unit of time stamps in a column whose header states none, or "UTC"."""
    return None if unit and unit_role(unit) else find_stamp_unit(cell)


def _find_own_unit(name: str) -> str | None:
    """Return the name of a column if it is a unit, such as `millis`; otherwise None."""
    is_unit = len(name) > 1 and normalise_name(name) not in _NAMES_TOO and common_unit(name)
    return name if is_unit else None


def find_stated_units(texts: Sequence[str]) -> dict[str, str]:
    """Return units stated in lines above the table, such as `Force unit;kN`, `Einheit Weg: mm`."""
    units_of: dict[str, set[str]] = {"time": set(), "elongation": set(), "force": set()}
    for text in texts:
        if len(text) > 200:
            continue
        match = re.match(
            r"\W*([^:=;,\t|\"]+?)\"?\s*[:=;,\t|]+\s*\"?([^:=;,\t|\"]+?)\"?[\s;,\t|]*$", text
        )
        if not match or not re.search(words.UNIT, normalise_name(match[1])):
            continue
        unit, role_named = unit_role(match[2]), find_role(match[1])
        if unit and role_named == unit[0]:
            units_of[unit[0]].add(match[2])
        elif role_named == "force" and force_unit_for(match[2]):
            units_of["force"].add(match[2])
    return {role: units.pop() for role, units in units_of.items() if len(units) == 1}
