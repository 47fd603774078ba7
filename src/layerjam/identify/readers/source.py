"""A file's bytes as plain lines: encoding, byte-order mark and line ends are settled here."""

from __future__ import annotations

import codecs
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from layerjam.errors import FileError

MAX_BYTES = 1_000_000_000
_LONGEST_LINE = 20_000
_KINDS = {
    b"PK\x03\x04": "an Excel workbook or zip archive",
    b"\xd0\xcf\x11\xe0": "an old Excel or Office file",
    b"%PDF": "a PDF",
    b"\x89HDF": "an HDF5 or NetCDF file",
    b"CDF\x01": "a NetCDF file",
}


@dataclass(frozen=True)
class Source:
    """A text file: `data` in UTF-8 or a one-byte code page, Unix newlines, no byte-order mark."""

    path: str
    data: bytes
    encoding: str

    def lines(self, offset: int = 0) -> Iterator[tuple[int, str]]:
        """(byte offset, text) of each line from a byte offset on."""
        data = self.data
        while offset < len(data):
            end = data.find(b"\n", offset)
            end = len(data) if end < 0 else end
            if end - offset > _LONGEST_LINE:
                number = data.count(b"\n", 0, offset) + 1
                raise FileError(
                    self.path, f"has a line of {end - offset} bytes, no table of numbers", number
                )
            yield offset, data[offset:end].decode(self.encoding, errors="replace")
            offset = end + 1

    def line_number(self, offset: int) -> int:
        """The line (from 1) that holds a byte offset."""
        return self.data.count(b"\n", 0, offset) + 1


def load_source(path: str | Path) -> Source:
    """Read a text file; raises FileError where there is none, or none that is text."""
    name = str(path)
    try:
        place = Path(path)
        if place.is_dir():
            raise FileError(name, "is a folder, not a file")
        if not place.exists():
            raise FileError(name, "does not exist")
        if not place.is_file():
            raise FileError(name, "is no regular file")
        size = place.stat().st_size
        if size > MAX_BYTES:
            raise FileError(name, f"is {size / 1e9:.1f} GB large, more than 1 GB is not read")
        data = place.read_bytes()
    except (OSError, ValueError) as err:
        reason = getattr(err, "strerror", None) or err
        raise FileError(name[:200], f"cannot be read: {reason}") from None
    if not data.strip():
        raise FileError(name, "is empty")
    for start, kind in _KINDS.items():
        if data.startswith(start):
            raise FileError(name, f"is {kind}, not text; export it as CSV")
    data, encoding = _decoded(name, data)
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return Source(name, data, encoding)


def _decoded(name: str, data: bytes) -> tuple[bytes, str]:
    """The bytes in an encoding in which digits and separators are single ASCII bytes."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            data = data.decode("utf-16").encode()
        except (UnicodeDecodeError, UnicodeEncodeError):
            raise FileError(
                name, "is not whole: its UTF-16 text breaks off or is damaged"
            ) from None
    data = data.removeprefix(codecs.BOM_UTF8)
    odd = next((c for c in data[:4096] if c < 32 and c not in b"\t\n\r\f\x1a"), None)
    if odd is not None or b"\0" in data:
        raise FileError(name, "is binary, not a text file of numbers")
    if not data.strip():
        raise FileError(name, "is empty")
    try:
        if not data.isascii():
            data.decode("utf-8")
        return data, "utf-8"
    except UnicodeDecodeError:
        return data, "cp1252"
