"""`crash`: analyse an impact in an accelerometer log."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from layerjam.brake.commands.arguments import Accept
from layerjam.brake.commands.sensor import SAMPLING, parse_channel_class
from layerjam.brake.simulate.accelerometer import STANDARD_GRAVITY, Accelerometer
from layerjam.core.command.declare import Help, Input, command
from layerjam.core.command.results import Figure, Judged, fact, result
from layerjam.core.errors import FileError, Notice, QuantityError
from layerjam.core.units import QuantitySpec, get_spec
from layerjam.core.verdict import judge
from layerjam.laboratory.commands.reading import TableOptions
from layerjam.laboratory.identify.logs.crash import Pulse
from layerjam.laboratory.identify.logs.sampling import find_gaps
from layerjam.laboratory.measure.log import ACCELERATION, TIME, Log, read_log
from layerjam.laboratory.measure.runs import ENDING, read_run
from layerjam.laboratory.measure.shots import Shot, find_shot

if TYPE_CHECKING:
    from layerjam.laboratory.identify.logs.crash import Crash

RANGE = replace(get_spec(Accelerometer, "range"), text="range of the sensor", example="'250 g'")
BEFORE = QuantitySpec("s", "time before the event", open_lo=True, hi=1e6, example="50ms")
SHOT = QuantitySpec("1", "number of the drop in a run", lo=1, hi=1e6, whole=True)
LEAST = 20
"""Minimum number of samples in a pulse."""
HIC = QuantitySpec(
    "s", "longest window of the head injury criterion", lo=1e-3, hi=0.1, example="15ms"
)


def _parse_range(value: float | str, _arguments: Mapping[str, Any]) -> float:
    """Return the range [m/s^2] from "250 g", "2450 m/s^2" or a number in m/s^2."""
    match = re.fullmatch(r"\s*(\d{1,9}(?:\.\d{1,9})?)\s*g\s*", str(value))
    return RANGE.si(float(match[1]) * STANDARD_GRAVITY if match else value, "range")


def _read_signal(
    file: str | Path, shot: Any, sampling: Any, options: TableOptions
) -> tuple[Log, float | None, list[str]]:
    """Return the log, the range [m/s^2] that its file states, and the notices."""
    if Path(file).suffix == ENDING:
        shot_log = _read_shot(file, shot, sampling, options)
        return _read_shot_log(shot_log, file), shot_log.range, _truncation_notice(shot_log)
    if shot is not None:
        raise QuantityError.of("shot", f"{file} is one log; only a run ({ENDING}) contains shots")
    clock = replace(TIME, optional=sampling is not None)
    log = read_log(file, [clock, ACCELERATION], options)
    if sampling is not None and "time" in log and (np.diff(log["time"]) >= 0).all():
        gaps = find_gaps(log["time"])
        if gaps:
            raise FileError(
                file,
                f"its time stamps show that {', '.join(map(str, gaps[:3]))}; one rate would close "
                "such gaps, so omit --sampling",
            )
    return log, None, []


def _crash_notices(falling: bool, hic: Any) -> Iterator[Notice]:
    if falling:
        sentence = (
            "gravity is subtracted from the velocity change, because the sensor was in free "
            "fall before the impact"
        )
        yield Notice(sentence, "falling")
    if hic is not None:
        sentence = (
            "HIC is defined for the resultant acceleration of a head; a single axis "
            "allows comparisons only"
        )
        yield Notice(sentence, "hic")


def _read_shot(file: str | Path, number: Any, sampling: Any, options: TableOptions) -> Shot:
    """Return a run's record; raises QuantityError for options that the run already states."""
    for name, value in {"sampling": sampling, **vars(options)}.items():
        if value not in (None, ()):
            raise QuantityError.of(
                name, (f"{file} is a run file, which already states it; omit the option")
            )
    record = find_shot(read_run(file).shots, None if number is None else int(number), str(file))
    if len(record.counts) < LEAST:
        raise FileError(
            file, f"only {len(record.counts)} samples of shot {record.number} were kept"
        )
    return record


def _read_shot_log(shot: Shot, file: str | Path) -> Log:
    columns = {"time": shot.time, "acceleration": shot.acceleration}
    sentence = (
        f"shot {shot.number} of the run: {shot.size} samples, with time counted from the trigger"
    )
    return Log(str(file), columns, {}, {}, (sentence,), synthetic=shot.synthetic)


def _truncation_notice(shot: Shot) -> list[str]:
    """Return a notice if part of a record is missing."""
    size = len(shot.counts)
    text = f"only {size} of the record's {shot.size} samples were kept: the run was interrupted"
    return [] if size == shot.size else [Notice(text, "cut-shot")]


@result
class CrashFound(Judged, Pulse):
    """Largest pulse of a log, after subtracting the offset; `record` is the Crash."""

    record: "Crash"
    understood: Sequence[str] = fact("how the file was read", listed=False)

    def draw(self) -> Figure:
        """Return the figure of acceleration and velocity versus time."""
        from layerjam.core.drawing.style import mark_figure
        from layerjam.laboratory.figures import measurement_figures

        return mark_figure(measurement_figures.draw_crash(self.record), self.synthetic)


@command("test")
def crash(
    file: Annotated[
        str | Path, Help("Log with a time column and an acceleration column.", metavar="FILE")
    ],
    *,
    filter_class: Annotated[
        str,
        Help("SAE J211-1: cfc60, 180, 600, 1000 or none.", metavar="CLASS", option="--filter"),
    ] = "cfc180",
    sampling: Annotated[
        float | None, SAMPLING, Help("Sampling rate of a file without a time column.")
    ] = None,
    before: Annotated[float | None, BEFORE, Help("Length of the quiet part at the start.")] = None,
    sensor_range: Annotated[
        float | None,
        Input(
            "Range of the sensor, e.g. '250 g'.",
            metavar="Q",
            option="--range",
            convert=_parse_range,
        ),
    ] = None,
    falling: Annotated[bool, Help("Sensor in free fall along its axis before impact.")] = False,
    hic: Annotated[float | None, HIC, Help("Longest window of the head injury criterion.")] = None,
    shot: Annotated[
        int | None, SHOT, Help("Number of the drop in a run that contains several.")
    ] = None,
    accept: Accept = None,
    options: TableOptions = TableOptions(),
) -> CrashFound:
    """Compute peak, filtered peak, velocity change and duration of an impact from a log.

    The largest pulse of the log is used. `filter_class` is none, cfc60, cfc180, cfc600 or cfc1000;
    `before` is the duration of the quiet part at the start of the log. `falling` states that the
    sensor was in free fall before the impact; gravity is then subtracted from the velocity change.
    `hic` is the longest window of the head injury criterion. A run recorded by `bench run --shot`
    is accepted too; it already states rate and range.
    """
    from layerjam.laboratory.identify.logs import crash as crash_log
    from layerjam.laboratory.identify.logs.log_checks import check_crash

    cfc = parse_channel_class(filter_class)
    log, reach, warnings = _read_signal(file, shot, sampling, options)
    signal = log["acceleration"]
    clock = np.arange(len(signal)) / sampling if sampling else log["time"]
    with log.locate_errors():
        reduction = crash_log.reduce_crash(
            clock,
            signal,
            cfc=cfc,
            sampling=sampling,
            before=before,
            limit=sensor_range or reach,
            falling=falling,
            hic=hic,
        )
    return CrashFound.create(
        reduction,
        log,
        judge(check_crash(reduction, falling), accept),
        warnings=[*warnings, *log.notices, *reduction.warnings, *_crash_notices(falling, hic)],
        record=reduction,
    )
