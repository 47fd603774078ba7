"""Vacuum versus time from a file, such as a pump log or a spreadsheet."""

from pathlib import Path

import numpy as np

from layerjam.errors import FileError
from layerjam.measure.log import PRESSURE, TIME, read_log
from layerjam.measure.options import ReadingOptions
from layerjam.simulate.vacuum_history import History
from layerjam.units import show


def read_history(
    path: str | Path, atmosphere: float, options: ReadingOptions | None = None
) -> History:
    """Read the history from a log such as ``time [s],vacuum [kPa]``, like any other log.

    The column's name (vacuum, absolute pressure, gauge pressure) or `options.reading` states the
    reference of the pressure. Raises FileError if neither does, if the file is not such a log, if
    time does not increase, or if the vacuum is not within 0 to `atmosphere` [Pa].
    """
    log = read_log(path, (TIME, PRESSURE), options)
    kind, _ = log.pressure_reference(options.reading if options else None)
    time, pressure = log["time"], log["pressure"]
    vacuum = {"absolute": atmosphere - pressure, "gauge": -pressure, "vacuum": pressure}[kind]
    step = np.diff(time)
    if (step <= 0).any():
        bad = int(np.argmax(step <= 0)) + 1
        raise FileError(
            path, f"time does not increase: {show(time[bad], 's')} after {show(time[bad - 1], 's')}"
        )
    wrong = (vacuum < 0) | (vacuum > atmosphere)
    if wrong.any():
        bad = int(np.argmax(wrong))
        raise FileError(
            path,
            f"vacuum {show(float(vacuum[bad]), 'Pa')} at {show(time[bad], 's')} is not allowed; it "
            f"must be between 0 and atmospheric pressure, {show(atmosphere, 'Pa')}"
            + ("" if kind == "vacuum" else f" (its pressure column was read as {kind})"),
        )
    return History(time, vacuum)
