"""Declarative description of a figure: panes with curves, marks and shaded areas.

Results have `panes`. `draw_panes` turns them into a figure, and the page draws the same figure.
Panes that share their x axis are stacked; others are side by side.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREY

POINTS_PER_PIXEL = 0.9
"""Line width in a figure [pt] per pixel on the page."""
Mark = tuple[float, float, str, str]
"""(x, y, label, colour) of a point."""
Ends = tuple[float | None, float | None]


@dataclass(frozen=True)
class Curve:
    """A curve of a pane; `x` and `y`, shape (N,), are in the units of its axes."""

    x: Any
    y: Any
    color: str = BLUE
    name: str = ""
    dash: str = "solid"
    """ "solid", "dashed" or "dotted"."""
    width: float = 2.0
    """Line width on the page [pixels]."""
    note: str = ""
    """Text after the name at the curve's end."""
    labelled: bool = True
    """Whether the name appears at the curve's end as well as at the cursor."""
    measured: bool = False
    """Whether the curve is measured; a measured curve is drawn as a line with some points."""

    @property
    def end(self) -> tuple[float, float]:
        """Return the last point with a finite y; NaN if there is none."""
        finite = np.flatnonzero(np.isfinite(np.asarray(self.y, float)))
        return (self.x[finite[-1]], self.y[finite[-1]]) if len(finite) else (np.nan, np.nan)


@dataclass(frozen=True)
class Pane:
    """Curves on one pair of axes, whose names include units; the first curve is the main one."""

    curves: Sequence[Curve]
    x: str
    y: str
    x_range: Ends = (0, None)
    y_range: Ends = (0, None)
    marks: Sequence[Mark] = ()
    levels: Sequence[tuple[float, str, str]] = ()
    """(y, name, colour) of each horizontal line."""
    spans: Sequence[tuple[float, float, str]] = ()
    """(start, end, colour) of each coloured interval of the x axis."""
    bands: Sequence[tuple[Curve, Curve]] = ()
    """Lower and upper edge of each coloured band, at the same x values."""
    headline: str = ""
    detail: str = ""
    share: float = 1.0
    """Fraction of the total height if panes are stacked."""

    @property
    def lines(self) -> list[Curve]:
        """Return the curves, followed by the levels as curves over the whole width."""
        ends = self.x_range[0], self.x_range[1]
        if self.levels and ends[1] is None:
            ends = ends[0], max(float(np.nanmax(curve.x)) for curve in self.curves)
        levels = [Curve(ends, (y, y), color, name, "dashed", 1.2) for y, name, color in self.levels]
        return [*self.curves, *levels]


def is_stacked(panes: Sequence[Pane]) -> bool:
    """Return whether panes are stacked."""
    return len(panes) > 1 and len({pane.x for pane in panes}) == 1


def add_comparisons(panes: Sequence[Pane], others: Mapping[str, Sequence[Curve]]) -> list[Pane]:
    """Return the panes with faint curves of other results, labelled only in the first pane."""
    result = []
    for place, pane in enumerate(panes):
        quiet = [
            replace(curves[place], color=GREY, name=label, width=1.2, labelled=not place)
            for label, curves in others.items()
            if place < len(curves)
        ]
        ends = []
        for (low, high), values, room in ((pane.x_range, "x", 1.0), (pane.y_range, "y", 1.1)):
            tops = [room * float(np.nanmax(getattr(curve, values))) for curve in quiet]
            ends.append((low, None if high is None else max(high, *tops, high)))
        curves = [*pane.curves, *quiet]
        result.append(replace(pane, curves=curves, x_range=ends[0], y_range=ends[1]))
    return result


@style.use_style
def draw_panes(panes: Sequence[Pane]) -> style.Figure:
    """Draw the panes as a figure."""
    count = len(panes)
    if is_stacked(panes):
        shares = [pane.share for pane in panes]
        figure, places = style.make_axes(1, count, 7.4, 5.0, sharex=True, height_ratios=shares)
    else:
        width, height = (6.4, 3.9) if count == 1 else (0.6 + 3.2 * count, 3.5)
        figure, places = style.make_axes(count, 1, width, height)
    for axes, pane in zip(places, panes, strict=True):
        draw_pane(axes, pane, below=is_stacked(panes) and pane is not panes[-1])
    return figure


def dash_untested(curve: Curve, tested_end: float) -> list[Curve]:
    """Return a curve, dashed where x is beyond the tested part; two curves if only a part is."""
    x, y = np.asarray(curve.x), np.asarray(curve.y)
    count = int(np.searchsorted(x, tested_end, side="right"))
    if count == len(x):
        return [curve]
    if count < 2:
        return [replace(curve, dash="dashed")]
    outer = replace(curve, x=x[count - 1 :], y=y[count - 1 :], dash="dashed")
    return [replace(curve, x=x[:count], y=y[:count], labelled=False), outer]


def draw_pane(axes: style.Axes, pane: Pane, below: bool = False) -> None:
    """Draw a pane; its x axis is unnamed if another pane is `below` it."""
    axes.set(ylabel=pane.y, **({} if below else {"xlabel": pane.x}))
    for start, end, color in pane.spans:
        axes.axvspan(start, end, color=color, alpha=0.12, lw=0)
    for low, high in pane.bands:
        style.add_band(axes, high.x, low.y, high.y, high.color)
    for place, curve in enumerate(pane.lines):
        dash: Any = {"dashed": style.DASHED, "dotted": style.DOTTED}.get(curve.dash, "-")
        width, above = POINTS_PER_PIXEL * curve.width, 2.0 + (not place)
        dots: dict[str, Any] = dict(marker="o", ms=2.6, markevery=0.02) if curve.measured else {}
        axes.plot(curve.x, curve.y, color=curve.color, ls=dash, lw=width, zorder=above, **dots)
    axes.set(xlim=pane.x_range, ylim=pane.y_range)
    for x, y, words, color in pane.marks:
        style.add_point(axes, x, y, words, color)
    ends: dict[float, list[tuple[float, str, str]]] = {}
    for curve in pane.lines:
        if curve.name and curve.labelled:
            ends.setdefault(curve.end[0], []).append((curve.end[1], curve.name, curve.color))
    for x, names in ends.items():
        style.add_end_labels(axes, x, names)
    style.label_axes(axes, pane.headline, pane.detail)
