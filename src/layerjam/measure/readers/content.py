"""Text of a file, line by line."""

from collections.abc import Iterator
from dataclasses import dataclass

from layerjam.errors import FileError

LONGEST_LINE = 20_000
IN_CELL = "\x0b"
"""Replacement for a line break within a quoted cell of the header."""


@dataclass(frozen=True)
class Source:
    """A text file, or one sheet of a workbook as text.

    `data` is in UTF-8 or a code page that extends ASCII, with Unix newlines and no byte-order mark.
    `decimal` is the decimal sign if the kind of file determines it; `notes` describes changes to
    the layout.
    """

    path: str
    data: bytes
    encoding: str
    sheet: str = ""
    decimal: str | None = None
    notes: tuple[str, ...] = ()

    def lines(self, offset: int = 0) -> Iterator[tuple[int, str]]:
        """Yield (byte offset, text) of each line, starting at a byte offset."""
        data = self.data
        while offset < len(data):
            end = data.find(b"\n", offset)
            end = len(data) if end < 0 else end
            if end - offset > LONGEST_LINE:
                raise self.make_length_error(end - offset, data.count(b"\n", 0, offset) + 1)
            yield offset, self.text(offset, end)
            offset = end + 1

    def make_length_error(self, size: int, line: int) -> FileError:
        """Return the error for a line that is too long for a table."""
        return FileError(
            self.path, (f"has a line of {size} bytes, so it is not a table of numbers"), line
        )

    def text(self, start: int, end: int) -> str:
        """Return the text between two byte offsets."""
        return self.data[start:end].decode(self.encoding, errors="replace")

    def line_number(self, offset: int) -> int:
        """Return the line (from 1) that contains a byte offset."""
        data = self.data
        return data.count(b"\n", 0, offset) + data.count(IN_CELL.encode(), 0, offset) + 1
