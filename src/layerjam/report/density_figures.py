"""Force over mass, log-log, with lines of equal force density (paper, Fig. 12)."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.report.style import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    canvas,
    label,
    look,
    save,
    title,
)
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from layerjam.design.force_density import SheetLine

__all__ = ["density", "save"]
_GROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
_LOOKS = ((RED, "s"), (GREEN, "^"), (PURPLE, "D"), (ORANGE, "v"), (SKY, "P"))


def density(
    rows: Sequence[dict[str, Any]],
    lines: Sequence[SheetLine],
    sheet: dict[str, Any],
    missing: Sequence[str],
) -> Figure:
    """Devices as `compare` lists them, the first brake's line of sheet counts, what is missing."""
    ours = [r for r in rows if r["computed"]]
    theirs = [r for r in rows if not r["computed"]]
    first = lines[0]
    x = np.array([r["mass"] for r in rows] + list(first.masses)) * 1e3
    y = np.array([r["max_force"] for r in rows] + list(first.forces))
    with look():
        figure, (axes,) = canvas(width=8.6, height=5.8)
        axes.set(xscale="log", yscale="log", xlabel="mass [g]", ylabel="greatest force [N]")
        axes.set(xlim=(x.min() / 4, x.max() * 3.5), ylim=(y.min() / 2.5, y.max() * 3))
        axes.grid(visible=False)
        _equal_density(axes)
        _ours(axes, ours, first)
        _theirs(axes, theirs)
        if missing:
            words = f"not drawn, for no device with a source was found: {', '.join(missing)}"
            figure.supxlabel(
                "\n".join(textwrap.wrap(words, 125)), fontsize=8, color=GREY, x=0.01, ha="left"
            )
        at = show(first.vacuum, "Pa", 4)
        title(
            axes, f"Force over mass, ours computed at {at} where not said",
            f"one more sheet in {sheet['brake']} at {show(sheet['vacuum'], 'Pa', 4)}: "
            f"{show(sheet['force_per_sheet'], 'N', 3)} and "
            f"{show(sheet['mass_per_sheet'], 'kg', 3)} (the paper: "
            f"{show(sheet['paper_force'], 'N', 3)}, {show(sheet['paper_mass'], 'kg', 3)})",
        )  # fmt: skip
    return figure


def fig12() -> Figure:
    """The paper's Fig. 12 from the mass model, beside what others make where a source was read."""
    from layerjam.design.comparison import comparison
    from layerjam.device.load import catalogue, load

    brakes = [load(name) for name in catalogue()]
    rows, sheet, lines, others = comparison(brakes, [b.brake.site.atmosphere for b in brakes])
    return density(rows, lines, sheet, list(others.looked_for))


def _equal_density(axes: Axes) -> None:
    """Straight lines of one force density, named where they leave the picture."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    for power in range(-1, 7):
        per_gram = 10.0**power / 1e3
        if per_gram * right < low * 1.6 or per_gram * left > high / 1.6:
            continue
        axes.plot([left, right], [left * per_gram, right * per_gram], color=FAINT, lw=0.8, zorder=1)
        end = min(right, high / per_gram)
        name = f"{10.0**power:g} N/kg" if power < 3 else f"{10.0 ** (power - 3):g} kN/kg"
        where = (end / 1.06, end * per_gram / 1.06)
        axes.annotate(
            name, where, color=GREY, fontsize=8, ha="right", va="top",
            xytext=(-1, -1), textcoords="offset points", zorder=2,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.9},
        )  # fmt: skip


def _ours(axes: Axes, ours: Sequence[dict[str, Any]], line: SheetLine) -> None:
    masses = np.array(line.masses) * 1e3
    axes.plot(masses, line.forces, color=BLUE, lw=1.4, ls=(0, (4, 2)), zorder=3)
    axes.plot(masses[1:], line.forces[1:], ".", color=BLUE, ms=5, zorder=3)
    for count, m, f in list(zip(line.sheets, masses, line.forces, strict=True))[1:]:
        label(axes, m / 1.1, f * 1.05, f"{count} sheets", BLUE, ha="right", fontsize=8)
    for row in ours:
        m, f, stacked = row["mass"] * 1e3, row["max_force"], row["brakes"] > 1
        inside = "white" if row["note"] else BLUE
        size = 10 if stacked else 6
        axes.plot(m, f, "*" if stacked else "o", color=BLUE, mfc=inside, ms=size, zorder=4)
        if stacked:
            label(
                axes, m * 1.13, f / 1.06, f"{row['brakes']} brakes side by side", BLUE, fontsize=8
            )
    _names(axes, [r for r in ours if r["brakes"] == 1])


def _names(axes: Axes, single: Sequence[dict[str, Any]]) -> None:
    """Names of single brakes in a column to the right, apart where forces are close."""
    column = 1.45e3 * max(r["mass"] for r in single)
    places: list[float] = []
    for row in sorted(single, key=lambda r: r["max_force"]):
        f = row["max_force"]
        places.append(max(f / 1.1, places[-1] * 1.3) if places else f / 1.1)
        name = row["name"] + (", friction not measured" if row["note"] else "")
        axes.annotate(
            name, (row["mass"] * 1e3, f), xytext=(column, places[-1]), textcoords="data",
            va="center", ha="left", fontsize=8, color=BLUE, zorder=3, bbox=_GROUND,
            arrowprops={"arrowstyle": "-", "color": BLUE, "lw": 0.4, "shrinkA": 0, "shrinkB": 3},
        )  # fmt: skip


def _theirs(axes: Axes, theirs: Sequence[dict[str, Any]]) -> None:
    for index, kind in enumerate(dict.fromkeys(r["kind"] for r in theirs)):
        color, marker = _LOOKS[index % len(_LOOKS)]
        mine = sorted((r for r in theirs if r["kind"] == kind), key=lambda r: r["mass"])
        for row in mine:
            axes.plot(row["mass"] * 1e3, row["max_force"], marker, color=color, ms=7, zorder=4)
        middle = mine[len(mine) // 2]
        place = (middle["mass"] * 1e3, middle["max_force"])
        light = place[0] < np.sqrt(np.prod(axes.get_xlim()))
        rim = "\n(torque at its own rim)" if middle["lever"] else ""
        text = f"{kind}{rim}" if len(mine) > 1 else f"{kind}:\n{mine[0]['name']}"
        axes.annotate(
            text, place, xytext=(-40 if light else 10, -12), textcoords="offset points",
            ha="left", va="top", fontsize=8.5, color=INK if color == ORANGE else color, zorder=3,
            bbox=_GROUND,
        )  # fmt: skip
