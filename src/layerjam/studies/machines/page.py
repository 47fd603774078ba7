"""A machine's result as a complete folder: report.html, results.json and figures.

The figures show the effect on the person and the decisive quantity.
"""

import functools
import math
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from layerjam._version import __version__
from layerjam.core.command.declare import Progress
from layerjam.core.command.wording import format_words
from layerjam.core.drawing import style
from layerjam.core.drawing.folder import figure_files, write_folder
from layerjam.core.drawing.page import NONE, Page, Part, Picture, Table, Word, draw_all, to_html
from layerjam.core.drawing.style import BLUE, FAINT, GREEN, GREY, INK, KN, KPA, MM, MS, ORANGE, RED
from layerjam.core.units import get, show
from layerjam.studies.machines import ankle_clutch, neck_guard, rehabilitation, seat_belt
from layerjam.studies.machines.ankle_clutch import RATES
from layerjam.studies.machines.rehabilitation import SPEEDS
from layerjam.studies.machines.scenario import load_kind
from layerjam.studies.machines.verdict import Result

G = 9.80665
RADIANS = "[1000 rad/s²]"
_LINES = ((BLUE, 2.2), (GREY, 1.3), (GREEN, 1.6))
"""Line styles for brakes, webbing alone and limiter."""


def draw_pictures(result: Result) -> list[Picture]:
    """Return the pictures of a machine's page, in order."""
    return [
        Picture(name=name, figure=functools.partial(PICTURES[name], result), caption=caption)
        for name, caption in load_kind(result.scenario.machine)["pictures"].items()
    ]


@style.use_style
def draw_belt_versus_time(result: Result) -> style.Figure:
    """Draw chest acceleration and displacement versus time for three kinds of restraint."""
    record: seat_belt.Record = result.record
    restraints, limits = record.held, get(result.scenario, "limits")
    figure, (left, right) = style.make_axes(columns=2, width=10.6, height=4.3)
    time = restraints[0].ride.time * MS
    left.plot(time, record.drive / G, color=FAINT, lw=1.4, label="vehicle")
    for curve, (color, width) in zip(restraints, _LINES, strict=True):
        left.plot(time, curve.chest / G, color=color, lw=width, label=curve.name)
        right.plot(time, curve.ride.way * MM, color=color, lw=width)
    turns = [float(time[int(np.argmax(curve.ride.way))]) for curve in restraints]
    end = 1.3 * max(*turns, float(time[int(np.flatnonzero(record.drive)[-1])]))
    top = max(*(float(curve.chest.max()) for curve in restraints), float(record.drive.max())) / G
    limit = limits.chest / G
    detail = f"allowed: {limit:.3g} g, off the chart"
    if limit < 1.8 * top:
        top, detail = max(top, limit), "grey: deceleration of the vehicle itself"
        style.mark_y(left, limit, "allowed")
    left.set(xlim=(0, end), ylim=(0, 1.45 * top))
    left.set(xlabel="time [ms]", ylabel="chest acceleration [g]")
    style.add_key(left, loc="upper right")
    style.add_title(left, "Load on the chest", detail)
    longest = max(*(float(curve.ride.way.max()) for curve in restraints), limits.space)
    right.set(xlim=(0, end), ylim=(0, 1.25 * MM * longest))
    right.set(xlabel="time [ms]", ylabel="chest displacement in the vehicle [mm]")
    style.mark_y(right, limits.space * MM, "available space")
    style.add_title(right, "Displacement", "in the vehicle, from the start of the crash")
    return figure


@style.use_style
def draw_belt_versus_displacement(result: Result) -> style.Figure:
    """Draw the force in the belt versus the displacement of the chest."""
    record: seat_belt.Record = result.record
    figure, (axes,) = style.make_axes(width=6.8, height=4.3)
    for curve, (color, width) in zip(record.held, _LINES, strict=True):
        end = int(np.argmax(curve.ride.way)) + 1
        force = curve.ride.force[:end] * KN
        axes.plot(curve.ride.way[:end] * MM, force, color=color, lw=width, label=curve.name)
    longest = max(float(curve.ride.way.max()) for curve in record.held)
    force = max(float(curve.ride.force.max()) for curve in record.held)
    limits = get(result.scenario, "limits")
    axes.set(xlim=(0, 1.15 * MM * max(longest, limits.space)), ylim=(0, 1.35 * KN * force))
    axes.set(xlabel="chest displacement in the vehicle [mm]")
    axes.set_ylabel("belt force [kN]")
    style.mark_y(axes, limits.belt * KN, "allowed", share=0.5)
    style.mark_x(axes, limits.space * MM, "space", RED, share=0.03)
    style.add_key(axes, loc="upper left")
    style.add_title(axes, "Force versus displacement", "up to the maximum displacement; unfiltered")
    return figure


@style.use_style
def draw_neck_versus_time(result: Result) -> style.Figure:
    """Draw angular acceleration and velocity versus time."""
    record: neck_guard.Record = result.record
    free, guard = record.turned
    time, case = free.ride.time * MS, result.scenario
    limit = get(case, "limits.acceleration") / 1e3
    figure, (left, right) = style.make_axes(columns=2, width=10.6, height=4.1)
    for turn, color, width in ((free, GREY, 1.6), (guard, BLUE, 2.0)):
        left.plot(time, turn.angular / 1e3, color=color, lw=width, label=turn.name)
        right.plot(time, turn.ride.speed / get(case, "guard.lever"), color=color, lw=width)
    for axes in (left, right):
        axes.set(xlim=(0, float(time[-1])), xlabel="time [ms]")
    high = 1.35 * max(free.acceleration / 1e3, limit)
    left.set_ylim(min(-0.4, float(guard.angular.min()) / 1e3 * 1.2), high)
    left.set_ylabel(f"angular acceleration {RADIANS}")
    right.set_ylabel("angular velocity [rad/s]")
    style.mark_y(left, limit, "allowed", share=0.99)
    style.add_key(left, loc="upper right")
    detail = (
        f"peak {free.acceleration:.0f} rad/s² free, {guard.acceleration:.0f} rad/s² with brakes"
    )
    style.add_title(left, "Acceleration of the head", detail)
    detail = f"BrIC {free.bric:.2f} free, {guard.bric:.2f} with brakes"
    style.add_title(right, "Velocity of the head", detail)
    return figure


@style.use_style
def draw_neck_versus_count(result: Result) -> style.Figure:
    """Draw the peak acceleration versus the number of brakes."""
    record: neck_guard.Record = result.record
    have, free = result.scenario.brakes.parallel, record.turned[0].acceleration / 1e3
    limit = get(result.scenario, "limits.acceleration") / 1e3
    counts, turns = record.tried.parallel.to_numpy(), record.tried.turns.to_numpy() / 1e3
    figure, (axes,) = style.make_axes(width=6.8, height=3.9)
    axes.plot(counts, turns, color=BLUE)
    style.set_log_scale(axes)
    axes.set(xlim=(1, float(counts[-1])), ylim=(0, 1.25 * max(free, limit)))
    axes.set(xlabel="number of brakes in parallel")
    axes.set_ylabel(f"maximum angular acceleration {RADIANS}")
    style.mark_y(axes, free, "free", GREY, share=0.99)
    style.mark_y(axes, limit, "allowed", below=True)
    style.add_point(axes, have, turns[have - 1], "this guard", BLUE)
    style.add_title(
        axes, "More brakes", "jammed before the blow, in series with the scenario's straps"
    )
    return figure


@style.use_style
def draw_ankle_stride(result: Result) -> style.Figure:
    """Draw angle, force and holding force along a stride."""
    record: ankle_clutch.Record = result.record
    stride, ready = record.stride, record.ready
    part, top = record.part * 100, float(ready.force.max())
    figure, (upper, lower) = style.make_axes(
        rows=2, width=7.4, height=5.6, sharex=True, height_ratios=(1, 1.6)
    )
    upper.plot(part, np.degrees(record.angle), color=INK)
    upper.set_ylabel("ankle [degrees]")
    for axes in (upper, lower):
        axes.axvspan(record.window[0] * 100, record.window[1] * 100, color=FAINT, alpha=0.3)
    style.add_title(upper, "One stride", "shaded: the clutch must hold; dorsiflexion is positive")
    lower.plot(part, ready.force, color=GREEN, ls=style.DASHED, label="if evacuated from the start")
    lower.plot(part, stride.hold, color=ORANGE, lw=1.6, label="holding capacity")
    lower.plot(part, stride.force, color=BLUE, lw=2.2, label="actual force")
    lower.set(ylim=(0, 1.35 * top), xlim=(float(part[0]), float(part[-1])), ylabel="force [N]")
    lower.set_xlabel("fraction of the stride after heel strike [%]")
    style.add_key(lower, loc="upper left")
    return figure


@style.use_style
def draw_ankle_rates(result: Result) -> style.Figure:
    """Draw the slip versus the stride rate."""
    record: ankle_clutch.Record = result.record
    rate, fastest = result.own["stride_rate"], result.own["fastest_stride_rate"]
    figure, (axes,) = style.make_axes(width=6.8, height=3.9)
    axes.plot(RATES, record.slips * MM, color=BLUE)
    style.set_log_scale(axes)
    axes.set(xlabel="stride rate [Hz]", ylabel="slip per stride [mm]")
    axes.set(xlim=(RATES[0], RATES[-1]), ylim=(0, 1.2 * MM * record.slips.max()))
    style.mark_y(axes, get(result.scenario, "limits.slip") * MM, "allowed")
    style.mark_x(axes, rate, "walking")
    detail = (
        f"holds up to {fastest:.3g} strides per second"
        if fastest
        else ("slips at every rate tried")
    )
    style.add_title(axes, "Stride rate that the vacuum follows", detail)
    return figure


@style.use_style
def draw_exercise_versus_time(result: Result) -> style.Figure:
    """Draw torque and vacuum versus time."""
    record: rehabilitation.Record = result.record
    session, vacuum = record.session, record.followed.loop
    figure, (upper, lower) = style.make_axes(
        rows=2, width=8.4, height=5.2, sharex=True, height_ratios=(1.7, 1)
    )
    flexion_torque = np.where(session.flexing, session.torque, np.nan)
    upper.plot(
        session.time, flexion_torque, color=GREEN, lw=2.6, alpha=0.7, label="target in flexion"
    )
    upper.plot(session.time, record.given, color=INK, lw=1.2, label="actual torque")
    top = 1.35 * float(session.torque.max())
    upper.set(ylim=(0, top), ylabel="torque [N m]", xlim=(0, float(session.time[-1])))
    detail = "the torque during extension is not drawn"
    style.add_title(upper, "Resistance in flexion", detail)
    target = vacuum.target * KPA
    lower.plot(session.time, target, color=GREEN, lw=1.1, ls=style.DASHED, label="target")
    lower.plot(session.time, vacuum.vacuum * KPA, color=BLUE, lw=1.4, label="in the brakes")
    lower.set(xlabel="time [s]", ylabel="vacuum [kPa]", ylim=(0, 1.5 * float(target.max())))
    for axes in (upper, lower):
        style.add_key(axes, loc="upper left", ncols=2)
    return figure


@style.use_style
def draw_exercise_versus_angle(result: Result) -> style.Figure:
    """Draw torque versus angle, and the fraction that can be followed versus speed."""
    record: rehabilitation.Record = result.record
    session, (grid, reach) = record.session, record.reachable
    edges = np.flatnonzero(np.diff(session.flexing.astype(int), prepend=0, append=0))
    first = slice(int(edges[0]), int(edges[1]))
    angle, grid = np.degrees(session.angle[first]), np.degrees(grid)
    top = 1.25 * max(float(session.torque.max()), float(reach.max()))
    figure, (left, right) = style.make_axes(columns=2, width=10.6, height=4.1)
    style.add_band(left, grid, reach, top, RED, 0.10)
    left.plot(grid, reach, color=RED, lw=1.3, label="maximum torque")
    left.plot(angle, session.torque[first], color=GREEN, lw=2.6, alpha=0.7, label="target")
    left.plot(angle, record.given[first], color=INK, lw=1.2, label="actual torque")
    left.set(xlim=(angle[0], angle[-1]), ylim=(0, top))
    left.set(xlabel="flexion [degrees]", ylabel="torque [N m]")
    style.add_key(left)
    style.add_title(left, "Torque versus angle", "first flexion; red: beyond full vacuum")
    speeds = np.degrees(SPEEDS)
    right.plot(speeds, record.shares * 100, color=BLUE)
    style.set_log_scale(right)
    right.set(ylim=(0, 108), xlabel="mean speed of flexion [degrees/s]")
    right.set_ylabel("fraction followed [% of the flexion]")
    right.set_xlim(float(speeds[0]), float(speeds[-1]))
    style.mark_y(right, get(result.scenario, "limits.followed") * 100, "minimum", below=True)
    style.mark_x(right, math.degrees(get(result.scenario, "exercise.speed")), "asked", share=0.03)
    fastest = math.degrees(result.own["fastest_speed"])
    style.add_title(
        right, "Coverage versus speed", f"up to {show(fastest, '1', 3)} degrees per second"
    )
    return figure


PICTURES: dict[str, Callable[[Result], style.Figure]] = {
    "seat-belt-time": draw_belt_versus_time,
    "seat-belt-force": draw_belt_versus_displacement,
    "neck-guard-time": draw_neck_versus_time,
    "neck-guard-count": draw_neck_versus_count,
    "ankle-clutch-stride": draw_ankle_stride,
    "ankle-clutch-rate": draw_ankle_rates,
    "rehabilitation-time": draw_exercise_versus_time,
    "rehabilitation-angle": draw_exercise_versus_angle,
}
"""{picture: function that draws it}; the machine's kind sets captions and order."""


MET = Word("✓ met", "verdict reproduced")
MISSED = Word("≠ missed", "verdict differs")


def write_page(result: Result, values: str, out: Path, progress: Progress) -> Path:
    """Write the folder and return the path of the page. `values` is the text of results.json."""
    page = make_page(result)
    svgs = draw_all(page.pictures(), progress)
    content = {"report.html": to_html(page.template_data(), svgs), "results.json": values + "\n"}
    write_folder(out, content | figure_files(svgs))
    return out / "report.html"


def make_page(result: Result) -> Page:
    """Return the page of a machine."""
    scenario, met = result.scenario, sum(limit.is_met for limit in result.limits)
    feasible = Word("✓ feasible", "reproduced"), Word("≠ not feasible", "differs")
    count = "none is sufficient" if result.brakes_needed is None else str(result.brakes_needed)
    return Page(
        title=f"{scenario.name}: {scenario.title}" if scenario.title else scenario.name,
        lead=f"A machine of Choi et al. 2018, Fig. 13, with brakes {scenario.brake.name}, computed "
        "from a model; nothing here was measured.",
        verdicts=[feasible[not result.feasible]],
        banner=[result.verdict],
        numbers=[
            (show(result.mass, "kg"), "mass of the brakes of this scenario"),
            (count, "brakes required"),
            (f"{met} of {len(result.limits)}", "limits met"),
        ],
        parts=_make_parts(result),
        footer=f"layerjam {__version__}, {datetime.now(UTC).date().isoformat()}",
    )


def _make_parts(result: Result) -> list[Part]:
    limits = [
        [
            Word(limit.name, "claim"),
            Word(show(limit.value, limit.unit), "value"),
            "at least" if limit.least else "at most",
            Word(show(limit.limit, limit.unit), "value"),
            MET if limit.is_met else MISSED,
        ]
        for limit in result.limits
    ]
    units = result.own_units
    rows = [
        [
            name.replace("_", " "),
            NONE if value is None else format_words(value, units.get(name, "")),
        ]
        for name, value in result.own.items()
    ]
    cited = [
        [Word(path, "claim"), Word(value, "words"), Word(source, "why")]
        for path, value, source in result.scenario.list_sources()
    ]
    head = ["what", "value", "", "allowed", "verdict"]
    sources = Table(id="sources-table", head=["entry", "value", "source"], rows=cited)
    every = Table(id="results-table", head=["quantity", "value"], rows=rows)
    notes = [*result.warnings, *result.scenario.warnings()]
    return [
        Part(
            id="limits", title="Limits", tables=[Table(id="limits-table", head=head, rows=limits)]
        ),
        Part(id="pictures", title="Pictures", pictures=draw_pictures(result)),
        Part(id="results", title="All results", tables=[every]),
        Part(id="notes", title="Notes", text=list(dict.fromkeys(notes))),
        Part(id="sources", title="Source of every number", tables=[sources]),
    ]
