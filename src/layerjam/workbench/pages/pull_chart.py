"""Charts of the Pull page: computed force with measured pulls, and residuals below."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.core.drawing.chart import Curve, Pane, add_comparisons, dash_untested
from layerjam.core.drawing.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, RED, SKY
from layerjam.core.units import show
from layerjam.workbench.charts import chart_options, round_up
from layerjam.workbench.pages.pull_band import NAME
from layerjam.workbench.pages.pull_files import Reading

if TYPE_CHECKING:
    from layerjam.brake.simulate.pull_spread import PullBand

MM = 1e3
NONE: Mapping[str, Any] = MappingProxyType({})
LABELLED = 5
"""Maximum number of curves named at their ends; if there are more, only the cursor names them."""
SHARED = 241
"""Number of points of the grid that overlaid curves share."""
FILE_COLORS = (ORANGE, GREEN, PURPLE, SKY, RED)


def pull_chart(
    result: Any,
    brake_facts: Any,
    reading: Reading,
    dark: bool,
    pins: Mapping[str, Any] = NONE,
    files: Collection[str] = (),
    bands: Mapping[str, "PullBand"] = NONE,
) -> dict[str, Any]:
    """Return the chart of force versus elongation; vacuum, speed and model do not move its axes.

    `pins` is {label: other result}; these are drawn faintly. `files` are measured pulls, drawn as
    points if their keys are pinned. `bands` is {label: 95 % band} of pins; the label of the result
    itself is "".
    """
    pinned_pulls = [item for item in reading.measured_pulls if item.file.key in files]
    few = len(reading.curves or pinned_pulls) + len(pins) <= LABELLED
    notes = dict.fromkeys(bands, NAME)
    main = replace(_computed_curve(result, "computed", notes), color=BLUE, width=2.5)
    curves = [main]
    if (band := bands.get("")) is not None:
        curves = dash_untested(main, band.tested_end * MM)
    residuals: list[Curve] = []
    drawn_paths, colors = {item.trace.path for item in pinned_pulls}, dict[str, str]()
    for place, item in enumerate(reading.curves):
        color = colors[item.path] = FILE_COLORS[place % len(FILE_COLORS)]
        label_text = f"{show(item.vacuum, 'Pa', 3)}, {reading.shown_name(item.path)}"
        if item.path not in drawn_paths:
            x, y = item.pull.elongation * MM, item.pull.force
            curves.append(Curve(x, y, color, label_text, width=1.5, labelled=few))
        curves.append(Curve(item.elongation * MM, item.model, INK, dash="dashed", width=1.2))
        left = f"{label_text}, residual"
        residuals.append(Curve(item.elongation * MM, item.residual, color, left, labelled=False))
    for place, pull in enumerate(pinned_pulls, len(reading.curves)):
        color = colors.get(pull.trace.path) or FILE_COLORS[place % len(FILE_COLORS)]
        x, y = pull.features.elongation * MM, pull.features.force
        curves.append(Curve(x, y, color, pull.label, width=1.0, measured=True))
    curves += [
        replace(_computed_curve(pin_result, label, notes), labelled=few)
        for label, pin_result in pins.items()
    ]
    first_edge = len(curves)
    for label, band in bands.items():
        curves += _band_edges(band, label)
    end = max(float(c.x.max()) for c in curves)
    top = round_up(max(brake_facts.max_force, *(float(c.y.max()) for c in curves[1:]), 0.0))
    if residuals:
        grid = np.linspace(0.0, end, SHARED)
        curves, residuals = _resample_curves(curves, grid), _resample_curves(residuals, grid)
    pull, ends = result.panes()[0], (0.0, end if residuals else None)
    edges = list(zip(curves[first_edge::2], curves[first_edge + 1 :: 2], strict=True))
    panes = [replace(pull, curves=curves, bands=edges, x_range=ends, y_range=(0, top), share=3.0)]
    if residuals:
        limit = round_up(max(*(float(np.nanmax(abs(c.y))) for c in residuals), 1e-6))
        panes.append(Pane(residuals, pull.x, "residual [N]", ends, (-limit, limit)))
    return chart_options(panes, dark)


def _computed_curve(result: Any, label: str, notes: Mapping[str, str]) -> Curve:
    """Return the curve of a computed pull; the note of the displayed pull has the key ""."""
    note = notes.get("" if label == "computed" else label, "")
    x, y = result.record.elongation * MM, result.record.force
    return Curve(x, y, GREY, label, width=1.2, note=note)


def _band_edges(band: "PullBand", label: str) -> list[Curve]:
    color, name = GREY if label else BLUE, f"{label or 'computed'}, {NAME}"
    return [
        Curve(band.elongation * MM, y, color, f"{name}, {side}", width=0.8, labelled=False)
        for y, side in ((band.low, "lower"), (band.high, "upper"))
    ]


def _resample_curves(curves: Sequence[Curve], grid: np.ndarray) -> list[Curve]:
    """Return the curves on one grid, because the cursor reads only points at its own position."""
    result = []
    for curve in curves:
        order = np.argsort(curve.x, kind="stable")
        x, y = np.asarray(curve.x)[order], np.asarray(curve.y)[order]
        inside = (grid >= x[0] - 1e-9) & (grid <= x[-1] + 1e-9)
        result.append(replace(curve, x=grid, y=np.where(inside, np.interp(grid, x, y), np.nan)))
    return result


def stick_slip_chart(
    result: Any, brake_facts: Any, dark: bool, pins: Mapping[str, Any] = NONE
) -> dict[str, Any]:
    """Return the chart of a stick–slip pull, with the curves of `pins`."""
    quiet = {label: pin_result.overlay_curves() for label, pin_result in pins.items()}
    (pane,) = add_comparisons(result.panes(), quiet)
    top = round_up(max(brake_facts.holding_force, pane.y_range[1]))
    return chart_options([replace(pane, y_range=(0, top))], dark)
