"""Line charts as ECharts options: axes with units, direct labels, colours of the report."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from layerjam.report.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, RED, SKY

COLORS = MappingProxyType(
    dict(main=BLUE, second=ORANGE, good=GREEN, bad=RED, quiet=GREY, other=PURPLE, sky=SKY)
)
FONT = "Roboto, -apple-system, Helvetica, Arial, sans-serif"
"""The page's own: it comes from this machine, with NiceGUI."""
MARKS = 40
"""Points on a measured curve, equally far apart as one sees it."""
BAND = 0.22
"""How strong the ground of a band is."""
POINTS = 500
"""Points of a curve sent to the browser at most."""
MOST_ROOM = 200
"""Pixels right of a chart for names at most."""
NAMED = 150
"""Pixels for those of pinned curves at most, beside charts that need their width."""


def aside(where: float, end: float) -> dict[str, Any]:
    """How the number above a point is set: to the right of it where the axis' numbers are near."""
    return dict(align="left", offset=[-4, 0]) if where < end / 2 else {}


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
    measured: bool = False
    """A thin line with a point here and there."""


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
    ink = ink_of(dark)
    series = [_series(curve, ink) for curve in curves]
    if series:
        series[0]["markPoint"] = {
            **dict(symbol="circle", symbolSize=9, animation=False),
            "data": [_mark(*mark, ink) for mark in marks],
        }
        series[0]["markArea"] = {"silent": True, "data": [_band(*band) for band in bands]}
    return {
        "animation": False,
        "textStyle": {"fontFamily": FONT},
        "grid": dict(left=62, right=_room([c.name for c in curves]), top=24, bottom=48),
        "tooltip": {
            **dict(trigger="axis", confine=True, order="valueDesc"),
            "axisPointer": {"type": "cross"},
        },
        "xAxis": _axis(x, x_range, log[0], 28, dark),
        "yAxis": _axis(y, y_range, log[1], 44, dark),
        "series": series,
    }


def round_up(value: float) -> float:
    """A round number above a positive one, for an axis."""
    step = 10.0 ** math.floor(math.log10(value)) / 2
    return math.ceil(1.05 * value / step) * step


def ink_of(dark: bool) -> str:
    """The colour of words and lines on the page's ground."""
    return "#dfe5ea" if dark else INK


def _room(names: Sequence[str]) -> int:
    """Pixels right of a chart for the names at the curves' ends."""
    return min(max(28, 14 + 7 * max(map(len, names), default=0)), MOST_ROOM)


def room_of(pins: Collection[str], least: int) -> int:
    """Pixels right of a chart for the names of pinned curves, and for what needs `least`."""
    return max(least, min(_room(list(pins)), NAMED)) if pins else least


def _mark(x: float, y: float, text: str, color: str, ink: str) -> dict[str, Any]:
    """A dot with words over it."""
    label = dict(show=True, position="top", formatter=text, color=ink)
    return dict(coord=[x, y], itemStyle={"color": COLORS.get(color, color)}, label=label)


def _band(start: float, end: float, color: str) -> list[dict[str, Any]]:
    """A stretch of the x axis on coloured ground."""
    ground = dict(color=COLORS.get(color, color), opacity=0.12)
    return [dict(xAxis=start, itemStyle=ground), {"xAxis": end}]


def _axis(
    name: str, limits: tuple[float | None, float | None], log: bool, gap: int, dark: bool
) -> dict[str, Any]:
    ink = ink_of(dark)
    ends = zip(("showMinLabel", "showMaxLabel"), limits, strict=True)
    return {
        **dict(type="log" if log else "value", name=name, nameLocation="middle", nameGap=gap),
        **dict(min=limits[0], max=limits[1]),
        "nameTextStyle": dict(color=ink, fontSize=13),
        # an end that is no round number is where a curve ends, not what is read there
        "axisLabel": dict(color=ink, hideOverlap=True, **{end: _round(v) for end, v in ends}),
        "axisLine": {"show": True, "lineStyle": {"color": GREY}},
        "splitLine": {"lineStyle": {"color": "#3a444d" if dark else "#e3e8ec"}},
    }


def _round(value: float | None) -> bool | None:
    """Whether a number is short enough to stand at the end of an axis; None where there is none."""
    return None if value is None else float(f"{value:.2g}") == value


def stacked(parts: Sequence[dict[str, Any]], shares: Sequence[float]) -> dict[str, Any]:
    """Charts of `options` below each other as one, on one x axis; `shares` of the height."""
    made: dict[str, Any] = dict(animation=False, grid=[], xAxis=[], yAxis=[], series=[])
    made["textStyle"] = parts[0]["textStyle"]
    made["tooltip"] = {**parts[0]["tooltip"], "axisPointer": {"type": "line"}}
    made["axisPointer"] = {"link": [{"xAxisIndex": "all"}]}
    top, room = 3.0, 88.0 - 4.0 * (len(parts) - 1)
    for i, (part, share) in enumerate(zip(parts, shares, strict=True)):
        high = room * share / sum(shares)
        sides = {side: part["grid"][side] for side in ("left", "right")}
        made["grid"].append({**sides, "top": f"{top:.2f}%", "height": f"{high:.2f}%"})
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


def band(low: Curve, high: Curve) -> dict[str, Any]:
    """Coloured ground between two curves on the same x, as one closed line without a width.

    ECharts stacks areas on a category axis alone; below a line that comes back on itself nothing is
    left of the area down to the axis but what the line encloses.
    """
    fine = np.isfinite(np.asarray(low.y, float)) & np.isfinite(np.asarray(high.y, float))
    edges = [thin(np.asarray(c.x)[fine], np.asarray(c.y)[fine]) for c in (high, low)]
    return {
        **dict(type="line", name="", data=[*edges[0], *reversed(edges[1])]),
        **dict(showSymbol=False, silent=True, z=1, color=COLORS.get(high.color, high.color)),
        "emphasis": {"disabled": True},
        "lineStyle": {"width": 0},
        "areaStyle": {"opacity": BAND, "origin": "start"},
        "endLabel": {"show": False},
    }


def marked(pairs: Sequence[Sequence[float | None]], count: int = MARKS) -> list[Any]:
    """Pairs of `thin`, of which about `count` are points to be seen, equally far apart.

    How far apart is measured with either axis as long as the curve reaches on it.
    """
    known = [(k, x, y) for k, (x, y) in enumerate(pairs) if x is not None and y is not None]
    if len(known) < 2:
        return list(pairs)
    places = np.array([k for k, _, _ in known])
    points = np.array([(x, y) for _, x, y in known])
    steps = np.diff(points, axis=0) / np.maximum(np.ptp(points, axis=0), 1e-12)
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*steps.T))))
    chosen = places[np.searchsorted(along, np.linspace(0.0, along[-1], count) - 1e-12)]
    made: list[Any] = list(pairs)
    for k in set(chosen.tolist()):
        made[k] = {"value": pairs[k], "symbol": "circle"}
    return made


def _series(curve: Curve, ink: str) -> dict[str, Any]:
    color = ink if curve.color == "ink" else COLORS.get(curve.color, curve.color)
    made: dict[str, Any] = {
        **dict(type="scatter" if curve.dots else "line", name=curve.name, color=color),
        "data": thin(curve.x, curve.y),
        "emphasis": {"disabled": True},
    }
    if curve.dots:
        return made | {"symbolSize": 4}
    # a line's own colour is too faint for words
    end: dict[str, Any] = dict(show=bool(curve.name), formatter="{a}", color=ink, distance=4)
    end["fontSize"] = 12
    if _room([curve.name]) == MOST_ROOM:
        end |= dict(width=MOST_ROOM - 10, overflow="truncate")
    if curve.measured:
        made |= dict(data=marked(made["data"]), symbol="none", symbolSize=5)
    line = dict(width=curve.width, type="dashed" if curve.dashed else "solid")
    # names at the ends of curves that end alike stand below each other
    apart = {"moveOverlap": "shiftY"}
    return made | dict(
        showSymbol=curve.measured, silent=True, lineStyle=line, endLabel=end, labelLayout=apart
    )
