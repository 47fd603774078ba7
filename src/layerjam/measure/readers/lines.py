"""The lines of a text: what separates their fields, and which are numbers, words or blank.

A few passes over the bytes as an array tell the lines of numbers, so that 40,000 rows cost
milliseconds; only lines with letters are looked at one by one.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from layerjam.errors import FileError
from layerjam.measure.readers.content import Source

_LONGEST_LINE = 20_000
_PIECE = 16_000_000
_FEW = 3000
_HEAD_BYTES = 300_000
_LOOSE_NUMBER = re.compile(r"[+\-\u2212]?[\d.,'\u2019\s]*\d[\d.,'\u2019\s]*(?:[eE][+-]?\d+)?")
_BARE_NUMBERS = re.compile(r"[\d\s.,;|+\-eE'\u2019\u2212]*\d[\d\s.,;|+\-eE'\u2019\u2212]*")
_WORD = re.compile(r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?")

Flags = npt.NDArray[np.bool_]
Places = npt.NDArray[np.int64]


def split(line: str, separator: str) -> list[str]:
    """The fields of one line, quotes taken off; the separator " " stands for any blanks."""
    if separator == " ":
        return line.replace('"', " ").split()
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
    """Tab, semicolon or bar where most lines have them outside quotes, else blanks or comma.

    Lines of nothing but numbers decide, where there are some: words may hold any sign.
    """
    kept = [re.sub(r'"[^"]*"', "0", line) for line in lines if line.strip()]
    numbers = [line for line in kept if len(line) <= 2000 and _BARE_NUMBERS.fullmatch(line)]
    judged = numbers if len(numbers) >= 3 else kept
    # A comma may be a decimal comma, so the others come first.
    for mark in ("\t", ";", "|"):
        if sum(mark in line.strip(" ") for line in judged) * 2 > len(judged):
            return mark
    blanks = sum(_only_words(line) for line in judged)
    return " " if judged and blanks * 2 > len(judged) else ","


def _only_words(line: str) -> bool:
    """Whether a line is two numbers or more between blanks, each by itself in order."""
    fields = line.split()
    return len(fields) >= 2 and all(_WORD.fullmatch(f) for f in fields)


@dataclass(frozen=True)
class Lines:
    """Every line of a source: where it begins and ends, and what it holds.

    `starts`, `stops` [bytes] without the line end; `number`: it holds a field that is a number;
    `pure`: no field of it is anything else; `blank`: nothing but separators.
    """

    source: Source
    separator: str
    starts: Places
    stops: Places
    number: Flags
    pure: Flags
    blank: Flags

    def text(self, line: int) -> str:
        """The text of a line (from 0)."""
        return self.source.text(int(self.starts[line]), int(self.stops[line]))

    def fields(self, line: int) -> list[str]:
        """The fields of a line (from 0)."""
        return split(self.text(line), self.separator)


def read_lines(source: Source) -> Lines:
    """Every line of a source; FileError where one is too long for a table."""
    separator = separator_of(_sample(source))
    parts = [_scanned(source, separator, *piece) for piece in pieces(source.data, 0)]
    starts, stops, odd, digit, ink = (np.concatenate(column) for column in zip(*parts, strict=True))
    number = digit & ~odd
    pure = number.copy()
    blank = ~ink
    lines = Lines(source, separator, starts, stops, number, pure, blank)
    mixed = np.flatnonzero(odd & digit)
    if len(mixed) <= _FEW:
        for line in mixed.tolist():
            number[line] = any(looks_numeric(f) for f in lines.fields(line) if f)
    else:
        number[mixed] = _with_a_number(lines, mixed)
    return lines


def _sample(source: Source) -> list[str]:
    """The last 200 of the first thousand lines."""
    head = source.data[:_HEAD_BYTES].split(b"\n")[:1000]
    if len(head) > 1 and len(source.data) > _HEAD_BYTES:
        head = head[:-1]
    return [line.decode(source.encoding, errors="replace") for line in head[-200:]]


def pieces(data: bytes, first: int, last: int | None = None) -> list[tuple[int, int]]:
    """Whole lines from a byte offset on, in pieces of some megabytes."""
    end = len(data) if last is None else last
    out = []
    while first < end:
        stop = end
        if end - first > _PIECE:
            stop = data.find(b"\n", first + _PIECE, end) + 1 or end
        out.append((first, stop))
        first = stop
    return out


_ODD = np.ones(256, np.bool_)
_ODD[list(b"0123456789+-.,;|'\"eE \t\n\f\x1a\x0b")] = False
_DIGIT = np.zeros(256, np.bool_)
_DIGIT[list(b"0123456789")] = True


def _scanned(
    source: Source, separator: str, first: int, stop: int
) -> tuple[Places, Places, Flags, Flags, Flags]:
    """For each line of a piece: start, stop, and whether it has other signs, digits, anything."""
    raw = np.frombuffer(source.data, np.uint8, stop - first, first)
    ends = np.flatnonzero(raw == 10)
    if raw[-1] != 10:
        ends = np.append(ends, len(raw))
    starts = np.concatenate(([0], ends[:-1] + 1))
    length = ends - starts
    if length.max(initial=0) > _LONGEST_LINE:
        line = int((length > _LONGEST_LINE).argmax())
        number = source.data.count(b"\n", 0, first + int(starts[line])) + 1
        raise FileError(
            source.path, f"has a line of {length[line]} bytes, no table of numbers", number
        )
    safe = np.minimum(starts, len(raw) - 1)
    digit = np.logical_or.reduceat(_DIGIT[raw], safe)
    odd = np.zeros(len(ends), np.bool_)
    odd[np.searchsorted(ends, np.flatnonzero(_ODD[raw]))] = True
    ink = digit | odd
    for line in np.flatnonzero(~ink & (length > 0))[:_FEW].tolist():
        piece = source.data[first + starts[line] : first + ends[line]]
        ink[line] = bool(piece.strip(b' \t\f\x1a\x0b",;|' if separator != " " else b' \t\f\x1a"'))
    return starts + first, ends + first, odd, digit, ink


def _with_a_number(lines: Lines, mixed: Places) -> Flags:
    """Which of many lines of words and numbers hold a field that is a number."""
    found = np.zeros(len(lines.starts), np.bool_)
    mark = ord(lines.separator)
    for first, stop in pieces(lines.source.data, 0):
        raw = np.frombuffer(lines.source.data, np.uint8, stop - first, first)
        cuts = np.concatenate(([0], np.flatnonzero((raw == mark) | (raw == 10)) + 1))
        cuts = cuts[cuts < len(raw)]
        good = np.logical_or.reduceat(_DIGIT[raw], cuts)
        good &= ~np.logical_or.reduceat(_ODD[raw], cuts)
        found[np.searchsorted(lines.stops, cuts[good] + first)] = True
    return found[mixed]
