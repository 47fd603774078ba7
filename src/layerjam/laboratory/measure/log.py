"""Time log from any logger or test machine, with named columns and units.

A command lists the quantities that it requires (`Want`). A column is selected first by its unit,
then by its name. If the file is ambiguous, `ReadingOptions` decide.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from layerjam.core.command.log_options import LogOptions
from layerjam.core.conversion import unit_factor
from layerjam.core.errors import FileError, FitError, Notice
from layerjam.core.units import show
from layerjam.laboratory.measure.options import ColumnEntry, ReadingOptions
from layerjam.laboratory.measure.readers.column_names import separate_words
from layerjam.laboratory.measure.readers.columns import (
    assign_by_order,
    assign_columns,
    list_unit_conflicts,
)
from layerjam.laboratory.measure.readers.content import Source
from layerjam.laboratory.measure.readers.header import Column, Header, Want
from layerjam.laboratory.measure.readers.heads import complete_units
from layerjam.laboratory.measure.readers.hints import suggest_order
from layerjam.laboratory.measure.readers.lines import Rows, Table, read_lines, split_line
from layerjam.laboratory.measure.readers.numbers import are_equal_columns, read_columns
from layerjam.laboratory.measure.readers.source import load_source
from layerjam.laboratory.measure.readers.table import (
    find_blocks,
    find_headless_table,
    make_bare_table,
)
from layerjam.laboratory.measure.readers.unit_words import PRESSURE as PRESSURE_UNIT
from layerjam.laboratory.measure.readers.unit_words import convert_unit
from layerjam.laboratory.measure.readers.words import normalise_name
from layerjam.laboratory.measure.sidecar import read_facts
from layerjam.laboratory.measure.synthetic import SYNTHETIC, is_marked_synthetic
from layerjam.laboratory.measure.trace import Array

_HEAD_LINES = 200
_OWN_NAMES = ("Pa", "m/s^2")
"""SI units of quantities whose column may be named by its unit alone, such as `hPa`."""
_TWO_POINTS = re.compile(rb"(?<![\w.,])[+-]?\d{1,3}(?:\.\d{3}){1,4}\.\d{1,9}(?![\d.,])")
_NAME_UNIT = re.compile(
    r"(.+?)(?:\s*/\s*|\s+in\s+|_|\s*[,:]\s*)"
    r"([^/_,:\s]{1,12}(?:[ _](?:abs|absolute|gauge|rel|relative))?)",
    re.IGNORECASE,
)
"""Name and unit in one cell; the unit of a pressure may be followed by its reference."""

TIME = Want("time", "s", r"\b(time|zeit|temps|tiempo|tempo|t|elapsed)\b|zeit\b", ("s", "ms"))
PRESSURE = Want(
    role="pressure",
    si="Pa",
    words=r"\b(pressure|vacuum|pression|presion|pressione|p|vide)\b|druck\b|vakuum",
    units=("kPa", "bar"),
)
TEMPERATURE = Want("temperature", "K", r"\btemp\b|temperature?", ("K", "°C"), optional=True)
ACCELERATION = Want(
    "acceleration", "m/s^2", r"\b(acc|acceleration|accel|beschleunigung|a)\b", ("g", "m/s^2")
)


@dataclass(frozen=True)
class Log:
    """Columns in SI units by role, each of shape (N,), and the interpretation of the file.

    `head` contains the lines above the table: {lower-case key: rest of the line}. `taken` contains
    the name and unit of each selected column as written, because a unit alone may be incomplete
    (bar absolute or gauge).
    """

    path: str
    columns: Mapping[str, Array] = field(repr=False)
    taken: Mapping[str, Column]
    head: Mapping[str, tuple[str, ...]]
    understood: tuple[str, ...]
    synthetic: bool = False
    """Whether a program generated the file, according to its header or its sidecar."""
    warnings: tuple[str, ...] = ()
    """Units in the file that the user overrides."""
    header: Header | None = None

    def __getitem__(self, role: str) -> Array:
        return self.columns[role]

    def __contains__(self, role: object) -> bool:
        return role in self.columns

    @property
    def name(self) -> str:
        """File name without its folder."""
        return Path(self.path).name

    @property
    def notices(self) -> list[Notice]:
        """Notices for every result computed from the file."""
        return [*([SYNTHETIC] if self.synthetic else []), *map(Notice, self.warnings)]

    def name_column(self, role: str) -> str:
        """Return the name by which the user can select the column of a role."""
        column = self.taken[role]
        return column.name if self.header is None else self.header.name_column(column.index)

    @contextmanager
    def locate_errors(self) -> Iterator[None]:
        """Add the file to the errors of fits to its columns."""
        try:
            yield
        except FitError as error:
            raise FileError(self.path, str(error)) from None


def find_reference(column: Column) -> str | None:
    """Return the pressure reference in a column's unit or name, or None."""
    match = PRESSURE_UNIT.fullmatch(column.unit.strip())
    suffix = (
        (match["how"] or "").lower() if match and unit_factor(column.unit, "Pa") is None else ""
    )
    name = "" if column.given else separate_words(column.name)
    if suffix in ("a", "abs", "absolute") or re.search(r"\babs\b|absolute?", name):
        return "absolute"
    if suffix in ("g", "gauge", "gage", "rel", "ü") or re.search(
        r"\b(gauge|gage)\b|uberdruck|relative?", name
    ):
        return "gauge"
    return "vacuum" if re.search(r"\b(vacuum|vide)\b|vakuum|unterdruck", name) else None


def read_log(
    path: str | Path, wants: Sequence[Want], options: ReadingOptions | LogOptions | None = None
) -> Log:
    """Read the required columns of a file in SI units.

    Raises FileError if a column is missing or ambiguous or has no unit or no number, and
    QuantityError for invalid options. A required column of time must not decrease.
    """
    options, source = ReadingOptions.complete(options), load_source(path)
    entries = options.entries({w.role: w.si for w in wants})
    order, decimal = options.by_order, options.decimal or source.decimal
    table, written_header = _find_largest_table(source, wants, order is not None)
    header = _split_units(table.header, wants)
    rows = Rows(source, replace(table, header=header))
    warnings: list[str] = []
    if order is not None:
        columns_used, notes = assign_by_order(header, wants, entries, len(order))
        if written_header is not None:
            warnings = list_unit_conflicts(_split_units(written_header, wants), columns_used, wants)
    else:
        rows = _pair_times(rows, wants, entries)
        are_equal = partial(are_equal_columns, rows, decimal=decimal, from_start=False)
        columns_used, notes = assign_columns(rows.table.header, wants, entries, are_equal)
    columns = list(columns_used.values())
    rows, fixes = _drop_points(rows, columns, decimal)
    values = dict(zip(columns_used, read_columns(rows, columns, decimal), strict=True))
    _check_time(rows, columns_used, values, wants)
    head_bytes = source.data[: table.first]
    return Log(
        source.path,
        values,
        columns_used,
        _parse_head(source, table),
        (*notes, *source.notes, *fixes),
        is_marked_synthetic(head_bytes) or read_facts(source.path).synthetic,
        tuple(f"{Path(source.path).name}: {warning}" for warning in warnings),
        rows.table.header,
    )


def _find_largest_table(
    source: Source, wants: Sequence[Want], listed: bool
) -> tuple[Table, Header | None]:
    """Return the table with the most rows, preferably one with units, and its header if listed.

    If the user lists the columns (`listed`), the table starts at the first row of numbers.
    """
    lines = read_lines(source)
    blocks = [complete_units(lines, block) for block in find_blocks(lines)]
    if listed and not blocks:
        raise FileError(source.path, "contains no row of numbers")
    if listed:
        bare_table, first = make_bare_table(lines, blocks[0]), blocks[0].table
        is_same = first is not None and len(first.header.names) == len(bare_table.header.names)
        return replace(bare_table, last=None), first.header if first and is_same else None
    best = max((b for b in blocks if b.table), key=lambda b: (b.has_units, b.rows), default=None)
    table = best.table if best else find_headless_table(lines, blocks)
    if table is None:
        largest_block = max(blocks, key=lambda b: b.rows, default=None)
        order = (
            suggest_order(make_bare_table(lines, largest_block).header, wants)
            if largest_block
            else ""
        )
        raise FileError(
            source.path,
            f"has {largest_block.width} columns of numbers without names"
            if largest_block
            else "contains no table",
            how=f"; specify each one, in order, such as {order}" if order else "",
            asks="columns",
        )
    return table, None


def _split_units(header: Header, wants: Sequence[Want]) -> Header:
    """Return the header, with units split off names: 'Druck / kPa', 'p_bar_abs', 'p [kPa(g)]'."""
    names, units = zip(*(_split_name_unit(n, u, wants) for n, u in header.columns), strict=True)
    return replace(header, names=names, units=units)


def _split_name_unit(name: str, unit: str | None, wants: Sequence[Want]) -> tuple[str, str | None]:
    if unit:
        return name, unit
    if len(name) > 1 and any(convert_unit(name, w.si) for w in wants if w.si in _OWN_NAMES):
        return name, name
    match = re.fullmatch(r"(.+?)\s*\[([^\[\]]{1,20})\]", name.strip())
    if match and any(convert_unit(match[2], w.si) for w in wants):
        return match[1], match[2]
    match = _NAME_UNIT.fullmatch(name.strip())
    unit = match[2].replace("_", " ") if match else ""
    if match and any(convert_unit(unit, w.si) for w in wants if w.si != "1"):
        return match[1].strip(), unit
    return name, None


def _drop_points(
    rows: Rows, columns: Sequence[Column], decimal: str | None
) -> tuple[Rows, list[str]]:
    """Convert numbers such as 1.002.000 (meaning 1002.000), in which the last point is decimal.

    This requires the user's decimal sign, or a column with a number such as 0.000, because
    thousands cannot follow a lone zero.
    """
    source, table = rows.source, rows.table
    notes: list[str] = []
    if decimal == "," or not _TWO_POINTS.search(rows.body):
        return rows, notes
    for column in columns:
        cells = [fields[column.index] for _, fields in rows]
        twice = next((c for c in cells if _TWO_POINTS.fullmatch(c.encode())), None)
        if twice is None:
            continue
        if decimal is None and not any(re.fullmatch(r"[+-]?0\.\d+", c) for c in cells):
            raise FileError(
                source.path,
                f"'{twice[:20]}' in {column.name} does not show whether its last point is "
                "the decimal sign; state the decimal sign",
                how=" (--decimal . or --decimal ,)",
                asks="decimal",
            )
        number = twice.replace(".", "", twice.count(".") - 1)
        notes.append(
            f"in {column.name}, {twice} is read as {number}: the last point is the decimal sign"
        )
    if not notes:
        return rows, notes
    body = _TWO_POINTS.sub(lambda m: m[0].replace(b".", b"", m[0].count(b".") - 1), rows.body)
    data = source.data[: table.first] + body
    return Rows(replace(source, data=data), replace(table, last=None)), notes


def _check_time(
    rows: Rows, columns: Mapping[str, Column], values: Mapping[str, Array], wants: Sequence[Want]
) -> None:
    """Raise FileError, with column and line, if a required time decreases or never increases."""
    needs_time = any(w.role == "time" and not w.optional for w in wants)
    if not needs_time or "time" not in values:
        return
    backwards = np.flatnonzero(np.diff(values["time"]) < 0)
    if backwards.size:
        before, after = (float(values["time"][backwards[0] + place]) for place in (0, 1))
        raise FileError(
            rows.source.path,
            f"time runs backwards in column '{columns['time'].name[:60]}', from "
            f"{show(before, 's', 6)} to {show(after, 's', 6)}",
            rows.line(int(backwards[0]) + 1),
        )
    if len(values["time"]) < 2 or values["time"][-1] <= values["time"][0]:
        name = columns["time"].name[:60]
        raise FileError(rows.source.path, f"its time never increases, in column '{name}'")


def _parse_head(source: Source, table: Table) -> dict[str, tuple[str, ...]]:
    """Return the lines above the table as {key: values}: 'Material;EcoFlex30;'."""
    out: dict[str, tuple[str, ...]] = {}
    for number, (offset, text) in enumerate(source.lines()):
        if offset >= table.first or number + 1 == table.header.line or number == _HEAD_LINES:
            break
        fields = [f for f in split_line(text.lstrip("# "), table.separator) if f]
        if len(fields) == 1 and (match := re.match(r"([^:=]{1,60})[:=]\s*(.+)", fields[0])):
            fields = [match[1].strip(), match[2].strip()]
        if len(fields) >= 2:
            out.setdefault(normalise_name(fields[0]), tuple(fields[1:]))
    return out


def _pair_times(rows: Rows, wants: Sequence[Want], entries: Mapping[str, ColumnEntry]) -> Rows:
    """Return the rows with only the channel of the required quantity, if each has its own times.

    Files such as `Time, Hammer, Time, Acceleration` have a column of time before every channel.
    The first required quantity other than time selects the channel. The channels may end at
    different rows. Other files are unchanged.
    """
    header = rows.table.header
    clock = next((w for w in wants if w.role == "time" and w.role not in entries), None)
    main_column = next((w for w in wants if w.role != "time" and not w.optional), None)
    times = [c.index for _, c in header.candidates(clock)] if clock else []
    if (
        main_column is None
        or len(times) < 2
        or {header.names[i] for i in times} != {header.names[times[0]]}
    ):
        return rows
    channel = _find_only_column(header.candidates(main_column, entries.get(main_column.role)))
    if channel is None or channel.index < times[0]:
        return rows
    start = max(i for i in times if i < channel.index)
    end = min((i for i in times if i > start), default=len(header.names))
    part = header.select(range(start, end))
    return replace(rows, table=replace(rows.table, header=part), shared=True)


def _find_only_column(candidates: Sequence[tuple[int, Column]]) -> Column | None:
    """Return the column with the best rank, None unless there is exactly one."""
    best = min((rank for rank, _ in candidates), default=None)
    first = [column for rank, column in candidates if rank == best]
    return first[0] if len(first) == 1 else None
