"""Names that a spreadsheet would run: kept from it in every CSV, and read back as they were."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.simulate.record import Outcome, PullRecord, read_header
from layerjam.core.toml_files.table_text import comment, format_rows, restore_cell, restore_comment
from layerjam.laboratory.campaigns.exports import Form, encode_file
from layerjam.laboratory.figures.brake_files import format_numbers
from layerjam.laboratory.figures.brake_numbers import COLUMNS, Number
from layerjam.laboratory.measure.conditions import LIST
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace
from layerjam.laboratory.records.contents import read_content

WORST = (
    "=cmd|' /C calc'!A0.csv",
    "+1+cmd|x",
    "-2+3+cmd|x",
    "@SUM(1)",
    "\t=1",
    "\r=1",
    "'=1",
    '"=1"',
)
texts = st.text(alphabet=st.sampled_from("=+-@'\",;\t\r 1.ae#x"), max_size=12) | st.text(
    max_size=20
)


def formula(shown: str) -> bool:
    """Whether a spreadsheet would compute a cell that a CSV reader gives it."""
    if shown[:1] not in ("=", "+", "-", "@", "\t", "\r") or not shown:
        return False
    try:
        float(shown)
    except ValueError:
        return True
    return bool(re.search(r"[_\s]", shown))


@given(st.lists(st.lists(texts, min_size=1, max_size=4), min_size=1, max_size=4))
def test_no_cell_is_a_formula_and_all_come_back(rows: list[list[str]]) -> None:
    found = list(csv.reader(io.StringIO(format_rows([[*row, "end"] for row in rows]), newline="")))
    assert not any(formula(one) for row in found for one in row)
    assert [[restore_cell(one) for one in row[:-1]] for row in found] == rows


@given(texts)
def test_no_piece_of_a_comment_is_a_formula_and_it_comes_back(text: str) -> None:
    line = comment(text)
    for mark in ",;\t":
        for one in csv.reader([line], delimiter=mark):
            assert not any(map(formula, one))
    assert restore_comment(line) == "# " + " ".join(text.splitlines())


def test_a_number_in_a_comment_is_no_formula() -> None:
    assert comment("size: 3,-2;+3.5e-4;-inf,.5") == "# size: 3,-2;+3.5e-4;-inf,.5"


@given(st.floats())
def test_numbers_stay_numbers(value: float) -> None:
    (row,) = csv.reader(io.StringIO(format_rows([[value, repr(value), None]])))
    assert row == [repr(value), repr(value), ""]


@pytest.mark.parametrize("name", WORST)
def test_the_numbers_of_a_report(name: str) -> None:
    number = Number(quantity=f"file {name}", value=-1.5, unit="N", source=name)
    head, row = csv.reader(io.StringIO(format_numbers([number]), newline=""))
    assert tuple(head) == tuple(COLUMNS)
    assert not any(map(formula, row))
    cells = dict(zip(head, row, strict=True))
    assert restore_cell(cells["source"]) == name
    assert float(cells["value"]) == -1.5


def test_a_brake_above_a_simulation_comes_back_to_the_letter(tmp_path: Path) -> None:
    text = load("choi2018-kapton").text
    one = 'source = "Choi 2018, section III-D, one pull at 94.5 kPa and 13 mm/s"'
    assert one in text
    bad = text.replace(one, "source = \"x,=cmd|' /C calc'!A0;@SUM(1),-2+3,-2\"")
    file = BrakeFile.read(bad, "bad.toml")
    some = np.linspace(0, 1, 12)
    record = PullRecord(
        outcome=Outcome.FINISHED, brake=file, time=some, elongation=some, force=some, slip=some
    )
    path = record.to_csv(tmp_path / "pull.csv")
    lines = path.read_text(encoding="utf-8").splitlines()
    for mark in ",;\t":
        assert not any(formula(c) for row in csv.reader(lines, delimiter=mark) for c in row)
    procedure = ["# procedure: pull at 1 mm/s until 20 mm", *lines[1:]]
    path.write_text("\n".join([lines[0], *procedure, ""]), encoding="utf-8")
    again, _ = read_header(path)
    assert again.text == file.render(file.name)
    cited = [c.key for c in read_content(path).cited]
    assert cited == [BrakeFile.read(file.render(file.name), "x").sha256]


def test_a_list_of_conditions_names_such_a_file(tmp_path: Path) -> None:
    u = np.linspace(0, 0.02, 60)
    trace = Trace(9e3 * u * (1 - 20 * u), u, u / 1e-3, "", "", facts=Facts(seed=1, repeat=1))
    path = tmp_path / "=1+1.csv"
    path.write_bytes(encode_file(trace, Form()))
    rows = [["file", "vacuum"], [path.name, "60 kPa"]]
    (tmp_path / LIST).write_text(format_rows(rows), encoding="utf-8")
    assert read_trace(path).facts.vacuum == 60e3


def test_every_writer_of_rows_is_this_one() -> None:
    """No module of ours makes CSV rows of its own."""
    source = Path(load.__code__.co_filename).parents[1]
    own = {
        p.relative_to(source).as_posix()
        for p in source.rglob("*.py")
        if "csv.writer" in p.read_text(encoding="utf-8")
    }
    assert own == set()
