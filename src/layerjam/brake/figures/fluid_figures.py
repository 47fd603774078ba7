"""Figures of the vacuum line: Fig. 5 of the paper, and ways to make the line faster."""

from typing import Any

import numpy as np

from layerjam.brake.fluid import closed_forms as forms
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.line_file import LineFile, load_line
from layerjam.brake.fluid.network import Response, respond
from layerjam.brake.fluid.timing import STORED, suggest_changes
from layerjam.core.drawing import style
from layerjam.core.drawing.chart import Curve, Pane, draw_pane
from layerjam.core.drawing.style import BLUE, GREEN, GREY, INK, KPA
from layerjam.core.units import show

FULL = 94.5e3
LONG, TOP = 1.6, 1.12
"""Upper limits of time and vacuum, relative to the time to the target and to the target."""


def _draw_rise_bars(axes: style.Axes, line: Line, target: float, water: bool = False) -> None:
    """Draw the rise time after each change to the line as a row, the first on top."""
    rows = suggest_changes(line, target, water)[::-1]
    longest = max((time for _, time in rows), default=1.0)
    for y, (change, time) in enumerate(rows):
        color = INK if change == "as it is" else GREEN
        axes.plot([0, time], [y, y], color=color, lw=1.2)
        style.add_point(axes, time, y, color=color, ms=5)
        style.add_label(axes, time + 0.03 * longest, y, show(time, "s", 3), color)
    if not rows:
        middle: dict[str, Any] = {"transform": axes.transAxes, "ha": "center"}
        style.add_label(axes, 0.5, 0.5, "none of these reaches the target", GREY, **middle)
    axes.set_yticks(range(len(rows)), [change for change, _ in rows])
    axes.set(xlim=(0, 1.3 * longest), ylim=(-0.6, max(len(rows), 1) - 0.4))
    axes.grid(axis="y", visible=False)
    detail = "one change at a time"
    if line.reservoir is None and not water:
        pressure = max(STORED, forms.final_pressure(line))
        detail = f"reservoir at {pressure * KPA:.3g} kPa absolute, its valve 0.2 L/(s bar)"
    style.label_axes(
        axes, "Ways to shorten the rise time", detail, xlabel="rise time (10 to 90 %) [s]"
    )


def _draw_rise_levels(axes: style.Axes, target: float) -> None:
    for part in (0.1, 0.9):
        style.mark_y(axes, part * target * KPA, f"{100 * part:.0f} %", GREY, 0.99, part > 0.5)
    axes.set(xlabel="time [s]", ylabel="vacuum [kPa]")


def make_rise_pane(
    file: LineFile, target: float, response: Response | forms.Filling, rise: float | None
) -> list[Pane]:
    """Return the pane of vacuum versus time up to a target [Pa].

    `rise` is the rise time [s], None if the target is never reached. In water, `response` is a
    Filling.
    """
    time, vacuum, water = response.time, response.vacuum, isinstance(response, forms.Filling)
    hits = np.flatnonzero(vacuum >= target)
    end = LONG * float(time[hits[0]]) if len(hits) else np.inf
    is_drawn = (time <= end) & (vacuum <= TOP * target)
    levels = [(part * target * KPA, f"{100 * part:.0f} %", GREY) for part in (0.1, 0.9)]
    levels.append((target * KPA, f"target {show(target, 'Pa')}", GREEN))
    return [
        Pane(
            [Curve(time[is_drawn], vacuum[is_drawn] * KPA)],
            "time [s]",
            "vacuum [kPa]",
            (0, float(time[is_drawn][-1])),
            (0, TOP * target * KPA),
            levels=levels,
            headline=f"{file.name} in {'water' if water else 'air'}",
            detail="never reached" if rise is None else f"10 to 90 % in {show(rise, 's', 3)}",
        )
    ]


@style.use_style
def draw_rise(pane: Pane, line: Line, target: float, water: bool) -> style.Figure:
    """Draw vacuum versus time up to a target [Pa], and the rise times of faster lines."""
    figure, (steps, bars) = style.make_axes(columns=2, width=9.6, height=3.9)
    draw_pane(steps, pane)
    _draw_rise_bars(bars, line, target, water)
    return figure


@style.use_style
def draw_fig5() -> style.Figure:
    """Draw vacuum versus time in air and in water, and the rise times of faster lines."""
    line = load_line("choi2018").line
    response = respond(line, 8.0)
    flow = forms.total_pump_flow(line) / (line.chamber.compliance or np.nan)
    figure, (steps, bars) = style.make_axes(columns=2, width=9.6, height=3.9)
    for name, vacuum, color, paper_time in (
        ("air", response.vacuum, INK, 3.9),
        ("water", flow * response.time, BLUE, 1.5),
    ):
        rise = forms.rise_time(FULL, line, water=name == "water") or np.nan
        words = f"{name}: {rise:.2f} s (paper {paper_time} s)"
        steps.plot(response.time, np.minimum(vacuum, FULL) * KPA, color=color, label=words)
    steps.set(xlim=(0, 8), ylim=(0, 100))
    _draw_rise_levels(steps, FULL)
    style.add_key(steps, loc="center right")
    style.add_title(steps, "Fig. 5: rise to 94.5 kPa", "7.50 mL and 0.0661 mL/kPa inferred from it")
    _draw_rise_bars(bars, line, FULL)
    return figure
