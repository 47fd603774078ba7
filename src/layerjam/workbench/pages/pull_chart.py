"""The chart of the page Pull: the force, measured pulls over it, what is left over below it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from layerjam.units import show
from layerjam.workbench.charts import Curve, aside, options, round_up, stacked, with_readout
from layerjam.workbench.charts import band as ground
from layerjam.workbench.pages.pull_band import Band
from layerjam.workbench.pages.pull_files import Reading

MM = 1e3
NONE: Mapping[str, Any] = MappingProxyType({})
LABELLED = 5
"""Files named at their curve's end; more are told apart by the cursor."""
LETTERS = 31
"""Of a name beside the chart at most."""
SHARED = 241
"""Points of the grid that overlaid curves share."""
SHARES, TALL = (3, 1), 290
"""Heights of the two charts, and pixels of the upper one, near enough to set names apart."""
FILE_COLORS = ("second", "good", "other", "sky", "bad")


def pulled(
    result: Any,
    whole: Any,
    reading: Reading,
    dark: bool,
    pins: Mapping[str, Any] = NONE,
    files: Collection[str] = (),
    bands: Mapping[str, Band] = NONE,
) -> dict[str, Any]:
    """Force over elongation; the axis stands still while vacuum, speed and model change.

    `pins` are other results by their labels, drawn quietly; `files` keys of those that are pinned,
    drawn as points; `bands` the 95 % of pins by their labels, and of the result itself by "".
    """
    curves = [_computed(result, "main", "computed", 2.5)]
    rest: list[Curve] = []
    kept = [one for one in reading.measured if one.file.key in files]
    drawn, colors = {one.trace.path for one in kept}, dict[str, str]()
    for place, one in enumerate(reading.curves):
        color = colors[one.path] = FILE_COLORS[place % len(FILE_COLORS)]
        said = f"{show(one.vacuum, 'Pa', 3)}, {reading.named(one.path)}"
        if one.path not in drawn:
            curves.append(Curve(one.pull.elongation * MM, one.pull.force, color, said, width=1.5))
        curves.append(Curve(one.elongation * MM, one.model, "ink", "", dashed=True, width=1.2))
        rest.append(Curve(one.elongation * MM, one.residual, color, f"{said}, left over"))
    for place, own in enumerate(kept, len(reading.curves)):
        color = colors.get(own.trace.path) or FILE_COLORS[place % len(FILE_COLORS)]
        x, y = own.features.elongation * MM, own.features.force
        curves.append(Curve(x, y, color, own.label, width=1.0, measured=True))
    curves += [_computed(other, "quiet", label, 1.2) for label, other in pins.items()]
    edged, also = len(curves), dict[int, str]()
    for label, band in bands.items():
        also[edged - len(pins) + list(pins).index(label) if label else 0] = band.name
        curves += _edges(pins[label] if label else result, band, label)
    end = max(float(c.x.max()) for c in curves)
    top = round_up(max(whole.max_force, *(float(c.y.max()) for c in curves[1:]), 0.0))
    if rest:
        grid = np.linspace(0.0, end, SHARED)
        curves, rest = _shared(curves, grid), _shared(rest, grid)
    force = result.peak_force
    common: dict[str, Any] = {"x": "elongation [mm]", "dark": dark}
    made = options(
        curves,
        y="force [N]",
        x_range=(0, end if rest else None),
        y_range=(0, top),
        marks=[(result.peak_elongation * MM, force, f"{force:.1f} N", "bad")],
        **common,
    )
    # above the handle that lies around the peak, and not over the numbers of the axis beside it
    label = made["series"][0]["markPoint"]["data"][0]["label"]
    label |= dict(distance=13, **aside(result.peak_elongation * MM, end))
    if rest or pins or kept or bands:
        _name_ends(made, curves[:edged], top, len(rest or kept) + len(pins), also)
    made["series"] += [ground(*curves[k : k + 2]) for k in range(edged, len(curves), 2)]
    if not rest:
        return with_readout(made, ("elongation", "mm"), "N")
    limit = round_up(max(*(float(np.nanmax(abs(c.y))) for c in rest), 1e-6))
    span: dict[str, Any] = {"x_range": (0.0, end), "y_range": (-limit, limit)}
    below = options(rest, y="left over [N]", **span, **common)
    below["grid"]["right"] = made["grid"]["right"]
    below["yAxis"]["splitNumber"] = 3
    for series in below["series"]:
        series["endLabel"]["show"] = False
    return with_readout(stacked([made, below], SHARES), ("elongation", "mm"), "N")


def _computed(result: Any, color: str, name: str, width: float) -> Curve:
    """The force of a computed pull."""
    record = result.record
    return Curve(record.elongation * MM, record.force, color, name, width=width)


def _edges(result: Any, band: Band, label: str) -> list[Curve]:
    """The lower and the upper edge of a computed pull's band."""
    x, color = band.elongation, "quiet" if label else "main"
    force = np.interp(x, result.record.elongation, result.record.force)
    name = f"{label or 'computed'}, {band.name}"
    ends = ((-band.half_width, f"{name}, lower"), (band.half_width, f"{name}, upper"))
    return [Curve(x * MM, force + half, color, said, width=0.8) for half, said in ends]


def _shared(curves: Sequence[Curve], grid: np.ndarray) -> list[Curve]:
    """The curves on one grid: the cursor reads only curves that have a point where it stands."""
    made = []
    for curve in curves:
        order = np.argsort(curve.x, kind="stable")
        x, y = np.asarray(curve.x)[order], np.asarray(curve.y)[order]
        inside = (grid >= x[0] - 1e-9) & (grid <= x[-1] + 1e-9)
        made.append(replace(curve, x=grid, y=np.where(inside, np.interp(grid, x, y), np.nan)))
    return made


def _name_ends(
    made: dict[str, Any],
    curves: Sequence[Curve],
    top: float,
    files: int,
    also: Mapping[int, str] = MappingProxyType({}),
) -> None:
    """Names at the ends of some curves, moved apart; what stands behind one's name is in `also`.

    Where they are too many, only those of the computed curve and of pinned files.
    """
    few = files <= LABELLED
    named = [k for k, c in enumerate(curves) if c.name and (few or k == 0 or c.measured)]
    made["grid"]["right"] = 200 if also or len(named) > 1 else 96
    pixels = TALL / top
    ends = {k: float(curves[k].y[np.isfinite(curves[k].y)][-1]) * pixels for k in named}
    above = math.inf
    for k in sorted(named, key=lambda k: -ends[k]):
        place = min(ends[k], above - 15.0)
        above = place
        offset = [0, ends[k] - place]
        end = dict(
            offset=offset,
            width=190,
            overflow="truncate",
            formatter=_said(curves[k].name, also.get(k, "")),
        )
        made["series"][k]["endLabel"] |= end
    for k, series in enumerate(made["series"]):
        series["endLabel"]["show"] = k in named


def _said(name: str, also: str) -> str:
    """What ECharts writes at a curve's end: its name, of a long one head and tail, and more."""
    if len(name) <= LETTERS:
        return f"{{a}}, {also}" if also else "{a}"
    plain = name.replace("{", "(").replace("}", ")")  # braces are ECharts' own
    return f"{plain[: LETTERS - 11]}…{plain[-10:]}"


def saw(result: Any, whole: Any, dark: bool, pins: Mapping[str, Any] = NONE) -> dict[str, Any]:
    """Force over time of a pull that sticks and slips; `pins` as in `pulled`."""
    record = result.record
    curves = [Curve(record.time, record.force, name="force")]
    for label, other in pins.items():
        pinned = other.record
        curves.append(Curve(pinned.time, pinned.force, "quiet", label, width=1.2))
    top = round_up(max(whole.holding_force, *(float(c.y.max()) for c in curves)))
    axes: dict[str, Any] = {"x": "time [s]", "y": "force [N]", "x_range": (0, None)}
    made = options(curves, y_range=(0, top), dark=dark, **axes)
    if pins:
        _name_ends(made, curves, top, len(pins))
    return with_readout(made, ("time", "s"), "N")
