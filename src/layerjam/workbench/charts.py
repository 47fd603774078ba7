"""Line charts as ECharts options: axes with units, direct labels, the report's colours."""

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.core.drawing.chart import Curve, Ends, Pane
from layerjam.core.drawing.style import GREY, INK

LOW = 35.0
"""Height of a pane [%] below which its y axis has fewer tick labels."""
TALL, LINE = 290.0, 15.0
"""Approximate height of a single pane, and minimum spacing of names at curve ends [pixels]."""
FONT = "Roboto, -apple-system, Helvetica, Arial, sans-serif"
"""Font of the page, served from this machine by NiceGUI."""
MARKS = 40
"""Number of marked points on a measured curve, equally spaced on the screen."""
BAND = 0.22
"""Opacity of a band."""
POINTS = 500
"""Maximum number of points per curve that are sent to the browser."""
MOST_ROOM = 200
"""Maximum width of the curve names to the right of a chart [pixels]."""
LETTERS = 31
"""Maximum number of characters of a curve name next to a chart."""


def thin_points(x: Any, y: Any, points: int = POINTS) -> list[list[float | None]]:
    """Return (x, y) pairs for the browser: all, or those with minimum or maximum y per interval."""
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
    pairs = _round_values(np.column_stack((x, y)))
    numbers = pairs.astype(object)
    numbers[~np.isfinite(pairs)] = None
    result: list[list[float | None]] = numbers.tolist()
    return result


def _round_values(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Round finite values to six digits, to send fewer bytes to the browser."""
    is_rounded = np.isfinite(values) & (values != 0)
    scale = 10 ** np.clip(5 - np.floor(np.log10(np.abs(np.where(is_rounded, values, 1.0)))), 0, 300)
    return np.where(is_rounded, np.round(values * scale) / scale, values)


def chart_options(panes: Sequence[Pane], dark: bool = False) -> dict[str, Any]:
    """Return a chart of panes that are stacked vertically and share their x axis."""
    chart: dict[str, Any] = dict(animation=False, grid=[], xAxis=[], yAxis=[], series=[])
    lone, ink = len(panes) == 1, text_colour(dark)
    right = max(_label_width(pane.lines) for pane in panes)
    top, room = 3.0, 88.0 - 4.0 * (len(panes) - 1)
    firsts = []
    for i, pane in enumerate(panes):
        high = room * pane.share / sum(p.share for p in panes)
        place = dict(top=24, bottom=48) if lone else dict(top=f"{top:.2f}%", height=f"{high:.2f}%")
        chart["grid"].append({**dict(left=62, right=right), **place})
        top += high + 4.0
        chart["xAxis"].append({**_make_axis(pane.x, pane.x_range, 28, dark), "gridIndex": i})
        if pane is not panes[-1]:
            chart["xAxis"][i] |= {"name": "", "axisLabel": {"show": False}}
        chart["yAxis"].append({**_make_axis(pane.y, pane.y_range, 44, dark), "gridIndex": i})
        if high < LOW:
            chart["yAxis"][i]["splitNumber"] = 3
        firsts.append(len(chart["series"]))
        chart["series"] += [
            {**series, "xAxisIndex": i, "yAxisIndex": i}
            for series in _pane_series(pane, ink, TALL * (1.0 if lone else high / 60))
        ]
    chart["textStyle"] = {"fontFamily": FONT}
    if not lone:
        chart["axisPointer"] = {"link": [{"xAxisIndex": "all"}]}
    chart["tooltip"] = {
        **dict(trigger="axis", confine=True, order="valueDesc"),
        "axisPointer": {"type": "cross" if lone else "line"},
        ":formatter": _cursor_text(panes, firsts),
    }
    return chart


def _pane_series(pane: Pane, ink: str, pixels: float) -> list[dict[str, Any]]:
    """Return the series of a pane: its curves with marks and spans, and its bands.

    Names at curve ends are kept apart, given a pane height of `pixels`.
    """
    series = [_curve_series(curve, ink) for curve in pane.lines]
    if series:
        middle = max(float(np.nanmax(c.x)) for c in pane.curves) / 2
        series[0] |= {
            "z": 4,
            "markPoint": {
                **dict(symbol="circle", symbolSize=9, animation=False),
                "data": [_point_mark(*mark, ink, mark[0] < middle) for mark in pane.marks],
            },
        }
        areas = [
            [dict(xAxis=start, itemStyle=dict(color=color, opacity=0.12)), {"xAxis": end}]
            for start, end, color in pane.spans
        ]
        series[0]["markArea"] = {"silent": True, "data": areas}
    _separate_end_labels(pane, series, pixels)
    return series + [band_series(*edges) for edges in pane.bands]


def _separate_end_labels(pane: Pane, series: Sequence[dict[str, Any]], pixels: float) -> None:
    lines = zip((curve.end[1] for curve in pane.lines), series, strict=True)
    ends = [(y, item["endLabel"]) for y, item in lines if item["endLabel"]["show"] and y == y]
    low, high = pane.y_range[0] or 0.0, pane.y_range[1] or max((y for y, _ in ends), default=1.0)
    upper_limit, scale = math.inf, pixels / (high - low or 1.0)
    for y, label in sorted(ends, key=lambda end: -end[0]):
        upper_limit = min(y * scale, upper_limit - LINE)
        label["offset"] = [0, y * scale - upper_limit]


def round_up(value: float) -> float:
    """Return a round number above a positive one, as the upper limit of an axis."""
    step = 10.0 ** math.floor(math.log10(value)) / 2
    return math.ceil(1.05 * value / step) * step


def text_colour(dark: bool) -> str:
    """Return the colour of text and lines on the page's background."""
    return "#dfe5ea" if dark else INK


def _label_width(curves: Sequence[Curve]) -> int:
    longest = max((len(f"{c.name}  {c.note}".strip()) for c in curves if c.labelled), default=0)
    return min(max(28, 14 + 7 * longest), MOST_ROOM)


def _point_mark(x: float, y: float, text: str, color: str, ink: str, left: bool) -> dict[str, Any]:
    """Return a dot with text above it; if `left`, the text starts at the dot, clear of the axis."""
    label = dict(show=True, position="top", distance=13, formatter=text, color=ink)
    label |= dict(align="left", offset=[-4, 0]) if left else {}
    return dict(coord=[x, y], itemStyle={"color": color}, label=label)


def _make_axis(name: str, limits: Ends, gap: int, dark: bool) -> dict[str, Any]:
    ink = text_colour(dark)
    ends = zip(("showMinLabel", "showMaxLabel"), limits, strict=True)
    return {
        **dict(type="value", name=name, nameLocation="middle", nameGap=gap),
        **dict(min=limits[0], max=limits[1]),
        "nameTextStyle": dict(color=ink, fontSize=13),
        # a limit that is not a round number is the end of a curve and needs no label
        "axisLabel": dict(color=ink, hideOverlap=True, **{end: _is_round(v) for end, v in ends}),
        "axisLine": {"show": True, "lineStyle": {"color": GREY}},
        "splitLine": {"lineStyle": {"color": "#3a444d" if dark else "#e3e8ec"}},
    }


def _is_round(value: float | None) -> bool | None:
    """Return whether an axis limit has few enough digits for a label; None if there is no limit."""
    return None if value is None else float(f"{value:.2g}") == value


def _cursor_text(panes: Sequence[Pane], firsts: Sequence[int]) -> str:
    """Return JavaScript for the cursor's text: named curves, and the unnamed ones in `firsts`."""
    axes = [_name_and_unit(pane.y) for pane in panes]
    name, unit = _name_and_unit(panes[-1].x)
    # only the name of a curve can contain HTML, because it may come from a file
    return (
        f"p => {{ const axes = {json.dumps(axes)}, firsts = {json.dumps(firsts)}, seen = new Set();"
        " const rows = p.flatMap(s => { const [y, unit] = axes[s.axisIndex], name = s.seriesName ||"
        " (firsts.includes(s.seriesIndex) ? y : ''), key = `${s.axisIndex} ${name}`;"
        " if (!name || s.value[1] == null || seen.has(key)) return []; seen.add(key);"
        " return `${s.marker}${name.replace(/[<>&]/g, '')}: <b>${(+s.value[1]).toPrecision(4)}"
        " ${unit}</b>`; });"
        f" return [`{name} ${{(+p[0].axisValue).toPrecision(4)}} {unit}`, ...rows].join('<br>'); }}"
    )


def _name_and_unit(axis: str) -> tuple[str, str]:
    name, _, unit = axis.partition(" [")
    return name, unit.rstrip("]").replace("-", "")


def band_series(low: Curve, high: Curve) -> dict[str, Any]:
    """Return the coloured area between two curves at the same x, as one closed line of zero width.

    ECharts stacks areas only on a category axis. For a line that returns to its start, the area is
    the part it encloses.
    """
    is_finite = np.isfinite(np.asarray(low.y, float)) & np.isfinite(np.asarray(high.y, float))
    edges = [
        thin_points(np.asarray(c.x)[is_finite], np.asarray(c.y)[is_finite]) for c in (high, low)
    ]
    return {
        **dict(type="line", name="", data=[*edges[0], *reversed(edges[1])]),
        **dict(showSymbol=False, silent=True, z=1, color=high.color),
        "emphasis": {"disabled": True},
        "lineStyle": {"width": 0},
        "areaStyle": {"opacity": BAND, "origin": "start"},
        "endLabel": {"show": False},
    }


def mark_points(pairs: Sequence[Sequence[float | None]], count: int = MARKS) -> list[Any]:
    """Return the pairs of `thin_points`, about `count` of them marked at equal distances.

    Distances are relative to the curve's extent on each axis.
    """
    finite = [(k, x, y) for k, (x, y) in enumerate(pairs) if x is not None and y is not None]
    if len(finite) < 2:
        return list(pairs)
    places = np.array([k for k, _, _ in finite])
    points = np.array([(x, y) for _, x, y in finite])
    steps = np.diff(points, axis=0) / np.maximum(np.ptp(points, axis=0), 1e-12)
    distance = np.concatenate(([0.0], np.cumsum(np.hypot(*steps.T))))
    picks = places[np.searchsorted(distance, np.linspace(0.0, distance[-1], count) - 1e-12)]
    result: list[Any] = list(pairs)
    for k in set(picks.tolist()):
        result[k] = {"value": pairs[k], "symbol": "circle"}
    return result


def _curve_series(curve: Curve, ink: str) -> dict[str, Any]:
    data = thin_points(curve.x, curve.y)
    # a line's own colour is too faint for text
    end: dict[str, Any] = dict(color=ink, distance=4, fontSize=12, formatter=_end_label(curve))
    end["show"] = bool(curve.name) and curve.labelled
    if _label_width([curve]) == MOST_ROOM:
        end |= dict(width=MOST_ROOM - 10, overflow="truncate")
    return {
        **dict(type="line", name=curve.name, color=ink if curve.color == INK else curve.color),
        **dict(data=mark_points(data) if curve.measured else data, silent=True, endLabel=end),
        **({"symbol": "none", "symbolSize": 5} if curve.measured else {}),
        **dict(showSymbol=curve.measured, lineStyle=dict(width=curve.width, type=curve.dash)),
        "emphasis": {"disabled": True},
        # names of curves with the same end are placed below each other
        "labelLayout": {"moveOverlap": "shiftY"},
    }


def _end_label(curve: Curve) -> str:
    """Return the label at a curve's end: its name, shortened if it is long, and its note."""
    if len(curve.name) <= LETTERS:
        return f"{{a}}, {curve.note}" if curve.note else "{a}"
    name = curve.name.replace("{", "(").replace("}", ")")  # braces are markup in ECharts
    return f"{name[: LETTERS - 11]}…{name[-10:]}"
