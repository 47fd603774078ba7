"""Pumping down and venting a chamber of constant volume in closed form (mechanics, section 5).

Air at one temperature with a negligible tube: V p' = -F (p - p_u) + G (a^2 - p^2)/2a. F is the flow
of all pumps, p_u their lowest pressure, G a laminar leak and a the atmosphere. A pump with a flow
curve has a closed form if there is no leak, section by section. For water C P' = F. Times are None
if the pressure is never reached. `final_pressure` and `reachable_vacuum` apply to every line.
"""

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.fluid.flow import NORMAL, VAPOUR, leak_throughput, tube_conductance
from layerjam.brake.fluid.line import Line, water_compliance
from layerjam.brake.fluid.pump import (
    curve_points,
    inlet_flow,
    lowest_pressure,
    pump_throughput,
    require_known_water_flow,
)
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError


def has_closed_form(line: Line) -> bool:
    """Return whether the closed forms apply: one rigid volume, one temperature, no leaking orifice.

    Pumps with a flow curve have no closed form against a leak.
    """
    leak = line.leak
    rigid = line.tube is None and line.chamber.shrink == 0 and line.polytropic == 1
    return rigid and leak.orifice == 0 and not (line.pump.curve is not None and leak.laminar)


def total_pump_flow(line: Line) -> float:
    """Return the inlet flow [m^3/s] of all pumps at zero vacuum, for zero ultimate pressure."""
    return inlet_flow(line.pump) * line.pump.count


def final_pressure(line: Line) -> float:
    """Return the final absolute pressure [Pa] with these pumps, tube and leak."""
    leak, tightest = line.leak, lowest_pressure(line.pump, line.site.atmosphere)
    if leak.laminar == 0 and leak.orifice == 0:
        return tightest
    if line.tube is None and line.pump.curve is None and leak.orifice == 0:
        return _laminar_balance_pressure(line)
    return _balance_pressure(line, tightest)


def _laminar_balance_pressure(line: Line) -> float:
    flow, a, leak = total_pump_flow(line), line.site.atmosphere, line.leak.laminar
    # solve G/2a p^2 + F p - (F p_u + G a/2) = 0
    free = flow * line.pump.ultimate + leak * a / 2
    return 2 * free / (flow + math.sqrt(flow * flow + 2 * leak / a * free))


def _balance_pressure(line: Line, tightest: float) -> float:
    """Return the pressure [Pa] at which pumps and tube balance the leak, by bisection."""
    a, leak, tube = line.site.atmosphere, line.leak, line.tube

    def excess_flow(p: float) -> float:
        leak_flow = leak_throughput(p, a, leak.laminar, leak.orifice)
        square = p * p
        if tube is not None:
            square -= leak_flow / tube_conductance(tube.length, tube.bore)
        if square <= 0:
            return -leak_flow
        return line.pump.count * pump_throughput(math.sqrt(square), line.pump, a) - leak_flow

    low, high = tightest, a
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (low, middle) if excess_flow(middle) > 0 else (middle, high)
    return high


def reachable_vacuum(line: Line, water: bool = False) -> float:
    """Return the highest vacuum [Pa]; QuantityError for water if only the flow of air is known."""
    if not water:
        return line.site.atmosphere - final_pressure(line)
    require_known_water_flow(line.pump)
    return line.site.atmosphere - max(line.pump.ultimate, VAPOUR)


reachable, pumps_flow = reachable_vacuum, total_pump_flow  # former names


def pumping_time(start: float, end: float, line: Line) -> float | None:
    """Return the time [s] to pump down between two absolute pressures [Pa]; None if never."""
    flow, a, leak = total_pump_flow(line), line.site.atmosphere, line.leak.laminar
    volume, low = line.chamber.volume, final_pressure(line)
    if end <= low:
        return None
    if leak == 0:
        return _pumping_time_by_parts(start, end, line)
    # with p' = -c (p - low)(p + high)
    c = leak / (2 * a * volume)
    high = low + flow / volume / c
    ratio = (start - low) * (end + high) / ((end - low) * (start + high))
    return math.log(ratio) / (c * (low + high))


def _pumping_time_by_parts(start: float, end: float, line: Line) -> float:
    """Return the pumping time [s] without a leak; q is linear in p between the curve's points."""
    a, pump = line.site.atmosphere, line.pump
    inner = [p for p in curve_points(pump, a) if end < p < start]
    total = 0.0
    for high, low in pairwise([start, *inner, end]):
        q_high, q_low = pump_throughput(high, pump, a), pump_throughput(low, pump, a)
        if q_high != q_low:
            total += (high - low) * math.log(q_high / q_low) / (q_high - q_low)
    return line.chamber.volume * total / pump.count


def held_vacuum(time: Any, start: Any, rate: Any, atmosphere: Any) -> Any:
    """Return the vacuum [Pa] in a closed rigid chamber with a laminar leak, at times [s].

    V p' = G (a^2 - p^2)/(2a) from the vacuum `start` [Pa]; `rate` = G/V [1/s]. A small vacuum falls
    like exp(-rate t), a deep one more slowly. A pressure above atmospheric is a negative vacuum.
    """
    ratio = start / (2 * atmosphere - start) * np.exp(-rate * time)
    return 2 * atmosphere * ratio / (1 + ratio)


def leak_down_time(end: Any, start: Any, rate: Any, atmosphere: Any) -> Any:
    """Return the time [s] for that leak to reduce a vacuum from `start` to `end` [Pa], above 0."""
    twice = 2 * atmosphere
    return np.log(start * (twice - end) / (end * (twice - start))) / rate


def rise_time(target: float, line: Line, water: bool = False) -> float | None:
    """Return the 10 to 90 % rise time [s] of a vacuum [Pa] at full pump power, or None if never."""
    a = line.site.atmosphere
    if target > reachable_vacuum(line, water) or (not water and target == reachable_vacuum(line)):
        return None
    if water:
        return 0.8 * target * water_compliance(line) / total_pump_flow(line)
    return pumping_time(a - 0.1 * target, a - 0.9 * target, line)


def time_constant(line: Line, water: bool = False) -> float:
    """Return V/F for air [s], with F the inlet flow at zero vacuum.

    For water it is C a/F, the time to a vacuum of one atmosphere, which is its only time scale.
    """
    if water:
        return water_compliance(line) * line.site.atmosphere / total_pump_flow(line)
    return line.chamber.volume / total_pump_flow(line)


@brief
class Filling(NamedTuple):
    """Vacuum [Pa] versus time [s] in a line filled with water, each of shape (N,)."""

    time: npt.NDArray[np.float64]
    vacuum: npt.NDArray[np.float64]


def filling(target: float, line: Line) -> Filling:
    """Return vacuum versus time in water: up to a target [Pa] or to boiling, then constant."""
    end = min(target, reachable_vacuum(line, water=True))
    duration = end / line.site.atmosphere * time_constant(line, water=True)
    return Filling(np.array([0.0, duration, 1.6 * duration]), np.array([0.0, end, end]))


def fall_by_valve(target: float, line: Line) -> float:
    """Return the 90 to 10 % fall time [s] of a vacuum [Pa] through the vent valve (ISO 6358).

    It follows from p' V = C p_0 a phi(p/a): linear while choked, then sinusoidal.
    """
    if line.valve is None:
        raise QuantityError.of("valve", "the line has no valve or pump that lets air in")
    a, b = line.site.atmosphere, line.valve.critical_ratio
    rate = line.valve.conductance * NORMAL / line.chamber.volume

    def dimensionless_fall_time(vacuum: float) -> float:
        ratio = (a - vacuum) / a
        x = (ratio - b) / (1 - b)
        return ratio - b if x <= 0 else (1 - b) * math.asin(x)

    return (dimensionless_fall_time(0.1 * target) - dimensionless_fall_time(0.9 * target)) / rate


def fall_by_pump(target: float, line: Line, water: bool = False) -> float | None:
    """Return the 90 to 10 % fall time [s] of a vacuum [Pa] with reversed pumps; None if impossible.

    Reversed pumps push in air from the atmosphere, p' V = B a; for water C P' = -B.
    """
    flow = line.pump.backwards * line.pump.count
    if flow == 0:
        return None
    if water:
        return 0.8 * target * water_compliance(line) / flow
    return 0.8 * target / line.site.atmosphere * line.chamber.volume / flow
