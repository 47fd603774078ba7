"""Impact planning: the vacuum over the warning time, and full against tuned vacuum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from layerjam.control.plan import Arrival, Plan
from layerjam.control.plan_spread import spread
from layerjam.report import style
from layerjam.report.style import BLUE, GREEN, INK, KPA, ORANGE, RED
from layerjam.units import show

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


@style.styled
def planned(made: Plan) -> style.Figure:
    """Vacuum that comes in the warning time; expected peak and chance to run out of travel."""
    figure, (rises, peaks, chances) = style.canvas(columns=3, width=12.4, height=3.9)
    _rise(rises, made)
    _modes(peaks, chances, made)
    return figure


def _rise(axes: style.Axes, made: Plan) -> None:
    time, vacuum = made.rising.time, made.rising.vacuum * KPA
    end, needed = max(float(time[-1]), 1e-3), made.needed
    axes.plot(time, vacuum, color=BLUE)
    top = max(float(vacuum.max()), 0.0 if needed is None else needed * KPA, 1.0)
    axes.set(xlim=(0, end * 1.02), ylim=(0, top * 1.22))
    axes.set(xlabel="time from the warning [s]", ylabel="vacuum [kPa]")
    style.spot(axes, time[-1], vacuum[-1], color=BLUE, clip_on=False)
    words = [(f"{show(made.reached, 'Pa', 3)} in time", BLUE)]
    what, detail = "What comes in time", "no vacuum of the site stops it within the travel"
    if needed is not None:
        enough, case = needed <= made.reached, made.case
        color = GREEN if enough else RED
        axes.axhline(needed * KPA, color=color, lw=1.2, ls=style.DASHED)
        words.append((f"{show(needed, 'Pa', 3)} needed", color))
        what = f"{'Enough' if enough else 'Too little'} vacuum comes in time"
        detail = f"{show(case.mass, 'kg')} at {show(case.speed, 'm/s')} within "
        detail += f"{show(case.travel, 'm')} of slip"
    style.key(axes, *words, at="lower right")
    style.title(axes, what, detail)


def _modes(peaks: style.Axes, chances: style.Axes, made: Plan) -> None:
    case, brake = made.case, made.brake.brake
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
        words = f"{name}: {show(vacuum, 'Pa', 3)}" + (
            "" if np.isfinite(g).any() else ", none stops"
        )
        peaks.plot(x, g, color=color, label=words)
        chances.plot(x, np.array([r.out for r in runs]) * 100, color=color, label=words)
        highest = max(highest, float(np.nanmax(np.append(g, 0.0))))
    usable = show(brake.sheets.usable_travel, "m")
    from_speed = "" if given else ", from the speed alone"
    peaks.set(ylim=(0, max(highest * 1.3, 1.0)), ylabel="expected peak [g]")
    chances.set_ylim(0, min(max(chances.get_ylim()[1] * 1.3, 5.0), 130))
    chances.set_ylabel("chance to run out of travel [%]")
    for axes in (peaks, chances):
        axes.set(xlim=(0, x[-1]), xlabel=f"standard deviation of the energy{from_speed} [%]")
        if given:
            style.upright(axes, energy_sd(made.case) * 100, "as given", at=0.03)
        style.key(axes, at="upper left")
    style.title(peaks, "What the mass feels", "expected peak of those that stop")
    style.title(chances, "What may go wrong", f"it needs more than the brake's {usable}")
