"""Layouts of particular programs, converted to plain tables.

Each function converts a file's bytes to the same number of lines, so that an error names the line
in the user's file. The program's own header is blanked; names and units are joined in one line.
"""

import re
from collections.abc import Callable

_HEAD = 20_000
_STAMP = re.compile(rb"^[ \t]*\d{1,2}:\d{2}:\d{2}(?:[.,]\d{1,6})? -> ?")
_FEW = 20
_UNITS_ALONE = re.compile(rb"(millis|micros)\s*([,;\t])\s*(grams?|g)\s*\2\s*(mm|cm|um)\s*")
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

Layout = tuple[bytes, tuple[str, ...]]
"""Lines of a file as a table, with notes about the conversion."""


def clean_lines(data: bytes) -> Layout:
    """Return the lines of a file without the program's additions, and notes about the changes."""
    notes: list[str] = []
    for layout in _LAYOUTS:
        data, layout_notes = layout(data)
        notes += layout_notes
    return data, tuple(notes)


def _clean_serial_monitor(data: bytes) -> Layout:
    """Remove the time stamp of each line (`12:34:05.678 -> 12,0.3`); merge comma and tab."""
    head = [line for line in data[:_HEAD].split(b"\n") if line.strip()][:_FEW]
    notes = []
    if head and 2 * sum(bool(_STAMP.match(line)) for line in head) > len(head):
        lines = data.split(b"\n")
        data = b"\n".join(_STAMP.sub(b"", line) for line in lines)
        notes.append("the serial monitor's time stamp before each line is not read")
    if 2 * sum(b",\t" in line for line in head) > len(head):
        data = data.replace(b",\t", b"\t")
    return data, tuple(notes)


def _name_sketch_columns(data: bytes) -> Layout:
    """Name the columns of an Arduino sketch whose header is only units: `millis,grams,mm`."""
    for number, line in enumerate(data[:_HEAD].split(b"\n")[:_FEW]):
        match = _UNITS_ALONE.fullmatch(line.strip().lower())
        if match:
            mark, time = match[2], b"ms" if match[1] == b"millis" else b"us"
            names = (b"time [" + time + b"]", b"force [gf]", b"position [" + match[4] + b"]")
            return _insert_line(data, number, mark.join(names)), (_GRAMS,)
    return data, ()


def _read_texture_analyser(data: bytes) -> Layout:
    """Read Exponent's `Time,Distance,Force` above `sec,mm,g`, or `Force (g)` in one line."""
    lines = data[:_HEAD].split(b"\n")[:_FEW]
    for number, line in enumerate(lines):
        for mark in (b"\t", b",", b";"):
            names = _find_words(line, mark)
            grams = _TEXTURE.get(tuple(sorted(names)))
            if grams is None:
                continue
            if grams in names:
                return _insert_line(data, number, _replace_text(line, b"(g)", b"(gf)")), (_GRAMS,)
            units = _find_words(lines[number + 1], mark) if number + 1 < len(lines) else []
            force_index = names.index(b"force")
            if len(units) == len(names) and units[force_index] == grams and b"mm" in units:
                units[force_index] = b"gf"
                return _insert_line(data, number + 1, mark.join(units)), (_GRAMS,)
    return data, ()


def _read_labview(data: bytes) -> Layout:
    """Read a LabVIEW measurement (.lvm), with units and time steps above each block of rows."""
    if not data[:99].lstrip().startswith(_LVM):
        return data, ()
    lines = data.split(b"\n")
    ends = [n for n, line in enumerate(lines) if line.startswith(_LVM_END)]
    mark = b"," if re.search(rb"(?m)^Separator[\t,]Comma", data[:_HEAD]) else b"\t"
    first = 0
    for end in ends[1:] or ends:
        above = {f[0]: f[1:] for f in (line.split(mark) for line in lines[first:end]) if f[0]}
        lines[first : end + 1] = [b""] * (end + 1 - first)
        first = _prepare_lvm_rows(lines, end + 1, above, mark)
    return b"\n".join(lines), ()


def _prepare_lvm_rows(
    lines: list[bytes], head: int, above: dict[bytes, list[bytes]], mark: bytes
) -> int:
    """Join units to the names below a header, add missing times, and return the last row's end."""
    units = iter(above.get(b"Y_Unit_Label", []))
    names = []
    for name in lines[head].rstrip(b"\r").split(mark) if head < len(lines) else []:
        of_time = name.strip() == b"X_Value" and above.get(b"X_Dimension", [b""])[0] == b"Time"
        unit = b"s" if of_time else b"" if name.strip() in (b"X_Value", b"Comment") else None
        unit = next(units, b"").strip() if unit is None else unit
        names.append((b"Time" if of_time else name) + (b" [" + unit + b"]" if unit else b""))
    if names:
        lines[head] = mark.join(names)
    start, step = (_parse_first(above.get(key, [])) for key in (b"X0", b"Delta_X"))
    row, count = head + 1, 0
    while row < len(lines) and not lines[row].startswith(b"Channels"):
        if lines[row].startswith(mark) and step is not None:
            lines[row] = repr((start or 0.0) + count * step).encode() + lines[row]
        count += bool(lines[row].strip())
        row += 1
    return row


def _read_mts(data: bytes) -> Layout:
    """Join the blocks of one MTS 793 file, each with a title and the same names, into one table.

    Blocks in which the time restarts are separate tests and remain separate.
    """
    if b"MTS793" not in data[:200]:
        return data, ()
    lines = data.split(b"\n")
    heads = [n for n in range(len(lines) - 1) if _is_header(lines[n], lines[n + 1])]
    same = [n for n in heads if lines[n : n + 2] == lines[heads[0] : heads[0] + 2]]
    if len(same) < 2 or len(same) < len(heads):
        return data, ()
    names = _find_words(lines[heads[0]], b"\t")
    times = [k for k, name in enumerate(names) if re.fullmatch(rb"(running )?time", name)]
    rows = [_find_last_row(lines, n) for n in same[1:]]
    for head, row in zip(same[1:], rows, strict=True):
        before, after = (_read_number(lines, n, times) for n in (row, head + 2))
        if before is not None and after is not None and after < before:
            return data, ()
    for head, row in zip(same[1:], rows, strict=True):
        lines[row + 1 : head + 2] = [b""] * (head + 1 - row)
    return b"\n".join(lines), (f"{len(same)} blocks of one test, read as one table",)


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


def _replace_text(line: bytes, old: bytes, new: bytes) -> bytes:
    return re.sub(re.escape(old), new, line, flags=re.IGNORECASE)


def _insert_line(data: bytes, number: int, line: bytes) -> bytes:
    lines = data.split(b"\n", number + 1)
    return b"\n".join([*lines[:number], line, *lines[number + 1 :]])


_LAYOUTS: tuple[Callable[[bytes], Layout], ...] = (
    _clean_serial_monitor,
    _name_sketch_columns,
    _read_texture_analyser,
    _read_labview,
    _read_mts,
)
