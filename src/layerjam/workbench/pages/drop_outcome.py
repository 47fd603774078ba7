"""Outcome of a drop: sentences, charts, a table of vacuums, and suggestions to apply."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import ui

from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.brake.simulate.rope_alone import BareDrop
from layerjam.core.drawing.chart import Curve, Pane, add_comparisons
from layerjam.core.drawing.style import GREEN, ORANGE, RED
from layerjam.core.units import parse, show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import result_fields
from layerjam.workbench.certainty import without_intervals
from layerjam.workbench.charts import chart_options
from layerjam.workbench.desk import Desk, set_sheets
from layerjam.workbench.widgets import (
    Hero,
    button,
    dress,
    predicted_hero,
    read_asset,
    round_value,
)

if TYPE_CHECKING:
    from layerjam.brake.simulate.crash import Crash


SAMPLES = 160
"""Number of samples of the record that are sent to the browser."""
SLOW = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
SAFE = 0.95
"""Share of stops that a safe vacuum keeps within the travel, unless another is chosen."""
FOLLOWS = "…"
"""Text in place of a number that follows once the sliders rest."""
LASTS = 4.0
"""Minimum duration of an animation with automatic slow motion [s]."""


def slow_motion_factor(lasts: float) -> float:
    """Return the smallest slow-motion factor that makes `lasts` [s] take at least `LASTS`."""
    return next((factor for factor in SLOW if factor * lasts >= LASTS), SLOW[-1])


def time_series(
    record: DropRecord | BareDrop, slow: float | None = None, crash: "Crash | None" = None
) -> dict[str, Any] | None:
    """Return the time series for the browser, in ms, mm, N and m/s²; None if nothing moved.

    `crash` is the motion after the travel is used up; the `crash` key is its start time.
    """
    if crash is not None and isinstance(record, DropRecord):
        # import late, so that the first page is shown before the computing code is loaded
        from layerjam.brake.simulate.crash import append_crash

        data = time_series(append_crash(record, crash), slow)
        return None if data is None else {**data, "crash": float(record.time[-1] * 1e3)}
    keep = record.time >= 0
    time, travel = record.time[keep], record.displacement[keep]
    if len(time) < 2 or not time[-1] > 0 or not travel.max() > 0:
        return None
    top = int(np.argmax(record.force[record.time >= 0]))
    moments = np.unique(np.append(np.linspace(0, time[-1], SAMPLES), time[top]))
    crashed = isinstance(record, DropRecord) and record.outcome is Outcome.BOTTOMED_OUT

    def resample(values: Any, factor: float) -> list[float]:
        column = np.interp(moments, time, np.asarray(values)[keep]) * factor
        return [float(f"{value:.5g}") for value in column]

    brake = isinstance(record, DropRecord)
    force = resample(record.force, 1.0)
    return {
        "time": [float(f"{m:.7g}") for m in moments * 1e3],
        "last": float(moments[-1] * 1e3),
        "travel": resample(record.displacement, 1e3),
        "slip": resample(record.slip, 1e3) if isinstance(record, DropRecord) else [],
        "force": force,
        "deceleration": resample(record.deceleration, 1.0),
        "most": float(travel.max() * 1e3),
        "top": max(force),
        "mass": show(record.mass, "kg", 3),
        "brake": brake,
        "horizontal": (record.gravity if isinstance(record, DropRecord) else record.along) == 0,
        "slow": slow_motion_factor(float(time[-1])) if slow is None else slow,
        "crash": float(time[-1] * 1e3) if crashed else None,
    }


class Animation:
    """The animated stage with its controls, and a cursor on a chart."""

    def __init__(self, chart: ui.echart | None = None, cursor: ui.element | None = None) -> None:
        """Build the stage in the current slot; `cursor` is an empty element on top of `chart`."""
        self._chart, self._cursor = chart, cursor
        if cursor is not None:
            cursor.classes("drop-cursor")
        stage = ui.html(sanitize=False).classes("w-full")
        self._client, self._root = stage.client, f"drop-animation-{stage.id}"
        page = read_asset("pages/drop_animation.html").replace("ROOT", self._root)
        if chart is None:  # this is a second stage, in addition to that of the Drop page
            page = page.replace('testid="drop-', 'testid="start-drop-')
        stage.set_content(page)
        self._loaded = False

    def load_series(self, content: dict[str, Any] | None) -> None:
        """Load the time series from `time_series`; None clears the stage."""
        cursor = "" if self._cursor is None else self._cursor.html_id
        data = "null" if content is None else json.dumps({**content, "cursor": cursor})
        chart = "null" if self._chart is None else f"getElement({self._chart.id})"
        call = f"layerjamDropAt('{self._root}').load('{self._root}', {data}, {chart})"
        if not self._loaded:
            self._loaded = True
            call = read_asset("pages/drop_animation.js") + call
        self._client.run_javascript(call)

    def play(self) -> None:
        """Play from the beginning."""
        self._client.run_javascript(f"layerjamDropAt('{self._root}').play()")


def describe_drop(stop: Any | None, refusal: str, inputs: Mapping[str, Any]) -> str:
    """Return the outcome of a drop with these `inputs`, as a sentence."""
    if stop is None:
        return f"Not possible: {refusal.rstrip('.')}."
    if not stop.feasible:
        return f"Not possible: {str(stop.reason).rstrip('.')}."
    if stop.outcome == "BOTTOMED_OUT":
        return _crash_sentence(stop)
    if stop.outcome is None:
        words = str(stop.reason).rstrip(".")
        return f"{words[:1].upper()}{words[1:]}."
    if stop.stopping_time is None:
        return "The mass is still moving at the end of the simulation."
    time_text = f"in {round_value(show(stop.stopping_time, 's'))}"
    if stop.outcome == "NEVER_SLID":
        return f"Stopped {time_text} by the rope alone: the sheets never slid."
    if stop.outcome == "CLOSED_BY_SLEEVE":
        return (
            f"The enclosure pulls the brake back {time_text}, because friction no longer holds it."
        )
    who, distance = "The rope alone", time_text
    if stop.slip is not None:
        who = "This vacuum history" if stop.vacuum is None else show(stop.vacuum, "Pa", 3)
        is_tuned = inputs.get("vacuum") == "tuned"
        distance = f"within {inputs['travel'] if is_tuned else show(stop.slip, 'm', 3)}"
    start = inputs.get("speed") or f"a fall of {inputs.get('height')}"
    peak = "" if stop.peak_g is None else f", at up to {show(stop.peak_g, '1', 3)} g"
    return f"{who} stops {inputs['mass']} from {start} {distance}{peak}."


def _crash_sentence(stop: Any) -> str:
    used = f"The travel of {show(stop.slip, 'm')} is used up with the mass still moving at "
    used += f"{show(stop.end_speed, 'm/s')}: it hits the end stop"
    if stop.crash_force is None:
        return f"{used}. The impact force is unknown, because no rope is given."
    hard = show(stop.crash_force, "N")
    in_g = "" if stop.crash_g is None else f", {show(stop.crash_g, '1', 3)} g"
    return f"{used}, with up to {hard}{in_g} if the end stop is rigid."


GOOD = ("STOPPED", "NEVER_SLID")
"""Outcomes in which the mass was stopped."""


def headlines(stop: Any | None, tuning: Answer | None = None) -> list[Hero]:
    """Return the headline numbers of a drop; peaks include impacts.

    With the `tuning` of its vacuum, the vacuums come first: the one that uses exactly the travel on
    average, and the one that is enough for most stops.
    """
    if stop is None or not stop.feasible or stop.peak_force is None:
        return []
    numbers = [] if tuning is None else vacuum_headlines(tuning)
    if stop.outcome == "BOTTOMED_OUT":
        name = "Peak with a rigid end stop" if stop.crash_force else "Peak before the impact"
        peak, g = stop.crash_force or stop.peak_force, stop.crash_g or stop.peak_g
        text = show(peak, "N") if g is None else f"{show(g, '1')} g"
        numbers.append(Hero("hero-peak", name, text))
    else:
        numbers.append(predicted_hero("hero-peak", "Peak force", stop, "peak_force"))
    if tuning is None and stop.slip is not None:
        numbers.append(predicted_hero("hero-slip", "Brake slip", stop, "slip"))
    if stop.outcome == "BOTTOMED_OUT":
        numbers.append(predicted_hero("hero-end-speed", "Speed at impact", stop, "end_speed"))
    elif stop.stopping_time is not None:
        numbers.append(predicted_hero("hero-time", "Stopping time", stop, "stopping_time"))
    return numbers


def vacuum_headlines(tuning: Answer) -> list[Hero]:
    """Return a tuning's vacuums: that of the average stop, and that which suits most stops."""
    result, options = tuning.result, tuning.call.options
    numbers = [predicted_hero("hero-vacuum", "Mean required vacuum", result, "vacuum")]
    share = parse(options.get("confidence", SAFE), "1", "confidence") * 100
    name = f"Keeps {share:.4g} % of stops within {options['travel']}"
    if not result.basis:
        numbers.append(Hero("hero-safe", name, FOLLOWS))
    elif result.safe_vacuum is not None:
        numbers.append(predicted_hero("hero-safe", name, result, "safe_vacuum"))
    return numbers


def await_intervals(numbers: Iterable[Hero]) -> list[Hero]:
    """Return headline numbers with space for their intervals, which follow."""
    return [n if n.text == FOLLOWS else n._replace(interval=FOLLOWS) for n in numbers]


WAYS: Mapping[str, str] = {
    "vacuum": "The vacuum tuned to the travel",
    "sheets": "The same brake with this number of sheets",
    "brakes": "Brakes in parallel: one is shown, with its share of the mass",
    "travel": "Stop within a different travel",
}
"""{change that may stop the mass: tooltip of its button}."""


class Advice:
    """Buttons that apply settings which stop the mass; each setting was tuned beforehand."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._acts: dict[str, partial[None]] = {}
        self._texts: dict[str, tuple[ui.button, live.Words]] = {}
        with dress(ui.row(), "drop-advice", "items-center gap-2") as self._row:
            ui.label("Ways to stop it").classes("text-sm")
            for key, tip in WAYS.items():
                item = button("", partial(self._take, key), f"drop-advice-{key}", tip=tip)
                with item:
                    self._texts[key] = item, live.Words("")
        self._row.set_visibility(False)

    def _take(self, key: str) -> None:
        if key in self._acts:  # a click may arrive after the inputs have changed
            self._acts[key]()

    def hide(self) -> None:
        """Show no suggestion, because none is needed or the inputs have changed."""
        self._show(())

    def fill(self, tuning: Answer) -> None:
        """Show a tuning's suggestions."""
        self._show(tuple(self._find_ways(tuning)))

    def _show(self, ways: Sequence[tuple[str, str, partial[None]]]) -> None:
        self._acts = {key: act for key, _, act in ways}
        self._row.set_visibility(bool(ways))
        for key, text, _ in ways:
            self._texts[key][1].set_text(text)
        for key, (item, _) in self._texts.items():
            item.set_visibility(key in self._acts)

    def _find_ways(self, tuning: Answer) -> Iterator[tuple[str, str, partial[None]]]:
        put, texts = partial(self._desk.put_settings, "drop"), tuning.call.options
        result = tuning.result
        if result.feasible:
            label = f"vacuum of {show(result.vacuum, 'Pa')}"
            yield "vacuum", label, partial(put, {"shown": "tuned"})
        if result.sheets_needed is not None:
            count = int(result.sheets_needed)
            yield "sheets", f"{count} sheets", partial(set_sheets, self._desk, count)
        if result.brakes_needed is not None:
            count, parts = int(result.brakes_needed), {"mass": "kg", "rope_stiffness": "N/m"}
            share = {k: parse(texts[k], unit, k) / count for k, unit in parts.items() if k in texts}
            yield "brakes", f"{count} brakes", partial(put, {"shown": "tuned", **share})
        if result.travel_needed is not None:
            travel = float(result.travel_needed)
            label = f"travel of {show(travel, 'm')}"
            yield "travel", label, partial(put, {"shown": "tuned", "travel": travel})


MODES: Mapping[str, str] = {
    "none": "no brake",
    "full": "full",
    "tuned": "tuned",
    "value": "a value",
    "history": "a history",
}
ROWS = ("outcome", "vacuum", "slip", "peak_force", "peak_g", "crash_g", "stopping_time")
"""Rows of the comparison above the charts; the "All numbers" panel contains the others."""
LEFT_OUT = ("feasible", "reason", "speed", "accelerometer", "filter")
OUTCOMES: Mapping[str, str] = {
    "STOPPED": "stopped",
    "NEVER_SLID": "stopped without slip",
    "SNAPS": "snaps",
    "BOTTOMED_OUT": "bottomed out",
    "FINISHED": "still moving",
}


Drops = Mapping[str, Answer]
"""{mode: answer}."""


def list_notes(drops: Drops, tuning: Any | None = None) -> list[str]:
    """Return the drops' warnings, and those of the tuning that no drop has.

    One that not all drops share begins with its drop's name.
    """
    by_mode = {
        mode: answer.result.warnings for mode, answer in drops.items() if answer.result is not None
    }
    by_brake = [warnings for mode, warnings in by_mode.items() if mode != "none"]
    lines = []
    for mode, warnings in by_mode.items():
        for w in warnings:
            is_shared = all(w in notes_of_mode for notes_of_mode in by_brake)
            lines.append(w if is_shared else f"{MODES[mode]}: {w}")
    sentences = {w for warnings in by_mode.values() for w in warnings}
    lines += [w for w in (() if tuning is None else tuning.warnings) if w not in sentences]
    return list(dict.fromkeys(lines))


def drop_tables(drops: Drops, mode_shown: str) -> tuple[str, str]:
    """Return the main rows and the others as HTML; a rejected drop's column shows the reason.

    Cells have no room for intervals, which the large numbers state.
    """
    stops = {mode: without_intervals(answer.result) for mode, answer in drops.items()}
    rows_by_mode = {
        mode: dict(stop.rows()) for mode, stop in stops.items() if stop and stop.feasible
    }
    main_keys = [key.replace("_", " ") for key in ROWS]
    left_out = {key.replace("_", " ") for key in LEFT_OUT}.union(main_keys)
    given = dict.fromkeys(
        n for texts in rows_by_mode.values() for n, text in texts.items() if text != "–"
    )
    main_names = [n for n in main_keys if n in given] or main_keys[:1]
    other_names = [n for n in given if n not in left_out]
    return (
        _table_html(drops, rows_by_mode, main_names, mode_shown),
        _table_html(drops, rows_by_mode, other_names, mode_shown, is_main=False),
    )


def _table_html(
    drops: Drops,
    rows_by_mode: Mapping[str, Mapping[str, str]],
    names: Sequence[str],
    mode_shown: str,
    is_main: bool = True,
) -> str:
    """Return a table of the named rows; `rows_by_mode`: {mode: {name: text}} of possible drops."""
    meanings = result_fields("drop")
    rows = []
    for i, name in enumerate(names):
        key = name.replace(" ", "_")
        meaning = escape(meanings.get(key, ""))
        cells = [f'<th scope="row" title="{meaning}">{escape(name.capitalize())}</th>']
        for mode, answer in drops.items():
            if mode in rows_by_mode:
                ident = f'data-testid="drop-{mode}-{key}"'
                text = rows_by_mode[mode].get(name, "–")
                text = OUTCOMES.get(text, text) if key == "outcome" else text.replace("^2", "²")
                cells.append(f"<td{_mode_mark(mode, mode_shown)} {ident}>{escape(text)}</td>")
            elif i == 0:
                reason = str(answer.result.reason) if answer.result else answer.refusal
                ident = f'data-testid="drop-{mode}-outcome"'
                text_cell = f"not possible: {escape(reason)}"
                ident = ident if is_main else ""
                cells.append(f'<td rowspan="{len(names)}" class="cannot" {ident}>{text_cell}</td>')
        rows.append(f"<tr>{''.join(cells)}</tr>")
    heads = [f'<th scope="col"{_mode_mark(m, mode_shown)}>{escape(MODES[m])}</th>' for m in drops]
    return (
        '<table class="drop-table"><caption class="sr-only">The same drop with no brake, at full '
        f"vacuum and tuned</caption><thead><tr><td></td>{''.join(heads)}</tr></thead>"
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _mode_mark(mode: str, mode_shown: str) -> str:
    return ' class="shown"' if mode == mode_shown else ""


COURSES = ("force", "travel", "deceleration")
"""Keys of `time_series` that are drawn versus time."""


def drop_chart(
    data: Mapping[str, Any], bound: float | None, pins: Mapping[str, Any], dark: bool
) -> dict[str, Any]:
    """Return three charts of `time_series`; `bound` is the lowest possible deceleration [m/s²].

    `pins` is {label: other drop}; these are drawn faintly and named next to the first chart.
    """
    time, last, quiet = data["time"], data["last"], dict[str, list[Curve]]()
    for label, result in pins.items():
        curves = time_series(result.record, crash=result.crash)
        if curves is not None:  # draw only if something moved
            quiet[label] = [Curve(curves["time"], curves[key]) for key in COURSES]
    force, travel, deceleration = ([Curve(time, data[key])] for key in COURSES)
    if data["slip"]:
        travel = [replace(travel[0], name="mass"), Curve(time, data["slip"], ORANGE, "slip")]
    top = max(range(len(time)), key=data["force"].__getitem__)
    peak = (min(time[top], last), data["force"][top], f"{data['force'][top]:.4g} N", RED)
    first: dict[str, Any] = {
        "y_range": (0, 1.18 * data["force"][top]),
        "marks": [peak],
        "share": 1.1,
    }
    bound_marks = [] if bound is None else [(bound, "lowest possible", GREEN)]
    common: dict[str, Any] = {"x": "time since the rope became taut [ms]", "x_range": (0, last)}
    if data["crash"] is not None:
        common["spans"] = [(min(data["crash"], 0.995 * last), last, RED)]
    panes = [
        Pane(force, y="force [N]", **first, **common),
        Pane(travel, y="distance [mm]", **common),
        Pane(
            deceleration,
            y="deceleration [m/s²]",
            y_range=(None, None),
            levels=bound_marks,
            **common,
        ),
    ]
    return chart_options(add_comparisons(panes, quiet), dark)
