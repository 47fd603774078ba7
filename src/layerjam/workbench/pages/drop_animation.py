"""The drop in slow motion, beside a cursor in the charts: drawn in the browser from one record."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

import numpy as np
from nicegui import ui

from layerjam.simulate.record import DropRecord
from layerjam.simulate.rope_alone import BareDrop
from layerjam.units import show

SAMPLES = 240
"""Moments of the record sent to the browser."""
SLOW = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
LASTS = 4.0
"""Least time an animation takes where the factor is chosen by itself [s]."""
STYLE = """
.drop-stage { color: inherit; width: 100%; display: block }
.drop-play { min-width: 108px; padding: 6px 14px; border-radius: 4px; border: 0; font: inherit;
  color: #fff; background: #0B5C8E; cursor: pointer }
.drop-scrub { width: 100%; accent-color: #0B5C8E }
.drop-now { display: grid; grid-template-columns: auto auto; gap: 2px 12px; font-size: 0.875rem }
.drop-now dd { margin: 0; text-align: right; font-variant-numeric: tabular-nums }
.drop-cursor { position: absolute; left: 0; top: 0; bottom: 0; width: 0; display: none;
  border-left: 1.5px solid #D55E00; pointer-events: none }
"""
_HTML = """
<div id="{root}" style="visibility:hidden" data-testid="drop-animation">
<svg class="drop-stage" data-part="stage" role="img"
 aria-label="A mass on a rope pulls the brake: drawn in slow motion"></svg>
<div style="display:flex;align-items:center;gap:12px;margin:6px 0">
<button type="button" class="drop-play" data-part="play" data-testid="drop-play"
 aria-label="Play or pause the drop">▶ Drop</button>
<span data-part="slow" data-testid="drop-slow-said" style="font-size:0.875rem"></span></div>
<input type="range" class="drop-scrub" data-part="scrub" data-testid="drop-scrub" min="0" max="1000"
 step="5" value="0" aria-label="Moment of the drop"/>
<dl class="drop-now" data-testid="drop-now">
<dt>time from the taut rope</dt><dd data-part="clock"></dd>
<dt>force on the mass</dt><dd data-part="force"></dd>
<dt>way of the mass</dt><dd data-part="travel"></dd>
<dt>deceleration</dt><dd data-part="deceleration"></dd></dl></div>
"""


def slowness(lasts: float) -> float:
    """Factor of slow motion at which a record of `lasts` [s] takes `LASTS` or a little more."""
    return next((factor for factor in SLOW if factor * lasts >= LASTS), SLOW[-1])


def series(record: DropRecord | BareDrop, slow: float | None = None) -> dict[str, Any] | None:
    """What the browser needs, in ms, mm, N and m/s²; None where nothing moved."""
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
    }


def record_top(record: DropRecord | BareDrop) -> int:
    """Place of the greatest force among the samples from time zero on."""
    return int(np.argmax(record.force[record.time >= 0]))


class Animation:
    """The stage with its controls, and the cursor over a chart."""

    def __init__(self, chart: ui.echart, cursor: ui.element) -> None:
        """Fills the current slot; `cursor` is an empty element laid over `chart`."""
        self._chart, self._cursor = chart, cursor
        cursor.classes("drop-cursor")
        self._root = f"drop-animation-{chart.id}"
        ui.html(_HTML.format(root=self._root), sanitize=False).classes("w-full")
        self._loaded = False

    def load(self, made: dict[str, Any] | None) -> None:
        """Show a time series of `series`; nothing for None."""
        data = "null" if made is None else json.dumps({**made, "cursor": self._cursor.html_id})
        call = f"layerjamDrop.load('{self._root}', {data}, getElement({self._chart.id}))"
        if not self._loaded:
            self._loaded = True
            here = files("layerjam.workbench.pages") / "drop_animation.js"
            call = here.read_text(encoding="utf-8") + call
        self._chart.client.run_javascript(call)
