"""Our own CSV: comment lines, the first "# layerjam ...", then names with units in brackets."""

from __future__ import annotations

from layerjam.errors import FileError
from layerjam.identify.columns import Choices, listed, sentence, split_unit, take
from layerjam.identify.readers.assemble import trace_of
from layerjam.identify.readers.source import Source
from layerjam.identify.readers.table import Table, split
from layerjam.identify.trace import Trace

NAME = "layerjam CSV"


def why_not(source: Source, table: Table | None) -> str | None:
    """None where the file is ours, else the reason."""
    if source.data.startswith(b"# layerjam"):
        return None
    return "its first line does not begin with '# layerjam'"


def read(source: Source, table: Table | None, choices: Choices) -> Trace:
    """The trace; names are exact here (`force`, not `sleeve_force`), and units still count."""
    own = _head(source)
    taken = {}
    for role in ("time", "elongation", "force"):
        name = (choices.columns or {}).get(role, role)
        if own.names.count(name) > 1:
            raise FileError(source.path, f"has the column '{name[:40]}' twice", own.line)
        if name in own.names:
            index = own.names.index(name)
            taken[role] = take(role, index, name, own.units[index], source.path, own.line)
        elif role != "time" or name != role:
            there = listed(own.names, own.units)
            raise FileError(source.path, f"has no column '{name[:40]}'; {there}", own.line)
    said = [sentence(column, []) for column in taken.values()]
    return trace_of(source, own, taken, said, choices, NAME, ".")


def _head(source: Source) -> Table:
    """The row of names below the comments."""
    for line, (offset, text) in enumerate(source.lines(), 1):
        if text.startswith("#") or not text.strip():
            continue
        pairs = [split_unit(f) for f in split(text, ",")]
        end = source.data.find(b"\n", offset)
        first = len(source.data) if end < 0 else end + 1
        names, units = tuple(n for n, _ in pairs), tuple(u for _, u in pairs)
        return Table(names, units, "names", ",", line, first)
    raise FileError(source.path, "holds a header and no column names")
