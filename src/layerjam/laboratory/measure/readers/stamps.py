"""Time stamps: the time of day, and dates with times (ISO 8601), as seconds."""

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from types import MappingProxyType

import numpy as np

from layerjam.laboratory.measure.readers.unit_words import CLOCK, DATE
from layerjam.laboratory.measure.trace import Array

STAMPS: Mapping[str, str] = MappingProxyType(
    {CLOCK: f" in {CLOCK}", DATE: ", dates with times, counted from the first row"}
)
"""{unit of a column of time stamps: its description}."""
_DAY = 86_400.0
_CLOCK = re.compile(r"(\d{1,4}):([0-5]\d):([0-5]\d(?:[.,]\d+)?)", re.ASCII)
_ISO = re.compile(
    r"(\d{4}-\d\d-\d\d)[T ](\d\d:[0-5]\d(?::[0-5]\d)?)(?:[.,](\d+))?\s?(Z|[+-]\d\d:?\d\d)?",
    re.ASCII,
)


def read_stamp(cell: str) -> tuple[str, float] | None:
    """Return the unit of a time stamp, in STAMPS, and its seconds; None for any other text.

    The time of day is counted from midnight, a date from the year 1970 in UTC.
    """
    clock = _CLOCK.fullmatch(cell)
    if clock is not None:
        hours, minutes, seconds = clock.groups()
        return CLOCK, 3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds.replace(",", "."))
    iso = _ISO.fullmatch(cell)
    if iso is None:
        return None
    day, time, fraction, zone = iso.groups()
    try:
        moment = datetime.fromisoformat(f"{day}T{time}{zone or ''}")
    except ValueError:
        return None  # an impossible date, such as 31 June
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    return DATE, moment.timestamp() + float(f"0.{fraction or 0}")


def find_stamp_unit(cell: str) -> str | None:
    """Return the unit of a time stamp, None for any other text."""
    stamp = read_stamp(cell)
    return None if stamp is None else stamp[0]


def unwrap_stamps(seconds: Array, unit: str) -> Array:
    """Return dates counted from the first, and times of day that go on after midnight."""
    if unit == DATE:
        return seconds - seconds[0]
    is_midnight = np.diff(seconds, prepend=seconds[0]) < -_DAY / 2
    return seconds + _DAY * np.cumsum(is_midnight)
