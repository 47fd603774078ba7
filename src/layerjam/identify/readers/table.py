"""Where in a text the table is, and its columns as exact floats.

The structure (which byte separates, which stands in quotes) is found with a few passes over the
bytes as an array, so that 40,000 rows cost milliseconds and a broken row is known by its line.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from layerjam.errors import FileError
from layerjam.identify.columns import split_unit, unit_role
from layerjam.identify.readers.source import Source

_HEAD_LINES = 1000
_ENOUGH_ROWS = 50
_MOST_COLUMNS = 100
_SAMPLE = 6000
_LOOSE_NUMBER = re.compile(r"[+\-\u2212]?[\d.,'\u2019\s]*\d[\d.,'\u2019\s]*(?:[eE][+-]?\d+)?")


@dataclass(frozen=True)
class Table:
    """A table's head: names and units by column, and where its numbers start.

    `style` says where the units stand: "bracket row", "plain row", "names" or "" (nowhere).
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    style: str
    separator: str
    line: int
    """Line of the names, from 1."""
    first: int
    """Byte offset of the first row of numbers; the length of the file where there is none."""


def split(line: str, separator: str) -> list[str]:
    """The fields of one line, quotes taken off."""
    if '"' not in line:
        return [field.strip() for field in line.split(separator)]
    try:
        return [f.strip() for f in next(csv.reader([line], delimiter=separator))]
    except (csv.Error, StopIteration):
        return [line]


def looks_numeric(field: str) -> bool:
    """Whether a field could be a number in some country; not yet which."""
    # The pattern may try every pair of places in a text, so a long text is not given to it.
    return len(field) <= 60 and _LOOSE_NUMBER.fullmatch(field) is not None


def separator_of(lines: Iterable[str]) -> str:
    """Tab or semicolon where most lines have them outside quotes, else comma."""
    counts = {"\t": 0, ";": 0, ",": 0}
    total = 0
    for line in lines:
        bare = re.sub(r'"[^"]*"', "", line)
        if bare.strip() or '"' in line:
            total += 1
            for mark in counts:
                counts[mark] += mark in bare
    # A comma may be a decimal comma, so the other two come first.
    return next((mark for mark in ("\t", ";") if counts[mark] * 2 > total), ",")


def find_table(source: Source) -> Table | None:
    """The table with the most rows in the first thousand lines; None where none has a header."""
    head: list[tuple[int, str]] = []
    for item in source.lines():
        head.append(item)
        if len(head) == _HEAD_LINES:
            break
    separator = separator_of(text for _, text in head[-200:])
    best: tuple[tuple[bool, int], Table] | None = None
    texts: list[tuple[int, list[str]]] = []  # the latest run of rows without any number
    rows, first = 0, len(source.data)

    def close() -> None:
        nonlocal best
        table = _head_of(texts, separator, first)
        if table is not None:
            score = (bool(table.style), rows)
            if best is None or score >= best[0]:
                best = (score, table)

    for number, (offset, text) in enumerate(head, 1):
        fields = split(text, separator)
        filled = [f for f in fields if f]
        if not filled:
            continue
        if any(looks_numeric(f) for f in filled):
            first = offset if rows == 0 else first
            rows += 1
            enough = _head_of(texts, separator, first) if rows == _ENOUGH_ROWS else None
            if enough is not None and enough.style:
                return enough
        elif len(filled) >= 2:
            if rows:
                close()
                texts, rows, first = [], 0, len(source.data)
            texts.append((number, fields))
            del texts[:-3]
    close()
    return best[1] if best else None


def _head_of(texts: Sequence[tuple[int, list[str]]], separator: str, first: int) -> Table | None:
    """Names and units from the last one or two rows of text above the numbers."""
    if not texts:
        return None
    number, fields = texts[-1]
    last = _trimmed(fields)
    if not 2 <= len(last) <= _MOST_COLUMNS:
        return None
    if len(texts) > 1:
        above_number, above = texts[-2][0], _trimmed(texts[-2][1])
        bracketed = [bool(re.fullmatch(r"[(\[].*[)\]]", f)) for f in last if f]
        units = tuple(re.sub(r"^[(\[]|[)\]]$", "", f).strip() or None for f in last)
        short = all(len(u or "") <= 20 for u in units)
        fits = len(above) >= len(last) and len(above) <= _MOST_COLUMNS and short
        if fits and any(u and unit_role(u) for u in units):
            padded = units + (None,) * (len(above) - len(units))
            style = "bracket row" if all(bracketed) else "plain row"
            return Table(tuple(above), padded, style, separator, above_number, first)
    pairs = [split_unit(f) for f in last]
    style = "names" if any(unit is not None for _, unit in pairs) else ""
    return Table(
        tuple(n for n, _ in pairs), tuple(u for _, u in pairs), style, separator, number, first
    )


def _trimmed(fields: list[str]) -> list[str]:
    """Without empty fields at the end, which a trailing separator leaves."""
    count = len(fields)
    while count and not fields[count - 1]:
        count -= 1
    return fields[:count]


@dataclass(frozen=True)
class Grid:
    """Rows of one width in ASCII, tab-separated and without quotes, and the file's line of each."""

    path: str
    text: bytes
    columns: int
    lines: npt.NDArray[np.int64]
    ended: bool
    """Whether the file's last line has its line end."""

    def line(self, row: int) -> int:
        """The file's line of a row, from 1."""
        return int(self.lines[row])

    def rows(self) -> list[list[str]]:
        """All rows as text."""
        return _fields(self.text)

    def sample(self) -> list[list[str]]:
        """Some whole rows from the beginning and the end as text."""
        if len(self.text) <= 2 * _SAMPLE:
            return _fields(self.text)
        head = self.text[: self.text.rfind(b"\n", 0, _SAMPLE) + 1]
        return (_fields(head) + self.tail()) or _fields(self.text)

    def tail(self) -> list[list[str]]:
        """The last rows as text, about two hundred of common length."""
        text = self.text[-_SAMPLE:]
        return _fields(text if len(text) == len(self.text) else text.partition(b"\n")[2])


def _fields(text: bytes) -> list[list[str]]:
    return [line.split("\t") for line in text.decode("ascii").split("\n")[:-1]]


def read_grid(source: Source, table: Table) -> Grid:
    """The rows of a table; FileError, with the line, where a row has not one field per column."""
    body = source.data[table.first :]
    start = source.line_number(table.first)
    if not body.strip():
        raise FileError(source.path, "holds column names and no rows of numbers", table.line)
    body = body.rstrip(b"\x1a")
    ended = body.endswith(b"\n")
    if not body.isascii():
        body = _ascii(body, source.encoding)
    if not ended:
        body += b"\n"
    raw = np.frombuffer(body, np.uint8).copy()
    mark = ord(table.separator)
    inside = _inside_quotes(raw, mark, source.path, start, ended) if b'"' in body else None
    delimiter = (raw == mark) | (raw == 10)
    if inside is not None:
        delimiter &= ~inside
    places = np.flatnonzero(delimiter)
    ends = np.flatnonzero(raw[places] == 10)
    fields = np.diff(ends, prepend=-1)
    stops = places[ends]
    lengths = np.diff(stops, prepend=-1) - 1
    lines = np.arange(start, start + len(ends))
    blank = lengths < fields  # nothing but separators
    for row in np.flatnonzero((fields == 1) & ~blank):
        blank[row] = not body[stops[row] - lengths[row] : stops[row]].strip()
    wanted = len(table.names)
    for row in np.flatnonzero((fields != wanted) & ~blank):
        text = body[stops[row] - lengths[row] : stops[row]].decode("ascii")
        parts = split(text, table.separator)
        if fields[row] > wanted and not any(parts[wanted:]):
            continue
        last = not ended and row == len(ends) - 1
        raise _broken_row(source.path, parts, wanted, int(lines[row]), last, int(row))
    raw[raw == 9] = 32  # a tab within a field is a blank; separators become tabs
    raw[places] = np.where(raw[places] == 10, 10, 9)
    clean = raw.tobytes()
    if blank.any():
        kept = zip(clean.split(b"\n")[:-1], blank.tolist(), strict=True)
        clean = b"".join([row + b"\n" for row, is_blank in kept if not is_blank])
        lines = lines[~blank]
    if inside is not None:
        clean = clean.replace(b'"', b"")
    return Grid(source.path, clean, wanted, lines, ended)


def _broken_row(
    path: str, parts: list[str], wanted: int, line: int, last: bool, row: int
) -> FileError:
    if last:
        return FileError(
            path,
            f"the last line is cut off: {_count(len(parts))} where {wanted} are due; "
            "the file is not whole",
            line,
        )
    if not any(looks_numeric(p) for p in parts):
        return no_row_of_numbers(path, parts, line)
    hint = ""
    if row == 0 and len(parts) > wanted:
        hint = "; decimal commas need another separator than the comma"
    return FileError(path, f"has {_count(len(parts))} where {wanted} are due{hint}", line)


def no_row_of_numbers(path: str, parts: Sequence[str], line: int) -> FileError:
    """The error for a line of words below the numbers."""
    return FileError(
        path,
        f"'{_short(' '.join(parts))}' is no row of numbers; a file may hold one specimen and "
        "nothing below its numbers",
        line,
    )


def _count(number: int) -> str:
    return f"{number} value" if number == 1 else f"{number} values"


def _short(text: str) -> str:
    text = "".join(c if c.isprintable() else "?" for c in text)
    return text if len(text) <= 40 else text[:37] + "..."


def _ascii(body: bytes, encoding: str) -> bytes:
    """Minus signs, hard blanks and apostrophes of typesetters as ASCII, the rest as '?'."""
    text = body.decode(encoding, errors="replace")
    text = text.translate({0x2212: "-", 0xA0: " ", 0x202F: " ", 0x2009: " ", 0x2019: "'"})
    return text.encode("ascii", errors="replace")


def _inside_quotes(
    raw: npt.NDArray[np.uint8], mark: int, path: str, start: int, ended: bool
) -> npt.NDArray[np.bool_]:
    """Which bytes stand in quotes; FileError where a quote does not open or close a field."""
    quote = raw == 34
    inside = np.bitwise_xor.accumulate(quote.view(np.uint8)).view(np.bool_)
    lost = np.flatnonzero(inside & (raw == 10))
    places = np.flatnonzero(quote)
    if not lost.size:
        before = raw[np.maximum(places[0::2] - 1, 0)]
        after = raw[places[1::2] + 1]
        fine = (before == mark) | (before == 10) | (before == 32) | (places[0::2] == 0)
        fine &= (after == mark) | (after == 10) | (after == 32)
        lost = places[0::2][~fine]
    if lost.size:
        line = int((raw[: lost[0]] == 10).sum())
        last = int((raw == 10).sum()) - 1 == line and not ended
        reason = "a quote is not closed, or stands within a field"
        raise FileError(
            path, f"the last line is cut off: {reason}" if last else reason, start + line
        )
    return inside
