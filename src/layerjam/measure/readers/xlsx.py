"""The numbers of a large .xlsx sheet, taken from its XML with passes over the bytes.

The general reader makes an object of every cell, which takes longest of all. Here it gets a copy of
the workbook in which the long runs of plain numbers are left out; their digits are cut from the
XML as text. What does not look exactly so (other cells than numbers, gaps, formulas) is left in.
"""

from __future__ import annotations

import io
import re
import zipfile
from dataclasses import dataclass

import numpy as np

_LARGE = 200_000
_HEAD_ROWS = 60
_MARK = "layerjam rows of "
_FROM = b"<row "
_UNTIL = b"</sheetData>"


@dataclass(frozen=True)
class Trimmed:
    """A workbook without its long runs of numbers, and those as text: {sheet's part: text}."""

    book: bytes
    runs: dict[str, bytes]

    def run_of(self, rows: list[list[object]]) -> bytes | None:
        """The run that a sheet's last row stands for."""
        last = next((c for c in rows[-1] if c != ""), "") if rows else ""
        if isinstance(last, str) and last.startswith(_MARK):
            return self.runs.get(last.removeprefix(_MARK))
        return None


def trimmed(data: bytes) -> Trimmed | None:
    """The workbook with its long runs of numbers cut out; None where there is none to cut."""
    runs: dict[str, bytes] = {}
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        parts = [i for i in book.infolist() if i.filename.startswith("xl/worksheets/sheet")]
        large = {i.filename for i in parts if i.file_size > _LARGE}
        if not large or "xl/workbook.xml" not in book.namelist():
            return None
        with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as small:
            for info in book.infolist():
                text = book.read(info)
                if info.filename in large:
                    text = _cut(text, info.filename, runs)
                small.writestr(info.filename, text)
    return Trimmed(out.getvalue(), runs) if runs else None


def _cut(xml: bytes, part: str, runs: dict[str, bytes]) -> bytes:
    """The sheet with its run of numbers replaced by one row that names the part."""
    first = 0
    for _ in range(_HEAD_ROWS):
        first = xml.find(_FROM, first + 1)
        if first < 0:
            return xml
    stop = xml.rfind(_UNTIL)
    if stop < first:
        return xml
    run = _digits(xml, first, stop)
    if run is None:
        return xml
    number = re.match(rb'<row [^>]*?r="(\d+)"', xml[first : first + 200])
    if number is None:
        return xml
    runs[part] = run
    at = number[1].decode()
    row = f'<row r="{at}"><c r="A{at}" t="inlineStr"><is><t>{_MARK}{part}</t></is></c></row>'
    return xml[:first] + row.encode() + xml[stop:]


def _digits(xml: bytes, first: int, stop: int) -> bytes | None:
    """Rows of plain numbers as tab-separated text; None where anything else is among them."""
    body = xml[first:stop]
    typed = body.count(b' t="')
    if typed and typed != body.count(b' t="n"'):
        return None
    raw = np.frombuffer(body, np.uint8)
    tags = np.flatnonzero(raw == ord("<"))
    one, two = raw[tags + 1], raw[tags + 2]
    value = (one == ord("v")) & (two == ord(">"))
    cell = (one == ord("c")) & (two == ord(" "))
    end = (one == ord("/")) & (two == ord("r"))
    cells, rows = int(cell.sum()), int(end.sum())
    closes = int(((one == ord("/")) & ((two == ord("v")) | (two == ord("c")))).sum())
    opens = int(((one == ord("r")) & (two == ord("o"))).sum())
    regular = rows and cells % rows == 0 and int(value.sum()) == cells and opens == rows
    if not regular or closes != 2 * cells or len(tags) != 4 * cells + 2 * rows:
        return None
    per_row = cells // rows
    places = tags[cell]
    letters = raw[places + 6].reshape(rows, per_row)
    named = (raw[places + 3] == ord("r")) & (raw[places + 5] == ord('"'))
    single = (raw[places + 7] >= ord("0")) & (raw[places + 7] <= ord("9"))
    alphabet = np.arange(ord("A"), ord("A") + per_row)
    if per_row > 26 or not (named & single).all() or not (letters == alphabet).all():
        return None
    which = np.flatnonzero(value)
    if (np.searchsorted(which, np.flatnonzero(end)) != np.arange(1, rows + 1) * per_row).any():
        return None
    starts, ends = tags[which] + 3, tags[which + 1]
    text = raw.copy()
    text[ends] = 9
    text[ends[per_row - 1 :: per_row]] = 10
    bounds = np.column_stack((starts, ends + 1)).ravel()
    lengths = np.diff(bounds, prepend=0, append=len(raw))
    inside = np.arange(len(lengths)) % 2 == 1  # what lies between, then a value, and so on
    return text[np.repeat(inside, lengths)].tobytes()
