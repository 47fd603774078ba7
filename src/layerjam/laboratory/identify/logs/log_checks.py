"""Checks of logs: whether a law describes them, and whether they determine its parameters."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from layerjam.brake.simulate.accelerometer import STANDARD_GRAVITY
from layerjam.core.units import show
from layerjam.core.verdict import Check, Level, check, interval_check
from layerjam.laboratory.identify.load_cell import LARGE
from layerjam.laboratory.identify.logs.correlated import Series
from layerjam.laboratory.identify.logs.crash import Crash
from layerjam.laboratory.identify.logs.leak import Leak, LeakFit
from layerjam.laboratory.identify.logs.pump_down import PumpDown
from layerjam.laboratory.measure.trace import Array

CLEAN = 3.0
"""Largest ratio of residual RMS to sensor noise at which a law describes a log."""
MISSES = 0.1
"""Ratio of residual RMS to pressure change above which the law does not describe the log at all."""
FALLEN = 0.9
"""Fraction of the pressure drop to the ultimate pressure that a pump-down log must contain."""
AT_REST = 0.1
"""Largest deviation [g] of a sensor at rest from 0 g (axis level) or 1 g (axis upright)."""
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


def check_crash(impact: Crash, falling: bool = False) -> Iterator[Check]:
    """Yield the checks of an impact: the sensor's range and the log contain the whole pulse.

    `falling` states that the sensor was in free fall before the event.
    """
    level: Level = "passed"
    sentence = "the sensor's range contains the peak"
    if impact.saturation is not None:
        limit = impact.saturation / STANDARD_GRAVITY
        level = "failed"
        sentence = f"saturated at {limit:.4g} g: the peaks and the velocity change are lower bounds"
    elif impact.flat_top is not None:
        limit = impact.flat_top / STANDARD_GRAVITY
        level, sentence = "warning", f"the sensor may be saturated: flat at {limit:.4g} g"
    yield check("saturation", level == "passed", sentence, level=level)
    sentence = "the log contains the whole pulse"
    if not impact.whole:
        sentence = "the log ends during the pulse: the velocity change is incomplete"
    yield check("whole pulse", impact.whole, sentence, level="failed")
    count = sum(gap.missing for gap in impact.pulse_gaps)
    sentence = (
        f"{', '.join(map(str, impact.pulse_gaps))}"
        if count
        else "no sample of the pulse is missing"
    )
    consequence = ": the values between their neighbours are interpolated, not measured"
    yield check("gaps", not count, sentence, consequence, "failed" if count > 1 else "warning")
    value, error = abs(impact.velocity_change), impact.velocity_change_se
    half_width = 1.96 * error
    yield interval_check("velocity change", value, value - half_width, value + half_width)
    yield _check_rest(impact, falling)


def _check_rest(impact: Crash, falling: bool) -> Check:
    """Check the reading before the event, which is subtracted: a sensor at rest reads 0 or 1 g.

    Subtraction removes a zero error. A sensor that falls reads 0 g; if it reads 1 g it was at rest,
    and gravity must not be subtracted from the velocity change.
    """
    reading = impact.offset / STANDARD_GRAVITY
    sentence = f"before the event the sensor reads {reading:+.2g} g, which is subtracted"
    if falling and abs(abs(reading) - 1) < AT_REST:
        share = STANDARD_GRAVITY * impact.duration / abs(impact.velocity_change)
        level: Level = "failed" if share > LARGE else "warning"
        advice = f", as at rest: omit --falling, which changes the velocity change by {share:.0%}"
        return check("zero", False, sentence, advice, level)
    is_at_rest = min(abs(reading), abs(abs(reading) - 1)) < AT_REST
    advice = ". It is neither 0 nor 1 g: the sensor is tilted, or its zero or scale is wrong"
    return check("zero", is_at_rest, sentence, advice, "note")


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
