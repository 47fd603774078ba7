"""Exact conversion of text to floats, with any decimal sign."""

import io
import re
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.readers.column_names import shorten
from layerjam.laboratory.measure.readers.header import Column
from layerjam.laboratory.measure.readers.lines import Rows, can_be_number, make_no_numbers_error
from layerjam.laboratory.measure.readers.stamps import STAMPS, find_stamp_unit, read_stamp
from layerjam.laboratory.measure.trace import Array

Style = tuple[str, str]
"""Decimal sign, and the thousands separator, if any."""
_PLAIN: tuple[Style, ...] = ((".", ""), (",", ""))
_GROUPED = ((".", ","), (",", "."), (".", " "), (",", " "), (".", "'"), (",", "'"))
_STYLES = (*_PLAIN, *_GROUPED)


def _make_pattern(decimal: str, thousands: str) -> str:
    integer = r"\d+"
    if thousands:
        integer = rf"(?:[1-9]\d{{0,2}}(?:{re.escape(thousands)}\d{{3}})+|\d+)"
    d = re.escape(decimal)
    return rf"[+-]?(?:{integer}(?:{d}\d*)?|{d}\d+)(?:[eE][+-]?\d+)?"


_CELL = {style: re.compile(_make_pattern(*style), re.ASCII) for style in _STYLES}
_CELLS = {style: re.compile(rf"(?:{_make_pattern(*style)}\n)*", re.ASCII) for style in _STYLES}
"""{style: pattern of many cells, one per line}."""


def read_columns(rows: Rows, columns: Sequence[Column], decimal: str | None) -> list[Array]:
    """Return the columns in SI units, each number bit-identical to float() of its text.

    `decimal` is the decimal sign, or None to detect it. Raises FileError, with the line, for a cell
    that is not a finite number, or if decimal sign and thousands separator are not distinguishable.
    """
    first = next(iter(rows))[1]
    columns = [_with_stamp_unit(column, first[column.index]) for column in columns]
    indices = [column.index for column in columns]
    arrays, style = _read_in_first_style(rows, columns, _list_styles(rows, indices, decimal))
    _check_last_number(rows, style[0])
    return [column.si(values) for column, values in zip(columns, arrays, strict=True)]


def _read_in_first_style(
    rows: Rows, columns: Sequence[Column], styles: Sequence[Style]
) -> tuple[list[Array], Style]:
    """Return the columns as written, and the first style in which all cells are numbers."""
    for style in styles:
        if style in _PLAIN and (values := _read_with_pandas(rows, columns, style[0])) is not None:
            return values, style
    errors = []
    for style in styles:
        try:
            return _read_cells(rows, columns, style), style
        except FileError as error:
            errors.append(error)
    # report the error of the style that reads the most rows: that is where the file is damaged
    raise max(errors, key=lambda error: error.line or 0)


def are_equal_columns(
    rows: Rows, columns: Sequence[Column], decimal: str | None, from_start: bool = True
) -> bool:
    """Return whether columns agree to 1 in 10,000.

    `from_start` subtracts their first values, because the origin of a travel does not matter.
    """
    try:
        values = read_columns(rows, columns, decimal)
        first, *others = (v - v[0] for v in values) if from_start else values
    except FileError:
        return False  # an unreadable column is not a measurement
    return all(float(np.abs(v - first).max()) <= 1e-4 * float(np.ptp(first)) for v in others)


def _list_styles(rows: Rows, indices: Sequence[int], decimal: str | None) -> list[Style]:
    def select_matching(styles: Iterable[Style], cells: Iterable[str]) -> list[Style]:
        column = "".join(f"{cell}\n" for cell in cells if cell)
        # where no cell has the separator, a style with it reads what the plain one reads
        read_as = {s: s if s[1] in column else (s[0], "") for s in styles}
        fits = {s for s in set(read_as.values()) if _CELLS[s].fullmatch(column)}
        return [s for s, same in read_as.items() if same in fits]

    candidates = [s for s in _STYLES if decimal in (None, s[0])]
    # unquoted numbers between commas can use only a point as the decimal sign
    asked = rows.table.separator == "," and b'"' not in rows.body
    if asked:
        candidates = [s for s in candidates if s[0] == "." and s[1] != ","]
    cells = (fields[i] for fields in rows.sample_rows() for i in indices)
    fits = select_matching(candidates, (cell for cell in cells if read_stamp(cell) is None))
    if decimal is None and not asked and {(".", ","), (",", ".")} <= set(fits):
        # If the sample does not distinguish 1.234 from 1,234, check every cell.
        every = [fields[i] for _, fields in rows for i in indices]
        fits = select_matching(fits, every) or fits
        signs = {sign for sign in ",." if any(sign in cell for cell in every)}
        if signs and {(".", ","), (",", ".")} <= set(fits):
            raise FileError(
                rows.source.path,
                f"does not show whether '{min(signs)}' is the decimal sign or the "
                "thousands separator; state the decimal sign",
                how=" (--decimal . or --decimal ,)",
                asks="decimal",
            )
    return fits or [s for s in candidates if s in _PLAIN] or [(decimal or ".", "")]


def _read_with_pandas(rows: Rows, columns: Sequence[Column], decimal: str) -> list[Array] | None:
    """Return the columns as read by pandas; None if a row or a cell is unusual."""
    import pandas

    body, mark = rows.body.rstrip(b"\n"), rows.table.separator.encode()
    indices = [column.index for column in columns]
    width = len(rows.table.header.names)
    words = body.translate(None, b"0123456789+-.,; \t\n\"'|").lower()
    if mark == b" " or rows.shared or b"true" in words or b"false" in words:
        return None  # pandas would read True as 1
    lines, raw = body.count(b"\n") + 1, np.frombuffer(body + b"\n", np.uint8)
    cuts = raw[(raw == ord(mark)) | (raw == ord("\n"))]
    is_rectangular = len(cuts) == lines * width and (cuts[width - 1 :: width] == ord("\n")).all()
    if not is_rectangular or not body.isascii():
        return None
    try:
        frame = pandas.read_csv(
            io.BytesIO(body),
            sep=mark.decode(),
            header=None,
            usecols=sorted(set(indices)),
            dtype=np.float64,
            decimal=decimal,
            keep_default_na=False,
            na_filter=False,
            skip_blank_lines=False,
            engine="c",
            low_memory=False,
        )
    except (ValueError, OverflowError):  # also ParserError: a cell is not a number
        return None
    columns_read = [frame[i].to_numpy() for i in indices]
    is_complete = all(len(c) == lines and np.isfinite(c).all() for c in columns_read)
    return columns_read if is_complete else None


def _read_cells(rows: Rows, columns: Sequence[Column], style: Style) -> list[Array]:
    """Return the number in every cell; raises FileError for the first that is not a number.

    A short specimen next to a longer one ends early: its last cells are empty.
    """
    decimal, thousands = style
    arrays = [array("d") for _ in columns]
    gap: tuple[int, list[str]] | None = None
    for line, fields in rows:
        if rows.shared and not any(fields[c.index] for c in columns):
            gap = gap or (line, fields)
            continue
        if gap is not None:
            raise _make_cell_error(rows, *gap, columns[0])
        for column, numbers in zip(columns, arrays, strict=True):
            cell = fields[column.index]
            text = cell.replace(thousands, "") if thousands else cell
            fits = _CELL[style].fullmatch(cell)
            number = float(text.replace(decimal, ".")) if fits else None
            if column.unit in STAMPS:
                unit, number = read_stamp(cell) or ("", None)
                number = number if unit == column.unit else None
            if number is None or not isfinite(number):
                raise _make_cell_error(rows, line, fields, column)
            numbers.append(number)
    return [np.array(numbers) for numbers in arrays]


def _with_stamp_unit(column: Column, cell: str) -> Column:
    """Return a column of time with the unit of its time stamps, whatever the user states."""
    unit = find_stamp_unit(cell) if column.role == "time" else None
    return replace(column, unit=unit) if unit else column


def _make_cell_error(rows: Rows, line: int, fields: list[str], column: Column) -> FileError:
    path, cell = rows.source.path, fields[column.index]
    # a row without a number is not damaged: it is a footer or begins the next table
    if not any(map(can_be_number, fields)):
        return make_no_numbers_error(path, fields, line)
    fault = f"'{shorten(cell)}' in column '{column.name[:40]}' is not a finite number"
    if not cell:
        fault = f"column '{column.name[:40]}' is empty"
    ending = "; the file is cut off there" if rows.is_broken_off(line) else ""
    return FileError(path, fault + ending, line)


def _check_last_number(rows: Rows, decimal: str) -> None:
    """Reject a last line without a line ending if its last number seems to be truncated.

    Many programs omit the last line ending, so this alone is not damage. A truncated number has
    fewer decimals than those in all rows above. If the number of decimals varies, it has fewer
    digits than any number above, or fewer digits and a jump.
    """
    if rows.has_line_ending:
        return
    cells = [fields[-1] for fields in rows.last_rows()]
    if len(cells) < 3:
        return
    last = cells[-1]
    digits = [len(re.sub(r"[eE].*|\D", "", c).lstrip("0")) for c in cells]
    decimals = [len(c.partition(decimal)[2]) for c in cells]
    if last[-1:] in ("", "+", "-", ".", ",", "e", "E"):
        is_cut = True
    elif len(set(decimals[:-1])) == 1 and not any("e" in c.lower() for c in cells):
        is_cut = decimals[-1] < decimals[0]
    elif not last.strip("+-0.,"):
        is_cut = False  # a plain zero is not truncated
    else:
        is_cut = digits[-1] < min(digits[:-1]) or (
            digits[-1] < digits[-2] and _has_jump([c.replace(decimal, ".") for c in cells[-20:]])
        )
    if is_cut:
        raise FileError(
            rows.source.path,
            (f"the last line is cut off in its last number '{last[:40]}'; the file is incomplete"),
            rows.source.line_number(len(rows.source.data)),
        )


def _has_jump(cells: list[str]) -> bool:
    """Return whether the last step is larger than three times the largest earlier step."""
    try:
        step = np.abs(np.diff([float(c) for c in cells]))
    except ValueError:  # an unused column may contain words
        return False
    return bool(step[-1] > 3 * step[:-1].max(initial=0.0))
