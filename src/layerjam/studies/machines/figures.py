"""Pictures of the four machines: what happens to the person, and what decides."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.report.page import Picture
from layerjam.report.style import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    INK,
    ORANGE,
    RED,
    canvas,
    label,
    look,
    title,
)
from layerjam.studies.machines import ankle_clutch, neck_guard, rehabilitation, seat_belt
from layerjam.studies.machines.verdict import Result
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

G = 9.80665
MS, MM, KN = 1e3, 1e3, 1e-3


def pictures(result: Result) -> list[Picture]:
    """The pictures of a machine's page, in order."""
    made: dict[str, Callable[[Result], list[Picture]]] = {
        "seat-belt": _belt, "neck-guard": _neck, "ankle-clutch": _ankle,
        "rehabilitation": _rehabilitation,
    }  # fmt: skip
    return made[result.scenario.machine](result)


def _limit(axes: Axes, value: float, text: str, at: float, *, below: bool = False) -> None:
    """A limit across the picture, named on its line at a part of the width."""
    axes.axhline(value, color=RED, lw=1.1, ls=(0, (5, 3)))
    axes.annotate(
        text, (at, value), xycoords=axes.get_yaxis_transform(),
        xytext=(0, -4 if below else 4), textcoords="offset points",
        va="top" if below else "bottom", color=RED, fontsize=8.8,
    )  # fmt: skip


def _belt(result: Result) -> list[Picture]:
    record: seat_belt.Record = result.record
    return [
        Picture(
            name="seat-belt-time",
            figure=lambda: belt_in_time(record),
            caption="The held part of the occupant in the vehicle's pulse: with the scenario's "
            "brakes, with webbing alone, and with the least load limiter of constant force that "
            "stops in the space. Acceleration behind the filter of SAE J211-1 of the scenario.",
        ),
        Picture(
            name="seat-belt-force",
            figure=lambda: belt_over_way(record),
            caption="Force in the belt over the chest's way. Behind the last brake's travel the "
            "belt holds on stops, and the force rises as that of webbing does.",
        ),
    ]


_HOW = ((BLUE, 2.2), (GREY, 1.3), (GREEN, 1.6))


def belt_in_time(record: seat_belt.Record) -> Figure:
    """Chest acceleration and way over time, three ways of holding."""
    with look():
        figure, (left, right) = canvas(columns=2, width=10.6, height=4.3)
        time = record.held[0].ride.time * MS
        left.plot(time, record.drive / G, color=FAINT, lw=1.4)
        turns = [float(time[int(np.argmax(one.ride.way))]) for one in record.held]
        end = 1.3 * max(*turns, float(time[int(np.flatnonzero(record.drive)[-1])]))
        for one, (color, width) in zip(record.held, _HOW, strict=True):
            left.plot(time, one.chest / G, color=color, lw=width)
            right.plot(time, one.ride.way * MM, color=color, lw=width)
        top = max(*(float(one.chest.max()) for one in record.held), float(record.drive.max())) / G
        near = record.limits.chest / G < 1.8 * top
        left.set(
            xlim=(0, end), ylim=(0, 1.25 * (max(top, record.limits.chest / G) if near else top))
        )
        left.set(xlabel="time [ms]", ylabel="acceleration of the chest [g]")
        if near:
            _limit(left, record.limits.chest / G, "allowed", 0.02)
        else:
            text = f"allowed: {record.limits.chest / G:.3g} g, above the picture"
            left.text(
                0.02, 0.975, text, color=RED, transform=left.transAxes, va="top", fontsize=8.8
            )
        _named(left, record, 0.985, "right")
        top_at = int(np.argmax(record.drive))
        label(
            left, float(time[top_at]) * 0.30, float(record.drive.max()) / G * 1.05, "vehicle", GREY
        )
        title(left, "What the chest feels", "grey: deceleration of the vehicle itself")
        ways = [float(one.ride.way.max()) for one in record.held]
        right.set(xlim=(0, end), ylim=(0, 1.25 * MM * max(*ways, record.limits.space)))
        right.set(xlabel="time [ms]", ylabel="way of the chest in the vehicle [mm]")
        _limit(right, record.limits.space * MM, "space there is", 0.02)
        title(right, "How far it is thrown", "in the vehicle, from the first instant")
    return figure


def _named(axes: Axes, record: seat_belt.Record, at: float, side: str) -> None:
    """The three ways by name, below one another at the top, at a part of the width."""
    for place, (one, (color, _)) in enumerate(zip(record.held, _HOW, strict=True)):
        axes.text(
            at, 0.975 - 0.062 * place, one.name, color=color, transform=axes.transAxes,
            ha=side, va="top", fontsize=8.8,
        )  # fmt: skip


def _plain(axes: Axes) -> None:
    """A logarithmic scale with plain numbers."""
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter("{x:g}")


def belt_over_way(record: seat_belt.Record) -> Figure:
    """Force in the belt over the chest's way."""
    with look():
        figure, (axes,) = canvas(width=6.8, height=4.3)
        for one, (color, width) in zip(record.held, _HOW, strict=True):
            to = int(np.argmax(one.ride.way)) + 1
            axes.plot(one.ride.way[:to] * MM, one.ride.force[:to] * KN, color=color, lw=width)
        ways = max(float(one.ride.way.max()) for one in record.held)
        force = max(float(one.ride.force.max()) for one in record.held)
        space = record.limits.space
        axes.set(xlim=(0, 1.15 * MM * max(ways, space)), ylim=(0, 1.3 * KN * force))
        axes.set(xlabel="way of the chest in the vehicle [mm]", ylabel="force in the belt [kN]")
        _limit(axes, record.limits.belt * KN, "allowed", 0.55)
        axes.axvline(space * MM, color=RED, lw=1.1, ls=(0, (5, 3)))
        axes.annotate(
            "space", (space * MM, 0.03), xycoords=axes.get_xaxis_transform(), rotation=90,
            xytext=(3, 0), textcoords="offset points", color=RED, fontsize=8.8,
        )  # fmt: skip
        _named(axes, record, 0.02, "left")
        title(axes, "Force over way", "up to the furthest point; not filtered")
    return figure


def _neck(result: Result) -> list[Picture]:
    record: neck_guard.Record = result.record
    return [
        Picture(
            name="neck-guard-time",
            figure=lambda: neck_in_time(record),
            caption="Angular acceleration and velocity of the helmeted head under the blow, free "
            "and with the scenario's brakes fully jammed before the blow, which is the best case.",
        ),
        Picture(
            name="neck-guard-count",
            figure=lambda: neck_over_count(record, result),
            caption="Greatest angular acceleration over the number of brakes side by side, behind "
            "the scenario's straps. Where it levels out, the straps are what is too soft.",
        ),
    ]


def neck_in_time(record: neck_guard.Record) -> Figure:
    """Angular acceleration and velocity over time."""
    with look():
        figure, (left, right) = canvas(columns=2, width=10.6, height=4.1)
        bare, held = record.turned
        time = bare.ride.time * MS
        for one, color, width in ((bare, GREY, 1.6), (held, BLUE, 2.0)):
            left.plot(time, one.acceleration / 1e3, color=color, lw=width)
            right.plot(time, one.ride.speed / record.lever, color=color, lw=width)
        left.set(xlim=(0, float(time[-1])), xlabel="time [ms]")
        left.set_ylabel("angular acceleration [1000 rad/s²]")
        high = max(bare.peak, record.limits.acceleration) / 1e3
        left.set_ylim(min(-0.4, float(held.acceleration.min()) / 1e3 * 1.2), 1.25 * high)
        _limit(left, record.limits.acceleration / 1e3, "allowed", 0.6)
        label(left, 0.55 * float(time[-1]), 1.15 * high, bare.name, GREY)
        label(left, 0.55 * float(time[-1]), 1.03 * high, held.name, BLUE)
        title(
            left,
            "The blow turns the head",
            f"peak {bare.peak:.0f} rad/s² free, {held.peak:.0f} rad/s² with brakes",
        )
        right.set(xlim=(0, float(time[-1])), xlabel="time [ms]", ylabel="angular velocity [rad/s]")
        title(right, "How fast it turns", f"BrIC {bare.bric:.2f} free, {held.bric:.2f} with brakes")
    return figure


def neck_over_count(record: neck_guard.Record, result: Result) -> Figure:
    """Peak over the number of brakes."""
    with look():
        figure, (axes,) = canvas(width=6.8, height=3.9)
        axes.plot(record.counts, record.peaks / 1e3, color=BLUE)
        have = result.scenario.numbers.brakes.parallel
        axes.plot([have], [record.peaks[have - 1] / 1e3], "o", color=BLUE, ms=6)
        top = max(record.turned[0].peak, record.limits.acceleration) / 1e3
        _plain(axes)
        axes.set(xlim=(1, float(record.counts[-1])), ylim=(0, 1.2 * top))
        axes.set(xlabel="brakes side by side", ylabel="greatest angular acceleration [1000 rad/s²]")
        axes.axhline(record.turned[0].peak / 1e3, color=GREY, lw=1.0)
        label(axes, 1.1, 1.06 * record.turned[0].peak / 1e3, "free", GREY)
        _limit(axes, record.limits.acceleration / 1e3, "allowed", 0.03, below=True)
        label(axes, have * 1.15, 0.93 * float(record.peaks[have - 1]) / 1e3, "this guard", BLUE)
        title(axes, "More brakes", "jammed before the blow, behind the scenario's straps")
    return figure


def _ankle(result: Result) -> list[Picture]:
    record: ankle_clutch.Record = result.record
    return [
        Picture(
            name="ankle-clutch-stride",
            figure=lambda: ankle_stride(record),
            caption="One stride from the closing of the clutch on: ankle angle, and the force in "
            "spring and clutch beside what the clutch can hold at the vacuum of the moment. Where "
            "the dashed force with a standing vacuum lies above what is held, the clutch slips.",
        ),
        Picture(
            name="ankle-clutch-rate",
            figure=lambda: ankle_rates(record, result),
            caption="Slip of the clutch in a stride over the stride rate: the vacuum of this line "
            "comes too late for a stride that is too short.",
        ),
    ]


def ankle_stride(record: ankle_clutch.Record) -> Figure:
    """Angle, force and hold along a stride."""
    with look():
        figure, (upper, lower) = canvas(
            rows=2, width=7.4, height=5.6, sharex=True, gridspec_kw={"height_ratios": (1, 1.6)}
        )
        made, ready = record.stride, record.ready
        part = made.part * 100
        upper.plot(part, np.degrees(made.angle), color=INK)
        upper.set_ylabel("ankle [degrees]")
        for axes in (upper, lower):
            axes.axvspan(record.window[0] * 100, record.window[1] * 100, color=FAINT, alpha=0.3)
        title(upper, "One stride", "shaded: the clutch ought to hold; dorsiflexion above zero")
        lower.plot(part, ready.force, color=GREEN, ls=(0, (4, 2)))
        lower.plot(part, made.hold, color=ORANGE, lw=1.6)
        lower.plot(part, made.force, color=BLUE, lw=2.2)
        top = float(ready.force.max())
        lower.set(ylim=(0, 1.35 * top), xlim=(float(part[0]), float(part[-1])))
        lower.set(xlabel="part of the stride [%], from heel strike on", ylabel="force [N]")
        peak = float(part[int(np.argmax(ready.force))])
        label(lower, peak + 3, 1.05 * top, "vacuum standing", GREEN)
        late = int(0.78 * len(part))
        label(
            lower, float(part[late]) - 12, min(float(made.hold[late]) + 0.10 * top, 1.25 * top),
            "what it can hold", ORANGE,
        )  # fmt: skip
        first = int(np.argmax(made.force))
        label(lower, float(part[first]) + 1, float(made.force.max()) + 0.10 * top, "given", BLUE)
    return figure


def ankle_rates(record: ankle_clutch.Record, result: Result) -> Figure:
    """Slip over the stride rate."""
    with look():
        figure, (axes,) = canvas(width=6.8, height=3.9)
        axes.plot(record.rates, record.slips * MM, color=BLUE)
        _plain(axes)
        axes.set(xlabel="strides a second", ylabel="slip in a stride [mm]")
        axes.set(xlim=(record.rates[0], record.rates[-1]), ylim=(0, 1.2 * MM * record.slips.max()))
        _limit(axes, record.limits.slip * MM, "allowed", 0.02)
        rate = result.own["stride_rate"]
        axes.axvline(rate, color=GREY, lw=1.0, ls=(0, (2, 2)))
        label(axes, rate * 0.93, 1.12 * MM * float(record.slips.max()), "walking", GREY, ha="right")
        fastest = result.own["fastest_stride_rate"]
        said = (
            f"holds up to {fastest:.3g} strides a second" if fastest else "holds at no rate tried"
        )
        title(axes, "How fast the vacuum follows", said)
    return figure


def _rehabilitation(result: Result) -> list[Picture]:
    record: rehabilitation.Record = result.record
    return [
        Picture(
            name="rehabilitation-time",
            figure=lambda: exercise_in_time(record),
            caption="Torque wanted and given in flexion, with the vacuum behind it. In extension "
            "nothing is wanted and the cord only pulls.",
        ),
        Picture(
            name="rehabilitation-angle",
            figure=lambda: exercise_over_angle(record, result),
            caption="Left: torque over the angle, beside the most the brakes give at full vacuum. "
            "Right: the part of a flexion that brake and line can follow, over its mean speed.",
        ),
    ]


def exercise_in_time(record: rehabilitation.Record) -> Figure:
    """Torque and vacuum over time."""
    with look():
        figure, (upper, lower) = canvas(
            rows=2, width=8.4, height=5.2, sharex=True, gridspec_kw={"height_ratios": (1.7, 1)}
        )
        time, asked = record.session.time, record.session
        wanted = np.where(asked.flexing, asked.torque, np.nan)
        upper.plot(time, wanted, color=GREEN, lw=2.6, alpha=0.7)
        upper.plot(time, record.given, color=INK, lw=1.2)
        top = float(asked.torque.max())
        upper.set(ylim=(0, 1.35 * top), ylabel="torque [N m]", xlim=(0, float(time[-1])))
        label(upper, 0.02 * float(time[-1]), 1.25 * top, "wanted in flexion", GREEN)
        label(upper, 0.30 * float(time[-1]), 1.25 * top, "given", INK)
        title(upper, "Resistance in flexion", "what the brakes give on the way back is not drawn")
        lower.plot(time, record.followed.loop.target / 1e3, color=GREEN, lw=1.1, ls=(0, (4, 2)))
        lower.plot(time, record.followed.loop.vacuum / 1e3, color=BLUE, lw=1.4)
        lower.set(xlabel="time [s]", ylabel="vacuum [kPa]")
        high = 1.35 * float(record.followed.loop.target.max()) / 1e3
        lower.set_ylim(0, high)
        label(lower, 0.02 * float(time[-1]), 0.9 * high, "target", GREEN)
        label(lower, 0.14 * float(time[-1]), 0.9 * high, "in the brakes", BLUE)
    return figure


def exercise_over_angle(record: rehabilitation.Record, result: Result) -> Figure:
    """Torque over angle, and what can be followed over speed."""
    with look():
        figure, (left, right) = canvas(columns=2, width=10.6, height=4.1)
        asked = record.session
        first = _first_run(asked.flexing)
        angle = np.degrees(asked.angle[first])
        grid, reach = record.reachable
        left.fill_between(np.degrees(grid), reach, 1e3, color=RED, alpha=0.10, lw=0)
        left.plot(np.degrees(grid), reach, color=RED, lw=1.3)
        left.plot(angle, asked.torque[first], color=GREEN, lw=2.6, alpha=0.7)
        left.plot(angle, record.given[first], color=INK, lw=1.2)
        top = max(float(asked.torque.max()), float(reach.max()))
        left.set(xlim=(angle[0], angle[-1]), ylim=(0, 1.1 * top))
        left.set(xlabel="flexion [degrees]", ylabel="torque [N m]")
        label(left, float(np.degrees(grid[60])), float(reach[60]) + 0.07 * top, "out of reach", RED)
        label(left, float(angle[0]) + 3, float(asked.torque[first][0]) * 0.6, "wanted", GREEN)
        label(left, float(angle[0]) + 25, float(asked.torque[first][0]) * 0.6, "given", INK)
        title(left, "Over the angle", "first flexion; red: more than full vacuum gives")
        right.plot(np.degrees(record.speeds), record.shares * 100, color=BLUE)
        _plain(right)
        right.set(ylim=(0, 108), xlabel="mean speed of flexion [degrees/s]")
        right.set_ylabel("can be followed [% of the flexion]")
        right.set_xlim(float(np.degrees(record.speeds[0])), float(np.degrees(record.speeds[-1])))
        _limit(right, record.limits.followed * 100, "least allowed", 0.02, below=True)
        speed = math.degrees(result.scenario.numbers.exercise.speed)
        right.axvline(speed, color=GREY, lw=1.0, ls=(0, (2, 2)))
        label(right, speed * 1.06, 12, "asked", GREY)
        fastest = math.degrees(result.own["fastest_speed"])
        title(right, "Over the speed", f"up to {show(fastest, '1', 3)} degrees a second")
    return figure


def _first_run(flexing: Any) -> slice:
    """The first flexion."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flexing.astype(int), [0]])))
    return slice(int(edges[0]), int(edges[1]))
