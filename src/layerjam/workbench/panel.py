"""A chart of a page with its pins and its take-away row: all show one computation."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from typing import Any

from nicegui import ui

from layerjam.errors import LayerjamError, QuantityError
from layerjam.report.chart import beside
from layerjam.workbench import live, takeaway
from layerjam.workbench.answer import Answer, Pinned
from layerjam.workbench.call import Call
from layerjam.workbench.charts import options
from layerjam.workbench.desk import Desk
from layerjam.workbench.pins import call_of, labels, pin_of, put_pin, turn_file
from layerjam.workbench.state import MEASURED, Pin
from layerjam.workbench.widgets import Alert, button, chart, dressed, one_line


class Panel:
    """A chart that shows an answer; what is pinned and taken away is that answer too."""

    chart: ui.echart

    def __init__(self, desk: Desk, page: str, ident: str = "", only: str = "") -> None:
        """Where a page has several charts, `ident` names this one, for `only` one command."""
        self._desk, self._page = desk, page
        self._ident, self._only = ident or page, only
        self._known: dict[str, tuple[Answer, Any]] = {}
        self.besides: Callable[[Pin, Any], Any] = lambda pin, result: None
        """What a page computes besides for a pin's result, once; may raise LayerjamError."""
        self._chips: ui.row | None = None
        self._drawn: tuple[tuple[Pin, str], ...] = ()
        self.shown: Answer | None = None
        self.problem = ""

    # ---- what stands on the page

    def build(self, ident: str, what: str, look: str = "", act: Any = None) -> None:
        """The chart; `what` it shows, for those who cannot see it."""
        self.chart = chart(ident, what, look, act)

    def build_row(self) -> ui.row:
        """The buttons that take it away."""
        return takeaway.row(self._ident, self.chart, lambda: self.shown)

    def build_pins(self) -> None:
        """The button to pin, and what is pinned."""
        with ui.row().classes("items-center gap-2"):
            tip = "Keep this curve as a quiet one, to compare with what comes next"
            button("Pin", self.pin, f"{self._ident}-pin", "push_pin", tip=tip)
            self._chips = dressed(ui.row().classes("items-center gap-2"), f"{self._ident}-pins")
        self._alert = Alert(f"{self._ident}-pin-problem", "text-sm")

    def draw(self, answer: Answer | None, made: Mapping[str, Any] | None) -> None:
        """Show an answer as a chart; without a chart it is hidden, and nothing can be taken."""
        self.shown = answer if made else None
        self.chart.set_visibility(made is not None)
        if made:
            live.draw(self.chart, dict(made))
        if self._chips is not None:
            self._fill(self._chips, () if answer is None else answer.pins)

    def show(self, answer: Answer, dark: bool) -> None:
        """Show the figure of an answer's result, with what is pinned beside it."""
        quiet = {label: one.result.quiet_curves() for label, one in answer.beside.items()}
        self.draw(answer, options(beside(answer.result.panes(), quiet), dark))

    def _fill(self, chips: ui.row, pins: tuple[Pinned, ...]) -> None:
        """Show what is pinned; nothing moves where it is the same."""
        if self.problem:
            self._alert.say(self.problem)
        drawn = tuple((one.pin, one.label) for one in pins if one.pin is not None)
        if drawn == self._drawn:
            return
        self._drawn = drawn
        chips.clear()
        with chips:
            for place, (pin, label) in enumerate(drawn):
                with ui.row().classes("items-center gap-0 no-wrap"):
                    ui.label(label).classes("text-sm")
                    act, look = partial(self.unpin, pin), "flat round dense size=sm"
                    gone = button("", act, f"{self._ident}-unpin-{place}", "close", how=look)
                    dressed(gone, aria_label=f"Unpin {label}")

    # ---- pins

    def beside(self, shown: Call) -> tuple[Pinned, ...]:
        """The pinned answers that can be drawn beside a call; in the page's thread."""
        kept: list[tuple[Answer, Any, Pin]] = []
        known, trouble = {}, []
        for pin in self._desk.state.pins:
            elsewhere = pin.page != self._page or (self._only and pin.command != self._only)
            if elsewhere or pin.command == MEASURED:
                continue
            key = json.dumps(asdict(pin), sort_keys=True)
            try:
                known[key] = self._known.get(key) or self._computed(pin)
            except LayerjamError as err:
                trouble.append(one_line(err))
                continue
            if pin.command == shown.name:
                kept.append((*known[key], pin))
        self._known = known
        self.problem = "; ".join(dict.fromkeys(trouble))
        named = labels([answer.call for answer, *_ in kept], shown)
        return tuple(Pinned(name, *one) for name, one in zip(named, kept, strict=True))

    def _computed(self, pin: Pin) -> tuple[Answer, Any]:
        call = call_of(pin)
        result = call.run()
        return Answer(call, result), self.besides(pin, result)

    def pin(self, **more: str) -> None:
        """Keep what is shown, and what is said `more` of it."""
        self._try(partial(self._pin_shown, more))

    def _pin_shown(self, more: Mapping[str, str]) -> None:
        if self.shown is None:
            raise QuantityError("pin: no curve is shown")
        made = pin_of(self._page, self.shown.call)
        put_pin(self._desk, replace(made, options={**made.options, **more}))

    def pin_file(self, key: str) -> None:
        """Keep a dropped file's curve, or let it go."""
        self._try(partial(turn_file, self._desk, key))

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except LayerjamError as err:
            self._alert.say(one_line(err))
        else:
            self._alert.say("")

    def unpin(self, pin: Pin) -> None:
        """Let one go."""
        self._desk.put_pins(tuple(one for one in self._desk.state.pins if one != pin))
