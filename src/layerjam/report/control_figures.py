"""A regulator on its line, and a force that follows a profile."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from layerjam.control.closed_loop import ClosedLoop
from layerjam.control.follow import Bode, Following
from layerjam.control.settings import Regulator
from layerjam.report import style
from layerjam.report.style import BLUE, GREEN, GREY, INK, KPA, RED
from layerjam.units import show


@style.styled
def loop(regulator: Regulator, made: ClosedLoop) -> style.Figure:
    """Vacuum, reading and target over time, and what the pump does."""
    figure, (upper, lower) = style.canvas(
        rows=2, width=7.4, height=5.0, sharex=True, height_ratios=(2.4, 1)
    )
    upper.plot(made.time, made.measured * KPA, color=GREY, lw=0.6, label="what the sensor shows")
    upper.plot(made.time, made.target * KPA, color=GREEN, lw=1.2, ls=style.DASHED, label="target")
    upper.plot(made.time, made.vacuum * KPA, color=INK, lw=1.5, label="vacuum in the chamber")
    high = float(max(made.target.max(), made.vacuum.max())) * KPA
    upper.set(ylim=(0, 1.15 * high), xlim=(0, float(made.time[-1])), ylabel="vacuum [kPa]")
    rise = show(made.rise_time, "s", 3) if np.isfinite(made.rise_time) else "never reached"
    words = f"rise 10 to 90 %: {rise}; overshoot {show(made.overshoot, 'Pa', 3)}; pump switched "
    words += f"{made.pump_switches} times"
    style.title(upper, f"Regulator {regulator.kind}: {made.outcome}", words)
    lower.fill_between(made.time, made.pump, step="post", color=BLUE, alpha=0.5, lw=0, label="pump")
    lower.step(made.time, made.vent, where="post", color=RED, lw=0.9, label="vent")
    lower.set(ylim=(-0.05, 1.15), xlabel="time [s]", ylabel="command [-]")
    for axes in (upper, lower):
        style.key(axes, at="right")
        if np.isfinite(made.fault_time):
            axes.axvline(made.fault_time, color=RED, lw=1.0)
    return figure


@style.styled
def watched(
    time: Sequence[float], vacuum: Sequence[float], target: Sequence[float], simulated: bool = False
) -> style.Figure:
    """Vacuum and target [Pa] of a bench over time [s]; NaN where the sensor showed none."""
    figure, (axes,) = style.canvas(width=7.4, height=3.6)
    wanted, seen = np.asarray(target, float) * KPA, np.asarray(vacuum, float) * KPA
    axes.plot(time, wanted, color=GREEN, lw=1.2, ls=style.DASHED, label="target")
    axes.plot(time, seen, color=INK, lw=1.5, label="vacuum")
    known = seen[np.isfinite(seen)]
    high = max(float(wanted.max()), float(known.max()) if len(known) else 0.0, 1.0)
    end = max(float(time[-1]), 1e-3)
    axes.set(xlim=(0, end), ylim=(0, 1.15 * high), xlabel="time [s]", ylabel="vacuum [kPa]")
    about = "a virtual board: computed, not measured" if simulated else f"over {show(end, 's', 3)}"
    style.title(axes, "Vacuum of the bench", about)
    style.key(axes, at="right")
    return figure


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
