"""Vacuum: a line's step response, a controller that holds the vacuum, and test faults."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from nicegui import ui

from layerjam.bench.control.faults import PROVOKED
from layerjam.bench.control.settings import KINDS, SAFE_STATES
from layerjam.brake.commands.edit import LINE_FIELDS, edit_line
from layerjam.brake.fluid.parts import parts as known_parts
from layerjam.core.units import show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer, try_call
from layerjam.workbench.call import Call
from layerjam.workbench.controls import (
    Choice,
    Control,
    add_choice,
    add_menu,
    control,
    make_choice,
    map_keys,
    vacuum_control,
)
from layerjam.workbench.desk import Desk
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.page import Figures, Notes, Page
from layerjam.workbench.pages.records import Editor, Kind
from layerjam.workbench.panel import Panel
from layerjam.workbench.widgets import (
    Hero,
    Heroes,
    columns,
    dress,
    fold,
    heading,
    hint,
    key_title,
    predicted_hero,
    status,
)

LINE = Kind(
    "line",
    "vacuum",
    "vacuum-line",
    MappingProxyType(
        {
            "chamber": "Chamber",
            "pump": "Pump",
            "tube": "Tube",
            "valve": "Vent valve",
            "leak": "Leak",
            "sensor": "Sensor",
            "reservoir": "Reservoir",
            "": "Gas",
            "site": "Site",
        }
    ),
    LINE_FIELDS,
    edit_line,
    origin=("number_kind", "number_source"),
    optional=("tube", "valve", "sensor", "reservoir"),
    parts=lambda table: {
        n: p.title or n for n, p in known_parts(table).items() if p.missing is None
    },
)
CONTROLS = ("target", "fluid", "safe_state", "kind", "fault", "fault_at", "duration", "sample_time")
"""Inputs of `regulate` that have a control on the page, in addition to those of the sensor."""
SENSOR = ("sensor_range", "noise")
NOT_CHOSEN = (
    "The controller does not run until you choose a safe state. After a fault, 'release' "
    "frees the brake and 'hold' keeps it jammed; choose according to the load on the brake."
)
KEY = (
    "Yellow background: fault not detected yet; red background: detected, in the safe state. "
    "Below zero, the pump runs backwards."
)
HELD = "Force of the brake"
LONGEST, SHORTEST = 1200.0, 1e-3
"""Maximum simulated time, and minimum sampling interval, on this page [s]."""
LOOP = (
    "fault_at",
    "fault_time",
    "said_after",
    "rise_time",
    "overshoot",
    "steady_error",
    "ripple",
    "pump_switches",
    "pump_on",
    "gain",
    "integral_time",
)


def law_choice() -> Choice:
    """Return the choice of control law."""
    meanings = "; ".join(f"{kind}: {meaning}" for kind, meaning in KINDS.items())
    words = {kind: "PI" if kind == "pi" else kind for kind in KINDS}
    return Choice("kind", words, "pi", label="Law", help=meanings)


def safe_choice() -> Choice:
    """Return the choice of the safe state after a fault; it has no default."""
    meanings = "; ".join(f"{state}: {meaning}" for state, meaning in SAFE_STATES.items())
    words = {"": "not chosen", **{state: state for state in SAFE_STATES}}
    return Choice("safe_state", words, "", help=f"Safe state after a fault. {meanings}")


def fault_choice() -> Choice:
    """Return the choice of the fault to inject."""
    words = {name: f"{name.replace('-', ' ')}: {meaning}" for name, meaning in PROVOKED.items()}
    return Choice("fault", {"none": "none", **words}, "none", help="Fault during the run")


class Vacuum(Page):
    """Page for a vacuum line: step response, controller and faults."""

    name, title = "vacuum", "Vacuum"
    summary = "Time to reach the vacuum, and controllers that hold it"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.line = Editor(desk, LINE)
        self.more = OtherInputs(self, "regulate", (*CONTROLS, *SENSOR))
        self.fluid = make_choice("rise", "fluid", {})
        self.law, self.safe, self.fault = law_choice(), safe_choice(), fault_choice()
        self.steps = Panel(desk, self.name, command="rise")
        self.loop = Panel(desk, self.name, "vacuum-loop", command="regulate")

    def controls(self) -> Mapping[str, Control]:
        """Return the controls, with the bounds that the line sets."""
        full_vacuum = self.more.atmosphere(self.desk.line.line.site.atmosphere)
        target = vacuum_control("rise", "target", full_vacuum, 0.01 * full_vacuum)
        span = control("regulate", "duration", 20.0, (1.0, 120.0), unit="s", label="Simulated time")
        sample = control("regulate", "sample_time", 0.01, (SHORTEST, 0.1), unit="ms")
        start_options = {"unit": "s", "label": "Start of the fault"}
        return map_keys(
            target,
            control("regulate", "fault_at", 10.0, (0.0, 30.0), **start_options),
            span.narrow_bounds(high=LONGEST),
            sample.narrow_bounds(SHORTEST),
            control("regulate", "sensor_range", 103e3, (10e3, 200e3)),
            control("regulate", "noise", 50.0, (0.0, 500.0), unit="Pa"),
        )

    def build(self) -> None:
        """Build step response and controller, each with its controls to the left of its result."""
        with ui.column().classes("w-full page gap-3"):
            self.add_alert()
            heading("Step response")
            side, main = columns()
            with side:
                self.add_slider("target")
                add_choice(self.desk, self.name, self.fluid)
                self.line.build_selection()
                with fold("Parts and numbers of the line", "vacuum-numbers"):
                    self.line.build_folds()
                    self.line.build_origin()
            with main:
                self._build_step_response()
            heading("Controller")
            side, main = columns()
            with side:
                self._build_loop_controls()
            with main:
                self._build_regulator()
            self.notes = Notes()

    def _build_loop_controls(self) -> None:
        add_choice(self.desk, self.name, self.safe)
        with self.show_while(lambda: not self.word(self.safe)):
            hint("Law, fault and sampling take effect once a safe state is chosen.")
        with self.enable_while(lambda: bool(self.word(self.safe))):
            add_choice(self.desk, self.name, self.law)
            add_menu(self.desk, self.name, self.fault)
            self.add_slider("fault_at", lambda: self.word(self.fault) != "none")
            with fold("Sampling and sensor", "vacuum-sampling"):
                self.add_slider("duration")
                self.add_slider("sample_time")
                with self.show_while(self._lacks_sensor):
                    hint("The line has no sensor. A sensor with this range and noise is assumed.")
                    for key in SENSOR:
                        self.add_slider(key)
        self.more.build()

    def _lacks_sensor(self) -> bool:
        return self.desk.line.line.sensor is None

    def _build_step_response(self) -> None:
        self.heroes = Heroes(self.name)
        with ui.row().classes("w-full items-center gap-x-6 gap-y-1"):
            self.rise_words = status("vacuum-rise-words")
            self.steps.build_pins()
        look = "width: 100%; height: max(260px, 34vh)"
        self.steps.build("vacuum-chart", "Vacuum over time at full pump power", look)
        self.steps.build_exports()

    def _build_regulator(self) -> None:
        self.loop_heroes = Heroes("vacuum-loop")
        self.verdict = status("vacuum-verdict", text=NOT_CHOSEN)
        with ui.row().classes("w-full beside items-start gap-4") as self.regulated:
            with ui.column().classes("gap-0").style("flex: 1; min-width: 0"):
                label = "Controlled vacuum and command over time"
                self.loop.build("vacuum-loop", label, "width: 100%; height: max(430px, 46vh)")
                self.loop.build_pins()
                hint(KEY)
                self.loop.build_exports()
            with ui.column().style("width: 240px; flex: none"):
                self.loop_figures = Figures("vacuum-loop", "regulate", LOOP)
                label = "Longest detection time of each fault at this vacuum"
                ui.label(label).classes("text-sm")
                self.detection = dress(live.Table(), "vacuum-detection")
        self.regulated.set_visibility(False)

    def calls(self) -> Sequence[Call]:
        """Return the calls for the step response, the controller if chosen, and the brake."""
        subjects, safe_state = (self.desk.subject("line"),), self.word(self.safe)
        common = self.texts("target")
        if self.word(self.fluid) != "air":
            common["fluid"] = self.word(self.fluid)
        other_options = self.more.options()
        site = {key: value for key, value in other_options.items() if key == "atmosphere"}
        rise = Call("rise", subjects, {**common, **site})
        place = {"slip": "0 mm", "vacuum": common["target"], **site}
        force = Call("force", (self.desk.brake_subject(),), place)
        if not safe_state:
            return [rise, force]
        inputs = {**common, "safe_state": safe_state, "kind": self.word(self.law)}
        inputs |= self.texts("duration", "sample_time")
        if self._lacks_sensor():
            inputs |= self.texts(*SENSOR)
        if self.word(self.fault) != "none":
            inputs |= {"fault": self.word(self.fault), "fault_at": self.text("fault_at")}
        return [rise, Call("regulate", subjects, {**inputs, **other_options}), force]

    def compute(self) -> list[Answer]:
        """Compute each call separately, so that an error in one does not affect the others."""
        *calls, force = self.calls()
        panels = zip((self.steps, self.loop), calls, strict=False)
        lines = [replace(try_call(call), pins=panel.pinned_answers(call)) for panel, call in panels]
        return [*lines, try_call(force)]

    def draw(self, result: Sequence[Answer]) -> None:
        """Draw both charts, and show their texts and notes."""
        rise, *loops, force = result
        self._draw_rise(rise, force.result)
        runs = [loop for loop in loops if loop.result is not None]
        self.regulated.set_visibility(bool(runs))
        if not runs:
            self.loop.draw(None, None)
            self.loop_heroes.fill([])
            self.verdict.set_text(f"Not possible: {loops[0].refusal}" if loops else NOT_CHOSEN)
        else:
            self._draw_loop(runs[0])
        warnings = [w for answer in (rise, *runs) if answer.result for w in answer.result.warnings]
        self.notes.fill(list(dict.fromkeys(warnings)))

    def _draw_rise(self, answer: Answer, force: Any) -> None:
        rise = answer.result
        if rise is None:
            self.steps.draw(answer, None)
            self.rise_words.set_text(f"Not possible: {answer.refusal}.")
            self.heroes.fill([])
            return
        words = f"Not possible: {rise.reason}."
        if rise.feasible:
            risen = f"rises from 10 to 90 % in {show(rise.rise_time, 's', 3)}"
            words = f"A vacuum of {show(rise.target, 'Pa')} in {rise.fluid} {risen}."
        self.rise_words.set_text(words)
        shown_force = force if rise.feasible else None
        self.heroes.fill(headlines(rise, shown_force), shown_force, HELD)
        self.steps.show(answer, self.dark)

    def _draw_loop(self, answer: Answer) -> None:
        result = answer.result
        self.loop.show(answer, self.dark)
        # error and ripple refer to the target, which the safe state abandons
        given_up = () if result.outcome == "HEALTHY" else ("steady_error", "ripple")
        self.loop_figures.fill(result, skip_keys=given_up)
        self.verdict.set_text(describe_fault(result))
        self.loop_heroes.fill(loop_headlines(result))
        self.detection.set_content(detection_table(result))


def describe_fault(result: Any) -> str:
    """Return sentences on the reported fault, its time, and the effect of the safe state."""
    target, end = show(result.target, "Pa"), float(result.record[1].vacuum[-1])
    ending = f"at the end the vacuum is {show(end, 'Pa', 3) if end >= 1 else 'gone'}"
    if result.fault is None and result.outcome == "HEALTHY":
        rise = f"The vacuum did not reach {target}"
        if result.rise_time is not None:
            rise = f"The rise to {target} took {show(result.rise_time, 's', 3)} (10 to 90 %)"
        return f"No fault was reported. {rise}; {ending}."
    cause = ""
    if result.fault is not None:
        cause = f"From {show(result.fault_at, 's')} on, {result.broken}. "
    if result.outcome == "HEALTHY":
        return f"{cause}The detector reported nothing; {ending}."
    delay_text = "" if result.said_after is None else f", {show(result.said_after, 's', 3)} later"
    state = f"{result.safe_state}: {SAFE_STATES[result.safe_state]}"
    return (
        f"{cause}The fault “{result.outcome.replace('_', ' ').lower()}” was detected at "
        f"{show(result.fault_time, 's')}{delay_text}; from then "
        f"on {state}, and {ending}."
    )


def _make_headline(key: str, name: str, value: float | None, unit: str) -> Hero:
    return Hero(key, name, "–" if value is None else show(value, unit))


def headlines(rise: Any, force: Any | None = None) -> list[Hero]:
    """Return the headline numbers of a step response; a dash marks unknown ones.

    The `force` of the current brake at that vacuum follows the rise time.
    """
    brake = [predicted_hero("force", HELD, force, "force")] if force else []
    return [
        _make_headline("rise_time", "Rise time (10 to 90 %)", rise.rise_time, "s"),
        *brake,
        _make_headline("reachable", "Maximum vacuum", rise.reachable, "Pa"),
        _make_headline(
            "fall_time", f"Fall time, through {rise.fall_by or 'a vent'}", rise.fall_time, "s"
        ),
        _make_headline("time_constant", "Time constant", rise.time_constant, "s"),
        _make_headline("gas_work", "Work on the gas", rise.gas_work, "J"),
    ]


def loop_headlines(result: Any) -> list[Hero]:
    """Return the headline numbers of a regulated run; the detection time if a fault is set."""
    if result.fault is not None:
        detected = _make_headline("detected", "Detected after", result.said_after, "s")
    else:
        detected = _make_headline("rise_time", "Rise time (10 to 90 %)", result.rise_time, "s")
    return [
        detected,
        _make_headline("overshoot", "Overshoot", result.overshoot, result.units["overshoot"]),
        _make_headline("ripple", "Ripple", result.ripple, result.units["ripple"]),
    ]


def detection_table(result: Any) -> str:
    """Return a list of the faults and their longest detection times, as HTML."""
    rows = "".join(
        f"<dt>{key_title(name.lower())}</dt>"
        f"<dd>{'not detected' if time is None else show(time, 's', 3)}</dd>"
        for name, time in result.detection.items()
    )
    return f'<dl class="vacuum-times">{rows}</dl>'
