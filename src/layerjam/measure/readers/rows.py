"""Rows of a table in a text, split into fields one by one."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice

from layerjam.errors import FileError
from layerjam.measure.readers.columns import Header, shorten
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.encoding import TYPOGRAPHY
from layerjam.measure.readers.lines import can_be_number, split_line

_SAMPLE_ROWS, _TAIL_BYTES = 200, 6000
_SIGNS = str.maketrans(TYPOGRAPHY)


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
        missing, cut_off = width - len(fields), self.is_broken_off
        if missing == 0 or (missing < 0 and not any(fields[width:])):
            return fields[:width]
        if missing > 0 and self.shared and not cut_off(line):
            return [*fields, *[""] * missing]
        due = f"{describe_count(len(fields))} instead of {width}"
        if cut_off(line):
            raise FileError(path, f"the last line is cut off: {due}; the file is incomplete", line)
        if not any(map(can_be_number, fields)):
            raise make_no_numbers_error(path, fields, line)
        if missing < 0 and line == self.source.line_number(self.table.first):
            due += "; decimal commas need a column separator other than a comma"
        raise FileError(path, f"has {due}", line)


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
