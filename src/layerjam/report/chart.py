"""A figure described once: panes with curves, marks and grounds.

Results give `panes`. `draw` makes a figure of them, and the page draws the same in the browser.
Panes that share their x axis are below each other, others side by side.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from layerjam.report import style
from layerjam.report.style import BLUE, GREY

POINTS_PER_PIXEL = 0.9
"""Width of a line in a figure [pt] per pixel of it on the page."""
Mark = tuple[float, float, str, str]
"""x, y, words and colour of a point."""
Ends = tuple[float | None, float | None]


@dataclass(frozen=True)
class Curve:
    """A line of a pane; `x` and `y` shape (N,) in its units; `name` appears at its end."""

    x: Any
    y: Any
    color: str = BLUE
    name: str = ""
    dash: str = "solid"
    """ "solid", "dashed" or "dotted"."""
    width: float = 2.0
    """Pixels on the page."""
    note: str = ""
    """Words behind the name at its end."""
    labelled: bool = True
    """Whether the name appears at its end too, not only under the cursor."""
    measured: bool = False
    """A line with a point here and there."""

    @property
    def end(self) -> tuple[float, float]:
        """The last point, NaN if none is known."""
        known = np.flatnonzero(np.isfinite(np.asarray(self.y, float)))
        return (self.x[known[-1]], self.y[known[-1]]) if len(known) else (np.nan, np.nan)


@dataclass(frozen=True)
class Pane:
    """Curves over one pair of axes, whose names end with their units; the first is the main one."""

    curves: Sequence[Curve]
    x: str
    y: str
    x_range: Ends = (0, None)
    y_range: Ends = (0, None)
    marks: Sequence[Mark] = ()
    levels: Sequence[tuple[float, str, str]] = ()
    """Lines across: y, name and colour."""
    spans: Sequence[tuple[float, float, str]] = ()
    """Stretches of the x axis on coloured ground: from, to, colour."""
    bands: Sequence[tuple[Curve, Curve]] = ()
    """Lower and upper edge of coloured ground between two curves on the same x."""
    headline: str = ""
    detail: str = ""
    share: float = 1.0
    """Part of the height, beside panes above or below."""

    @property
    def lines(self) -> list[Curve]:
        """The curves, and the levels as curves over the whole width."""
        ends = self.x_range[0], self.x_range[1]
        if self.levels and ends[1] is None:
            ends = ends[0], max(float(np.nanmax(curve.x)) for curve in self.curves)
        across = [Curve(ends, (y, y), color, name, "dashed", 1.2) for y, name, color in self.levels]
        return [*self.curves, *across]


def stacked(panes: Sequence[Pane]) -> bool:
    """Whether panes are below each other."""
    return len(panes) > 1 and len({pane.x for pane in panes}) == 1


def beside(panes: Sequence[Pane], others: Mapping[str, Sequence[Curve]]) -> list[Pane]:
    """The panes with curves of others by their labels, one in each, quiet and named once."""
    made = []
    for place, pane in enumerate(panes):
        quiet = [
            replace(curves[place], color=GREY, name=label, width=1.2, labelled=not place)
            for label, curves in others.items()
            if place < len(curves)
        ]
        ends = []
        for (low, high), values, room in ((pane.x_range, "x", 1.0), (pane.y_range, "y", 1.1)):
            most = [room * float(np.nanmax(getattr(one, values))) for one in quiet]
            ends.append((low, None if high is None else max(high, *most, high)))
        curves = [*pane.curves, *quiet]
        made.append(replace(pane, curves=curves, x_range=ends[0], y_range=ends[1]))
    return made


@style.styled
def draw(panes: Sequence[Pane]) -> style.Figure:
    """The figure of panes."""
    count = len(panes)
    if stacked(panes):
        shares = [pane.share for pane in panes]
        figure, places = style.canvas(1, count, 7.4, 5.0, sharex=True, height_ratios=shares)
    else:
        width, height = (6.4, 3.9) if count == 1 else (0.6 + 3.6 * count, 3.5)
        figure, places = style.canvas(count, 1, width, height)
    for axes, pane in zip(places, panes, strict=True):
        fill(axes, pane, below=stacked(panes) and pane is not panes[-1])
    return figure


def fill(axes: style.Axes, pane: Pane, below: bool = False) -> None:
    """Draw a pane; the x axis has no name where another pane is `below`."""
    axes.set(ylabel=pane.y, **({} if below else {"xlabel": pane.x}))
    for start, end, color in pane.spans:
        axes.axvspan(start, end, color=color, alpha=0.12, lw=0)
    for low, high in pane.bands:
        style.band(axes, high.x, low.y, high.y, high.color)
    for place, one in enumerate(pane.lines):
        dash: Any = {"dashed": style.DASHED, "dotted": style.DOTTED}.get(one.dash, "-")
        width, above = POINTS_PER_PIXEL * one.width, 2.0 + (not place)
        dots: dict[str, Any] = dict(marker="o", ms=2.6, markevery=0.02) if one.measured else {}
        axes.plot(one.x, one.y, color=one.color, ls=dash, lw=width, zorder=above, **dots)
    axes.set(xlim=pane.x_range, ylim=pane.y_range)
    for x, y, words, color in pane.marks:
        style.spot(axes, x, y, words, color)
    ends: dict[float, list[tuple[float, str, str]]] = {}
    for one in pane.lines:
        if one.name and one.labelled:
            ends.setdefault(one.end[0], []).append((one.end[1], one.name, one.color))
    for x, names in ends.items():
        style.labels_right(axes, x, names)
    style.panel(axes, pane.headline, pane.detail)
