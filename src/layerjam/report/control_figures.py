"""A regulator on its line, and a force that follows a profile."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from layerjam.control.closed_loop import ClosedLoop
from layerjam.control.follow import Bode, Following
from layerjam.control.plan import Arrival, Plan
from layerjam.control.plan_spread import spread
from layerjam.control.settings import Regulator
from layerjam.report import style
from layerjam.report.chart import Curve, Pane, draw
from layerjam.report.style import BLUE, GREEN, GREY, INK, KPA, ORANGE, RED, SKY
from layerjam.units import show


def loop(regulator: Regulator, made: ClosedLoop, fault_at: float | None = None) -> list[Pane]:
    """Vacuum, reading and target over time, and what the pump does; ground from a fault on."""
    time, end = made.time, float(made.time[-1])
    vacuum = [
        Curve(time, made.vacuum * KPA, name="vacuum"),
        Curve(time, made.measured * KPA, SKY, "sensor", width=1.0),
        Curve(time, made.target * KPA, GREEN, "target", "dashed", 1.5),
    ]
    commands = [
        Curve(time, made.pump, name="pump", width=1.2),
        Curve(time, made.vent, RED, "vent", width=1.5),
    ]
    found = float(made.fault_time) if np.isfinite(made.fault_time) else end
    begins = found if fault_at is None else min(fault_at, found)
    grounds = (begins, found, ORANGE), (found, end, RED)
    common: dict[str, Any] = {"x": "time [s]", "x_range": (0, end)}
    common["spans"] = [ground for ground in grounds if ground[0] < ground[1]]
    high = 1.15 * float(max(made.target.max(), made.vacuum.max())) * KPA
    rise = show(made.rise_time, "s", 3) if np.isfinite(made.rise_time) else "never reached"
    words = f"rise 10 to 90 %: {rise}; overshoot {show(made.overshoot, 'Pa', 3)}; pump switched "
    words += f"{made.pump_switches} times"
    said: dict[str, Any] = {
        "headline": f"Regulator {regulator.kind}: {made.outcome}",
        "detail": words,
    }
    low = min(1.15 * float(made.pump.min()), 0.0)
    return [
        Pane(vacuum, y="vacuum [kPa]", y_range=(0, high), share=1.7, **said, **common),
        Pane(commands, y="command [-]", y_range=(low, 1.15), **common),
    ]


def seen(time: Any, vacuum: Any, target: Any, **pane: Any) -> list[Pane]:
    """Vacuum and target [Pa] of a bench over time [s]; NaN where the sensor showed none."""
    wanted, shown = np.asarray(target, float) * KPA, np.asarray(vacuum, float) * KPA
    aim = Curve(time, wanted, GREEN, "target", "dashed", 1.5)
    most = max(50.0, 1.15 * float(np.nanmax((*wanted, *shown))))
    how = {"x": "time [s]", "x_range": (0, max(float(time[-1]), 1e-3)), **pane}
    curves, top = [Curve(time, shown, name="vacuum"), aim], math.ceil(most / 10) * 10
    return [Pane(curves, y="vacuum [kPa]", y_range=(0, top), **how)]


def watched(
    time: Sequence[float], vacuum: Sequence[float], target: Sequence[float], simulated: bool = False
) -> style.Figure:
    """The figure of `seen`."""
    about = f"over {show(max(float(time[-1]), 1e-3), 's', 3)}"
    about = "a virtual board: computed, not measured" if simulated else about
    return draw(seen(time, vacuum, target, headline="Vacuum of the bench", detail=about))


@style.styled
def following(made: Following, swept: Bode | None) -> style.Figure:
    """Force and what was wanted, the vacuum behind it, and the response to a sine."""
    figure, (force, *size) = style.canvas(columns=1 + (swept is not None), width=10.4, height=4.2)
    detail = f"error {show(made.rms, 'N', 3)} RMS; the brake slips from "
    detail += f"{show(float(made.slip[0]), 'm', 3)} to {show(float(made.slip[-1]), 'm', 3)}"
    profile(force, made, 1.3 * float(max(made.wanted.max(), made.force.max())))
    style.title(force, "A force that follows a profile", detail)
    if swept is not None:
        wide = (
            "beyond what was tried" if swept.bandwidth is None else show(swept.bandwidth, "Hz", 3)
        )
        frequency_response(size[0], [(swept, INK, "")], turn=(-180, 45))
        style.title(size[0], "A sine of this swing", f"down to 71 % at {wide}; phase dashed")
    return figure


def profile(axes: style.Axes, made: Following, top: float) -> None:
    """Force given over the force wanted, and where it cannot be followed."""
    lost = ~made.possible
    across = axes.get_xaxis_transform()
    axes.fill_between(made.time, 0, 1, where=lost, color=RED, alpha=0.15, lw=0, transform=across)
    axes.plot(made.time, made.wanted, color=GREEN, lw=2.2, alpha=0.7)
    axes.plot(made.time, made.force, color=INK, lw=1.1)
    names = [("wanted", GREEN), ("given", INK)]
    names += [("cannot be followed", RED)] if lost.mean() > 0.005 else []
    axes.set(xlim=(0, float(made.time[-1])), ylim=(0, top), xlabel="time [s]", ylabel="force [N]")
    style.key(axes, *names, at="upper left", ncols=3)


def frequency_response(
    axes: style.Axes, swept: list[tuple[Bode, str, str]], turn: tuple[float, float]
) -> None:
    """Size and phase over the frequency of (response, colour, name); `turn` bounds the phase."""
    phase = axes.twinx()
    for made, color, _ in swept:
        axes.plot(made.frequency, made.magnitude, "o-", color=color, ms=3.5, lw=1.3)
        phase.plot(made.frequency, made.phase, color=color, lw=1.0, ls=style.DASHED)
    style.plain(axes)
    axes.set(ylim=(0, 1.25), xlabel="frequency [Hz]", ylabel="force / required force [-]")
    style.level(axes, 2**-0.5, "71 %", GREY)
    phase.set(ylabel="phase, dashed [degrees]", ylim=turn)
    phase.grid(visible=False)
    if any(name for *_, name in swept):
        style.key(axes, *((name, color) for _, color, name in swept), at="lower left")


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
    what, detail = "Vacuum available in time", "no vacuum of the site stops it within the travel"
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
    style.title(peaks, "Force on the mass", "expected peak of those that stop")
    style.title(chances, "Faults", f"it needs more than the brake's {usable}")
