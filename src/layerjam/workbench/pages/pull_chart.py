"""The chart of the page Pull: the force, measured pulls over it, what is left over below it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from layerjam.report.chart import Curve, Pane, beside
from layerjam.report.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, RED, SKY
from layerjam.units import show
from layerjam.workbench.charts import options, round_up
from layerjam.workbench.pages.pull_band import Band
from layerjam.workbench.pages.pull_files import Reading

MM = 1e3
NONE: Mapping[str, Any] = MappingProxyType({})
LABELLED = 5
"""Files named at their curve's end; more are told apart by the cursor."""
SHARED = 241
"""Points of the grid that overlaid curves share."""
FILE_COLORS = (ORANGE, GREEN, PURPLE, SKY, RED)


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
    kept = [one for one in reading.measured if one.file.key in files]
    few = len(reading.curves or kept) + len(pins) <= LABELLED
    notes = {label: one.name for label, one in bands.items()}
    curves = [replace(_computed(result, "computed", notes), color=BLUE, width=2.5)]
    rest: list[Curve] = []
    drawn, colors = {one.trace.path for one in kept}, dict[str, str]()
    for place, one in enumerate(reading.curves):
        color = colors[one.path] = FILE_COLORS[place % len(FILE_COLORS)]
        said = f"{show(one.vacuum, 'Pa', 3)}, {reading.named(one.path)}"
        if one.path not in drawn:
            x, y = one.pull.elongation * MM, one.pull.force
            curves.append(Curve(x, y, color, said, width=1.5, labelled=few))
        curves.append(Curve(one.elongation * MM, one.model, INK, dash="dashed", width=1.2))
        left = f"{said}, left over"
        rest.append(Curve(one.elongation * MM, one.residual, color, left, labelled=False))
    for place, own in enumerate(kept, len(reading.curves)):
        color = colors.get(own.trace.path) or FILE_COLORS[place % len(FILE_COLORS)]
        x, y = own.features.elongation * MM, own.features.force
        curves.append(Curve(x, y, color, own.label, width=1.0, measured=True))
    curves += [
        replace(_computed(other, label, notes), labelled=few) for label, other in pins.items()
    ]
    edged = len(curves)
    for label, band in bands.items():
        curves += _edges(pins[label] if label else result, band, label)
    end = max(float(c.x.max()) for c in curves)
    top = round_up(max(whole.max_force, *(float(c.y.max()) for c in curves[1:]), 0.0))
    if rest:
        grid = np.linspace(0.0, end, SHARED)
        curves, rest = _shared(curves, grid), _shared(rest, grid)
    own, ends = result.panes()[0], (0.0, end if rest else None)
    edges = list(zip(curves[edged::2], curves[edged + 1 :: 2], strict=True))
    panes = [replace(own, curves=curves, bands=edges, x_range=ends, y_range=(0, top), share=3.0)]
    if rest:
        limit = round_up(max(*(float(np.nanmax(abs(c.y))) for c in rest), 1e-6))
        panes.append(Pane(rest, own.x, "left over [N]", ends, (-limit, limit)))
    return options(panes, dark)


def _computed(result: Any, label: str, notes: Mapping[str, str]) -> Curve:
    """The force of a computed pull; the shown one has its note under ""."""
    note = notes.get("" if label == "computed" else label, "")
    return replace(result.panes()[0].curves[0], color=GREY, name=label, width=1.2, note=note)


def _edges(result: Any, band: Band, label: str) -> list[Curve]:
    """The lower and the upper edge of a computed pull's band."""
    x, color = band.elongation, GREY if label else BLUE
    force = np.interp(x, result.record.elongation, result.record.force)
    name = f"{label or 'computed'}, {band.name}"
    ends = ((-band.half_width, f"{name}, lower"), (band.half_width, f"{name}, upper"))
    return [
        Curve(x * MM, force + half, color, said, width=0.8, labelled=False) for half, said in ends
    ]


def _shared(curves: Sequence[Curve], grid: np.ndarray) -> list[Curve]:
    """The curves on one grid: the cursor reads only curves that have a point where it stands."""
    made = []
    for curve in curves:
        order = np.argsort(curve.x, kind="stable")
        x, y = np.asarray(curve.x)[order], np.asarray(curve.y)[order]
        inside = (grid >= x[0] - 1e-9) & (grid <= x[-1] + 1e-9)
        made.append(replace(curve, x=grid, y=np.where(inside, np.interp(grid, x, y), np.nan)))
    return made


def saw(result: Any, whole: Any, dark: bool, pins: Mapping[str, Any] = NONE) -> dict[str, Any]:
    """Force over elongation of a pull that sticks and slips; `pins` as in `pulled`."""
    quiet = {label: other.quiet_curves() for label, other in pins.items()}
    (pane,) = beside(result.panes(), quiet)
    top = round_up(max(whole.holding_force, pane.y_range[1]))
    return options([replace(pane, y_range=(0, top))], dark)
