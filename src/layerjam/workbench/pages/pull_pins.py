"""Measured pulls pinned to the page Pull: a button to choose them, and what they are called."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from layerjam.workbench.call import Call
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.pull_files import Reading
from layerjam.workbench.pins import Pins
from layerjam.workbench.widgets import button, dressed

TITLE = "Pin a measured curve"


def labels(desk: Desk, reading: Reading) -> dict[str, str]:
    """{key: label} of the pinned files that are drawn."""
    kept = desk.state.files
    named = {one.file.key: one.label for one in reversed(reading.measured)}
    return {key: named[key] for key in kept if key in named}


def beside(desk: Desk, reading: Reading) -> dict[str, tuple[Call, Any]]:
    """{label: (call, result)} of the pinned files, as a chart gives them away."""
    made = {}
    for key, label in labels(desk, reading).items():
        file = next(one.file for one in reading.measured if one.file.key == key)
        own = [pair for pair in reading.understood.record if Path(pair[0].path) == file.path]
        result = replace(reading.understood, record=own)
        made[label] = (Call("pull", files=(file,)), result)
    return made


class PinFiles:
    """A button that pins a dropped pull: at once where there is one, else one of a list."""

    def __init__(self, desk: Desk, pins: Pins) -> None:
        self._desk, self._pins = desk, pins
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
                item = ui.menu_item(text, partial(self._pins.pin_file, key))
                dressed(item, f"pull-pin-file-{key}", role="menuitem")

    def _asked(self) -> None:
        if len(self._names) == 1:
            self._pins.pin_file(next(iter(self._names)))
        else:
            self._menu.open()
