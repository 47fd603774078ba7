"""What one pump takes in, by its displacement or by its flow curve.

Displacement: q = flow (p - ultimate), of a pump that displaces the same volume again and again and
keeps some gas back. Flow curve: a pump moves volumes, so that what it does hangs on p over the
atmosphere it blows into, and the free air of its curve is counted at that atmosphere. At STANDARD
that is the data sheet; at altitude the greatest vacuum is less in proportion to the atmosphere.
"""

from __future__ import annotations

from layerjam.errors import QuantityError
from layerjam.fluid.curve import STANDARD, free_flow
from layerjam.fluid.line import Pump


def intake(p: float, pump: Pump, atmosphere: float) -> float:
    """Throughput [Pa m^3/s] of one pump, full on, at p [Pa absolute]; 0 below its lowest."""
    if pump.curve is not None:
        return atmosphere * free_flow((1 - p / atmosphere) * STANDARD, pump.curve)
    return _displacement(pump) * max(p - pump.ultimate, 0.0)


def _displacement(pump: Pump) -> float:
    if pump.flow is None:
        raise QuantityError.of("pump.flow", "is not known, and the pump has no flow curve")
    return pump.flow


def lowest_pressure(pump: Pump, atmosphere: float) -> float:
    """Absolute pressure [Pa] at which a pump without leak takes in no more."""
    if pump.curve is not None:
        return atmosphere * (1 - pump.curve[-1][0] / STANDARD)
    return pump.ultimate


def inlet_flow(pump: Pump) -> float:
    """Displacement of one pump, or the flow at its inlet without vacuum [m^3/s]."""
    if pump.curve is not None:
        return pump.curve[0][1]
    return _displacement(pump)


def check_water(pump: Pump) -> None:
    """Raise QuantityError for a pump of which only the flow of air is known."""
    if pump.curve is not None:
        raise QuantityError.of(
            "pump.curve", "is the flow of free air, which says nothing of water; give pump.flow"
        )


def points(pump: Pump, atmosphere: float) -> list[float]:
    """Absolute pressures [Pa], falling, between which a pump's throughput is straight in p."""
    if pump.curve is None:
        return [pump.ultimate]
    return [atmosphere * (1 - vacuum / STANDARD) for vacuum, _ in pump.curve]


def displacement_at(p: float, pump: Pump, atmosphere: float) -> float:
    """Displacement [m^3/s] of the pump that takes in as much at p and comes down as low."""
    if pump.curve is None:
        return inlet_flow(pump)
    low = lowest_pressure(pump, atmosphere)
    # at or below the lowest pressure: the curve's last stretch
    at = max(p, points(pump, atmosphere)[-2]) if p <= low else p
    return intake(at, pump, atmosphere) / (at - low)
