"""Each kind of bad input gets one plain sentence that names the file and the line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from laboratory.measure.layouts import bluehill, named, own, rows
from laboratory.measure.layouts import testxpert as zwick
from layerjam.core.errors import FileError
from layerjam.laboratory.measure.readers import source
from layerjam.laboratory.measure.readers.read import read_trace

HEAD = "Time (s),Extension (mm),Load (N)"


def table(*body: str, head: str = HEAD, end: str = "\n") -> str:
    return "\n".join([head, *body]) + end


def with_row(index: int, row: str) -> str:
    body = rows()
    body[index] = row
    return table(*body)


CUT = bluehill().rstrip("\n")
CASES: dict[str, tuple[bytes | str, str, int | None]] = {
    "empty": ("", "is empty", None),
    "only blanks": (" \n\n", "is empty", None),
    "only a byte-order mark": (b"\xef\xbb\xbf", "is empty", None),
    "header only": (HEAD + "\n", "contains column names but no rows of numbers", 1),
    "header only, no line end": (HEAD, "contains column names but no rows of numbers", 1),
    "header only, own": (own(0), "contains column names but no rows of numbers", 5),
    "header only, Zwick": (zwick(0), "contains column names but no rows of numbers", 5),
    "comments only": ("# layerjam 1\n# x\n", "contains a header but no column names", None),
    "cut off: a field missing": (CUT[: CUT.rindex(",")], "cut off", 69),
    "cut off: within quotes": (CUT[:-2], "cut off", 69),
    "cut off: within a number": (named()[:-3], "the last line is cut off in its last", 61),
    "cut off: after a separator": (named()[: named().rindex(",") + 1], "cut off", 61),
    "a short row": (with_row(7, "1,2"), "has 2 values instead of 3", 9),
    "a long row": (with_row(7, "1,2,3,4"), "has 4 values instead of 3", 9),
    "decimal commas between commas": (
        table(*("0,1,0,2,3,4" for _ in range(20))),
        "decimal commas need a column separator",
        2,
    ),
    "two specimens": (table(*rows(), "", HEAD, *rows()), "contains 2 specimens", None),
    "words among the numbers": (
        table(*rows(), "no numbers here,or here,", *rows()),
        "is not a row of numbers, and rows of numbers without names follow it",
        62,
    ),
    "names among the numbers": (
        "\n".join([*rows(), HEAD, *rows(), ""]),
        "has 60 rows of numbers above its column names",
        1,
    ),
    "two specimens side by side": (
        table(*(f"{r},{r}" for r in rows()), head=f"{HEAD},{HEAD}"),
        "contains 2 specimens ('1', '2'); choose one (--specimen 1)",
        None,
    ),
    "no known format": ("hello\nworld\n", "is not in a known format; tried layerjam CSV (", None),
    "numbers without header": (
        table(*rows(), head=""),
        "3 columns of numbers without names; specify each one, in order, such as --columns time:s,",
        None,
    ),
    "no force": (
        table(*rows(), head="Time (s),Extension (mm),Torque (N·m)"),
        "has no column with a unit of force ('N', 'kN' or 'lbf'); its columns are 'Time' [s]",
        1,
    ),
    "no elongation": (
        table(*rows(), head="Time (s),Strain (%),Load (N)"),
        "contains force and time but no elongation",
        1,
    ),
    "no unit": (
        table(*rows(), head="Time (s),Extension (mm),Load"),
        "column 'Load' has no unit; force needs a unit such as 'N', 'kN' or 'lbf'",
        1,
    ),
    "no units at all": (
        table(*rows(), head="Time,Extension,Load"),
        "column 'Extension' has no unit",
        1,
    ),
    "no units, Zwick": (
        zwick().replace('"s","mm","N","mm"\n', ""),
        "column 'Traverse absolue' has no unit",
        5,
    ),
    "wrong dimension": (
        table(*rows(), head="Time (s),Extension (mm),Load (mm)"),
        "column 'Load' is in 'mm', which is not a unit of force",
        1,
    ),
    "a mass as force": (
        table(*rows(), head="Time (s),Extension (mm),Load (kg)"),
        "column 'Load' is in 'kg', which is not a unit of force",
        1,
    ),
    "wrong dimension, own": (
        own().replace("force [N]", "force [mm]"),
        "column 'force' is in 'mm', which is not a unit of force",
        5,
    ),
    "column missing, own": (
        own().replace(",force [N]", ",kraft [N]"),
        "has no column 'force'; its columns are 'time' [s], 'elongation' [m], 'kraft' [N]",
        5,
    ),
    "two forces": (
        table(*(f"{r},1" for r in rows()), head=f"{HEAD},Force (N)"),
        "does not state which column is the force: 'Load' or 'Force'",
        1,
    ),
    "a word": (with_row(30, "0.3,3.9,abc"), "'abc' in column 'Load' is not a finite number", 32),
    "NaN": (with_row(30, "0.3,NaN,95"), "'NaN' in column 'Extension' is not a finite number", 32),
    "NaN in the first row": (with_row(0, "0,0,NaN"), "is not a finite number", 2),
    "infinite": (with_row(30, "0.3,3.9,inf"), "'inf' in column 'Load' is not a finite number", 32),
    "overflow": (with_row(30, "0.3,3.9,1e999"), "'1e999' in column 'Load' is not a finite", 32),
    "True": (with_row(30, "0.3,3.9,True"), "'True' in column 'Load' is not a finite number", 32),
    "an empty cell": (with_row(30, "0.3,,95"), "column 'Extension' is empty", 32),
    "a stray quote": (with_row(30, '0.3,3.9,9"5'), "a quote is not closed", 32),
    "no such force": (with_row(30, "0.3,3.9,1e200"), "is beyond the range of any test machine", 32),
    "time backwards": (with_row(30, "0.1,3.9,95"), "time runs backwards, from 0.29 s to 0.1 s", 32),
    "time backwards after a blank line": (
        with_row(30, "\n0.1,3.9,95"),
        "time runs backwards",
        33,
    ),
    "too short": (table(*rows(9)), "contains 9 rows of numbers; at least 10 are needed", None),
    "force never changes": (
        table(*(f"{i},{i},5.0" for i in range(50))),
        "the force is 5 N in every row",
        None,
    ),
    "crosshead never moves": (
        table(*(f"{i},5.0,{i}" for i in range(50))),
        "the elongation never changes",
        None,
    ),
    "binary": (bytes(range(256)) * 20, "is binary", None),
    "binary later on": (table(*rows()).encode() + b"\0" * 50, "is binary", None),
    "Excel": (b"PK\x03\x04" + b"x" * 99, "is an Excel workbook or zip archive", None),
    "half of UTF-16": (named().encode("utf-16")[:-1], "its UTF-16 text ends early", None),
    "a line of a megabyte": ("x" * 1_000_000, "has a line of 1000000 bytes", 1),
}


@pytest.mark.parametrize("case", CASES)
def test_one_plain_sentence(case: str, tmp_path: Path) -> None:
    data, sentence, line = CASES[case]
    path = tmp_path / "bad.csv"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(FileError) as err:
        read_trace(path)
    text = str(err.value)
    assert sentence in text and text.startswith(str(path)) and "\n" not in text
    assert err.value.line == line


def test_no_format_says_what_was_tried(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("hello\n")
    with pytest.raises(FileError) as err:
        read_trace(path)
    for name in ("layerjam CSV (", "Zwick testXpert", "Instron Bluehill", "MTS", "Shimadzu"):
        assert name in str(err.value)


def test_no_file_at_all(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="does not exist"):
        read_trace(tmp_path / "none.csv")
    for folder in (tmp_path, ".", "..", "/"):
        with pytest.raises(FileError, match="is a folder"):
            read_trace(folder)
    with pytest.raises(FileError, match="is an empty name; specify a file"):
        read_trace("")
    for odd in ("a\0b", "x" * 5000):
        with pytest.raises(FileError):
            read_trace(odd)


def test_too_large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "large.csv"
    with path.open("wb") as handle:
        handle.truncate(source.MAX_BYTES + 1)  # a hole, it takes no room
    with pytest.raises(FileError, match="is 1.0 GB; at most 1 GB can be read"):
        read_trace(path)


@pytest.mark.parametrize("noise", [0.0, 0.05, 2.0])
def test_saturated_load_cell(noise: float, tmp_path: Path) -> None:
    travel = np.linspace(0, 40, 2000)
    force = np.minimum(100 * travel, 175 - 2 * travel) + np.random.default_rng(1).normal(
        0, noise, 2000
    )
    force = np.minimum(force, 150.0)
    path = tmp_path / "saturated.csv"
    body = [f"{x:.4f},{f:.3f}" for x, f in zip(travel, force, strict=True)]
    path.write_text("\n".join(["Extension (mm),Load (N)", *body, ""]))
    with pytest.raises(FileError, match="the load cell was saturated: .* at exactly 150 N"):
        read_trace(path)
