"""Files of test machines, recognised by structure and units instead of by brand.

A file is text or a workbook (`source`). Its lines contain numbers, words or nothing (`lines`). The
lines above a block of numbers contain its names and units (`heads`, `table`), and each specimen in
it becomes a trace (`specimens`). A CSV file that layerjam wrote begins with "# layerjam ...".
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from layerjam.brake.simulate.procedure import Evacuate, Pull, Return, parse_procedure
from layerjam.core.errors import (
    FileError,
    LayerjamError,
    explain_arguments,
)
from layerjam.core.system import quote_word
from layerjam.core.toml_files.table_text import restore_comment
from layerjam.laboratory.measure.options import ReadingOptions, load_reading_options
from layerjam.laboratory.measure.readers import words
from layerjam.laboratory.measure.readers.column_names import shorten, split_unit
from layerjam.laboratory.measure.readers.content import Source
from layerjam.laboratory.measure.readers.header import PULL, Header
from layerjam.laboratory.measure.readers.lines import Rows, Table, split_line
from layerjam.laboratory.measure.readers.source import check_path, load_sources
from layerjam.laboratory.measure.readers.specimens import Specimen, find_specimens
from layerjam.laboratory.measure.readers.unit_words import ROLES
from layerjam.laboratory.measure.readers.words import normalise_name
from layerjam.laboratory.measure.sidecar import READ
from layerjam.laboratory.measure.trace import Trace

OWN_FORMAT = "layerjam CSV"


@dataclass(frozen=True)
class UnreadSpecimen:
    """A specimen that has not been read yet: its label in the file and the sidecar's options."""

    label: str
    take: Callable[[ReadingOptions], Trace]
    beside: ReadingOptions

    def read(self, options: ReadingOptions) -> Trace:
        """Return the trace; raises FileError like `read_trace`."""
        trace = self.take(options.over(self.beside))
        if self.beside == ReadingOptions():
            return trace
        notes = (*trace.understood, f"read with the options in [{READ}] of its sidecar")
        return replace(trace, understood=notes)


@explain_arguments
def read_trace(path: str | Path, options: ReadingOptions | None = None) -> Trace:
    """Read the trace in a file from a test machine.

    `options` resolve ambiguities of the file (sign, column, unit, decimal sign, specimen); the
    [read] table of its sidecar is the default. Raises FileError, with the file and, if known, the
    line, for anything that cannot be read with certainty. It also rejects a file with several
    specimens unless one is selected.
    """
    entries = open_traces(path, options)
    if len(entries) > 1:
        labels = [s.label for s in entries if s.label]
        listing = f" ({', '.join(repr(label[:30]) for label in labels[:6])})" if labels else ""
        raise FileError(
            path,
            f"contains {len(entries)} specimens{listing}; choose one",
            how=" (--specimen 1)",
            asks="specimen",
        )
    return entries[0].read(options or ReadingOptions())


@explain_arguments
def read_traces(path: str | Path, options: ReadingOptions | None = None) -> list[Trace]:
    """Return every specimen in a file as a trace, in file order; see `read_trace`."""
    return [entry.read(options or ReadingOptions()) for entry in open_traces(path, options)]


def open_traces(path: str | Path, options: ReadingOptions | None = None) -> list[UnreadSpecimen]:
    """Return the unread specimens in a file, each with `label` and `read(options)`.

    A damaged specimen therefore does not affect the others. Raises FileError if nothing in the file
    can be a tension test, or for a specimen that does not exist.
    """
    check_path(path)
    sidecar = load_reading_options(path)
    every = (options or ReadingOptions()).over(sidecar)
    sources = load_sources(path, every.sheet)
    if sources[0].data.startswith(b"# layerjam"):
        entries = [UnreadSpecimen("", partial(read_layerjam_csv, sources[0]), sidecar)]
    else:
        several = len(sources) > 1
        read = _read_sheets(sources, every) if several else find_specimens(sources[0], every)
        entries = [UnreadSpecimen(specimen.label, specimen.read, sidecar) for specimen in read]
    if every.specimen is None:
        return entries
    if every.specimen > len(entries):
        count_text = f"{len(entries)} specimens" if len(entries) > 1 else "1 specimen"
        raise FileError(path, f"contains {count_text}, but no specimen {every.specimen}")
    return [entries[every.specimen - 1]]


def _read_sheets(sources: list[Source], options: ReadingOptions) -> list[Specimen]:
    """Return the specimens in all sheets; raises FileError if their columns differ."""
    curves = [s for s in sources if not re.search(words.RESULTS, normalise_name(s.sheet))]
    by_sheet: dict[str, list[Specimen]] = {}
    reasons: list[FileError] = []
    for source in curves or sources:
        try:
            by_sheet[source.sheet] = find_specimens(source, options)
        except FileError as err:
            reasons.append(err)
    if not by_sheet:
        raise max(reasons, key=lambda e: e.line or 0)
    heads = {tuple(several[0].rows.table.header.columns) for several in by_sheet.values()}
    if len(heads) > 1 and options.specimen is None:
        sheets = ", ".join(f"'{name[:30]}'" for name in list(by_sheet)[:6])
        raise FileError(
            sources[0].path,
            f"has {len(by_sheet)} sheets with force and elongation in different columns "
            f"({sheets}); choose one",
            how=f" (--sheet {quote_word(next(iter(by_sheet)))})",
            asks="sheet",
        )
    return [
        specimen if specimen.label or len(by_sheet) == 1 else replace(specimen, label=sheet)
        for sheet, several in by_sheet.items()
        for specimen in several
    ]


def read_layerjam_csv(source: Source, options: ReadingOptions) -> Trace:
    """Return the measurement in a file that this program wrote, with exact names (`force`).

    Raises FileError if a column is missing or its unit has the wrong dimension.
    """
    table = _read_head(source)
    names, entries = table.header.names, options.entries(ROLES)
    indices = set()
    for want in PULL:
        name = (entries[want.role].name if want.role in entries else None) or want.role
        if names.count(name) > 1:
            raise table.header.error(f"has the column '{shorten(name)}' twice")
        if name in names:
            indices.add(names.index(name))
        elif not want.optional or name != want.role:
            raise table.header.error(f"has no column '{shorten(name)}'; {table.header.describe()}")
    csv_options = replace(
        options, decimal=".", columns=None if options.by_order else options.columns
    )
    trace = Specimen(Rows(source, table), table.header.select(indices), OWN_FORMAT).read(
        csv_options
    )
    if trace.facts.vacuum is not None:
        return trace
    return replace(trace, facts=replace(trace.facts, vacuum=_read_header_vacuum(source)))


def _read_header_vacuum(source: Source) -> float | None:
    """Return the vacuum in the header's procedure if it evacuates once and then only moves."""
    for _, text in source.lines():
        if not text.startswith("#"):
            break
        if text.startswith("# procedure: "):
            text_of_steps = restore_comment(text).removeprefix("# procedure: ").strip()
            try:
                steps = parse_procedure(text_of_steps).steps
            except LayerjamError:
                return None
            first, others = steps[0], steps[1:]
            if isinstance(first, Evacuate) and all(isinstance(s, Pull | Return) for s in others):
                return first.to
    return None


def _read_head(source: Source) -> Table:
    for line, (offset, text) in enumerate(source.lines(), 1):
        if text.startswith("#") or not text.strip():
            continue
        names, units = zip(*map(split_unit, split_line(text, ",")), strict=True)
        end = source.data.find(b"\n", offset)
        first = len(source.data) if end < 0 else end + 1
        return Table(Header(names, units, "names", line, path=source.path), ",", first)
    raise FileError(source.path, "contains a header but no column names")
