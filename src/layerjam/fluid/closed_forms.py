"""Pumping down and venting a chamber of constant volume in closed form (mechanics, section 5).

Air at one temperature, without a tube that matters: V p' = -F (p - p_u) + G (a^2 - p^2)/2a, with F
the flow of all pumps, p_u the lowest pressure they reach, G a laminar leak and a the atmosphere.
A pump by its flow curve has a closed form without leak, stretch by stretch. Water: C P' = F. Times
are None where the pressure is never reached. `lowest` and `reachable` hold for every line.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.errors import QuantityError
from layerjam.fluid.flow import NORMAL, VAPOUR, leaking, tube_conductance
from layerjam.fluid.line import Line, water_compliance
from layerjam.fluid.pump import check_water, inlet_flow, intake, lowest_pressure, points


def simple(line: Line) -> bool:
    """Whether the closed forms hold: one rigid volume at one temperature, no orifice leaks.

    Pumps by their flow curve have none against a leak.
    """
    leak = line.leak
    rigid = line.tube is None and line.chamber.shrink == 0 and line.polytropic == 1
    return rigid and leak.orifice == 0 and not (line.pump.curve is not None and leak.laminar)


def pumps_flow(line: Line) -> float:
    """Flow of all pumps at their inlet, without vacuum and with none kept back [m^3/s]."""
    return inlet_flow(line.pump) * line.pump.count


def lowest(line: Line) -> float:
    """Absolute pressure [Pa] that pumps, tube and leak come to in the end."""
    leak, tightest = line.leak, lowest_pressure(line.pump, line.site.atmosphere)
    if leak.laminar == 0 and leak.orifice == 0:
        return tightest
    if line.tube is None and line.pump.curve is None and leak.orifice == 0:
        return _against_laminar(line)
    return _balance(line, tightest)


def _against_laminar(line: Line) -> float:
    flow, a, leak = pumps_flow(line), line.site.atmosphere, line.leak.laminar
    # G/2a p^2 + F p - (F p_u + G a/2) = 0
    free = flow * line.pump.ultimate + leak * a / 2
    return 2 * free / (flow + math.sqrt(flow * flow + 2 * leak / a * free))


def _balance(line: Line, tightest: float) -> float:
    """Where the pumps, through the tube, take out what leaks in; by bisection."""
    a, leak, tube = line.site.atmosphere, line.leak, line.tube

    def excess(p: float) -> float:
        comes = leaking(p, a, leak.laminar, leak.orifice)
        squared = p * p
        if tube is not None:
            squared -= comes / tube_conductance(tube.length, tube.bore)
        if squared <= 0:
            return -comes
        return line.pump.count * intake(math.sqrt(squared), line.pump, a) - comes

    low, high = tightest, a
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (low, middle) if excess(middle) > 0 else (middle, high)
    return high


def reachable(line: Line, water: bool = False) -> float:
    """Greatest vacuum [Pa] that can be reached; QuantityError for water by a flow curve of air."""
    if not water:
        return line.site.atmosphere - lowest(line)
    check_water(line.pump)
    return line.site.atmosphere - max(line.pump.ultimate, VAPOUR)


def pumping_time(start: float, end: float, line: Line) -> float | None:
    """Time [s] from one absolute pressure [Pa] down to another, pump full on; None if never."""
    flow, a, leak = pumps_flow(line), line.site.atmosphere, line.leak.laminar
    volume, low = line.chamber.volume, lowest(line)
    if end <= low:
        return None
    if leak == 0:
        return _by_stretches(start, end, line)
    # p' = -c (p - low)(p + high)
    c = leak / (2 * a * volume)
    high = low + flow / volume / c
    ratio = (start - low) * (end + high) / ((end - low) * (start + high))
    return math.log(ratio) / (c * (low + high))


def _by_stretches(start: float, end: float, line: Line) -> float:
    """Without leak: between points q is straight in p, so V dp over the logarithmic mean of q."""
    a, pump = line.site.atmosphere, line.pump
    between = [p for p in points(pump, a) if end < p < start]
    taken = 0.0
    for high, low in pairwise([start, *between, end]):
        more, less = intake(high, pump, a), intake(low, pump, a)
        if more != less:
            taken += (high - low) * math.log(more / less) / (more - less)
    return line.chamber.volume * taken / pump.count


def held_vacuum(time: Any, start: Any, rate: Any, atmosphere: Any) -> Any:
    """Vacuum [Pa] that a laminar leak leaves in a closed rigid chamber; times [s] broadcast.

    V p' = G (a^2 - p^2)/(2a) from the vacuum `start` [Pa]; `rate` = G/V [1/s]. A small vacuum falls
    as exp(-rate t), a deep one more slowly. Pressure above the atmosphere is a negative vacuum.
    """
    left = start / (2 * atmosphere - start) * np.exp(-rate * time)
    return 2 * atmosphere * left / (1 + left)


def holding_time(end: Any, start: Any, rate: Any, atmosphere: Any) -> Any:
    """Time [s] in which that leak takes a vacuum from `start` to `end` [Pa], both above zero."""
    whole = 2 * atmosphere
    return np.log(start * (whole - end) / (end * (whole - start))) / rate


def rise_time(target: float, line: Line, water: bool = False) -> float | None:
    """From 10 to 90 % of a vacuum [Pa], pump full on; None where the target is never reached."""
    a = line.site.atmosphere
    if target > reachable(line, water) or (not water and target == reachable(line)):
        return None
    if water:
        return 0.8 * target * water_compliance(line) / pumps_flow(line)
    return pumping_time(a - 0.1 * target, a - 0.9 * target, line)


def time_constant(line: Line, water: bool = False) -> float:
    """V/F of air [s], F at the inlet without vacuum.

    Of water the time to a vacuum of one atmosphere, C a/F, its only scale.
    """
    if water:
        return water_compliance(line) * line.site.atmosphere / pumps_flow(line)
    return line.chamber.volume / pumps_flow(line)


class Filling(NamedTuple):
    """Vacuum [Pa] over time [s] in a line filled with water, shape (N,)."""

    time: npt.NDArray[np.float64]
    vacuum: npt.NDArray[np.float64]


def filling(target: float, line: Line) -> Filling:
    """Vacuum over time in water up to a target [Pa], or to where the water boils, and held."""
    end = min(target, reachable(line, water=True))
    whole = end / line.site.atmosphere * time_constant(line, water=True)
    return Filling(np.array([0.0, whole, 1.6 * whole]), np.array([0.0, end, end]))


def fall_by_valve(target: float, line: Line) -> float:
    """From 90 to 10 % of a vacuum [Pa] through the vent valve (ISO 6358), with its leak left out.

    p' V = C p_0 a phi(p/a): linear while choked, then a = sin of a clock.
    """
    if line.valve is None:
        raise QuantityError.of("valve", "the line has none that lets air in")
    a, b = line.site.atmosphere, line.valve.critical_ratio
    rate = line.valve.conductance * NORMAL / line.chamber.volume

    def clock(vacuum: float) -> float:
        ratio = (a - vacuum) / a
        over = (ratio - b) / (1 - b)
        return ratio - b if over <= 0 else (1 - b) * math.asin(over)

    return (clock(0.1 * target) - clock(0.9 * target)) / rate


def fall_by_pump(target: float, line: Line, water: bool = False) -> float | None:
    """From 90 to 10 % of a vacuum [Pa], pumps run backwards; None where they cannot.

    Backwards they push in air of the atmosphere: p' V = B a; water: C P' = -B.
    """
    flow = line.pump.backwards * line.pump.count
    if flow == 0:
        return None
    if water:
        return 0.8 * target * water_compliance(line) / flow
    return 0.8 * target / line.site.atmosphere * line.chamber.volume / flow
