"""How far a workbook stretches is known before it is read."""

from __future__ import annotations

import time
import zipfile
from pathlib import Path

import pytest

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.readers.workbook import (
    _count_binary,
    _count_open_document,
    _count_xml,
)


def test_a_part_that_is_no_sheet_is_looked_through_in_no_time() -> None:
    begin = time.process_time()
    for text in (b"<c ", b'<c a="', b"<c '", b"<table:table ", b'<table:table-cell x="'):
        _count_xml(text * 300_000), list(_count_open_document(text * 300_000))
    assert time.process_time() - begin < 60  # a search that begins anew at each tag takes hours


def test_the_extent_of_other_workbooks_is_counted_too() -> None:
    row = b'<table:table-row table:number-rows-repeated="%d">%s</table:table-row>'
    empty = b'<table:table-cell table:number-columns-repeated="%d"/>'
    sheet = b"<table:table>" + row % (1, b"<table:table-cell>1</table:table-cell>" + empty % 16383)
    sheet += row % (1048575, empty % 16384)
    assert max(_count_open_document(sheet + b"</table:table>")) == (1, 1)
    far = row % (1048575, empty % 16383 + b"<table:table-cell>1</table:table-cell>")
    assert max(_count_open_document(sheet + far))[0] > 1e10
    record = b"\x00\x04" + (1048575).to_bytes(4, "little")
    record += b"\x05\x04" + (16383).to_bytes(4, "little")
    assert _count_binary(record) == (1048576 * 16384, 1)


LAST_XLSX = '<sheetData><row><c r="{}"><v>1</v></c></row></sheetData>'
EMPTY = '<table:table-cell table:number-columns-repeated="{}"/>'
LAST_ODS = (
    '<table:table table:name="S"><table:table-row table:number-rows-repeated="{}">'
    "<table:table-cell/></table:table-row><table:table-row>" + EMPTY + "{}</table:table-row>"
    "</table:table>"
)
ONE = '<table:table-cell office:value-type="float" office:value="1"'


@pytest.mark.parametrize(("name", "content"), [
    ("xl/worksheets/sheet1.xml", LAST_XLSX.format("XFD1048576")),
    ("xl/worksheets/sheet1.xml", LAST_XLSX.format("A4294967295")),
    ("xl/worksheets/sheet1.xml", LAST_XLSX.format("XFD0000000001048576")),
    ("xl/worksheets/sheet1.xml", LAST_XLSX.format("A1048576")),
    ("xl/worksheets/sheet1.xml", LAST_XLSX.format("NTP1000")),
    ("content.xml", LAST_ODS.format(1048575, 16383, f"{ONE}/>")),
    ("content.xml", LAST_ODS.format(1048575, 16383, f"{ONE}>1</table:table-cell>")),
    ("content.xml", LAST_ODS.format(999, 9999, f"{ONE}/>")),
])  # fmt: skip
def test_a_small_workbook_with_one_value_far_out_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, content: str
) -> None:
    python_calamine = pytest.importorskip("python_calamine")
    monkeypatch.delattr(python_calamine, "CalamineWorkbook")  # it would store all cells between
    path = tmp_path / "far.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr(name, content)
    assert path.stat().st_size < 1500
    with pytest.raises(FileError, match="has a sheet of .* cells"):
        read_trace(path)


def test_an_empty_cell_or_row_far_out_does_not_count() -> None:
    table = "".join(f'<row r="{i}"><c r="A{i}"><v>{i}</v></c></row>' for i in range(1, 50))
    for far in ('<row r="1048576"/>', '<row r="1048576"><c r="XFD1048576" s="1"/></row>'):
        assert _count_xml(f"<sheetData>{table}{far}</sheetData>".encode()) == (49, 49)
