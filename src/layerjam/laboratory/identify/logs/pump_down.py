"""Volume and pump flow from a pump-down log.

A positive-displacement pump of flow S evacuates a volume V of air isothermally: d(pV)/dt = -S (p -
p_u). p_u is the ultimate pressure, at which leak and dead space balance the pump (mechanics,
section 5). At constant V

    p = p_u + (p0 - p_u) exp(-S t/V),

so one log determines S/V and p_u but not S and V: twice the volume with twice the flow gives the
same curve. A known volume, a known flow, or a second log with a known added volume determines both.

A chamber that contracts under vacuum, V = V0 - c (a - p) with a the atmosphere, has a closed form.
With u = p - p_u and A = V0 - c a + 2 c p_u it is A ln(u/u0) + 2 c (u - u0) = -S t. A log then
determines S/V0, c/V0 and p_u.
"""

from dataclasses import dataclass

import numpy as np

from layerjam.core.brief import brief
from layerjam.core.errors import FitError, count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.logs.correlated import Series, check_resolution, fit_series
from layerjam.laboratory.identify.logs.leak import CLEAR
from layerjam.laboratory.identify.statistics import interval_ends
from layerjam.laboratory.measure.trace import Array

LEVEL = 0.95
FEWEST = 20
"""Smallest number of samples of a pump-down."""
FALL = 0.05
"""Smallest fall in pressure of a pump-down, relative to the atmosphere."""


def pressure(
    time: Array,
    start: float,
    ultimate: float,
    rate: float,
    shrink: float = 0.0,
    atmosphere: float = 101325.0,
) -> Array:
    """Return the absolute pressure [Pa] at times [s]; `rate` = S/V0 [1/s], `shrink` = c/V0 [1/Pa].

    V0 is the volume at atmospheric pressure. NaN if the chamber would have collapsed (V ≤ 0).
    """
    excess = start - ultimate
    if shrink == 0 or excess == 0:
        return ultimate + excess * np.exp(-rate * time)
    from scipy.special import wrightomega

    normalised_end = 1 - shrink * atmosphere + 2 * shrink * ultimate
    if normalised_end <= 0 or 1 - shrink * (atmosphere - ultimate) <= 0 or excess < 0:
        return np.full(np.shape(time), np.nan)
    if shrink < 0:
        return _pressure_while_stretching(time, excess, ultimate, rate, shrink, normalised_end)
    weight = 2 * shrink * excess / normalised_end
    omega = wrightomega(np.log(weight) + weight - rate * time / normalised_end)
    return np.asarray(ultimate + normalised_end / (2 * shrink) * omega)


def _pressure_while_stretching(
    time: Array, excess: float, ultimate: float, rate: float, shrink: float, normalised_end: float
) -> Array:
    """Return the pressure in a chamber that stretches (c < 0), by Newton's method in ln u."""
    log = np.full(np.shape(time), 0.0) - rate * time / normalised_end
    for _ in range(60):
        u = excess * np.exp(log)
        slope = normalised_end + 2 * shrink * u
        if (slope <= 0).any():
            return np.full(np.shape(time), np.nan)
        log = log - (normalised_end * log + 2 * shrink * (u - excess) + rate * time) / slope
    return np.asarray(ultimate + excess * np.exp(log))


@brief
@dataclass(frozen=True, kw_only=True)
class PumpDown:
    """Fit to one log: `rate` = S/V0 [1/s], `ultimate`, `start` [Pa, absolute], `shrink` = c/V0.

    `time` [s] from the start of the window and `pressure` [Pa, absolute] have shape (N,).
    `shrink_fitted` means that `series` has a fourth parameter (start, ultimate, rate, shrink).
    """

    shrink: float
    shrink_fitted: bool
    series: Series
    time: Array
    pressure: Array
    atmosphere: float
    window: tuple[float, float]

    @property
    def start(self) -> float:
        """Pressure at the start of the window [Pa, absolute]."""
        return float(self.series.values[0])

    @property
    def ultimate(self) -> float:
        """Pressure at which leak and dead space balance the pump [Pa, absolute]."""
        return float(self.series.values[1])

    @property
    def rate(self) -> float:
        """Rate S/V0 [1/s]."""
        return float(self.series.values[2])

    def interval(self, index: int) -> tuple[float, float]:
        """Return the 95 % interval of a parameter of `series`; all are positive.

        The ultimate pressure never exceeds atmospheric pressure, however uncertain it is.
        """
        low, high = self.series.interval(lambda v: float(v[index]), LEVEL, positive=True)
        return low, (min(high, self.atmosphere) if index == 1 else high)

    def derive(self, value: float, se: float) -> "DerivedValue":
        """Return a value derived from the rate, with the interval of this fit."""
        return DerivedValue(value=value, se=se, quantile=self.series.quantile(LEVEL))

    def curve(self, time: Array) -> Array:
        """Return the fitted pressure [Pa]."""
        return pressure(time, self.start, self.ultimate, self.rate, self.shrink, self.atmosphere)


@dataclass(frozen=True, kw_only=True)
class DerivedValue:
    """A value with its standard error and the half-width of its interval, in standard errors."""

    value: float
    se: float
    quantile: float

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval, symmetric in the logarithm because volumes and flows are positive."""
        return interval_ends(self.value, self.quantile * self.se)


def pump_down_window(
    time: Array, absolute: Array, ends: tuple[float | None, float | None]
) -> Array:
    """Return which samples belong to the pump-down, starting at the last one near the start level.

    By default it begins one sample before the pressure finally falls below its highest level by 2 %
    of the total drop, and ends with the log.
    """
    first, last = ends
    if first is None:
        top, low = float(absolute.max()), float(absolute.min())
        high = np.flatnonzero(absolute >= top - 0.02 * (top - low))
        first = float(time[int(high[-1])])
    end = float(time[-1]) if last is None else last
    return np.asarray((time >= first) & (time <= end))


def select_pump_down(
    time: Array, absolute: Array, atmosphere: float, window: tuple[float | None, float | None]
) -> Array:
    """Return which samples belong to the pump-down; see `pump_down_window`.

    Raises FitError if there are fewer than 20, or if the pressure does not fall.
    """
    is_inside = pump_down_window(time, absolute, window)
    rise = _total_fall(absolute[::-1])
    if window[0] is None and rise > FALL * atmosphere:
        raise FitError(f"its absolute pressure rises by {show(rise, 'Pa')} while the pump runs")
    if is_inside.sum() < FEWEST:
        samples = count_text(int(is_inside.sum()), "sample")
        raise FitError(f"the pump-down has {samples}; {FEWEST} are needed")
    p = absolute[is_inside]
    if float(p.min()) <= 0:
        raise FitError(f"{show(float(p.min()), 'Pa')} is not an absolute pressure")
    if _total_fall(p) < FALL * atmosphere:
        raise FitError(f"the pressure falls by only {show(_total_fall(p), 'Pa')}: not a pump-down")
    return is_inside


def _total_fall(pressure: Array) -> float:
    """Return the fall in pressure [Pa] from the first samples to the last."""
    return float(pressure[:3].mean() - pressure[-max(len(pressure) // 50, 3) :].mean())


def fit_pump_down(
    time: Array,
    absolute: Array,
    *,
    atmosphere: float = 101325.0,
    window: tuple[float | None, float | None] = (None, None),
    shrink: float | None = 0.0,
) -> PumpDown:
    """Fit S/V0 and the ultimate pressure to time [s] and absolute pressure [Pa], shape (N,).

    `shrink` = c/V0 [1/Pa] is a known value; if None, it is fitted too. Raises FitError if fewer
    than 20 samples remain or the pressure does not fall.
    """
    is_inside = select_pump_down(time, absolute, atmosphere, window)
    window_time, p = time[is_inside], absolute[is_inside]
    t, low, fall = window_time - window_time[0], float(p.min()), _total_fall(p)
    check_resolution(p, float(p[-1]), float(t[-1]))
    third = float(t[int(np.argmax(p <= low + (p[0] - low) / np.e))]) or float(t[1])
    first, end = float(p[0]), float(p[-1])
    parameters = [
        (first, fall, 0.5 * first, 1.5 * first),
        (max(low - 0.02 * fall, 1e-3 * low), 0.1 * fall, 0.0, max(end * 1.5, 2 * low)),
        (1 / third, 1 / third, 0.0, np.inf),
    ]
    if shrink is None:
        unit_shrink = 1 / atmosphere
        parameters.append((0.1 / atmosphere, unit_shrink, -0.9 / atmosphere, 0.999 / atmosphere))
    begin, scale, bottom, top = zip(*parameters, strict=True)

    def curve(values: Array) -> Array:
        start, ultimate, rate, *optional = (float(v) for v in values)
        return pressure(
            t, start, ultimate, rate, optional[0] if optional else shrink or 0.0, atmosphere
        )

    solution = fit_series(curve, p, begin, scale, (bottom, top))
    return PumpDown(
        shrink=float(solution.values[3]) if shrink is None else shrink,
        shrink_fitted=shrink is None,
        series=solution,
        time=t,
        pressure=p,
        atmosphere=atmosphere,
        window=(float(window_time[0]), float(window_time[-1])),
    )


def compliance_ratio(volume: float | None, flow: float | None, loss: float, fit: PumpDown) -> float:
    """Return c/V0 [1/Pa] for a volume loss c [m³/Pa]; if only the flow is known, V0 = S/rate.

    `fit` is a fit at constant volume, whose rate is a first guess.
    """
    base = volume if volume is not None else (flow or 0.0) / fit.rate
    if base <= loss * fit.atmosphere:
        raise FitError(
            f"compliance: {show(loss * 1e9, '1')} mL/kPa would reduce a volume of "
            f"{base * 1e6:.4g} mL to zero at a vacuum of {show(base / loss, 'Pa')}"
        )
    return loss / base


def is_flexible_better(constant: PumpDown, flexible: PumpDown) -> bool:
    """Return whether a volume that changes with vacuum fits the log clearly better."""
    return constant.series.excess_over(flexible.series) > CLEAR


def pump_flow(fit: PumpDown, volume: float) -> DerivedValue:
    """Return the pump flow S [m³/s] for a known volume V0 [m³]."""
    return fit.derive(volume * fit.rate, volume * float(fit.series.standard_errors[2]))


def chamber_volume(fit: PumpDown, flow: float) -> DerivedValue:
    """Return the volume V0 [m³] for a known pump flow S [m³/s]."""
    se = float(fit.series.standard_errors[2])
    return fit.derive(flow / fit.rate, flow * se / fit.rate**2)


def combine_logs(
    single: PumpDown, joint: PumpDown, volume: float
) -> tuple[DerivedValue, DerivedValue]:
    """Return (V0, S) from two logs, one with an added known volume [m³]: V0 = ΔV k2/(k1 - k2).

    The volumes are constant. Raises FitError unless the two rates differ by more than their
    uncertainty.
    """
    from scipy.stats import t

    k1, k2 = single.rate, joint.rate
    s1, s2 = (float(f.series.standard_errors[2]) for f in (single, joint))
    freedom = (s1**2 + s2**2) ** 2 / (
        s1**4 / single.series.freedom + s2**4 / joint.series.freedom + 1e-300
    )
    quantile = float(t.ppf(0.5 + LEVEL / 2, max(freedom, 1.0)))
    if k1 - k2 <= quantile * np.hypot(s1, s2):
        raise FitError(
            f"added volume: the rates {show(k1, '1/s')} without it and {show(k2, '1/s')} with it "
            "do not differ by more than their uncertainty; add a larger volume, or swap the logs"
        )
    gap = k1 - k2
    inner_volume, flow = volume * k2 / gap, volume * k1 * k2 / gap
    inside_se = volume * float(np.hypot(k2 * s1, k1 * s2)) / gap**2
    flow_se = volume * float(np.hypot(k2**2 * s1, k1**2 * s2)) / gap**2
    return (
        DerivedValue(value=inner_volume, se=inside_se, quantile=quantile),
        DerivedValue(value=flow, se=flow_se, quantile=quantile),
    )
