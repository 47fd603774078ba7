"""Workbooks (.xlsx, .xlsm, .xlsb, .xls, .ods): each sheet as tab-separated text.

A sheet is therefore read like any other file. Numbers keep every digit; the text of a cell is
unchanged, except for tabs and line breaks.
"""

import io
import re
import zipfile
from collections.abc import Iterator, Sequence
from functools import lru_cache

from layerjam.core.errors import FileError, MissingExtraError
from layerjam.laboratory.measure.readers.content import Source

MAX_UNPACKED = 250_000_000
"""Largest size of an unpacked workbook [bytes]; reading takes several times as much memory."""
MOST_CELLS = 10_000_000
"""Largest number of cells in a sheet, including empty cells, which the reader also stores."""
FEW_CELLS, SPARSE = 200_000, 100
"""A sheet of more than `FEW_CELLS` cells is rejected if less than 1/`SPARSE` are filled."""
_CLEAN = str.maketrans({"\t": " ", "\n": " ", "\r": " ", '"': "''"})
_ATTRIBUTES = rb"""((?:[^>"']++|"[^"]*"|'[^']*')*+)"""
_CELL = re.compile(rb'<(?:\w+:)?(row|c)(?=[\s/>])(?: r="([A-Z]{0,9})(\d{1,20})")?' + _ATTRIBUTES)
_PLACE = re.compile(rb"""\sr\s*=\s*["']([A-Za-z]{0,9})(\d{1,20})["']""")
_BEGIN_SHEET = b"\x81\x01"
"""First record of an .xlsb sheet."""
_REPEATED = re.compile(rb"<table:((?:covered-)?table-cell|table-row|table)\b" + _ATTRIBUTES)
_TIMES = re.compile(rb"""number-(?:rows|columns)-repeated\s*=\s*["'](\d{1,20})["']""")


def read_sheets(path: str, data: bytes, sheet: str | None) -> list[Source]:
    """Return the non-empty sheets, or the given one; raises FileError if there is none."""
    with MissingExtraError.raise_if_missing(f"{path}: reading a workbook", "excel"):
        import python_calamine

    try:
        _check_size(path, data)
        book = python_calamine.CalamineWorkbook.from_filelike(io.BytesIO(data))
        names = list(book.sheet_names)
        if sheet is not None and sheet not in names:
            listing = ", ".join(f"'{n[:40]}'" for n in names[:8])
            raise FileError(path, f"has no sheet '{sheet[:40]}'; its sheets are {listing}")
        names_read = names if sheet is None else [sheet]
        rows = {n: book.get_sheet_by_name(n).to_python(skip_empty_area=False) for n in names_read}
    except FileError:
        raise
    # on some damaged files the reader panics, and a panic is not an Exception
    except BaseException as err:
        if isinstance(err, KeyboardInterrupt | SystemExit | MemoryError):
            raise
        raise FileError(
            path, "is an Excel workbook or zip archive that cannot be read; it may be damaged"
        ) from None
    sources = [_make_source(path, name, cells) for name, cells in rows.items() if cells]
    if not sources:
        raise FileError(path, "is an empty workbook")
    return sources


def _check_size(path: str, data: bytes) -> None:
    """Reject a small file that becomes too large when it is unpacked and its gaps are filled."""
    if not data.startswith(b"PK"):
        return  # .xls: at most 65,536 rows of 256 columns
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        size = sum(part.file_size for part in book.infolist())
        if size > MAX_UNPACKED:
            raise FileError(
                path,
                f"unpacks to {size / 1e6:.0f} MB; at most {MAX_UNPACKED / 1e6:.0f} MB can be "
                "read. Export it as CSV",
            )
        for part in book.infolist():
            for cells, count in _count_cells(part.filename.lower(), book.read(part)):
                _check_cells(path, cells, count)


def _check_cells(path: str, cells: int, count: int) -> None:
    """Reject a sheet that is too large or far larger than its filled part."""
    if cells > MOST_CELLS:
        raise FileError(
            path,
            f"has a sheet of {cells:.3g} cells between its first and last filled cell; at most "
            f"{MOST_CELLS:.0e} can be read. Export the required columns as CSV",
        )
    if cells > max(FEW_CELLS, SPARSE * count):
        raise FileError(
            path,
            f"has a sheet of {cells:.3g} cells, but only {count} are filled; delete the "
            "cells far from its table, or export the required columns as CSV",
        )


def _count_cells(name: str, data: bytes) -> Iterator[tuple[int, int]]:
    """Yield (rows times columns, filled cells) for a part of a workbook.

    Any part may be a sheet, because the names of parts are arbitrary.
    """
    if name == "content.xml":
        yield from _count_open_document(data)
    elif data.startswith(_BEGIN_SHEET) or (name.endswith(".bin") and "sheets/" in name):
        yield _count_binary(data)
    else:
        yield _count_xml(data)


def _count_xml(data: bytes) -> tuple[int, int]:
    """Return both counts for an .xlsx sheet; a cell without a position follows the previous one.

    A self-closing cell is empty, and the reader skips it.
    """
    row = column = rows = columns = count = 0
    for tag in _CELL.finditer(data):
        kind, letters, number, attributes = tag.groups()
        if kind == b"row":
            row, column = row + 1, 0
        else:
            column += 1
        if number:  # the position is usually the first attribute
            row, column = int(number), _column_number(letters) or column
        for letters, number in _PLACE.findall(attributes) if b"r" in attributes else ():
            row, column = int(number), _column_number(letters) or column
        if kind == b"c" and not attributes.endswith(b"/"):
            count += 1
            rows, columns = max(rows, row), max(columns, column)
    return rows * max(columns, 1), count


@lru_cache(maxsize=20_000)
def _column_number(letters: bytes) -> int:
    """Return the number of a column, counted from 1: 28 for AB."""
    return sum(26**i * (c - 64) for i, c in enumerate(reversed(letters.upper())))


def _count_binary(data: bytes) -> tuple[int, int]:
    """Return both counts for an .xlsb sheet: records with a type, a length, and a row or column."""
    offset = rows = columns = count = 0
    while offset < len(data):
        kind, offset = _read_varint(data, offset)
        length, offset = _read_varint(data, offset)
        if kind <= 11 and length >= 4:
            index = int.from_bytes(data[offset : offset + 4], "little") + 1
            count += kind > 1  # 0 starts a row, 1 is an empty cell
            rows, columns = (
                (max(rows, index), columns) if kind == 0 else (rows, max(columns, index))
            )
        offset += length
    return rows * max(columns, 1), count


def _read_varint(data: bytes, offset: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[offset]
        value, offset, shift = value | (byte & 127) << shift, offset + 1, shift + 7
        if byte < 128:
            return value, offset


def _count_open_document(data: bytes) -> Iterator[tuple[int, int]]:
    """Yield both counts for each sheet of an .ods, up to the last cell that is not empty.

    A self-closing cell may still have a value in an attribute.
    """
    row = last_row = column = widest = cells = 0
    for tag in _REPEATED.finditer(data):
        kind, attributes = tag.groups()
        repeat = _TIMES.search(attributes)
        count = int(repeat[1]) if repeat else 1
        if kind == b"table":
            yield last_row * widest, cells
            row = last_row = widest = cells = 0
        elif kind == b"table-row":
            row, column = row + count, 0
        else:
            column += count
            if not attributes.endswith(b"/") or b"value" in attributes or b"formula" in attributes:
                last_row, widest, cells = row, max(widest, column), cells + 1
    yield last_row * widest, cells


def _make_source(path: str, name: str, rows: Sequence[Sequence[object]]) -> Source:
    lines = [
        "\t".join([repr(c) if type(c) is float else str(c).translate(_CLEAN).strip() for c in row])
        for row in rows
    ]
    numbers = any(isinstance(c, float | int) for row in rows for c in row)
    return Source(path, ("\n".join(lines) + "\n").encode(), "utf-8", name, "." if numbers else None)
