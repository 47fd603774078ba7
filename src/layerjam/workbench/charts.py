"""Line charts as ECharts options: axes with units, direct labels, colours of the report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.report.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, RED, SKY

COLORS = {"main": BLUE, "second": ORANGE, "good": GREEN, "bad": RED, "quiet": GREY,
          "other": PURPLE, "sky": SKY}  # fmt: skip
POINTS = 500
"""Points of a curve sent to the browser at most."""


@dataclass(frozen=True)
class Curve:
    """A line of a chart; `x` and `y` shape (N,) in the chart's units; `name` stands at its end."""

    x: Any
    y: Any
    color: str = "main"
    name: str = ""
    dashed: bool = False
    width: float = 2.0
    dots: bool = False


def thin(x: Any, y: Any, points: int = POINTS) -> list[list[float | None]]:
    """Pairs for the browser: all, or a lowest and a highest value of every stretch."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    if len(x) > points:
        last = len(x) - 1
        width = -(-len(x) // (points // 2))
        part = np.minimum(np.arange(-(-len(x) // width) * width), last).reshape(-1, width)
        height = np.where(np.isfinite(y), y, 0.0)[part]
        rows = np.arange(len(part))
        lowest, highest = part[rows, height.argmin(1)], part[rows, height.argmax(1)]
        pick = np.unique(np.concatenate(([0, last], lowest, highest)))
        x, y = x[pick], y[pick]
    return [list(pair) for pair in zip(_short(x), _short(y), strict=True)]


def _short(values: Any) -> list[float | None]:
    """Six digits: fewer bytes on the way to the browser; None for what is no number."""
    fine = np.isfinite(values) & (values != 0)
    size = np.floor(np.log10(np.abs(np.where(fine, values, 1.0))))
    digits = np.clip(5 - size, 0, 300)
    made = np.where(fine, np.round(values * 10**digits) / 10**digits, values).tolist()
    return [v if math.isfinite(v) else None for v in made]


def options(
    curves: Sequence[Curve],
    *,
    x: str,
    y: str,
    x_range: tuple[float | None, float | None] = (None, None),
    y_range: tuple[float | None, float | None] = (0, None),
    marks: Sequence[tuple[float, float, str, str]] = (),
    bands: Sequence[tuple[float, float, str]] = (),
    dark: bool = False,
    log: tuple[bool, bool] = (False, False),
) -> dict[str, Any]:
    """The chart. `marks` are (x, y, text, colour), `bands` (x from, x to, colour) on the ground."""
    ink = "#dfe5ea" if dark else INK
    faint = "#3a444d" if dark else "#e3e8ec"
    series = [_series(curve, ink) for curve in curves]
    if series:
        series[0]["markPoint"] = {
            "symbol": "circle", "symbolSize": 9, "animation": False,
            "data": [
                {"coord": [a, b], "itemStyle": {"color": COLORS.get(color, color)},
                 "label": {"show": True, "position": "top", "formatter": text, "color": ink}}
                for a, b, text, color in marks
            ],
        }  # fmt: skip
        series[0]["markArea"] = {
            "silent": True,
            "data": [
                [{"xAxis": a, "itemStyle": {"color": COLORS.get(c, c), "opacity": 0.12}},
                 {"xAxis": b}] for a, b, c in bands
            ],
        }  # fmt: skip

    def axis(
        name: str, limits: tuple[float | None, float | None], logarithmic: bool, gap: int
    ) -> Any:
        return {
            "type": "log" if logarithmic else "value", "name": name, "nameLocation": "middle",
            "nameGap": gap, "min": limits[0], "max": limits[1],
            "nameTextStyle": {"color": ink, "fontSize": 13},
            "axisLabel": {"color": ink, "hideOverlap": True},
            "axisLine": {"show": True, "lineStyle": {"color": GREY}},
            "splitLine": {"lineStyle": {"color": faint}},
        }  # fmt: skip

    return {
        "animation": False,
        "grid": {"left": 62, "right": 96, "top": 24, "bottom": 48},
        "tooltip": {
            "trigger": "axis", "axisPointer": {"type": "cross"}, "confine": True,
            "order": "valueDesc",
        },
        "xAxis": axis(x, x_range, log[0], 28),
        "yAxis": axis(y, y_range, log[1], 44),
        "series": series,
    }  # fmt: skip


def stacked(parts: Sequence[dict[str, Any]], shares: Sequence[float]) -> dict[str, Any]:
    """Charts of `options` below each other as one, on one x axis; `shares` of the height."""
    made: dict[str, Any] = {
        "animation": False, "grid": [], "xAxis": [], "yAxis": [], "series": [],
        "tooltip": {**parts[0]["tooltip"], "axisPointer": {"type": "line"}},
        "axisPointer": {"link": [{"xAxisIndex": "all"}]},
    }  # fmt: skip
    top, room = 3.0, 88.0 - 4.0 * (len(parts) - 1)
    for i, (part, share) in enumerate(zip(parts, shares, strict=True)):
        high = room * share / sum(shares)
        made["grid"].append({
            "left": part["grid"]["left"], "right": part["grid"]["right"],
            "top": f"{top:.2f}%", "height": f"{high:.2f}%",
        })  # fmt: skip
        top += high + 4.0
        last = i == len(parts) - 1
        under = {} if last else {"name": "", "axisLabel": {"show": False}}
        made["xAxis"].append({**part["xAxis"], **under, "gridIndex": i})
        made["yAxis"].append({**part["yAxis"], "gridIndex": i})
        made["series"] += [
            {**series, "xAxisIndex": i, "yAxisIndex": i} for series in part["series"]
        ]
    return made


def with_readout(made: dict[str, Any], x: tuple[str, str], unit: str) -> dict[str, Any]:
    """The chart with a cursor that reads every curve; `x` is the axis' name and unit."""
    rows = (
        "const seen = new Set(); const rows = p.filter(s => s.seriesName && s.value[1] != null"
        " && !seen.has(s.seriesName) && seen.add(s.seriesName)).map(s => s.marker +"
        " s.seriesName.replace(/[<>&]/g, '') + ': <b>' + (+s.value[1]).toPrecision(4) +"
    )
    # the text is ours; a curve's name, which may be a file's, loses what HTML would read
    made["tooltip"][":formatter"] = (
        f"p => {{ {rows} ' {unit}</b>'); return '{x[0]} ' +"
        f" (+p[0].axisValue).toPrecision(4) + ' {x[1]}<br>' + rows.join('<br>'); }}"
    )
    return made


def _series(curve: Curve, ink: str) -> dict[str, Any]:
    color = ink if curve.color == "ink" else COLORS.get(curve.color, curve.color)
    made: dict[str, Any] = {
        "type": "scatter" if curve.dots else "line", "name": curve.name,
        "data": thin(curve.x, curve.y), "color": color, "emphasis": {"disabled": True},
    }  # fmt: skip
    if curve.dots:
        return made | {"symbolSize": 4}
    # a line's own colour is too faint for words
    return made | {
        "showSymbol": False, "silent": True,
        "lineStyle": {"width": curve.width, "type": "dashed" if curve.dashed else "solid"},
        "endLabel": {"show": bool(curve.name), "formatter": "{a}", "color": ink,
                     "distance": 4, "fontSize": 12},
    }  # fmt: skip
