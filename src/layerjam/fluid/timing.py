"""Rise and fall of the vacuum in a line, integrated, and what would make it faster."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from layerjam.fluid.closed_forms import (
    fall_by_pump,
    fall_by_valve,
    lowest,
    reachable,
    rise_time,
    time_constant,
)
from layerjam.fluid.line import Line, Reservoir, water_compliance
from layerjam.fluid.network import Drive, Response, at_pressure, respond
from layerjam.fluid.tube import filling_lag, wave_delay

Progress = Callable[[float], None]
"""Told the share done of a stretch of time."""
LONGEST = 200.0
"""Time constants after which a rise is given up."""
SAMPLES = 801
DOUBLINGS = 12
TANK = Reservoir(volume=0.5e-3, conductance=2e-9)
STORED = 2e3
"""Absolute pressure of the reservoir before it is joined [Pa], where the pump comes so low."""


def pumped(
    target: float, line: Line, progress: Progress | None = None
) -> tuple[float | None, Response | None]:
    """10 to 90 % rise time [s] to a vacuum [Pa] in air, pump full on; None where it never comes."""
    if target >= reachable(line):
        return None, None
    constant = time_constant(line)
    if line.tube is not None:
        constant += filling_lag(line, line.site.atmosphere - target) + wave_delay(line.tube)
    span = 4 * constant
    while span < LONGEST * constant:
        made = respond(line, span, Drive(), at_pressure(line), SAMPLES, progress)
        if made.vacuum[-1] >= target:
            return _between(made, 0.1 * target, 0.9 * target), made
        span *= 2
    return None, None


def released(
    target: float, line: Line, progress: Progress | None = None
) -> tuple[float | None, str | None]:
    """90 to 10 % fall time [s] from a vacuum [Pa] in air, and by what; None where nothing vents.

    By the vent valve from when it is open, else by the pumps run backwards.
    """
    if line.valve is not None:
        drive, by, first = Drive(pump=0.0, vent=1.0), "valve", fall_by_valve(target, line)
    else:
        drive, by = Drive(pump=-1.0), "pumps run backwards"
        alone = fall_by_pump(target, line)
        if alone is None:
            return None, None
        first = alone
    start, span = at_pressure(line, line.site.atmosphere - target), 2 * first
    for _ in range(DOUBLINGS):
        made = respond(line, span, drive, start, SAMPLES, progress)
        if made.vacuum[-1] <= 0.1 * target:
            return _between(made, 0.9 * target, 0.1 * target), by
        span *= 2
    return None, None


def _between(made: Response, first: float, second: float) -> float | None:
    one, two = made.crossing(first), made.crossing(second)
    return None if one is None or two is None else two - one


def with_reservoir(line: Line, target: float, at_most: float) -> float | None:
    """10 to 90 % rise [s] where an emptied half litre is joined and the pump helps."""
    joined = replace(line, reservoir=TANK)
    start = at_pressure(joined, stored=max(STORED, lowest(line)))
    for duration in (1.0, at_most):  # so short a rise is seen in a short run alone
        made = respond(joined, duration, Drive(store=1.0), start, 2001)
        low, high = made.crossing(0.1 * target), made.crossing(0.9 * target)
        if low is not None and high is not None:
            return high - low
    return None


def changes(line: Line, target: float, water: bool = False) -> list[tuple[str, float]]:
    """What can be changed, and the rise time [s] it gives; left out where it is never reached."""
    chamber, pump = line.chamber, line.pump
    twice = replace(line, pump=replace(pump, count=2 * pump.count))
    more = {2: "two", 4: "four"}.get(twice.pump.count, str(twice.pump.count)) + " pumps"

    def filled(changed: Line) -> float | None:
        return rise_time(target, changed, water=True)

    def emptied(changed: Line) -> float | None:
        return pumped(target, changed)[0]

    if water:
        stiff = replace(line, chamber=replace(chamber, compliance=water_compliance(line) / 2))
        found = {
            "as it is": filled(line),
            "half the compliance": filled(stiff),
            more: filled(twice),
            "air in place of water": emptied(line),
        }
    else:
        half = replace(line, chamber=replace(chamber, volume=chamber.volume / 2))
        own = emptied(line)
        found = {"as it is": own, "half the volume": emptied(half), more: emptied(twice)}
        if line.tube is not None:
            tube = replace(line.tube, length=line.tube.length / 2)
            found["tube half as long"] = emptied(replace(line, tube=tube))
        if chamber.compliance is not None and pump.curve is None:
            found |= {"water": filled(line), f"water, {more}": filled(twice)}
        if own is not None and line.reservoir is None:
            found["0.5 L reservoir"] = with_reservoir(line, target, 2 * own)
    return [(what, time) for what, time in found.items() if time is not None]
