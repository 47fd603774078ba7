"""Throughput of one pump, from its displacement or its flow curve.

With a displacement, q = flow (p - ultimate), for a pump that displaces a constant volume and
retains some gas. With a flow curve, the throughput depends on the ratio of p to the atmosphere,
because a pump moves volumes; the curve's free air is at this atmosphere. At STANDARD this agrees
with the data sheet. At altitude the maximum vacuum falls in proportion to atmospheric pressure.
"""

from layerjam.brake.fluid.line import Pump
from layerjam.brake.fluid.pump_curve import STANDARD, free_flow
from layerjam.core.errors import QuantityError


def pump_throughput(p: float, pump: Pump, atmosphere: float) -> float:
    """Return the throughput [Pa m^3/s] of one pump at full power, at p [Pa absolute], or 0."""
    if pump.curve is not None:
        return atmosphere * free_flow((1 - p / atmosphere) * STANDARD, pump.curve)
    return _pump_displacement(pump) * max(p - pump.ultimate, 0.0)


def _pump_displacement(pump: Pump) -> float:
    if pump.flow is None:
        raise QuantityError.of("pump.flow", "is not known, and the pump has no flow curve")
    return pump.flow


def lowest_pressure(pump: Pump, atmosphere: float) -> float:
    """Return the lowest absolute pressure [Pa] that a pump reaches without a leak."""
    if pump.curve is not None:
        return atmosphere * (1 - pump.curve[-1][0] / STANDARD)
    return pump.ultimate


def inlet_flow(pump: Pump) -> float:
    """Return the displacement of one pump, or its inlet flow at zero vacuum [m^3/s]."""
    if pump.curve is not None:
        return pump.curve[0][1]
    return _pump_displacement(pump)


def require_known_water_flow(pump: Pump) -> None:
    """Raise QuantityError for a pump whose flow is known only for air."""
    if pump.curve is not None:
        raise QuantityError.of(
            "pump.curve", "is a flow of free air and does not apply to water; give pump.flow"
        )


def curve_points(pump: Pump, atmosphere: float) -> list[float]:
    """Return the absolute pressures [Pa], falling; between them the throughput is linear in p."""
    if pump.curve is None:
        return [pump.ultimate]
    return [atmosphere * (1 - vacuum / STANDARD) for vacuum, _ in pump.curve]


def displacement_at_pressure(p: float, pump: Pump, atmosphere: float) -> float:
    """Return the displacement [m^3/s] giving this pump's intake at p and its lowest pressure."""
    if pump.curve is None:
        return inlet_flow(pump)
    low = lowest_pressure(pump, atmosphere)
    # at or below the lowest pressure, use the last section of the curve
    pressure = max(p, curve_points(pump, atmosphere)[-2]) if p <= low else p
    return pump_throughput(pressure, pump, atmosphere) / (pressure - low)
