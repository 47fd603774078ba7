"""PI gains from a plant model, and the plant model from one recorded step response.

Near a vacuum v the plant answers the pump command like K/(1 + s tau) with K/tau = k (top - w v),
tau = 1/(w k u + leak). The rule is SIMC (Skogestad, Journal of Process Control 13, 2003, 291-309):

gain = 1/((K/tau) (T_c + theta)), integral time = min(tau, 4 (T_c + theta)).

The dead time theta is half a sample (for a held command) plus the sensor's full lag. The paper's
half rule would use half of the lag and leave a phase margin of 34 degrees on an integrating line;
with the full lag it is at least 40 degrees. T_c is the closed loop's time constant. The rule's
tight choice is T_c = theta. Here T_c is also at least four samples and a twentieth of the pump's
1/k, so that the pump does not follow noise.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.bench.control.plant import Plant
from layerjam.core.errors import FitError
from layerjam.core.units import show
from layerjam.core.verdict import Check, interval_check

Array = np.ndarray[Any, np.dtype[np.float64]]
LEAST_ROOM = 0.05
"""Smallest fraction of the pump's vacuum in the gain schedule, as in the law."""


@dataclass(frozen=True, kw_only=True)
class Gains:
    """Gains from the rule, applied at `vacuum` [Pa]."""

    gain: float
    """Pump command per pascal of error [1/Pa]."""
    integral_time: float
    """Integral time [s]."""
    dead_time: float
    """theta [s]."""
    closed_loop_time: float
    """T_c [s]."""
    vacuum: float


def simc_gains(plant: Plant, *, sample_time: float, lag: float, vacuum: float = 0.0) -> Gains:
    """Return the PI gains for a plant at `vacuum` [Pa] by this module's rule; times are in s."""
    dead = 0.5 * sample_time + lag
    closed_loop_time = max(dead, 4 * sample_time, 0.05 / plant.rate)
    margin = max(plant.top - plant.weight * vacuum, LEAST_ROOM * plant.top)
    leak_share = plant.leak * vacuum / (plant.rate * margin)
    pole = plant.weight * plant.rate * min(leak_share, 1.0) + plant.leak
    longest = 4 * (closed_loop_time + dead)
    return Gains(
        gain=1.0 / (plant.rate * margin * (closed_loop_time + dead)),
        integral_time=min(1.0 / pole, longest) if pole else longest,
        dead_time=dead,
        closed_loop_time=closed_loop_time,
        vacuum=vacuum,
    )


@dataclass(frozen=True)
class Identified:
    """A plant fitted to a step response, with 95 % confidence intervals."""

    plant: Plant
    rate_interval: tuple[float, float]
    """Interval of the pole k + leak [1/s] (air), or of the ratio of rise to `top` (water)."""
    reach_interval: tuple[float, float]
    """Interval of the final vacuum of the step [Pa]."""
    noise: float
    """Standard deviation of a reading [Pa], from the residuals of the fit."""
    checks: tuple[Check, ...]


def identify_air(
    time: Array, vacuum: Array, *, vent: float, leak: float = 0.0, atmosphere: float = 101325.0
) -> Identified:
    """Fit the plant to times [s] and vacuums [Pa], shape (N,), at full power from zero vacuum.

    One step determines the pole k + leak and the final vacuum; `leak` [1/s] (from a hold log)
    separates pump and leak, and `vent` [1/s] is assumed. Raises FitError if there is no pump-down
    or the leak exceeds the pole.
    """
    from layerjam.laboratory.identify.logs.log_checks import check_pump_downs
    from layerjam.laboratory.identify.logs.pump_down import fit_pump_down

    fit = fit_pump_down(np.asarray(time, float), atmosphere - np.asarray(vacuum, float))
    if leak >= fit.rate:
        raise FitError(
            f"leak: {show(leak, '1/s')} is not below the step's own rate of {show(fit.rate, '1/s')}"
        )
    rate, ultimate_vacuum = fit.rate - leak, atmosphere - fit.ultimate
    low, high = fit.interval(1)
    plant = Plant(rate=rate, top=ultimate_vacuum * fit.rate / rate, leak=leak, vent=vent)
    ends = (atmosphere - high, atmosphere - low)
    pole = fit.interval(2)
    checks = (*check_pump_downs([fit], {}), interval_check("rate", fit.rate, *pole))
    return Identified(plant, pole, ends, float(fit.series.noise), checks)


def identify_water(
    time: Array, vacuum: Array, *, vent: float, top: float, leak: float = 0.0
) -> Identified:
    """Return the plant for water, from a straight-line fit to 5 to 90 % of the rise to `top` [Pa].

    Raises FitError for fewer than 20 samples in this range, or if the fitted line does not rise.
    """
    time, vacuum = np.asarray(time, float), np.asarray(vacuum, float)
    high = float(vacuum.max())
    first = int(np.argmax(vacuum >= 0.05 * high))
    last = int(np.argmax(vacuum >= 0.9 * high))
    t, v = time[first:last], vacuum[first:last]
    if len(t) < 20:
        raise FitError(f"the rise has {len(t)} samples; at least 20 are needed")
    slope, level = np.polyfit(t, v, 1)
    residuals = v - (slope * t + level)
    noise = float(np.sqrt(residuals @ residuals / (len(t) - 2)))
    error = 1.96 * noise / float(np.sqrt(((t - t.mean()) ** 2).sum()))
    if slope - error <= 0:
        raise FitError("the vacuum does not rise, so this is not the step response of a water line")
    rise = float(slope) + leak * float(v.mean())
    plant = Plant(rate=rise / top, top=top, leak=leak, vent=vent, water=True)
    pole = (rise - error) / top, (rise + error) / top
    return Identified(plant, pole, (top, top), noise, (interval_check("rate", rise / top, *pole),))
