"""Figures of stops: one drop, and Fig. 11 of the paper."""

from dataclasses import replace
from typing import Any

import numpy as np

from layerjam.brake.device.load import load
from layerjam.brake.figures.titles import drop_title
from layerjam.brake.mechanics.pull import peak
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, stop
from layerjam.brake.mechanics.stop.tune import tuned_vacuum
from layerjam.brake.simulate.crash import Crash
from layerjam.brake.simulate.drop import series_spring
from layerjam.brake.simulate.record import DropRecord
from layerjam.brake.simulate.rope_alone import BareDrop
from layerjam.core.drawing import style
from layerjam.core.drawing.chart import Curve, Ends, Pane
from layerjam.core.drawing.style import BLUE, GREEN, GREY, INK, MM, MS, RED
from layerjam.core.units import show

save = style.save
SLIP = 0.040
BAR = 0.01
"""Half of the width of a bar, relative to the time of the stop."""
TIME, FORCE = "time [ms]", "force [N]"


def drop_panes(record: DropRecord, crash: Crash | None = None) -> list[Pane]:
    """Draw force and speed versus time, and force versus the displacement of the mass.

    The part after the end of the travel, where the brake is rigid, is dotted.
    """
    time, travel = record.time * MS, record.displacement * MM
    courses = [[Curve(time, record.force)], [Curve(time, record.speed_of_mass)]]
    courses.append([Curve(travel, record.force)])
    top, words = int(np.argmax(record.force)), ""
    peak, peak_time = float(record.force[top]), time[top]
    if crash is not None:
        top, words = int(np.argmax(crash.force)), "crash: "
        peak, peak_time = float(crash.peak_force), crash.time[top] * MS
        xs = crash.time * MS, crash.time * MS, crash.displacement * MM
        ys = crash.force, crash.speed, crash.force
        for curves, x, y in zip(courses, xs, ys, strict=True):
            curves.append(Curve(x, y, RED, dash="dotted"))
    high = (0, 1.18 * max(peak, float(record.force.max())) or 1.0)
    mark = (peak_time, peak, words + show(peak, "N"), RED)
    options: dict[str, Any] = {
        "headline": drop_title(record),
        "detail": f"simulated; {record.brake.name}, {show(record.vacuum, 'Pa')}",
        "marks": [mark],
    }
    return [
        Pane(courses[0], TIME, FORCE, y_range=high, **options),
        Pane(courses[1], TIME, "speed of the mass [m/s]", headline="Speed"),
        _make_work_pane(courses[2], high),
    ]


def show_certainty(
    panes: list[Pane], peak: tuple[float | None, float | None], basis: str | None
) -> list[Pane]:
    """Return the panes of `drop_panes` with the 95 % interval of the peak force [N] as a bar.

    The curves are dashed if the basis is that the stop is outside the tested range.
    """
    if basis == "extrapolated":
        panes = [
            replace(pane, curves=[replace(pane.curves[0], dash="dashed"), *pane.curves[1:]])
            for pane in panes
        ]
    low, high = peak
    if low is None or high is None:
        return panes
    force = panes[0]
    # as wide as the point at the peak, because the band is not that of the whole curve
    x = force.marks[0][0] + BAR * np.array([-1.0, 1.0]) * force.curves[0].x[-1]
    edges = Curve(x, np.full(2, low), GREY), Curve(x, np.full(2, high), GREY)
    words = f"{force.detail} (bar: 95 % of peaks)"
    top = max(float(force.y_range[1] or 0.0), 1.1 * high)
    return [replace(force, bands=[edges], y_range=(0, top), detail=words), *panes[1:]]


def _make_work_pane(curves: list[Curve], high: Ends) -> Pane:
    """Return the pane of force versus displacement; the area below the first curve is the work."""
    ground = (replace(curves[0], y=0 * curves[0].y), curves[0])
    place = "displacement of the mass [mm]"
    return Pane(curves, place, FORCE, y_range=high, bands=[ground], headline="Work")


def rope_panes(record: BareDrop) -> list[Pane]:
    """Draw the rope's force versus time and versus displacement, for a mass without a brake."""
    taut = record.time >= 0
    time, force = record.time[taut] * MS, record.force[taut]
    top = int(np.argmax(force))
    high, peak = (0, float(force.max()) * 1.18 or 1.0), float(force[top])
    options: dict[str, Any] = {"detail": f"simulated; {show(record.mass, 'kg')} on the rope alone"}
    options |= {"headline": "No brake", "marks": [(time[top], peak, show(peak, "N"), RED)]}
    return [
        Pane([Curve(time, force)], TIME, FORCE, y_range=high, **options),
        _make_work_pane([Curve(record.displacement[taut] * MM, force)], high),
    ]


@style.use_style
def draw_fig11() -> style.Figure:
    """Draw peak acceleration versus impact speed: no brake, full vacuum, tuned vacuum."""
    brake = load("choi2018-kapton").brake
    rope = float(brake.rope.stiffness) if brake.rope is not None else np.inf
    g, full_vacuum = brake.site.gravity, 94.5e3
    spring = series_spring(brake, rope)
    speed = np.linspace(0.02, 3.7, 370)
    bare_peak = 1 + np.sqrt(1 + rope * speed**2 / g**2)
    run = stop(1.0, speed, full_vacuum, spring, g, brake)
    hard, out = np.asarray(run.peak_force) / g, np.asarray(run.outcome) == BOTTOMED_OUT
    vacuum = np.asarray(tuned_vacuum(1.0, speed, SLIP, spring, g, brake))
    is_tuned = np.isfinite(vacuum) & (vacuum <= full_vacuum)
    peak_g = np.asarray(peak(np.where(is_tuned, vacuum, full_vacuum), 0.06, brake).force) / g
    floor = 1 + speed**2 / (2 * g * (SLIP + peak_g * g / spring))
    figure, (axes,) = style.make_axes(width=7.6, height=4.8)
    axes.plot(speed, bare_peak, color=INK, label="no brake")
    axes.plot(speed[~out], hard[~out], color=BLUE, label="full vacuum, 94.5 kPa")
    axes.plot(speed[out], hard[out], color=BLUE, ls=style.DOTTED, label="out of travel")
    axes.plot(speed[is_tuned], peak_g[is_tuned], color=GREEN, label="tuned for 40 mm")
    (floor_line,) = axes.plot(speed[is_tuned], floor[is_tuned], color=GREY, lw=1.1, ls=style.DASHED)
    floor_line.set_label("lower bound, 1 + v²/2gz")
    axes.plot([0.5, 2.5], [2, 2], color=RED, lw=3)
    axes.set(xlabel="speed at impact [m/s]", ylabel="peak acceleration [g]")
    axes.set(xlim=(0, 3.8), ylim=(0, 54))
    style.add_point(axes, 3.7, 50, "paper: 50 g", shape="^")
    style.add_point(axes, 3.7, 10, "paper: about a fifth", shape="s")
    style.add_label(axes, 0.5, 3.9, "paper: under 2 g", RED)
    style.add_key(axes, loc="upper left")
    style.add_title(
        axes, "Fig. 11 from the model", "1 kg on the inferred rope; paper values in red"
    )
    return figure
