"""Specimens in a file: one below the other, side by side, or one per sheet."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise, takewhile

from layerjam.core.errors import FileError
from layerjam.core.units import show
from layerjam.laboratory.measure.conditions import read_conditions
from layerjam.laboratory.measure.options import ColumnEntry, ReadingOptions
from layerjam.laboratory.measure.readers.column_names import find_role, shorten
from layerjam.laboratory.measure.readers.columns import (
    assign_by_order,
    assign_columns,
    has_all_columns,
    list_unit_conflicts,
)
from layerjam.laboratory.measure.readers.content import Source
from layerjam.laboratory.measure.readers.header import PULL, TIMED, Column, Header, Want
from layerjam.laboratory.measure.readers.heads import complete_units
from layerjam.laboratory.measure.readers.hints import suggest_columns, suggest_order
from layerjam.laboratory.measure.readers.lines import (
    Lines,
    Rows,
    Table,
    make_no_numbers_error,
    read_lines,
)
from layerjam.laboratory.measure.readers.numbers import are_equal_columns, read_columns
from layerjam.laboratory.measure.readers.started import find_start
from layerjam.laboratory.measure.readers.table import (
    Block,
    find_blocks,
    find_headless_table,
    make_bare_table,
    share_headers,
)
from layerjam.laboratory.measure.readers.unit_words import DATE, ROLES, unit_role
from layerjam.laboratory.measure.readers.words import normalise_name
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.synthetic import SYNTHETIC, is_marked_synthetic
from layerjam.laboratory.measure.trace import FEWEST_ROWS, Trace, check_trace

_SHARE = 0.2
_COUNTED = re.compile(r"(.*?)[\s_.\-#(]*(\d{1,3})\)?")


@dataclass(frozen=True)
class Specimen:
    """Columns of one specimen in a table; the header is blank for columns of other specimens."""

    rows: Rows
    header: Header
    form: str
    """Name of the format."""
    label: str = ""
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    written: Header | None = None
    """Header in the file, if the user lists the columns in order."""
    wants: Sequence[Want] = PULL

    def read(self, options: ReadingOptions) -> Trace:
        """Return the trace; raises FileError if a column, a unit or a row is invalid."""
        rows, source = self.rows, self.rows.source
        decimal, entries = options.decimal or source.decimal, options.entries(ROLES)
        if (order := options.by_order) is not None:
            columns, sentences = assign_by_order(self.header, self.wants, entries, len(order))
        else:
            are_equal = partial(are_equal_columns, rows, decimal=decimal)
            columns, sentences = assign_columns(self.header, self.wants, entries, are_equal)
        notes = [*sentences, *source.notes, *self.notes]
        values = dict(
            zip(columns, read_columns(rows, list(columns.values()), decimal), strict=True)
        )
        facts = read_conditions(source.path, options)
        if "elongation" not in values and facts.speed is not None:
            values["elongation"] = facts.speed * (values["time"] - values["time"][0])
            speed = show(facts.speed, "m/s")
            notes.append(f"the elongation is the time times the crosshead speed, {speed}")
        for role in ("force", "elongation"):
            if role in options.negative:
                values[role] = -values[role]
                notes.append(f"the sign of the {role} was reversed")
        warnings = list_unit_conflicts(self.written, columns, self.wants) if self.written else []
        if facts.synthetic or is_marked_synthetic(source.data[: rows.table.first]):
            facts = replace(facts, synthetic=True)
            warnings.append(SYNTHETIC)
        if not rows.has_line_ending:
            warning = "the last line has no line break: the file may have been cut off there"
            warnings.append(warning)
        trace = Trace(
            values["force"],
            values["elongation"],
            values.get("time"),
            source.path,
            "columns as specified" if order is not None else self.form,
            understood=tuple(notes),
            warnings=tuple(warnings),
            facts=facts,
            specimen=self.label,
            start=self._find_start(facts, columns.get("time")),
        )
        trace = check_trace(trace, rows.line, turned="force" in options.negative)
        return replace(trace, warnings=(*trace.warnings, *self.warnings))

    def _find_start(self, facts: Facts, clock: Column | None) -> float | None:
        """Return the start of the test that the sidecar, the time column or the header states."""
        source, table = self.rows.source, self.rows.table
        start = find_start([facts.date])
        if start is None and clock is not None and clock.unit == DATE:
            start = find_start([next(iter(self.rows))[1][clock.index]])
        if start is None:
            head = takewhile(lambda line: line[0] < table.first, source.lines())
            start = find_start(text for _, text in head)
        return start


def find_specimens(source: Source, options: ReadingOptions) -> list[Specimen]:
    """Return the specimens in a text, in order; raises FileError if no table can be one."""
    lines, entries = read_lines(source), options.entries(ROLES)
    blocks = list(share_headers(lines, find_blocks(lines)))
    if (order := options.by_order) is not None:
        wants = PULL if "elongation" in entries else _list_required_columns(source, options)
        return [replace(s, wants=wants) for s in _select_by_order(lines, blocks, len(order))]
    blocks = [complete_units(lines, b) for b in blocks]
    wants = PULL
    if not any(_has_columns(b, entries, PULL) for b in blocks):
        wants = _list_required_columns(source, options)
    fit = [b for b in blocks if _has_columns(b, entries, wants)]
    if not fit:
        raise _explain_unreadable(lines, blocks, entries)
    largest_block = max(fit, key=lambda b: b.rows)
    used = [b for b in fit if _is_like_largest(b, largest_block)]
    _reject_orphan_rows(lines, blocks, used, largest_block)
    result = [
        s for b in used for s in _split_side_by_side(source, b, entries, wants, len(used) > 1)
    ]
    labels = [s.label for s in result]
    if len(result) > 1 and len(set(labels)) < len(labels):
        result = [replace(s, label=f"{i} {s.label}".strip()) for i, s in enumerate(result, 1)]
    warnings = _note_skipped_lines(lines, blocks, used)
    return [replace(s, warnings=warnings, wants=wants) for s in result]


def _list_required_columns(source: Source, options: ReadingOptions) -> Sequence[Want]:
    """Return the required quantities; if the speed is known, elongation may be missing."""
    return PULL if read_conditions(source.path, options).speed is None else TIMED


def _has_columns(block: Block, entries: Mapping[str, ColumnEntry], wants: Sequence[Want]) -> bool:
    if block.table is None:
        return False
    header = block.table.header
    return has_all_columns(header, entries, wants) and (
        wants is PULL or _has_time_axis(header, entries)
    )


def _has_time_axis(header: Header, entries: Mapping[str, ColumnEntry]) -> bool:
    required_columns = [replace(w, optional=False) for w in TIMED if w.role != "elongation"]
    return has_all_columns(header, entries, required_columns)


def _is_like_largest(block: Block, main: Block) -> bool:
    """Return whether a block is a specimen like the largest one: same columns or same length."""
    table, main_table = block.table, main.table
    if table and main_table and table.header.columns == main_table.header.columns:
        return True
    return block.rows >= max(FEWEST_ROWS, _SHARE * main.rows)


def _select_by_order(lines: Lines, blocks: list[Block], count: int) -> list[Specimen]:
    """Return, as specimens, the blocks with as many columns as the user lists."""
    fit = [b for b in blocks if b.width == count] or blocks
    if not fit:
        raise FileError(lines.source.path, "contains no row of numbers")
    largest_block = max(fit, key=lambda b: b.rows)
    used = [b for b in fit if b is largest_block or (b.pure and b.rows >= FEWEST_ROWS)]
    warnings, result = _note_skipped_lines(lines, blocks, used), []
    for k, block in enumerate(used, 1):
        table = make_bare_table(lines, block)
        label = (block.title or str(k)) if len(used) > 1 else ""
        rows = Rows(lines.source, table)
        own_header = block.table.header if block.table else None
        if own_header and len(own_header.names) != count:
            own_header = None
        result.append(
            Specimen(rows, table.header, "", label, warnings=warnings, written=own_header)
        )
    return result


def _explain_unreadable(
    lines: Lines, blocks: list[Block], given_entries: Mapping[str, ColumnEntry]
) -> FileError:
    path = lines.source.path
    tables = [b.table for b in blocks if b.table is not None]
    bare_block = max((b for b in blocks if b.pure), key=lambda b: b.rows, default=None)
    best = max(tables, key=lambda t: (bool(t.header.style), t.rows), default=None)
    if best is None or (
        bare_block is not None and bare_block.table is None and best.rows * 10 < bare_block.rows
    ):
        if bare_block is not None and bare_block.rows >= FEWEST_ROWS and bare_block.width >= 2:
            order = suggest_order(make_bare_table(lines, bare_block).header, PULL)
            return FileError(
                path,
                f"is not in a known format: {bare_block.width} columns of numbers without names; "
                "specify each one",
                how=f", in order, such as {order}",
                asks="columns",
            )
        best = best or find_headless_table(lines, blocks)
    if best is None or not (best.header.style or any(map(find_role, best.header.names))):
        order = suggest_order(best.header, PULL) if best and best.rows >= FEWEST_ROWS else ""
        if best and order:
            return best.header.error(
                f"has columns without known names or units: {best.header.describe()}; specify "
                "each one",
                f", in order, such as {order}",
            )
        return FileError(
            path,
            "is not in a known format; tried layerjam CSV (first line '# layerjam'), "
            "Instron Bluehill, Zwick testXpert, MTS TestSuite, Shimadzu Trapezium and tables of "
            "numbers below column names",
        )
    if best.rows == 0:
        return best.header.error("contains column names but no rows of numbers")
    if "elongation" not in given_entries and _has_time_axis(best.header, given_entries):
        column = suggest_columns(best.header, PULL, given_entries)
        return best.header.error(
            f"contains force and time but no elongation ({best.header.describe()}); state the "
            "crosshead speed",
            f" (--speed 10mm/min){', or its column' if column else ''}{column}",
            "speed",
        )
    try:
        assign_columns(best.header, PULL, given_entries)
    except FileError as err:
        return err
    return best.header.error(f"cannot be read; {best.header.describe()}")


def _reject_orphan_rows(
    lines: Lines, blocks: list[Block], blocks_used: list[Block], main: Block
) -> None:
    """Reject rows as wide as the table but without a header: the file is damaged there."""
    for k, block in enumerate(blocks):
        if block in blocks_used or not block.pure or block.width != main.width:
            continue
        if block.has_units:
            continue
        block_before = next((b for b in reversed(blocks[:k]) if b in blocks_used), None)
        if block_before is not None:
            line = next(n for n in range(block_before.last + 1, block.first) if not lines.blank[n])
            raise make_no_numbers_error(lines.source.path, [lines.text(line)], line + 1)
        if block.rows >= 2:
            raise FileError(
                lines.source.path,
                f"has {block.rows} rows of numbers above its column names; is it damaged there?",
                block.first + 1,
            )


def _note_skipped_lines(
    lines: Lines, blocks: list[Block], blocks_used: list[Block]
) -> tuple[str, ...]:
    end = blocks_used[-1].last + 1
    lines_below = [n for n in range(end, min(end + 50, len(lines.starts))) if not lines.blank[n]]
    if not lines_below:
        return ()
    count = int((~lines.blank[end:]).sum())
    line_count = f"{count} lines" if count > 1 else "1 line"
    text = shorten(lines.text(lines_below[0]))
    return (f"ignored {line_count} below the numbers, from line {lines_below[0] + 1}: '{text}'",)


def _split_side_by_side(
    source: Source,
    block: Block,
    entries: Mapping[str, ColumnEntry],
    wants: Sequence[Want],
    several: bool,
) -> list[Specimen]:
    table = block.table
    if table is None:
        return []
    head, form = table.header, detect_format(source, table)
    groups = [head.select(group) for group in _group_columns(head)]
    is_split = len(groups) > 1 and all(has_all_columns(header, entries, wants) for header in groups)
    rows = Rows(source, table, shared=is_split)
    if not is_split:
        title = block.title if several else ""
        number = next((n for n in head.names[:1] if n.isdigit()), "")  # for example: 1,Time,Load
        label = next((c for c in head.label[:1] if _is_specimen_number(c)), "") or number or title
        return [Specimen(rows, head, form, label)]
    result = []
    for k, header in enumerate(groups, 1):
        labels = [c for c, (n, u) in zip(head.label, header.columns, strict=False) if n or u]
        label = next(filter(None, labels), str(k))
        note = f"specimen {k} of {len(groups)} side by side"
        result.append(Specimen(rows, header, form, label, (note,)))
    return result


def _is_specimen_number(text: str) -> bool:
    """Return whether a cell above the names contains the number of a specimen."""
    return re.search(r"\d", text) is not None and len(text) <= 40


def _group_columns(head: Header) -> list[list[int]]:
    """Return the columns of each specimen if specimens are side by side; empty otherwise."""
    columns = [i for i, n in enumerate(head.names) if n or head.units[i]]
    starts = [i for i, cell in enumerate(head.label) if cell and i < len(head.names)]
    labelled = len(starts) > 1 and starts[0] == columns[0] and len(starts) < len(columns)
    if labelled and all(_is_specimen_number(head.label[i]) for i in starts):
        column_set = set(columns)
        return [
            [i for i in range(a, b) if i in column_set]
            for a, b in pairwise([*starts, len(head.names)])
        ]
    for times in ([], columns[:1]):
        if times and not _is_time(head.units[times[0]]):
            continue
        others = columns[len(times) :]
        for period in range(2, len(others) // 2 + 1):
            if len(others) % period == 0 and _is_repeated(head, others, period):
                return [times + others[k : k + period] for k in range(0, len(others), period)]
    return _group_by_number(head, columns)


def _is_repeated(head: Header, columns: Sequence[int], period: int) -> bool:
    keys = [(_base_name(head.names[i]), head.units[i]) for i in columns]
    return all(a == b for a, b in zip(keys, keys[period:], strict=False))


def _group_by_number(head: Header, columns: Sequence[int]) -> list[list[int]]:
    """Group columns whose names end in the same number: Load 1, Load 2, Travel 1, Travel 2."""
    times: list[int] = []
    by_number: dict[int, list[int]] = {}
    for i in columns:
        match = _COUNTED.fullmatch(normalise_name(head.names[i]))
        if match and match[1]:
            by_number.setdefault(int(match[2]), []).append(i)
        else:
            times.append(i)
    if len(by_number) < 2 or not all(_is_time(head.units[i]) for i in times):
        return []
    kinds = {
        tuple(sorted((_base_name(head.names[i]), head.units[i] or "") for i in group))
        for group in by_number.values()
    }
    return [times + group for group in by_number.values()] if len(kinds) == 1 else []


def _is_time(unit: str | None) -> bool:
    role = unit_role(unit) if unit else None
    return role is not None and role[0] == "time"


def _base_name(name: str) -> str:
    text = normalise_name(name)
    match = _COUNTED.fullmatch(text)
    return match[1] if match and match[1] else text


def detect_format(source: Source, table: Table) -> str:
    """Return the format's name, for display only."""
    head = source.data[: min(table.first, 4000)]
    text = head.decode(source.encoding, errors="replace").lower()
    if source.sheet:
        return f"workbook, sheet '{source.sheet[:40]}'"
    if re.search(r"trapezium|shimadzu|\d+ _ \d+", text):
        return "Shimadzu Trapezium"
    if re.search(r"\bmts\b|mts793|testsuite|testworks", text):
        return "MTS TestSuite"
    if re.search(r"testxpert|zwick", text):
        return "Zwick testXpert"
    if re.search(r"bluehill|instron", text):
        return "Instron Bluehill"
    quoted = b'"' in head
    standard = any("standard" in normalise_name(name) for name in table.header.names)
    # other programs also quote their units
    if quoted and standard and table.header.style == "plain row":
        return "Zwick testXpert"
    if quoted and table.header.style == "bracket row":
        return "Instron Bluehill"
    return "table of columns"
