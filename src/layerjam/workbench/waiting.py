"""A line that says what is being computed and how far it is, with a button to stop it."""

from __future__ import annotations

import time

from nicegui import ui

from layerjam.workbench.runner import Runner
from layerjam.workbench.widgets import button, dressed

PATIENCE = 0.6
"""Seconds a computation runs before the page says so."""
LOOK = 0.3


class Waiting:
    """Visible only while a page's runner is at work for longer than a moment."""

    def __init__(self, page: str, runner: Runner) -> None:
        self._runner = runner
        self._since: float | None = None
        self._words, self._share = "", 0.0
        with ui.row().classes("w-full items-center gap-3") as self._row:
            ui.spinner(size="sm")
            self._label = dressed(ui.label("computing"), "", "text-sm", role="status")
            self._bar = ui.linear_progress(value=0, show_value=False).classes("grow")
            button("Stop", runner.stop, f"{page}-stop")
        self._row.set_visibility(False)
        ui.timer(LOOK, self._look)

    def tell(self, what: str, share: float) -> None:
        """A command's progress callback, in its thread; raises Stopped where the user said so."""
        self._words, self._share = what, share
        self._runner.check()

    def _look(self) -> None:
        if not self._runner.running:
            if self._since is not None:
                self._since, self._words, self._share = None, "", 0.0
                self._row.set_visibility(False)
            return
        now = time.monotonic()
        self._since = self._since or now
        if now - self._since > PATIENCE:
            self._row.set_visibility(True)
            self._label.set_text(self._words or "computing; the first time takes some seconds")
            self._bar.set_value(round(self._share, 3))
