"""Designs: the front, the chosen one and the runner-up."""

from __future__ import annotations

from typing import Any

import numpy as np

from layerjam.report import style
from layerjam.report.style import BLUE, FAINT, GREEN, GREY, ORANGE, RED
from layerjam.units import show, unit_factor

save = style.save
MARKS = (
    ("chosen", "chosen", BLUE, "o", 9),
    ("runner_up", "runner-up", ORANGE, "s", 7),
    ("refined", "between the steps", GREEN, "D", 6),
)


@style.styled
def front(answer: Any) -> style.Figure:
    """The designs that no other one beats in both objectives, with the chosen one.

    `answer` is what `design` or `sweep` gave.

    With three objectives or more the front is seen from the first two; with one, over mass.
    """
    spec = answer.record.spec
    names = [o.name for o in spec.objectives][:2]
    if len(names) == 1:
        names.insert(0, "mass" if names[0] != "mass" else "holding_force")
    figure, (axes,) = style.canvas(width=7.4, height=4.8)
    _draw(axes, answer, names)
    detail = f"{answer.feasible_designs:,} of {answer.designs:,} designs meet the constraints"
    if len(answer.front) < answer.front_size:
        detail += f"; {len(answer.front)} of {answer.front_size} on the front are drawn"
    goals = " and ".join(str(o) for o in spec.objectives)
    style.title(axes, f"{answer.name}: {goals}", detail)
    return figure


def _draw(axes: style.Axes, answer: Any, names: list[str]) -> None:
    scales = [scale(answer, n) for n in names]

    def at(design: Any) -> tuple[float, ...]:
        return tuple(design[n] * f for n, (f, _) in zip(names, scales, strict=True))

    x, y = np.array(sorted(at(d) for d in answer.front)).T
    if len(answer.record.spec.objectives) == 2:
        axes.plot(x, y, color=FAINT, lw=1.2, zorder=1)
    axes.plot(x, y, "o", color=GREY, ms=3.2, mec="none", zorder=2)
    points = []
    for key, word, color, mark, size in MARKS:
        if (design := answer.values[key]) is not None:
            axes.plot(*at(design), mark, color=color, ms=size, mec="white", mew=0.8, zorder=4)
            points.append((at(design), word, color))
    for blocked in sorted(answer.forbidden, key=lambda f: f["short"])[:1]:
        axes.plot(*at(blocked["design"]), "x", color=RED, ms=7, mew=1.6, zorder=4)
        points.append((at(blocked["design"]), f"but for {blocked['constraint']}", RED))
    words = [f"{n.replace('_', ' ')} [{unit}]" for n, (_, unit) in zip(names, scales, strict=True)]
    axes.set(xlabel=words[0], ylabel=words[1])
    axes.margins(0.12)
    least = {o.name: o.least for o in answer.record.spec.objectives}
    aside = 1.0 if least.get(names[0], True) else -1.0
    _labels(axes, points, aside, 1.0 if least.get(names[1], False) else -1.0)


def _labels(
    axes: style.Axes, points: list[tuple[Any, str, str]], aside: float, down: float
) -> None:
    """A word beside each mark, on the side of the designs that lose, where nothing is drawn."""
    low, high = axes.get_xlim()
    bottom, top = axes.get_ylim()
    taken: list[tuple[float, float]] = []
    for (x, y), word, color in sorted(points, key=lambda p: down * p[0][1]):
        across, up = (x - low) / (high - low), (y - bottom) / (top - bottom)
        at, height = across + 0.05 * aside, up + 0.05 * down
        while any(abs(height - h) < 0.058 and abs(at - p) < 0.4 for p, h in taken):
            height += 0.015 * down
        taken.append((at, height))
        side = {"ha": "left" if aside > 0 else "right", "textcoords": "axes fraction"}
        foot = {"relpos": (0.0 if aside > 0 else 1.0, 0.5)}
        style.pointed(axes, word, (x, y), (at, height), color, line=foot, **side)


def scale(answer: Any, name: str) -> tuple[float, str]:
    """Factor from SI, and the unit, in which the middle of the front reads well."""
    unit = answer.units[name]
    if unit == "1":
        return 1.0, "1"
    middle = float(np.median([d[name] for d in answer.front]))
    text = show(middle, unit).split(" ", 1)[1]
    factor = unit_factor(text, unit)
    return (1 / float(factor), text) if factor else (1.0, unit)
