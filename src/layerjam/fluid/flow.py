"""Flows of gas through pump, valve, tube and leak, as throughputs [Pa m^3/s]."""

from __future__ import annotations

import math

CRITICAL = 0.528
"""Critical pressure ratio of a nozzle without losses."""
NORMAL = 1e5
"""Pressure of the standard reference atmosphere of ISO 6358 [Pa]."""
LAMINAR = 0.999
"""Pressure ratio above which a valve's flow is taken as proportional to the difference: there the
ellipse of ISO 6358 is infinitely steep, which no flow is."""
VISCOSITY = 1.81e-5
"""Of air at 20 degC [Pa s] (handbook)."""
SPECIFIC_GAS = 287.05
"""Of dry air [J/(kg K)] (handbook)."""
TEMPERATURE = 293.15
"""Of the gas in the line [K]: 20 degC, as for the viscosity."""
VAPOUR = 2339.0
"""Vapour pressure of water at 20 degC [Pa] (handbook): below it water boils."""


def passed(ratio: float, critical: float = CRITICAL) -> float:
    """Flow over the choked flow at a ratio of absolute pressures, 0 to 1 (ISO 6358).

    1 up to the critical ratio, then the quarter of an ellipse, straight from `LAMINAR` to 0 at
    equal pressures.
    """
    if ratio > LAMINAR:
        return passed(LAMINAR, critical) * (1 - ratio) / (1 - LAMINAR)
    over = (ratio - critical) / (1 - critical)
    if over <= 0:
        return 1.0
    return math.sqrt(max(1.0 - over * over, 0.0))


def through_valve(high: float, low: float, conductance: float, critical: float = CRITICAL) -> float:
    """From pressure `high` to `low` [Pa absolute]; negative where low is the higher one."""
    if low > high:
        return -through_valve(low, high, conductance, critical)
    return conductance * NORMAL * high * passed(low / high if high > 0 else 1.0, critical)


def tube_conductance(length: float, bore: float) -> float:
    """Throughput over the difference of squared pressures [m^3/(s Pa)], laminar (Poiseuille)."""
    return math.pi * bore**4 / (256 * VISCOSITY * length)


def through_tube(a: float, b: float, length: float, bore: float) -> float:
    """From a to b [Pa absolute], laminar flow of a gas (Poiseuille)."""
    return tube_conductance(length, bore) * (a * a - b * b)


def leaking(p: float, atmosphere: float, laminar: float, orifice: float) -> float:
    """Into a chamber at p [Pa absolute] from the atmosphere; negative where p is above it."""
    flow = laminar * (atmosphere * atmosphere - p * p) / (2 * atmosphere)
    if orifice:
        high, low = max(p, atmosphere), min(p, atmosphere)
        flow += math.copysign(orifice * high * passed(low / high), atmosphere - p)
    return flow
