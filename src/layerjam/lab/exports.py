"""Records written as test machines export them: one layout for each machine's software.

Every file says that it is synthetic, in its own text and in the sidecar beside it. The layouts are
imitations, written from what such files look like, not by the machines.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
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


@dataclass(frozen=True, kw_only=True)
class Style:
    """How one file is written, and what it says of its force's unit (N are the numbers')."""

    trace: Trace
    mark: str
    """Between columns."""
    decimal: str
    names: tuple[str, ...]
    """Of time, travel, force, and what testXpert calls crosshead, travel and force."""
    unit: str

    def line(self, *cells: str, form: str = '"%s"') -> str:
        """One line of the head."""
        return self.mark.join(form % cell for cell in cells)


@dataclass(frozen=True, kw_only=True)
class Layout:
    """One software's layout: the lines above its numbers, its columns, and what is usual for it.

    `columns` holds the format of each column: t, time [s]; x, travel [mm]; m, travel [m]; c, the
    absolute crosshead [mm]; f, force [N]. `english` are the names of time, travel and force where
    they are not those of `LANGUAGES`; `fixed` says that encoding, decimal sign and language are
    always the usual ones.
    """

    about: str
    ending: str
    encoding: str
    head: Callable[[Style], list[str]]
    columns: Mapping[str, str]
    newline: str = "\n"
    mark: str = ""
    """Between columns; a comma, or a semicolon beside decimal commas, where it is empty."""
    decimal: str = "."
    english: tuple[str, ...] = ()
    fixed: bool = False


def statement(facts: Facts) -> str:
    """What stands in every file."""
    return f"SYNTHETIC, layerjam {__version__} virtual test machine, seed {facts.seed}"


def _own(style: Style) -> list[str]:
    said = statement(style.trace.facts)
    head = [f"# layerjam {__version__} measurement", f"# data: {said}"]
    return [*head, f"time [s],elongation [m],force [{style.unit}]"]


def _bluehill(style: Style) -> list[str]:
    operator = style.line("Operator", statement(style.trace.facts))
    units = style.line("s", "mm", style.unit, form='"(%s)"')
    return ['"Sample description"', operator, "", style.line(*style.names[:3]), units, ""]


def _testxpert(style: Style) -> list[str]:
    trace, mark = style.trace, style.mark
    length = float(np.ptp(trace.elongation)) * 1e3 if len(trace) else 0.0

    def line(name: str, number: float, unit: str) -> str:
        text = f"{number:g}".replace(".", style.decimal)
        return f'"{name}"{mark}{text}{mark}"{unit}"'

    time, _, _, crosshead, travel, force = style.names
    return [
        line("Gage length, standard travel", length, "mm"),
        line("Cross-section", 1, "mm²"),
        style.line("Extensometer", ""),
        style.line("Load cell", ""),
        style.line("Operator", statement(trace.facts)),
        line("v1", (trace.facts.speed or 0.0) * 60e3, "mm/min"),
        style.line(time, crosshead, force, travel),
        style.line("s", "mm", style.unit, "mm"),
    ]


def _mts(style: Style) -> list[str]:
    time, travel, force = style.names[:3]
    return [
        "MTS TestSuite",
        "Data Acquisition: Timed",
        f"Station Name: {statement(style.trace.facts)}",
        f"Test Run Name: repeat {style.trace.facts.repeat}",
        "",
        style.line(travel, force, time, form="%s"),
        style.line("mm", style.unit, "sec", form="%s"),
    ]


def _trapezium(style: Style) -> list[str]:
    time, travel, force = style.names[:3]
    return [
        style.line("Key Word", "Test Type", "Test Mode", "Operator"),
        style.line("", "Tensile", "Single", statement(style.trace.facts)),
        "",
        f'"1 _ {style.trace.facts.repeat}"',
        style.line(time, force, travel),
        style.line("sec", style.unit, "mm"),
    ]


def _plain(style: Style) -> list[str]:
    time, travel, force = style.names[:3]
    names = style.line(f"{time} [s]", f"{travel} [mm]", f"{force} [{style.unit}]", form="%s")
    return [statement(style.trace.facts), names]


LAYOUTS = {
    "own": Layout(
        about="layerjam CSV, SI, every digit",
        ending=".csv",
        encoding="utf-8",
        head=_own,
        columns={"t": "%r", "m": "%r", "f": "%r"},
        fixed=True,
    ),
    "bluehill": Layout(
        about="Instron Bluehill",
        ending=".csv",
        encoding="utf-8",
        head=_bluehill,
        columns={"t": '"%.6f"', "x": '"%.6f"', "f": '"%.5f"'},
        newline="\r\n",
    ),
    "testxpert": Layout(
        about="Zwick testXpert",
        ending=".TRA",
        encoding="latin-1",
        head=_testxpert,
        columns={"t": "%.6g", "c": "%.6g", "f": "%.6g", "x": "%.6g"},
    ),
    "mts": Layout(
        about="MTS TestSuite",
        ending=".txt",
        encoding="utf-8",
        head=_mts,
        columns={"x": "%.6f", "f": "%.5f", "t": "%.6f"},
        newline="\r\n",
        mark="\t",
        english=("Time", "Crosshead", "Load"),
    ),
    "trapezium": Layout(
        about="Shimadzu Trapezium",
        ending=".csv",
        encoding="utf-8-sig",
        head=_trapezium,
        columns={"t": '"%.9g"', "f": '"%.9g"', "x": '"%.9g"'},
        newline="\r\n",
        english=("Time", "Stroke", "Force"),
    ),
    "plain": Layout(
        about="columns between tabs, decimal commas",
        ending=".tsv",
        encoding="cp1252",
        head=_plain,
        columns={"t": "%.6f", "x": "%.6f", "f": "%.5f"},
        mark="\t",
        decimal=",",
        english=("Time", "Displacement", "Force"),
    ),
}


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
    if trace.time is None:
        raise QuantityError("a trace without time cannot be written")
    layout, (encoding, decimal, language) = form.made, form.settled()
    names: tuple[str, ...] = LANGUAGES[language]
    if language == "en" and layout.english:
        names = (*layout.english, *names[3:])
    mark = layout.mark or ("," if decimal == "." else ";")
    style = Style(trace=trace, mark=mark, decimal=decimal, names=names, unit=force_unit)
    head = layout.newline.join([*layout.head(style), ""])
    text = head + _rows(layout, style, trace.time)
    if cut is not None:
        text = _cut_off(text, mark, len(trace), cut)
    return text.encode(encoding)


def _rows(layout: Layout, style: Style, time: np.ndarray) -> str:
    """All rows in one go."""
    travel = style.trace.elongation * 1e3
    every = {"t": time, "x": travel, "c": travel + 250.0, "f": style.trace.force}
    every["m"] = style.trace.elongation
    flat = np.column_stack([every[c] for c in layout.columns]).ravel().tolist() if len(time) else ()
    # the mark goes in last: a comma between columns is no decimal sign
    row = "\0".join(layout.columns.values()) + layout.newline
    text = (row * len(time)) % tuple(flat)
    return text.replace(".", style.decimal).replace("\0", style.mark)


def _cut_off(text: str, mark: str, rows: int, part: float) -> str:
    """The text up to the second value of a row, half of that row's line."""
    lines = text.splitlines(keepends=True)
    row = len(lines) - rows + min(int(part * rows), rows - 1)
    last = lines[row]
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
