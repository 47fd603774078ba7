"""Several specimens in a file, columns without names, and workbooks."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
import pytest

from laboratory.measure.layouts import curve, rows
from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.read import open_traces, read_trace, read_traces

TIME, TRAVEL, FORCE = (np.array(c) for c in curve())
HEAD = "Time (s),Extension (mm),Load (N)"


def scaled(factor: float, count: int = 60, form: str = "{:.4f},{:.5f},{:.4f}") -> list[str]:
    return [form.format(t, x, f * factor) for t, x, f in zip(*curve(count), strict=True)]


def write(tmp_path: Path, *lines: str, name: str = "x.csv") -> Path:
    path = tmp_path / name
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return path


def side_by_side(*parts: Sequence[str], fill: str = ",,") -> list[str]:
    longest = max(map(len, parts))
    return [",".join(p[i] if i < len(p) else fill for p in parts) for i in range(longest)]


STACKED = {
    "heads repeated": ([HEAD, *scaled(1)], ["", HEAD, *scaled(2)]),
    "titles and heads": (["Specimen 1", HEAD, *scaled(1)], ["Specimen 2", HEAD, *scaled(2)]),
    "one head, titles between": ([HEAD, "Specimen 1", *scaled(1)], ["Specimen 2", *scaled(2)]),
    "results above each": (
        ['"Max load (N)","Extension at max (mm)"', "99.8,1.3", "", HEAD, *scaled(1)],
        ['"Max load (N)","Extension at max (mm)"', "199.6,1.3", "", HEAD, *scaled(2)],
    ),
    "Trapezium blocks": (
        ['"1 _ 1"', '"Time","Stroke","Force"', '"sec","mm","N"', *scaled(1)],
        ["", '"1 _ 2"', '"Time","Stroke","Force"', '"sec","mm","N"', *scaled(2)],
    ),
}


@pytest.mark.parametrize("case", STACKED)
def test_one_below_the_other(case: str, tmp_path: Path) -> None:
    first, second = STACKED[case]
    path = write(tmp_path, *first, *second)
    one, two = read_traces(path)
    assert len(one) == len(two) == 60
    np.testing.assert_allclose(two.force, 2 * one.force, atol=2e-4)
    assert one.specimen != two.specimen
    with pytest.raises(FileError, match=r"contains 2 specimens .*--specimen 1"):
        read_trace(path)
    again = read_trace(path, ReadingOptions(specimen=2))
    np.testing.assert_array_equal(again.force, two.force)
    with pytest.raises(FileError, match="no specimen 3"):
        read_trace(path, ReadingOptions(specimen=3))


BESIDE = {
    "Trapezium": [
        '"1 _ 1","","","1 _ 2","","","1 _ 3","",""',
        ",".join(['"Time","Stroke","Force"'] * 3),
        ",".join(['"sec","mm","N"'] * 3),
    ],
    "units in names": [",".join([HEAD] * 3)],
    "numbered names": [
        ",".join(f"Time {k} (s),Extension {k} (mm),Load {k} (N)" for k in (1, 2, 3))
    ],
    "labelled": [
        "Specimen 1,,,Specimen 2,,,Specimen 3,,",
        ",".join(["Time,Extension,Load"] * 3),
        ",".join(["(s),(mm),(N)"] * 3),
    ],
}


@pytest.mark.parametrize("short", [",,", ""])
@pytest.mark.parametrize("case", BESIDE)
def test_side_by_side_of_different_lengths(case: str, short: str, tmp_path: Path) -> None:
    parts = [scaled(1, 60), scaled(2, 45), scaled(3, 50)]
    body = side_by_side(*parts)
    if not short:  # rows end with the last value there is
        body = [line.rstrip(",") for line in body]
    traces = read_traces(write(tmp_path, *BESIDE[case], *body))
    assert [len(t) for t in traces] == [60, 45, 50]
    for k, trace in enumerate(traces, 1):
        np.testing.assert_allclose(trace.force, k * FORCE[: len(trace)], atol=1e-4)
        np.testing.assert_allclose(trace.time, TIME[: len(trace)], atol=1e-4)
    assert len({t.specimen for t in traces}) == 3
    if case == "Trapezium":
        assert [t.specimen for t in traces] == ["1 _ 1", "1 _ 2", "1 _ 3"]
        assert traces[0].format == "Shimadzu Trapezium"


def test_one_time_for_all_and_columns_with_spaces_between(tmp_path: Path) -> None:
    body = [f"{t},{x},{f},{x},{2 * f}" for t, x, f in zip(TIME, TRAVEL, FORCE, strict=True)]
    head = "Time (s),Extension (mm),Load (N),Extension (mm),Load (N)"
    one, two = read_traces(write(tmp_path, head, *body))
    np.testing.assert_array_equal(one.time, two.time)
    np.testing.assert_allclose(two.force, 2 * one.force)
    body = [f"{x},{f},,{x},{3 * f}" for x, f in zip(TRAVEL, FORCE, strict=True)]
    one, two = read_traces(write(tmp_path, "Weg [mm],Kraft [N],,Weg [mm],Kraft [N]", *body))
    np.testing.assert_allclose(two.force, 3 * one.force)


def test_two_load_cells_are_no_two_specimens(tmp_path: Path) -> None:
    body = [f"{r},{i}" for i, r in enumerate(rows())]
    path = write(tmp_path, "Time (s),Extension (mm),Load 1 (N),Load 2 (N)", *body)
    with pytest.raises(FileError, match="does not state which column is the force"):
        read_trace(path)
    assert read_trace(path, ReadingOptions(column=["force=Load 2"])).force[7] == 7


def test_a_gap_in_the_middle_is_damage_even_side_by_side(tmp_path: Path) -> None:
    body = side_by_side(scaled(1, 60), scaled(2, 45))
    body[20] = body[20].rsplit(",", 3)[0] + ",,,"
    found = open_traces(write(tmp_path, f"{HEAD},{HEAD}", *body))
    assert len(found[0].read(ReadingOptions())) == 60
    with pytest.raises(FileError, match="is empty") as err:
        found[1].read(ReadingOptions())
    assert err.value.line == 22


@pytest.mark.parametrize("width", [2, 3, 5])
def test_the_hint_for_bare_numbers_is_one_that_is_taken(width: int, tmp_path: Path) -> None:
    columns = [TRAVEL, FORCE] if width == 2 else [TIME, TRAVEL, FORCE, FORCE, FORCE][:width]
    body = [",".join(f"{v:.5f}" for v in row) for row in zip(*columns, strict=True)]
    path = write(tmp_path, *body)
    with pytest.raises(FileError) as err:
        read_trace(path)
    trace = read_trace(path, ReadingOptions(columns=str(err.value).rpartition("--columns ")[2]))
    np.testing.assert_allclose(trace.force, FORCE, atol=1e-5)
    np.testing.assert_allclose(trace.elongation, TRAVEL / 1e3, atol=1e-8)


def test_columns_by_their_place(tmp_path: Path) -> None:
    body = [f"{t * 1e3:.1f}\t9\t{f:.4f}\t{x:.5f}" for t, x, f in zip(*curve(), strict=True)]
    path = write(tmp_path, *body)
    with pytest.raises(FileError, match="4 columns of numbers without names.*--columns time:s,"):
        read_trace(path)
    trace = read_trace(path, ReadingOptions(columns="time:ms, skip, force:N, elongation:mm"))
    np.testing.assert_allclose(trace.force, FORCE, atol=1e-4)
    np.testing.assert_allclose(trace.time, TIME, atol=1e-4)
    np.testing.assert_allclose(trace.elongation, TRAVEL / 1e3, atol=1e-8)
    assert "force is the column 'column 3' in N, as given" in trace.understood
    with pytest.raises(FileError, match="has 4 columns, but --columns lists 2"):
        read_trace(path, ReadingOptions(columns="force:N,elongation:mm"))
    for wrong in (
        "force:N",
        "force:mm,elongation:mm",
        "force,elongation:mm",
        "x:N",
        "force:N,force:N",
    ):
        with pytest.raises(LayerjamError):
            read_trace(path, ReadingOptions(columns=wrong))


@pytest.mark.parametrize("above", [0, 3])
def test_a_wrong_list_of_columns_is_reported_at_the_first_row(above: int, tmp_path: Path) -> None:
    path = write(tmp_path, *["by hand"] * above, *rows())
    with pytest.raises(FileError, match="has 3 columns, but --columns lists 2") as err:
        read_trace(path, ReadingOptions(columns="force:N,elongation:mm"))
    assert err.value.line == above + 1


def test_a_named_table_is_explained_unless_far_more_rows_have_no_names(tmp_path: Path) -> None:
    """A table of time and force, which needs a speed, and below it three columns of numbers."""
    for named, nameless, words in (
        (20, 40, "contains force and time but no elongation"),
        (9, 100, "is not in a known format: 3 columns of numbers without names"),
    ):
        table = [f"{t:.4f},{f:.4f}" for t, _, f in zip(*curve(named), strict=True)]
        path = write(tmp_path, "Time (s),Load (N)", *table, "Raw", *rows(nameless))
        with pytest.raises(FileError, match=words):
            read_trace(path)


def test_units_that_the_user_gives(tmp_path: Path) -> None:
    path = write(tmp_path, "Time,Extension,Load (lb)", *rows())
    with pytest.raises(FileError, match=r"'Extension' has no unit.*--columns elongation:mm="):
        read_trace(path)
    some = ReadingOptions(column=["elongation:mm=Extension"])
    with pytest.raises(
        FileError, match=r"'lb', which is not a unit of force, a unit of mass.*force:lbf="
    ):
        read_trace(path, some)
    trace = read_trace(path, ReadingOptions(column=["elongation:mm=Extension", "force:lbf=Load"]))
    np.testing.assert_allclose(trace.force, FORCE * 4.4482216152605, atol=1e-3)
    assert trace.time is None and any("the time is not read" in s for s in trace.understood)
    with pytest.raises(LayerjamError, match="'mm' is not a unit of force"):
        read_trace(path, ReadingOptions(column=["force:mm=Load"]))


def test_one_syntax_names_columns_in_every_kind_of_file(tmp_path: Path) -> None:
    path = write(tmp_path, "Time,Extension,Load, raw", *rows(form="{:.4f};{:.5f};{:.4f}"))
    path.write_text(path.read_text().replace("Time,Extension,", "Time;Extension;"))
    trace = read_trace(path, ReadingOptions(columns="elongation:mm=Extension,force:N=Load, raw"))
    np.testing.assert_allclose(trace.force, FORCE, atol=1e-4)
    again = ReadingOptions(column=["elongation:mm=Extension", "force:N=Load, raw"])
    assert trace.understood == read_trace(path, again).understood


def test_a_trace_can_be_cut_and_is_a_trace_still(tmp_path: Path) -> None:
    trace = read_trace(write(tmp_path, "Time (s),Extension (mm),Load (N)", *rows()))
    part = trace.between(0.1, 0.3)
    assert (part.time[0], part.time[-1]) == (0.1, 0.3) and len(part) == 21
    far = trace.between(end=2e-3, over="elongation")
    assert far.elongation.max() <= 2e-3 and "cut to its elongation to 2 mm" in far.understood[-1]
    for wrong in ({"start": 9.0}, {"over": "force"}):
        with pytest.raises(LayerjamError):
            trace.between(**wrong)


# ---- workbooks ---------------------------------------------------------------------------------

Rows = Sequence[Sequence[object]]
XL = "http://schemas.openxmlformats.org"
KIND = "application/vnd.openxmlformats"
PARTS = {
    "[Content_Types].xml": f'<Types xmlns="{XL}/package/2006/content-types">'
    '<Default Extension="rels" ContentType="' + KIND + '-package.relationships+xml"/>'
    '<Default Extension="xml" ContentType="application/xml"/>'
    '<Override PartName="/xl/workbook.xml" ContentType="'
    + KIND
    + '-officedocument.spreadsheetml.sheet.main+xml"/></Types>',
    "_rels/.rels": f'<Relationships xmlns="{XL}/package/2006/relationships"><Relationship '
    f'Id="rId1" Type="{XL}/officeDocument/2006/relationships/officeDocument" '
    'Target="xl/workbook.xml"/>'
    "</Relationships>",
}


def xlsx(path: Path, sheets: dict[str, Rows], shared: bool = False) -> Path:
    """A workbook as spreadsheets write it; texts in the cells or in a table of shared strings."""
    strings: list[str] = []
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        for part, text in PARTS.items():
            book.writestr(part, text)
        names = "".join(
            f'<sheet name="{n}" sheetId="{k}" r:id="rId{k}"/>' for k, n in enumerate(sheets, 1)
        )
        book.writestr(
            "xl/workbook.xml",
            f'<workbook xmlns="{XL}/spreadsheetml/2006/main" '
            f'xmlns:r="{XL}/officeDocument/2006/relationships"><sheets>{names}</sheets></workbook>',
        )
        kind = f"{XL}/officeDocument/2006/relationships"
        links = "".join(
            f'<Relationship Id="rId{k}" Type="{kind}/worksheet" Target="worksheets/sheet{k}.xml"/>'
            for k in range(1, len(sheets) + 1)
        )
        links += f'<Relationship Id="rS" Type="{kind}/sharedStrings" Target="sharedStrings.xml"/>'
        book.writestr(
            "xl/_rels/workbook.xml.rels",
            f'<Relationships xmlns="{XL}/package/2006/relationships">{links}</Relationships>',
        )
        for k, table in enumerate(sheets.values(), 1):
            book.writestr(f"xl/worksheets/sheet{k}.xml", _sheet(table, strings, shared))
        items = "".join(f"<si><t>{escape(s)}</t></si>" for s in strings)
        book.writestr(
            "xl/sharedStrings.xml", f'<sst xmlns="{XL}/spreadsheetml/2006/main">{items}</sst>'
        )
    return path


def _sheet(table: Rows, strings: list[str], shared: bool) -> str:
    out = []
    for i, row in enumerate(table, 1):
        cells = []
        for j, value in enumerate(row):
            place = f"{chr(65 + j)}{i}"
            if isinstance(value, str) and shared:
                strings.append(value)
                cells.append(f'<c r="{place}" t="s"><v>{len(strings) - 1}</v></c>')
            elif isinstance(value, str):
                text = f"<is><t>{escape(value)}</t></is>"
                cells.append(f'<c r="{place}" t="inlineStr">{text}</c>')
            elif value is not None:
                cells.append(f'<c r="{place}" s="0"><v>{value!r}</v></c>')
        out.append(f'<row r="{i}">{"".join(cells)}</row>')
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<worksheet xmlns="{XL}/spreadsheetml/2006/main">'
        f"<sheetData>{''.join(out)}</sheetData></worksheet>"
    )


def ods(path: Path, table: Rows) -> Path:
    """A sheet as LibreOffice writes it."""
    body = []
    for row in table:
        cells = []
        for value in row:
            if isinstance(value, str):
                cells.append(
                    '<table:table-cell office:value-type="string" calcext:value-type="string">'
                    f"<text:p>{escape(value)}</text:p></table:table-cell>"
                )
            elif value is None:
                cells.append("<table:table-cell/>")
            else:
                cells.append(
                    f'<table:table-cell office:value-type="float" office:value="{value!r}" '
                    f'calcext:value-type="float"><text:p>{value:.2f}</text:p></table:table-cell>'
                )
        body.append(f"<table:table-row>{''.join(cells)}</table:table-row>")
    spaces = " ".join(
        f'xmlns:{s}="urn:oasis:names:tc:opendocument:xmlns:{s}:1.0"'
        for s in ("office", "table", "text")
    )
    content = (
        f'<?xml version="1.0" encoding="UTF-8"?><office:document-content {spaces} '
        'xmlns:calcext="urn:org:documentfoundation:names:experimental:calc:xmlns:calcext:1.0">'
        '<office:body><office:spreadsheet><table:table table:name="Raw">'
        f"{''.join(body)}</table:table></office:spreadsheet></office:body></office:document-content>"
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        book.writestr("content.xml", content)
        book.writestr("META-INF/manifest.xml", MANIFEST)
    return path


MANIFEST = (
    '<?xml version="1.0" encoding="UTF-8"?><manifest:manifest '
    'xmlns:manifest="urn:oasis:names:tc:opendocument:xmlns:manifest:1.0">'
    '<manifest:file-entry manifest:full-path="/" '
    'manifest:media-type="application/vnd.oasis.opendocument.spreadsheet"/></manifest:manifest>'
)
NUMBERS = [list(row) for row in zip(TIME.tolist(), TRAVEL.tolist(), FORCE.tolist(), strict=True)]
RAW = [["Specimen", "A 12"], [], ["Time", "Extension", "Load"], ["s", "mm", "N"], *NUMBERS]


@pytest.mark.parametrize("kind", ["inline", "shared", "ods"])
def test_a_workbook_is_read_exactly(kind: str, tmp_path: Path) -> None:
    pytest.importorskip("python_calamine")
    path = tmp_path / "book.bin"  # told by its content, not by its name
    if kind == "ods":
        ods(path, RAW)
    else:
        xlsx(path, {"Info": [["Operator", "me"]], "Raw": RAW}, shared=kind == "shared")
    trace = read_trace(path)
    np.testing.assert_array_equal(trace.force, FORCE)
    np.testing.assert_array_equal(trace.elongation, TRAVEL / 1000)
    assert trace.format == "workbook, sheet 'Raw'"


def test_sheets(tmp_path: Path) -> None:
    pytest.importorskip("python_calamine")
    double = [[t, x, 2 * f] for t, x, f in NUMBERS]
    same = {"Results": [["Max (N)"], [99.0]], "P1": RAW, "P2": [*RAW[:4], *double]}
    path = xlsx(tmp_path / "same.xlsx", same)
    one, two = read_traces(path)
    assert (one.specimen, two.specimen) == ("P1", "P2")
    np.testing.assert_array_equal(two.force, 2 * one.force)
    other = {"P1": RAW, "P2": [["Weg [mm]", "Kraft [N]"], *([x, f] for _, x, f in NUMBERS)]}
    path = xlsx(tmp_path / "other.xlsx", other)
    with pytest.raises(FileError, match=r"2 sheets .*\('P1', 'P2'\); choose one \(--sheet P1\)"):
        read_trace(path)
    assert read_trace(path, ReadingOptions(sheet="P2")).time is None
    with pytest.raises(FileError, match="has no sheet 'P9'; its sheets are 'P1', 'P2'"):
        read_trace(path, ReadingOptions(sheet="P9"))


def test_numbers_with_three_decimals_in_a_workbook_are_no_thousands(tmp_path: Path) -> None:
    pytest.importorskip("python_calamine")
    numbers = [[1.125 + k, (k + 1.5) * 1.25] for k in range(60)]
    path = xlsx(tmp_path / "x.xlsx", {"S": [["Weg [mm]", "Kraft [N]"], *numbers]})
    assert read_trace(path).force[0] == 1.875


@pytest.mark.parametrize("cut", [30, 200, 900])
def test_a_damaged_workbook_is_one_sentence(cut: int, tmp_path: Path) -> None:
    pytest.importorskip("python_calamine")
    path = xlsx(tmp_path / "x.xlsx", {"Raw": RAW})
    path.write_bytes(path.read_bytes()[:-cut])
    with pytest.raises(FileError, match="cannot be read"):
        read_trace(path)


def _with_a_last_cell(data: bytes, part: str, old: bytes, new: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as book, zipfile.ZipFile(out, "w") as made:
        for name in book.namelist():
            text = book.read(name)
            made.writestr(name, text.replace(old, new) if part in name else text)
    return out.getvalue()


def test_a_small_workbook_with_a_far_cell_is_refused_before_it_is_opened(tmp_path: Path) -> None:
    pytest.importorskip("python_calamine")
    path = xlsx(tmp_path / "x.xlsx", {"Raw": RAW})
    cell = b'<row r="1048576"><c r="XFD1048576"><v>1</v></c></row></sheetData>'
    path.write_bytes(_with_a_last_cell(path.read_bytes(), "sheets/", b"</sheetData>", cell))
    with pytest.raises(FileError, match=r"has a sheet of 1.72e\+10 cells"):
        read_trace(path)


FAR = b'<row r="1048576"><c r="XFD1048576"><v>1</v></c></row></sheetData>'
DISGUISES = {
    "small letters": (b"XFD", b"xfd", ""),
    "blanks": (b'r="', b'r = "', ""),
    "behind another attribute": (b'<c r="', b'<c x=" > " r="', ""),
    "a prefix": (b"<c r", b"<x:c r", ""),
    "no places in it": (b' r="1048576"><c r="XFD1048576"', b"><c" + b"/><c" * 10**6, ""),
    "no sheet's name": (b"", b"", "xl/data/one.xml"),
    "capitals in its name": (b"", b"", "xl/Worksheets/Sheet1.XML"),
}


@pytest.mark.parametrize("case", DISGUISES)
def test_a_far_cell_is_found_however_it_is_written(case: str, tmp_path: Path) -> None:
    """Each is as the workbook reader takes it: without the bound some GB are asked for."""
    pytest.importorskip("python_calamine")
    old, new, part = DISGUISES[case]
    data = xlsx(tmp_path / "x.xlsx", {"Raw": RAW}).read_bytes()
    data = _with_a_last_cell(data, "sheets/", b"</sheetData>", FAR.replace(old, new))
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as book, zipfile.ZipFile(out, "w") as made:
        for name in book.namelist():
            text = book.read(name)
            if part:
                text = text.replace(b"worksheets/sheet1.xml", part.removeprefix("xl/").encode())
            place = name.replace("xl/worksheets/sheet1.xml", part) if part else name
            made.writestr(place, text)
    path = tmp_path / "far.xlsx"
    path.write_bytes(out.getvalue())
    with pytest.raises(FileError, match=r"has a sheet of .* cells"):
        read_trace(path)
