"""The laboratory's results: numbers, checks in words, notes and the figure of each step."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from layerjam.commands.results import Result
from layerjam.report.page import drawn, svg_of, themed
from layerjam.units import show
from layerjam.workbench.pages.laboratory_steps import Done

TITLES = {"friction": "Friction", "calibrate": "Calibration", "validate": "Validation"}
WAITS = {
    "friction": "No friction test among the files: the friction of the brake's own file is used.",
    "calibrate": "No pull to calibrate on yet.",
    "validate": "No pull to validate on yet: hold some back, or drop others.",
}
STYLE = """
.figure { --ground:transparent; --ink:#1c2530; --grey:#5b6672; --grid:#e7ebee; --line:#c9d0d6;
  --shade:#f1f4f6; --v1:#08306b; --v2:#2171b5; --v3:#4f9bcb; --v4:#8c96a0; --blue:#0072b2;
  --orange:#e69f00; --brown:#8a5f00; --red:#d55e00; --sky:#56b4e9; --green:#009e73;
  --purple:#b25b8d; width:100% }
.body--dark .figure { --ink:#e6ebf0; --grey:#a3aeb9; --grid:#2f3842; --line:#3a444f;
  --shade:#1c242c; --v1:#d3e6f8; --v2:#8fc1ea; --v3:#4f9bcb; --v4:#8c96a0; --blue:#8fc1ea;
  --orange:#f0b429; --brown:#f0c46a; --red:#ff8a4c; --sky:#56b4e9; --green:#3fcfa5;
  --purple:#e3a3c6 }
.figure svg { width:100%; height:auto; display:block }
.synthetic { color:#8a4b00; font-weight:600 }
.body--dark .synthetic { color:#f0c46a }
.yes { color:#00684c }
.no { color:#a63d00 }
.body--dark .yes { color:#4cc9a0 }
.body--dark .no { color:#ff9a66 }
"""
_drawing = threading.Lock()
"""Matplotlib's settings are the process's: one figure at a time."""


def picture_of(verb: str, answer: Result) -> str:
    """The verb's figure as SVG whose colours follow the page."""
    with _drawing:
        figure = answer.draw()
        return themed(svg_of(drawn(figure), verb))


def numbers_of(verb: str, answer: Result) -> list[tuple[str, str]]:
    """The step's numbers by name."""
    values = answer.values
    if verb == "friction":
        return [*_coefficients(values), ("Repeats", str(values["repeats"]))]
    if verb == "calibrate":
        return [
            (name.replace("_", " ").capitalize(), _fitted(name, values))
            for name in values["intervals"]
        ]
    before = values["uncalibrated"]
    rows = [
        ("Mean error (MAPE)", f"{values['mape']:.2%}"),
        ("before calibration", f"{before['mape']:.2%}" if before else "–"),
        ("RMSE", show(values["rmse"], "N", 3)),
        ("Pulls", str(len(values["files"]))),
    ]
    if values["r_squared"] is not None:
        rows.insert(3, ("R²", f"{values['r_squared']:.4f}"))
    return rows


def _coefficients(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    made = []
    for name in ("static", "kinetic"):
        value, over = values[name], values["intervals"][name]
        text = "it sticks and slips" if value is None else f"{value:.4f}"
        if value is not None and over and over["low"] is not None:
            text += f" (95 %: {over['low']:.4f} to {over['high']:.4f})"
        made.append((f"{name.capitalize()} friction", text))
    return made


def _fitted(name: str, values: Mapping[str, Any]) -> str:
    unit = "N/m" if name == "stiffness" else "1"

    def text(value: float) -> str:
        return f"{value:.4f}" if unit == "1" else show(value, unit)

    over = values["intervals"][name]
    if over is None:
        return text(values[name])
    return f"{text(values[name])} (95 %: {text(over['low'])} to {text(over['high'])})"


def words_of(done: Done) -> list[str]:
    """What to say of a step besides its checks."""
    if done.answer is None:
        return []
    said = [w for w in done.answer.warnings if getattr(w, "key", "") != "synthetic"]
    unused = done.answer.values["refused"].items()
    refused = [f"{name}: not used, {why}" for name, why in unused]
    pressure = done.answer.values.get("pressure")
    return [*refused, *said] if pressure is None else [*refused, *dict.fromkeys(said)]


class Card:
    """One step's place on the page."""

    def __init__(self, verb: str, buttons: Callable[[], None]) -> None:
        """`buttons` puts more into its head."""
        self.verb = verb
        self._shown: Any = object()
        with ui.card().classes("w-full").props(f'flat bordered data-testid="laboratory-{verb}"'):
            with ui.row().classes("w-full items-center justify-between"):
                ui.label(TITLES[verb]).classes("text-lg font-medium").props('role="heading"')
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
                ui.label(instead or WAITS[self.verb]).classes("opacity-80")
            elif done.answer is None:
                ui.label(done.problem).classes("text-negative").props('role="alert"')
            else:
                self._result(done, done.answer)

    def _result(self, done: Done, answer: Result) -> None:
        with ui.row().classes("w-full items-start gap-8"):
            with ui.grid(columns="auto auto").classes("gap-x-6 gap-y-1 items-baseline"):
                for name, value in numbers_of(self.verb, answer):
                    ui.label(name).classes("text-sm opacity-80")
                    key = name.lower().replace(" ", "-")
                    ui.label(value).classes("text-base font-medium").props(
                        f'data-testid="laboratory-{self.verb}-{key}"'
                    )
            with ui.column().classes("gap-1").style("flex:1; min-width:280px"):
                for check in answer.values.get("checks", ()):
                    _check(check)
        if done.picture:
            ui.html(done.picture, sanitize=False).classes("figure").props(
                f'role="img" aria-label="Figure: {TITLES[self.verb]}"'
            )
        with ui.column().classes("gap-1 text-sm opacity-80"):
            for sentence in words_of(done):
                ui.label(f"Note: {sentence}")


def _check(check: Mapping[str, Any]) -> None:
    with ui.row().classes("no-wrap gap-2 items-baseline"):
        tone, word = ("yes", "✓ ok") if check["passed"] else ("no", "✗ look")
        ui.label(word).classes(f"{tone} font-medium whitespace-nowrap")
        ui.label(f"{check['name']}: {check['sentence']}").classes("text-sm")
