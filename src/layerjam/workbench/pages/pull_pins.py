"""Measured pulls pinned to the page Pull: a button to choose them, and what they are called."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

from nicegui import ui

from layerjam.workbench.answer import Answer, Pinned
from layerjam.workbench.call import Call
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.pull_files import Reading
from layerjam.workbench.panel import Panel
from layerjam.workbench.state import MEASURED
from layerjam.workbench.widgets import button, dressed

TITLE = "Pin a measured curve"


def pinned(desk: Desk, reading: Reading) -> tuple[Pinned, ...]:
    """The measured curves that are pinned and there, each with its file's own answer."""
    named, made = {one.file.key: one for one in reversed(reading.measured)}, []
    for pin in desk.state.pins:
        one = named.get(pin.subject) if pin.command == MEASURED else None
        if one is not None:
            path, record = one.file.path, reading.understood.record
            own = [pair for pair in record if Path(pair[0].path) == path]
            result = replace(reading.understood, record=own)
            made.append(Pinned(one.label, Answer(Call("pull", files=(one.file,)), result), pin=pin))
    return tuple(made)


class PinFiles:
    """A button that pins a dropped pull: at once where there is one, else one of a list."""

    def __init__(self, desk: Desk, panel: Panel) -> None:
        self._desk, self._panel = desk, panel
        self._names: Mapping[str, str] = {}
        self._shown: object = None
        self._button = button(TITLE, self._asked, "pull-pin-file", "push_pin")
        with self._button:
            where = f'no-parent-event auto-close role="region" aria-label="{TITLE}"'
            with ui.menu().props(where) as self._menu:
                self._list = dressed(ui.element("div"), role="menu", aria_label=TITLE)
        self._button.set_visibility(False)

    def fill(self, reading: Reading) -> None:
        """Show the pulls of now; nothing moves where they are the same."""
        kept = self._desk.state.files
        self._names = {one.file.key: one.about for one in reversed(reading.measured)}
        shown = (tuple(self._names.items()), kept)
        if shown == self._shown:
            return
        self._shown = shown
        self._button.set_visibility(len(self._names) > 1 or bool(self._names.keys() - {*kept}))
        self._list.clear()
        with self._list:
            for key, name in reversed(self._names.items()):
                text = f"✓ {name}" if key in kept else name
                item = ui.menu_item(text, partial(self._panel.pin_file, key))
                dressed(item, f"pull-pin-file-{key}", role="menuitem")

    def _asked(self) -> None:
        if len(self._names) == 1:
            self._panel.pin_file(next(iter(self._names)))
        else:
            self._menu.open()
