"""Designs: the front, the chosen one and the runner-up."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.report.style import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    ORANGE,
    RED,
    canvas,
    look,
    save,
    title,
)
from layerjam.units import show, unit_factor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


__all__ = ["front", "save"]
MARKS = (
    ("chosen", "chosen", BLUE, "o", 9),
    ("runner_up", "runner-up", ORANGE, "s", 7),
    ("refined", "between the steps", GREEN, "D", 6),
)


def front(answer: Any) -> Figure:
    """The designs that no other one beats in both objectives, with the chosen one.

    `answer` is what `design` or `sweep` gave.

    With three objectives or more the front is seen from the first two; with one, over mass.
    """
    spec = answer.record.spec
    names = [o.name for o in spec.objectives][:2]
    if len(names) == 1:
        names.insert(0, "mass" if names[0] != "mass" else "holding_force")
    with look():
        figure, (axes,) = canvas(width=7.4, height=4.8)
        _draw(axes, answer, names)
        goals = " and ".join(str(o) for o in spec.objectives)
        detail = f"{answer.feasible_designs:,} of {answer.designs:,} designs meet the constraints"
        if len(answer.front) < answer.front_size:
            detail += f"; {len(answer.front)} of {answer.front_size} on the front are drawn"
        title(axes, f"{answer.name}: {goals}", detail)
    return figure


def _draw(axes: Axes, answer: Any, names: list[str]) -> None:
    scales = [scale(answer, n) for n in names]
    columns = [
        np.array([d[n] * factor for d in answer.front])
        for n, (factor, _) in zip(names, scales, strict=True)
    ]
    order = np.argsort(columns[0])
    x, y = (column[order] for column in columns)
    if len(answer.record.spec.objectives) == 2:
        axes.plot(x, y, color=FAINT, lw=1.2, zorder=1)
    axes.plot(x, y, "o", color=GREY, ms=3.2, mec="none", zorder=2)
    points = []
    for key, word, color, mark, size in MARKS:
        design = answer.values[key]
        if design is not None:
            at = tuple(design[n] * f for n, (f, _) in zip(names, scales, strict=True))
            axes.plot(*at, mark, color=color, ms=size, mec="white", mew=0.8, zorder=4)
            points.append((at, word, color))
    for blocked in sorted(answer.forbidden, key=lambda f: f["short"])[:1]:
        design = blocked["design"]
        at = tuple(design[n] * f for n, (f, _) in zip(names, scales, strict=True))
        axes.plot(*at, "x", color=RED, ms=7, mew=1.6, zorder=4)
        points.append((at, f"but for {blocked['constraint']}", RED))
    axes.set(xlabel=f"{names[0].replace('_', ' ')} [{scales[0][1]}]",
             ylabel=f"{names[1].replace('_', ' ')} [{scales[1][1]}]")  # fmt: skip
    axes.margins(0.12)
    goals = {o.name: o.least for o in answer.record.spec.objectives}
    _labels(axes, points, 1.0 if goals.get(names[0], True) else -1.0,
            1.0 if goals.get(names[1], False) else -1.0)  # fmt: skip


def _labels(axes: Axes, points: list[tuple[Any, str, str]], aside: float, down: float) -> None:
    """A word beside each mark, on the side of the designs that lose, where nothing is drawn."""
    low, high = axes.get_xlim()
    bottom, top = axes.get_ylim()
    taken: list[tuple[float, float]] = []
    for (x, y), word, color in sorted(points, key=lambda p: down * p[0][1]):
        place, depth = (x - low) / (high - low), (y - bottom) / (top - bottom)
        at, height = place + 0.05 * aside, depth + 0.05 * down
        while any(abs(height - h) < 0.058 and abs(at - p) < 0.4 for p, h in taken):
            height += 0.015 * down
        taken.append((at, height))
        axes.annotate(
            word, (x, y), xytext=(at, height), textcoords="axes fraction", color=color,
            ha="left" if aside > 0 else "right", va="center", fontsize=8.8, zorder=5,
            arrowprops={"arrowstyle": "-", "color": color, "lw": 0.6, "shrinkA": 1, "shrinkB": 4,
                        "relpos": (0.0 if aside > 0 else 1.0, 0.5)},
            bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.8},
        )  # fmt: skip


def scale(answer: Any, name: str) -> tuple[float, str]:
    """Factor from SI, and the unit, in which the middle of the front reads well."""
    unit = answer.units[name]
    if unit == "1":
        return 1.0, "1"
    middle = float(np.median([d[name] for d in answer.front]))
    text = show(middle, unit).split(" ", 1)[1]
    factor = unit_factor(text, unit)
    return (1 / float(factor), text) if factor else (1.0, unit)
