"""Bytes of a file as plain lines: encoding, byte-order mark and line endings."""

from pathlib import Path

from layerjam.core.errors import FileError, QuantityError, short_text
from layerjam.core.system import report_failure
from layerjam.core.toml_files.toml import suggest_nearby
from layerjam.laboratory.measure.readers.content import IN_CELL, Source, decode_file
from layerjam.laboratory.measure.readers.layouts import clean_lines
from layerjam.laboratory.measure.readers.workbook import read_sheets
from layerjam.laboratory.measure.run_text import format_run_csv
from layerjam.laboratory.measure.runs import ENDING, read_run

MAX_BYTES = 1_000_000_000
_HEAD = 65_536
_KINDS = {
    b"%PDF": "a PDF",
    b"\x89HDF": "an HDF5 or NetCDF file",
    b"CDF\x01": "a NetCDF file",
    b"<?xml": "XML",
    b"<html": "a web page",
    b"<!DOCTYPE": "a web page",
    b"{\\rtf": "RTF",
    b"\x1f\x8b": "a gzip archive",
}
_WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")


def check_path(path: object) -> None:
    """Raise QuantityError if a value is not a path."""
    if not isinstance(path, str | Path):
        raise QuantityError.of("path", f"{short_text(path)} is not text or a path")


def load_source(path: str | Path) -> Source:
    """Return a text file, or the largest sheet of a workbook; raises FileError if there is none."""
    return max(load_sources(path), key=lambda s: len(s.data))


def load_sources(path: str | Path, sheet: str | None = None) -> list[Source]:
    """Return a text file, a bench run as text, or each non-empty sheet of a workbook.

    `sheet` selects one by name. Raises FileError if the file or the sheet does not exist, or if the
    file is not text.
    """
    check_path(path)
    name = str(path)
    if not name:
        raise FileError("''", "is an empty name; specify a file")
    if Path(name).suffix == ENDING:
        return [Source(name, format_run_csv(read_run(path)).encode(), "utf-8")]
    data = _read_text(name, path)
    if not data or data.isspace():
        raise FileError(name, "is empty")
    if data.startswith(_WORKBOOKS):
        return read_sheets(name, data, sheet)
    if sheet is not None:
        raise FileError(name, f"has no sheet '{sheet[:40]}': it is text, not a workbook")
    for start, kind in _KINDS.items():
        if data[:99].lstrip()[: len(start)].lower() == start.lower():
            raise FileError(name, f"is {kind}, not text; export it as CSV")
    data, encoding = decode_file(name, data)
    if not data or data.isspace():
        raise FileError(name, "is empty")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    layout = clean_lines(_join_cell_lines(data))
    return [Source(name, layout.data, encoding, decimal=layout.decimal, notes=layout.notes)]


def _read_text(name: str, path: str | Path) -> bytes:
    with report_failure(path, "cannot be read"):
        place = Path(path)
        if place.is_dir():
            raise FileError(name, "is a folder, not a file")
        if not place.exists():
            raise FileError(name, "does not exist", how=suggest_nearby(place))
        if not place.is_file():
            raise FileError(name, "is not a regular file")
        size = place.stat().st_size
        if size > MAX_BYTES:
            raise FileError(name, f"is {size / 1e9:.1f} GB; at most 1 GB can be read")
        return place.read_bytes()


def _join_cell_lines(data: bytes) -> bytes:
    """Join the two lines of a name in one quoted cell ("Load", line break, "(N)")."""
    head = data[:_HEAD]
    if b'"' not in head:
        return data
    lines = head.split(b"\n")
    out, place = [], 0
    joined = False
    while place < len(lines):
        line, last = lines[place], place
        while line.count(b'"') % 2 and last + 1 < min(len(lines) - 1, place + 12):
            last += 1
            line += IN_CELL.encode() + lines[last]
        if line.count(b'"') % 2 or last == place:
            out.append(lines[place])
            place += 1
            continue
        joined = True
        out.append(line)
        place = last + 1
    return b"\n".join(out) + data[_HEAD:] if joined else data
