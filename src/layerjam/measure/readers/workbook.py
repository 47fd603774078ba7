"""Workbooks (.xlsx, .xlsm, .xlsb, .xls, .ods): each sheet as tab-separated text.

So a sheet goes the way of every other file. Numbers keep every digit; a cell's text is kept as it
is, without tabs and line ends.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Sequence
from functools import lru_cache

from layerjam.errors import FileError, MissingExtraError
from layerjam.measure.readers.content import Source

MAX_UNPACKED = 250_000_000
"""Bytes a zipped workbook may unpack to, which cost several times their number in memory."""
MOST_CELLS = 10_000_000
"""Cells of a sheet from its first to its last row and column: the reader stores the empty ones."""
FEW_CELLS, SPARSE = 200_000, 100
"""A sheet of more than these cells is not read where less than one in so many is filled."""
_CLEAN = str.maketrans({"\t": " ", "\n": " ", "\r": " ", '"': "''"})
_ATTRIBUTES = rb"""((?:[^>"']++|"[^"]*"|'[^']*')*+)"""
_CELL = re.compile(rb'<(?:\w+:)?(row|c)(?=[\s/>])(?: r="([A-Z]{0,9})(\d{1,20})")?' + _ATTRIBUTES)
_PLACE = re.compile(rb"""\sr\s*=\s*["']([A-Za-z]{0,9})(\d{1,20})["']""")
_BEGIN_SHEET = b"\x81\x01"
"""The record that an .xlsb sheet begins with."""
_REPEATED = re.compile(rb"<table:((?:covered-)?table-cell|table-row|table)\b" + _ATTRIBUTES)
_TIMES = re.compile(rb"""number-(?:rows|columns)-repeated\s*=\s*["'](\d{1,20})["']""")


def sheets(path: str, data: bytes, sheet: str | None) -> list[Source]:
    """The sheets that hold anything, or the one asked for; FileError where there is none."""
    with MissingExtraError.raise_if_missing(f"{path}: reading a workbook", "excel"):
        import python_calamine

    try:
        _check_size(path, data)
        book = python_calamine.CalamineWorkbook.from_filelike(io.BytesIO(data))
        names = list(book.sheet_names)
        if sheet is not None and sheet not in names:
            there = ", ".join(f"'{n[:40]}'" for n in names[:8])
            raise FileError(path, f"has no sheet '{sheet[:40]}'; its sheets are {there}")
        wanted = names if sheet is None else [sheet]
        rows = {n: book.get_sheet_by_name(n).to_python(skip_empty_area=False) for n in wanted}
    except FileError:
        raise
    except BaseException as err:  # the reader panics on some damage, which is no Exception
        if isinstance(err, KeyboardInterrupt | SystemExit | MemoryError):
            raise
        raise FileError(
            path, "is an Excel workbook or zip archive that cannot be read; it may be damaged"
        ) from None
    found = [_source(path, name, cells) for name, cells in rows.items() if cells]
    if not found:
        raise FileError(path, "is a workbook without any filled cell")
    return found


def _check_size(path: str, data: bytes) -> None:
    """Refuse a small file that no memory holds once it is unpacked and its gaps are filled."""
    if not data.startswith(b"PK"):
        return  # .xls: 65,536 rows of 256 columns at most
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        size = sum(part.file_size for part in book.infolist())
        if size > MAX_UNPACKED:
            raise FileError(
                path,
                f"unpacks to {size / 1e6:.0f} MB, more than {MAX_UNPACKED / 1e6:.0f} MB is not "
                "read; export it as CSV",
            )
        for part in book.infolist():
            for cells, filled in _cells_of(part.filename.lower(), book.read(part)):
                _check_cells(path, cells, filled)


def _check_cells(path: str, cells: int, filled: int) -> None:
    """Refuse a sheet that is too large, or far larger than what is filled of it."""
    if cells > MOST_CELLS:
        raise FileError(
            path,
            f"has a sheet of {cells:.3g} cells from its first to its last, more than "
            f"{MOST_CELLS:.0e} are not read; export the columns needed as CSV",
        )
    if cells > max(FEW_CELLS, SPARSE * filled):
        raise FileError(
            path,
            f"has a sheet of {cells:.3g} cells from its first to its last, of which {filled} are "
            "filled; delete what stands far from its table, or export the columns needed as CSV",
        )


def _cells_of(name: str, data: bytes) -> Iterator[tuple[int, int]]:
    """(rows times columns, filled cells) that a part of a workbook stretches over.

    Any part may be a sheet: a workbook names its sheets' parts as it likes.
    """
    if name == "content.xml":
        yield from _open_document_cells(data)
    elif data.startswith(_BEGIN_SHEET) or (name.endswith(".bin") and "sheets/" in name):
        yield _binary_cells(data)
    else:
        yield _xml_cells(data)


def _xml_cells(data: bytes) -> tuple[int, int]:
    """The same of an .xlsx sheet: a row or cell that states no place follows the one before.

    A cell that is closed at once is empty, and the reader passes over it.
    """
    row = column = rows = columns = filled = 0
    for tag in _CELL.finditer(data):
        kind, letters, number, attributes = tag.groups()
        if kind == b"row":
            row, column = row + 1, 0
        else:
            column += 1
        if number:  # usually the first attribute
            row, column = int(number), _column(letters) or column
        for letters, number in _PLACE.findall(attributes) if b"r" in attributes else ():
            row, column = int(number), _column(letters) or column
        if kind == b"c" and not attributes.endswith(b"/"):
            filled += 1
            rows, columns = max(rows, row), max(columns, column)
    return rows * max(columns, 1), filled


@lru_cache(maxsize=20_000)
def _column(letters: bytes) -> int:
    """The number of a column, from 1: 28 for AB."""
    return sum(26**i * (c - 64) for i, c in enumerate(reversed(letters.upper())))


def _binary_cells(data: bytes) -> tuple[int, int]:
    """The same of an .xlsb sheet: records of a type, a length, and a row or a column first."""
    at = rows = columns = filled = 0
    while at < len(data):
        kind, at = _varint(data, at)
        length, at = _varint(data, at)
        if kind <= 11 and length >= 4:
            index = int.from_bytes(data[at : at + 4], "little") + 1
            filled += kind > 1  # 0 begins a row, 1 is a cell without content
            rows, columns = (
                (max(rows, index), columns) if kind == 0 else (rows, max(columns, index))
            )
        at += length
    return rows * max(columns, 1), filled


def _varint(data: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]
        value, at, shift = value | (byte & 127) << shift, at + 1, shift + 7
        if byte < 128:
            return value, at


def _open_document_cells(data: bytes) -> Iterator[tuple[int, int]]:
    """The same of the sheets of an .ods: up to the last cell that is not empty.

    A cell that is closed at once may hold a value all the same, in an attribute.
    """
    row = last_row = column = widest = filled = 0
    for tag in _REPEATED.finditer(data):
        kind, attributes = tag.groups()
        found = _TIMES.search(attributes)
        count = int(found[1]) if found else 1
        if kind == b"table":
            yield last_row * widest, filled
            row = last_row = widest = filled = 0
        elif kind == b"table-row":
            row, column = row + count, 0
        else:
            column += count
            if not attributes.endswith(b"/") or b"value" in attributes or b"formula" in attributes:
                last_row, widest, filled = row, max(widest, column), filled + 1
    yield last_row * widest, filled


def _source(path: str, name: str, rows: Sequence[Sequence[object]]) -> Source:
    lines = ["\t".join([repr(c) if type(c) is float else _cell(c) for c in row]) for row in rows]
    numbers = any(isinstance(c, float | int) for row in rows for c in row)
    return Source(path, ("\n".join(lines) + "\n").encode(), "utf-8", name, "." if numbers else None)


def _cell(value: object) -> str:
    return str(value).translate(_CLEAN).strip()
