"""Date and time of a test, as stated in the lines above a table, in a column or in a sidecar."""

import re
from collections.abc import Iterable
from datetime import UTC, datetime

_DATE = re.compile(
    r"(?<![\d.:/-])(?:(?P<year>\d{4})(?P<mark>[-/.])(?P<month>\d\d?)(?P=mark)(?P<day>\d\d?)"
    r"|(?P<first>\d\d?)(?P<sign>[-/.])(?P<second>\d\d?)(?P=sign)(?P<last>\d{4}))(?![\d:/-])",
    re.ASCII,
)
_CLOCK = re.compile(
    r"(?<![\d:])(\d\d?):([0-5]\d)(?::([0-5]\d(?:[.,]\d{1,9})?))?(?![\d:])"
    r"\s*(?i:([ap])\.?m\b\.?)?(\s?Z\b|\s?[+-]\d\d:?\d\d\b)?",
    re.ASCII,
)
_NOT_START = re.compile(
    r"(?i)calibr|kalibr|due|print|export|save|version|release|expir|durat|dauer|elapsed|total"
)
"""Words of lines whose date or time of day is not that of the test."""
_LINES = 200


def find_start(lines: Iterable[str]) -> float | None:
    """Return the start of a test [s since 1970, UTC] that text lines state, or None.

    The first date and the first time of day count, on one line or on two. A date without a time of
    day does not order the tests of a day, so it is not enough. The order of day and month in
    `5/11/2026` is unknown; they are read as month and day if the time of day has AM or PM.
    """
    date = clock = None
    for number, line in enumerate(lines):
        if number == _LINES or (date and clock):
            break
        if _NOT_START.search(line):
            continue
        match = _DATE.search(line)
        date = date or match
        # a time of day follows its date, or stands alone below it
        tail = line[match.end() :] if match else line
        clock = clock or (_CLOCK.search(tail.removeprefix("T")) if date else None)
    return _combine(date, clock) if date and clock else None


def _combine(date: re.Match[str], clock: re.Match[str]) -> float | None:
    """Return a date and a time of day as seconds since 1970; None if they do not exist."""
    hour, minute, second, half, zone = clock.groups()
    if date["year"]:
        year, month, day = (int(date[part]) for part in ("year", "month", "day"))
    else:
        year, day, month = int(date["last"]), int(date["first"]), int(date["second"])
        if month > 12 or (half and date["sign"] == "/" and day <= 12):
            day, month = month, day
    hours = int(hour) if half is None else int(hour) % 12 + 12 * (half in "pP")
    offset = (zone or "Z").strip()
    text = f"{year:04}-{month:02}-{day:02}T{hours:02}:{minute}:00{offset}"
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        return None
    return moment.astimezone(UTC).timestamp() + float((second or "0").replace(",", "."))
