"""Layouts of particular programs, converted to plain tables.

Each function converts a file's bytes to the same number of lines, so that an error names the line
in the user's file. The program's own header is blanked; names and units are joined in one line.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from layerjam.core.plugins import list_plugins, load_plugin
from layerjam.laboratory.measure.readers.unit_words import convert_unit, force_unit_for

GROUP = "layerjam.layouts"
"""Entry points: functions from the bytes of a file to its Layout; others return it as it is."""
_HEAD = 20_000
_STAMP = re.compile(rb"^[ \t]*\d{1,2}:\d{2}:\d{2}(?:[.,]\d{1,6})? -> ?")
_FEW = 20
_SKETCH = {b"millis": b"time [ms]", b"micros": b"time [us]"} | {
    **dict.fromkeys((b"grams", b"gram", b"g"), b"force [gf]"),
    **{unit: b"position [" + unit + b"]" for unit in (b"mm", b"cm", b"um")},
}
"""{unit as the name of a column in an Arduino sketch: its name and unit}."""
_TEXTURE = {
    tuple(sorted(names)): grams
    for names, grams in (
        ((b"time", b"distance", b"force"), b"g"),
        ((b"time (sec)", b"distance (mm)", b"force (g)"), b"force (g)"),
    )
}
_LVM = b"LabVIEW Measurement"
_LVM_END = b"***End_of_Header***"
_GRAMS = "the force is in grams, read as gram-force (gf): 1 g weighs 9.80665 mN"

_CELL = re.compile(
    rb'("?)([+-]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?)[ \xa0]?([^\s\d"+\-.,][^\s"]{0,9})\1'
)
"""A number with its unit: 12.3 N."""
_LONGEST = 40
_HAS_UNIT = re.compile(rb'\d[.,]?[ \xa0]?(?![eE][+-]?\d)[^\s\d.,;|+\-"]')
"""A digit before a letter, unless it is that of an exponent; lines of plain numbers have none."""
_QUANTITIES = ("s", "m", "N", "Pa", "m/s^2", "K", "1")
_FEWEST = 3


@dataclass(frozen=True)
class Layout:
    """Lines of a file as a table, notes about the conversion, and the decimal sign if stated."""

    data: bytes
    notes: tuple[str, ...] = ()
    decimal: str | None = None


def clean_lines(data: bytes) -> Layout:
    """Return the lines of a file without the program's additions.

    Each layout of the entry points `layerjam.layouts`, in the order of their names, converts what
    the one before returned.
    """
    result = Layout(data)
    for name in list_plugins(GROUP):
        layout: Layout = load_plugin(GROUP, name)(result.data)
        notes = (*result.notes, *layout.notes)
        result = Layout(layout.data, notes, layout.decimal or result.decimal)
    return result


def clean_serial_monitor(data: bytes) -> Layout:
    """Remove the time stamp of each line (`12:34:05.678 -> 12,0.3`); merge comma and tab."""
    head = [line for line in data[:_HEAD].split(b"\n") if line.strip()][:_FEW]
    notes = []
    if head and 2 * sum(bool(_STAMP.match(line)) for line in head) > len(head):
        lines = data.split(b"\n")
        data = b"\n".join(_STAMP.sub(b"", line) for line in lines)
        notes.append("the serial monitor's time stamp before each line is not read")
    if 2 * sum(b",\t" in line for line in head) > len(head):
        data = data.replace(b",\t", b"\t")
    return Layout(data, tuple(notes))


def name_sketch_columns(data: bytes) -> Layout:
    """Name the columns of an Arduino sketch whose header is only units: `millis,grams,mm`."""
    for number, line in enumerate(data[:_HEAD].split(b"\n")[:_FEW]):
        for mark in (b",", b";", b"\t"):
            units = _find_words(line, mark)
            if len(units) == 3 and len({_SKETCH.get(unit, b"")[:4] for unit in units} - {b""}) == 3:
                names = mark.join(_SKETCH[unit] for unit in units)
                return Layout(_insert_line(data, number, names), (_GRAMS,))
    return Layout(data)


def read_texture_analyser(data: bytes) -> Layout:
    """Read Exponent's `Time,Distance,Force` above `sec,mm,g`, or `Force (g)` in one line."""
    lines = data[:_HEAD].split(b"\n")[:_FEW]
    for number, line in enumerate(lines):
        for mark in (b"\t", b",", b";"):
            names = _find_words(line, mark)
            grams = _TEXTURE.get(tuple(sorted(names)))
            if grams is None:
                continue
            if grams in names:
                named_line = re.sub(re.escape(b"(g)"), b"(gf)", line, flags=re.IGNORECASE)
                return Layout(_insert_line(data, number, named_line), (_GRAMS,))
            units = _find_words(lines[number + 1], mark) if number + 1 < len(lines) else []
            force_index = names.index(b"force")
            if len(units) == len(names) and units[force_index] == grams and b"mm" in units:
                units[force_index] = b"gf"
                return Layout(_insert_line(data, number + 1, mark.join(units)), (_GRAMS,))
    return Layout(data)


def read_labview(data: bytes) -> Layout:
    """Read a LabVIEW measurement (.lvm), with units and time steps above each block of rows."""
    if not data[:99].lstrip().startswith(_LVM):
        return Layout(data)
    lines = data.split(b"\n")
    ends = [n for n, line in enumerate(lines) if line.startswith(_LVM_END)]
    mark = b"," if re.search(rb"(?m)^Separator[\t,]Comma", data[:_HEAD]) else b"\t"
    decimal_line = re.search(rb"(?m)^Decimal_Separator[\t,]([.,])", data[:_HEAD])
    decimal = decimal_line[1].decode() if decimal_line else None
    first = 0
    for end in ends[1:] or ends:
        head_entries = {
            f[0]: f[1:] for f in (line.split(mark) for line in lines[first:end]) if f[0]
        }
        lines[first : end + 1] = [b""] * (end + 1 - first)
        first = _prepare_lvm_rows(lines, end + 1, head_entries, mark, decimal or ".")
    return Layout(b"\n".join(lines), decimal=decimal)


def _prepare_lvm_rows(
    lines: list[bytes], head: int, above: dict[bytes, list[bytes]], mark: bytes, decimal: str
) -> int:
    """Join units to the names below a header, add missing times, and return the last row's end.

    Entries above the header belong to the columns of the channels; the key belongs to the first
    column, which has the times. Each channel may have its own column of times.
    """

    def find_entry(key: bytes, column: int) -> bytes:
        entries = above.get(key, [])
        return entries[column].strip() if 0 <= column < len(entries) else b""

    names = []
    for column, name in enumerate(
        lines[head].rstrip(b"\r").split(mark) if head < len(lines) else []
    ):
        of_time = name.strip() == b"X_Value" and find_entry(b"X_Dimension", column) == b"Time"
        unit = b"s" if of_time else find_entry(b"Y_Unit_Label", column - 1)
        names.append((b"Time" if of_time else name) + (b" [" + unit + b"]" if unit else b""))
    if names:
        lines[head] = mark.join(names)
    steps = {_parse_first([entry]) for entry in above.get(b"Delta_X", []) if entry.strip()}
    start, step = _parse_first(above.get(b"X0", [])) or 0.0, next(iter(steps), None)
    row, count = head + 1, 0
    while row < len(lines) and not lines[row].startswith(b"Channels"):
        if lines[row].startswith(mark) and step is not None and len(steps) == 1:
            time = repr(start + count * step).replace(".", decimal)
            lines[row] = time.encode() + lines[row]
        count += bool(lines[row].strip())
        row += 1
    return row


def move_units_to_header(data: bytes) -> Layout:
    """Move the units in cells (`12.3 N`) into the names above them.

    A cell with a different unit remains, and is an error when the numbers are read.
    """
    head = data[:_HEAD].split(b"\n")
    has_unit = [bool(_HAS_UNIT.search(line)) for line in head]
    if not any(has_unit[:200]):
        return Layout(data)
    for mark in (b"\t", b";", b",", b"|"):
        for number in (n for n in range(len(head) - _FEWEST) if has_unit[n + 1]):
            lines = head[number : number + 1 + _FEWEST]
            names, *rows = (line.rstrip(b"\r").split(mark) for line in lines)
            if len(names) > 1 and all(len(row) == len(names) for row in rows):
                units = [_find_cell_unit([row[i] for row in rows]) for i in range(len(names))]
                if any(units) and not any(map(_match_cell, names)):
                    return Layout(
                        _remove_cell_units(data, number, mark, units),
                        ("the units in the cells are those of their columns",),
                    )
    return Layout(data)


@lru_cache(maxsize=4096)
def _match_cell(cell: bytes) -> re.Match[bytes] | None:
    """Return the quote, number and unit in a cell."""
    return _CELL.fullmatch(cell.strip()) if len(cell) <= _LONGEST else None


def _find_cell_unit(cells: Sequence[bytes]) -> bytes:
    """Return the unit in all of these cells; empty if they have none, or different ones."""
    matches = [_match_cell(cell) for cell in cells]
    units = {match[3] for match in matches if match}
    if len(units) != 1 or not all(matches):
        return b""
    text = next(iter(units)).decode(errors="replace")
    known = force_unit_for(text) or any(convert_unit(text, si) for si in _QUANTITIES)
    return next(iter(units)) if known else b""


def _remove_cell_units(data: bytes, head: int, mark: bytes, units: Sequence[bytes]) -> bytes:
    """Return the text with the units of columns in the names, which are in line `head`."""
    lines = data.split(b"\n")
    names = lines[head].rstrip(b"\r").split(mark)
    for index, unit in enumerate(units):
        if unit and unit not in names[index]:
            names[index] = names[index].strip(b' "') + b" [" + unit + b"]"
    lines[head] = mark.join(names)
    for number in range(head + 1, len(lines)):
        cells = lines[number].split(mark)
        for index, (cell, unit) in enumerate(zip(cells, units, strict=False)):
            match = _match_cell(cell) if unit else None
            if match and match[3] == unit:
                cells[index] = match[1] + match[2] + match[1]
        lines[number] = mark.join(cells)
    return b"\n".join(lines)


def read_mts(data: bytes) -> Layout:
    """Join the blocks of one MTS 793 file, each with a title and the same names, into one table.

    Blocks in which the time restarts are separate tests and remain separate.
    """
    if b"MTS793" not in data[:200]:
        return Layout(data)
    lines = data.split(b"\n")
    heads = [n for n in range(len(lines) - 1) if _is_header(lines[n], lines[n + 1])]
    matches = [n for n in heads if lines[n : n + 2] == lines[heads[0] : heads[0] + 2]]
    if len(matches) < 2 or len(matches) < len(heads):
        return Layout(data)
    names = _find_words(lines[heads[0]], b"\t")
    times = [k for k, name in enumerate(names) if re.fullmatch(rb"(running )?time", name)]
    rows = [_find_last_row(lines, n) for n in matches[1:]]
    for head, row in zip(matches[1:], rows, strict=True):
        before, after = (_read_number(lines, n, times) for n in (row, head + 2))
        if before is not None and after is not None and after < before:
            return Layout(data)
    for head, row in zip(matches[1:], rows, strict=True):
        lines[row + 1 : head + 2] = [b""] * (head + 1 - row)
    return Layout(b"\n".join(lines), (f"{len(matches)} blocks of one test, read as one table",))


def _is_header(names: bytes, units: bytes) -> bool:
    """Return whether two lines are the names and units of the same number of columns."""
    name_words, unit_words = _find_words(names, b"\t"), _find_words(units, b"\t")
    texts = [*name_words, *unit_words]
    return len(name_words) == len(unit_words) >= 2 and all(
        t and _parse_first([t]) is None for t in texts
    )


def _find_last_row(lines: list[bytes], head: int) -> int:
    return next(
        (n for n in range(head - 1, -1, -1) if _parse_first(lines[n].split(b"\t")) is not None),
        head - 1,
    )


def _read_number(lines: list[bytes], row: int, columns: list[int]) -> float | None:
    """Return the number in the first of a row's `columns`, or None."""
    fields = lines[row].split(b"\t") if 0 <= row < len(lines) else []
    return _parse_first(fields[columns[0] :]) if columns and columns[0] < len(fields) else None


def _parse_first(fields: list[bytes]) -> float | None:
    try:
        return float(fields[0].replace(b",", b".")) if fields else None
    except ValueError:
        return None


def _find_words(line: bytes, mark: bytes) -> list[bytes]:
    return [word.strip(b' "\r\t').lower() for word in line.split(mark) if word.strip(b' "\r\t')]


def _insert_line(data: bytes, number: int, line: bytes) -> bytes:
    lines = data.split(b"\n", number + 1)
    return b"\n".join([*lines[:number], line, *lines[number + 1 :]])
