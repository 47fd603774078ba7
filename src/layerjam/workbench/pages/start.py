"""Start: a layer-jamming brake in ten seconds, with links to the other pages."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any

from nicegui import ui

from layerjam.brake.device.load import devices, load
from layerjam.core.drawing.style import GREY
from layerjam.core.units import parse, show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer, try_call
from layerjam.workbench.call import Call
from layerjam.workbench.charts import chart_options, round_up
from layerjam.workbench.controls import Control, map_keys, vacuum_control
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Page
from layerjam.workbench.pages.drop_outcome import Animation, time_series
from layerjam.workbench.pages.records import build_open_button
from layerjam.workbench.scene import StackView, build_stack, describe_stack
from layerjam.workbench.widgets import Alert, button, chart, columns, dress, heading, hint, status

INTRODUCTION = (
    "A layer-jamming brake is a stack of thin sheets in a soft, airtight enclosure. Pump "
    "the air out, and the atmosphere presses the sheets together: sheets that slid "
    "freely now resist."
)
PULL, HELD = MappingProxyType({"speed": "1 mm/s"}), 0.04
"""Speed and maximum travel [m] of the pull on this page; short sheets limit the travel."""
FALL = MappingProxyType({"mass": "1 kg", "height": "30 cm"})
"""Mass and height of the button's drop, which has no rope."""
MM, DIGITS = 1e3, 3


class Start(Page):
    """Page with a slider for the vacuum, the brake and its force."""

    name = "start"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.dropped = False
        """Whether the button was pressed; from then on, the drop is computed at every vacuum."""
        self._play = False
        self._full: tuple[object, Any] = (None, None)

    def controls(self) -> Mapping[str, Control]:
        """Return the control for the vacuum."""
        return map_keys(vacuum_control("tensile", "vacuum", self.desk.brake.brake.site.atmosphere))

    def build(self) -> None:
        """Build introduction, slider and cards on the left; force, view and chart on the right."""
        with ui.column().classes("page-head gap-1"):
            heading("Sheets that slide until the air is pumped out", 1)
            dress(ui.label(INTRODUCTION), "start-what", "start-say")
        side, main = columns("start-page", all_shown=True)
        with side:
            with ui.column().classes("w-full gap-3 start-set"):
                self.add_slider("vacuum")
                button("Drop a kilogram", self._drop_mass, "start-drop", "south", look="no-caps")
                self.add_alert()
            self._build_cards()
        with main:
            with ui.row().classes("items-baseline gap-x-4 gap-y-0 start-force"):
                dress(ui.label("resists up to"), "", "text-base")
                self.hero = dress(live.Words("–"), "start-force", "start-hero")
                self.words = status("start-words", "text-base")
            with ui.element("div").classes("start-row"):
                with ui.element("div").classes("start-seen"):
                    self.view = StackView("start-scene", "start-view", views=False)
                label = "Force versus elongation at this vacuum"
                self.chart = dress(chart("start-chart", label, "width: 100%"), "", "start-chart")
                self.stage = ui.element("div").classes("start-stage")
            self.happened = status("start-happened", "text-base start-happened")
        with self.stage:
            self.animation = Animation()
        self.stage.set_visibility(self.dropped)
        self._show_stack(self.value("vacuum"))

    def _show_stack(self, vacuum: float) -> None:
        brake = self.desk.brake.brake
        stack = build_stack(brake, 0.0, vacuum / brake.site.atmosphere)
        self.view.show(stack, describe_stack(brake, stack, 0.0), self.dark)

    def _build_cards(self) -> None:
        with ui.element("div").classes("start-cards"):
            with self._build_card("Try", "A different brake from the catalogue:"):
                self.tried = {}
                with ui.row().classes("gap-2"):
                    for name in devices():
                        title = (load(name).title or name).rpartition(", ")[2]
                        put = partial(self.desk.put_brake, name)
                        self.tried[name] = button(title, put, f"start-try-{name}")
            with self._build_card("My brake", "Its numbers, each with its source:"):
                problem = Alert("start-brake-problem")
                with ui.row().classes("gap-2"):
                    turn = partial(self.desk.show_tab, "brake")
                    button("Change this brake", turn, "start-edit", "edit")
                    build_open_button(self.desk, "brake", self.name, problem)
            with self._build_card("My files", "Friction tests and pulls from a test machine:"):
                choose = partial(self.desk.notify_watchers, "choosing")
                button("Drop or choose files", choose, "start-files", "upload_file")
        self.desk.add_watcher(lambda _: self._mark_current(), "brake", "undo")
        self._mark_current()

    @staticmethod
    def _build_card(title: str, text: str) -> ui.column:
        with ui.column().classes("start-card") as card:
            heading(title)
            hint(text)
        return card

    def _mark_current(self) -> None:
        for name, button_ in self.tried.items():
            dress(button_, aria_pressed=str(name == self.desk.state.brake).lower())

    def _drop_mass(self) -> None:
        self.dropped = self._play = True
        self.stage.set_visibility(self.dropped)
        self.refresh()

    def calls(self) -> Sequence[Call]:
        """Return the calls for the pull and, once requested, for the drop."""
        subject, vacuum = (self.desk.brake_subject(),), self.texts("vacuum")
        travel = show(min(HELD, self.desk.brake.brake.sheets.usable_travel), "m", 15)
        pull = Call("tensile", subject, {**vacuum, **PULL, "elongation": travel})
        return [pull, Call("drop", subject, {**FALL, **vacuum})] if self.dropped else [pull]

    def compute(self) -> Any:
        """Return the pull, the pull at full vacuum (once for each brake), and the drop."""
        pull, *drops = self.calls()
        answer = Answer(pull, pull.run())
        if self._full[0] != pull.subjects[0].text:
            control = self.controls()["vacuum"]
            full = {**pull.options, "vacuum": control.text(control.high)}
            full_pull = Call("tensile", pull.subjects, full).run()
            self._full = (pull.subjects[0].text, full_pull)
        return answer, self._full[1], *map(try_call, drops)

    def draw(self, result: Any) -> None:
        """Show the brake, its peak force, its force curve, and the outcome of the drop."""
        answer, full, *fall = result
        pull, brake = answer.result, self.desk.brake.brake
        vacuum = parse(answer.call.options["vacuum"], "Pa", "vacuum")
        self.hero.set_text(show(pull.peak_force, "N", DIGITS))
        self.words.set_text(holding_sentence(pull, brake.site.gravity))
        live.draw_chart(self.chart, force_chart(pull, full, self.dark))
        self._show_stack(vacuum)
        if not fall:
            return
        stop = fall[0].result
        self.happened.set_text(drop_sentence(stop, fall[0].refusal))
        record = stop.record if stop is not None and stop.feasible else None
        self.animation.load_series(None if record is None else time_series(record))
        if self._play:
            self._play = False
            self.animation.play()


def holding_sentence(pull: Any, gravity: float) -> str:
    """Return a sentence with the peak force of a pull, and the mass that weighs as much."""
    force = show(pull.peak_force, "N", DIGITS)
    if pull.peak_elongation >= pull.record.elongation[-1]:
        stretch = show(pull.peak_elongation, "m", 2)
        return (
            f"The sheets do not resist yet: stretched {stretch}, the enclosure pulls with {force}."
        )
    mass = show(round_down_digits(pull.peak_force / gravity), "kg", DIGITS)
    return f"The brake resists a pull of up to {force}, the weight of {mass}."


def round_down_digits(value: float, digits: int = DIGITS) -> float:
    """Round a positive number down to the given number of significant digits."""
    step = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    return math.floor(value / step + 1e-9) * step


def drop_sentence(stop: Any | None, refusal: str) -> str:
    """Return the outcome of the drop as a sentence."""
    begins = f"{FALL['mass']} falls {FALL['height']}"
    if stop is None:
        return f"{begins}: {refusal}"
    if not stop.feasible:
        return f"{begins}: {stop.reason}"
    if stop.outcome == "BOTTOMED_OUT":
        return (
            f"{begins}: too little vacuum. The mass uses up all {show(stop.slip, 'm', 3)} "
            f"of travel and still moves at {show(stop.end_speed, 'm/s', 2)}."
        )
    if stop.outcome == "NEVER_SLID":
        return f"{begins}: the brake holds the mass, and no sheet slides."
    return (
        f"{begins}: the brake slips {show(stop.slip, 'm', 3)} and stops the mass within "
        f"{show(stop.stopping_time, 's', 2)}, at up to {show(stop.peak_g, '1', 3)} g."
    )


def force_chart(pull: Any, full: Any, dark: bool) -> dict[str, Any]:
    """Return the chart of force versus elongation, with full vacuum as a thin line."""
    pane, full_curve = pull.panes()[0], full.panes()[0].curves[0]
    quiet = replace(full_curve, color=GREY, name="full", dash="dashed", width=1.2)
    curves = [replace(pane.curves[0], width=3.5), quiet]
    ends, top = (0.0, float(full_curve.x[-1])), (0.0, round_up(full.peak_force))
    marks = [(x, y, "", color) for x, y, _, color in pane.marks]  # the page shows the number
    pane = replace(pane, curves=curves, marks=marks, x_range=ends, y_range=top)
    return chart_options([pane], dark)
