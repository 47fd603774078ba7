"""Text of a file: conversion from bytes in any encoding, and access line by line."""

import codecs
import re
from collections.abc import Iterator
from dataclasses import dataclass

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.readers.unit_words import unit_role
from layerjam.laboratory.measure.readers.words import count_known_letters

LONGEST_LINE = 20_000
IN_CELL = "\x0b"
"""Replacement for a line break within a quoted cell of the header."""
_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_TWO_BYTES = ("cp932", "gb18030", "big5", "cp949", "euc-jp")
# In all of these, digits, separators, quotes and line endings are the same bytes as in ASCII.
_PAGES = ("cp1252", "cp1250", "cp1251", *_TWO_BYTES, "koi8-r", "cp1253", "cp1254")
_HEAD = 16_384
TYPOGRAPHY = {"\u2212": "-", "\u00a0": " ", "\u202f": " ", "\u2009": " ", "\u2019": "'"}
"""{typographic minus sign, non-breaking space or apostrophe: its ASCII equivalent}."""
_ALLOWED = b"\t\n\r\f\x1a"


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


def decode_file(name: str, data: bytes) -> tuple[bytes, str]:
    """Return the bytes in an encoding with digits and separators as single ASCII bytes.

    Typographic minus signs, non-breaking spaces and apostrophes become ASCII. Raises FileError for
    incomplete UTF-16 and for binary data.
    """
    wide = next((code for mark, code in _MARKS if data.startswith(mark)), None) or _guess_utf16(
        data
    )
    if wide is not None:
        try:
            data = data.decode(wide).encode()
        except (UnicodeDecodeError, UnicodeEncodeError):
            kind = wide.upper()[:6]
            raise FileError(
                name, f"is incomplete: its {kind} text ends early or is damaged"
            ) from None
    data = data.removeprefix(codecs.BOM_UTF8)
    control_character = next((c for c in data[:4096] if c < 32 and c not in _ALLOWED), None)
    if control_character is not None or b"\0" in data:
        raise FileError(name, "is binary, not a text file of numbers")
    encoding = _guess_encoding(data)
    if not data.isascii():
        for mark, ascii_mark in TYPOGRAPHY.items():
            data = _replace_sign(data, mark, ascii_mark, encoding)
    return data, encoding


def _replace_sign(data: bytes, mark: str, plain: str, encoding: str) -> bytes:
    """Replace a typographic sign with ASCII if that is safe in a two-byte encoding."""
    try:
        code = mark.encode(encoding)
    except UnicodeEncodeError:
        return data
    if code not in data or (encoding in _TWO_BYTES and len(code) < 2):
        return data
    return data.replace(code, plain.encode())


def _guess_utf16(data: bytes) -> str | None:
    """Return the kind of UTF-16 without a mark, in which every second byte at the start is zero."""
    head = data[:4096]
    if len(head) < 20 or b"\0" not in head:
        return None
    even, odd = head[0::2], head[1::2]
    if odd.count(0) > 0.5 * len(odd) and even.count(0) < 0.05 * len(even):
        return "utf-16-le"
    if even.count(0) > 0.5 * len(even) and odd.count(0) < 0.05 * len(odd):
        return "utf-16-be"
    return None


def _guess_encoding(data: bytes) -> str:
    if data.isascii():
        return "utf-8"
    try:
        data.decode("utf-8")
        return "utf-8"
    except UnicodeDecodeError:
        pass
    lines = [line for line in data[:_HEAD].splitlines() if not line.isascii()][:100]
    text = b"\n".join(lines)
    best_encoding, highest_score = "cp1252", 0
    for page in _PAGES:
        try:
            score = _score_text(text.decode(page))
        except UnicodeDecodeError:
            continue
        if score > highest_score:
            best_encoding, highest_score = page, score
    return best_encoding


def _score_text(text: str) -> int:
    """Return the number of letters in known words and units if decoded with one code page."""
    units = [u for u in re.split(r"[\t;,|\"'()\[\]/\n]+", text) if u and not u.isascii()]
    unit_letters = sum(8 for u in set(units) if len(u) <= 12 and unit_role(u.strip()))
    return count_known_letters(text[:4000]) + unit_letters
