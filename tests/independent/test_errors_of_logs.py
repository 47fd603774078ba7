"""Errors of logs name the file, the column and the cause, also if several files are given."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from independent import field_files as made
from independent.chamber import Chamber
from layerjam.core.errors import FileError, QuantityError

HEAD = "Time (s),Gauge pressure (kPa)"
CELL = 29
"""Row of the damaged cell; the header is line 1."""


def pressures(start: int = 0, end: int | None = None) -> tuple[Any, Any]:
    time, reading = Chamber(held=60.0).record(1)
    return time[start:end], reading[start:end]


def with_cell(text: str) -> Callable[[Path], Path]:
    def write(path: Path) -> Path:
        time, reading = pressures()
        lines = [HEAD, *(f"{t:.1f},{p:.4f}" for t, p in zip(time, reading, strict=True))]
        lines[CELL + 1] = f"{time[CELL]:.1f},{text}"
        return made.write(path, lines)

    return write


def table(*columns: Any, head: str = HEAD) -> Callable[[Path], Path]:
    return lambda path: made.csv(path, head, *columns, form="%.5g")


def shaken(values: Any) -> Any:
    time, signal = made.impact()
    return table(time[values], signal[values], head="Time (s),Acceleration (g)")


TIME, READING = pressures()
CASES: dict[str, tuple[Callable[..., Any], dict[str, Any], Callable[[Path], Path], str]] = {
    "text": (lj.leak, {}, with_cell("abc"), "line 31: 'abc' in column 'Gauge pressure'"),
    "no number": (lj.leak, {}, with_cell("nan"), "line 31: 'nan' in column 'Gauge pressure'"),
    "empty": (lj.leak, {}, with_cell(""), "line 31: column 'Gauge pressure' is empty"),
    "overflow": (lj.leak, {}, with_cell("1e999"), "line 31: '1e999' in column 'Gauge pressure'"),
    "backwards": (
        lj.leak, {}, table(np.r_[TIME[:50], TIME[20:]], np.r_[READING[:50], READING[20:]]),
        "line 52: time runs backwards in column 'Time', from 4.9 s to 2 s",
    ),
    "one time": (lj.leak, {}, table(0 * TIME, READING), "never increases, in column 'Time'"),
    "few": (lj.leak, {}, table(*pressures(-10)), "column 'Gauge pressure': .* only 10 samples"),
    "window": (
        lj.leak, {"start": "60 s", "end": "60.4 s"}, table(TIME, READING),
        "column 'Gauge pressure': only 5 samples lie between 60 s and 60.4 s; a hold needs 20",
    ),
    "crosses": (
        lj.leak, {}, table(TIME, np.linspace(-50, 50, len(TIME))),
        "column 'Gauge pressure': the log crosses atmospheric pressure",
    ),
    "flat": (lj.leak, {}, table(TIME, 0 * TIME), "column 'Gauge pressure' cannot be read as gauge"),
    "rising": (
        lj.pump_down, {}, table(*pressures(150)),
        "column 'Gauge pressure': its absolute pressure rises by",
    ),
    "short impact": (lj.crash, {}, shaken(slice(15)), "at least 20 samples; there are 15"),
    "slow impact": (lj.crash, {}, shaken(slice(None, None, 10)), "its sampling rate of 1000 Hz"),
    "no rest": (
        lj.crash, {"before": "100 us"}, shaken(slice(None)),
        "the first 0.1 ms contains 1 sample; the part before the event needs at least 5",
    ),
    "other quantity": (
        lj.leak, {}, table(TIME, READING, head="Time (s),Load (N)"),
        r"line 1: has no column with a unit of pressure .* 'Time' \[s\], 'Load' \[N\]",
    ),
}  # fmt: skip
"""{case: (command, options, how the file is written, part of the message)}."""


@pytest.mark.parametrize("name", CASES)
def test_error_names_file_column_and_cause(tmp_path: Path, name: str) -> None:
    command, options, write, words = CASES[name]
    path = write(tmp_path / "log.csv")
    with pytest.raises(FileError, match=rf"^{path}.*{words}"):
        command(path, **options)


def test_error_of_the_second_log_names_it(tmp_path: Path) -> None:
    first = table(*pressures(0, 101))(tmp_path / "one.csv")
    second = table(*pressures(0, 20))(tmp_path / "two.csv")
    with pytest.raises(FileError, match=r"two\.csv: column 'Gauge pressure': the pump-down has"):
        lj.pump_down(first, second, added_volume="1 L")


def test_error_of_a_stated_rate_is_about_the_option(tmp_path: Path) -> None:
    path = shaken(slice(None))(tmp_path / "log.csv")
    with pytest.raises(QuantityError, match=r"^sampling: 1000 Hz is too slow"):
        lj.crash(path, sampling="1 kHz")


def test_every_refused_file_has_its_reason(tmp_path: Path) -> None:
    time, elongation, force = made.pull()
    head = "Time (s),Extension (mm),Load (N)"
    good, still, silent = (
        table(*columns, head=head)(tmp_path / f"{name}.csv")
        for name, columns in (
            ("good", (time, elongation, force)),
            ("still", (time, 0 * time, force)),
            ("silent", (time, elongation, 0 * time)),
        )
    )
    refused = lj.pull([good, still, silent]).refused
    assert set(refused) == {str(still), str(silent)}
    assert "elongation never changes" in refused[str(still)]
    assert "force is 0 N in every row" in refused[str(silent)]
