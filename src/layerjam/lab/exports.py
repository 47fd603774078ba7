"""Records written as test machines export them: one layout for each machine's software.

Every file says that it is synthetic, in its own text and in the sidecar beside it. The layouts are
imitations, written from what such files look like, not by the machines.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from layerjam._version import __version__
from layerjam.device.load import write_whole
from layerjam.errors import FileError, QuantityError
from layerjam.measure.sidecar import Facts, sidecar_path, write_facts
from layerjam.measure.trace import Trace

# Names of time, travel and force, then testXpert's for crosshead, travel and force.
LANGUAGES = {
    "en": ("Time", "Extension", "Load", "Crosshead absolute", "Standard travel", "Standard force"),
    "de": ("Zeit", "Weg", "Kraft", "Traversenposition", "Standardweg", "Standardkraft"),
    "fr": ("Temps", "Déplacement", "Charge", "Traverse absolue", "Course standard",
           "Force standard"),
    "es": ("Tiempo", "Desplazamiento", "Carga", "Travesaño absoluto", "Desplazamiento estándar",
           "Fuerza estándar"),
    "it": ("Tempo", "Spostamento", "Carico", "Traversa assoluta", "Corsa standard",
           "Forza standard"),
    "pt": ("Tempo", "Deslocamento", "Carga", "Travessa absoluta", "Deslocamento padrão",
           "Força padrão"),
    "ja": ("時間", "ストローク", "試験力", "クロスヘッド", "標準変位", "標準荷重"),
}  # fmt: skip
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252", "cp932")
# What MTS and Trapezium call the columns in English, where other software says it otherwise.
_MTS = ("Time", "Crosshead", "Load")
_TRAPEZIUM = ("Time", "Stroke", "Force")


@dataclass(frozen=True, kw_only=True)
class Style:
    """How one file is written, and what it says of its force's unit (N are the numbers')."""

    decimal: str = "."
    language: str = "en"
    force_unit: str = "N"

    @property
    def separator(self) -> str:
        """Of columns, in layouts with commas: a semicolon beside decimal commas."""
        return "," if self.decimal == "." else ";"

    def names(self, english: tuple[str, ...] = LANGUAGES["en"][:3]) -> tuple[str, ...]:
        """Names of time, travel and force."""
        return english if self.language == "en" else LANGUAGES[self.language][:3]


@dataclass(frozen=True, kw_only=True)
class Layout:
    """One software's layout: its text, and what is usual for it."""

    text: Callable[[Trace, Style], str]
    ending: str
    encoding: str
    about: str
    decimal: str = "."
    fixed: bool = False
    """Whether encoding, decimal sign and language are always these."""


def statement(facts: Facts) -> str:
    """What stands in every file."""
    return f"SYNTHETIC, layerjam {__version__} virtual test machine, seed {facts.seed}"


def _rows(form: str, trace: Trace, style: Style, *columns: np.ndarray) -> str:
    """All rows in one go; `form` is the format of one row with its line end."""
    count = len(trace)
    flat = tuple(np.column_stack(columns).ravel().tolist()) if count else ()
    text = (form * count) % flat
    return text if style.decimal == "." else text.replace(".", ",")


def _time(trace: Trace) -> np.ndarray:
    if trace.time is None:
        raise QuantityError("a trace without time cannot be written")
    return trace.time


def own(trace: Trace, style: Style) -> str:
    """Our own CSV: SI, every digit."""
    head = [f"# layerjam {__version__} measurement", f"# data: {statement(trace.facts)}"]
    head.append(f"time [s],elongation [m],force [{style.force_unit}]\n")
    rows = _rows("%r,%r,%r\n", trace, Style(), _time(trace), trace.elongation, trace.force)
    return "\n".join(head) + rows


def bluehill(trace: Trace, style: Style) -> str:
    """Instron Bluehill: everything in quotes, names over units in parentheses; s, mm, N."""
    mark, (time, travel, force) = style.separator, style.names()
    head = [
        '"Sample description"',
        f'"Operator"{mark}"{statement(trace.facts)}"',
        "",
        f'"{time}"{mark}"{travel}"{mark}"{force}"',
        f'"(s)"{mark}"(mm)"{mark}"({style.force_unit})"',
        "",
        "",
    ]
    form = f'"%.6f"{mark}"%.6f"{mark}"%.5f"\r\n'
    rows = _rows(form, trace, style, _time(trace), trace.elongation * 1e3, trace.force)
    return "\r\n".join(head) + rows


def testxpert(trace: Trace, style: Style) -> str:
    """Zwick testXpert .TRA: lines about the specimen, names over units, numbers of six digits."""
    mark, words = style.separator, LANGUAGES[style.language]
    length = float(np.ptp(trace.elongation)) * 1e3 if len(trace) else 0.0

    def line(name: str, number: float, unit: str) -> str:
        text = f"{number:g}".replace(".", style.decimal)
        return f'"{name}"{mark}{text}{mark}"{unit}"'

    head = [
        line("Gage length, standard travel", length, "mm"),
        line("Cross-section", 1, "mm²"),
        f'"Extensometer"{mark}""',
        f'"Load cell"{mark}""',
        f'"Operator"{mark}"{statement(trace.facts)}"',
        line("v1", (trace.facts.speed or 0.0) * 60e3, "mm/min"),
        mark.join(f'"{w}"' for w in (words[0], words[3], words[5], words[4])),
        mark.join(f'"{u}"' for u in ("s", "mm", style.force_unit, "mm")) + "\n",
    ]
    form = mark.join(["%.6g"] * 4) + "\n"
    travel = trace.elongation * 1000.0
    rows = _rows(form, trace, style, _time(trace), travel + 250.0, trace.force, travel)
    return "\n".join(head) + rows


def mts(trace: Trace, style: Style) -> str:
    """MTS TestSuite: lines about station and test, then names over units, between tabs."""
    time, travel, force = style.names(_MTS)
    head = [
        "MTS TestSuite",
        "Data Acquisition: Timed",
        f"Station Name: {statement(trace.facts)}",
        f"Test Run Name: repeat {trace.facts.repeat}",
        "",
        f"{travel}\t{force}\t{time}",
        f"mm\t{style.force_unit}\tsec",
        "",
    ]
    rows = _rows(
        "%.6f\t%.5f\t%.6f\r\n", trace, style, trace.elongation * 1e3, trace.force, _time(trace)
    )
    return "\r\n".join(head) + rows


def trapezium(trace: Trace, style: Style) -> str:
    """Shimadzu Trapezium: keys and values of the test, then names, then units, all in quotes."""
    mark, (time, travel, force) = style.separator, style.names(_TRAPEZIUM)
    head = [
        mark.join(f'"{w}"' for w in ("Key Word", "Test Type", "Test Mode", "Operator")),
        mark.join(f'"{w}"' for w in ("", "Tensile", "Single", statement(trace.facts))),
        "",
        f'"1 _ {trace.facts.repeat}"',
        f'"{time}"{mark}"{force}"{mark}"{travel}"',
        f'"sec"{mark}"{style.force_unit}"{mark}"mm"',
        "",
    ]
    form = f'"%.9g"{mark}"%.9g"{mark}"%.9g"\r\n'
    rows = _rows(form, trace, style, _time(trace), trace.force, trace.elongation * 1e3)
    return "\r\n".join(head) + rows


def plain(trace: Trace, style: Style) -> str:
    """Columns between tabs, units in brackets behind the names, decimal commas."""
    time, travel, force = style.names(("Time", "Displacement", "Force"))
    head = [
        statement(trace.facts),
        f"{time} [s]\t{travel} [mm]\t{force} [{style.force_unit}]\n",
    ]
    form = "%.6f\t%.6f\t%.5f\n"
    rows = _rows(form, trace, style, _time(trace), trace.elongation * 1e3, trace.force)
    return "\n".join(head) + rows


LAYOUTS = {
    "own": Layout(
        text=own, ending=".csv", encoding="utf-8", fixed=True, about="layerjam CSV, SI, every digit"
    ),
    "bluehill": Layout(text=bluehill, ending=".csv", encoding="utf-8", about="Instron Bluehill"),
    "testxpert": Layout(
        text=testxpert, ending=".TRA", encoding="latin-1", about="Zwick testXpert"
    ),
    "mts": Layout(text=mts, ending=".txt", encoding="utf-8", about="MTS TestSuite"),
    "trapezium": Layout(
        text=trapezium, ending=".csv", encoding="utf-8-sig", about="Shimadzu Trapezium"
    ),
    "plain": Layout(
        text=plain, ending=".tsv", encoding="cp1252", decimal=",",
        about="columns between tabs, decimal commas",
    ),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Form:
    """The form of one file: a layout, and what differs from what is usual for it."""

    layout: str = "own"
    encoding: str = "usual"
    decimal: str = "usual"
    language: str = "en"

    @property
    def made(self) -> Layout:
        """The layout behind the name."""
        return LAYOUTS[self.layout]

    def settled(self) -> tuple[str, str, str]:
        """Encoding, decimal sign and language as they will be written."""
        made = self.made
        if made.fixed:
            return made.encoding, made.decimal, "en"
        encoding = made.encoding if self.encoding == "usual" else self.encoding
        decimal = made.decimal if self.decimal == "usual" else self.decimal
        return encoding, decimal, self.language

    def possible(self) -> None:
        """Raise QuantityError where the encoding lacks letters of the language."""
        encoding, _, language = self.settled()
        words = "".join(LANGUAGES[language]) + ("²" if self.layout == "testxpert" else "")
        try:
            words.encode(encoding)
        except UnicodeEncodeError as error:
            letter = words[error.start]
            raise QuantityError.of(
                "files.encoding",
                f"{encoding} has no '{letter}', which the layout {self.layout} in "
                f"language '{language}' needs; utf-8 has it",
            ) from None


def file_bytes(trace: Trace, form: Form, force_unit: str = "N", cut: float | None = None) -> bytes:
    """The file of a trace; `cut` ends it in the middle of the line at that part of its rows."""
    encoding, decimal, language = form.settled()
    style = Style(decimal=decimal, language=language, force_unit=force_unit)
    text = form.made.text(trace, style)
    if cut is not None:
        text = _cut_off(text, form, style, len(trace), cut)
    return text.encode(encoding)


def _cut_off(text: str, form: Form, style: Style, rows: int, part: float) -> str:
    """The text up to the second value of a row, half of that row's line."""
    lines = text.splitlines(keepends=True)
    row = len(lines) - rows + min(int(part * rows), rows - 1)
    last = lines[row]
    tabs = form.layout in ("mts", "plain")
    mark = "\t" if tabs else style.separator
    return "".join(lines[:row]) + last[: last.index(mark) + 3]


def write_trace(trace: Trace, path: str | Path, layout: str = "own", force: bool = False) -> Path:
    """Write a trace in a layout, with its sidecar; FileError where one of them exists already."""
    return write_pair(trace, path, file_bytes(trace, Form(layout=layout)), force)


def write_pair(
    trace: Trace, path: str | Path, data: bytes, force: bool, sidecar: bool = True
) -> Path:
    """The data file and its sidecar; neither where one of them exists and `force` is not set."""
    beside = sidecar_path(path)
    if not force:
        for there in (beside, Path(path)):
            if there.exists():
                raise FileError(there, "exists already; --force replaces it")
    # the sidecar first: a file of numbers that was written always has its facts beside it
    if sidecar:
        write_facts(path, replace(trace.facts, synthetic=True), force)
    return write_whole(path, lambda place: _put(place, data), force)


def _put(place: Path, data: bytes) -> None:
    place.write_bytes(data)
