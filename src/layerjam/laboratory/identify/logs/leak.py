"""Leak from a pressure-hold log: the return of a closed chamber to atmospheric pressure.

For a rigid isothermal chamber of volume V, V dp/dt = -q, with q the leak [Pa m³/s] out of it. With
p absolute and a the atmosphere,

    linear    q = C (p - a)                  p - a falls as exp(-t/τ), τ = V/C
    laminar   q = C (p² - a²)/(2a)           Poiseuille with the gas's density along the leak
    orifice   q = C p₁ φ(p₂/p₁)              ISO 6358: φ = 1 to the critical ratio b (choked), then
                                             √(1 - ((r - b)/(1 - b))²), the root of the difference

The index 1 is the side of higher pressure; b = 0.528, that of a lossless nozzle. All three have
closed forms above and below atmospheric pressure. C is the conductance at a small pressure
difference for the first two, the sonic conductance for an orifice.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from layerjam.brake.fluid.closed_forms import held_vacuum
from layerjam.core.brief import brief
from layerjam.core.errors import FitError, UnknownNameError
from layerjam.core.units import show
from layerjam.laboratory.identify.logs.correlated import Series, check_resolution, fit_series
from layerjam.laboratory.measure.trace import Array

MODELS = ("linear", "laminar", "orifice")
CRITICAL = 0.528
FEWEST = 20
"""Smallest number of samples of a hold."""
STANDARD_TEMPERATURE = 273.15
SCCM = 101325.0 * 1e-6 / 60
"""One standard cubic centimetre per minute (0 °C, 101325 Pa) in Pa m³/s at 0 °C."""
CLEAR = 6.0
"""Twice the difference in log likelihood above which one model is clearly better."""


def pressure(model: str, time: Array, start: float, rate: float, atmosphere: float) -> Array:
    """Return the absolute pressure [Pa] at times [s] after `start` [Pa]; `rate` is C/V [1/s]."""
    y0 = start / atmosphere
    if model == "linear":
        return atmosphere * (1 + (y0 - 1) * np.exp(-rate * time))
    if model == "laminar":
        depression: Array = held_vacuum(time, atmosphere - start, rate, atmosphere)
        return atmosphere - depression
    if model == "orifice":
        if y0 >= 1:
            return atmosphere / _overpressure_ratio(_overpressure_scaled_time(1 / y0) + rate * time)
        return atmosphere * _subatmospheric_ratio(_subatmospheric_scaled_time(y0) + rate * time)
    raise UnknownNameError("leak model", model, MODELS)


def flow(model: str, p: float, rate: float, atmosphere: float) -> float:
    """Return q/V [Pa/s] at an absolute pressure p [Pa]; positive out of the chamber."""
    if model == "linear":
        return rate * (p - atmosphere)
    if model == "laminar":
        return rate * (p * p - atmosphere**2) / (2 * atmosphere)
    if model == "orifice":
        high, low = max(p, atmosphere), min(p, atmosphere)
        excess = max(low / high - CRITICAL, 0.0) / (1 - CRITICAL)
        return float(np.sign(p - atmosphere)) * rate * high * float(np.sqrt(1 - excess * excess))
    raise UnknownNameError("leak model", model, MODELS)


# the scaled time s of an orifice is ds = dt C/V, zero when the flow ceases to be choked
def _subatmospheric_scaled_time(ratio: float) -> float:
    excess = (ratio - CRITICAL) / (1 - CRITICAL)
    return ratio - CRITICAL if excess <= 0 else (1 - CRITICAL) * float(np.arcsin(excess))


def _subatmospheric_ratio(clock: Array) -> Array:
    """Return the ratio of inside to outside pressure; 1 once the pressures are equal."""
    angle = np.minimum(clock / (1 - CRITICAL), np.pi / 2)
    return np.where(clock < 0, CRITICAL + clock, CRITICAL + (1 - CRITICAL) * np.sin(angle))


_ROOT = float(np.sqrt(2 * CRITICAL - 1))


def _tangent_integral(tangent: Array | float) -> Array:
    """Return ∫ dθ/(b + (1 - b) sin θ) up to tan(θ/2)."""
    return np.asarray(2 / _ROOT * np.arctan((CRITICAL * tangent + 1 - CRITICAL) / _ROOT))


def _overpressure_scaled_time(ratio: float) -> float:
    excess = (ratio - CRITICAL) / (1 - CRITICAL)
    if excess <= 0:
        return float(np.log(ratio / CRITICAL))
    tangent = np.tan(np.arcsin(excess) / 2)
    return float((1 - CRITICAL) * (_tangent_integral(tangent) - _tangent_integral(0.0)))


def _overpressure_ratio(clock: Array) -> Array:
    """Return the ratio of outside to inside pressure; 1 once the pressures are equal."""
    end = (1 - CRITICAL) * (_tangent_integral(1.0) - _tangent_integral(0.0))
    clipped_clock = np.clip(clock, 0.0, end)
    angle = (clipped_clock / (1 - CRITICAL) + _tangent_integral(0.0)) * _ROOT / 2
    tangent = (_ROOT * np.tan(angle) - (1 - CRITICAL)) / CRITICAL
    late_ratio = CRITICAL + (1 - CRITICAL) * np.sin(2 * np.arctan(tangent))
    return np.where(
        clock < 0, CRITICAL * np.exp(np.minimum(clock, 0.0)), np.minimum(late_ratio, 1.0)
    )


@dataclass(frozen=True, kw_only=True)
class LeakFit:
    """One model: `start` [Pa, absolute], `rate` = C/V [1/s], the sensor's `zero` [Pa] or None."""

    model: str
    start: float
    rate: float
    zero: float | None
    series: Series

    def curve(self, time: Array, atmosphere: float) -> Array:
        """Return the reading [Pa, absolute, with the zero error] at times [s] in the window."""
        return pressure(self.model, time, self.start, self.rate, atmosphere) + (self.zero or 0.0)

    def rate_interval(self) -> tuple[float, float]:
        """Return the 95 % interval of the rate."""
        return self.series.interval(lambda v: float(v[1]), positive=True)

    def flow_interval(self, p: float, atmosphere: float) -> tuple[float, float, float]:
        """Return q/V [Pa/s] at a pressure, and its 95 % interval."""

        def leak_flow(values: Array) -> float:
            return flow(self.model, p, float(values[1]), atmosphere)

        return (leak_flow(self.series.values), *self.series.interval(leak_flow, positive=True))


@brief
@dataclass(frozen=True, kw_only=True)
class Leak:
    """All models of one log; `pressure` [Pa, absolute], `time` [s] from the window's start, (N,).

    `best` is the model with the smallest RMSE (all have the same number of parameters). `distinct`
    means that it is clearly better, given the correlation of its residuals. `mean` is the window's
    mean pressure, `heat` the change of temperature [K] that alone would explain the change of
    pressure.
    """

    fits: Mapping[str, LeakFit]
    best: str
    distinct: bool
    time: Array
    pressure: Array
    atmosphere: float
    window: tuple[float, float]
    mean: float
    heat: float
    warnings: tuple[str, ...]


def fit_leak(
    time: Array,
    absolute: Array,
    *,
    atmosphere: float = 101325.0,
    window: tuple[float | None, float | None] = (None, None),
    temperature: Array | float = 293.15,
) -> Leak:
    """Fit the leak models to a log of time [s] and absolute pressure [Pa], each of shape (N,).

    `window` [s] is the section used; by default it starts at the largest difference from the
    atmosphere. `temperature` [K] of the gas is one value or one per sample; pressures are first
    converted to the mean temperature. Raises FitError if fewer than 20 samples, or no difference
    from the atmosphere, remain.
    """
    warnings = []
    first, last = select_hold(time, absolute, atmosphere, window)
    if window[0] is None and first > time[0] + 0.05 * (time[-1] - time[0]):
        warnings.append(
            f"the pressure differs most from atmospheric at {show(first, 's')}; earlier samples "
            "are not used (change the start with --from)"
        )
    is_inside = (time >= first) & (time <= last)
    warm = np.broadcast_to(np.asarray(temperature, float), time.shape)[is_inside]
    t, p = time[is_inside] - first, absolute[is_inside]
    middle = float(warm.mean())
    p = p * middle / warm
    ends = _average_end(p, len(p) // 20), _average_end(p[::-1], len(p) // 20)
    difference = ends[0] - atmosphere
    settled = abs(ends[1] - atmosphere) < 0.1 * abs(difference) and (
        abs(_average_end(p[len(p) // 2 :], len(p) // 20) - ends[1]) < 0.02 * abs(difference)
    )
    if settled:
        check_resolution(p, ends[1], last - first)
    fits = {m: _fit_model(m, t, p, atmosphere, ends, settled) for m in MODELS}
    order = sorted(fits, key=lambda m: fits[m].series.rmse)
    best = fits[order[0]]
    distinct = all(fits[m].series.excess_over(best.series) > CLEAR for m in order[1:])
    if settled:
        warnings.append(
            "the record reaches its final level, so the sensor's zero is fitted too: "
            f"{show(best.zero, 'Pa')} at atmospheric pressure"
        )
    return Leak(
        fits=fits,
        best=order[0],
        distinct=distinct,
        time=t,
        pressure=p,
        atmosphere=atmosphere,
        window=(first, last),
        mean=float(p.mean()),
        heat=middle * (ends[1] / ends[0] - 1),
        warnings=tuple(warnings),
    )


def select_hold(
    time: Array, absolute: Array, atmosphere: float, window: tuple[float | None, float | None]
) -> tuple[float, float]:
    """Return the start and end [s] of the hold in a log; see `fit_leak`.

    Raises FitError if it has fewer than 20 samples, or if the pressure is not held above or below
    atmospheric pressure.
    """
    gap = np.abs(absolute - atmosphere)
    first = float(time[int(np.argmax(gap))]) if window[0] is None else window[0]
    last = float(time[-1]) if window[1] is None else window[1]
    gauge = (absolute - atmosphere)[(time >= first) & (time <= last)]
    count = len(gauge)
    if count < FEWEST:
        samples = "1 sample" if count == 1 else f"{count} samples"
        fault = f"only {samples} lie between {show(first, 's')} and {show(last, 's')}"
        if window[0] is None:
            fault = (
                f"its pressure moves away from atmospheric pressure until {show(first, 's')}, "
                f"with only {samples} from there on"
            )
        raise FitError(f"{fault}; a hold needs {FEWEST}")
    difference = _average_end(gauge, count // 20)
    if abs(difference) < 1e-4 * atmosphere:
        raise FitError(
            f"the hold begins {show(abs(difference), 'Pa')} from atmospheric pressure: no "
            "pressure difference is held"
        )
    if (gauge * difference < -0.1 * difference**2).any():
        raise FitError("the log crosses atmospheric pressure, so it is not a hold")
    return first, last


def _average_end(values: Array, count: int) -> float:
    return float(np.mean(values[: max(count, 1)]))


def _fit_model(
    model: str, t: Array, p: Array, atmosphere: float, ends: tuple[float, float], settled: bool
) -> LeakFit:
    span = float(t[-1]) or 1.0
    floor = 0.02 * (ends[0] - atmosphere)
    remaining = max((ends[1] - atmosphere) / (ends[0] - atmosphere), 0.02)
    guess = -np.log(remaining) / span
    if settled:  # count from the time at which half of the difference is gone
        is_near_end = np.abs(p - atmosphere) < 0.5 * abs(ends[0] - atmosphere)
        guess = np.log(2) / max(float(t[int(np.argmax(is_near_end))]), span / len(t))
    if model != "linear":  # start with the same flow as the linear model
        guess *= flow("linear", ends[0], 1.0, atmosphere) / flow(model, ends[0], 1.0, atmosphere)
    bounds = (1e-6 * atmosphere, atmosphere) if ends[0] < atmosphere else (atmosphere, np.inf)
    parameters = [
        (ends[0], abs(floor), *bounds),
        (guess, max(abs(guess), 1e-3 / span), -np.inf, np.inf),
        *[(0.0, abs(floor), -np.inf, np.inf)] * settled,
    ]
    start, scale, low, high = zip(*parameters, strict=True)

    def curve(values: Array) -> Array:
        law = pressure(model, t, float(values[0]), float(values[1]), atmosphere)
        return law + (float(values[2]) if settled else 0.0)

    solution = fit_series(curve, p, start, scale, (low, high))
    initial, rate, *zero = map(float, solution.values)
    return LeakFit(
        model=model, start=initial, rate=rate, zero=zero[0] if zero else None, series=solution
    )


def to_sccm(throughput: float, temperature: float) -> float:
    """Return a leak [Pa m³/s at `temperature`, K] in standard cm³/min (0 °C, 101325 Pa)."""
    return throughput * STANDARD_TEMPERATURE / temperature / SCCM
