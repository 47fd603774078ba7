"""Plant and sensor over one sample: exactly, or numerically if there is a tube."""

from layerjam.bench.control.exact import Rates
from layerjam.bench.control.through_tube import advance


def advance_plant(
    vacuum: float,
    side: float,
    gauge: float,
    factors: tuple[float, ...],
    plant: Rates,
    dt: float,
    lag: float,
    left: float,
) -> tuple[float, float, float]:
    """Return (vacuum of chamber, vacuum at the pump, vacuum that the sensor shows) [Pa].

    `factors` are those of `exact.step_factors` for a sample of `dt` [s]. `left` is
    1 - exp(-dt/lag), or 1 if the sensor has no lag.
    """
    a, b, gain, effect = factors
    if plant.side > 0.0:  # the leak is at the chamber, not at the pump
        return advance(vacuum, side, gauge, a, b - plant.leak, plant, dt, lag)
    slope = a - b * vacuum
    vacuum_after = vacuum + slope * gain
    if vacuum_after > plant.top:
        vacuum_after, slope = plant.top, (plant.top - vacuum) / gain
    shown = gauge + left * (vacuum - gauge) + slope * effect if lag > 0.0 else vacuum_after
    return vacuum_after, side, shown
