"""A regulator on its line, and a force that follows a profile."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from layerjam.control.closed_loop import ClosedLoop
from layerjam.control.follow import Bode, Following
from layerjam.control.settings import Regulator
from layerjam.report import style
from layerjam.report.chart import Curve, Pane, draw
from layerjam.report.style import GREEN, GREY, INK, KPA, ORANGE, RED, SKY
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
    axes.set(ylim=(0, 1.25), xlabel="frequency [Hz]", ylabel="force over wanted force [-]")
    style.level(axes, 2**-0.5, "71 %", GREY)
    phase.set(ylabel="phase, dashed [degrees]", ylim=turn)
    phase.grid(visible=False)
    if any(name for *_, name in swept):
        style.key(axes, *((name, color) for _, color, name in swept), at="lower left")
