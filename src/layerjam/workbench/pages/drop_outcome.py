"""What a drop came to: sentences, charts, the table beside other vacuums, and advice to apply."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from html import escape
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import ui

from layerjam.report.chart import Curve, Pane, beside
from layerjam.report.style import GREEN, ORANGE, RED
from layerjam.simulate.record import DropRecord, Outcome
from layerjam.simulate.rope_alone import BareDrop
from layerjam.units import parse, show
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import result_fields
from layerjam.workbench.charts import options
from layerjam.workbench.desk import Desk, with_sheets
from layerjam.workbench.widgets import Hero, button, shipped

if TYPE_CHECKING:
    from layerjam.simulate.crash import Crash


SAMPLES = 240
"""Moments of the record sent to the browser."""
SLOW = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
LASTS = 4.0
"""Least time an animation takes where the factor is chosen by itself [s]."""


def slowness(lasts: float) -> float:
    """Factor of slow motion at which a record of `lasts` [s] takes `LASTS` or a little more."""
    return next((factor for factor in SLOW if factor * lasts >= LASTS), SLOW[-1])


def series(
    record: DropRecord | BareDrop, slow: float | None = None, crash: "Crash | None" = None
) -> dict[str, Any] | None:
    """What the browser needs, in ms, mm, N and m/s²; None where nothing moved.

    `crash` is how a drop goes on that used the travel up; its beginning is the key `crash`.
    """
    if crash is not None and isinstance(record, DropRecord):
        # the first page is shown before what computes is loaded
        from layerjam.simulate.crash import with_crash

        made = series(with_crash(record, crash), slow)
        return None if made is None else {**made, "crash": float(record.time[-1] * 1e3)}
    keep = record.time >= 0
    time, travel = record.time[keep], record.travel[keep]
    if len(time) < 2 or not time[-1] > 0 or not travel.max() > 0:
        return None
    top = int(np.argmax(record.force[record.time >= 0]))
    moments = np.unique(np.append(np.linspace(0, time[-1], SAMPLES), time[top]))
    crashed = isinstance(record, DropRecord) and record.outcome is Outcome.BOTTOMED_OUT

    def sampled(values: Any, factor: float) -> list[float]:
        column = np.interp(moments, time, np.asarray(values)[keep]) * factor
        return [float(f"{value:.5g}") for value in column]

    brake = isinstance(record, DropRecord)
    force = sampled(record.force, 1.0)
    return {
        "time": [float(f"{m:.7g}") for m in moments * 1e3],
        "last": float(moments[-1] * 1e3),
        "travel": sampled(record.travel, 1e3),
        "slip": sampled(record.slip, 1e3) if isinstance(record, DropRecord) else [],
        "force": force,
        "deceleration": sampled(record.deceleration, 1.0),
        "most": float(travel.max() * 1e3),
        "top": max(force),
        "mass": show(record.mass, "kg", 3),
        "brake": brake,
        "horizontal": (record.gravity if isinstance(record, DropRecord) else record.along) == 0,
        "slow": slowness(float(time[-1])) if slow is None else slow,
        "crash": float(time[-1] * 1e3) if crashed else None,
    }


class Animation:
    """The stage with its controls, and the cursor over a chart."""

    def __init__(self, chart: ui.echart | None = None, cursor: ui.element | None = None) -> None:
        """Fills the current slot; `cursor` is an empty element laid over `chart`."""
        self._chart, self._cursor = chart, cursor
        if cursor is not None:
            cursor.classes("drop-cursor")
        stage = ui.html(sanitize=False).classes("w-full")
        self._client, self._root = stage.client, f"drop-animation-{stage.id}"
        page = shipped("pages/drop_animation.html").replace("ROOT", self._root)
        if chart is None:  # a second stage beside that of the page Drop
            page = page.replace('testid="drop-', 'testid="start-drop-')
        stage.set_content(page)
        self._loaded = False

    def load(self, made: dict[str, Any] | None) -> None:
        """Show a time series of `series`; nothing for None."""
        cursor = "" if self._cursor is None else self._cursor.html_id
        data = "null" if made is None else json.dumps({**made, "cursor": cursor})
        chart = "null" if self._chart is None else f"getElement({self._chart.id})"
        call = f"layerjamDropAt('{self._root}').load('{self._root}', {data}, {chart})"
        if not self._loaded:
            self._loaded = True
            call = shipped("pages/drop_animation.js") + call
        self._client.run_javascript(call)

    def play(self) -> None:
        """From its beginning."""
        self._client.run_javascript(f"layerjamDropAt('{self._root}').play()")


def verdict(stop: Any | None, refusal: str) -> str:
    """What happened, in a sentence."""
    if stop is None:
        return f"Cannot: {refusal.rstrip('.')}."
    if not stop.feasible:
        return f"Cannot: {str(stop.reason).rstrip('.')}."
    if stop.outcome == "BOTTOMED_OUT":
        return _crashed(stop)
    if stop.outcome is None:
        return _sentence(str(stop.reason))
    if stop.stopping_time is None:
        return "The mass still moves when the time to follow it is over."
    after = f"in {show(stop.stopping_time, 's')}"
    if stop.outcome == "NEVER_SLID":
        return f"Stopped {after} by the rope alone: the sheets never slid."
    if stop.outcome == "CLOSED_BY_SLEEVE":
        return f"The enclosure pulls the brake shut {after}: friction no longer holds it."
    if stop.slip is None:
        return f"Stopped {after} by the rope, without a brake."
    return f"Stopped {after}, after {show(stop.slip, 'm')} of slip."


def _crashed(stop: Any) -> str:
    """How far it got, how fast it still was, and how hard the end of the travel is."""
    used = f"The travel of {show(stop.slip, 'm')} is used up with the mass still at "
    used += f"{show(stop.end_speed, 'm/s')}: it crashes"
    if stop.crash_force is None:
        return f"{used}. How hard is not known: without a rope nothing says what gives."
    hard = show(stop.crash_force, "N")
    felt = "" if stop.crash_g is None else f", {show(stop.crash_g, '1', 3)} g"
    return f"{used}, with up to {hard}{felt} if the end does not give."


def _sentence(words: str) -> str:
    """With a capital and a full stop."""
    return f"{words[:1].upper()}{words[1:].rstrip('.')}."


GOOD = ("STOPPED", "NEVER_SLID")
"""Outcomes in which the mass was stopped."""


def heroes(stop: Any | None) -> list[Hero]:
    """What a drop is looked at for; a crash counts into the peak, where it is known."""
    if stop is None or not stop.feasible or stop.peak_force is None:
        return []
    crashed = stop.outcome == "BOTTOMED_OUT"
    peak, g = stop.peak_force, stop.peak_g
    name = "Peak"
    if crashed:
        name = "Peak, if the end is rigid" if stop.crash_force else "Peak before the crash"
        peak, g = stop.crash_force or peak, stop.crash_g or g
    made = [("hero-peak", name, show(peak, "N") if g is None else f"{show(g, '1', 3)} g")]
    if stop.slip is not None:
        made.append(("hero-slip", "Slip of the brake", show(stop.slip, "m")))
    if crashed:
        made.append(("hero-end-speed", "Speed at the crash", show(stop.end_speed, "m/s")))
    elif stop.stopping_time is not None:
        made.append(("hero-time", "Stands still after", show(stop.stopping_time, "s")))
    return made


class Advice:
    """Buttons that set what would stop the mass; each of them was tuned before it is named."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._shown: list[object] = []
        self._row = ui.row().classes("items-center gap-2")
        self._row.props["data-testid"] = "drop-advice"

    def fill(self, tuned: Answer, failed: bool) -> None:
        """What a tuning found; nothing where the drop did not fail."""
        ways = list(self._ways(tuned)) if failed and tuned.result is not None else []
        # the same words may set other numbers: a third of another mass
        shown: list[object] = [(text, act.args, act.keywords) for text, _, act in ways]
        if shown == self._shown:
            return
        self._shown = shown
        self._row.clear()
        with self._row:
            if ways:
                ui.label("What would stop it").classes("text-sm")
            for key, (text, tip, act) in enumerate(ways):
                button(text, act, f"drop-advice-{key}", tip=tip)

    def _ways(self, tuned: Answer) -> Iterator[tuple[str, str, partial[None]]]:
        put, found, asked = self._put, tuned.result, tuned.call.options
        if found.feasible:
            there = f"{show(found.vacuum, 'Pa')} of vacuum"
            yield there, "The vacuum that is tuned to the travel", partial(put, shown="tuned")
        if found.sheets_needed is not None:
            count = int(found.sheets_needed)
            tip = "The same brake with as many sheets"
            yield f"{count} sheets", tip, partial(with_sheets, self._desk, count)
        if found.brakes_needed is not None:
            count, parts = int(found.brakes_needed), {"mass": "kg", "rope_stiffness": "N/m"}
            share = {k: parse(asked[k], unit, k) / count for k, unit in parts.items() if k in asked}
            tip = f"Side by side: shows one of them, with 1/{count} of the mass and of the rope"
            yield f"{count} brakes", tip, partial(put, shown="tuned", **share)
        if found.travel_needed is not None:
            far = float(found.travel_needed)
            said = f"{show(far, 'm')} of travel"
            yield said, "Stop within another travel", partial(put, shown="tuned", travel=far)

    def _put(self, **settings: Any) -> None:
        self._desk.put_all("drop", settings)


MODES = MappingProxyType(
    {
        "none": "no brake",
        "full": "full",
        "tuned": "tuned",
        "value": "a value",
        "history": "a history",
    }
)
ROWS = (
    "outcome",
    "vacuum",
    "slip",
    "peak_force",
    "peak_deceleration",
    "peak_g",
    "crash_force",
    "crash_g",
    "stopping_time",
    "end_speed",
    "dissipated_energy",
)
"""These come first; below them stands what else a stop has to say."""
LEFT_OUT = ("feasible", "reason", "speed", "accelerometer", "filter")
OUTCOMES = MappingProxyType(
    {
        "STOPPED": "stopped",
        "NEVER_SLID": "stopped without slip",
        "SNAPS": "snaps",
        "BOTTOMED_OUT": "bottomed out",
        "FINISHED": "still moving",
    }
)


Drops = Mapping[str, Answer]
"""{mode: answer}."""


def notes(drops: Drops) -> list[str]:
    """Warnings of the drops, each with whose it is unless all drops of the brake say it."""
    said = {mode: one.result.warnings for mode, one in drops.items() if one.result is not None}
    by_brake = [warnings for mode, warnings in said.items() if mode != "none"]
    made = []
    for mode, warnings in said.items():
        for w in warnings:
            shared = all(w in other for other in by_brake)
            made.append(w if shared else f"{MODES[mode]}: {w}")
    return list(dict.fromkeys(made))


def table(drops: Drops, shown: str) -> str:
    """HTML of the table; what cannot be says so across its column."""
    stops = {mode: answer.result for mode, answer in drops.items()}
    fine = {mode: dict(stop.rows()) for mode, stop in stops.items() if stop and stop.feasible}
    named = {key.replace("_", " ") for key in LEFT_OUT}
    names = [key.replace("_", " ") for key in ROWS]
    names += [n for texts in fine.values() for n in texts if n not in named]
    names = list(dict.fromkeys(names))
    about = result_fields("drop")
    rows = []
    for i, name in enumerate(names):
        key = name.replace(" ", "_")
        what = escape(about.get(key, ""))
        cells = [f'<th scope="row" title="{what}">{escape(name.capitalize())}</th>']
        for mode, stop in stops.items():
            if mode in fine:
                ident = f'data-testid="drop-{mode}-{key}"'
                text = _cell(key, fine[mode].get(name, "–"))
                cells.append(f"<td{_mark(mode, shown)} {ident}>{escape(text)}</td>")
            elif i == 0:
                why = drops[mode].refusal if stop is None else str(stop.reason)
                ident = f'data-testid="drop-{mode}-outcome"'
                said = f"cannot: {escape(why)}"
                cells.append(f'<td rowspan="{len(names)}" class="cannot" {ident}>{said}</td>')
        rows.append(f"<tr>{''.join(cells)}</tr>")
    heads = [f'<th scope="col"{_mark(m, shown)}>{escape(MODES[m])}</th>' for m in drops]
    return (
        '<table class="drop-table"><caption class="sr-only">The same drop with no brake, at full '
        f"vacuum and tuned</caption><thead><tr><td></td>{''.join(heads)}</tr></thead>"
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _mark(mode: str, shown: str) -> str:
    return ' class="shown"' if mode == shown else ""


def _cell(key: str, text: str) -> str:
    return OUTCOMES.get(text, text) if key == "outcome" else text.replace("^2", "²")


COURSES = ("force", "travel", "deceleration")
"""Keys of a drop's `series` that are drawn over its time."""


def stopped(
    made: Mapping[str, Any], bound: float | None, pins: Mapping[str, Any], dark: bool
) -> dict[str, Any]:
    """The three charts of a drop's `series`; `bound` is the least deceleration [m/s²].

    `pins` are other drops by their labels, drawn quietly and named beside the first chart.
    """
    time, last, quiet = made["time"], made["last"], dict[str, list[Curve]]()
    for label, other in pins.items():
        one = series(other.record, crash=other.crash)
        if one is not None:  # something moved
            quiet[label] = [Curve(one["time"], one[key]) for key in COURSES]
    force, travel, deceleration = ([Curve(time, made[key])] for key in COURSES)
    if made["slip"]:
        travel = [replace(travel[0], name="mass"), Curve(time, made["slip"], ORANGE, "slip")]
    top = max(range(len(time)), key=made["force"].__getitem__)
    peak = (min(time[top], last), made["force"][top], f"{made['force'][top]:.4g} N", RED)
    first: dict[str, Any] = {
        "y_range": (0, 1.18 * made["force"][top]),
        "marks": [peak],
        "share": 1.1,
    }
    least = [] if bound is None else [(bound, "least", GREEN)]
    common: dict[str, Any] = {"x": "time from the taut rope [ms]", "x_range": (0, last)}
    if made["crash"] is not None:
        common["spans"] = [(min(made["crash"], 0.995 * last), last, RED)]
    panes = [
        Pane(force, y="force [N]", **first, **common),
        Pane(travel, y="distance [mm]", **common),
        Pane(deceleration, y="deceleration [m/s²]", y_range=(None, None), levels=least, **common),
    ]
    return options(beside(panes, quiet), dark)
