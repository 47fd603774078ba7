"""One tab's desk: its state, the brake and line on it, undo, and who wants to know of changes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue, load
from layerjam.errors import QuantityError
from layerjam.fluid.file import LineFile, lines, load_line
from layerjam.workbench.call import Subject
from layerjam.workbench.state import State, Value

STEPS = 200
"""Undo steps kept."""
PAUSE = 1.5
"""Moves of one control less than this [s] apart are one step."""


class Desk:
    """State with undo; `watch` functions are called after every change with what changed."""

    def __init__(self, state: State | None = None) -> None:
        """Raises LayerjamError where the state's brake or line cannot be read."""
        self.state = state or State()
        self._past: list[State] = []
        self._future: list[State] = []
        self._moved = 0.0
        self._watching: list[Callable[[str], None]] = []
        self.brake = read_any_brake(self.state.brake)
        self.line = read_any_line(self.state.line)
        self.beside = read_any_brake(self.state.beside) if self.state.beside else None

    def watch(self, told: Callable[[str], None]) -> None:
        """Call `told(what)` after changes: "brake", "line", "settings", "undo" or "page"."""
        self._watching.append(told)

    def get(self, page: str, key: str, default: Value) -> Value:
        """A control's value."""
        return self.state.get(page, key, default)

    def put(self, page: str, key: str, value: Value) -> None:
        """Set a control; moves of one control in a row are one step of undo."""
        if self.state.get(page, key, "") == value and key in self.state.settings.get(page, {}):
            return
        last = self._past[-1] if self._past else None
        now = time.monotonic()
        same = (
            last is not None and now - self._moved < PAUSE and self._only_differs(last, page, key)
        )
        self._moved = now
        self._become(self.state.put(page, key, value), "settings", keep=not same)

    def _only_differs(self, last: State, page: str, key: str) -> bool:
        """Whether the last step already was a move of this control."""
        if (last.brake, last.line, last.beside, last.page) != (
            self.state.brake, self.state.line, self.state.beside, self.state.page,
        ):  # fmt: skip
            return False
        pages = {*last.settings, *self.state.settings}
        changed = [
            (p, k)
            for p in pages
            for k in {*last.settings.get(p, {}), *self.state.settings.get(p, {})}
            if last.settings.get(p, {}).get(k) != self.state.settings.get(p, {}).get(k)
        ]
        return changed == [(page, key)]

    def put_brake(self, text: str) -> None:
        """Another brake: a catalogue name or TOML text. Raises LayerjamError."""
        made = read_any_brake(text)
        self.brake = made
        self._become(replace(self.state, brake=text), "brake")

    def put_beside(self, text: str) -> None:
        """A second brake to compare with, none if empty. Raises LayerjamError."""
        self.beside = read_any_brake(text) if text else None
        self._become(replace(self.state, beside=text), "brake")

    def put_line(self, text: str) -> None:
        """Another line: a catalogue name or TOML text. Raises LayerjamError."""
        made = read_any_line(text)
        self.line = made
        self._become(replace(self.state, line=text), "line")

    def open(self, page: str) -> None:
        """Another page; no step of undo."""
        self.state = replace(self.state, page=page)
        self._tell("page")

    def undo(self) -> bool:
        """Back one step; False where there is none."""
        return self._back(self._past, self._future)

    def redo(self) -> bool:
        """Forth one step."""
        return self._back(self._future, self._past)

    def _back(self, source: list[State], target: list[State]) -> bool:
        if not source:
            return False
        target.append(self.state)
        self.state = replace(source.pop(), page=self.state.page)
        self.brake = read_any_brake(self.state.brake)
        self.line = read_any_line(self.state.line)
        self.beside = read_any_brake(self.state.beside) if self.state.beside else None
        self._tell("undo")
        return True

    def _become(self, state: State, what: str, keep: bool = True) -> None:
        if keep:
            self._past.append(self.state)
            del self._past[:-STEPS]
        self._future.clear()
        self.state = state
        self._tell(what)

    def _tell(self, what: str) -> None:
        for told in self._watching:
            told(what)

    def brake_subject(self) -> Subject:
        """The brake as a call takes it: its name, or the file the user can save."""
        if self.state.brake in catalogue():
            return Subject(self.state.brake)
        return Subject(f"{self.brake.name}.toml", self.brake)

    def line_subject(self) -> Subject:
        """The line likewise."""
        if self.state.line in lines():
            return Subject(self.state.line)
        return Subject(f"{self.line.name}.toml", self.line)


def read_any_brake(text: str) -> BrakeFile:
    """A brake by catalogue name or from TOML text; never from a path."""
    if text in catalogue():
        return load(text)
    if "\n" not in text:
        raise QuantityError(f"brake: '{text[:60]}' is not in the catalogue")
    return BrakeFile.read(text, "the brake")


def read_any_line(text: str) -> LineFile:
    """A line by catalogue name or from TOML text; never from a path."""
    if text in lines():
        return load_line(text)
    if "\n" not in text:
        raise QuantityError(f"line: '{text[:60]}' is not in the catalogue")
    return LineFile.read(text, "the line")
