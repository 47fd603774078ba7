"""Files of test machines, recognised by their content: structure and units, not brands.

A file is text or a workbook (`source`), its lines are numbers, words or blank (`lines`), a block of
numbers takes names and units from the words above it (`heads`, `table`), and each specimen in it
becomes a trace (`specimens`). Our own CSV begins with comments, the first "# layerjam ...".
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.options import ReadingOptions, options_beside
from layerjam.measure.readers import words
from layerjam.measure.readers.columns import PULL, Header, cut, split_unit
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.lines import split
from layerjam.measure.readers.rows import Rows, Table
from layerjam.measure.readers.source import load_sources
from layerjam.measure.readers.specimens import Specimen, specimens
from layerjam.measure.readers.unit_words import ROLES
from layerjam.measure.readers.words import plain
from layerjam.measure.sidecar import READ
from layerjam.measure.trace import Trace
from layerjam.records.table_text import plain_comment
from layerjam.simulate.procedure import Evacuate, Pull, Return, parse_procedure

OWN = "layerjam CSV"


@dataclass(frozen=True)
class Opened:
    """A specimen that is not read yet: what its file calls it, what the sidecar says of it."""

    label: str
    take: Callable[[ReadingOptions], Trace]
    beside: ReadingOptions

    def read(self, options: ReadingOptions) -> Trace:
        """The trace; FileError as the readers raise it."""
        trace = self.take(options.over(self.beside))
        if self.beside == ReadingOptions():
            return trace
        said = (*trace.understood, f"read with the answers in [{READ}] of its sidecar")
        return replace(trace, understood=said)


def read_trace(path: str | Path, options: ReadingOptions | None = None) -> Trace:
    """The trace in a test machine's file.

    `options` answer what the file leaves open (sign, column, unit, decimal sign, specimen); where
    they are silent the [read] table of its sidecar does. Raises FileError, one sentence with the
    file and where known the line, for anything that cannot be read with certainty, and for a file
    of several specimens unless one is named.
    """
    found = open_traces(path, options)
    if len(found) > 1:
        labels = [s.label for s in found if s.label]
        named = f" ({', '.join(repr(label[:30]) for label in labels[:6])})" if labels else ""
        raise FileError(
            path,
            f"holds {len(found)} specimens{named}; say which one",
            how=" (--specimen 1)",
            asks="specimen",
        )
    return found[0].read(options or ReadingOptions())


def read_traces(path: str | Path, options: ReadingOptions | None = None) -> list[Trace]:
    """Every specimen of a file as a trace of its own, in the file's order; else as `read_trace`."""
    return [one.read(options or ReadingOptions()) for one in open_traces(path, options)]


def open_traces(path: str | Path, options: ReadingOptions | None = None) -> list[Opened]:
    """The specimens of a file, each with `label` and `read(options)`, none of them read yet.

    So that one damaged specimen does not take the others with it. Raises FileError where the file
    holds nothing that can be a tension test, and for a specimen that is not there.
    """
    beside = options_beside(path)
    every = (options or ReadingOptions()).over(beside)
    sources = load_sources(path, every.sheet)
    if sources[0].data.startswith(b"# layerjam"):
        found = [Opened("", partial(read_own, sources[0]), beside)]
    else:
        several = len(sources) > 1
        read = _of_sheets(sources, every) if several else specimens(sources[0], every)
        found = [Opened(one.label, one.read, beside) for one in read]
    if every.specimen is None:
        return found
    if every.specimen > len(found):
        many = f"{len(found)} specimens" if len(found) > 1 else "1 specimen"
        raise FileError(path, f"holds {many}, there is no specimen {every.specimen}")
    return [found[every.specimen - 1]]


def _of_sheets(sources: list[Source], options: ReadingOptions) -> list[Specimen]:
    """The specimens of those sheets that hold any; FileError where their columns differ."""
    curves = [s for s in sources if not re.search(words.RESULTS, plain(s.sheet))]
    found: dict[str, list[Specimen]] = {}
    reasons: list[FileError] = []
    for source in curves or sources:
        try:
            found[source.sheet] = specimens(source, options)
        except FileError as err:
            reasons.append(err)
    if not found:
        raise max(reasons, key=lambda e: e.line or 0)
    heads = {tuple(several[0].rows.table.header.columns) for several in found.values()}
    if len(heads) > 1 and options.specimen is None:
        sheets = ", ".join(f"'{name[:30]}'" for name in list(found)[:6])
        raise FileError(
            sources[0].path,
            f"has {len(found)} sheets with force and elongation in different columns ({sheets}); "
            "say which one",
            how=" (--sheet NAME)",
            asks="sheet",
        )
    return [
        one if one.label or len(found) == 1 else replace(one, label=sheet)
        for sheet, several in found.items()
        for one in several
    ]


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
    trace = Specimen(Rows(source, table), table.header.only(kept), OWN).read(ours)
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
    for line, (offset, text) in enumerate(source.lines(), 1):
        if text.startswith("#") or not text.strip():
            continue
        names, units = zip(*map(split_unit, split(text, ",")), strict=True)
        end = source.data.find(b"\n", offset)
        first = len(source.data) if end < 0 else end + 1
        return Table(Header(names, units, "names", line, path=source.path), ",", first)
    raise FileError(source.path, "holds a header and no column names")
