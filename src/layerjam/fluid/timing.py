"""Rise and fall of the vacuum in a line, integrated."""

from __future__ import annotations

from collections.abc import Callable

from layerjam.fluid.closed_forms import (
    fall_by_pump,
    fall_by_valve,
    reachable,
    time_constant,
)
from layerjam.fluid.line import Line
from layerjam.fluid.network import Drive, Response, at_pressure, respond
from layerjam.fluid.tube import filling_lag, wave_delay

Progress = Callable[[float], None]
"""Told the share done of a stretch of time."""
LONGEST = 200.0
"""Time constants after which a rise is given up."""
SAMPLES = 801
DOUBLINGS = 12


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
