"""Lines of a text and rows of a table: separator, fields, and whether they contain numbers.

The characters in a line determine its kind, so that reading 40,000 lines of numbers takes
milliseconds. Only lines with letters and digits are examined field by field.
"""

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice

import numpy as np
import numpy.typing as npt

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.readers.column_names import shorten
from layerjam.laboratory.measure.readers.content import LONGEST_LINE, TYPOGRAPHY, Source
from layerjam.laboratory.measure.readers.header import Header

_HEAD_BYTES = 300_000
_LOOSE_NUMBER = re.compile(r"[+\-\u2212]?[\d.,'\u2019\s]*\d[\d.,'\u2019\s]*(?:[eE][+-]?\d+)?")
_BARE_NUMBERS = re.compile(r"[\d\s.,;|+\-eE'\u2019\u2212]*\d[\d\s.,;|+\-eE'\u2019\u2212]*")
_WORD = re.compile(r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?")

_BLANK, _DIGIT, _SIGN, _SEPARATOR, _LETTER = map(np.uint8, (0, 1, 2, 4, 8))
_KIND_OF = {
    b"0123456789": _DIGIT,
    b"+-.'eE": _SIGN,
    b",;|": _SEPARATOR,
    b' \t\f\x1a\x0b"\n': _BLANK,
}
_KIND = {byte: int(kind) for signs, kind in _KIND_OF.items() for byte in signs}
_KINDS = bytes(_KIND.get(byte, int(_LETTER)) for byte in range(256))
"""Kind of each byte: part of a number, separator, blank (0), or anything else."""

Flags = npt.NDArray[np.bool_]
Places = npt.NDArray[np.int64]
_SAMPLE_ROWS, _TAIL_BYTES = 200, 6000
_SIGNS = str.maketrans(TYPOGRAPHY)


def split_line(line: str, separator: str) -> list[str]:
    """Return the fields of one line without quotes; the separator " " means any run of blanks."""
    if separator == " ":
        return line.replace('"', " ").split()
    if '"' not in line:
        return [field.strip() for field in line.split(separator)]
    try:
        fields = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
        return [field.strip() for field in fields]
    except (csv.Error, StopIteration):
        return [line]


def can_be_number(field: str) -> bool:
    """Return whether a field may be a number in some notation."""
    # the pattern may try every pair of positions, so it is not used for long texts
    return len(field) <= 60 and _LOOSE_NUMBER.fullmatch(field) is not None


def find_separator(lines: Iterable[str]) -> str:
    """Return tab, semicolon or bar if most lines contain it unquoted, otherwise blank or comma.

    If there are lines of numbers, only these count, because texts may contain any character.
    """
    plain_lines = [re.sub(r'"[^"]*"', "0", line) for line in lines if line.strip()]
    numbers = [line for line in plain_lines if len(line) <= 2000 and _BARE_NUMBERS.fullmatch(line)]
    evidence = numbers if len(numbers) >= 3 else plain_lines
    # a comma may be a decimal comma, so try the other separators first
    for mark in ("\t", ";", "|"):
        if sum(mark in line.strip(" ") for line in evidence) * 2 > len(evidence):
            return mark
    blanks = sum(_is_row_of_numbers(line) for line in evidence)
    return " " if evidence and blanks * 2 > len(evidence) else ","


def _is_row_of_numbers(line: str) -> bool:
    """Return whether a line consists of at least two numbers separated by blanks."""
    fields = line.split()
    return len(fields) >= 2 and all(_WORD.fullmatch(f) for f in fields)


@dataclass(frozen=True)
class Lines:
    """Every line of a source, with its position and its kind.

    `starts` and `stops` [bytes] exclude the line ending. `number` marks lines with any number,
    `pure` lines of numbers only, and `blank` lines of separators only.
    """

    source: Source
    separator: str
    starts: Places
    stops: Places
    number: Flags
    pure: Flags
    blank: Flags

    def text(self, line: int) -> str:
        """Return the text of a line (from 0)."""
        return self.source.text(int(self.starts[line]), int(self.stops[line]))

    def fields(self, line: int) -> list[str]:
        """Return the fields of a line (from 0)."""
        return split_line(self.text(line), self.separator)


def read_lines(source: Source) -> Lines:
    """Return every line of a source; raises FileError if one is too long for a table."""
    separator = find_separator(_sample_lines(source))
    raw = np.frombuffer(source.data, np.uint8)
    stops = np.flatnonzero(raw == ord("\n"))
    if raw[-1] != ord("\n"):
        stops = np.append(stops, len(raw))
    starts = np.concatenate(([0], stops[:-1] + 1))
    longest = int((stops - starts).argmax())
    if stops[longest] - starts[longest] > LONGEST_LINE:
        raise source.make_length_error(int(stops[longest] - starts[longest]), longest + 1)
    kinds = np.frombuffer(source.data.translate(_KINDS), np.uint8)
    kinds_of_line = np.bitwise_or.reduceat(kinds, starts)
    blank = (kinds_of_line if separator == " " else kinds_of_line & ~_SEPARATOR) == 0
    digit, has_letters = kinds_of_line & _DIGIT > 0, kinds_of_line & _LETTER > 0
    pure = digit & ~has_letters
    lines = Lines(source, separator, starts, stops, pure.copy(), pure, blank)
    for line in np.flatnonzero(digit & has_letters).tolist():
        lines.number[line] = any(can_be_number(f) for f in lines.fields(line) if f)
    return lines


def _sample_lines(source: Source) -> list[str]:
    """Return the last 200 of the first 1000 lines."""
    head = source.data[:_HEAD_BYTES].split(b"\n")[:1000]
    if len(head) > 1 and len(source.data) > _HEAD_BYTES:
        head = head[:-1]
    return [line.decode(source.encoding, errors="replace") for line in head[-200:]]


@dataclass(frozen=True)
class Table:
    """Columns of a table, and the position [bytes] of its numbers in the text.

    `first` is the start of the first row of numbers, or the length of the text if there is none.
    `last` is the position after the last row, or None at the end of the text.
    """

    header: Header
    separator: str
    first: int
    last: int | None = None
    rows: int = 0


@dataclass(frozen=True)
class Rows:
    """Rows of a table; each has a line number (from 1) and one field per column.

    Blank rows are skipped. If adjacent specimens have `shared` rows, a row may end early.
    """

    source: Source
    table: Table
    shared: bool = False

    def __iter__(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the rows; raises FileError, with the line, if a row is broken or there are none."""
        if not self.body.strip():
            header = self.table.header
            raise header.error("contains column names but no rows of numbers")
        return self._iterate_rows(self.table.first)

    @cached_property
    def body(self) -> bytes:
        """Return the bytes of all rows."""
        return self.source.data[self.table.first : self.table.last].rstrip(b"\x1a")

    @property
    def has_line_ending(self) -> bool:
        """Return whether the last row has a line ending."""
        return self.body.endswith(b"\n")

    def is_broken_off(self, line: int) -> bool:
        """Return whether a line is the last one in the text and has no line ending."""
        return not self.has_line_ending and line == self.source.line_number(len(self.source.data))

    def line(self, row: int) -> int:
        """Return the line number of a row."""
        return next(islice(self, row, None))[0]

    def last_rows(self) -> list[list[str]]:
        """Return the last rows, about two hundred if they have the usual length."""
        end = len(self.source.data) if self.table.last is None else self.table.last
        start = max(end - _TAIL_BYTES, self.table.first)
        if start > self.table.first:
            start = self.source.data.find(b"\n", start, end) + 1 or end
        return [fields for _, fields in self._iterate_rows(start)]

    def sample_rows(self) -> list[list[str]]:
        """Return some rows from the start and the end."""
        return [fields for _, fields in islice(self, _SAMPLE_ROWS)] + self.last_rows()

    def _iterate_rows(self, start: int) -> Iterator[tuple[int, list[str]]]:
        last = self.table.last
        lines = self.source.lines(start)
        for line, (offset, text) in enumerate(lines, self.source.line_number(start)):
            if last is not None and offset >= last:
                return
            fields = self._split_fields(text, line)
            if any(fields):
                yield line, self._complete_fields(fields, line)

    def _split_fields(self, text: str, line: int) -> list[str]:
        """Return the fields of a line, with typographic signs as ASCII."""
        mark = self.table.separator
        if not text.isascii():
            text = text.translate(_SIGNS)
        if '"' in text and '"' in re.sub(rf'(?<![^{mark} ])"[^"]*"(?![^{mark} ])', "", text):
            cut_note = "the last line is cut off: " if self.is_broken_off(line) else ""
            reason = f"{cut_note}a quote is not closed, or is within a field"
            raise FileError(self.source.path, reason, line)
        return split_line(text.rstrip("\x1a"), mark)

    def _complete_fields(self, fields: list[str], line: int) -> list[str]:
        """Return one field per column; raises FileError if there are too few or too many."""
        path, width = self.source.path, len(self.table.header.names)
        missing_count, cut_off = width - len(fields), self.is_broken_off
        if missing_count == 0 or (missing_count < 0 and not any(fields[width:])):
            return fields[:width]
        if missing_count > 0 and self.shared and not cut_off(line):
            return [*fields, *[""] * missing_count]
        difference = f"{describe_count(len(fields))} instead of {width}"
        if cut_off(line):
            raise FileError(
                path, f"the last line is cut off: {difference}; the file is incomplete", line
            )
        if not any(map(can_be_number, fields)):
            raise make_no_numbers_error(path, fields, line)
        if missing_count < 0 and line == self.source.line_number(self.table.first):
            difference += "; decimal commas need a column separator other than a comma"
        raise FileError(path, f"has {difference}", line)


def make_no_numbers_error(path: str, parts: Sequence[str], line: int) -> FileError:
    """Return the error for a line of text among the numbers."""
    return FileError(
        path,
        f"'{shorten(' '.join(parts))}' is not a row of numbers, and rows of numbers without names "
        "follow it; is the file damaged there?",
        line,
    )


def describe_count(number: int) -> str:
    """Return a count of values as text."""
    return f"{number} value" if number == 1 else f"{number} values"
