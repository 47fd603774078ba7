"""Lines of a text: their separator, and whether they contain numbers, words or nothing.

The characters in a line determine its kind, so that reading 40,000 lines of numbers takes
milliseconds. Only lines with letters and digits are examined field by field.
"""

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from layerjam.measure.readers.content import LONGEST_LINE, Source

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
    holds = np.bitwise_or.reduceat(kinds, starts)
    blank = (holds if separator == " " else holds & ~_SEPARATOR) == 0
    digit, has_letters = holds & _DIGIT > 0, holds & _LETTER > 0
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
