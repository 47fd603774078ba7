"""A page's chart with its pins and download buttons, all for one computation."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from typing import Any

from nicegui import ui

from layerjam.core.drawing.chart import add_comparisons
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.workbench import live, takeaway
from layerjam.workbench.answer import Answer, Pinned
from layerjam.workbench.call import Call
from layerjam.workbench.charts import chart_options
from layerjam.workbench.desk import Desk
from layerjam.workbench.pins import add_pin, make_call, make_pin, make_pin_labels, toggle_file_pin
from layerjam.workbench.state import MEASURED, Pin
from layerjam.workbench.widgets import Alert, button, chart, dress, find_error, one_line


class Panel:
    """Panel whose chart shows an answer; pins and downloads use the same answer."""

    chart: ui.echart

    def __init__(self, desk: Desk, page: str, ident: str = "", command: str = "") -> None:
        """Create the panel; `ident` distinguishes panels of a page, `command` limits the pins."""
        self._desk, self._page = desk, page
        self._ident, self._only = ident or page, command
        self._known: dict[str, tuple[Answer, Any]] = {}
        self.compute_extra: Callable[[Pin, Any], Any] = lambda pin, result: None
        """Function that returns the page's additional result for a pin; may raise LayerjamError."""
        self._acts: list[ui.element] = []
        self._chips: ui.row | None = None
        self._drawn: tuple[tuple[Pin, str], ...] = ()
        self.shown: Answer | None = None
        self.problem = ""

    # ---- layout

    def build(self, ident: str, label: str, look: str = "", act: Any = None) -> None:
        """Build the chart; `label` describes it for screen readers."""
        self.chart = chart(ident, label, look, act)

    def build_exports(self) -> ui.row:
        """Build the download buttons."""
        row = takeaway.add_exports(self._ident, self.chart, lambda: self.shown)
        self._acts.append(row)
        self._enable_actions()
        return row

    def build_pins(self) -> None:
        """Build the Pin button and the list of pins."""
        with ui.row().classes("items-center gap-2"):
            tip = "Keep this curve in grey for comparison with the next one"
            self._acts.append(
                button("Pin", self.pin_answer, f"{self._ident}-pin", "push_pin", tip=tip)
            )
            self._enable_actions()
            self._chips = dress(ui.row().classes("items-center gap-2"), f"{self._ident}-pins")
        self._alert = Alert(f"{self._ident}-pin-problem", "text-sm")

    def draw(self, answer: Answer | None, chart: Mapping[str, Any] | None) -> None:
        """Show an answer as `chart`; None hides the chart and disables the downloads."""
        self.shown = answer if chart else None
        self._enable_actions()
        self.chart.set_visibility(chart is not None)
        if chart:
            live.draw_chart(self.chart, dict(chart))
        if self._chips is not None:
            self._fill_pins(self._chips, () if answer is None else answer.pins)

    def _enable_actions(self) -> None:
        """Enable pins and downloads only while a result is displayed."""
        for act in self._acts:
            if self.shown is None:
                act.props("inert")
            elif "inert" in act.props:
                act.props(remove="inert")

    def show(self, answer: Answer, dark: bool) -> None:
        """Show an answer's result as a chart, together with the pinned ones."""
        quiet = {label: pin.result.overlay_curves() for label, pin in answer.pinned_answers.items()}
        self.draw(answer, chart_options(add_comparisons(answer.result.panes(), quiet), dark))

    def _fill_pins(self, chips: ui.row, pins: tuple[Pinned, ...]) -> None:
        if self.problem:
            self._alert.show_error(self.problem)
        items = tuple((pin.pin, pin.label) for pin in pins if pin.pin is not None)
        if items == self._drawn:
            return
        self._drawn = items
        chips.clear()
        with chips:
            for place, (pin, label) in enumerate(items):
                with ui.row().classes("items-center gap-0 no-wrap"):
                    ui.label(label).classes("text-sm")
                    act, look = partial(self.remove_pin, pin), "flat round dense size=sm"
                    unpin_button = button(
                        "", act, f"{self._ident}-unpin-{place}", "close", look=look
                    )
                    dress(unpin_button, aria_label=f"Unpin {label}")

    # ---- pins

    def pinned_answers(self, call: Call) -> tuple[Pinned, ...]:
        """Return the pinned answers that can be drawn with a call; run it in the page's thread."""
        pins: list[tuple[Answer, Any, Pin]] = []
        computed_pins, trouble = {}, []
        for pin in self._desk.state.pins:
            is_foreign = pin.page != self._page or (self._only and pin.command != self._only)
            if is_foreign or pin.command == MEASURED:
                continue
            key = json.dumps(asdict(pin), sort_keys=True)
            try:
                computed_pins[key] = self._known.get(key) or self._compute_pin(pin)
            except LayerjamError as err:
                trouble.append(one_line(err))
                continue
            if pin.command == call.name:
                pins.append((*computed_pins[key], pin))
        self._known = computed_pins
        self.problem = "; ".join(dict.fromkeys(trouble))
        names = make_pin_labels([answer.call for answer, *_ in pins], call)
        return tuple(Pinned(name, *pin) for name, pin in zip(names, pins, strict=True))

    def _compute_pin(self, pin: Pin) -> tuple[Answer, Any]:
        call = make_call(pin)
        result = call.run()
        return Answer(call, result), self.compute_extra(pin, result)

    def pin_answer(self, **more: str) -> None:
        """Pin the displayed answer; `more` contains additional options for the pin."""
        self._alert.show_error(find_error(self._pin_current_answer, more))

    def _pin_current_answer(self, extra: Mapping[str, str]) -> None:
        if self.shown is None:
            raise QuantityError("pin: no curve is shown")
        pin = make_pin(self._page, self.shown.call)
        add_pin(self._desk, replace(pin, options={**pin.options, **extra}))

    def pin_file(self, key: str) -> None:
        """Pin a dropped file's curve, or unpin it."""
        self._alert.show_error(find_error(toggle_file_pin, self._desk, key))

    def remove_pin(self, pin: Pin) -> None:
        """Remove a pin."""
        self._desk.put_pins(tuple(p for p in self._desk.state.pins if p != pin))
