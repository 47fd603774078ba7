"""Vacuum versus time from a file, such as a pump log or a spreadsheet."""

from pathlib import Path

import numpy as np

from layerjam.brake.simulate.vacuum_history import History
from layerjam.core.command.log_options import LogOptions
from layerjam.core.errors import FileError, FitError
from layerjam.core.units import show
from layerjam.laboratory.measure.log import PRESSURE, TIME, read_log
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.pressure import read_absolute
from layerjam.laboratory.measure.trace import Array


def read_history(
    path: str | Path, atmosphere: float, options: ReadingOptions | LogOptions | None = None
) -> History:
    """Read the history from a log such as ``time [s],vacuum [kPa]``, like any other log.

    The column's name (vacuum, absolute pressure, gauge pressure) or `options.reading` states the
    reference of the pressure. Raises FileError if neither does, if the file is not such a log, if
    time does not increase, or if the vacuum is not within 0 to `atmosphere` [Pa].
    """
    log = read_log(path, (TIME, PRESSURE), options)
    time = log["time"]

    def check_range(absolute: Array) -> None:
        vacuum = atmosphere - absolute
        wrong = (vacuum < 0) | (vacuum > atmosphere)
        if wrong.any():
            first = int(np.argmax(wrong))
            raise FitError(
                f"vacuum {show(float(vacuum[first]), 'Pa')} at {show(time[first], 's')} is not "
                f"between 0 and atmospheric pressure, {show(atmosphere, 'Pa')}"
            )

    read = read_absolute(log, options.reading if options else None, atmosphere, test=check_range)
    step = np.diff(time)
    if (step <= 0).any():
        bad = int(np.argmax(step <= 0)) + 1
        raise FileError(
            path, f"time does not increase: {show(time[bad], 's')} after {show(time[bad - 1], 's')}"
        )
    return History(time, read.vacuum)
