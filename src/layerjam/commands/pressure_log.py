"""Pressure logs as arguments of commands: the pressure reference and the part that is used."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from layerjam.commands.declare import Help, Input
from layerjam.commands.quantities import LOG_TIME
from layerjam.device.mount import Site
from layerjam.errors import FileError, QuantityError
from layerjam.measure.log import PRESSURE, TEMPERATURE, TIME, Log, read_log
from layerjam.measure.options import ReadingOptions
from layerjam.measure.readers.unit_words import convert_unit
from layerjam.measure.trace import Array
from layerjam.units import QuantitySpec, show

VOLUME = QuantitySpec("m^3", "volume", lo=1e-10, hi=1e3, example="120mL")
ZERO = QuantitySpec("Pa", "sensor reading at atmospheric pressure", lo=-1e6, hi=1e6)
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

    @property
    def understood(self) -> list[str]:
        """Return how the file was interpreted."""
        return list(self.log.understood)


def read_pressure(
    file: str | Path,
    options: ReadingOptions,
    atmosphere: float | None,
    zero: float | None = None,
    warm: bool = False,
) -> PressureLog:
    """Return the absolute pressure of a log and, with `warm`, its temperature, if any.

    Raises FileError if the pressure reference is unknown or the pressure would be negative.
    """
    around = Site().atmosphere if atmosphere is None else atmosphere
    log = read_log(file, [TIME, PRESSURE, *[TEMPERATURE] * warm], options)
    kind, says = log.pressure_reference(options.reading)
    sentences: list[str] = [*log.notices]
    if says not in (None, kind):
        sentences.append(
            f"{log.name}: its column states {says}, but --reading {kind} takes precedence"
        )
    value = log["pressure"] - (zero or 0.0)
    absolute = {"absolute": value, "gauge": around + value, "vacuum": around - value}[kind]
    if (absolute < -0.01 * around).any():
        raise FileError(
            log.path,
            f"read as {kind}, its pressure falls to {show(float(absolute.min()), 'Pa')} "
            "absolute, which is impossible: check --reading, the unit and --zero",
        )
    return PressureLog(log, np.maximum(absolute, 1.0), kind, around, sentences)


def check_window(start: float | None, end: float | None) -> tuple[float | None, float | None]:
    """Return the start and end [s] of the window; raises QuantityError if in the wrong order."""
    if start is not None and end is not None and start >= end:
        raise QuantityError(f"from: {show(start, 's')} is not below to, {show(end, 's')}")
    return start, end


def format_span(span: Sequence[float]) -> str:
    """Return a description of a part of a log."""
    return f"{span[0]:.4g} s to {span[1]:.4g} s"
