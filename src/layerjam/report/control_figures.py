"""A regulator on its line, and a force that follows a profile."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layerjam.control.closed_loop import ClosedLoop
from layerjam.control.follow import Bode, Following
from layerjam.control.settings import Regulator
from layerjam.report.style import BLUE, GREEN, GREY, INK, RED, canvas, label, look, save, title
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["following", "loop", "save"]
KPA = 1e3


def loop(regulator: Regulator, made: ClosedLoop) -> Figure:
    """Vacuum, reading and target over time, and what the pump does."""
    with look():
        figure, (upper, lower) = canvas(
            rows=2, width=7.4, height=5.0, sharex=True, gridspec_kw={"height_ratios": (2.4, 1)}
        )
        upper.plot(made.time, made.measured / KPA, color=GREY, lw=0.6)
        upper.plot(made.time, made.target / KPA, color=GREEN, lw=1.2, ls=(0, (4, 2)))
        upper.plot(made.time, made.vacuum / KPA, color=INK, lw=1.5)
        high = float(max(made.target.max(), made.vacuum.max())) / KPA
        late = float(made.time[-1])
        label(upper, 0.55 * late, 0.62 * high, "vacuum in the chamber", INK)
        label(upper, 0.55 * late, 0.50 * high, "target", GREEN)
        label(upper, 0.55 * late, 0.38 * high, "what the sensor shows", GREY)
        upper.set(ylim=(0, 1.15 * high), xlim=(0, late), ylabel="vacuum [kPa]")
        rise = show(made.rise_time, "s", 3) if np.isfinite(made.rise_time) else "never reached"
        title(
            upper, f"Regulator {regulator.kind}: {made.outcome}",
            f"rise 10 to 90 %: {rise}; overshoot {show(made.overshoot, 'Pa', 3)}; pump switched "
            f"{made.pump_switches} times",
        )  # fmt: skip
        lower.fill_between(made.time, made.pump, step="post", color=BLUE, alpha=0.5, lw=0)
        lower.step(made.time, made.vent, where="post", color=RED, lw=0.9)
        lower.set(ylim=(-0.05, 1.15), xlabel="time [s]", ylabel="command")
        label(lower, 0.55 * late, 0.85, "pump", BLUE)
        label(lower, 0.7 * late, 0.85, "vent", RED)
        if np.isfinite(made.fault_time):
            for axes in (upper, lower):
                axes.axvline(made.fault_time, color=RED, lw=1.0)
    return figure


def following(made: Following, swept: Bode | None) -> Figure:
    """Force and what was wanted, the vacuum behind it, and the answer to a sine."""
    with look():
        figure, axes = canvas(columns=2 if swept is not None else 1, width=10.4, height=4.2)
        force = axes[0]
        lost = ~made.possible
        if lost.any():
            force.fill_between(
                made.time, 0, 1, where=lost, color=RED, alpha=0.12, lw=0,
                transform=force.get_xaxis_transform(),
            )  # fmt: skip
        force.plot(made.time, made.wanted, color=GREEN, lw=2.2, alpha=0.7)
        force.plot(made.time, made.force, color=INK, lw=1.1)
        top = float(max(made.wanted.max(), made.force.max()))
        late = float(made.time[-1])
        force.set(xlim=(0, late), ylim=(0, 1.3 * top), xlabel="time [s]", ylabel="force [N]")
        label(force, 0.03 * late, 1.22 * top, "wanted", GREEN)
        label(force, 0.2 * late, 1.22 * top, "given", INK)
        if lost.mean() > 0.005:
            label(force, 0.36 * late, 1.22 * top, "cannot be followed", RED)
        title(
            force, "A force that follows a profile",
            f"error {show(made.rms, 'N', 3)} RMS; the brake slips from "
            f"{show(float(made.slip[0]), 'm', 3)} to {show(float(made.slip[-1]), 'm', 3)}",
        )  # fmt: skip
        if swept is not None:
            size = axes[1]
            size.plot(swept.frequency, swept.magnitude, "o-", color=INK, ms=4, lw=1.2)
            size.axhline(2**-0.5, color=GREY, lw=0.8, ls=(0, (2, 2)))
            size.set(xscale="log", ylim=(0, 1.25), xlabel="frequency [Hz]")
            size.set_ylabel("force over wanted force", color=INK)
            turn = size.twinx()
            turn.plot(swept.frequency, swept.phase, "s--", color=BLUE, ms=3.5, lw=1.0)
            turn.set_ylabel("phase [degrees]", color=BLUE)
            turn.set(ylim=(-180, 45))
            turn.grid(visible=False)
            wide = swept.bandwidth
            said = "beyond what was tried" if wide is None else show(wide, "Hz", 3)
            title(size, "A sine of this swing", f"down to 71 % at {said}; phase dashed")
    return figure
