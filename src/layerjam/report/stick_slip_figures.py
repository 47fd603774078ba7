"""A pull that sticks and slips."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layerjam.report.style import BLUE, GREY, ORANGE, RED, canvas, label, look, save, title
from layerjam.simulate.stick_slip import StickSlipRecord, bounds_at, slide_of
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["save", "stick_slip"]
MM = 1e3
DARK_ORANGE = "#8a5f00"


def stick_slip(record: StickSlipRecord) -> Figure:
    """Force over elongation between its bounds, and the last slip in slow motion."""
    brake = record.brake.brake
    at = slide_of(
        brake, vacuum=record.vacuum, speed=record.speed, mass=record.mass,
        stiffness=record.stiffness, stribeck=record.stribeck, frozen=True, slip=record.slip,
    )  # fmt: skip
    static, kinetic = bounds_at(at)
    u = record.elongation * MM
    with look():
        figure, (whole, one) = canvas(columns=2, width=9.2, height=3.8, width_ratios=(1.7, 1))
        whole.plot(u, static, color=RED, lw=1.1, ls=(0, (4, 2)))
        whole.plot(u, kinetic, color=GREY, lw=1.1, ls=(0, (4, 2)))
        whole.plot(u, record.force, color=BLUE, lw=1.3)
        top = float(max(static.max(), record.force.max()))
        whole.set(xlabel="elongation [mm]", ylabel="force [N]", xlim=(0, float(u[-1]) or 1.0))
        whole.set_ylim(0, top * 1.18)
        # where no curve lies: left of the first slip, or behind a swing that has died
        end, x, side = (0, 0.01, "left") if len(record.events) else (-1, 1.0, "right")
        label(whole, x * u[-1], float(static[end]) + 0.05 * top, "static bound", RED, ha=side)
        label(whole, x * u[-1], float(kinetic[end]) + 0.05 * top, "kinetic", GREY, ha=side)
        words = f"simulated; {show(record.vacuum, 'Pa')}, {show(record.speed, 'm/s')}, "
        words += f"{show(record.mass, 'kg')} on {show(record.stiffness, 'N/m')}"
        title(whole, f"{record.brake.name}: {record.outcome}", words)
        _one_slip(one, record)
    return figure


def _one_slip(axes: Axes, record: StickSlipRecord) -> None:
    """The last event against time, or how the motion settles."""
    if len(record.events):
        start, end = float(record.events.break_time[-1]), float(record.events.stick_time[-1])
        room = 0.25 * (end - start)
        start, end, what = start - room, end + room, "The last slip in slow motion"
    else:
        moving = np.flatnonzero(record.sliding)
        start = float(record.time[moving[0]]) if len(moving) else 0.0
        end, what = float(record.time[-1]), "From the first slip on"
    # straight between samples while stuck; dense while it slides
    grid = np.linspace(start, end, 500)
    force, pace = (np.interp(grid, record.time, a) for a in (record.force, record.speed_of_mass))
    times = (grid - start) * 1e3
    axes.plot(times, force, color=BLUE)
    axes.set(xlabel="time [ms]", ylabel="force [N]", xlim=(0, float(times[-1]) or 1.0))
    axes.set_ylim(0, float(force.max()) * 1.25 or 1.0)
    twin = axes.twinx()
    twin.plot(times, pace, color=ORANGE, lw=1.4)
    twin.set_ylabel("speed of the sheets [m/s]", color=DARK_ORANGE)
    twin.set_ylim(0, max(float(pace.max()) * 1.25, 1e-9))
    twin.grid(False)
    slips = len(record.events) > 0
    spots = (5, int(np.argmax(pace))) if slips else (470, 470)
    for on, values, place, up, word, color in (
        (axes, force, spots[0], 6 if slips else -14, "force", BLUE),
        (twin, pace, spots[1], 6, "speed", DARK_ORANGE),
    ):
        on.annotate(
            word, (times[place], values[place]), xytext=(2, up), textcoords="offset points",
            color=color, ha="left" if place < 100 else "center", fontsize=8.8,
        )  # fmt: skip
    title(axes, what, "sheets stick, slip, stick" if slips else "the swing dies away")
