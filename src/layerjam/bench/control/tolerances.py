"""Differences between a bench and its model within which the fault detectors work as stated.

A bench within these tolerances causes no false fault, and each fault is detected within its stated
time.
"""

from dataclasses import dataclass

from layerjam.core.units import quantity


@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """Tolerances of a controller's detectors; the defaults cover the parts in the catalogue."""

    pump: float = quantity("1", "relative error of the pump's flow", hi=0.5, default=0.2)
    vent: float = quantity("1", "relative error of the vent's flow", hi=0.9, default=0.3)
    zero: float = quantity(
        "1", ("zero error of the sensor, as a fraction of its range"), hi=0.1, default=0.01
    )
    lag: float = quantity(
        "s", "longest lag of the sensor, unless a longer one is given", hi=10, default=0.05
    )
    noise: float = quantity(
        "1", "largest noise of a reading relative to the stated noise", lo=1, hi=20, default=4.0
    )


EXACT = Tolerances(pump=0.0, vent=0.0, zero=0.0, lag=0.0, noise=1.0)
"""Tolerances for a bench that is identical to its model."""
