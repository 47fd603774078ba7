"""Layouts that one kind of machine or program writes, each as that program lays it out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from laboratory.measure.test_specimens import xlsx
from layerjam.core.errors import FileError
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.read import open_traces, read_trace, read_traces

GRAM = 9.80665e-3
COUNT = 60
TIME = np.arange(COUNT) * 0.05
TRAVEL = 0.65 * np.arange(COUNT)  # mm
FORCE = np.minimum(40.0 * TRAVEL, 170 - 2 * TRAVEL)  # N
ROWS = list(zip(TIME, TRAVEL, FORCE, strict=True))


def mts(blocks: int, restart: bool = False, cycles: bool = False) -> str:
    """An MPT file: the names stand anew over each block of the same test."""
    lines = ["MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A", ""]
    size = COUNT // blocks
    for k in range(blocks):
        if cycles:
            lines += [f"Stored at:\t{k + 1}\tcycle", ""]
        else:
            lines += [f"Data Acquisition: Timed\t\t\tTime:\t{k}.5\tSec\t11/13/2018 10:05:0{k} AM"]
        lines += ["Axial Displacement\tAxial Force\tTime", "mm\tkN\tSec"]
        for t, u, f in ROWS[k * size : (k + 1) * size]:
            lines += [f"{u:.6f}\t{f / 1000:.7f}\t{t - restart * ROWS[k * size][0]:.5f}"]
        lines += [""]
    return "\r\n".join(lines)


def lvm(x_columns: str = "One", units: bool = True, comma: bool = False) -> str:
    mark = "," if comma else "\t"
    top = ["LabVIEW Measurement", "Writer_Version,2", f"Separator,{'Comma' if comma else 'Tab'}"]
    top += [f"X_Columns,{x_columns}", "Date,2018/11/13", "Time,10:05:01.7", "***End_of_Header***"]
    head = ["Channels,2", f"Samples,{COUNT},{COUNT}", "Time,10:05:01.7,10:05:01.7"]
    head += ["Y_Unit_Label,Newton,Millimeter"] if units else []
    head += ["X_Dimension,Time,Time", "X0,0.0E+0,0.0E+0", "Delta_X,0.05,0.05"]
    head += ["***End_of_Header***", "X_Value,Force,Displacement,Comment"]
    lines = [line.replace(",", mark) for line in [*top, "", *head]]
    for t, u, f in ROWS:
        start = "" if x_columns == "No" else f"{t:.6f}"
        lines.append(mark.join((start, f"{f:.6f}", f"{u:.6f}")))
    return "\n".join(lines) + "\n"


def texture(rows: bool) -> str:
    head = ["Time,Distance,Force", "sec,mm,g"] if rows else ["Force (g)\tDistance (mm)\tTime (sec)"]
    body = [
        f"{t:.3f},{u:.5f},{f / GRAM:.4f}" if rows else f"{f / GRAM:.4f}\t{u:.5f}\t{t:.3f}"
        for t, u, f in ROWS
    ]
    return "\n".join([*head, *body, ""])


def monitor(head: str, row: Callable[[float, float, float], str], stamped: bool) -> str:
    lines = [head, *(row(t, u, f) for t, u, f in ROWS)]
    clock = [f"12:34:{5 + 0.05 * k:06.3f} -> " if stamped else "" for k in range(len(lines))]
    return "\r\n".join(stamp + line for stamp, line in zip(clock, lines, strict=True)) + "\r\n"


def in_grams(t: float, u: float, f: float) -> str:
    return f"{1000 * t:.0f},{f / GRAM:.4f},{u:.5f}"


def lloyd() -> str:
    head = '"NEXYGENPlus","4.1"\n"Load (N)","Machine Extension (mm)","Extension from Preload (mm)"'
    return "\n".join([head, *(f"{f:.5f},{u + 3.2:.5f},{u:.5f}" for _, u, f in ROWS), ""])


FILES = {
    "MTS 793, timed blocks": mts(4),
    "MTS 793, cycles": mts(3, cycles=True),
    "LabVIEW": lvm(),
    "LabVIEW with commas": lvm(comma=True),
    "LabVIEW without times": lvm("No"),
    "TA.XT, units below": texture(True),
    "TA.XT, units in the names": texture(False),
    "serial monitor, millis": monitor("millis,grams,mm", in_grams, stamped=False),
    "serial monitor with stamps": monitor("millis,grams,mm", in_grams, stamped=True),
    "comma and tab": monitor(
        "time_ms,\tforce_N,\tposition_mm",
        lambda t, u, f: f"{1000 * t:.0f},\t{f:.5f},\t{u:.5f}",
        stamped=False,
    ),
    "Lloyd": lloyd(),
}


@pytest.mark.parametrize("name", FILES)
def test_every_machine_gives_the_curve(name: str, tmp_path: Path) -> None:
    path = tmp_path / "x.dat"
    path.write_bytes(FILES[name].encode())
    trace = read_trace(path)
    np.testing.assert_allclose(trace.elongation, TRAVEL / 1000, atol=2e-8, rtol=0)
    np.testing.assert_allclose(trace.force, FORCE, atol=1.1e-4, rtol=0)
    if name != "Lloyd":
        assert trace.time is not None
        np.testing.assert_allclose(trace.time, TIME, atol=1e-9)


def test_an_error_names_the_line_of_the_users_file(tmp_path: Path) -> None:
    for text in (mts(4), lvm(), monitor("millis,grams,mm", in_grams, stamped=True)):
        lines = text.splitlines()
        path = tmp_path / "x.txt"
        row = len(lines) - 5
        lines[row] = lines[row][:-3] + "x.y"
        path.write_text("\n".join([*lines, ""]), encoding="utf-8")
        with pytest.raises(FileError) as err:
            read_trace(path)
        assert err.value.line == row + 1


def test_tests_of_one_mts_file_whose_time_starts_anew_stay_apart(tmp_path: Path) -> None:
    path = tmp_path / "x.dat"
    path.write_text(mts(3, restart=True).replace("Data Acquisition: Timed", "Specimen"))
    assert len(open_traces(path)) == 3


def test_a_labview_file_without_units_asks_for_them(tmp_path: Path) -> None:
    path = tmp_path / "x.lvm"
    path.write_text(lvm(units=False), encoding="utf-8")
    with pytest.raises(FileError, match="'Displacement' has no unit"):
        read_trace(path)
    said = ReadingOptions(column=("force:N=Force", "elongation:mm=Displacement"))
    np.testing.assert_allclose(read_trace(path, said).force, FORCE, atol=1e-5)


@pytest.mark.parametrize("sheet", ["Ergebnisse", "Results", "Statistik"])
def test_the_sheet_of_results_is_no_curve(sheet: str, tmp_path: Path) -> None:
    results = [["Weg bei Fmax [mm]", "Fmax [N]", "Weg [mm]", "Kraft [N]"]]
    results += [[1.0 + k, 170.0 + k, 2.0 + k, 160.0 - k] for k in range(12)]
    curve = [["Weg [mm]", "Kraft [N]"], *([float(u), float(f)] for _, u, f in ROWS)]
    path = xlsx(tmp_path / "x.xlsx", {sheet: results, "Probe 1": curve, "Probe 2": curve})
    found = read_traces(path)
    assert [trace.specimen for trace in found] == ["Probe 1", "Probe 2"]
    np.testing.assert_allclose(found[0].force, FORCE, atol=1e-9)
    alone = read_trace(path, ReadingOptions(sheet="Probe 2"))
    np.testing.assert_allclose(alone.force, FORCE, atol=1e-9)
