"""The laboratory's results: numbers, checks in words, notes and the figure of each step."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from layerjam.commands.results import in_words
from layerjam.report.page import drawn, svg_of, themed
from layerjam.workbench.call import key_of, result_fields
from layerjam.workbench.pages.laboratory_steps import Done
from layerjam.workbench.widgets import dressed, hint, named

TITLES = {"friction": "Friction", "calibrate": "Calibration", "validate": "Validation"}
WAITS = {
    "friction": "No friction test among the files: the friction of the brake's own file is used.",
    "calibrate": "No pull to calibrate on yet.",
    "validate": "No pull to validate on yet: hold some back, or drop others.",
}
_drawing = threading.Lock()
"""Matplotlib's settings are the process's: one figure at a time."""


def picture_of(name: str, result: Any) -> str:
    """The figure of a result as SVG whose colours follow the page."""
    with _drawing:
        return themed(svg_of(drawn(result.draw()), name))


def numbers_of(result: Any) -> list[tuple[str, str, str]]:
    """(key, name, text) of the step's numbers, with the 95 % interval where there is one."""
    over = getattr(result, "intervals", None) or {}
    made = []
    for f in result.keys():  # noqa: SIM118
        value, unit = getattr(result, f.name), result.units.get(f.name)
        if f.name == "kinetic" and value is None:
            made.append((f.name, "Kinetic", "it sticks and slips"))
        if unit is None or not f.metadata["listed"] or value is None:
            continue

        def text(number: float, shown: Any = f.metadata["shown"], unit: str = unit) -> str:
            return str(shown(number)) if shown else in_words(number, unit)

        said, span = text(value), over.get(f.name)
        if span and span["low"] is not None:
            said += f" (95 %: {text(span['low'])} to {text(span['high'])})"
        made.append((f.name, named(f.name), said))
    before = getattr(result, "uncalibrated", None)
    if before:
        made.append(("before", "MAPE before calibration", f"{before['mape']:.2%}"))
    if hasattr(result, "uncalibrated"):
        made.append(("pulls", "Pulls", str(len(result.files))))
    return made


def words_of(done: Done) -> list[str]:
    """What to say of a step besides its checks; that files are synthetic stands above already."""
    if done.result is None:
        return []
    said = [w for w in done.result.warnings if key_of(w) != "synthetic"]
    refused = [f"{name}: not used, {why}" for name, why in done.result.refused.items()]
    return [*refused, *dict.fromkeys(said)]


class Card:
    """One step on the page."""

    def __init__(self, name: str, buttons: Callable[[], None]) -> None:
        """`buttons` puts more into its head."""
        self.name = name
        self._shown: Any = object()
        with dressed(ui.card(), f"laboratory-{name}", "w-full", "flat bordered"):
            with ui.row().classes("w-full items-center justify-between"):
                title = ui.label(TITLES[name])
                dressed(title, "", "text-lg font-medium", role="heading")
                with ui.row().classes("gap-2"):
                    buttons()
            self._box = ui.column().classes("w-full gap-2")

    def fill(self, done: Done | None, instead: str = "") -> None:
        """Show a result; `instead` where there is none."""
        shown = done or instead
        if self._shown == shown if isinstance(shown, str) else self._shown is shown:
            return
        self._shown = shown
        self._box.clear()
        with self._box:
            if done is None:
                ui.label(instead or WAITS[self.name]).classes("opacity-80")
            elif done.result is None:
                dressed(ui.label(done.problem), "", "text-negative", role="alert")
            else:
                self._result(done, done.result)

    def _result(self, done: Done, result: Any) -> None:
        told = result_fields(self.name)
        with ui.row().classes("w-full items-start gap-8"):
            with ui.grid(columns="auto auto").classes("gap-x-6 gap-y-1 items-baseline"):
                for key, name, value in numbers_of(result):
                    hint(name).tooltip(told.get(key, name))
                    ident = f"laboratory-{self.name}-{key.replace('_', '-')}"
                    dressed(ui.label(value), ident, "text-base font-medium")
            with ui.column().classes("gap-1").style("flex:1; min-width:280px"):
                for check in result.values.get("checks", ()):
                    _check(check)
        if done.picture:
            about = f"Figure: {TITLES[self.name]}"
            picture = ui.html(done.picture, sanitize=False)
            dressed(picture, "", "figure", role="img", aria_label=about)
        with ui.column().classes("gap-1"):
            for sentence in words_of(done):
                hint(f"Note: {sentence}")


def _check(check: Mapping[str, Any]) -> None:
    with ui.row().classes("no-wrap gap-2 items-baseline"):
        tone, word = ("yes", "✓ ok") if check["passed"] else ("no", "✗ look")
        ui.label(word).classes(f"{tone} font-medium whitespace-nowrap")
        ui.label(f"{check['name']}: {check['sentence']}").classes("text-sm")
