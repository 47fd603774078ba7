"""Recorded numbers of what readers find in exports of machines, whole and damaged, and in logs."""

from __future__ import annotations

import dataclasses
import itertools
import math
import random
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from laboratory.measure.exports import EXPORTS, SUFFIX, Export
from layerjam.core.errors import LayerjamError
from layerjam.laboratory.measure.log import ACCELERATION, PRESSURE, Want, find_reference, read_log
from layerjam.laboratory.measure.log import TIME as CLOCK
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.read import read_trace
from recorded.counting import find_numbers
from recorded.laws import totals

VARIANTS, COUNT = 9, 50
TIME = 0.04 * np.arange(COUNT)
TRAVEL = 2e-4 * np.arange(COUNT)
FORCE = np.minimum(9e4 * TRAVEL, 120 - 1500 * TRAVEL)
STYLES = ("{name} ({unit})", "{name} [{unit}]", "{name}_{unit}", "{name}", "none", "rows", "rows()",
          "units above", "names alone")  # fmt: skip
CHANGES: dict[str, tuple[object, ...]] = {
    "sep": (",", ";", "\t", "|", "  "),
    "decimal": (".", ","),
    "thousands": (",", ".", " ", "'"),
    "quote": ("all", "names"),
    "encoding": ("utf-8-sig", "utf-16", "utf-16-be", "cp1252", "shift_jis"),
    "newline": ("\r\n", "\r"),
    "style": STYLES,
    "above": (("Specimen: 7", "Width;10"), ("", "#", "Operator A. B."), ("1,2,3",)),
    "below": (("", "mean,1,2"), ("*** end ***",), ("7", "8")),
    "between": (("",), ("1 2 3 4",), ("---",)),
    "digits": (1, 3, 9),
    "pad": (12,),
    "origin": (0.25, -0.04),
}
OPTIONS: tuple[dict[str, object], ...] = (
    {"decimal": ","}, {"decimal": "."}, {"negative": ["force"]}, {"speed": 5e-3},
    {"columns": "time:s,elongation:mm,force:N"}, {"columns": "skip,elongation:mm,force:kN"},
    {"column": ["force:lbf=Load"]}, {"specimen": 1},
)  # fmt: skip
DAMAGES: tuple[Callable[[list[str], random.Random], list[str]], ...] = (
    lambda lines, _: [*lines[:-2], lines[-2][: len(lines[-2]) // 2]],
    lambda lines, _: [*lines[:30], "", *lines[30:]],
    lambda lines, _: [*lines[:30], "pause", *lines[30:]],
    lambda lines, _: [*lines[:30], *lines[:5], *lines[30:]],
    lambda lines, _: [*lines[:30], lines[31], lines[30], *lines[32:]],
    lambda lines, _: [*lines[:30], lines[29], *lines[30:]],
    lambda lines, _: [line.replace("0", "NaN", 1) if i == 33 else line
                      for i, line in enumerate(lines)],
    lambda lines, _: [line.replace("N", "furlong").replace("mm", "NN") for line in lines],
    lambda lines, rng: [line for line in lines if rng.random() > 0.1],
    lambda lines, _: [line + line[-1:] for line in lines],
    lambda lines, _: [*lines[:12], *lines[:4], *lines[13:]],
)  # fmt: skip


def list_read_numbers(folder: Path) -> dict[str, float | str]:
    """Return outcomes and totals over the variants of each export."""
    found: dict[str, float | str] = {}
    for place, (name, export) in enumerate(EXPORTS.items()):
        rng = random.Random(place)
        outcomes: dict[str, float] = {}
        for number in range(VARIANTS):
            for key, value in read_variant(folder, export, number, rng):
                outcomes[key] = outcomes.get(key, 0.0) + value
        found |= {f"{name}.{key}": value for key, value in outcomes.items()}
    return found


def read_variant(
    folder: Path, export: Export, number: int, rng: random.Random
) -> Iterator[tuple[str, float]]:
    """Yield the outcome of reading one variant: an error, or totals of the columns."""
    for field in rng.sample(list(CHANGES), rng.randint(0, 2)):
        export = dataclasses.replace(export, **{field: rng.choice(CHANGES[field])})
    damage = rng.choice(DAMAGES) if rng.random() < 0.4 else None
    options = rng.choice(OPTIONS) if rng.random() < 0.3 else {}
    try:
        text = export.write(TIME, TRAVEL, FORCE).decode(export.encoding)
        if damage is not None:
            text = export.newline.join(damage(text.split(export.newline), rng))
        data = text.encode(export.encoding)
    except UnicodeError:
        return
    path = folder / f"variant-{number}.{SUFFIX.get(export.sep, 'csv')}"
    path.write_bytes(data)
    try:
        trace = read_trace(path, ReadingOptions(**options))
    except LayerjamError as error:
        yield type(error).__name__, 1.0
        yield "said", math.fsum(find_numbers([str(error).replace(str(path), "")]))
        return
    finally:
        path.unlink()
    said = *trace.understood, *trace.warnings
    yield "texts", float(len(said))
    yield "said", math.fsum(find_numbers(said))
    for column in ("time", "elongation", "force"):
        values = getattr(trace, column)
        for key, value in totals(np.array([math.nan]) if values is None else values):
            yield f"{column}.{key}".removesuffix("arithms"), value * (1 + number)


LOGGED: dict[str, tuple[Want, tuple[tuple[str, str, float], ...]]] = {
    "pressure": (
        PRESSURE,
        (("Pressure", "kPa abs", 1e3), ("Druck", "mbar abs", 1e2), ("vacuum", "kPa", 1e3),
         ("p", "bar", 1e5), ("Gauge pressure", "psi", 6894.757), ("abs. pressure", "Torr", 133.322),
         ("Vakuum", "mbar", 1e2), ("Pression absolue", "hPa", 1e2), ("Unterdruck", "hPa", 1e2),
         ("Pressure", "psia", 6894.757), ("Pressure", "psig", 6894.757), ("Ch 2", "inHg", 3386.389),
         ("Druck", "bar(ü)", 1e5), ("Pressure", "parsec", 1e3), ("pressure abs", "MPa", 1e6)),
    ),
    "acceleration": (
        ACCELERATION,
        (("acceleration", "g", 9.80665), ("a", "m/s^2", 1.0), ("Beschleunigung", "m/s²", 1.0),
         ("Acc Z", "mg", 9.80665e-3), ("accel", "ft/s^2", 0.3048), ("acceleration", "N", 1.0)),
    ),
}  # fmt: skip
CLOCKS = (("time", "s", 1.0), ("Zeit", "ms", 1e-3), ("t", "min", 60.0), ("elapsed", "s", 1.0))
FORMS = (("{name} ({unit})", ",", "."), ("{name} [{unit}]", ";", ","), ("{name}_{unit}", "\t", "."),
         ("{name}, {unit}", ";", "."), ("rows", ";", ","), ("{name}", ",", "."))  # fmt: skip


def list_log_numbers(folder: Path) -> dict[str, float | str]:
    """Return outcomes and totals over logs of each quantity and unit in several forms."""
    found: dict[str, float | str] = {}
    values = 2e4 + 8e4 * np.exp(-TIME)
    for quantity, (want, columns) in LOGGED.items():
        for name, unit, factor in columns:
            outcomes: dict[str, float] = {}
            for number, (form, clock) in enumerate(itertools.product(FORMS, CLOCKS)):
                path = folder / f"log-{number}.csv"
                path.write_text(write_log(form, clock, (name, unit, factor), values), "utf-8")
                for key, value in read_one_log(path, want):
                    outcomes[key] = outcomes.get(key, 0.0) + value * (1 + number)
                path.unlink()
            found |= {f"{quantity} {name} {unit}.{k}": v for k, v in outcomes.items()}
    return found


def write_log(
    form: tuple[str, str, str],
    clock: tuple[str, str, float],
    column: tuple[str, str, float],
    values: np.ndarray,
) -> str:
    """Return the text of a log: how names and units are written, the separator, the decimal."""
    style, separator, decimal = form
    pairs = (clock[:2], column[:2])
    heads = (
        [separator.join(pair) for pair in zip(*pairs, strict=True)]
        if style == "rows"
        else [separator.join(f'"{style.format(name=n, unit=u)}"' for n, u in pairs)]
    )
    rows = (
        separator.join(f"{cell:.9g}".replace(".", decimal) for cell in row)
        for row in zip(TIME / clock[2], values / column[2], strict=True)
    )
    return "\n".join([*heads, *rows, ""])


def read_one_log(path: Path, want: Want) -> Iterator[tuple[str, float]]:
    """Yield the outcome of reading a log: an error, or totals of the column and its reference."""
    try:
        log = read_log(path, (CLOCK, want))
    except LayerjamError as error:
        yield type(error).__name__, 1.0
        yield "said", math.fsum(find_numbers([str(error).replace(str(path), "")]))
        return
    yield "texts", float(len(log.understood) + 10 * len(log.warnings))
    yield f"reference {find_reference(log.taken[want.role])}", 1.0
    for role in (CLOCK.role, want.role):
        for key, value in totals(log[role]):
            yield f"{role}.{key}".removesuffix("arithms"), value
