"""Rise and fall of the vacuum in a line, by integration, and changes that would speed them up."""

from collections.abc import Callable

from layerjam.brake.fluid.closed_forms import (
    fall_by_pump,
    fall_by_valve,
    final_pressure,
    reachable_vacuum,
    rise_time,
    time_constant,
)
from layerjam.brake.fluid.line import Line, Reservoir, water_compliance
from layerjam.brake.fluid.network import Drive, Response, respond, state_at_pressure
from layerjam.brake.fluid.tube import filling_lag, wave_delay
from layerjam.core.evolve import evolve

Progress = Callable[[float], None]
"""Function that is called with the completed fraction of a period."""
LONGEST = 200.0
"""Number of time constants after which a rise is abandoned."""
SAMPLES = 801
DOUBLINGS = 12
TANK = Reservoir(volume=0.5e-3, conductance=2e-9)
STORED = 2e3
"""Absolute pressure [Pa] of the reservoir before it is connected, if the pump can reach it."""


def air_rise_time(
    target: float, line: Line, progress: Progress | None = None
) -> tuple[float | None, Response | None]:
    """Return the 10 to 90 % rise time [s] to a vacuum [Pa] in air at full pump power, or None."""
    if target >= reachable_vacuum(line):
        return None, None
    constant = time_constant(line)
    if line.tube is not None:
        constant += filling_lag(line, line.site.atmosphere - target) + wave_delay(line.tube)
    span = 4 * constant
    while span < LONGEST * constant:
        response = respond(line, span, Drive(), state_at_pressure(line), SAMPLES, progress)
        if response.vacuum[-1] >= target:
            return _crossing_time(response, 0.1 * target, 0.9 * target), response
        span *= 2
    return None, None


def air_fall_time(
    target: float, line: Line, progress: Progress | None = None
) -> tuple[float | None, str | None]:
    """Return the 90 to 10 % fall time [s] from a vacuum [Pa] in air, and its method, or None.

    The method is the vent valve, timed from its opening, or otherwise reversed pumps.
    """
    if line.valve is not None:
        drive, means, first = Drive(pump=0.0, vent=1.0), "valve", fall_by_valve(target, line)
    else:
        drive, means = Drive(pump=-1.0), "pumps run backwards"
        time_backwards = fall_by_pump(target, line)
        if time_backwards is None:
            return None, None
        first = time_backwards
    start, span = state_at_pressure(line, line.site.atmosphere - target), 2 * first
    for _ in range(DOUBLINGS):
        response = respond(line, span, drive, start, SAMPLES, progress)
        if response.vacuum[-1] <= 0.1 * target:
            return _crossing_time(response, 0.9 * target, 0.1 * target), means
        span *= 2
    return None, None


def _crossing_time(response: Response, first: float, second: float) -> float | None:
    start, end = response.crossing(first), response.crossing(second)
    return None if start is None or end is None else end - start


def reservoir_rise_time(line: Line, target: float, longest: float) -> float | None:
    """Return the 10 to 90 % rise time [s] with the pump and an evacuated 0.5 L reservoir."""
    line_with_tank = evolve(line, reservoir=TANK)
    start = state_at_pressure(line_with_tank, tank_pressure=max(STORED, final_pressure(line)))
    for duration in (1.0, longest):  # so short a rise can be resolved only in a short run
        response = respond(line_with_tank, duration, Drive(store=1.0), start, 2001)
        low, high = response.crossing(0.1 * target), response.crossing(0.9 * target)
        if low is not None and high is not None:
            return high - low
    return None


def suggest_changes(line: Line, target: float, water: bool = False) -> list[tuple[str, float]]:
    """Return changes to the line with which it reaches the target, and their rise times [s]."""
    chamber, pump = line.chamber, line.pump
    twice = evolve(line, pump=evolve(pump, count=2 * pump.count))
    pumps = {2: "two", 4: "four"}.get(twice.pump.count, str(twice.pump.count)) + " pumps"

    def water_time(line_: Line) -> float | None:
        return rise_time(target, line_, water=True)

    def air_time(line_: Line) -> float | None:
        return air_rise_time(target, line_)[0]

    if water:
        stiff = evolve(line, chamber=evolve(chamber, compliance=water_compliance(line) / 2))
        times = {
            "as it is": water_time(line),
            "half the compliance": water_time(stiff),
            pumps: water_time(twice),
            "air in place of water": air_time(line),
        }
    else:
        half_line = evolve(line, chamber=evolve(chamber, volume=chamber.volume / 2))
        present = air_time(line)
        times = {
            "as it is": present,
            "half the volume": air_time(half_line),
            pumps: air_time(twice),
        }
        if line.tube is not None:
            tube = evolve(line.tube, length=line.tube.length / 2)
            times["tube half as long"] = air_time(evolve(line, tube=tube))
        if chamber.compliance is not None and pump.curve is None:
            times |= {"water": water_time(line), f"water, {pumps}": water_time(twice)}
        if present is not None and line.reservoir is None:
            times["0.5 L reservoir"] = reservoir_rise_time(line, target, 2 * present)
    return [(name, time) for name, time in times.items() if time is not None]
