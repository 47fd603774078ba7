"""Records in the style of test machine exports, with one layout per program.

Every file states that it is synthetic, in its text and in its sidecar. The layouts imitate exports;
no machine wrote such a file.
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.store import store_file
from layerjam.laboratory.measure.sidecar import Facts, sidecar_path, write_facts
from layerjam.laboratory.measure.trace import Array, Trace

_DATA: dict[str, Any] = tomllib.loads(
    files("layerjam.laboratory.campaigns").joinpath("layouts.toml").read_text(encoding="utf-8")
)
LANGUAGES: dict[str, tuple[str, ...]] = {
    language: tuple(words) for language, words in _DATA["languages"].items()
}
"""{language: names of time, travel and force, then testXpert's crosshead, travel and force}."""
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252", "cp932")


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Layout of a program: the lines above the numbers, the columns and the defaults.

    `head` contains the header lines: "|" starts a new cell, and words in braces are replaced in
    each file (`_make_header_values`). `columns` contains the format of each column: t, time [s]; x,
    travel [mm]; m, travel [m]; f, force [N]. testXpert also has c, the absolute crosshead position
    [mm], and X and F, its travel and force. `name` and `unit` are the formats of a cell with a name
    or a unit; `second` is the unit of time. `english` contains the names of time, travel and force
    if they differ from `LANGUAGES`. `fixed` means a fixed encoding, decimal sign and language.
    """

    about: str
    ending: str
    encoding: str
    head: Sequence[str]
    columns: Mapping[str, str]
    name: str = '"{name}"'
    unit: str = '"{unit}"'
    second: str = "s"
    newline: str = "\n"
    mark: str = ""
    """Column separator; if empty, a comma, or a semicolon if the decimal sign is a comma."""
    decimal: str = "."
    english: Sequence[str] = ()
    fixed: bool = False


def synthetic_statement(facts: Facts) -> str:
    """Return the statement that every file contains."""
    return f"SYNTHETIC, layerjam {__version__} virtual test machine, seed {facts.seed}"


# {column: (index of its name in LANGUAGES, unit)}
_COLUMNS = {
    "t": (0, "s"),
    "x": (1, "mm"),
    "m": (1, "m"),
    "f": (2, "N"),
    "c": (3, "mm"),
    "X": (4, "mm"),
    "F": (5, "N"),
}
LAYOUTS = {name: Layout(**layout) for name, layout in _DATA["layouts"].items()}


@dataclass(frozen=True, kw_only=True)
class Form:
    """Form of one file: a layout, and choices that differ from the defaults."""

    layout: str = "own"
    encoding: str = "usual"
    decimal: str = "usual"
    language: str = "en"

    @property
    def details(self) -> Layout:
        """Layout whose name is `layout`."""
        return LAYOUTS[self.layout]

    def choices(self) -> tuple[str, str, str]:
        """Return encoding, decimal sign and language of the file."""
        layout = self.details
        if layout.fixed:
            return layout.encoding, layout.decimal, "en"
        encoding = layout.encoding if self.encoding == "usual" else self.encoding
        decimal = layout.decimal if self.decimal == "usual" else self.decimal
        return encoding, decimal, self.language

    def check_encoding(self) -> None:
        """Raise QuantityError if the encoding lacks characters of the language."""
        encoding, _, language = self.choices()
        words = "".join([*LANGUAGES[language], *self.details.head])
        try:
            words.encode(encoding)
        except UnicodeEncodeError as error:
            letter = words[error.start]
            raise QuantityError.of(
                "files.encoding",
                f"{encoding} lacks the character '{letter}', which the layout {self.layout} in "
                f"language '{language}' needs; use utf-8",
            ) from None


def encode_file(trace: Trace, form: Form, force_unit: str = "N", cut: float | None = None) -> bytes:
    """Return the file's bytes; it ends mid-line after `cut` of the rows."""
    if trace.time is None:
        raise QuantityError("a trace without time cannot be written")
    layout, (encoding, decimal, _) = form.details, form.choices()
    mark = layout.mark or ("," if decimal == "." else ";")
    head = [line.replace("|", mark) for line in layout.head]
    words = _make_header_values(trace, form, force_unit, mark)
    text = layout.newline.join([*(line.format(**words) for line in head), ""])
    text += _format_rows(layout, trace, trace.time, mark, decimal)
    if cut is not None:
        text = _truncate_rows(text, mark, len(trace), cut)
    return text.encode(encoding)


def _make_header_values(trace: Trace, form: Form, force_unit: str, mark: str) -> dict[str, object]:
    layout, (_, decimal, language) = form.details, form.choices()
    names: tuple[str, ...] = LANGUAGES[language]
    if language == "en" and layout.english:
        names = (*layout.english, *names[3:])
    units = {"s": layout.second, "N": force_unit}
    pairs = [
        (names[place], units.get(unit, unit))
        for place, unit in (_COLUMNS[c] for c in layout.columns)
    ]
    length = float(np.ptp(trace.elongation)) * 1e3 if len(trace) else 0.0
    speed = (trace.facts.speed or 0.0) * 60e3
    return {
        "version": __version__,
        "said": synthetic_statement(trace.facts),
        "repeat": trace.facts.repeat,
        "length": f"{length:g}".replace(".", decimal),
        "speed": f"{speed:g}".replace(".", decimal),
        "names": mark.join(layout.name.format(name=name, unit=unit) for name, unit in pairs),
        "units": mark.join(layout.unit.format(unit=unit) for _, unit in pairs),
    }


def _format_rows(layout: Layout, trace: Trace, time: Array, mark: str, decimal: str) -> str:
    travel, force, count = trace.elongation * 1e3, trace.force, len(trace)
    every = {"t": time, "m": trace.elongation, "f": force, "F": force}
    every |= {"x": travel, "X": travel, "c": travel + 250.0}
    numbers = np.column_stack([every[c] for c in layout.columns]).ravel().tolist() if count else ()
    # insert the decimal sign last: a comma between columns is not a decimal sign
    row = "\0".join(layout.columns.values()) + layout.newline
    return (row * count % tuple(numbers)).replace(".", decimal).replace("\0", mark)


def _truncate_rows(text: str, mark: str, rows: int, part: float) -> str:
    """Return the text, cut off after the second value of a row in the middle of a line."""
    lines = text.splitlines(keepends=True)
    row = len(lines) - rows + min(int(part * rows), rows - 1)
    last = lines[row]
    return "".join(lines[:row]) + last[: last.index(mark) + 3]


def write_trace(
    trace: Trace, path: str | Path, layout: str = "own", overwrite: bool = False
) -> Path:
    """Write a trace in a layout, with its sidecar; raises FileError if either exists."""
    return write_with_sidecar(trace, path, encode_file(trace, Form(layout=layout)), overwrite)


def write_with_sidecar(
    trace: Trace, path: str | Path, data: bytes, overwrite: bool, sidecar: bool = True
) -> Path:
    """Write the data file and its sidecar; neither if either exists and `overwrite` is not set."""
    sidecar_file = sidecar_path(path)
    if not overwrite:
        for file in (sidecar_file, Path(path)):
            if file.exists():
                raise FileError(file, "already exists; --overwrite replaces it")
    # write the sidecar first, so that a data file is never without metadata
    if sidecar:
        write_facts(path, evolve(trace.facts, synthetic=True), overwrite)
    return store_file(path, data, overwrite)


file_bytes = encode_file  # former name
