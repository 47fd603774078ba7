"""The vacuum line: Fig. 5 of the paper, and what would make the line faster."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from layerjam.fluid import closed_forms as forms
from layerjam.fluid.file import load_line
from layerjam.fluid.line import Line, Reservoir
from layerjam.fluid.network import Drive, at_pressure, respond
from layerjam.fluid.timing import pumped
from layerjam.report import style
from layerjam.report.style import BLUE, GREEN, GREY, INK, KPA
from layerjam.units import show

save = style.save
FULL = 94.5e3
TANK = Reservoir(volume=0.5e-3, conductance=2e-9)
STORED = 2e3
"""Absolute pressure of the reservoir before it is joined [Pa], where the pump comes so low."""
LONG, TOP = 1.6, 1.12
"""How much a figure shows, over the time to the target and over the target itself."""


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
    stiff = replace(line.chamber, compliance=(line.chamber.compliance or np.nan) / 2)
    water = [("as it is", line), ("half the compliance", replace(line, chamber=stiff))]
    found = [(w, forms.rise_time(target, c, water=True)) for w, c in [*water, (more, twice)]]
    return [*found, ("air in place of water", pumped(target, line)[0])]


def _bars(axes: style.Axes, line: Line, target: float, water: bool = False) -> None:
    """What would make the line faster: rise times as rows, the first on top."""
    rows = changes(line, target, water)[::-1]
    longest = max((time for _, time in rows), default=1.0)
    for y, (what, time) in enumerate(rows):
        color = INK if what == "as it is" else GREEN
        axes.plot([0, time], [y, y], color=color, lw=1.2)
        style.spot(axes, time, y, color=color, ms=5)
        style.label(axes, time + 0.03 * longest, y, show(time, "s", 3), color)
    if not rows:
        middle: dict[str, Any] = {"transform": axes.transAxes, "ha": "center"}
        style.label(axes, 0.5, 0.5, "none of these reaches the target", GREY, **middle)
    axes.set_yticks(range(len(rows)), [what for what, _ in rows])
    axes.set(xlim=(0, 1.3 * longest), ylim=(-0.6, max(len(rows), 1) - 0.4))
    axes.grid(axis="y", visible=False)
    detail = "each alone, all else as it is"
    if line.reservoir is None and not water:
        stored = max(STORED, forms.lowest(line))
        detail = f"reservoir at {stored * KPA:.3g} kPa absolute, its valve 0.2 L/(s bar)"
    style.panel(axes, "What would make it faster", detail, xlabel="rise time 10 to 90 % [s]")


def _levels(axes: style.Axes, target: float) -> None:
    """The two vacuums between which a rise is timed."""
    for part in (0.1, 0.9):
        style.level(axes, part * target * KPA, f"{100 * part:.0f} %", GREY, 0.99, part > 0.5)
    axes.set(xlabel="time [s]", ylabel="vacuum [kPa]")


def rise_figure(line: Line, target: float, water: bool = False, name: str = "") -> style.Figure:
    """Vacuum over time, and what would make the line faster; all in SI, checked by the caller."""
    if water:
        time, vacuum = forms.filling(target, line)
        rise = forms.rise_time(target, line, water=True)
    else:
        rise, made = pumped(target, line)
        if made is None:  # never reached: how far it comes
            made = respond(line, 8 * forms.time_constant(line))
        time, vacuum = made.time, made.vacuum
    reached = np.flatnonzero(vacuum >= target)
    end = LONG * float(time[reached[0]]) if len(reached) else np.inf
    seen = (time <= end) & (vacuum <= TOP * target)
    figure, (steps, bars) = style.canvas(columns=2, width=9.6, height=3.9)
    steps.plot(time[seen], vacuum[seen] * KPA, color=BLUE if water else INK)
    steps.set(xlim=(0, float(time[seen][-1])), ylim=(0, TOP * target * KPA))
    style.level(steps, target * KPA, f"target {show(target, 'Pa')}", INK, 0.01)
    _levels(steps, target)
    said = "never reached" if rise is None else f"10 to 90 % in {show(rise, 's', 3)}"
    style.title(steps, f"{name or 'the line'} in {'water' if water else 'air'}", said)
    _bars(bars, line, target, water)
    return figure


@style.styled
def fig5() -> style.Figure:
    """Vacuum over time in air and water, and rise times of other lines."""
    line = load_line("choi2018").line
    made = respond(line, 8.0)
    flow = forms.pumps_flow(line) / (line.chamber.compliance or np.nan)
    figure, (steps, bars) = style.canvas(columns=2, width=9.6, height=3.9)
    for name, vacuum, color, printed in (
        ("air", made.vacuum, INK, 3.9),
        ("water", flow * made.time, BLUE, 1.5),
    ):
        rise = forms.rise_time(FULL, line, water=name == "water") or np.nan
        words = f"{name}: {rise:.2f} s (paper {printed} s)"
        steps.plot(made.time, np.minimum(vacuum, FULL) * KPA, color=color, label=words)
    steps.set(xlim=(0, 8), ylim=(0, 100))
    _levels(steps, FULL)
    style.key(steps, at="center right")
    style.title(steps, "Fig. 5: rise to 94.5 kPa", "7.50 mL and 0.0661 mL/kPa are inferred from it")
    _bars(bars, line, FULL)
    return figure
