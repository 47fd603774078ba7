"""Figures of stops: one drop, and Fig. 11 of the paper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layerjam.device.load import load
from layerjam.mechanics.pull import peak
from layerjam.mechanics.stop.exact import BOTTOMED_OUT, stop
from layerjam.mechanics.stop.tune import tuned_vacuum
from layerjam.report.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    RED,
    canvas,
    label,
    look,
    save,
    title,
)
from layerjam.simulate.drop import spring_of
from layerjam.simulate.record import DropRecord
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["drop", "fig11", "save"]
SLIP = 0.040


def drop(record: DropRecord) -> Figure:
    """Force and speed over time, and force over the way of the mass."""
    time = record.time * 1e3
    with look():
        figure, (force, speed, way) = canvas(columns=3, width=9.6, height=3.5)
        top = int(np.argmax(record.force))
        force.plot(time, record.force, color=BLUE)
        force.plot(time[top], record.force[top], "o", color=RED, ms=5)
        label(
            force, time[top] + 0.05 * time[-1], record.force[top] * 1.06,
            show(float(record.force[top]), "N"), RED,
        )  # fmt: skip
        force.set(xlabel="time [ms]", ylabel="force [N]", xlim=(0, None))
        force.set_ylim(0, float(record.force.max()) * 1.15)
        speed.plot(time, record.speed_of_mass, color=BLUE)
        speed.set(xlabel="time [ms]", ylabel="speed of the mass [m/s]", xlim=(0, None))
        speed.set_ylim(0, None)
        way.fill_between(record.travel * 1e3, 0, record.force, color=BLUE, alpha=0.15, lw=0)
        way.plot(record.travel * 1e3, record.force, color=BLUE)
        way.set(xlabel="way of the mass [mm]", ylabel="force [N]", xlim=(0, None))
        way.set_ylim(0, float(record.force.max()) * 1.15)
        words = f"simulated; {show(record.mass, 'kg')} at {show(record.speed, 'm/s')}, "
        title(force, f"{record.brake.name}: {record.outcome}", words + show(record.vacuum, "Pa"))
        title(speed, "Speed")
        title(way, "Work")
    return figure


def fig11() -> Figure:
    """Peak acceleration over the speed of impact: no brake, full vacuum, tuned vacuum."""
    brake = load("choi2018-kapton").brake
    rope = float(brake.rope.stiffness) if brake.rope is not None else np.inf
    g, full = brake.site.gravity, 94.5e3
    spring = spring_of(brake, rope)
    speed = np.linspace(0.02, 3.7, 370)
    bare = 1 + np.sqrt(1 + rope * speed**2 / g**2)
    hard = stop(1.0, speed, full, spring, g, brake)
    vacuum = np.asarray(tuned_vacuum(1.0, speed, SLIP, spring, g, brake))
    within = np.isfinite(vacuum) & (vacuum <= full)
    soft = np.asarray(peak(np.where(within, vacuum, full), 0.06, brake).force) / g
    stretch = SLIP + soft * g / spring
    floor = 1 + speed**2 / (2 * g * stretch)
    out = np.asarray(hard.outcome) == BOTTOMED_OUT
    with look():
        figure, (axes,) = canvas(width=7.6, height=4.8)
        axes.plot(speed, bare, color=INK)
        axes.plot(speed[~out], (np.asarray(hard.peak_force) / g)[~out], color=BLUE)
        axes.plot(speed[out], (np.asarray(hard.peak_force) / g)[out], color=BLUE, ls=(0, (2, 2)))
        axes.plot(speed[within], soft[within], color=GREEN)
        axes.plot(speed[within], floor[within], color=GREY, lw=1.1, ls=(0, (4, 2)))
        axes.plot(3.7, 50, "^", color=RED, ms=7)
        axes.plot([3.7], [10], "s", color=RED, ms=6)
        axes.plot([0.5, 2.5], [2, 2], color=RED, lw=3)
        label(axes, 2.7, 42, "no brake", INK, ha="right")
        label(axes, 1.5, 20, "full vacuum, 94.5 kPa", BLUE)
        label(axes, 3.62, 21, "out of travel", BLUE, ha="right")
        label(axes, 2.2, 11.8, "tuned for 40 mm", GREEN, ha="right")
        label(axes, 2.62, 5.4, "least possible, 1 + v²/2gz", GREY)
        label(axes, 3.62, 50, "paper: 50 g", RED, ha="right")
        label(axes, 3.62, 9.2, "paper: about a fifth", RED, ha="right")
        label(axes, 0.5, 3.4, "paper: under 2 g", RED)
        axes.set(xlabel="speed at impact [m/s]", ylabel="peak acceleration [g]")
        axes.set(xlim=(0, 3.8), ylim=(0, 54))
        title(
            axes, "Fig. 11 from the model", "1 kg on the inferred rope; the paper's claims in red"
        )
    return figure
