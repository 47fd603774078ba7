"""Whether a drawn figure can be read: its axes have units, no word hides another or leaves."""

from __future__ import annotations

import re
from itertools import combinations
from typing import Any


def words_of(figure: Any) -> list[Any]:
    """Every text that is drawn."""
    from matplotlib.text import Text

    ticks, drawn = set(), set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            every = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
            ticks |= {label for tick in every for label in (tick.label1, tick.label2)}
            if axes.get_visible() and axis.get_visible() and axes.axison:
                seen = axis._update_ticks()
                drawn |= {label for tick in seen for label in (tick.label1, tick.label2)}
    hidden = {t for axes in figure.axes if not axes.get_visible() for t in axes.findobj(Text)}
    return [
        t
        for t in set(figure.findobj(Text)) - hidden
        if t.get_visible() and t.get_text().strip() and (t not in ticks or t in drawn)
    ]


def faults(figure: Any) -> list[str]:
    """What is wrong with a figure, in words."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()
    out, boxes = [], []
    for text in words_of(figure):
        box = Text.get_window_extent(text, renderer)
        whole = figure.bbox
        if box.x0 < -1 or box.y0 < -1 or box.x1 > whole.x1 + 1 or box.y1 > whole.y1 + 1:
            out.append(f"leaves the canvas: {text.get_text()!r}")
        boxes.append((text.get_text(), box.padded(-1.0, -0.12 * box.height)))
    for (one, first), (other, second) in combinations(boxes, 2):
        if first.overlaps(second):
            out.append(f"overlap: {one!r} and {other!r}")
    for axes in (a for a in figure.axes if a.get_visible()):
        if axes.axison and axes.name == "rectilinear" and axes.spines["top"].get_visible():
            out.append(f"not in our style: {axes.get_title(loc='left')!r}")
        for axis in (axes.xaxis, axes.yaxis):
            ticks = [label for tick in axis._update_ticks() for label in (tick.label1, tick.label2)]
            said = [label.get_text() for label in ticks if label.get_visible()]
            words = [re.search(r"[a-z]{2}", s.replace("mathdefault", "")) for s in said]
            if not axis.get_visible() or not said or any(words):
                continue
            label = axis.label.get_text()
            if not re.search(r"\[[^\]]+\]|^number of |^(pull|sheet) number\b", label):
                out.append(f"no unit: {label!r} of {axes.get_title(loc='left')!r}")
    return out
