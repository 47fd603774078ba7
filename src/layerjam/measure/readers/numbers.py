"""Text to floats: which sign is the decimal one, and every number exactly as written."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from math import isfinite

import numpy as np

from layerjam.errors import FileError
from layerjam.measure.readers.columns import cut
from layerjam.measure.readers.grid import Grid, no_row_of_numbers
from layerjam.measure.readers.lines import looks_numeric
from layerjam.measure.trace import Array

_PLAIN = ((".", ""), (",", ""))
_GROUPED = ((".", ","), (",", "."), (".", " "), (",", " "), (".", "'"), (",", "'"))


def _pattern(decimal: str, thousands: str) -> str:
    whole = r"\d+"
    if thousands:
        whole = rf"(?:[1-9]\d{{0,2}}(?:{re.escape(thousands)}\d{{3}})+|\d+)"
    d = re.escape(decimal)
    return rf" *[+-]?(?:{whole}(?:{d}\d*)?|{d}\d+)(?:[eE][+-]?\d+)? *"


_CELL = {c: re.compile(_pattern(*c)) for c in (*_PLAIN, *_GROUPED)}
_CELLS = {c: re.compile(rf"(?:{_pattern(*c)}\n)*+") for c in (*_PLAIN, *_GROUPED)}


def read_columns(
    grid: Grid, indices: Sequence[int], names: Sequence[str], decimal: str | None, asked: bool
) -> list[Array]:
    """The columns as float64, each number bit for bit what float() makes of its text.

    `decimal` is "." or "," where that is known, None to find it out; `asked` says that "." is a
    matter of course (numbers without quotes between commas). Raises FileError, with the line, for
    a cell that is no finite number, and where decimal and thousands signs cannot be told apart.
    """
    styles = _styles(grid, indices, decimal, asked)
    for style in styles:
        columns = _parse(grid, indices, style)
        if columns is not None:
            _check_last(grid, style[0])
            return columns
    style = styles[0] if styles else (decimal or ".", "")
    error = _bad_cell(grid, indices, names, style)
    columns = None if error else _slow(grid, indices, style)
    if columns is None:  # a number float() reads and pandas does not is still a number
        raise error or FileError(grid.path, "holds numbers that cannot be read")
    _check_last(grid, style[0])
    return columns


def _cells(rows: list[list[str]], indices: Sequence[int]) -> str:
    return "".join([f"{row[i]}\n" for row in rows for i in indices])


def _styles(
    grid: Grid, indices: Sequence[int], decimal: str | None, asked: bool
) -> list[tuple[str, str]]:
    """(decimal sign, thousands sign) pairs to try, the likeliest first."""
    sample = _cells(grid.sample(), indices)
    known = [s for s in (*_PLAIN, *_GROUPED) if decimal in (None, s[0])]
    if asked:
        known = [s for s in known if s[0] == "." and s[1] != ","]
    fits = [s for s in known if _CELLS[s].fullmatch(sample)]
    if decimal is None and not asked and {(".", ","), (",", ".")} <= set(fits):
        # Nothing in the sample tells 1.234 from 1,234; then every cell is asked.
        every = _cells(grid.rows(), indices)
        signs = {"," if "," in every else "", "." if "." in every else ""} - {""}
        fits = [s for s in fits if _CELLS[s].fullmatch(every)] or fits
        if signs and {(".", ","), (",", ".")} <= set(fits):
            raise FileError(
                grid.path,
                f"does not show whether '{signs.pop()}' is the decimal sign or groups thousands; "
                "say which sign is the decimal one (--decimal)",
            )
    return fits or [s for s in known if s in _PLAIN][:1]


def _parse(grid: Grid, indices: Sequence[int], style: tuple[str, str]) -> list[Array] | None:
    import pandas

    decimal, thousands = style
    if thousands and thousands.encode() not in grid.text:
        return None  # the same as without one, which was tried before
    if thousands and not _grouped(grid, indices, style):
        return None
    words = bool(grid.text.translate(None, b"0123456789+-.,eE \t\n'"))
    lower = grid.text.lower() if words else b""
    if b"true" in lower or b"false" in lower:
        return _slow(grid, indices, style)  # pandas would read True as 1
    try:
        frame = pandas.read_csv(
            io.BytesIO(grid.text),
            sep="\t",
            header=None,
            usecols=sorted(set(indices)),
            dtype=np.float64,
            decimal=decimal,
            thousands=thousands or None,
            quoting=3,
            keep_default_na=False,
            na_filter=False,
            skip_blank_lines=False,
            engine="c",
            low_memory=False,
        )
    except (ValueError, OverflowError):  # ParserError too: a cell is no number
        return None
    columns = [frame[i].to_numpy() for i in indices]
    if any(len(c) != len(grid.lines) or not np.isfinite(c).all() for c in columns):
        return None
    return columns


def _grouped(grid: Grid, indices: Sequence[int], style: tuple[str, str]) -> bool:
    """Whether every thousands sign stands where one may; pandas drops them anywhere."""
    if _well_grouped(grid.text, *style):
        return True
    return _CELLS[style].fullmatch(_cells(grid.rows(), indices)) is not None


def _well_grouped(text: bytes, decimal: str, thousands: str) -> bool:
    """Whether each thousands sign of the whole text stands between digits as one must."""
    edge = b"\n" * 5
    raw = np.frombuffer(edge + text + edge, np.uint8)
    at = np.flatnonzero(raw == ord(thousands))
    digit = (raw >= 48) & (raw <= 57)
    fine = digit[at + 1] & digit[at + 2] & digit[at + 3] & ~digit[at + 4] & digit[at - 1]
    two = digit[at - 2]
    three = two & digit[at - 3]
    fine &= ~(three & digit[at - 4])
    length = 1 + two.astype(np.int64) + three
    leading, before = raw[at - length], raw[at - length - 1]
    follows = before == ord(thousands)  # then its group has three digits, else no leading zero
    fine &= np.where(follows, length == 3, leading != 48)
    return bool((fine & ~np.isin(before, [ord(decimal), 69, 101])).all())


def _slow(grid: Grid, indices: Sequence[int], style: tuple[str, str]) -> list[Array] | None:
    rows = grid.rows()
    if not all(_CELL[style].fullmatch(row[i]) for row in rows for i in indices):
        return None
    columns = [
        np.array([float(r[i].replace(style[1] or " ", "").replace(style[0], ".")) for r in rows])
        for i in indices
    ]
    return columns if all(np.isfinite(c).all() for c in columns) else None


def _bad_cell(
    grid: Grid, indices: Sequence[int], names: Sequence[str], style: tuple[str, str]
) -> FileError | None:
    """The first cell that is no finite number, as an error with its line."""
    decimal, thousands = style
    for row, fields in enumerate(grid.rows()):
        for index, name in zip(indices, names, strict=True):
            cell = fields[index].strip()
            number = cell.replace(thousands, "") if thousands else cell
            if _CELL[style].fullmatch(cell) and isfinite(float(number.replace(decimal, "."))):
                continue
            # A row without any number is no damaged number: a footer, or the next table.
            if not any(looks_numeric(field.strip()) for field in fields):
                return no_row_of_numbers(grid.path, fields, grid.line(row))
            what = f"'{cut(cell)}' in column '{name[:40]}' is no finite number"
            if not cell:
                what = f"column '{name[:40]}' is empty"
            if row == len(grid.lines) - 1 and not grid.ended:
                what += "; the file is cut off there"
            return FileError(grid.path, what, grid.line(row))
    return None


def _check_last(grid: Grid, decimal: str) -> None:
    """Refuse a last line without line end whose last number seems to be cut.

    Many programs leave out the last line end, so that alone is no damage. A file cut off within
    its last number shows by fewer decimals than all rows above have; where their count varies, by
    fewer digits than any number above, or by fewer digits and a jump.
    """
    if grid.ended:
        return
    cells = [row[grid.columns - 1].strip() for row in grid.tail()]
    if len(cells) < 3:
        return
    last = cells[-1]
    digits = [len(re.sub(r"[eE].*|\D", "", c).lstrip("0")) for c in cells]
    decimals = [len(c.partition(decimal)[2]) for c in cells]
    if last[-1:] in ("", "+", "-", ".", ",", "e", "E"):
        cut = True
    elif len(set(decimals[:-1])) == 1 and not any("e" in c.lower() for c in cells):
        cut = decimals[-1] < decimals[0]
    elif not last.strip("+-0.,"):
        cut = False  # a plain zero
    else:
        cut = digits[-1] < min(digits[:-1]) or (
            digits[-1] < digits[-2] and _jumps([c.replace(decimal, ".") for c in cells[-20:]])
        )
    if cut:
        raise FileError(
            grid.path,
            f"the last line is cut off within its last number '{last[:40]}'; the file is not whole",
            grid.line(len(grid.lines) - 1),
        )


def _jumps(cells: list[str]) -> bool:
    """Whether the last number lies further from the one before than three of the largest steps."""
    try:
        step = np.abs(np.diff([float(c) for c in cells]))
    except ValueError:  # a column nobody reads may hold words
        return False
    return bool(step[-1] > 3 * step[:-1].max(initial=0.0))
