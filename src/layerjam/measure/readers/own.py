"""Our own CSV: comment lines, the first "# layerjam ...", then names with units in brackets."""

from __future__ import annotations

from dataclasses import dataclass, replace

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.readers.assemble import Rows, trace_of
from layerjam.measure.readers.columns import Choices, listed, sentence, split_unit, take
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.grid import Table
from layerjam.measure.readers.lines import split
from layerjam.measure.trace import Trace
from layerjam.simulate.procedure import Evacuate, Pull, Return, parse_procedure

NAME = "layerjam CSV"


@dataclass(frozen=True)
class Own:
    """The one measurement of a file of ours; names are exact here (`force`, not `sleeve_force`)."""

    source: Source
    label: str = ""

    def read(self, choices: Choices) -> Trace:
        """The trace; FileError where a column is missing or in a unit of something else."""
        return _read(self.source, choices)


def _read(source: Source, choices: Choices) -> Trace:
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
    trace = trace_of(Rows(source, own, False), taken, said, choices, NAME, ".")
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
