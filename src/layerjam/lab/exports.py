"""Records written as test machines export them: one layout for each machine's software.

Every file says that it is synthetic, in its own text and in the sidecar beside it. The layouts are
imitations, written from what such files look like, not by the machines.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.device.load import write_whole
from layerjam.errors import FileError, QuantityError
from layerjam.measure.sidecar import Facts, sidecar_path, write_facts
from layerjam.measure.trace import Array, Trace

_DATA: dict[str, Any] = tomllib.loads(
    files("layerjam.lab").joinpath("layouts.toml").read_text(encoding="utf-8")
)
LANGUAGES: dict[str, tuple[str, ...]] = {
    language: tuple(words) for language, words in _DATA["languages"].items()
}
"""Names of time, travel and force, then testXpert's for crosshead, travel and force."""
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252", "cp932")


@dataclass(frozen=True, kw_only=True)
class Layout:
    """One software's layout: the lines above its numbers, its columns, and what is usual for it.

    `head` holds the lines, with "|" for the mark between cells and words in braces for what differs
    from file to file (`_said` says which). `columns` holds the format of each column: t, time [s];
    x, travel [mm]; m, travel [m]; f, force [N]; of testXpert c, the absolute crosshead [mm], X and
    F, its travel and force. `name` and `unit` are what a cell of the names and of the units looks
    like, `second` is the unit of time. `english` are the names of time, travel and force where they
    are not those of `LANGUAGES`; `fixed` says that encoding, decimal sign and language are always
    the usual ones.
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
    """Between columns; a comma, or a semicolon beside decimal commas, where it is empty."""
    decimal: str = "."
    english: Sequence[str] = ()
    fixed: bool = False


def statement(facts: Facts) -> str:
    """What stands in every file."""
    return f"SYNTHETIC, layerjam {__version__} virtual test machine, seed {facts.seed}"


# Of each column: the place of its name in LANGUAGES, and its unit.
_COLUMNS = {
    "t": (0, "s"),
    "x": (1, "mm"),
    "m": (1, "m"),
    "f": (2, "N"),
    "c": (3, "mm"),
    "X": (4, "mm"),
    "F": (5, "N"),
}
LAYOUTS = {name: Layout(**about) for name, about in _DATA["layouts"].items()}


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
        words = "".join([*LANGUAGES[language], *self.made.head])
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
    layout, (encoding, decimal, _) = form.made, form.settled()
    mark = layout.mark or ("," if decimal == "." else ";")
    head = [line.replace("|", mark) for line in layout.head]
    said = _said(trace, form, force_unit, mark)
    text = layout.newline.join([*(line.format(**said) for line in head), ""])
    text += _rows(layout, trace, trace.time, mark, decimal)
    if cut is not None:
        text = _cut_off(text, mark, len(trace), cut)
    return text.encode(encoding)


def _said(trace: Trace, form: Form, force_unit: str, mark: str) -> dict[str, object]:
    """What stands for the words in braces of a head."""
    layout, (_, decimal, language) = form.made, form.settled()
    names: tuple[str, ...] = LANGUAGES[language]
    if language == "en" and layout.english:
        names = (*layout.english, *names[3:])
    shown = {"s": layout.second, "N": force_unit}
    pairs = [
        (names[at], shown.get(unit, unit)) for at, unit in (_COLUMNS[c] for c in layout.columns)
    ]
    length = float(np.ptp(trace.elongation)) * 1e3 if len(trace) else 0.0
    speed = (trace.facts.speed or 0.0) * 60e3
    return {
        "version": __version__,
        "said": statement(trace.facts),
        "repeat": trace.facts.repeat,
        "length": f"{length:g}".replace(".", decimal),
        "speed": f"{speed:g}".replace(".", decimal),
        "names": mark.join(layout.name.format(name=name, unit=unit) for name, unit in pairs),
        "units": mark.join(layout.unit.format(unit=unit) for _, unit in pairs),
    }


def _rows(layout: Layout, trace: Trace, time: Array, mark: str, decimal: str) -> str:
    travel, force, count = trace.elongation * 1e3, trace.force, len(trace)
    every = {"t": time, "m": trace.elongation, "f": force, "F": force}
    every |= {"x": travel, "X": travel, "c": travel + 250.0}
    flat = np.column_stack([every[c] for c in layout.columns]).ravel().tolist() if count else ()
    # the mark goes in last: a comma between columns is no decimal sign
    row = "\0".join(layout.columns.values()) + layout.newline
    return (row * count % tuple(flat)).replace(".", decimal).replace("\0", mark)


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
    return write_whole(path, data, force)
