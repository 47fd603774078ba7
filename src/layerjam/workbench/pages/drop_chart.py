"""The chart of the page Drop: force, distance and deceleration over time, pinned ones beside."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from layerjam.workbench.charts import NAMED, Curve, aside, options, room_of, stacked
from layerjam.workbench.pages.drop_animation import series

RIGHT = 56
"""Pixels right of the charts without pinned curves."""


def stopped(
    made: Mapping[str, Any], bound: float | None, pins: Mapping[str, Any], dark: bool
) -> dict[str, Any]:
    """The three charts of a drop's `series`; `bound` is the least deceleration [m/s²].

    `pins` are other drops by their labels, drawn quietly and named beside the first chart.
    """
    time, last = made["time"], made["last"]
    force = [Curve(time, made["force"])]
    travel = [Curve(time, made["travel"], name="mass")]
    if made["slip"]:
        travel.append(Curve(time, made["slip"], "second", "slip"))
    deceleration = [Curve(time, made["deceleration"])]
    if bound is not None:
        line = Curve([0, last], [bound] * 2, "good", "least", dashed=True, width=1.5)
        deceleration.append(line)
    own, end = (len(force), len(travel), len(deceleration)), last
    for label, other in pins.items():
        quiet = series(other.record, crash=other.crash)
        if quiet is None:  # nothing moved
            continue
        end = max(end, quiet["last"])
        for curves, key in zip(
            (force, travel, deceleration), ("force", "travel", "deceleration"), strict=True
        ):
            curves.append(Curve(quiet["time"], quiet[key], "quiet", label, width=1.2))
    common: dict[str, Any] = {"x_range": (0, end), "dark": dark}
    common["x"] = "time from the taut rope [ms]"
    if made["crash"] is not None:
        common["bands"] = [(min(made["crash"], 0.995 * last), last, "bad")]
    top = max(range(len(time)), key=made["force"].__getitem__)
    peak = (time[top], made["force"][top], f"{made['force'][top]:.4g} N", "bad")
    parts = [
        options(force, y="force [N]", marks=[peak], **common),
        options(travel, y="distance [mm]", **common),
        options(deceleration, y="deceleration [m/s²]", y_range=(None, None), **common),
    ]
    # room above the peak for its number
    parts[0]["yAxis"]["boundaryGap"] = [0, 0.18]
    parts[0]["series"][0]["markPoint"]["data"][0]["label"] |= aside(time[top], end)
    for series_, shift in zip(parts[1]["series"][: own[1]], (-6, 7), strict=False):
        series_["endLabel"]["offset"] = [0, shift]
    for place, part in enumerate(parts):
        part["grid"]["right"] = room_of(pins, RIGHT)
        for series_ in part["series"][own[place] :]:
            series_["endLabel"] |= dict(show=place == 0, width=NAMED - 8, overflow="truncate")
    return stacked(parts, (1.1, 1, 1))
