"""Lines, sensors and controllers that several tests share."""

from __future__ import annotations

from typing import Any

from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.brake.fluid.line import Sensor

AIR = Plant(rate=3.33 / 7.503, top=101325.0, leak=0.002, vent=5.0)
"""The paper's line, with a leak and a vent that are ours."""
WATER = Plant(rate=3.33 / 0.06607 / 98.0, top=98e3, leak=0.001, vent=8.0, water=True)
IDEAL = Sensor(range=103e3)
NOISY = Sensor(range=103e3, lag=0.005, noise=50.0, resolution=25.0)
COARSE = Sensor(range=103e3, lag=0.02, noise=2.0, resolution=100.0)


def regulator(**changes: Any) -> Regulator:
    """A regulator of the paper's line that releases on a fault."""
    made: dict[str, Any] = {"plant": AIR, "sensor": NOISY, "safe_state": "release"}
    return Regulator(**(made | changes))
