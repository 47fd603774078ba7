"""Figures of computed pulls: steady ones, those of arrays, and those with stick–slip."""

from dataclasses import replace
from typing import Any

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.figures.titles import record_title
from layerjam.brake.mechanics.bending import (
    buckling_moment,
    slip_moment,
    turning_moment,
    turning_stiffness_free,
)
from layerjam.brake.mechanics.enclosure import enclosure_force
from layerjam.brake.mechanics.friction import sheet_friction
from layerjam.brake.mechanics.joint import joint_friction
from layerjam.brake.mechanics.pull import brake_force
from layerjam.brake.simulate.prediction import Prediction
from layerjam.brake.simulate.pull_spread import find_pull_band
from layerjam.brake.simulate.record import TensileRecord
from layerjam.brake.simulate.stick_slip import StickSlipRecord, force_bounds
from layerjam.core.drawing import style
from layerjam.core.drawing.chart import Curve, Pane, dash_untested, draw_pane
from layerjam.core.drawing.style import BLUE, GREY, INK, KPA, MM, MS, ORANGE, RED
from layerjam.core.units import show


def pull_panes(record: Any, headline: str, detail: str, x: str = "elongation [mm]") -> list[Pane]:
    """Return the pane of force versus elongation of any record that has both, with its peak."""
    top = int(np.argmax(record.force))
    force, elongation = float(record.force[top]), float(record.elongation[top])
    peak = elongation * MM, force, f"{show(force, 'N')} at {show(elongation, 'm')}", RED
    curve, high = Curve(record.elongation * MM, record.force), (0, force * 1.18 + 1e-9)
    options: dict[str, Any] = {
        "headline": headline,
        "detail": detail,
        "y_range": high,
        "marks": [peak],
    }
    return [Pane([curve], x, "force [N]", **options)]


def tensile_panes(record: TensileRecord) -> list[Pane]:
    """Return the pane of force versus elongation of a simulated pull."""
    detail = f"simulated, {record.model}: {_shorten_procedure(record.procedure)}"
    (pane,) = pull_panes(record, record_title(record), detail, "elongation at the crosshead [mm]")
    band = find_pull_band(record)
    if band is None:
        return [pane]
    low, high = (Curve(band.elongation * MM, end, GREY) for end in (band.low, band.high))
    top = max(float(pane.y_range[1] or 0.0), 1.1 * float(np.nanmax(band.high)))
    curves = dash_untested(pane.curves[0], band.tested_end * MM)
    words = f"{pane.detail}; band: 95 %"
    return [replace(pane, curves=curves, bands=[(low, high)], y_range=(0, top), detail=words)]


def _shorten_procedure(text: str, longest: int = 58) -> str:
    """Return the first steps of a procedure, as many as fit, and the number of the others."""
    steps = text.split("; ")
    fitting = max(int(np.sum(np.cumsum([len(step) + 2 for step in steps]) <= longest)), 1)
    others = len(steps) - fitting
    return "; ".join([*steps[:fitting], *[f"and {others} more"] * (others > 0)])


def bounds_panes(record: StickSlipRecord) -> list[Pane]:
    """Return the pane of force versus elongation with the bounds of the stick–slip."""
    static, kinetic = force_bounds(record.freeze_friction(record.slip))
    u = record.elongation * MM
    curves = [
        Curve(u, record.force, width=1.5),
        Curve(u, static, RED, "static bound", "dashed", 1.2),
        Curve(u, kinetic, GREY, "kinetic", "dashed", 1.2),
    ]
    words = f"simulated; {show(record.vacuum, 'Pa')}, {show(record.speed, 'm/s')}, "
    words += f"{show(record.mass, 'kg')} on {show(record.stiffness, 'N/m')}"
    ends = (0, float(u[-1]) or 1.0), (0, float(max(static.max(), record.force.max())) * 1.15)
    title = record_title(record)
    return [Pane(curves, "elongation [mm]", "force [N]", *ends, headline=title, detail=words)]


@style.use_style
def draw_stick_slip(record: StickSlipRecord, pane: Pane) -> style.Figure:
    """Draw force versus elongation with the stick–slip bounds, and the last slip enlarged."""
    figure, (full, zoom) = style.make_axes(columns=2, width=9.6, height=3.8, width_ratios=(1.7, 1))
    draw_pane(full, pane)
    _draw_last_slip(zoom, record)
    return figure


def _draw_last_slip(axes: style.Axes, record: StickSlipRecord) -> None:
    """Draw the last slip versus time or, if there is none, the start of steady sliding."""
    if len(record.events):
        start, end = float(record.events.break_time[-1]), float(record.events.stick_time[-1])
        margin = 0.25 * (end - start)
        start, end, headline = start - margin, end + margin, "The last slip in slow motion"
        detail = "sheets stick, slip, stick"
    else:
        moving = np.flatnonzero(record.sliding)
        start = float(record.time[moving[0]]) if len(moving) else 0.0
        end, headline = float(record.time[-1]), "From the first slip onwards"
        detail = "the oscillation decays"
    # the curve is straight while stuck, and has dense samples while sliding
    grid = np.linspace(start, end, 500)
    force, pace = (np.interp(grid, record.time, a) for a in (record.force, record.speed_of_mass))
    times = (grid - start) * MS
    axes.plot(times, force, color=BLUE)
    axes.set(xlabel="time [ms]", ylabel="force [N]", xlim=(0, float(times[-1]) or 1.0))
    axes.set_ylim(0, float(force.max()) * 1.3 or 1.0)
    twin = axes.twinx()
    twin.plot(times, pace, color=ORANGE, lw=1.4)
    twin.set_ylabel("sheet speed [m/s]", color=style.text_ink(ORANGE))
    twin.set_ylim(0, max(float(pace.max()) * 1.3, 1e-9))
    twin.grid(False)
    style.add_key(axes, ("force", BLUE), ("speed", ORANGE), loc="upper left", ncols=2)
    style.add_title(axes, headline, detail)


@style.use_style
def draw_bend(
    file: BrakeFile, vacuum: float, angle: float, slip: float, radius: float | None
) -> style.Figure:
    """Draw moment versus angle, jammed and free, and the sheets' friction versus joint angle."""
    columns = 1 if radius is None else 2
    figure, (turn, *pull) = style.make_axes(columns=columns, width=5.6 * columns, height=3.9)
    _draw_moment(turn, file, vacuum, angle, slip)
    if radius is not None:
        _draw_sheet_friction(pull[0], file, vacuum, angle, slip, radius)
    return figure


def _draw_moment(
    axes: style.Axes, file: BrakeFile, vacuum: float, limit: float, slip: float
) -> None:
    brake, milli = file.brake, 1e3
    angle = np.linspace(0, 1.25 * limit, 400)
    moment = np.asarray(turning_moment(angle, slip, vacuum, brake)) * milli
    free = float(turning_stiffness_free(slip, brake)) * angle * milli
    friction = float(slip_moment(slip, vacuum, brake)) * milli
    top, degrees = float(max(moment.max(), free.max())) * 1.3, np.degrees(angle)
    axes.plot(degrees, friction + free, color=GREY, lw=1.1, ls=style.DASHED)
    axes.plot(degrees, moment, color=BLUE)
    axes.plot(degrees, free, color=INK)
    axes.set(xlabel="angle between the caps [°]", ylabel="moment [mN m]")
    axes.set(xlim=(0, float(degrees[-1])), ylim=(0, top))
    euler = float(buckling_moment(slip, brake)) * milli
    if euler < 0.9 * top:
        style.mark_y(axes, euler, "sheets buckle", share=0.98)
    names = (("jammed", BLUE), ("without vacuum", INK), ("all interfaces slip", GREY))
    style.add_key(axes, *names, loc="upper left", ncols=2)
    style.add_title(axes, f"{file.name}, bent", f"computed; {show(vacuum, 'Pa')}")


def _draw_sheet_friction(
    axes: style.Axes, file: BrakeFile, vacuum: float, limit: float, slip: float, radius: float
) -> None:
    brake = file.brake
    angle = np.linspace(0, 1.25 * limit, 400)
    friction, friction_free = (
        np.asarray(
            joint_friction(
                slip,
                pressure,
                angle,
                radius,
                float(enclosure_force(slip, pressure, brake)) / 2,
                brake,
            )
        )
        for pressure in (vacuum, 0.0)
    )
    degrees = np.degrees(angle)
    axes.plot(degrees, friction, color=BLUE)
    axes.plot(degrees, friction_free, color=INK)
    axes.set(xlabel="joint angle [°]", ylabel="sheet friction [N]")
    axes.set(xlim=(0, float(degrees[-1])), ylim=(0, float(friction.max()) * 1.3 or 1.0))
    force = float(np.interp(limit, angle, friction))
    style.add_point(axes, float(np.degrees(limit)), force, show(force, "N"), RED)
    style.add_key(axes, ("jammed", BLUE), ("without vacuum", INK), loc="upper left", ncols=2)
    style.add_title(axes, "Pulled over a joint", f"radius {show(radius, 'm')}")


@style.use_style
def plot_force_slip(file: BrakeFile, vacuum: float, slip: float) -> style.Figure:
    """Draw the sliding brake's force versus slip at one vacuum, divided into its components."""
    brake = file.brake
    x = np.linspace(0, brake.sheets.overlap, 400)
    sheets, total = (np.asarray(law(x, vacuum, brake)) for law in (sheet_friction, brake_force))
    figure, (axes,) = style.make_axes()
    style.add_band(axes, x * MM, 0, sheets, BLUE, 0.16)
    style.add_band(axes, x * MM, sheets, total, ORANGE, 0.35)
    prediction = Prediction(file, vacuum, x)
    ends = prediction.interval(brake_force(x, vacuum, prediction.brakes))
    low, high = (np.nan_to_num(ends[end]) for end in ("low", "high"))
    style.add_band(axes, x * MM, low, high, GREY, 0.35)
    # dashed outside the tested range
    is_tested = prediction.is_tested() & np.isfinite(total)
    axes.plot(x * MM, total, color=INK, ls=style.DASHED, lw=1.1)
    axes.plot(x * MM, np.where(is_tested, total, np.nan), color=INK)
    top = 1.3 * float(max(total.max(), high.max())) or 1.0
    axes.set(xlabel="sheet slip [mm]", ylabel="force [N]", xlim=(0, None), ylim=(0, top))
    style.mark_x(axes, brake.sheets.usable_travel * MM, "usable travel")
    force = float(brake_force(slip, vacuum, brake))
    style.add_point(axes, slip * MM, force, show(force, "N"))
    names = (("sheets", BLUE), ("enclosure", ORANGE), ("95 % of tests", GREY))
    style.add_key(axes, *names, loc="upper left", ncols=3)
    style.add_title(axes, f"{file.name} sliding at {show(vacuum, 'Pa')}", "computed")
    return figure


@style.use_style
def plot_force_vacuum(file: BrakeFile, slip: float, target: float, vacuum: float) -> style.Figure:
    """Draw the force at one slip versus vacuum, with the target force."""
    brake = file.brake
    pressure = np.linspace(0, brake.site.atmosphere, 400)
    figure, (axes,) = style.make_axes()
    force = np.asarray(brake_force(slip, pressure, brake))
    axes.plot(pressure * KPA, force, color=BLUE)
    axes.set(xlabel="vacuum [kPa]", ylabel="force [N]", xlim=(0, None))
    axes.set_ylim(0, 1.12 * max(float(force.max()), target))
    style.mark_y(axes, target, f"required {show(target, 'N')}")
    if np.isfinite(vacuum):
        style.mark_x(axes, vacuum * KPA, show(vacuum, "Pa"), RED, share=0.03)
        style.add_point(axes, vacuum * KPA, target)
    style.add_title(axes, f"{file.name} at a slip of {show(slip, 'm')}", "computed")
    return figure
