"""Flows of gas through pump, valve, tube and leak, as throughputs [Pa m^3/s]."""

import math

CRITICAL = 0.528
"""Critical pressure ratio of a lossless nozzle."""
NORMAL = 1e5
"""Pressure of the standard reference atmosphere of ISO 6358 [Pa]."""
LAMINAR = 0.999
"""Pressure ratio above which a valve's flow is proportional to the pressure difference, because the
ellipse of ISO 6358 becomes infinitely steep there, unlike real flow."""
VISCOSITY = 1.81e-5
"""Viscosity of air at 20 degC [Pa s] (handbook)."""
SPECIFIC_GAS = 287.05
"""Specific gas constant of dry air [J/(kg K)] (handbook)."""
TEMPERATURE = 293.15
"""Temperature of the gas in the line [K]: 20 degC, as for the viscosity."""
VAPOUR = 2339.0
"""Vapour pressure of water at 20 degC [Pa] (handbook), below which water boils."""


def flow_ratio(ratio: float, critical: float = CRITICAL) -> float:
    """Return the ratio of flow to choked flow at a ratio of absolute pressures, 0 to 1 (ISO 6358).

    It is 1 up to the critical ratio, then a quarter of an ellipse, and linear from `LAMINAR` to 0
    at equal pressures.
    """
    if ratio > LAMINAR:
        return flow_ratio(LAMINAR, critical) * (1 - ratio) / (1 - LAMINAR)
    x = (ratio - critical) / (1 - critical)
    if x <= 0:
        return 1.0
    return math.sqrt(max(1.0 - x * x, 0.0))


def valve_throughput(
    high: float, low: float, conductance: float, critical: float = CRITICAL
) -> float:
    """Return the throughput from `high` to `low` [Pa absolute]; negative if `low` is higher."""
    if low > high:
        return -valve_throughput(low, high, conductance, critical)
    return conductance * NORMAL * high * flow_ratio(low / high if high > 0 else 1.0, critical)


def tube_conductance(length: float, bore: float) -> float:
    """Return the laminar throughput per difference of squared pressures [m^3/(s Pa)]."""
    return math.pi * bore**4 / (256 * VISCOSITY * length)


def tube_throughput(a: float, b: float, length: float, bore: float) -> float:
    """Return the laminar flow of a gas from a to b [Pa absolute] (Poiseuille)."""
    return tube_conductance(length, bore) * (a * a - b * b)


def leak_throughput(p: float, atmosphere: float, laminar: float, orifice: float) -> float:
    """Return the leak into a chamber at p [Pa absolute]; negative for p above atmospheric."""
    flow = laminar * (atmosphere * atmosphere - p * p) / (2 * atmosphere)
    if orifice:
        high, low = max(p, atmosphere), min(p, atmosphere)
        flow += math.copysign(orifice * high * flow_ratio(low / high), atmosphere - p)
    return flow
