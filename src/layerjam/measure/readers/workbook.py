"""Workbooks (.xlsx, .xlsm, .xlsb, .xls, .ods): each sheet as tab-separated text.

So a sheet goes the way of every other file. Numbers keep every digit; a cell's text is kept as it
is, without tabs and line ends.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from typing import Any

from layerjam.errors import FileError, MissingExtraError
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.xlsx import trimmed

MAX_UNPACKED = 250_000_000
"""Bytes a zipped workbook may unpack to, which cost several times their number in memory: two full
sheets (a million rows) of four columns."""
_CLEAN = str.maketrans({"\t": " ", "\n": " ", "\r": " ", '"': "''"})


def sheets(path: str, data: bytes, sheet: str | None) -> list[Source]:
    """The sheets that hold anything, or the one asked for; FileError where there is none."""
    try:
        import python_calamine
    except ImportError:
        raise MissingExtraError(f"{path}: reading a workbook", "excel") from None

    _check_size(path, data)

    def opened(data: bytes) -> Any:
        return python_calamine.CalamineWorkbook.from_filelike(io.BytesIO(data))

    try:
        small = trimmed(data) if data.startswith(b"PK") else None
        book = opened(small.book if small else data)
        names = list(book.sheet_names)
        if sheet is not None and sheet not in names:
            there = ", ".join(f"'{n[:40]}'" for n in names[:8])
            raise FileError(path, f"has no sheet '{sheet[:40]}'; its sheets are {there}")
        found = []
        for name in names if sheet is None else [sheet]:
            rows = _rows(book, name)
            run = small.run_of(rows) if small else None
            if run is not None and not all(isinstance(c, float) for c in rows[-2]):
                rows, run = _rows(opened(data), name), None  # dates, which are numbers in the XML
            if rows:
                found.append(_source(path, name, rows if run is None else rows[:-1], run or b""))
    except FileError:
        raise
    except BaseException as err:  # the reader panics on some damage, which is no Exception
        if isinstance(err, KeyboardInterrupt | SystemExit | MemoryError):
            raise
        raise FileError(
            path, "is an Excel workbook or zip archive that cannot be read; it may be damaged"
        ) from None
    if not found:
        raise FileError(path, "is a workbook without any filled cell")
    return found


def _check_size(path: str, data: bytes) -> None:
    """Refuse a small file that unpacks into what no memory holds."""
    if not data.startswith(b"PK"):
        return
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as book:
            size = sum(part.file_size for part in book.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError, EOFError, OSError):
        return  # damaged: the reader says so
    if size > MAX_UNPACKED:
        raise FileError(
            path,
            f"unpacks to {size / 1e6:.0f} MB, more than {MAX_UNPACKED / 1e6:.0f} MB is not read; "
            "export it as CSV",
        )


def _rows(book: Any, name: str) -> list[list[object]]:
    rows: list[list[object]] = book.get_sheet_by_name(name).to_python(skip_empty_area=False)
    return rows


def _source(path: str, name: str, rows: Sequence[Sequence[object]], run: bytes) -> Source:
    lines = ["\t".join([repr(c) if type(c) is float else _cell(c) for c in row]) for row in rows]
    numbers = run or any(isinstance(c, float | int) for row in rows for c in row)
    text = ("\n".join(lines) + "\n").encode() + run
    return Source(path, text, "utf-8", name, "." if numbers else None)


def _cell(value: object) -> str:
    return str(value).translate(_CLEAN).strip()
