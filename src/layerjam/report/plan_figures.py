"""Impact planning: the vacuum over the warning time, and full against tuned vacuum."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from layerjam.control.plan import Arrival, Plan
from layerjam.control.plan_spread import spread
from layerjam.device.brake import Brake
from layerjam.report.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    RED,
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

__all__ = ["planned", "save"]
KPA = 1e3
STEPS = 25
"""Uncertainties drawn, from none to `MOST` times the one given."""
MOST = 2.0
GUESS = 0.1
"""Standard deviation of the speed over its mean, where none was given."""


def energy_sd(case: Arrival) -> float:
    """Standard deviation of the energy over its mean, of log-normal mass and speed."""
    mass = np.log1p((case.mass_sd / case.mass) ** 2)
    speed = np.log1p((case.speed_sd / case.speed) ** 2)
    return float(np.sqrt(np.expm1(mass + 4 * speed)))


def planned(made: Plan) -> Figure:
    """Vacuum that comes in the warning time; expected peak and chance to run out of travel."""
    with look():
        figure, (rises, peaks, chances) = canvas(columns=3, width=12.4, height=3.9)
        _rise(rises, made)
        _modes(peaks, chances, made, made.brake.brake)
    return figure


def _rise(axes: Axes, made: Plan) -> None:
    time, vacuum = made.rising.time, made.rising.vacuum / KPA
    end = max(float(time[-1]), 1e-3)
    axes.plot(time, vacuum, color=BLUE)
    axes.plot([time[-1]], [vacuum[-1]], "o", color=BLUE, ms=6, clip_on=False)
    top = max(float(vacuum.max()), 0.0 if made.needed is None else made.needed / KPA, 1.0)
    axes.set(xlim=(0, end * 1.02), ylim=(0, top * 1.22))
    axes.set(xlabel="time from the warning [s]", ylabel="vacuum [kPa]")
    height = axes.get_ylim()[1]
    near = made.needed is not None and 0 <= made.needed / KPA - vacuum[-1] < 0.14 * height
    # above the end of a curve that bends down nothing else is drawn, the line of the need excepted
    label(axes, end, vacuum[-1] + (-0.12 if near else 0.06) * height,
          f"{show(made.reached, 'Pa', 3)} in time", BLUE, ha="right")  # fmt: skip
    if made.needed is None:
        title(axes, "What comes in time", "no vacuum of the site stops it within the travel")
        return
    enough = made.needed <= made.reached
    color = GREEN if enough else RED
    axes.axhline(made.needed / KPA, color=color, lw=1.2, ls=(0, (4, 2)))
    place, side, shift = (end, "right", -0.055) if enough else (0.02 * end, "left", 0.055)
    label(axes, place, made.needed / KPA + shift * height,
          f"{show(made.needed, 'Pa', 3)} needed", color, ha=side)  # fmt: skip
    what = "Enough vacuum comes in time" if enough else "Too little vacuum comes in time"
    case = made.case
    title(axes, what, f"{show(case.mass, 'kg')} at {show(case.speed, 'm/s')} within "
          f"{show(case.travel, 'm')} of slip")  # fmt: skip


def _modes(peaks: Axes, chances: Axes, made: Plan, brake: Brake) -> None:
    case = made.case
    given = energy_sd(case) > 0
    if not given:
        case = replace(case, speed_sd=GUESS * case.speed)
    cases = [
        replace(case, mass_sd=case.mass_sd * part, speed_sd=case.speed_sd * part)
        for part in np.linspace(0, MOST, STEPS).tolist()
    ]
    x = np.array([energy_sd(c) for c in cases]) * 100
    modes = [("full", INK, made.reached), ("tuned", ORANGE, made.tuned.vacuum)]
    if made.capped:
        modes = [("full (tuned is capped to it)", INK, made.reached)]
    highest = 0.0
    for name, color, vacuum in modes:
        runs = [spread(vacuum, brake, c) for c in cases]
        g = np.array([r.peak_g for r in runs])
        out = np.array([r.out for r in runs]) * 100
        peaks.plot(x, g, color=color)
        chances.plot(x, out, color=color)
        words = f"{name}: {show(vacuum, 'Pa', 3)}"
        for axes, y, side in ((peaks, g, x[-1]), (chances, out, x[STEPS * 9 // 10])):
            there = float(np.interp(side, x, y))
            if np.isfinite(there):
                axes.annotate(words, (side, there), xytext=(-6, 8), textcoords="offset points",
                              color=color, fontsize=8.8, ha="right")  # fmt: skip
        if not np.isfinite(g).any():
            peaks.text(0.5, 0.5, "none stops", color=color, ha="center",
                       transform=peaks.transAxes)  # fmt: skip
            peaks.set_yticks([])
        highest = max(highest, float(np.nanmax(np.append(g, 0.0))))
    for axes in (peaks, chances):
        axes.set(xlim=(0, x[-1]), xlabel="standard deviation of the energy [%]")
        if given:
            axes.axvline(energy_sd(made.case) * 100, color=GREY, lw=0.8, ls=(0, (2, 2)))
            axes.text(energy_sd(made.case) * 100 - 0.015 * x[-1], 0.96, "as given", fontsize=8.2,
                      color=GREY, transform=axes.get_xaxis_transform(), ha="right")  # fmt: skip
        else:
            axes.set_xlabel("standard deviation of the energy, from the speed alone [%]")
    peaks.set(ylim=(0, max(highest * 1.25, 1.0)), ylabel="expected peak [g]")
    chances.set(ylim=(0, min(max(chances.get_ylim()[1] * 1.2, 5.0), 115)))
    chances.set(ylabel="chance to run out of travel [%]")
    title(peaks, "What the mass feels", "expected peak of those that stop")
    usable = show(brake.sheets.usable_travel, "m")
    title(chances, "What may go wrong", f"it needs more than the brake's {usable}")
