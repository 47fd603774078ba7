"""One tab's desk: its state, its brake and line, undo, and observers of changes."""

import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

from layerjam.brake.commands.edit import edit
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import catalogue, load
from layerjam.brake.fluid.line_file import LineFile, lines, load_line
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.workbench.call import Subject
from layerjam.workbench.state import MEASURED, Pin, State, Value
from layerjam.workbench.uploads import Uploads

STEPS = 200
"""Number of undo steps that are kept."""
PAUSE = 1.5
"""Moves of one control within this time [s] count as one undo step."""


class Desk:
    """State with undo; functions added by `add_watcher` are called after every change."""

    def __init__(self, state: State | None = None) -> None:
        """Raises LayerjamError if the state's brake or line cannot be read."""
        self.state = state or State()
        self.files = Uploads()
        """Files dropped in this tab of the browser, for every page; not in the state."""
        self._past: list[State] = []
        self._future: list[State] = []
        self._moved = ("", "")
        self._when = 0.0
        self._watching: list[tuple[Callable[[str], object], frozenset[str]]] = []
        self.show_tab: Callable[[str], object] = self.open
        """Function that opens the tab of a page; set by the frame."""
        self._load_records()

    def _load_records(self) -> None:
        state = self.state
        brake, line = read_device("brake", state.brake), read_device("line", state.line)
        second = read_device("brake", state.beside) if state.beside else None
        self.brake: BrakeFile = brake
        self.line: LineFile = line
        self.beside: BrakeFile | None = second

    def add_watcher(self, callback: Callable[[str], object], *changes: str) -> None:
        """Call `callback(change)` after each change, or only after these `changes`.

        Changes: "brake", "line", "settings", "moved", "undo", "pins", "page", "files", "waiting"
        (dropped files wait for a decision) and "choosing" (the user wants to add files).
        """
        self._watching.append((callback, frozenset(changes)))

    def announce_files(self) -> None:
        """Notify the watchers that files or sidecars have changed.

        Removing a file also removes its pin. This is not an undo step, because undo cannot restore
        files.
        """
        remaining = self.state.without_files({file.key for file in self.files.files})
        if remaining != self.state:
            self.state = remaining
        self.notify_watchers("files")

    def take_over_files(self, before: "Desk") -> None:
        """Take over a discarded desk's files, with their pins."""
        if not self.files.take_over_files(before.files):
            return
        current = self.state.pins
        pins = (p for p in before.state.pins if p.command == MEASURED and p not in current)
        self.state = replace(self.state, pins=(*current, *pins))
        self.announce_files()

    def get(self, page: str, key: str, default: Value) -> Value:
        """Return a control's value."""
        return self.state.get(page, key, default)

    def put_setting(
        self, page: str, key: str, value: Value, *, single: bool = False, follow: bool = False
    ) -> None:
        """Set a control; successive moves of one control are one undo step, unless `single`.

        With `follow`, the control on the page also moves, because the user did not move it.
        """
        if self.state.find_setting(page, key) == value:
            return
        time_now = time.monotonic()
        is_same_drag = self._moved == (page, key) and time_now - self._when < PAUSE and not single
        self._moved, self._when = (page, key), time_now
        self._set_state(
            self.state.put_setting(page, key, value),
            "moved" if follow else "settings",
            keep=not is_same_drag,
        )

    def put_settings(self, page: str, settings: Mapping[str, Value]) -> None:
        """Set several controls as one undo step; the page's controls follow."""
        state = self.state
        for key, value in settings.items():
            state = state.put_setting(page, key, value)
        if state != self.state:
            self._set_state(state, "undo")

    def restore_state(self, state: State) -> None:
        """Adopt a different state, except for its page, as one undo step.

        Raises LayerjamError, without any change, if its brake or line cannot be read.
        """
        old_state = self.state
        self.state = replace(state, page=old_state.page)
        try:
            self._load_records()
        except LayerjamError:
            self.state = old_state
            raise
        new_state, self.state = self.state, old_state
        self._set_state(new_state, "undo")

    def put_pins(self, pins: tuple[Pin, ...]) -> None:
        """Replace the pinned curves, as one undo step."""
        self._set_state(replace(self.state, pins=pins), "pins")

    def put_file(self, kind: str, text: str) -> None:
        """Set the "brake", the "line" or the second brake ("beside") by catalogue name or TOML.

        An empty text removes the second brake. Raises LayerjamError if the text is invalid.
        """
        file = read_device("line" if kind == "line" else "brake", text) if text else None
        setattr(self, kind, file)
        update: dict[str, Any] = {kind: text}
        self._set_state(replace(self.state, **update), "line" if kind == "line" else "brake")

    def put_brake(self, text: str) -> None:
        """Set a different brake by catalogue name or TOML text; raises LayerjamError."""
        self.put_file("brake", text)

    def open(self, page: str) -> None:
        """Open a different page; this is not an undo step."""
        self.state = replace(self.state, page=page)
        self.notify_watchers("page")

    def undo(self) -> bool:
        """Undo one step; return False if there is none."""
        return self._move_in_history(self._past, self._future)

    def redo(self) -> bool:
        """Redo one step."""
        return self._move_in_history(self._future, self._past)

    def _move_in_history(self, source: list[State], target: list[State]) -> bool:
        if not source:
            return False
        target.append(self.state)
        self.state = replace(source.pop(), page=self.state.page)
        self._load_records()
        self.notify_watchers("undo")
        return True

    def _set_state(self, state: State, change: str, keep: bool = True) -> None:
        if keep:
            self._past.append(self.state)
            del self._past[:-STEPS]
        self._future.clear()
        self.state = state
        self.notify_watchers(change)

    def notify_watchers(self, change: str) -> None:
        """Call the watchers of a change."""
        if change not in ("settings", "moved"):
            self._moved = ("", "")
        for callback, changes in self._watching:
            if not changes or change in changes:
                callback(change)

    def subject(self, kind: str) -> Subject:
        """Return a brake or line as a call's subject: a catalogue name, or a file to save."""
        text, file = getattr(self.state, kind), getattr(self, kind)
        names = SHELVES["line" if kind == "line" else "brake"].names()
        return Subject(text) if text in names else Subject(f"{file.name}.toml", file)

    def brake_subject(self) -> Subject:
        """Return the brake as a call's subject."""
        return self.subject("brake")


@dataclass(frozen=True)
class Shelf:
    """Catalogue of brakes or lines: its names, and readers for a name and for TOML text."""

    names: Callable[[], list[str]]
    load: Callable[[str], Any]
    read: Callable[[str], Any]


SHELVES: Mapping[str, Shelf] = {
    "brake": Shelf(catalogue, load, lambda text: BrakeFile.read(text, "the brake")),
    "line": Shelf(lines, load_line, lambda text: LineFile.read(text, "the line")),
}


def read_device(kind: str, text: str) -> Any:
    """Return a brake or line by catalogue name or from TOML text, never from a path."""
    shelf = SHELVES[kind]
    if text in shelf.names():
        return shelf.load(text)
    if "\n" not in text:
        raise QuantityError(f"{kind}: '{text[:60]}' is not in the catalogue")
    return shelf.read(text)


class Connection(Protocol):
    """Part of NiceGUI's client that this module uses."""

    tab_id: str | None
    """None while no browser is connected."""

    @property
    def is_deleted(self) -> bool:
        """Whether its page is permanently closed."""


_desks: dict[str, tuple[Connection, Desk]] = {}


def move_files(client: Connection, desk: Desk) -> None:
    """Move a tab's files, with their pins and calibrations, from its previous desk to `desk`.

    A tab whose page is still open keeps its files, so a duplicated tab starts without any.
    """
    tab = client.tab_id
    if tab is None:
        return
    former_client, before = _desks.get(tab, (client, desk))
    _desks[tab] = (client, desk)
    if before is not desk and former_client.tab_id is None and not former_client.is_deleted:
        desk.take_over_files(before)


def forget_desk(desk: Desk) -> None:
    """Forget a desk whose page was closed."""
    for tab in [tab for tab, (_, owner) in _desks.items() if owner is desk]:
        del _desks[tab]


def resize_stack(file: BrakeFile, count: int) -> BrakeFile:
    """Return the same brake with a different number of sheets; raises LayerjamError."""
    name = f"{re.sub('-[0-9]+-sheets$', '', file.name)}-{count}-sheets"
    edited_file = edit(file, {"sheets.count": float(count)}, name=name, source="set on the page")
    return BrakeFile.read(edited_file.text, name)


def set_sheets(desk: Desk, count: int) -> None:
    """Change the number of sheets of the desk's brake; raises LayerjamError."""
    desk.put_brake(resize_stack(desk.brake, count).text)
