"""A vacuum over time from a file: a column of time and one of vacuum, units in their names."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from layerjam.errors import FileError, UnknownNameError
from layerjam.identify.columns import split_unit
from layerjam.identify.log import Said, pressure_says
from layerjam.simulate.vacuum_history import History
from layerjam.units import show, unit_factor

READINGS = ("absolute", "gauge", "vacuum")
"""What a pressure may count from: nothing, the atmosphere upwards, the atmosphere downwards."""

LARGEST = 50_000_000
"""Bytes of a file that is read."""


def read_history(path: str | Path, atmosphere: float, reading: str | None = None) -> History:
    """The history in a CSV such as ``time [s],vacuum [kPa]``; lines with '#' are skipped.

    The column in a unit of time and the one in a unit of pressure are taken. What the pressure
    counts from, its column says (vacuum, absolute pressure, gauge pressure) or `reading` does:
    absolute, gauge (over the atmosphere) or vacuum (below it). Raises FileError where there is not
    exactly one column of each, where neither says what it counts from, where a number is missing or
    not finite, time does not rise, or the vacuum leaves 0 to `atmosphere` [Pa].
    """
    if reading is not None and reading not in READINGS:
        raise UnknownNameError("reading", reading, READINGS)
    lines = _lines(path)
    if len(lines) < 3:
        raise FileError(path, "needs a row of names and at least two rows of numbers")
    (first, head), rows = lines[0], lines[1:]
    names = [split_unit(cell) for cell in head]
    places = [
        _place(names, si, what, path, first) for si, what in (("s", "time"), ("Pa", "vacuum"))
    ]
    name, unit = names[places[1][0]]
    kind = reading or pressure_says(Said(places[1][0], name, unit or "", False))
    if kind is None:
        raise FileError(
            path,
            f"does not say what '{name[:60]}' counts from: name the column vacuum, or give "
            "--reading absolute, gauge (over the atmosphere) or vacuum (below it)",
            first,
        )
    values = np.empty((2, len(rows)))
    for number, (line, row) in enumerate(rows):
        for k, (place, factor) in enumerate(places):
            values[k, number] = _number(row, place, path, line) * factor
    time, pressure = values
    vacuum = {"absolute": atmosphere - pressure, "gauge": -pressure, "vacuum": pressure}[kind]
    step = np.diff(time)
    if (step <= 0).any():
        bad = int(np.argmax(step <= 0)) + 1
        raise FileError(
            path, f"time does not rise here ({show(float(time[bad]), 's')})", rows[bad][0]
        )
    out = (vacuum < 0) | (vacuum > atmosphere)
    if out.any():
        bad = int(np.argmax(out))
        raise FileError(
            path,
            f"vacuum {show(float(vacuum[bad]), 'Pa')} is not allowed; it lies between 0 and the "
            f"atmosphere of {show(atmosphere, 'Pa')}"
            + ("" if kind == "vacuum" else f" (its pressure is read as {kind})"),
            rows[bad][0],
        )
    return History(time, vacuum)


def _lines(path: str | Path) -> list[tuple[int, list[str]]]:
    """Line number and cells of every line that is neither empty nor a comment."""
    try:
        size = Path(path).stat().st_size
        if size > LARGEST:
            raise FileError(path, f"is {size / 1e6:.0f} MB large; at most 50 MB are read")
        text = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(path, "cannot be read: it is no text in UTF-8") from None
    except OSError as err:
        raise FileError(path, f"cannot be read: {err.strerror or err}") from None
    kept = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    kept = [(n, line) for n, line in kept if not line.startswith("#")]
    mark = next((m for m in (";", "\t", ",") if kept and m in kept[0][1]), ",")
    return [(n, next(csv.reader(io.StringIO(line), delimiter=mark))) for n, line in kept]


def _place(
    names: list[tuple[str, str | None]], si: str, what: str, path: str | Path, line: int
) -> tuple[int, float]:
    """Index and factor to SI of the one column in a unit of this dimension."""
    found = []
    for index, (_, unit) in enumerate(names):
        factor = unit_factor(unit, si) if unit else None
        if factor is not None:
            found.append((index, float(factor)))
    if len(found) != 1:
        there = ", ".join(f"'{n}' [{u or 'no unit'}]"[:60] for n, u in names[:8])
        count = "no column" if not found else f"{len(found)} columns"
        raise FileError(
            path, f"has {count} of {what} in a unit such as {si}; there is {there}", line
        )
    return found[0]


def _number(row: list[str], place: int, path: str | Path, line: int) -> float:
    text = row[place].strip() if place < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise FileError(path, f"'{text[:40]}' is no number", line)
    return value
