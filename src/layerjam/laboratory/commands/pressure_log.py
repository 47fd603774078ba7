"""Pressure logs as arguments of commands: the pressure reference and the part that is used."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from layerjam.brake.commands.arguments import LOG_TIME
from layerjam.brake.device.mount import Site
from layerjam.core.command.declare import Help, Input
from layerjam.core.command.log_options import LogOptions
from layerjam.core.errors import QuantityError
from layerjam.core.units import QuantitySpec, show
from layerjam.core.verdict import Check
from layerjam.laboratory.identify.logs.sampling import find_gaps
from layerjam.laboratory.measure.log import PRESSURE, TEMPERATURE, TIME, Log, read_log
from layerjam.laboratory.measure.pressure import read_absolute
from layerjam.laboratory.measure.readers.unit_words import convert_unit
from layerjam.laboratory.measure.trace import Array

VOLUME = QuantitySpec("m^3", "volume", lo=1e-10, hi=1e3, example="120mL")
ZERO = QuantitySpec("Pa", "sensor reading at atmospheric pressure", lo=-1e6, hi=1e6)
GAPS = 3
"""Number of gaps in the sampling of a log that are named."""
ROOM = 293.15
"""Default temperature of the gas [K]: 20 °C (assumed)."""


def parse_temperature(text: float | str | None, _arguments: object = None) -> float | None:
    """Return the temperature [K] from "23 °C", "296 K" or a number; raises QuantityError."""
    if text is None:
        return None
    value = float(text) if isinstance(text, int | float) else None
    if isinstance(text, str):
        match = re.fullmatch(r"\s*([+-]?\d{1,6}(?:\.\d{1,12})?)\s*(\S.{0,15}?)\s*", text)
        kelvin = convert_unit(match[2], "K") if match else None
        if not match or kelvin is None:
            raise QuantityError(
                f"temperature: '{text[:40]}' is not a temperature; write '23 °C' or '296 K'"
            )
        value = float(match[1]) * float(kelvin[0]) + kelvin[1]
    if value is None or not 150 <= value <= 600:
        value_text = f"{value:.4g} K" if value is not None else type(text).__name__
        raise QuantityError(
            f"temperature: {value_text} is not within 150 K to 600 K; write, e.g., '23 °C'"
        )
    return value


LogFile = Annotated[str | Path, Help("Log with columns of time and pressure.", metavar="FILE")]
Zero = Annotated[float | None, ZERO, Help("Sensor reading at atmospheric pressure. Default: 0.")]
Start = Annotated[float | None, LOG_TIME, Help("Start time of the part to use.", option="--from")]
End = Annotated[float | None, LOG_TIME, Help("End time of the part to use.", option="--to")]
Temperature = Annotated[
    float | None,
    Input(
        "Temperature of the gas, e.g. 23°C. Default: 20 °C.", metavar="Q", convert=parse_temperature
    ),
]


@dataclass(frozen=True)
class PressureLog:
    """Pressure log: `absolute` [Pa], shape (N,), and how it was read.

    `reading` is the reference of the pressure in the file, `atmosphere` [Pa] that of the site,
    `notices` are for the user.
    """

    log: Log
    absolute: Array
    reading: str
    atmosphere: float
    notices: list[str]
    zero: float = 0.0
    """Zero of the sensor [Pa] that was subtracted."""

    @property
    def understood(self) -> list[str]:
        """Return how the file was interpreted, and where samples are missing."""
        gaps = [str(gap) for gap in find_gaps(self.log["time"])]
        ending = [f"{len(gaps) - GAPS} more gaps"] if len(gaps) > GAPS else []
        return [*self.log.understood, *gaps[:GAPS], *ending]

    def check_vented(self, mean: float, result: str) -> Iterator[Check]:
        """Yield the check that the gauge reads atmospheric pressure before the log leaves it.

        `mean` [Pa, absolute] is the pressure whose difference from atmospheric pressure determines
        the `result`. Nothing is yielded if the log does not begin at atmospheric pressure.
        """
        from layerjam.laboratory.identify.load_cell import check_zero, find_zero

        around, side = self.atmosphere, float(np.sign(mean - self.atmosphere))
        signal = side * (self.absolute - around)
        zero = find_zero(signal, float(signal.max()))
        if zero is None:
            return
        offset = side * zero.force
        reading = self.zero + (-offset if self.reading == "vacuum" else offset)
        cause = f"a zero error (--zero {reading:.0f}Pa subtracts it)"
        if self.reading == "absolute":
            cause = f"another atmosphere (--atmosphere {around + offset:.0f}Pa), or a zero error"
        effects = {self.log.name: (show(abs(offset), "Pa"), zero.effect(abs(mean - around)))}
        word = "above" if offset > 0 else "below"
        moment = f"{word} atmospheric pressure before the log leaves it"
        yield check_zero(effects, result, "pressure", moment, cause)


def read_pressure(
    file: str | Path,
    options: LogOptions,
    atmosphere: float | None,
    zero: float | None = None,
    warm: bool = False,
    test: Callable[[Array, Array, float], object] | None = None,
) -> PressureLog:
    """Return the absolute pressure of a log and, with `warm`, its temperature, if any.

    `test` raises FitError for times [s], absolute pressures and an atmosphere [Pa] that the command
    cannot use. Raises FileError if the pressure reference is unknown or impossible.
    """
    around = Site().atmosphere if atmosphere is None else atmosphere
    log = read_log(file, [TIME, PRESSURE, *[TEMPERATURE] * warm], options)

    def test_pressure(absolute: Array) -> None:
        if test is not None:
            test(log["time"], absolute, around)

    read = read_absolute(log, options.reading, around, zero or 0.0, test_pressure)
    absolute = np.maximum(read.absolute, 1.0)
    return PressureLog(log, absolute, read.reading, around, read.notices, zero or 0.0)


def check_window(start: float | None, end: float | None) -> tuple[float | None, float | None]:
    """Return the start and end [s] of the window; raises QuantityError if in the wrong order."""
    if start is not None and end is not None and start >= end:
        raise QuantityError(f"from: {show(start, 's')} is not below to, {show(end, 's')}")
    return start, end


def format_span(span: Sequence[float]) -> str:
    """Return a description of a part of a log."""
    return f"{span[0]:.4g} s to {span[1]:.4g} s"
