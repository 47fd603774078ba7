"""Figures of designs: the front, the chosen design and the runner-up."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from layerjam.core.conversion import unit_factor
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, FAINT, GREEN, GREY, ORANGE, RED
from layerjam.core.units import show

save = style.save


class Look(NamedTuple):
    """Mark of a design in a figure, and its symbol on the page."""

    color: str
    mark: str
    size: float
    symbol: str
    symbol_size: float


LOOKS = {
    "chosen": Look(BLUE, "o", 9, "circle", 17),
    "runner-up": Look(ORANGE, "s", 7, "rect", 13),
    "between grid steps": Look(GREEN, "D", 6, "diamond", 15),
}
FORBIDDEN = Look(RED, "X", 7, "triangle", 13)


def find_front_axes(answer: Any) -> tuple[str, str]:
    """Return the axes of the front: the first two objectives, or one and either mass or force."""
    names = [o.name for o in answer.record.spec.objectives][:2]
    if len(names) == 1:
        names.insert(0, "mass" if names[0] != "mass" else "holding_force")
    return names[0], names[1]


def marked_designs(
    answer: Any, names: tuple[str, str]
) -> list[tuple[Mapping[str, Any], str, Look]]:
    """Return (design, description, style) for each labelled design."""
    designs = zip((answer.chosen, answer.runner_up, answer.refined), LOOKS.items(), strict=True)
    marks = [(design, word, look) for design, (word, look) in designs if design is not None]
    for forbidden in sorted(answer.forbidden, key=lambda f: f["short"])[:1]:
        if all(math.isfinite(forbidden["design"][n]) for n in names):
            marks.append((forbidden["design"], f"without {forbidden['constraint']}", FORBIDDEN))
    return marks


def worse_direction(answer: Any, name: str) -> float:
    """Return 1 if larger values are worse, otherwise -1; the front is empty on that side."""
    goals = {o.name: o.least for o in answer.record.spec.objectives}
    return 1.0 if goals.get(name, True) else -1.0


@style.use_style
def draw_front(answer: Any) -> style.Figure:
    """Draw the designs that no other design beats in both objectives, with the chosen one.

    `answer` is the result of `design` or `sweep`.

    With three or more objectives, the front is projected onto the first two; with one objective, it
    is drawn versus mass.
    """
    spec, names = answer.record.spec, find_front_axes(answer)
    figure, (axes,) = style.make_axes(width=7.4, height=4.8)
    scales = [choose_scale(answer, n) for n in names]

    def locate(design: Any) -> tuple[float, ...]:
        return tuple(design[n] * f for n, (f, _) in zip(names, scales, strict=True))

    x, y = np.array(sorted(locate(d) for d in answer.front)).T
    if len(spec.objectives) == 2:
        axes.plot(x, y, color=FAINT, lw=1.2, zorder=1)
    axes.plot(x, y, "o", color=GREY, ms=3.2, mec="none", zorder=2)
    points = []
    for design, word, look in marked_designs(answer, names):
        axes.plot(*locate(design), look.mark, color=look.color, ms=look.size, mec="white", zorder=4)
        points.append((locate(design), word, look.color))
    words = [f"{n.replace('_', ' ')} [{unit}]" for n, (_, unit) in zip(names, scales, strict=True)]
    axes.set(xlabel=words[0], ylabel=words[1])
    axes.margins(0.12)
    _draw_labels(axes, points, *(worse_direction(answer, n) for n in names))
    detail = f"{answer.feasible_designs:,} of {answer.designs:,} designs meet the constraints"
    if len(answer.front) < answer.front_size:
        detail += f"; {len(answer.front)} of {answer.front_size} on the front are drawn"
    goals = " and ".join(str(o) for o in spec.objectives)
    style.add_title(axes, f"{answer.name}: {goals}", detail)
    return figure


def _draw_labels(
    axes: style.Axes, points: list[tuple[Any, str, str]], aside: float, down: float
) -> None:
    """Write a label next to each mark, on the side of the worse designs, which is empty."""
    low, high = axes.get_xlim()
    bottom, top = axes.get_ylim()
    places: list[tuple[float, float]] = []
    for (x, y), word, color in sorted(points, key=lambda p: down * p[0][1]):
        share, up = (x - low) / (high - low), (y - bottom) / (top - bottom)
        x_text, height = share + 0.05 * aside, up + 0.05 * down
        while any(abs(height - h) < 0.058 and abs(x_text - p) < 0.4 for p, h in places):
            height += 0.015 * down
        places.append((x_text, height))
        side = {"ha": "left" if aside > 0 else "right", "textcoords": "axes fraction"}
        foot = {"relpos": (0.0 if aside > 0 else 1.0, 0.5)}
        style.add_callout(axes, word, (x, y), (x_text, height), color, line=foot, **side)


def choose_scale(answer: Any, name: str) -> tuple[float, str]:
    """Return the factor from SI, and the unit, that suit the middle of the front's values."""
    unit = answer.units[name]
    if unit == "1":
        return 1.0, "1"
    middle = float(np.median([d[name] for d in answer.front]))
    text = show(middle, unit).split(" ", 1)[1]
    factor = unit_factor(text, unit)
    return (1 / float(factor), text) if factor else (1.0, unit)
