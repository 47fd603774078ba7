"""The unit of a force that a file gives as a mass, and units that gainsay the file's."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from laboratory.measure.layouts import curve, rows
from layerjam.core.errors import FileError
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.read import read_trace

FORCE = np.array(curve()[2])


def write(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "x.csv"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return path


NEWTONS = {  # of one unit, from the definition of the pound, and of gravity, exactly
    "g": 9.80665e-3,
    "kg": 9.80665,
    "oz": 0.45359237 / 16 * 9.80665,
    "lbs": 0.45359237 * 9.80665,
}
HEADS = {
    "bracket": "Time (s),Extension (mm),Load ({})",
    "row": "Time,Extension,Load\ns,mm,{}",
    "word": "Time (s),Extension (mm),Load {}",
    "after a comma": 'Time (s),Extension (mm),"Load, {}"',
    "slash": "Time (s),Extension (mm),Load / {}",
    "stated": "Force unit: {}\nTime (s),Extension (mm),Load",
    "no name of a force": "Time (s),Extension (mm),Sample [{}]",
}


@pytest.mark.parametrize("unit", NEWTONS)
@pytest.mark.parametrize("head", HEADS)
def test_the_hint_for_a_mass_leads_to_the_right_force(head: str, unit: str, tmp_path: Path) -> None:
    path = write(tmp_path, HEADS[head].format(unit), *rows())
    with pytest.raises(FileError, match="a unit of mass") as err:
        read_trace(path)
    advice = re.search(r"--columns (force:\w+)=(\w+)\)", str(err.value))
    assert advice is not None
    trace = read_trace(path, ReadingOptions(column=[f"{advice[1]}={advice[2]}"]))
    np.testing.assert_allclose(trace.force, FORCE * NEWTONS[unit], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(
    ("written", "said"),
    [("g", "kgf"), ("g", "N"), ("oz", "gf"), ("lb", "kgf"), ("N", "kN"), ("MPa", "N"), ("mm", "N")],
)
def test_a_unit_that_gainsays_the_file_is_refused(written: str, said: str, tmp_path: Path) -> None:
    path = write(tmp_path, f"Time (s),Extension (mm),Load ({written})", *rows())
    with pytest.raises(FileError, match=f"is in '{written}'.*, not in '{said}' as given"):
        read_trace(path, ReadingOptions(column=[f"force:{said}=Load"]))
    # whoever lists the columns says that the file is wrong, and is told so
    trace = read_trace(path, ReadingOptions(columns=f"time:s,elongation:mm,force:{said}"))
    assert any("the given unit takes precedence" in w for w in trace.warnings)


@pytest.mark.parametrize(("written", "said"), [("N", "newton"), ("lb", "lbf"), ("raw", "kN")])
def test_a_unit_that_agrees_or_that_nobody_knows_is_taken(
    written: str, said: str, tmp_path: Path
) -> None:
    path = write(tmp_path, f"Time (s),Extension (mm),Load ({written})", *rows())
    read_trace(path, ReadingOptions(column=[f"force:{said}=Load"]))
    if written == "raw":
        notes = read_trace(path, ReadingOptions(column=[f"force:{said}=Load"])).understood
        assert "the unit of column 'Load', 'raw', is unknown: kN is used" in notes
        with pytest.raises(FileError, match=r"\(specify it: --columns force:N=Load\)"):
            read_trace(path)


@pytest.mark.parametrize("word", ["gf", "grams-force", "gram force", "Grams-Force", "gmf", "pond"])
def test_grams_force_and_its_like_are_known(word: str, tmp_path: Path) -> None:
    path = write(tmp_path, f"Time (s),Extension (mm),Load ({word})", *rows())
    np.testing.assert_allclose(read_trace(path).force, FORCE * 9.80665e-3, rtol=1e-4, atol=1e-5)


def test_a_unit_in_the_name_and_in_the_row_below_is_no_part_of_the_name(tmp_path: Path) -> None:
    head = ["Time (s),Extension (mm),Load (N)", "s,mm,N"]
    trace = read_trace(write(tmp_path, *head, *rows()))
    assert "force is the column 'Load' in N" in trace.understood
    np.testing.assert_allclose(trace.force, FORCE, atol=1e-4)
    named = ReadingOptions(column=["force=Load"])
    assert (
        "force is the column 'Load' in N, as given"
        in read_trace(tmp_path / "x.csv", named).understood
    )
