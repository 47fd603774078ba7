"""Our own CSV: comment lines, the first "# layerjam ...", then names with units in brackets."""

from __future__ import annotations

from dataclasses import replace

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.assemble import Rows, trace_of
from layerjam.measure.readers.columns import PULL, Header, cut, split_unit
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.grid import Table
from layerjam.measure.readers.lines import split
from layerjam.measure.trace import Trace
from layerjam.simulate.procedure import Evacuate, Pull, Return, parse_procedure

NAME = "layerjam CSV"


def read_own(source: Source, options: ReadingOptions) -> Trace:
    """The one measurement of a file of ours; names are exact here (`force`, not `sheet_force`).

    Raises FileError where a column is missing, or in a unit of something else.
    """
    table = _head(source)
    header = Header(table.names, table.units, source.path, table.line)
    said = options.entries({want.role: want.si for want in PULL})
    taken = {}
    for want in PULL:
        name = said[want.role].name or want.role if want.role in said else want.role
        if table.names.count(name) > 1:
            raise header.fail(f"has the column '{cut(name)}' twice")
        if name in table.names:
            taken[want.role] = header.take(want, table.names.index(name))
        elif not want.optional or name != want.role:
            raise header.fail(f"has no column '{cut(name)}'; {header.listed()}")
    sentences = [column.sentence() for column in taken.values()]
    trace = trace_of(Rows(source, table, False), (taken, sentences), options, NAME, ".")
    if trace.facts.vacuum is not None:
        return trace
    return replace(trace, facts=replace(trace.facts, vacuum=_vacuum(source)))


def _vacuum(source: Source) -> float | None:
    """The vacuum of the procedure in the header, if it evacuates once and then only moves."""
    for _, text in source.lines():
        if not text.startswith("#"):
            break
        if text.startswith("# procedure: "):
            try:
                steps = parse_procedure(text.removeprefix("# procedure: ").strip()).steps
            except LayerjamError:
                return None
            first, rest = steps[0], steps[1:]
            if isinstance(first, Evacuate) and all(isinstance(s, Pull | Return) for s in rest):
                return first.to
    return None


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
