"""Our own CSV: comment lines, the first "# layerjam ...", then names with units in brackets."""

from __future__ import annotations

from dataclasses import replace

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.columns import PULL, Header, cut, split_unit
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.lines import split
from layerjam.measure.readers.rows import Rows, Table
from layerjam.measure.readers.specimens import Specimen
from layerjam.measure.readers.unit_words import ROLES
from layerjam.measure.trace import Trace
from layerjam.records.table_text import plain_comment
from layerjam.simulate.procedure import Evacuate, Pull, Return, parse_procedure

NAME = "layerjam CSV"


def read_own(source: Source, options: ReadingOptions) -> Trace:
    """The one measurement of a file of ours; names are exact here (`force`, not `sheet_force`).

    Raises FileError where a column is missing, or in a unit of something else.
    """
    table = _head(source)
    names, said = table.header.names, options.entries(ROLES)
    kept = set()
    for want in PULL:
        name = (said[want.role].name if want.role in said else None) or want.role
        if names.count(name) > 1:
            raise table.header.fail(f"has the column '{cut(name)}' twice")
        if name in names:
            kept.add(names.index(name))
        elif not want.optional or name != want.role:
            raise table.header.fail(f"has no column '{cut(name)}'; {table.header.listed()}")
    ours = replace(options, decimal=".", columns=None if options.by_order else options.columns)
    trace = Specimen(Rows(source, table), table.header.only(kept), NAME).read(ours)
    if trace.facts.vacuum is not None:
        return trace
    return replace(trace, facts=replace(trace.facts, vacuum=_vacuum(source)))


def _vacuum(source: Source) -> float | None:
    """The vacuum of the procedure in the header, if it evacuates once and then only moves."""
    for _, text in source.lines():
        if not text.startswith("#"):
            break
        if text.startswith("# procedure: "):
            said = plain_comment(text).removeprefix("# procedure: ").strip()
            try:
                steps = parse_procedure(said).steps
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
        names, units = zip(*map(split_unit, split(text, ",")), strict=True)
        end = source.data.find(b"\n", offset)
        first = len(source.data) if end < 0 else end + 1
        return Table(Header(names, units, "names", line, path=source.path), ",", first)
    raise FileError(source.path, "holds a header and no column names")
