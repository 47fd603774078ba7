"""Figures of stops: one drop, and Fig. 11 of the paper."""

from __future__ import annotations

from typing import Any

import numpy as np

from layerjam.device.load import load
from layerjam.mechanics.pull import peak
from layerjam.mechanics.stop.exact import BOTTOMED_OUT, stop
from layerjam.mechanics.stop.tune import tuned_vacuum
from layerjam.report import style
from layerjam.report.style import BLUE, GREEN, GREY, INK, MM, MS, RED
from layerjam.simulate.crash import Crash
from layerjam.simulate.drop import spring_of
from layerjam.simulate.record import DropRecord
from layerjam.simulate.rope_alone import BareDrop
from layerjam.units import show

save = style.save
SLIP = 0.040


@style.styled
def drop(record: DropRecord, crash: Crash | None = None) -> style.Figure:
    """Force and speed over time, and force over the displacement of the mass.

    What comes after the end of the travel, at a rigid end, is dotted.
    """
    time, top = record.time * MS, int(np.argmax(record.force))
    most = max(float(record.force.max()), 0.0 if crash is None else crash.peak_force)
    high = most * 1.18 or 1.0
    figure, (force, speed, work) = style.canvas(columns=3, width=11.4, height=3.5)
    force.plot(time, record.force, color=BLUE)
    force.set(xlabel="time [ms]", ylabel="force [N]", xlim=(0, None), ylim=(0, high))
    if crash is None:
        style.spot(force, time[top], record.force[top], show(float(record.force[top]), "N"))
    speed.plot(time, record.speed_of_mass, color=BLUE)
    speed.set(xlabel="time [ms]", ylabel="speed of the mass [m/s]", xlim=(0, None), ylim=(0, None))
    style.band(work, record.travel * MM, 0, record.force, BLUE, 0.15)
    work.plot(record.travel * MM, record.force, color=BLUE)
    work.set(xlabel="displacement of the mass [mm]", ylabel="force [N]", ylim=(0, high))
    if crash is not None:
        how: dict[str, Any] = {"color": RED, "ls": style.DOTTED}
        force.plot(crash.time * MS, crash.force, **how)
        speed.plot(crash.time * MS, crash.speed, **how)
        work.plot(crash.travel * MM, crash.force, **how)
        top = int(np.argmax(crash.force))
        style.spot(force, crash.time[top] * MS, crash.peak_force)
        said = f"dotted: the crash, up to {show(crash.peak_force, 'N')}"
        style.key(force, (said, RED), at="upper left", handlelength=0)
    words = f"simulated; {show(record.mass, 'kg')} at {show(record.speed, 'm/s')}, "
    style.title(force, f"{record.brake.name}: {record.outcome}", words + show(record.vacuum, "Pa"))
    style.title(speed, "Speed")
    style.panel(work, "Work", xlim=(0, None))
    return figure


@style.styled
def bare(record: BareDrop) -> style.Figure:
    """Force of the rope over time and over the displacement of a mass without a brake."""
    taut = record.time >= 0
    time, force = record.time[taut] * MS, record.force[taut]
    top = int(np.argmax(force))
    figure, (course, work) = style.canvas(columns=2, width=8.4, height=3.5)
    high = float(force.max()) * 1.18 or 1.0
    course.plot(time, force, color=BLUE)
    course.set(xlabel="time [ms]", ylabel="force [N]", xlim=(0, None), ylim=(0, high))
    style.spot(course, time[top], force[top], show(float(force[top]), "N"))
    work.plot(record.travel[taut] * MM, force, color=BLUE)
    work.set(xlabel="displacement of the mass [mm]", ylabel="force [N]", ylim=(0, high))
    style.title(course, "No brake", f"simulated; {show(record.mass, 'kg')} on the rope alone")
    style.panel(work, "Work", xlim=(0, None))
    return figure


@style.styled
def fig11() -> style.Figure:
    """Peak acceleration over the speed of impact: no brake, full vacuum, tuned vacuum."""
    brake = load("choi2018-kapton").brake
    rope = float(brake.rope.stiffness) if brake.rope is not None else np.inf
    g, full = brake.site.gravity, 94.5e3
    spring = spring_of(brake, rope)
    speed = np.linspace(0.02, 3.7, 370)
    bare = 1 + np.sqrt(1 + rope * speed**2 / g**2)
    run = stop(1.0, speed, full, spring, g, brake)
    hard, out = np.asarray(run.peak_force) / g, np.asarray(run.outcome) == BOTTOMED_OUT
    vacuum = np.asarray(tuned_vacuum(1.0, speed, SLIP, spring, g, brake))
    within = np.isfinite(vacuum) & (vacuum <= full)
    soft = np.asarray(peak(np.where(within, vacuum, full), 0.06, brake).force) / g
    floor = 1 + speed**2 / (2 * g * (SLIP + soft * g / spring))
    figure, (axes,) = style.canvas(width=7.6, height=4.8)
    axes.plot(speed, bare, color=INK, label="no brake")
    axes.plot(speed[~out], hard[~out], color=BLUE, label="full vacuum, 94.5 kPa")
    axes.plot(speed[out], hard[out], color=BLUE, ls=style.DOTTED, label="out of travel")
    axes.plot(speed[within], soft[within], color=GREEN, label="tuned for 40 mm")
    (least,) = axes.plot(speed[within], floor[within], color=GREY, lw=1.1, ls=style.DASHED)
    least.set_label("least possible, 1 + v²/2gz")
    axes.plot([0.5, 2.5], [2, 2], color=RED, lw=3)
    axes.set(xlabel="speed at impact [m/s]", ylabel="peak acceleration [g]")
    axes.set(xlim=(0, 3.8), ylim=(0, 54))
    style.spot(axes, 3.7, 50, "paper: 50 g", shape="^")
    style.spot(axes, 3.7, 10, "paper: about a fifth", shape="s")
    style.label(axes, 0.5, 3.9, "paper: under 2 g", RED)
    style.key(axes, at="upper left")
    style.title(axes, "Fig. 11 from the model", "1 kg on the inferred rope; the paper's in red")
    return figure
