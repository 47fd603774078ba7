"""Commands on files in layouts from the field, with the right answer of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from independent import field_files as made


@dataclass(frozen=True)
class Case:
    """A command on a generated file, and its right answer."""

    command: str
    make: Callable[[Path], Path]
    right: dict[str, float]
    options: tuple[str, ...] = ()
    hints: int = 0
    take: int = 0
    """Which of the offered hints is right: the user knows, not the program."""
    within: float = 0.01
    ending: str = "csv"
    words: tuple[str, ...] = field(default=())
    """Parts of the messages or of the printed interpretation."""


def leak_file(head: str, values: Callable[[Any], Any], constant: float = 300.0, **form: Any):
    def make(path: Path) -> Path:
        time, pressure = made.hold(constant, 20.0)
        return made.csv(path, head, time * form.get("clock", 1), values(pressure))

    return make


def stamped(form: str, cell: str, head: str) -> Callable[[Path], Path]:
    """A leak whose times are stamps, and whose pressures may have units in their cells."""

    def make(path: Path) -> Path:
        time, pressure = made.hold(300.0, 20.0)
        start = np.datetime64("2026-02-08T23:59:40.000")
        stamps = [start + np.timedelta64(round(1e3 * t), "ms") for t in time]
        vacuums = made.ATMOSPHERE - pressure
        rows = (
            f"{form.format(str(t)[:10], str(t)[11:])},{cell.format(v)}"
            for t, v in zip(stamps, vacuums, strict=True)
        )
        return made.write(path, [head, *rows])

    return make


def pump_file(head: str, values: Callable[[Any], Any]) -> Callable[[Path], Path]:
    return lambda path: made.csv(
        path, head, *(f(c) for f, c in zip((lambda t: t, values), made.pump_down(), strict=True))
    )


def silicone(head: str, *order: Callable[[Any, Any], Any], to: float = 3.0, rows: int = 150):
    """A specimen of 33 mm and 18 mm²; each column is a function of strain and stress [kPa]."""

    def make(path: Path) -> Path:
        strain, stress = made.specimen(rows, to)
        return made.csv(path, head, *(column(strain, stress) for column in order), form="%.7g")

    return make


def crash_file(head: str, *order: Callable[[Any, Any], Any]) -> Callable[[Path], Path]:
    return lambda path: made.csv(path, head, *(f(*made.impact()) for f in order), form="%.8g")


def pull_file(head: str, *order: Callable[..., Any], mark: str = ",") -> Callable[[Path], Path]:
    return lambda path: made.csv(path, head, *(f(*made.pull()) for f in order), mark=mark)


VACUUM, GAUGE = (lambda p: made.ATMOSPHERE - p), (lambda p: p - made.ATMOSPHERE)
TIME, TRAVEL, FORCE = (lambda t, x, f: t), (lambda t, x, f: x), (lambda t, x, f: f)
EXTENSION, LOAD = (lambda e, s: 33 * e), (lambda e, s: 18e-3 * s)
SIZES = ("--area", "18mm^2", "--gauge-length", "33mm")
SILICONE = {"modulus_100": 87.5e3, "modulus_300": made.stress(4.0) * 1e3}
LEAK = {"time_constant": 300.0}
STIFFNESS = {"stiffness": 50e3}
PEAK = {"peak": 20 * made.G, "peak_time": 0.03}

CASES = {
    # the sixteen of the shared folder
    "01 vacuum counted negative": Case(
        "leak",
        leak_file("Time (s),Vacuum (kPa)", GAUGE, 150.0),
        {"time_constant": 150.0},
        hints=1,
        words=("cannot be read as vacuum", "--reading gauge"),
    ),
    "04 millis": Case(
        "leak",
        leak_file("millis,pressure_hPa", lambda p: 10 * p, clock=1e3),
        LEAK,
        ("--reading", "absolute"),
        words=("time is the column 'millis'",),
    ),
    "06 stretch": Case(
        "enclosure",
        silicone("Stretch [-],Stress [MPa]", lambda e, s: 1 + e, lambda e, s: s / 1e3),
        SILICONE,
    ),
    "08 LabVIEW without X": Case(
        "crash", lambda p: made.write(p, made.labview(",", "No"), "\r\n"), PEAK, ending="lvm"
    ),
    "09 LabVIEW with an X for each": Case(
        "crash",
        lambda p: made.write(p, made.labview(".", "Multi"), "\r\n"),
        PEAK,
        ending="lvm",
    ),
    "11 two equal extensions": Case(
        "enclosure",
        silicone(
            "Time,Extension,Load,Tensile extension,Tensile strain (Extension),Tensile stress\n"
            "(s),(mm),(N),(mm),(mm/mm),(MPa)",
            lambda e, s: 10 * e,
            EXTENSION,
            LOAD,
            EXTENSION,
            lambda e, s: e,
            lambda e, s: s / 1e3,
        ),
        SILICONE,
    ),
    "13 tension counted negative": Case(
        "enclosure",
        silicone("Extension (mm),Load (N)", EXTENSION, lambda e, s: -18e-3 * s),
        SILICONE,
        SIZES,
        hints=1,
        words=("--negative force",),
    ),
    "15 stamps of a phone": Case("crash", made.phone, {"peak": 30.0, "peak_time": 6.05}, hints=1),
    "16 absolute called vacuum": Case(
        "leak",
        leak_file("Time (s),Vacuum (mbar)", lambda p: 10 * p, 200.0),
        {"time_constant": 200.0},
        hints=1,
        words=("moves away", "--reading absolute"),
    ),
    "17 symbols": Case(
        "pull",
        pull_file("t,x,F", TIME, TRAVEL, FORCE),
        STIFFNESS,
        hints=1,
        words=("'t', 'x', 'F'", "--columns time:s,elongation:mm,force:N"),
    ),
    "19 ISO 8601": Case("leak", stamped("{}T{}Z", "{:.4f}", "timestamp,vacuum_kPa"), LEAK),
    "21 grams": Case(
        "pull",
        pull_file(
            "millis,grams,mm", lambda t, x, f: 1e3 * t, lambda t, x, f: f / 9.80665e-3, TRAVEL
        ),
        STIFFNESS,
        words=("read as gram-force",),
    ),
    # the kinds behind them
    "stamps with a blank": Case("leak", stamped("{} {}", "{:.4f}", "date,vacuum (kPa)"), LEAK),
    "times of day over midnight": Case("leak", stamped("{1}", "{:.4f}", "Time,vacuum (kPa)"), LEAK),
    "stamps with a zone": Case(
        "leak", stamped("{}T{}+02:00", "{:.4f}", "Time (UTC),vacuum_kPa"), LEAK
    ),
    "units in cells": Case(
        "leak",
        stamped("{}T{}", "{:.3f} kPa", "time,vacuum"),
        LEAK,
        words=("the units in the cells",),
    ),
    "pressure of unknown reference": Case(
        "leak",
        leak_file("Time (s),p (kPa)", lambda p: p),
        LEAK,
        hints=1,
    ),
    "negative pressure of unknown reference": Case(
        "leak",
        leak_file("Time (s),p (kPa)", GAUGE),
        LEAK,
        hints=1,
        words=("--reading gauge)",),
    ),
    "absolute called gauge": Case(
        "leak",
        leak_file("Time (s),Gauge pressure (kPa)", lambda p: p),
        LEAK,
        hints=1,
        take=0,
    ),
    "headerless leak": Case(
        "leak",
        lambda p: made.write(
            p, [f"{t:g},{v:.5g}" for t, v in zip(*made.hold(300.0, 20.0), strict=True)]
        ),
        LEAK,
        hints=2,
    ),
    "names without units": Case("leak", leak_file("time,vacuum", VACUUM), LEAK, hints=2, take=-1),
    "symbols of a leak": Case("leak", leak_file("t,p", VACUUM), LEAK, hints=2, take=-1),
    "pump-down that falls as a vacuum": Case(
        "pump-down",
        pump_file("Time (s),Vacuum (kPa)", lambda p: p),
        {"time_constant": 12.0},
        hints=1,
        within=0.02,
        words=("rises by", "--reading absolute"),
    ),
    "pump-down counted negative": Case(
        "pump-down",
        pump_file("Time (s),Vacuum (kPa)", GAUGE),
        {"time_constant": 12.0},
        hints=1,
        within=0.02,
        words=("--reading gauge",),
    ),
    "strain that starts at 1": Case(
        "enclosure",
        silicone("Strain [-],Stress [MPa]", lambda e, s: 1 + e, lambda e, s: s / 1e3),
        SILICONE,
        hints=1,
        words=("starts at 1", "--columns stretch:-=Strain"),
    ),
    "stretch in percent": Case(
        "enclosure",
        silicone("Stretch,Stress [kPa]", lambda e, s: 100 * (1 + e), lambda e, s: s),
        SILICONE,
    ),
    "stretch that starts at 0": Case(
        "enclosure",
        silicone("Stretch [%],Stress [MPa]", lambda e, s: 100 * e, lambda e, s: s / 1e3),
        SILICONE,
        hints=1,
        take=0,
    ),
    "strain without a unit": Case(
        "enclosure",
        silicone("Strain,Stress [MPa]", lambda e, s: 100 * e, lambda e, s: s / 1e3),
        SILICONE,
        hints=1,
        take=1,
    ),
    "humidity is not a strain": Case(
        "enclosure",
        silicone("Humidity (%),Extension (mm),Load (N)", lambda e, s: 40 + e, EXTENSION, LOAD),
        SILICONE,
        SIZES,
    ),
    "stress counted negative": Case(
        "enclosure",
        silicone("Strain [%],Stress [MPa]", lambda e, s: 100 * e, lambda e, s: -s / 1e3),
        SILICONE,
        hints=1,
    ),
    "headerless silicone": Case(
        "enclosure",
        lambda p: made.csv(p, "# specimen 1", 100 * made.specimen()[0], made.specimen()[1] / 1e3),
        SILICONE,
        hints=1,
        words=("--columns strain:%,stress:MPa",),
    ),
    "symbols of silicone": Case(
        "enclosure", silicone("x,F", EXTENSION, LOAD), SILICONE, SIZES, hints=1
    ),
    "two loads of one name": Case(
        "enclosure",
        silicone("Extension (mm),Load (N),Load (N)", EXTENSION, lambda e, s: 0.1 + 0 * s + e, LOAD),
        SILICONE,
        (*SIZES, "--columns", "force=Load#2"),
    ),
    "milli-g": Case(
        "crash", crash_file("time (s),Z (mG)", lambda t, a: t, lambda t, a: 1e3 * a), PEAK
    ),
    "milli-g given as g": Case(
        "crash",
        crash_file("time (s),Z (mG)", lambda t, a: t, lambda t, a: 1e3 * a),
        PEAK,
        ("--columns", "acceleration:mg=Z"),
    ),
    "two axes": Case(
        "crash",
        crash_file(
            "time (s),Acc X (g),Acc Y (g)", lambda t, a: t, lambda t, a: a, lambda t, a: 0.1 * a
        ),
        PEAK,
        hints=1,
    ),
    "two axes of one name": Case(
        "crash",
        crash_file(
            "time (s),Acc (g),Acc (g)", lambda t, a: t, lambda t, a: a, lambda t, a: 0.1 * a
        ),
        PEAK,
        hints=1,
        words=("Acc#1",),
    ),
    "unit alone as a name": Case(
        "crash", crash_file("micros,mg", lambda t, a: 1e6 * t, lambda t, a: 1e3 * a), PEAK
    ),
    "acceleration in raw counts": Case(
        "crash", crash_file("time (s),Acc (raw)", lambda t, a: t, lambda t, a: a), PEAK, hints=1
    ),
    "headerless crash": Case(
        "crash",
        lambda p: made.write(
            p, [f"{t:.5f};{a:.5f};7" for t, a in zip(*made.impact(), strict=True)]
        ),
        PEAK,
        hints=1,
    ),
    "decimal commas in LabVIEW with X": Case(
        "crash", lambda p: made.write(p, made.labview(",", "Multi"), "\r\n"), PEAK, ending="lvm"
    ),
    "names without meaning": Case(
        "pull", pull_file("Time (s),Ch1,Ch2", TIME, TRAVEL, FORCE), STIFFNESS, hints=1
    ),
    "symbols in another order": Case(
        "pull",
        pull_file("F;x;t", FORCE, TRAVEL, TIME, mark=";"),
        STIFFNESS,
        hints=1,
        words=("--columns force:N,elongation:mm,time:s",),
    ),
    "headerless pull": Case(
        "pull",
        lambda p: made.write(
            p, [";".join(f"{v:.4f}" for v in row) for row in zip(*made.pull(), strict=True)]
        ),
        STIFFNESS,
        hints=1,
    ),
    "load in grams": Case(
        "pull",
        pull_file("Time (s),Extension (mm),Load (g)", TIME, TRAVEL, lambda t, x, f: f / 9.80665e-3),
        STIFFNESS,
        hints=1,
        words=("--columns force:gf=Load",),
    ),
    "two loads": Case(
        "pull",
        pull_file(
            "Time (s),Extension (mm),Load A (N),Load B (N)",
            TIME,
            TRAVEL,
            FORCE,
            lambda t, x, f: 0.3 * f + t,
        ),
        STIFFNESS,
        hints=1,
        words=("--columns 'force=Load A'",),
    ),
    "two loads of one name in a pull": Case(
        "pull",
        pull_file(
            "Time (s),Extension (mm),Load (N),Load (N)",
            TIME,
            TRAVEL,
            FORCE,
            lambda t, x, f: 0.3 * f + t,
        ),
        STIFFNESS,
        hints=1,
        words=("Load#1",),
    ),
    "a name with its bracket": Case(
        "pull",
        pull_file(
            "Time (s),Extension (mm),Load (kN),Load (lbf)",
            TIME,
            TRAVEL,
            lambda t, x, f: f / 1e3,
            lambda t, x, f: 0.3 * f + t,
        ),
        STIFFNESS,
        ("--columns", "force=Load (kN)"),
    ),
    "a name that cannot be typed": Case(
        "pull",
        pull_file('Time (s),Extension (mm),"Load, A=1",Other', TIME, TRAVEL, FORCE, TIME),
        STIFFNESS,
        hints=1,
        words=("#3",),
    ),
    "tension and travel counted negative": Case(
        "pull",
        pull_file("Time (s),Extension (mm),Load (N)", TIME, lambda t, x, f: -x, lambda t, x, f: -f),
        STIFFNESS,
        hints=2,
    ),
    "travel counted negative": Case(
        "pull",
        pull_file("Time (s),Extension (mm),Load (N)", TIME, lambda t, x, f: -x, FORCE),
        STIFFNESS,
        hints=1,
    ),
    "no elongation": Case(
        "pull",
        pull_file("Time (s),Load (N)", TIME, FORCE),
        {"stiffness": 50e3 * 0.42 / (10 / 60)},
        hints=1,
    ),
    "a wrong unit given": Case(
        "pull",
        pull_file("Time (s),Extension (mm),Load (N)", TIME, TRAVEL, FORCE),
        {"stiffness": 50e6},
        ("--column", "force:kN=Load"),
        hints=1,
    ),
    "too few entries": Case(
        "pull",
        pull_file("t,x,F", TIME, TRAVEL, FORCE),
        STIFFNESS,
        ("--columns", "elongation:mm,force:N"),
        hints=1,
    ),
    "units in cells of a pull": Case(
        "pull",
        lambda p: made.write(
            p,
            [
                "time;travel;load",
                *(f"{t:.1f} s;{x:.4f} mm;{f:.3f} N" for t, x, f in zip(*made.pull(), strict=True)),
            ],
        ),
        STIFFNESS,
    ),
    "1.234 may be a thousand": Case(
        "pull",
        lambda p: made.write(
            p,
            [
                "Weg (um);Kraft (N)",
                *(
                    f"{1000 + 42 * k:,}".replace(",", ".") + f";{1000 + 3 * k:,}".replace(",", ".")
                    for k in range(120)
                ),
            ],
        ),
        {},
        hints=1,
    ),
}
