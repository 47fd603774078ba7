"""Drop: a mass stopped by the rope alone, by a full brake, and by one tuned to a travel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

from nicegui import ui

from layerjam.commands.answer import Answer
from layerjam.commands.quantities import HEIGHT
from layerjam.commands.quantities import ROPE_STIFFNESS as ROPE
from layerjam.simulate.quantities import ARRIVAL_SPEED as SPEED
from layerjam.simulate.quantities import MASS, VACUUM
from layerjam.simulate.quantities import STOP_TRAVEL as TRAVEL
from layerjam.units import QuantitySpec, show
from layerjam.workbench import live
from layerjam.workbench.call import Call
from layerjam.workbench.charts import Curve, options, stacked
from layerjam.workbench.controls import (
    Choice,
    Control,
    choice,
    menu,
    number,
    readout,
    slider,
    word,
)
from layerjam.workbench.page import Notes, Page, answered
from layerjam.workbench.pages.drop_animation import SLOW, STYLE, Animation, series

ARRIVES = Choice("arrives", {"speed": "speed", "height": "height"}, "speed", label="Given as",
                 help="Speed at the taut rope, or height of the fall before it")  # fmt: skip
DIRECTION = Choice("direction", {"falling": "falling", "horizontal": "horizontal"}, "falling",
                   help="Horizontal: no gravity along the pull")  # fmt: skip
ON_ROPE = Choice("on_rope", {"rope": "a rope", "none": "none"}, "rope", label="Rope",
                 help="Without a rope the mass hangs on the brake itself")  # fmt: skip
MODES = {"none": "no brake", "full": "full", "tuned": "tuned", "value": "a value"}
SHOWN = Choice("shown", MODES, "tuned", label="Vacuum",
               help="No brake: the mass on the rope alone. Tuned: to the travel below")  # fmt: skip
SLOWLY = Choice("slow", {"auto": "chosen by the stop", **{f"{s:g}": f"{s:g} ×" for s in SLOW}},
                "auto", label="Slow motion")  # fmt: skip
ROWS = (
    ("outcome", "Outcome"), ("vacuum", "Vacuum"), ("slip", "Slip of the brake"),
    ("peak_force", "Peak force"), ("peak_deceleration", "Peak deceleration"),
    ("peak_g", "Felt, in g"), ("stopping_time", "Time to the end"),
    ("end_speed", "Speed at the end"),
    ("dissipated_energy", "Heat"),
)  # fmt: skip
OUTCOMES = {
    "STOPPED": "stopped", "NEVER_SLID": "stopped without slip", "SNAPS": "snaps",
    "BOTTOMED_OUT": "bottomed out", "FINISHED": "still moving",
}  # fmt: skip
NO_ROPE = "there is no rope, and without a brake the mass hangs on nothing else"
TABLE = """
.drop-table { border-collapse: collapse; width: 100%; font-size: 0.9rem }
.drop-table th, .drop-table td { padding: 3px 10px; text-align: right; vertical-align: top;
  border-bottom: 1px solid rgba(128,128,128,.35) }
.drop-table th:first-child { text-align: left; font-weight: 400 }
.drop-table td.cannot { text-align: left; max-width: 22em }
.drop-table .shown { background: rgba(0,114,178,.12) }
"""


class Drop(Page):
    """Drop a mass, see it stop; none, full and tuned side by side."""

    name = "drop"

    def controls(self) -> dict[str, Control]:
        """Bounds that the brake sets."""
        brake = self.desk.brake.brake
        full, way = brake.site.atmosphere, brake.sheets.usable_travel
        within = QuantitySpec("m", TRAVEL.text, TRAVEL.lo, way)
        made = (
            Control("mass", MASS, 1.0, 0.05, 10.0, unit="kg"),
            Control("speed", SPEED, 1.5, 0.05, 6.0, unit="m/s"),
            Control("height", HEIGHT, 0.1, 0.005, 2.0, unit="m"),
            Control("rope_stiffness", ROPE, 16.8e3, 500.0, 100e3, label="Rope's stiffness"),
            Control("travel", within, min(0.04, way), 0.001, way, label="Travel to stop within"),
            Control("vacuum", QuantitySpec("Pa", VACUUM.text, 0.0, full), 0.25 * full, 0.0, full),
        )
        return {control.key: control for control in made}

    def build(self) -> None:
        """Controls, the stage, charts, and the table below."""
        ui.add_css(STYLE + TABLE)
        desk, name, controls = self.desk, self.name, self.controls()
        with ui.row().classes("w-full no-wrap items-start gap-6 page"):
            with ui.column().classes("side"):
                slider(desk, name, controls["mass"])
                choice(desk, name, DIRECTION)
                self._boxes: list[tuple[ui.column, Callable[[], bool]]] = []
                with ui.column().classes("w-full") as box:
                    choice(desk, name, ARRIVES)
                self._boxes.append((box, lambda: not self._flat()))
                self._hideable(controls["speed"], lambda: self._arrives() == "speed")
                self._hideable(controls["height"], lambda: self._arrives() == "height")
                choice(desk, name, ON_ROPE)
                self._hideable(controls["rope_stiffness"], self._roped)
                slider(desk, name, controls["travel"], lambda: self.controls()["travel"])
                choice(desk, name, SHOWN)
                self._hideable(controls["vacuum"], lambda: self._is(SHOWN, "value"))
                menu(desk, name, SLOWLY)
                self.problem_line()
            with ui.column().classes("main gap-3"):
                self.verdict = live.Words("").classes("text-lg").props(
                    'role="status" data-testid="drop-verdict"'
                )  # fmt: skip
                with ui.row().classes("w-full items-start gap-4"):
                    stage = ui.column().style("width: 270px; flex: none")
                    with ui.element("div").style("flex: 1; min-width: 300px; position: relative"):
                        self.chart = ui.echart({}).style("width: 100%; height: 460px").props(
                            'data-testid="drop-chart" role="img" '
                            'aria-label="Force, travel and deceleration over time"'
                        )  # fmt: skip
                        cursor = ui.element("div")
                    with stage:
                        self.animation = Animation(self.chart, cursor)
                self.table = live.Table().classes("w-full").props(
                    'data-testid="drop-table"'
                )  # fmt: skip
                self.bound = live.Words("").classes("text-sm").props('data-testid="drop-bound"')
                self.notes = Notes()
        self._hide("settings")
        desk.watch(self._hide)

    def _hideable(self, control: Control, seen: Callable[[], bool]) -> None:
        with ui.column().classes("w-full") as box:
            slider(self.desk, self.name, control, lambda: self.controls()[control.key])
        self._boxes.append((box, seen))

    def _hide(self, _: str) -> None:
        for box, seen in self._boxes:
            box.set_visibility(seen())

    def _is(self, what: Choice, value: str) -> bool:
        return word(self.desk, self.name, what) == value

    def _flat(self) -> bool:
        return self._is(DIRECTION, "horizontal")

    def _roped(self) -> bool:
        return self._is(ON_ROPE, "rope")

    def _arrives(self) -> str:
        """Nothing falls into a horizontal stop."""
        return "speed" if self._flat() else word(self.desk, self.name, ARRIVES)

    def columns(self) -> dict[str, Call]:
        """The drops of the table, by what stands above them."""
        full = self.controls()["vacuum"].spec.hi
        common = self._common()
        travel = self._text("travel")
        modes: dict[str, dict[str, str | float | bool]] = {
            **({"none": {"no_brake": True}} if self._roped() else {}),
            "full": {"vacuum": self.controls()["vacuum"].text(full)},
            "tuned": {"vacuum": "tuned", "travel": travel},
        }
        if self._is(SHOWN, "value"):
            modes["value"] = {"vacuum": self._text("vacuum")}
        subject = self.desk.brake_subject()
        return {mode: Call("drop", (subject,), {**common, **own}) for mode, own in modes.items()}

    def _common(self) -> dict[str, str | float | bool]:
        """Options of drop and tune alike."""
        arrives = self._arrives()
        said: dict[str, str | float | bool] = {
            "mass": self._text("mass"), arrives: self._text(arrives),
        }  # fmt: skip
        if self._roped():
            said["rope_stiffness"] = self._text("rope_stiffness")
        if self._flat():
            said["horizontal"] = True
        return said

    def _text(self, key: str) -> str:
        control = self.controls()[key]
        return control.text(number(self.desk, self.name, control))

    def calls(self) -> Sequence[Call]:
        """The drops of the table, and the tuning that knows the bound."""
        said = {**self._common(), "travel": self._text("travel")}
        return [*self.columns().values(), Call("tune", (self.desk.brake_subject(),), said)]

    def compute(self) -> Any:
        """Every drop alone: one that is refused leaves the others."""
        shown, drops, tune = word(self.desk, self.name, SHOWN), self.columns(), self.calls()[-1]
        found: dict[str, tuple[Answer | None, str]] = {"none": (None, NO_ROPE)}
        found |= {mode: answered(call) for mode, call in drops.items()}
        return shown, found, answered(tune)

    def draw(self, result: Any) -> None:
        """Verdict, stage, charts, table."""
        shown, drops, (tuned, _) = result
        answer, refusal = drops[shown]
        self.verdict.set_text(verdict(answer, refusal))
        record = answer.record if answer is not None else None
        slow = word(self.desk, self.name, SLOWLY)
        made = None if record is None else series(record, None if slow == "auto" else float(slow))
        floor = None if tuned is None else tuned.floor_g
        self.chart.set_visibility(made is not None)
        if made is not None:
            self._draw_charts(made, floor)
        self.animation.load(made)
        self.table.set_content(table(drops, shown))
        self.bound.set_text(self._bound(floor))
        self.notes.fill(notes(drops))

    def _bound(self, floor: float | None) -> str:
        if floor is None:
            return ""
        formula = "v²/2gd" if self._flat() else "v²/2gd + 1"
        return (
            f"No brake at all stops it within {self._text('travel')} and what the rope gives with "
            f"less than {show(floor, '1', 3)} g felt ({formula}: the force constant all the way)."
        )

    def _draw_charts(self, made: Mapping[str, Any], floor: float | None) -> None:
        time, last = made["time"], made["last"]
        deceleration = [Curve(time, made["deceleration"])]
        g = self.desk.brake.brake.site.gravity
        if floor is not None:
            least = floor * g - (0.0 if self._flat() else g)
            deceleration.append(
                Curve([0, last], [least, least], "good", "least", dashed=True, width=1.5)
            )
        travel = [Curve(time, made["travel"], name="mass")]
        if made["slip"]:
            travel.append(Curve(time, made["slip"], "second", "slip"))
        common: dict[str, Any] = {"x": "time from the taut rope [ms]", "x_range": (0, last),
                                  "dark": self.dark}  # fmt: skip
        top = max(range(len(time)), key=made["force"].__getitem__)
        peak = (time[top], made["force"][top], f"{made['force'][top]:.4g} N", "bad")
        parts = [
            options([Curve(time, made["force"])], y="force [N]", marks=[peak], **common),
            options(travel, y="travel [mm]", **common),
            options(deceleration, y="deceleration [m/s²]", y_range=(None, None), **common),
        ]
        # the peak comes early: beside it there is room, above it there is none
        parts[0]["series"][0]["markPoint"]["data"][0]["label"]["position"] = "right"
        for series_, shift in zip(parts[1]["series"], (-6, 7), strict=False):
            series_["endLabel"]["offset"] = [0, shift]
        for part in parts:
            part["grid"]["right"] = 56
        live.draw(self.chart, stacked(parts, (1.1, 1, 1)))


def notes(drops: Mapping[str, tuple[Answer | None, str]]) -> list[str]:
    """Warnings of the drops, each with whose it is unless all drops of the brake say it."""
    said = {mode: answer.warnings for mode, (answer, _) in drops.items() if answer is not None}
    by_brake = [warnings for mode, warnings in said.items() if mode != "none"]
    made = [
        w if all(w in other for other in by_brake) else f"{MODES[mode]}: {w}"
        for mode, warnings in said.items() for w in warnings
    ]  # fmt: skip
    return list(dict.fromkeys(made))


def verdict(answer: Answer | None, refusal: str) -> str:
    """What happened, in a sentence."""
    if answer is None:
        return f"Cannot: {refusal}"
    if not answer.feasible:
        return f"Cannot: {answer.reason}"
    if answer.outcome == "BOTTOMED_OUT":
        return (
            f"BOTTOMED_OUT: the travel of {show(answer.slip, 'm')} is used up, the mass still at "
            f"{show(answer.end_speed, 'm/s')}"
        )
    if answer.outcome is None:
        return str(answer.reason)
    after = f"{answer.outcome}: in {show(answer.stopping_time, 's')}"
    if answer.outcome == "NEVER_SLID":
        return f"{after}, by the rope alone: the sheets never slid"
    return after if answer.slip is None else f"{after}, after {show(answer.slip, 'm')} of slip"


def table(drops: Mapping[str, tuple[Answer | None, str]], shown: str) -> str:
    """HTML of the table; what cannot be says so across its column."""
    head = "".join(
        f'<th scope="col"{_mark(mode, shown)}>{escape(MODES[mode])}</th>' for mode in drops
    )
    rows = []
    for i, (key, name) in enumerate(ROWS):
        cells = [f'<th scope="row">{escape(name)}</th>']
        for mode, (answer, refusal) in drops.items():
            fine = answer is not None and bool(answer.feasible)
            if not fine and i == 0:
                why = refusal if answer is None else str(answer.reason)
                ident = f'data-testid="drop-{mode}-outcome"'
                cells.append(
                    f'<td rowspan="{len(ROWS)}" class="cannot" {ident}>cannot: {escape(why)}</td>'
                )
            if fine:
                assert answer is not None
                ident = f'data-testid="drop-{mode}-{key}"'
                cells.append(f"<td{_mark(mode, shown)} {ident}>{escape(_cell(answer, key))}</td>")
        rows.append(f"<tr>{''.join(cells)}</tr>")
    return (
        '<table class="drop-table"><caption class="sr-only">The same drop with no brake, at full '
        f'vacuum and tuned</caption><thead><tr><th scope="col"></th>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _mark(mode: str, shown: str) -> str:
    return ' class="shown"' if mode == shown else ""


def _cell(answer: Answer, key: str) -> str:
    value = answer.values.get(key)
    if key == "outcome":
        return OUTCOMES.get(str(value), "–" if value is None else str(value))
    return readout(value, answer.units.get(key, "1")).replace("^2", "²")
