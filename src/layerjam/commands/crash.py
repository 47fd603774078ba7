"""`crash`: an impact in an accelerometer's log."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from layerjam.commands.declare import Help, Input, command
from layerjam.commands.quantities import si
from layerjam.commands.reading import TableOptions
from layerjam.commands.results import Result, fact, number, result
from layerjam.commands.sensor import SAMPLING, channel_class
from layerjam.errors import FileError, FitError, Notice
from layerjam.measure.log import ACCELERATION, TIME, read_log
from layerjam.simulate.accelerometer import STANDARD_GRAVITY, Accelerometer
from layerjam.units import QuantitySpec, spec_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RANGE = replace(spec_of(Accelerometer, "range"), text="range of the sensor", example="'250 g'")
BEFORE = QuantitySpec("s", "time before the event", open_lo=True, hi=1e6, example="50ms")
HIC = QuantitySpec(
    "s", "longest window of the head injury criterion", lo=1e-3, hi=0.1, example="15ms"
)


def _range(value: Any, _given: Mapping[str, Any]) -> float:
    """m/s^2 of "250 g", "2450 m/s^2" or a number of m/s^2."""
    match = re.fullmatch(r"\s*(\d{1,9}(?:\.\d{1,9})?)\s*g\s*", str(value))
    return si(float(match[1]) * STANDARD_GRAVITY if match else value, RANGE, "range")


def _span(found: Sequence[float]) -> str:
    return f"{found[0]:.6g} s to {found[1]:.6g} s"


@result
class CrashFound(Result):
    """The greatest pulse of a log, its offset taken off; `record` is the Crash."""

    peak: float = number("m/s^2", "greatest acceleration")
    peak_g: float = number("1", "the same in g")
    peak_time: float = number("s", "time of the peak")
    filtered_peak: float = number("m/s^2", "greatest acceleration behind the filter")
    filtered_peak_g: float = number("1", "the same in g")
    filtered_peak_time: float = number("s", "time of the filtered peak")
    filter: str = fact("class of the filter")
    velocity_change: float = number("m/s", "change of velocity over the pulse")
    velocity_change_se: float = number("m/s", "its standard error")
    duration: float = number("s", "duration of the pulse")
    pulse: Sequence[float] = number("s", "start and end of the pulse", shown=_span)
    hic: float | None = number("1", "head injury criterion")
    hic_window: Sequence[float] | None = number("s", "its window", shown=_span)
    offset: float = number("m/s^2", "offset of the sensor, from the quiet part")
    offset_se: float = number("m/s^2", "its standard error")
    quiet: Sequence[float] = number("s", "the quiet part", shown=_span)
    sampling: float = number("Hz", "sampling rate")
    saturated: bool = fact("whether the sensor's range was left")
    samples: int = number("1", "samples of the log", listed=False)
    understood: Sequence[str] = fact("what was made of the file", listed=False)

    def draw(self) -> Figure:
        """Acceleration and velocity over time."""
        from layerjam.report import measurement_figures
        from layerjam.report.style import of_synthetic

        return of_synthetic(measurement_figures.crash(self.record), self.synthetic)


@command(
    "test",
    place=70,
    examples=("layerjam crash drop.csv --filter cfc180 --range '250 g'",),
    computes=False,
)
def crash(
    file: Annotated[
        str | Path, Help("Log: a column of time, one of acceleration.", metavar="FILE")
    ],
    *,
    filter_class: Annotated[
        str,
        Help("SAE J211-1: cfc60, 180, 600, 1000 or none.", metavar="CLASS", option="--filter"),
    ] = "cfc180",
    sampling: Annotated[
        float | str | None, SAMPLING, Help("Sampling rate of a file without time.")
    ] = None,
    before: Annotated[
        float | str | None, BEFORE, Help("Length of the quiet part at the beginning.")
    ] = None,
    sensor_range: Annotated[
        float | str | None,
        Input("Range of the sensor, e.g. '250 g'.", metavar="Q", option="--range", convert=_range),
    ] = None,
    falling: Annotated[bool, Help("The sensor fell freely before, along its axis.")] = False,
    hic: Annotated[
        float | str | None, HIC, Help("Head injury criterion over this window at most.")
    ] = None,
    options: TableOptions = TableOptions(),
) -> CrashFound:
    """Peak, filtered peak, velocity change and duration of an impact in an accelerometer's log.

    The greatest pulse of the log counts. `filter_class` is none, cfc60, cfc180, cfc600 or cfc1000;
    `before` is the length of the quiet part at the beginning. `falling`: the sensor fell freely
    before, so the weight is taken off the velocity change. `hic` is the longest window of the head
    injury criterion.
    """
    from layerjam.identify.logs import crash as crash_log

    cfc = channel_class(filter_class)
    log = read_log(file, [ACCELERATION] if sampling else [TIME, ACCELERATION], options)
    signal = log["acceleration"]
    clock = np.arange(len(signal)) / sampling if sampling else log["time"]
    try:
        found = crash_log.crash(
            clock,
            signal,
            cfc=cfc,
            sampling=sampling,
            before=before,
            limit=sensor_range,
            falling=falling,
            hic=hic,
        )
    except FitError as error:
        raise FileError(log.path, str(error)) from None
    warnings = [*log.said, *found.warnings]
    if falling:
        why = "the weight is taken off the velocity change: the sensor fell freely before"
        warnings.append(Notice(why, "falling"))
    if hic is not None:
        why = "HIC is defined for the resultant of a head; of one axis it only compares"
        warnings.append(Notice(why, "hic"))
    return CrashFound.of(
        found,
        log,
        peak_g=found.peak / STANDARD_GRAVITY,
        filtered_peak_g=found.filtered_peak / STANDARD_GRAVITY,
        filter="none" if cfc is None else f"cfc{cfc}",
        duration=found.pulse[1] - found.pulse[0],
        sampling=found.rate,
        samples=len(found.time),
        warnings=warnings,
        record=found,
    )
