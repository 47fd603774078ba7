"""Our own CSV: comment lines, the first "# layerjam ...", then names with units in brackets."""

from __future__ import annotations

from layerjam.errors import FileError
from layerjam.identify.columns import Choices, Column, assign, unit_role
from layerjam.identify.readers.assemble import trace_of
from layerjam.identify.readers.source import Source
from layerjam.identify.readers.table import Table, split, split_unit
from layerjam.identify.trace import Trace

NAME = "layerjam CSV"


def why_not(source: Source, table: Table | None) -> str | None:
    """None where the file is ours, else the reason."""
    if source.data.startswith(b"# layerjam"):
        return None
    return "its first line does not begin with '# layerjam'"


def read(source: Source, table: Table | None, choices: Choices) -> Trace:
    """The trace; names are exact here (`force`, not `sleeve_force`), units still count."""
    for offset, text in source.lines():
        if text.startswith("#") or not text.strip():
            continue
        line = source.line_number(offset)
        pairs = [split_unit(f) for f in split(text, ",")]
        names, units = tuple(n for n, _ in pairs), tuple(u for _, u in pairs)
        end = source.data.find(b"\n", offset)
        first = len(source.data) if end < 0 else end + 1
        own = Table(names, units, "names", ",", line, first)
        exact = [n if n in ("time", "elongation", "force") else "" for n in names]
        if {"elongation", "force"} <= set(exact) and choices.columns is None:
            taken: dict[str, Column] = {}
            for role in ("time", "elongation", "force"):
                if exact.count(role) > 1:
                    raise FileError(source.path, f"has the column '{role}' twice", line)
                if role in exact:
                    index = exact.index(role)
                    unit = units[index] or ""
                    known = unit_role(unit)
                    if known is None or known[0] != role:
                        break
                    taken[role] = Column(role, index, role, unit, known[1])
            else:
                said = [f"{c.role} is the column '{c.name}' in {c.unit}" for c in taken.values()]
                return trace_of(source, own, taken, said, choices, NAME, ".")
        # Something is missing or has another unit: the general rule finds the words for it.
        plain = tuple(u if n in ("time", "elongation", "force") else None
                      for n, u in zip(names, units, strict=True))  # fmt: skip
        taken, said = assign(names, plain if choices.columns is None else units, source.path,
                             line, choices)  # fmt: skip
        return trace_of(source, own, taken, said, choices, NAME, ".")
    raise FileError(source.path, "holds a header and no column names")
