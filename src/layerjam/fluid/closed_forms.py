"""Pumping down and venting a chamber of constant volume in closed form (mechanics, section 5).

Air at one temperature, without a tube that matters: V p' = -F (p - p_u) + G (a^2 - p^2)/2a, with F
the flow of all pumps, p_u the lowest pressure they reach, G a laminar leak and a the atmosphere.
Water: C P' = F. Times are None where the pressure is never reached.
"""

from __future__ import annotations

import math

from layerjam.fluid.flow import NORMAL, VAPOUR
from layerjam.fluid.line import Line


def pumps_flow(line: Line) -> float:
    """Flow of all pumps [m^3/s]."""
    return line.pump.flow * line.pump.count


def lowest(line: Line) -> float:
    """Absolute pressure [Pa] that pump and laminar leak come to in the end."""
    flow, a, leak = pumps_flow(line), line.site.atmosphere, line.leak.laminar
    if leak == 0:
        return line.pump.ultimate
    # G/2a p^2 + F p - (F p_u + G a/2) = 0
    free = flow * line.pump.ultimate + leak * a / 2
    return 2 * free / (flow + math.sqrt(flow * flow + 2 * leak / a * free))


def reachable(line: Line, water: bool = False) -> float:
    """Greatest vacuum [Pa] that can be reached."""
    limit = max(line.pump.ultimate, VAPOUR) if water else lowest(line)
    return line.site.atmosphere - limit


def pumping_time(start: float, end: float, line: Line) -> float | None:
    """Time [s] from one absolute pressure [Pa] down to another, pump full on; None if never."""
    flow, a, leak = pumps_flow(line), line.site.atmosphere, line.leak.laminar
    volume, low = line.chamber.volume, lowest(line)
    if end <= low:
        return None
    if leak == 0:
        return volume / flow * math.log((start - low) / (end - low))
    # p' = -c (p - low)(p + high)
    c = leak / (2 * a * volume)
    high = low + flow / volume / c
    ratio = (start - low) * (end + high) / ((end - low) * (start + high))
    return math.log(ratio) / (c * (low + high))


def rise_time(target: float, line: Line, water: bool = False) -> float | None:
    """From 10 to 90 % of a vacuum [Pa], pump full on; None where the target is never reached."""
    a = line.site.atmosphere
    if target > reachable(line, water) or (not water and target == reachable(line)):
        return None
    if water:
        assert line.chamber.compliance is not None
        return 0.8 * target * line.chamber.compliance / pumps_flow(line)
    return pumping_time(a - 0.1 * target, a - 0.9 * target, line)


def time_constant(line: Line, water: bool = False) -> float:
    """V/F of air [s]; of water the time to a vacuum of one atmosphere, C a/F, its only scale."""
    if water:
        assert line.chamber.compliance is not None
        return line.chamber.compliance * line.site.atmosphere / pumps_flow(line)
    return line.chamber.volume / pumps_flow(line)


def fall_by_valve(target: float, line: Line) -> float:
    """From 90 to 10 % of a vacuum [Pa] through the vent valve (ISO 6358), with its leak left out.

    p' V = C p_0 a phi(p/a): linear while choked, then a = sin of a clock.
    """
    assert line.valve is not None
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
        assert line.chamber.compliance is not None
        return 0.8 * target * line.chamber.compliance / flow
    return 0.8 * target / line.site.atmosphere * line.chamber.volume / flow
