"""The vacuum line: Fig. 5 of the paper, and what would make the line faster."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from layerjam.fluid import closed_forms as forms
from layerjam.fluid.file import load_line
from layerjam.fluid.line import Line, Reservoir
from layerjam.fluid.network import Drive, at_pressure, respond
from layerjam.report.style import BLUE, GREEN, GREY, INK, canvas, label, look, save, title

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["fig5", "save"]
FULL, KPA, ML = 94.5e3, 1e3, 1e-6
TANK = Reservoir(volume=0.5e-3, conductance=2e-9)
STORED = 2e3
"""Absolute pressure of the reservoir before it is joined [Pa]."""


def with_reservoir(line: Line) -> float | None:
    """10 to 90 % rise [s] where an emptied half litre is joined and the pump helps."""
    joined = replace(line, reservoir=TANK)
    made = respond(joined, 1.0, Drive(store=1.0), at_pressure(joined, stored=STORED), 2001)
    low, high = made.crossing(0.1 * FULL), made.crossing(0.9 * FULL)
    return None if low is None or high is None else high - low


def changes(line: Line) -> list[tuple[str, float]]:
    """What can be changed, and the rise time [s] it gives."""
    half = replace(line, chamber=replace(line.chamber, volume=line.chamber.volume / 2))
    twice = replace(line, pump=replace(line.pump, count=2 * line.pump.count))
    found = [
        ("as it is", forms.rise_time(FULL, line)),
        ("half the volume", forms.rise_time(FULL, half)),
        ("four pumps", forms.rise_time(FULL, twice)),
        ("water", forms.rise_time(FULL, line, water=True)),
        ("water, four pumps", forms.rise_time(FULL, twice, water=True)),
        ("0.5 L reservoir", with_reservoir(line)),
    ]
    return [(what, time) for what, time in found if time is not None]


def fig5() -> Figure:
    """Vacuum over time in air and water, and rise times of other lines."""
    line = load_line("choi2018").line
    air = respond(line, 8.0)
    water = np.minimum(
        forms.pumps_flow(line) * air.time / (line.chamber.compliance or np.nan), FULL
    )
    with look():
        figure, (steps, bars) = canvas(columns=2, width=9.6, height=3.9)
        for part in (0.1, 0.9):
            steps.axhline(part * FULL / KPA, color=GREY, lw=0.7, ls=(0, (2, 2)))
        shown = np.minimum(air.vacuum, FULL)
        steps.plot(air.time, shown / KPA, color=INK)
        steps.plot(air.time, water / KPA, color=BLUE)
        for name, color, place, paper, level in (
            ("air", INK, forms.rise_time(FULL, line), 3.9, (2.5, 60.0)),
            ("water", BLUE, forms.rise_time(FULL, line, water=True), 1.5, (0.95, 20.0)),
        ):
            label(steps, *level, f"{name}: {place:.2f} s (paper {paper} s)", color)
        steps.text(7.9, 0.1 * FULL / KPA + 1.5, "10 %", fontsize=8.2, color=GREY, ha="right")
        steps.text(7.9, 0.9 * FULL / KPA - 5, "90 %", fontsize=8.2, color=GREY, ha="right")
        steps.set(xlim=(0, 8), ylim=(0, 100), xlabel="time [s]", ylabel="vacuum [kPa]")
        title(steps, "Fig. 5: rise to 94.5 kPa", "7.50 mL and 0.0661 mL/kPa are inferred from it")
        made = changes(line)[::-1]
        places = np.arange(len(made))
        for y, (what, time) in zip(places.tolist(), made, strict=True):
            color = INK if what == "as it is" else GREEN
            bars.plot([0, time], [y, y], color=color, lw=1.2)
            bars.plot([time], [y], "o", color=color, ms=5)
            short = f"{time:.2f} s" if time > 0.1 else f"{time * 1e3:.0f} ms"
            bars.text(time + 0.12, y, short, va="center", fontsize=8.8, color=color)
        bars.set_yticks(places, [what for what, _ in made])
        bars.set(xlim=(0, 4.8), ylim=(-0.6, len(made) - 0.4), xlabel="rise time 10 to 90 % [s]")
        bars.grid(axis="y", visible=False)
        detail = f"reservoir: at {STORED / KPA:g} kPa absolute, behind a valve of C = 0.2 L/(s bar)"
        title(bars, "What would make it faster", detail)
    return figure
