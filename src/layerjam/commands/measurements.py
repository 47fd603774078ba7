"""`sleeve`, `leak`, `pump_down` and `crash`: what else a laboratory measures of a brake."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from layerjam.commands.answer import Answer, Quantity, si
from layerjam.commands.pressure_log import leak, pump_down
from layerjam.commands.sensor import channel_class
from layerjam.commands.sleeve import sleeve
from layerjam.errors import FileError, FitError
from layerjam.identify.logs import crash as crash_log
from layerjam.measure.log import ACCELERATION, TIME, read_log
from layerjam.measure.options import ReadingOptions
from layerjam.simulate.accelerometer import STANDARD_GRAVITY
from layerjam.units import QuantitySpec

__all__ = ["crash", "leak", "pump_down", "sleeve"]
RANGE = QuantitySpec("m/s^2", "range of the accelerometer", open_lo=True, hi=1e7)
RATE = QuantitySpec("Hz", "sampling rate", lo=1, hi=1e8)
BEFORE = QuantitySpec("s", "time before the event", open_lo=True, hi=1e6)
HIC = QuantitySpec("s", "longest window of the head injury criterion", lo=1e-3, hi=0.1)


def crash(
    file: str | Path,
    *,
    filter: str | None = "cfc180",
    sampling: Quantity | None = None,
    before: Quantity | None = None,
    range: Quantity | None = None,
    falling: bool = False,
    hic: Quantity | None = None,
    columns: str | None = None,
    decimal: str | None = None,
) -> Answer:
    """Peak, filtered peak, velocity change and duration of the greatest pulse of a log.

    `filter` is none, cfc60, cfc180, cfc600 or cfc1000; `before` the length of the quiet part at the
    beginning, `range` the accelerometer's. `falling`: the sensor fell freely before, so the weight
    is taken off the velocity change. `hic` is the longest window of the head injury criterion.
    `record` is the Crash.
    """
    chosen = channel_class(filter)
    rate = None if sampling is None else si(sampling, RATE, "sampling")
    quiet = None if before is None else si(before, BEFORE, "before")
    limit = None if range is None else acceleration_of(range, "range")
    longest = None if hic is None else si(hic, HIC, "hic")
    wants = [ACCELERATION] if rate is not None else [TIME, ACCELERATION]
    log = read_log(file, wants, ReadingOptions(columns=columns, decimal=decimal))
    signal = log["acceleration"]
    clock = log["time"] if rate is None else np.arange(len(signal)) / rate
    try:
        found = crash_log.crash(
            clock, signal, cfc=chosen, sampling=rate, before=quiet, limit=limit, falling=falling,
            hic=longest,
        )  # fmt: skip
    except FitError as error:
        raise FileError(log.path, str(error)) from None
    warnings = list(found.warnings)
    if falling:
        warnings.append(
            "the weight is taken off the velocity change: the sensor fell freely before"
        )
    if longest is not None:
        warnings.append("HIC is defined for the resultant of a head; of one axis it only compares")
    g = STANDARD_GRAVITY
    change = found.velocity_change
    return Answer(
        values={
            "peak": found.peak, "peak_g": found.peak / g, "peak_time": found.peak_time,
            "filtered_peak": found.filtered_peak, "filtered_peak_g": found.filtered_peak / g,
            "filtered_peak_time": found.filtered_peak_time,
            "filter": "none" if chosen is None else f"cfc{chosen}",
            "velocity_change": change, "velocity_change_se": found.velocity_change_se,
            "duration": found.pulse[1] - found.pulse[0], "pulse": list(found.pulse),
            "hic": found.hic, "hic_window": list(found.hic_window) if found.hic_window else None,
            "offset": found.offset, "offset_se": found.offset_se, "quiet": list(found.quiet),
            "sampling": found.rate, "saturated": found.saturated, "samples": len(found.time),
            "understood": list(log.understood),
        },
        units=_CRASH_UNITS,
        warnings=warnings,
        record=found,
    )  # fmt: skip


_CRASH_UNITS = {
    **dict.fromkeys(("peak", "filtered_peak", "offset", "offset_se"), "m/s^2"),
    **dict.fromkeys(("peak_g", "filtered_peak_g", "samples", "hic"), "1"),
    **dict.fromkeys(("peak_time", "filtered_peak_time", "duration", "pulse", "hic_window", "quiet"),
                    "s"),
    **dict.fromkeys(("velocity_change", "velocity_change_se"), "m/s"),
    "sampling": "Hz",
}  # fmt: skip


def acceleration_of(value: Quantity, name: str) -> float:
    """m/s² of "250 g", "2450 m/s^2" or a number of m/s²."""
    if isinstance(value, str):
        match = re.fullmatch(r"\s*(\d{1,9}(?:\.\d{1,9})?)\s*g\s*", value)
        if match:
            return RANGE.check(float(match[1]) * STANDARD_GRAVITY, name)
    return si(value, RANGE, name)
