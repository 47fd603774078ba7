"""Force versus mass, log-log, with lines of constant force per unit mass (paper, Fig. 12)."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, PURPLE, RED, SKY
from layerjam.core.units import show

if TYPE_CHECKING:
    from layerjam.workshop.design.force_density import SheetLine

save = style.save
_GROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
_LOOKS = ((RED, "s"), (GREEN, "^"), (PURPLE, "D"), (ORANGE, "v"), (SKY, "P"))
G = 1e3
"""Grams per kilogram."""


@style.use_style
def draw_density(
    rows: Sequence[dict[str, Any]],
    lines: "Sequence[SheetLine]",
    sheet: Mapping[str, Any],
    missing: Sequence[str],
) -> style.Figure:
    """Draw the devices of `compare`, the first of them with more sheets, and the empty classes."""
    first = lines[0]
    x = np.array([r["mass"] for r in rows] + list(first.masses)) * G
    y = np.array([r["max_force"] for r in rows] + list(first.forces))
    figure, (axes,) = style.make_axes(width=8.6, height=5.8)
    axes.set(xscale="log", yscale="log", xlabel="mass [g]", ylabel="maximum force [N]")
    axes.set(xlim=(x.min() / 4, x.max() * 3.5), ylim=(y.min() / 2.5, y.max() * 3))
    axes.grid(visible=False)
    _draw_equal_density(axes)
    _draw_our_brakes(axes, [r for r in rows if r["computed"]], first)
    _draw_other_devices(axes, [r for r in rows if not r["computed"]])
    if missing:
        words = f"not drawn because no published device was found: {', '.join(missing)}"
        note = "\n".join(textwrap.wrap(words, 125))
        figure.supxlabel(note, fontsize=8, color=GREY, x=0.01, ha="left")
    forces = [
        show(sheet[k], unit, 3) for k, unit in (("force_per_sheet", "N"), ("paper_force", "N"))
    ]
    masses = [show(sheet[k], "kg", 3) for k in ("mass_per_sheet", "paper_mass")]
    detail = f"one more sheet in {sheet['brake']} at {show(sheet['vacuum'], 'Pa', 4)}: "
    detail += f"{forces[0]} and {masses[0]} (paper: {forces[1]}, {masses[1]})"
    vacuum = show(first.vacuum, "Pa", 4)
    style.add_title(
        axes, f"Force versus mass; our brakes computed at {vacuum} unless stated", detail
    )
    return figure


def draw_fig12() -> style.Figure:
    """Draw the paper's Fig. 12 from the mass model, with other devices from cited sources."""
    from layerjam.brake.device.load import devices, load
    from layerjam.workshop.design.comparison import compare_devices

    brakes = [load(name) for name in devices()]
    rows, sheet, lines, others = compare_devices(brakes, [b.brake.site.atmosphere for b in brakes])
    return draw_density(rows, lines, sheet, list(others.looked_for))


def _draw_equal_density(axes: style.Axes) -> None:
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    for power in range(-1, 7):
        per_gram = 10.0**power / G
        if per_gram * right < low * 1.6 or per_gram * left > high / 1.6:
            continue
        axes.plot([left, right], [left * per_gram, right * per_gram], color=FAINT, lw=0.8, zorder=1)
        end = min(right, high / per_gram)
        name = f"{10.0**power:g} N/kg" if power < 3 else f"{10.0 ** (power - 3):g} kN/kg"
        align = {"fontsize": 8, "ha": "right", "va": "top", "zorder": 2}
        style.add_label(axes, end / 1.08, end * per_gram / 1.08, name, GREY, **align)


def _draw_our_brakes(axes: style.Axes, rows: Sequence[dict[str, Any]], line: "SheetLine") -> None:
    masses = np.array(line.masses) * G
    axes.plot(masses, line.forces, color=BLUE, lw=1.4, ls=style.DASHED, zorder=3)
    axes.plot(masses[1:], line.forces[1:], ".", color=BLUE, ms=5, zorder=3)
    for count, m, f in list(zip(line.sheets, masses, line.forces, strict=True))[1:]:
        style.add_label(axes, m / 1.1, f * 1.05, f"{count} sheets", BLUE, ha="right", fontsize=8)
    for row in rows:
        m, f, is_array = row["mass"] * G, row["max_force"], row["brakes"] > 1
        shape, size = ("*", 10) if is_array else ("o", 6)
        axes.plot(m, f, shape, color=BLUE, mfc="white" if row["note"] else BLUE, ms=size, zorder=4)
        if is_array:
            words = f"array of {row['brakes']} brakes"
            style.add_label(axes, m * 1.13, f / 1.06, words, BLUE, fontsize=8)
    _draw_names(axes, [r for r in rows if r["brakes"] == 1])


def _draw_names(axes: style.Axes, single: Sequence[dict[str, Any]]) -> None:
    """Write the names of single brakes in a column to the right, spaced out if forces are close."""
    column = 1.45 * G * max(r["mass"] for r in single)
    height = 0.0
    for row in sorted(single, key=lambda r: r["max_force"]):
        height = max(row["max_force"] / 1.1, height * 1.3)
        words = row["name"] + (", friction not measured" if row["note"] else "")
        point = row["mass"] * G, row["max_force"]
        style.add_callout(axes, words, point, (column, height), BLUE, fontsize=8, zorder=3)


def _draw_other_devices(axes: style.Axes, rows: Sequence[dict[str, Any]]) -> None:
    for index, kind in enumerate(dict.fromkeys(r["kind"] for r in rows)):
        color, marker = _LOOKS[index % len(_LOOKS)]
        kind_rows = sorted((r for r in rows if r["kind"] == kind), key=lambda r: r["mass"])
        for row in kind_rows:
            axes.plot(row["mass"] * G, row["max_force"], marker, color=color, ms=7, zorder=4)
        middle = kind_rows[len(kind_rows) // 2]
        point = (middle["mass"] * G, middle["max_force"])
        light = point[0] < np.sqrt(np.prod(axes.get_xlim()))
        rim = "\n(torque at its own rim)" if middle["lever"] else ""
        text = f"{kind}{rim}" if len(kind_rows) > 1 else f"{kind}:\n{kind_rows[0]['name']}"
        shift: dict[str, Any] = {
            "xytext": (-40 if light else 10, -12),
            "textcoords": "offset points",
        }
        shade = INK if color == ORANGE else style.text_ink(color)
        axes.annotate(text, point, va="top", fontsize=8.5, color=shade, bbox=_GROUND, **shift)
