"""The vacuum line: Fig. 5 of the paper, and what would make the line faster."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from layerjam.fluid import closed_forms as forms
from layerjam.fluid.file import load_line
from layerjam.fluid.line import Line, Reservoir
from layerjam.fluid.network import Drive, Response, at_pressure, respond
from layerjam.fluid.timing import pumped
from layerjam.report.style import BLUE, GREEN, GREY, INK, canvas, label, look, save, title
from layerjam.units import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]
__all__ = ["fig5", "rise_figure", "save"]
FULL, KPA = 94.5e3, 1e3
TANK = Reservoir(volume=0.5e-3, conductance=2e-9)
STORED = 2e3
"""Absolute pressure of the reservoir before it is joined [Pa], where the pump comes so low."""
LONG, TOP = 1.6, 1.12
"""Of the way to the target, and of the target itself, how much a figure shows."""


def with_reservoir(line: Line, target: float, at_most: float) -> float | None:
    """10 to 90 % rise [s] where an emptied half litre is joined and the pump helps."""
    joined = replace(line, reservoir=TANK)
    start = at_pressure(joined, stored=max(STORED, forms.lowest(line)))
    for duration in (1.0, at_most):  # so short a rise is seen in a short run alone
        made = respond(joined, duration, Drive(store=1.0), start, 2001)
        low, high = made.crossing(0.1 * target), made.crossing(0.9 * target)
        if low is not None and high is not None:
            return high - low
    return None


def changes(line: Line, target: float, water: bool = False) -> list[tuple[str, float]]:
    """What can be changed, and the rise time [s] it gives; left out where it is never reached."""
    twice = replace(line, pump=replace(line.pump, count=2 * line.pump.count))
    more = {2: "two", 4: "four"}.get(twice.pump.count, str(twice.pump.count)) + " pumps"
    found = _in_water(line, twice, more, target) if water else _in_air(line, twice, more, target)
    return [(what, time) for what, time in found if time is not None]


def _in_air(line: Line, twice: Line, more: str, target: float) -> list[tuple[str, float | None]]:
    half = replace(line, chamber=replace(line.chamber, volume=line.chamber.volume / 2))
    air = [("as it is", line), ("half the volume", half), (more, twice)]
    if line.tube is not None:
        short = replace(line.tube, length=line.tube.length / 2)
        air.append(("tube half as long", replace(line, tube=short)))
    found = [(what, pumped(target, changed)[0]) for what, changed in air]
    if line.chamber.compliance is not None and line.pump.curve is None:
        found.append(("water", forms.rise_time(target, line, water=True)))
        found.append((f"water, {more}", forms.rise_time(target, twice, water=True)))
    own = found[0][1]
    if own is not None and line.reservoir is None:
        found.append(("0.5 L reservoir", with_reservoir(line, target, 2 * own)))
    return found


def _in_water(line: Line, twice: Line, more: str, target: float) -> list[tuple[str, float | None]]:
    assert line.chamber.compliance is not None
    stiff = replace(line.chamber, compliance=line.chamber.compliance / 2)
    water = [("as it is", line), ("half the compliance", replace(line, chamber=stiff))]
    found = [(w, forms.rise_time(target, c, water=True)) for w, c in [*water, (more, twice)]]
    return [*found, ("air in place of water", pumped(target, line)[0])]


def bars_of(axes: Axes, made: list[tuple[str, float]], detail: str) -> None:
    """Rise times as rows, the first on top."""
    rows = made[::-1]
    places, most = np.arange(len(rows)), max((time for _, time in made), default=1.0)
    for y, (what, time) in zip(places.tolist(), rows, strict=True):
        color = INK if what == "as it is" else GREEN
        axes.plot([0, time], [y, y], color=color, lw=1.2)
        axes.plot([time], [y], "o", color=color, ms=5)
        axes.text(time + 0.03 * most, y, show(time, "s", 3), va="center", fontsize=8.8, color=color)
    axes.set_yticks(places, [what for what, _ in rows])
    axes.set(
        xlim=(0, 1.23 * most), ylim=(-0.6, max(len(rows), 1) - 0.4),
        xlabel="rise time 10 to 90 % [s]",
    )  # fmt: skip
    axes.grid(axis="y", visible=False)
    title(axes, "What would make it faster", detail)


def levels(axes: Axes, target: float, end: float) -> None:
    """The two vacuums between which a rise is timed."""
    for part, away in ((0.1, 0.015), (0.9, -0.05)):
        axes.axhline(part * target / KPA, color=GREY, lw=0.7, ls=(0, (2, 2)))
        height = (part + away) * target / KPA
        axes.text(0.99 * end, height, f"{100 * part:.0f} %", fontsize=8.2, color=GREY, ha="right")


def tank_detail(line: Line, water: bool = False) -> str:
    """What stands under the chart."""
    if line.reservoir is not None or water:
        return "each alone, all else as it is"
    stored = max(STORED, forms.lowest(line))
    return f"reservoir at {stored / KPA:.3g} kPa absolute, its valve 0.2 L/(s bar)"


def in_water(line: Line, target: float) -> tuple[Array, Array]:
    """Time [s] and vacuum [Pa] of a line filled with water, up to the target or where it boils."""
    assert line.chamber.compliance is not None
    end = min(target, forms.reachable(line, water=True))
    whole = end * line.chamber.compliance / forms.pumps_flow(line)
    return np.array([0.0, whole, LONG * whole]), np.array([0.0, end, end])


def rise_figure(line: Line, target: float, water: bool = False, name: str = "") -> Figure:
    """Vacuum over time, and what would make the line faster; all in SI, checked by the caller."""
    made: Response | None = None
    if water:
        time, vacuum = in_water(line, target)
        rise = forms.rise_time(target, line, water=True)
    else:
        rise, made = pumped(target, line)
        if made is None:  # never reached: how far it comes
            made = respond(line, 8 * forms.time_constant(line))
        time, vacuum = made.time, made.vacuum
    reached = np.flatnonzero(vacuum >= target)
    end = LONG * float(time[reached[0]]) if len(reached) else np.inf
    seen = (time <= end) & (vacuum <= TOP * target)
    time, vacuum = time[seen], vacuum[seen]
    end = float(time[-1])
    with look():
        figure, (steps, bars) = canvas(columns=2, width=9.6, height=3.9)
        steps.plot(time, vacuum / KPA, color=BLUE if water else INK)
        steps.axhline(target / KPA, color=GREY, lw=0.9)
        steps.text(
            0.01 * end,
            target / KPA * 1.015,
            f"target {show(target, 'Pa')}",
            fontsize=8.8,
            color=INK,
        )
        levels(steps, target, end)
        steps.set(xlim=(0, end), ylim=(0, TOP * target / KPA), xlabel="time [s]",
                  ylabel="vacuum [kPa]")  # fmt: skip
        said = "never reached" if rise is None else f"10 to 90 % in {show(rise, 's', 3)}"
        title(steps, f"{name or 'the line'} in {'water' if water else 'air'}", said)
        found = changes(line, target, water)
        bars_of(bars, found, tank_detail(line, water))
        if not found:
            bars.text(0.5, 0.5, "none of these reaches the target", ha="center", color=GREY,
                      transform=bars.transAxes)  # fmt: skip
    return figure


def fig5() -> Figure:
    """Vacuum over time in air and water, and rise times of other lines."""
    line = load_line("choi2018").line
    air = respond(line, 8.0)
    water = np.minimum(
        forms.pumps_flow(line) * air.time / (line.chamber.compliance or np.nan), FULL
    )
    with look():
        figure, (steps, bars) = canvas(columns=2, width=9.6, height=3.9)
        levels(steps, FULL, 8.0)
        shown = np.minimum(air.vacuum, FULL)
        steps.plot(air.time, shown / KPA, color=INK)
        steps.plot(air.time, water / KPA, color=BLUE)
        for name, color, place, paper, level in (
            ("air", INK, forms.rise_time(FULL, line), 3.9, (2.5, 60.0)),
            ("water", BLUE, forms.rise_time(FULL, line, water=True), 1.5, (0.95, 20.0)),
        ):
            label(steps, *level, f"{name}: {place:.2f} s (paper {paper} s)", color)
        steps.set(xlim=(0, 8), ylim=(0, 100), xlabel="time [s]", ylabel="vacuum [kPa]")
        title(steps, "Fig. 5: rise to 94.5 kPa", "7.50 mL and 0.0661 mL/kPa are inferred from it")
        bars_of(bars, changes(line, FULL), tank_detail(line))
    return figure
