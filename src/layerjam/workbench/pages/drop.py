"""Drop: a mass stopped by the rope alone, at full vacuum, or at a vacuum tuned to a travel."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from nicegui import ui

from layerjam.brake.commands.drop import failed_run
from layerjam.brake.commands.tuning import SEARCHES
from layerjam.core.units import show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer, Pinned, try_call
from layerjam.workbench.call import Call, Options
from layerjam.workbench.controls import (
    Choice,
    Control,
    add_choice,
    add_menu,
    control,
    map_keys,
    vacuum_control,
)
from layerjam.workbench.desk import Desk, read_device
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.page import Notes, Page
from layerjam.workbench.pages.drop_outcome import (
    GOOD,
    MODES,
    SAFE,
    SLOW,
    Advice,
    Animation,
    await_intervals,
    describe_drop,
    drop_chart,
    drop_tables,
    headlines,
    list_notes,
    time_series,
)
from layerjam.workbench.panel import Panel
from layerjam.workbench.runner import Part, Runner
from layerjam.workbench.widgets import Heroes, columns, dress, fold, status

ARRIVES = Choice(
    "arrives",
    {"speed": "speed", "height": "height"},
    "speed",
    label="Specified as",
    help="Speed when the rope becomes taut, or height of the fall until then",
)
DIRECTION = Choice(
    "direction",
    {"falling": "falling", "horizontal": "horizontal"},
    "falling",
    help="Horizontal: no gravity along the pull",
)
ON_ROPE = Choice(
    "on_rope",
    {"rope": "a rope", "none": "none"},
    "rope",
    label="Rope",
    help="Without a rope, the mass hangs directly on the brake",
)
SHOWN = Choice(
    "shown",
    {key: MODES[key] for key in ("none", "full", "tuned", "value")},
    "tuned",
    label="Vacuum",
    help="No brake: the mass on the rope alone. Tuned: the vacuum that uses all the travel",
)
SLOWLY = Choice(
    "slow",
    {"auto": "automatic", **{f"{s:g}": f"{s:g} ×" for s in SLOW}},
    "auto",
    label="Slow motion",
)
NO_ROPE = "there is neither a rope nor a brake, so nothing holds the mass"
KEYS = ("mass", "speed", "height", "vacuum", "travel", "rope_stiffness", "no_brake", "horizontal")
"""Inputs of `drop` that have a control on the page; the "More" panel has the others."""
TUNED = (
    *("mass", "speed", "height", "rope_stiffness", "horizontal", "travel", "atmosphere", "film"),
    "interval",
)
"""Inputs that `drop` and `tune` share."""
HISTORY = ("vacuum_history", "reading", "columns", "decimal")
"""Inputs that specify a vacuum history, which replaces the vacuum."""


class Drop(Page):
    """Page to drop a mass and see it stop: with no brake, at full vacuum, or at a tuned vacuum."""

    name, title = "drop", "Drop"
    summary = "The brake stops a falling mass"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.more = OtherInputs(self, "drop", KEYS)
        self.all_numbers = ""
        self._part: Drops | None = None
        """The part of a result that is drawn already."""
        self.panel = Panel(desk, self.name)

    def controls(self) -> Mapping[str, Control]:
        """Return the controls, with the bounds that the brake sets."""
        brake = self.desk.brake.brake
        usable = brake.sheets.usable_travel
        full_vacuum = self.more.atmosphere(brake.site.atmosphere)
        travel = control(
            "drop", "travel", min(0.04, usable), (0.001, usable), label="Stopping travel"
        )
        rope = control("drop", "rope_stiffness", 16.8e3, (500.0, 100e3), label="Rope stiffness")
        return map_keys(
            control("drop", "mass", 1.0, (0.05, 10.0), unit="kg"),
            control("drop", "speed", 1.5, (0.05, 6.0), unit="m/s"),
            control("drop", "height", 0.1, (0.005, 2.0), unit="m"),
            rope,
            travel.narrow_bounds(high=usable),
            vacuum_control("drop", "vacuum", full_vacuum),
            control(
                "tune", "confidence", SAFE, (0.5, 0.99), label="Share of stops within the travel"
            ),
        )

    def build(self) -> None:
        """Build controls on the left, and table, stage and charts on the right."""
        desk, name = self.desk, self.name
        side, main = columns()
        with side:
            self.add_slider("mass")
            add_choice(desk, name, DIRECTION)
            with self.show_while(lambda: not self._is_horizontal()):
                add_choice(desk, name, ARRIVES)
            self.add_slider("speed", lambda: self._arrival_option() == "speed")
            self.add_slider("height", lambda: self._arrival_option() == "height")
            add_choice(desk, name, ON_ROPE)
            self.add_slider("rope_stiffness", self._has_rope)
            self.add_slider("travel")
            self.add_slider("confidence", lambda: self.word(SHOWN) == "tuned")
            add_choice(desk, name, SHOWN)
            self.add_slider("vacuum", lambda: self.word(SHOWN) == "value")
            add_menu(desk, name, SLOWLY)
            self.more.build()
            self.add_alert()
        with main:
            self.heroes = Heroes(name)
            self.verdict = status("drop-verdict", "text-lg")
            self.advice = Advice(self.desk)
            self.table = dress(live.Table(), "drop-table", "w-full plain-scroll")
            with ui.row().classes("w-full items-start gap-4"):
                stage = ui.column().classes("drop-side")
                with ui.element("div").style("flex: 1; min-width: 300px; position: relative"):
                    label = "Force, displacement and deceleration over time"
                    look = "width: 100%; height: max(460px, 62vh)"
                    self.panel.build("drop-chart", label, look)
                    cursor = ui.element("div")
                with stage:
                    self.animation = Animation(self.panel.chart, cursor)
            with ui.row().classes("w-full items-center gap-x-6"):
                self.panel.build_pins()
                self.panel.build_exports()
            with fold("All numbers", "drop-numbers") as self.numbers:
                self.others = dress(live.Table(), "drop-others", "w-full plain-scroll")
            self.numbers.on_value_change(self._fill_numbers)
            self.bound = dress(live.Words(""), "drop-bound", "text-sm")
            self.notes = Notes()

    def _fill_numbers(self) -> None:
        if self.numbers.value:
            self.others.set_content(self.all_numbers)

    def _is_horizontal(self) -> bool:
        return self.word(DIRECTION) == "horizontal"

    def _has_rope(self) -> bool:
        return self.word(ON_ROPE) == "rope"

    def _arrival_option(self) -> str:
        """Return "speed" or "height", whichever is given; a horizontal stop has no height."""
        return "speed" if self._is_horizontal() else self.word(ARRIVES)

    def table_calls(self) -> dict[str, Call]:
        """Return {mode: call} for the columns of the table."""
        control = self.controls()["vacuum"]
        other_options = self.more.options()
        history = {key: other_options.pop(key) for key in HISTORY if key in other_options}
        if not self._has_rope():
            other_options.pop("rope_damping", None)
        # without a brake, neither a vacuum nor a duration applies
        bare_options = {key: value for key, value in other_options.items() if key != "duration"}
        modes: dict[str, Options] = {
            **({"none": {"no_brake": True, **bare_options}} if self._has_rope() else {}),
            "full": {"vacuum": control.text(control.spec.hi), **other_options},
            "tuned": {"vacuum": "tuned", "travel": self.text("travel"), **other_options},
        }
        if self.word(SHOWN) == "value":
            modes["value"] = {"vacuum": self.text("vacuum"), **other_options}
        if "vacuum_history" in history:
            modes["history"] = {**history, **other_options}
        subject, common = self.desk.brake_subject(), self._common_options()
        return {
            mode: Call("drop", (subject,), {**common, **mode_options})
            for mode, mode_options in modes.items()
        }

    def _common_options(self) -> Options:
        rope = ["rope_stiffness"] if self._has_rope() else []
        inputs = self.texts("mass", self._arrival_option(), *rope)
        if self._is_horizontal():
            inputs["horizontal"] = True
        return inputs

    def calls(self) -> Sequence[Call]:
        """Return the calls for the drops in the table, and for the tuning and its bound."""
        drops = self.table_calls()
        return [*drops.values(), self._tuning_call(drops["tuned"])]

    def compute(self) -> Any:
        """Compute each drop separately, so that an error in one does not affect the others."""
        return self.begin().finish()

    def begin(self) -> Part:
        """Return the drop that is shown; intervals and the others of the table follow."""
        calls = self.table_calls()
        view = "history" if "history" in calls else self.word(SHOWN)
        tuning = try_call(self._tuning_call(calls["tuned"]), searches=())
        pins = self.panel.pinned_answers(calls.get(view, calls["full"]))
        first = Drops(calls, view, {}, tuning, pins, self.runner, has_intervals=False)
        first.compute(view)
        first.compute(first.chart_mode)
        return Part(first, partial(self._finish, first))

    def _finish(self, first: "Drops") -> Any:
        # the page shows no speeds, so only its first result has those that the command prints
        searches = SEARCHES if self.result is None else ("safety", "alternatives")
        tuning = try_call(first.tuning.call, searches=searches)
        drops = first._replace(answers={}, tuning=tuning, has_intervals=True)
        modes = dict.fromkeys((*drops.calls, "none"))
        for mode in modes:
            drops.compute(mode)
        return drops.view, {mode: drops.answers[mode] for mode in modes}, drops.tuning, drops.pins

    def _tuning_call(self, drop: Call) -> Call:
        """Return the call that tunes the vacuum of a drop."""
        options = {key: drop.options[key] for key in TUNED if key in drop.options}
        if self.value("confidence") != SAFE:
            options |= self.texts("confidence")
        return Call("tune", drop.subjects, options)

    def answers(self) -> Sequence[Answer]:
        """Return the answers for the drops in the table, and for the tuning."""
        if self.result is None:
            return []
        _, drops, tuning, _ = self.result
        return [*(answer for answer in drops.values() if answer.refusal != NO_ROPE), tuning]

    def draw_part(self, part: "Drops") -> None:
        """Show verdict, stage and charts, which belong to the drop that is shown."""
        self._draw_stop(part)
        self._part = part
        self.advice.hide()

    def draw(self, result: Any) -> None:
        """Show verdict, stage, charts and table."""
        view, answers, tuning, pins = result
        drops = Drops({}, view, answers, tuning, pins, self.runner)
        if self._part is not None and drops.continues(self._part):
            self._draw_numbers(drops)
        else:
            self._draw_stop(drops)
        self._part = None
        if drops.is_stopped or tuning.result is None:
            self.advice.hide()
        else:
            self.advice.fill(tuning)
        main_table, self.all_numbers = drop_tables(answers, view)
        self.table.set_content(main_table)
        self._fill_numbers()
        self.notes.fill(list_notes(answers, tuning.result))

    def _draw_numbers(self, drops: "Drops") -> None:
        """Show the headline numbers; what is exported has their intervals too."""
        stop, tuning = drops.chart_stop, drops.chart_tuning
        numbers, source = headlines(stop, tuning), stop if tuning is None else tuning.result
        if not drops.has_intervals:
            # a drop has its basis already; a rope alone has no intervals
            numbers = await_intervals(numbers) if getattr(stop, "basis", "") else numbers
            source = stop
        self.heroes.fill(numbers, source)
        self.panel.shown = drops.chart_answer if self.panel.shown else None

    def _draw_stop(self, drops: "Drops") -> None:
        view, mode, tuning = drops.view, drops.chart_mode, drops.tuning
        subject, stop = drops.answers[view], drops.chart_stop
        inputs = subject.call.options
        sentence = describe_drop(subject.result, subject.refusal, inputs)
        if mode != view:
            sentence = f"{sentence} The chart shows full vacuum: {describe_drop(stop, '', inputs)}"
        self.verdict.set_text(sentence)
        texts = tuning.call.options
        factor = None if self.word(SLOWLY) == "auto" else float(self.word(SLOWLY))
        has_moved = stop is not None and stop.record is not None
        data = time_series(stop.record, factor, stop.crash) if has_moved else None
        floor = None if tuning.result is None else tuning.result.floor_g
        answer, chart = drops.chart_answer, None
        if data is not None:
            quiet = {label: pin.result for label, pin in answer.pinned_answers.items()}
            brake: Any = read_device("brake", tuning.call.subjects[0].text)
            g = brake.brake.site.gravity
            floor_force = (
                None if floor is None else floor * g - (0.0 if texts.get("horizontal") else g)
            )
            chart = drop_chart(data, floor_force, quiet, self.dark)
        self.panel.draw(answer, chart)
        self._draw_numbers(drops)
        self.animation.load_series(data)
        self.bound.set_text(bound_sentence(floor, texts))


class Drops(NamedTuple):
    """Answers for the drops of a table, of which the one that is shown is computed first."""

    calls: Mapping[str, Call]
    view: str
    """Mode of the drop that is shown."""
    answers: dict[str, Answer]
    """{mode: answer} so far."""
    tuning: Answer
    pins: tuple[Pinned, ...]
    runner: Runner
    has_intervals: bool = True

    def continues(self, part: "Drops") -> bool:
        """Whether these are the drops of a part, whose chart stays the same."""
        return (
            self.view == part.view
            and self.chart_stop is self.answers[self.view].result
            and self.answers[self.view].call == part.answers[part.view].call
        )

    @property
    def chart_stop(self) -> Any:
        """Result of the drop in the chart, or None."""
        return self.answers[self.chart_mode].result

    @property
    def chart_answer(self) -> Answer:
        """Answer of the drop in the chart, with the pinned ones."""
        answer = self.answers[self.chart_mode]
        return replace(answer, pins=self.pins, title=f"{answer.name}-{self.chart_mode}")

    @property
    def chart_tuning(self) -> Answer | None:
        """Tuning of the drop in the chart, None if that is not tuned."""
        is_tuned = self.chart_mode == "tuned" and self.tuning.result is not None
        return self.tuning if is_tuned else None

    @property
    def chart_mode(self) -> str:
        """Mode of the drop in the chart: full vacuum if the tuned one cannot be computed."""
        result = self.answers[self.view].result
        failed = self.view == "tuned" and result is not None and result.record is None
        full = self.answers.get("full")
        return "full" if failed and (full is None or full.result is not None) else self.view

    @property
    def is_stopped(self) -> bool:
        """Whether a brake that is shown stops the mass, or none is shown."""
        result = self.answers[self.view].result
        return self.view == "none" or (result is not None and result.outcome in GOOD)

    def compute(self, mode: str) -> None:
        """Compute the answer of a mode unless it is known."""
        if mode in self.answers:
            return
        tuning = self.tuning.result
        if mode not in self.calls:
            answer = Answer(self.calls["full"], refusal=NO_ROPE)
        elif mode == "tuned" and tuning is not None and not tuning.feasible:
            # alternatives take long to find, so they are not searched twice
            answer = Answer(self.calls[mode], failed_run(tuning))
        else:
            wants = {"has_intervals": self.has_intervals, "progress": self.runner.report_progress}
            answer = try_call(self.calls[mode], **wants)
        self.answers[mode] = answer


def bound_sentence(floor: float | None, tuning: Mapping[str, Any]) -> str:
    """Return a sentence with the lowest peak deceleration [g] that a brake can achieve."""
    if floor is None:
        return ""
    formula = "v²/2gd" if tuning.get("horizontal") else "v²/2gd + 1"
    return (
        f"No brake can stop the mass within {tuning['travel']} plus the stretch of the rope "
        f"with a peak below {show(floor, '1', 3)} g ({formula}, for a constant force)."
    )
