"""A vacuum over time from a file, as a pump's log or a spreadsheet holds it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from layerjam.errors import FileError, UnknownNameError
from layerjam.measure.log import PRESSURE, TIME, pressure_says, read_log
from layerjam.simulate.vacuum_history import History
from layerjam.units import show

READINGS = ("absolute", "gauge", "vacuum")
"""What a pressure may count from: nothing, the atmosphere upwards, the atmosphere downwards."""


def read_history(
    path: str | Path,
    atmosphere: float,
    reading: str | None = None,
    columns: str | None = None,
    decimal: str | None = None,
) -> History:
    """The history in a log such as ``time [s],vacuum [kPa]``, read as every other log is.

    What the pressure counts from, its column says (vacuum, absolute pressure, gauge pressure) or
    `reading` does: absolute, gauge (over the atmosphere) or vacuum (below it). `columns` and
    `decimal` are as `read_log` takes them. Raises FileError where neither says so, for what is no
    such log, where time does not rise, or the vacuum leaves 0 to `atmosphere` [Pa].
    """
    if reading is not None and reading not in READINGS:
        raise UnknownNameError("reading", reading, READINGS)
    log = read_log(path, (TIME, PRESSURE), columns, decimal)
    said = log.said["pressure"]
    kind = reading or pressure_says(said)
    if kind is None:
        raise FileError(
            path,
            f"does not say what '{said.name[:60]}' counts from: name the column vacuum, or give "
            "--reading absolute, gauge (over the atmosphere) or vacuum (below it)",
        )
    time, pressure = log["time"], log["pressure"]
    vacuum = {"absolute": atmosphere - pressure, "gauge": -pressure, "vacuum": pressure}[kind]
    step = np.diff(time)
    if (step <= 0).any():
        bad = int(np.argmax(step <= 0)) + 1
        raise FileError(
            path, f"time does not rise: {show(time[bad], 's')} after {show(time[bad - 1], 's')}"
        )
    wrong = (vacuum < 0) | (vacuum > atmosphere)
    if wrong.any():
        bad = int(np.argmax(wrong))
        raise FileError(
            path,
            f"vacuum {show(float(vacuum[bad]), 'Pa')} at {show(time[bad], 's')} is not allowed; it "
            f"lies between 0 and the atmosphere of {show(atmosphere, 'Pa')}"
            + ("" if kind == "vacuum" else f" (its pressure is read as {kind})"),
        )
    return History(time, vacuum)
