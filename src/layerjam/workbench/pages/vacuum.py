"""Vacuum: how fast a line brings it, a regulator that holds it, and faults to try it with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from nicegui import ui

from layerjam.commands.quantities import TARGET
from layerjam.commands.regulate import FAULT_AT, Regulation
from layerjam.commands.vacuum_line import VacuumRise
from layerjam.control.faults import PROVOKED
from layerjam.control.settings import KINDS, SAFE_STATES, Regulator
from layerjam.fluid.line import Sensor
from layerjam.simulate.quantities import DURATION
from layerjam.units import QuantitySpec, show, spec_of
from layerjam.workbench import live
from layerjam.workbench.call import Call
from layerjam.workbench.charts import Curve, options, stacked
from layerjam.workbench.controls import Choice, Control, choice, menu, number, slider, word
from layerjam.workbench.page import Figures, Notes, Page, answered
from layerjam.workbench.pages.line_fields import LineFields

FLUID = Choice("fluid", {"air": "air", "water": "water"}, "air", help="What fills the line")
KIND = Choice("kind", {k: k for k in KINDS}, "pi", label="Law",
              help="; ".join(f"{k}: {v}" for k, v in KINDS.items()))  # fmt: skip
SAFE = Choice("safe_state", {"": "not chosen", **{k: k for k in SAFE_STATES}}, "",
              label="Safe state", help="Where a fault ends. "
              + "; ".join(f"{k}: {v}" for k, v in SAFE_STATES.items()))  # fmt: skip
FAULT = Choice("fault", {"none": "none",
                         **{k: f"{k.replace('-', ' ')}: {v}" for k, v in PROVOKED.items()}},
               "none", help="What breaks while the target is held")  # fmt: skip
NOT_CHOSEN = (
    "Nothing is regulated until a safe state is chosen: whether a fault should let the brake go "
    "(release) or keep it jammed (hold) depends on what hangs on it."
)
KEY = (
    "Light line: what the sensor shows. Yellow ground: broken and not said yet; red ground: said, "
    "in the safe state. Below zero the pump runs backwards."
)
LONGEST, SHORTEST = 1200.0, 1e-3
"""Time simulated at most and time between samples at least, on this page [s]."""
KPA = 1e3
STYLE = """
.vacuum-times { display: grid; grid-template-columns: auto auto; gap: 2px 12px;
  font-size: 0.8rem; margin: 0 }
.vacuum-times dd { margin: 0; text-align: right }
"""


class Vacuum(Page):
    """A line: its step response, its regulator, its faults."""

    name = "vacuum"

    def controls(self) -> dict[str, Control]:
        """Bounds that the line sets."""
        full = self.desk.line.line.site.atmosphere
        target = QuantitySpec("Pa", TARGET.text, 0.0, full, open_lo=True)
        sample = spec_of(Regulator, "sample_time")
        sample = QuantitySpec("s", sample.text, SHORTEST, sample.hi)
        lasts = QuantitySpec("s", DURATION.text, 0.0, LONGEST, open_lo=True)
        made = (
            Control("target", target, min(60e3, 0.6 * full), 0.01 * full, 0.99 * full),
            Control("fault_at", FAULT_AT, 10.0, 0.0, 30.0, unit="s", label="Fault begins at"),
            Control("duration", lasts, 20.0, 1.0, 120.0, unit="s", label="Time simulated"),
            Control("sample_time", sample, 0.01, SHORTEST, 0.1, unit="ms"),
            Control("sensor_range", spec_of(Sensor, "range"), 103e3, 10e3, 200e3),
            Control("noise", spec_of(Sensor, "noise"), 50.0, 0.0, 500.0, unit="Pa"),
        )
        return {control.key: control for control in made}

    def build(self) -> None:
        """Controls and line left, the two answers right."""
        ui.add_css(STYLE)
        with ui.row().classes("w-full no-wrap items-start gap-6 page"):
            with ui.column().classes("side"):
                self._slider("target")
                choice(self.desk, self.name, FLUID)
                choice(self.desk, self.name, SAFE)
                choice(self.desk, self.name, KIND)
                menu(self.desk, self.name, FAULT)
                with ui.column().classes("w-full") as self.when:
                    self._slider("fault_at")
                with (
                    ui.expansion("Sampling and sensor")
                    .classes("w-full")
                    .props('dense header-class="font-medium" data-testid="vacuum-sampling"')
                ):
                    self._slider("duration")
                    self._slider("sample_time")
                    with ui.column().classes("w-full") as self.stand_in:
                        ui.label(
                            "The line has no sensor: one of this range and noise stands in."
                        ).classes("text-sm opacity-80")
                        self._slider("sensor_range")
                        self._slider("noise")
                self.problem_line()
                self.line = LineFields(self.desk)
            with ui.column().classes("main gap-3"):
                self._answers()
        self._hide("settings")
        self.desk.watch(self._hide)

    def _answers(self) -> None:
        ui.label("Step response, pump full on").classes("text-lg")
        self.rise_words = live.Words("").props('role="status" data-testid="vacuum-rise-words"')
        with ui.row().classes("w-full no-wrap items-start gap-4"):
            self.steps = ui.echart({}).style("flex: 1; min-width: 0; height: 260px").props(
                'data-testid="vacuum-chart" role="img" aria-label="Vacuum over time, pump full on"'
            )  # fmt: skip
            with ui.column().style("width: 260px; flex: none"):
                self.rise_figures = Figures(
                    self.name,
                    [("rise_time", "Rise, 10 to 90 %"), ("time_constant", "Time constant"),
                     ("fall_time", "Fall, 90 to 10 %"), ("fall_by", "by"),
                     ("reachable", "Reachable"), ("gas_work", "Work on the gas")],
                )  # fmt: skip
        ui.label("Regulator").classes("text-lg")
        self.verdict = live.Words(NOT_CHOSEN).props('role="status" data-testid="vacuum-verdict"')
        with ui.row().classes("w-full no-wrap items-start gap-4") as self.regulated:
            with ui.column().classes("gap-0").style("flex: 1; min-width: 0"):
                self.loop = ui.echart({}).style("width: 100%; height: 430px").props(
                    'data-testid="vacuum-loop" role="img" '
                    'aria-label="Vacuum and command over time, regulated"'
                )  # fmt: skip
                ui.label(KEY).classes("text-sm opacity-80")
            with ui.column().style("width: 260px; flex: none"):
                self.loop_figures = Figures(
                    "vacuum-loop",
                    [("outcome", "Detector says"), ("fault_at", "Fault begins"),
                     ("fault_time", "Said at"), ("said_after", "After"),
                     ("rise_time", "Rise, 10 to 90 %"), ("overshoot", "Overshoot"),
                     ("steady_error", "Error at the end"), ("ripple", "Ripple"),
                     ("pump_switches", "Pump switched"), ("pump_on", "Pump ran"),
                     ("gain", "Gain"), ("integral_time", "Integral time")],
                )  # fmt: skip
                ui.label("Longest until a fault is said, at this vacuum").classes("text-sm")
                self.detection = live.Table().props('data-testid="vacuum-detection"')
        self.regulated.set_visibility(False)
        self.notes = Notes()

    def _slider(self, key: str) -> None:
        slider(self.desk, self.name, self.controls()[key], lambda: self.controls()[key])

    def _hide(self, _: str) -> None:
        self.when.set_visibility(word(self.desk, self.name, FAULT) != "none")
        self.stand_in.set_visibility(self.desk.line.line.sensor is None)

    def _text(self, key: str) -> str:
        control = self.controls()[key]
        return control.text(number(self.desk, self.name, control))

    def calls(self) -> Sequence[Call]:
        """The step; the regulator only once a safe state is chosen."""
        subject, safe = self.desk.line_subject(), word(self.desk, self.name, SAFE)
        common: dict[str, str | float | bool] = {"target": self._text("target")}
        if word(self.desk, self.name, FLUID) == "water":
            common["fluid"] = "water"
        made = [Call("rise", (subject,), common)]
        if not safe:
            return made
        said = {
            **common, "safe_state": safe, "kind": word(self.desk, self.name, KIND),
            "duration": self._text("duration"), "sample_time": self._text("sample_time"),
        }  # fmt: skip
        if self.desk.line.line.sensor is None:
            said |= {"sensor_range": self._text("sensor_range"), "noise": self._text("noise")}
        fault = word(self.desk, self.name, FAULT)
        if fault != "none":
            said |= {"fault": fault, "fault_at": self._text("fault_at")}
        return [*made, Call("regulate", (subject,), said)]

    def compute(self) -> Any:
        """Each alone: a step that is refused leaves the regulator, and the other way round."""
        return [answered(call) for call in self.calls()]

    def draw(self, result: Any) -> None:
        """Both charts and what is said of them."""
        (rise, refused), *loops = result
        self._draw_rise(rise, refused)
        self.regulated.set_visibility(bool(loops) and loops[0][0] is not None)
        said = list(rise.warnings) if rise is not None else []
        if not loops:
            self.verdict.set_text(NOT_CHOSEN)
        elif loops[0][0] is None:
            self.verdict.set_text(f"Cannot: {loops[0][1]}")
        else:
            self._draw_loop(loops[0][0])
            said += loops[0][0].warnings
        self.notes.fill(list(dict.fromkeys(said)))

    def _draw_rise(self, rise: VacuumRise | None, refused: str) -> None:
        self.steps.set_visibility(rise is not None)
        if rise is None:
            self.rise_words.set_text(f"Cannot: {refused}")
            return
        target = show(rise.target, "Pa")
        self.rise_words.set_text(
            f"{target} in {rise.fluid}: 10 to 90 % in {show(rise.rise_time, 's', 3)}"
            if rise.feasible else f"Cannot: {rise.reason}"
        )  # fmt: skip
        self.rise_figures.fill(rise)
        time, vacuum = np.asarray(rise.record.time), np.asarray(rise.record.vacuum)
        there = np.flatnonzero(vacuum >= rise.target)
        end = 1.4 * float(time[there[0]]) if len(there) else float(time[-1])
        seen = time <= end
        marks = [
            (float(np.interp(part * rise.target, vacuum, time)), part * rise.target / KPA,
             f"{part:.0%}", "quiet") for part in (0.1, 0.9) if rise.feasible
        ]  # fmt: skip
        wanted = rise.target / KPA
        made = options(
            [Curve(time[seen], vacuum[seen] / KPA),
             Curve([0, end], [wanted, wanted], "good", "target", dashed=True, width=1.5)],
            x="time [s]", y="vacuum [kPa]", x_range=(0, end), marks=marks, dark=self.dark,
        )  # fmt: skip
        made["series"][1]["endLabel"]["color"] = made["xAxis"]["axisLabel"]["color"]
        live.draw(self.steps, made)

    def _draw_loop(self, answer: Regulation) -> None:
        _, loop = answer.record
        end = answer.duration
        begins, said = answer.fault_at, answer.fault_time
        stop = end if said is None else said
        bands = [(begins, stop, "second")] if begins is not None and begins < stop else []
        bands += [(said, end, "bad")] if said is not None else []
        common: dict[str, Any] = {"x": "time [s]", "x_range": (0, end), "dark": self.dark,
                                  "bands": bands}  # fmt: skip
        vacuum = [
            Curve(loop.time, loop.measured / KPA, "sky", "", width=1.0),
            Curve(loop.time, loop.target / KPA, "good", "target", dashed=True, width=1.5),
            Curve(loop.time, loop.vacuum / KPA, "main", "vacuum"),
        ]
        commands = [
            Curve(loop.time, loop.pump, "main", "pump", width=1.2),
            Curve(loop.time, loop.vent, "bad", "vent", width=1.5),
        ]
        low = -1.2 if float(loop.pump.min()) < 0 else 0
        top = 1.15 * max(float(np.nanmax(loop.vacuum)), answer.target) / KPA
        parts = [
            options(vacuum, y="vacuum [kPa]", y_range=(0, math.ceil(top / 10) * 10), **common),
            options(commands, y="command", y_range=(low, 1.2), **common),
        ]
        parts[1]["yAxis"]["axisLabel"] |= {"showMaxLabel": False, "showMinLabel": low == 0}
        for part in parts:
            part["grid"]["right"] = 62
            # at the end they mostly lie on each other, their names must not
            for series, shift in zip(part["series"][-2:], (-7, 7), strict=True):
                series["endLabel"]["offset"] = [0, shift]
        live.draw(self.loop, stacked(parts, (1.7, 1)))
        self.loop_figures.fill(in_figures(answer))
        self.verdict.set_text(verdict(answer))
        self.detection.set_content(detection(answer))


def in_figures(answer: Regulation) -> Regulation:
    """Without error and ripple of a target that the safe state has given up."""
    if answer.outcome == "HEALTHY":
        return answer
    return replace(answer, steady_error=None, ripple=None)


def verdict(answer: Regulation) -> str:
    """What the detector said, when, and what the safe state did, in words."""
    target, end = show(answer.target, "Pa"), float(answer.record[1].vacuum[-1])
    held = f"at the end the vacuum is {show(end, 'Pa', 3) if end >= 1 else 'gone'}"
    if answer.fault is None and answer.outcome == "HEALTHY":
        rise = "never" if answer.rise_time is None else f"in {show(answer.rise_time, 's', 3)}"
        return f"HEALTHY: risen to {target} {rise} (10 to 90 %); {held}."
    what = ""
    if answer.fault is not None:
        what = f"From {show(answer.fault_at, 's')} on {answer.broken}. "
    if answer.outcome == "HEALTHY":
        return f"{what}The detector said nothing; {held}."
    after = "" if answer.said_after is None else f", {show(answer.said_after, 's', 3)} later"
    state = f"{answer.safe_state}: {SAFE_STATES[answer.safe_state]}"
    return (
        f"{what}{answer.outcome} was said at {show(answer.fault_time, 's')}{after}; from then on "
        f"{state}, and {held}."
    )


def detection(answer: Regulation) -> str:
    """HTML: each fault and the longest time until it is said."""
    rows = "".join(
        f"<dt>{name}</dt><dd>{'not seen' if time is None else show(time, 's', 3)}</dd>"
        for name, time in answer.detection.items()
    )
    return f'<dl class="vacuum-times">{rows}</dl>'
