"""Checks of logs: whether a law describes them, and whether they determine its parameters."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from layerjam.identify.logs.correlated import Series
from layerjam.identify.logs.crash import Crash
from layerjam.identify.logs.leak import Leak, LeakFit
from layerjam.identify.logs.pump_down import PumpDown
from layerjam.measure.trace import Array
from layerjam.simulate.accelerometer import STANDARD_GRAVITY
from layerjam.units import show
from layerjam.verdict import Check, Level, check, interval_check

CLEAN = 3.0
"""Largest ratio of residual RMS to sensor noise at which a law describes a log."""
MISSES = 0.1
"""Ratio of residual RMS to pressure change above which the law does not describe the log at all."""
FALLEN = 0.9
"""Fraction of the pressure drop to the ultimate pressure that a pump-down log must contain."""
GAS_CHANGE, ROOM_CHANGE = 10.0, 0.5
"""Changes of gas and room temperature [K] whose effect the pressure change must exceed."""


def check_leak(leak: Leak, best: LeakFit, logged: bool) -> Iterator[Check]:
    """Yield the checks of a pressure hold; `logged` states whether its temperature was logged."""
    advice = "another effect is present (a valve, cooling, a compliant wall)"
    yield _check_law(best.series, best.curve(leak.time, leak.atmosphere), advice)
    yield interval_check("leak", best.rate, *best.rate_interval())
    if not logged:
        level: Level = "failed" if abs(leak.heat) <= ROOM_CHANGE else "warning"
        change = "cooling" if leak.heat < 0 else "warming"
        yield check(
            "temperature",
            abs(leak.heat) > GAS_CHANGE,
            f"a {change} of {abs(leak.heat):.2g} K alone would change the pressure as much as the "
            "log shows",
            "; log the temperature too, or hold longer",
            level,
        )


def check_pump_downs(
    logs: Iterable[PumpDown], intervals: Mapping[str, tuple[float, float, float]]
) -> Iterator[Check]:
    """Yield the checks of pump-downs; `intervals` is {quantity: (value, low, high)}."""
    advice = "the volume or the flow changes with vacuum (for the volume, try --compliance fit)"
    for log in logs:
        yield _check_law(log.series, log.curve(log.time), advice)
        fall_share = (log.start - float(log.pressure[-1])) / (log.start - log.ultimate)
        sentence = f"the log ends at {fall_share:.0%} of the fall to the ultimate pressure"
        consequence = ", which is therefore an extrapolation"
        yield check("ultimate pressure", fall_share >= FALLEN, sentence, consequence)
    for name, (value, low, high) in intervals.items():
        yield interval_check(name, value, low, high)


def check_crash(impact: Crash) -> Iterator[Check]:
    """Yield the checks of an impact: the sensor's range and the log contain the whole pulse."""
    sentence = "the sensor's range contains the peak"
    if impact.saturation is not None:
        level = impact.saturation / STANDARD_GRAVITY
        sentence = f"saturated at {level:.4g} g: the peaks and the velocity change are lower bounds"
    yield check("saturation", impact.saturation is None, sentence, level="failed")
    sentence = "the log contains the whole pulse"
    if not impact.whole:
        sentence = "the log ends during the pulse: the velocity change is incomplete"
    yield check("whole pulse", impact.whole, sentence, level="failed")
    value, error = abs(impact.velocity_change), impact.velocity_change_se
    reach = 1.96 * error
    yield interval_check("velocity change", value, value - reach, value + reach)


def _check_law(series: Series, curve: Array, cause: str) -> Check:
    """Return the check that the best law describes a log; `cause` is the likely reason if not."""
    share = series.rmse / float(np.ptp(curve))
    times = series.rmse / series.noise if series.noise > 0 else 0.0
    level: Level = "failed" if share > MISSES else "warning"
    return check(
        "law",
        times <= CLEAN,
        f"the best law deviates from the log by {show(series.rmse, 'Pa')} (RMSE), "
        f"{times:.2g} times the sensor's noise and {share:.2g} of the log's change",
        f": {cause}; try part of the log (--from, --to)",
        level,
    )
