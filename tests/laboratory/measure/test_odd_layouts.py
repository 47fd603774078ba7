"""Clock time, numbered heads of batches, and damaged rows in files of every decimal sign."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.read import read_trace, read_traces

TIME = np.arange(0, 3, 0.1)
FORCE = 30 * (1 - np.exp(-2 * TIME))


def clock(second: float) -> str:
    """The clock at 00:53:18 and some seconds."""
    minute, rest = divmod(53 * 60 + 18 + second, 60)
    return f"00:{int(minute):02d}:{rest:06.3f}"


def written(path: Path, head: str, rows: list[list[str]], mark: str) -> Path:
    path.write_text("\n".join([head, *(mark.join(row) for row in rows)]) + "\n")
    return path


@pytest.mark.parametrize(
    ("mark", "comma"), [(",", False), (";", False), ("\t", False), (";", True), ("\t", True)]
)
def test_clock_time_is_read(tmp_path: Path, mark: str, comma: bool) -> None:
    rows = [[clock(t), f"{f:.4f}"] for t, f in zip(TIME, FORCE, strict=True)]
    if comma:
        rows = [[cell.replace(".", ",") for cell in row] for row in rows]
    path = written(tmp_path / "log.csv", mark.join(["Time", "Force (N)"]), rows, mark)
    trace = read_trace(path, ReadingOptions(speed=0.013))
    assert trace.time is not None
    assert trace.time == pytest.approx(53 * 60 + 18 + TIME, abs=1e-9)
    assert trace.elongation == pytest.approx(0.013 * TIME, abs=1e-12)
    assert trace.force == pytest.approx(FORCE, abs=1e-4)
    assert "time is the column 'Time' in hh:mm:ss" in trace.understood
    with pytest.raises(FileError, match=r"hh:mm:ss.*--speed 10mm/min"):
        read_trace(path)


def test_clock_time_beside_an_elongation(tmp_path: Path) -> None:
    rows = [[clock(t), f"{13 * t:.4f}", f"{f:.4f}"] for t, f in zip(TIME, FORCE, strict=True)]
    path = written(tmp_path / "pull.csv", "Time;Weg (mm);Kraft (N)", rows, ";")
    trace = read_trace(path)
    assert trace.time == pytest.approx(53 * 60 + 18 + TIME, abs=1e-9)
    rows[12][0] = "00:53:61.000"
    path = written(tmp_path / "bad.csv", "Time;Weg (mm);Kraft (N)", rows, ";")
    with pytest.raises(FileError, match="line 14: '00:53:61.000'"):
        read_trace(path)


@pytest.mark.parametrize("quote", ["", '"'])
@pytest.mark.parametrize("gap", [[], [""]])
@pytest.mark.parametrize("numbers", [(1, 2, 3), (4, 7, 12)])
def test_a_batch_whose_heads_number_the_specimens(
    tmp_path: Path, quote: str, gap: list[str], numbers: tuple[int, ...]
) -> None:
    lines = []
    for number in numbers:
        lines += [f"{number},Time,Displacement,Force", ",(s),(mm),(N)"]
        for t, f in zip(TIME, FORCE, strict=True):
            cells = (f"{t:.2f}", f"{13 * t:.4f}", f"{number * f:.4f}")
            lines.append("," + ",".join(f"{quote}{cell}{quote}" for cell in cells))
        lines += gap
    path = tmp_path / "batch.csv"
    path.write_text("\n".join(lines) + "\n")
    found = read_traces(path)
    assert [one.specimen for one in found] == [str(number) for number in numbers]
    for number, one in zip(numbers, found, strict=True):
        assert one.force == pytest.approx(number * FORCE, abs=1e-4)
        assert one.elongation == pytest.approx(0.013 * TIME, abs=1e-7)


DAMAGE = {
    "a sign": lambda row: [*row[:2], row[2][:1] + "#" + row[2][1:]],
    "a letter": lambda row: [row[0], "x" + row[1], row[2]],
    "an empty cell": lambda row: [*row[:2], ""],
    "a cell less": lambda row: row[:2],
    "a cell more": lambda row: [*row, "99"],
    "words": lambda row: ["connection lost"],
    "two signs": lambda row: [*row[:2], row[2] + row[2]],
}


@pytest.mark.parametrize("place", [3, 15, 29])
@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize(("mark", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", ",")])
def test_the_damaged_line_is_named(
    tmp_path: Path, mark: str, decimal: str, damage: str, place: int
) -> None:
    rows = [[f"{t:.2f}", f"{13 * t:.4f}", f"{f:.4f}"] for t, f in zip(TIME, FORCE, strict=True)]
    rows = [[cell.replace(".", decimal) for cell in row] for row in rows]
    rows[place] = DAMAGE[damage](rows[place])
    head = mark.join(["Time (s)", "Extension (mm)", "Load (N)"])
    path = written(tmp_path / "pull.csv", head, rows, mark)
    try:
        trace = read_trace(path)
    except FileError as error:
        assert error.line == place + 2, str(error)
    else:  # words below the last row are a footer, and a warning says so
        assert (damage, place) == ("words", 29) and any("line 31" in w for w in trace.warnings)
