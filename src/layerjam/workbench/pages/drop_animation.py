"""The drop in slow motion, beside a cursor in the charts: drawn in the browser from one record."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import ui

from layerjam.simulate.record import DropRecord, Outcome
from layerjam.simulate.rope_alone import BareDrop
from layerjam.units import show
from layerjam.workbench.widgets import shipped

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
    record: DropRecord | BareDrop, slow: float | None = None, crash: Crash | None = None
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
    moments = np.unique(np.append(np.linspace(0, time[-1], SAMPLES), time[record_top(record)]))

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
        "crash": float(time[-1] * 1e3) if record_crashes(record) else None,
    }


def record_top(record: DropRecord | BareDrop) -> int:
    """Position of the greatest force among the samples from time zero on."""
    return int(np.argmax(record.force[record.time >= 0]))


def record_crashes(record: DropRecord | BareDrop) -> bool:
    """Whether the mass still moved when the travel was used up."""
    return isinstance(record, DropRecord) and record.outcome is Outcome.BOTTOMED_OUT


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
