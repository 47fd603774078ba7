"""The rows of a table as one text of tabs and line ends, found with passes over the bytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from layerjam.errors import FileError
from layerjam.measure.readers.columns import Header, cut
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.encoding import TYPOGRAPHY
from layerjam.measure.readers.lines import looks_numeric, split

_SAMPLE = 6000


@dataclass(frozen=True)
class Table:
    """A table's head: names and units by column, and where its numbers start and end.

    `style` says where the units stand: "bracket row", "plain row", "names", "units" or ""
    (nowhere).
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    style: str
    separator: str
    line: int
    """Line of the names, from 1."""
    first: int
    """Byte offset of the first row of numbers; the length of the file where there is none."""
    last: int | None = None
    """Byte offset behind the last row; None where it is the file's end."""
    rows: int = 0
    label: tuple[str, ...] = field(default=(), compare=False)
    """The fields of the line above the names, which may number specimens."""

    def header(self, path: str) -> Header:
        """Its names and units, and where they stand."""
        return Header(self.names, self.units, path, self.line)


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

    def until_empty(self, columns: Sequence[int]) -> Grid:
        """The rows down to where all these columns end: side by side, a short one ends early.

        A cell that is empty further up stays, for that is damage.
        """
        raw = np.frombuffer(self.text, np.uint8)
        places = np.flatnonzero((raw == 9) | (raw == 10))
        ends = np.flatnonzero(raw[places] == 10)
        begin = np.concatenate(([0], ends[:-1] + 1))
        width = np.diff(places, prepend=-1) - 1
        filled = np.zeros(len(ends), np.bool_)
        for column in columns:
            filled |= width[np.minimum(begin + column, ends)] > 0
        rows = int(np.flatnonzero(filled)[-1]) + 1 if filled.any() else 0
        if rows == len(ends):
            return self
        stop = int(places[ends[rows - 1]]) + 1 if rows else 0
        return Grid(self.path, self.text[:stop], self.columns, self.lines[:rows], True)


def _fields(text: bytes) -> list[list[str]]:
    return [line.split("\t") for line in text.decode("ascii").split("\n")[:-1]]


def read_grid(source: Source, table: Table, ragged: bool = False) -> Grid:
    """The rows of a table; FileError, with the line, where a row has not one field per column.

    With `ragged`, rows may end early (several specimens side by side) and are filled up.
    """
    body = source.data[table.first : table.last]
    start = source.line_number(table.first)
    if not body or body.isspace():
        raise FileError(source.path, "holds column names and no rows of numbers", table.line)
    body = body.rstrip(b"\x1a")
    ended = body.endswith(b"\n")
    if not body.isascii():
        body = _ascii(body, source.encoding)
    if not ended:
        body += b"\n"
    mark = ord(table.separator)
    if table.separator == " ":
        body, mark = _one_tab(body), 9
    raw = np.frombuffer(body, np.uint8).copy()
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
    short = []
    for row in np.flatnonzero((fields != wanted) & ~blank):
        if ragged and fields[row] < wanted and (ended or row < len(ends) - 1):
            short.append(row)
            continue
        text = body[stops[row] - lengths[row] : stops[row]].decode("ascii")
        parts = split(text, chr(mark))
        if fields[row] > wanted and not any(parts[wanted:]):
            continue
        last = not ended and row == len(ends) - 1
        raise _broken_row(source.path, parts, wanted, int(lines[row]), last, int(row))
    raw[raw == 9] = 32  # a tab within a field is a blank; separators become tabs
    raw[places] = np.where(raw[places] == 10, 10, 9)
    clean = raw.tobytes()
    if blank.any() or short:
        texts = clean.split(b"\n")[:-1]
        for row in short:
            texts[row] += b"\t" * int(wanted - fields[row])
        kept = zip(texts, blank.tolist(), strict=True)
        clean = b"".join([row + b"\n" for row, is_blank in kept if not is_blank])
        lines = lines[~blank]
    if inside is not None:
        clean = clean.replace(b'"', b"")
    return Grid(source.path, clean, wanted, lines, ended)


def _one_tab(body: bytes) -> bytes:
    """One tab for each run of blanks between fields, none at the ends of lines."""
    raw = np.frombuffer(body, np.uint8)
    blank = (raw == 32) | (raw == 9)
    end = raw == 10
    before = np.concatenate(([True], (blank | end)[:-1]))
    at = np.flatnonzero(blank & ~before)  # the first blank behind each field
    keep = ~blank
    keep[at] = True
    kept = raw[keep].copy()
    kept[kept == 32] = 9
    last = np.flatnonzero(kept[1:] == 10)  # a blank that only a line end follows is no separator
    last = last[kept[last] == 9]
    return bytes(np.delete(kept, last).tobytes())


def _broken_row(
    path: str, parts: list[str], wanted: int, line: int, last: bool, row: int
) -> FileError:
    if last:
        return FileError(
            path,
            f"the last line is cut off: {count_of(len(parts))} where {wanted} are due; "
            "the file is not whole",
            line,
        )
    if not any(looks_numeric(p) for p in parts):
        return no_row_of_numbers(path, parts, line)
    hint = ""
    if row == 0 and len(parts) > wanted:
        hint = "; decimal commas need another separator than the comma"
    return FileError(path, f"has {count_of(len(parts))} where {wanted} are due{hint}", line)


def no_row_of_numbers(path: str, parts: Sequence[str], line: int) -> FileError:
    """The error for a line of words among the numbers."""
    return FileError(
        path,
        f"'{cut(' '.join(parts))}' is no row of numbers, and rows of numbers without names "
        "follow it; is the file damaged there?",
        line,
    )


def count_of(number: int) -> str:
    """A number of values, in words."""
    return f"{number} value" if number == 1 else f"{number} values"


def _ascii(body: bytes, encoding: str) -> bytes:
    """Signs of typesetters as ASCII, what else is not ASCII as '?'."""
    text = body.decode(encoding, errors="replace").translate(
        {ord(k): v for k, v in TYPOGRAPHY.items()}
    )
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
