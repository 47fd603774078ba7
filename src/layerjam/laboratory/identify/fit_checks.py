"""Checks of a fit: whether its parameters are plausible, in plain sentences."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.core.units import show
from layerjam.core.verdict import Check, Level, check, interval_check
from layerjam.laboratory.identify.statistics import fit_line
from layerjam.laboratory.measure.trace import Array

__all__ = ["Check", "check"]

PLAUSIBLE = (0.5, 2.0)
"""Range of plausible scale factors; those in the paper are 0.875 and 1.24."""
POSSIBLE = (0.3, 3.0)
"""Range outside which a scale factor fails, because the film or a unit must be wrong."""
SMALL = 0.05
"""Relative change or difference below which a trend passes, whatever its interval."""

REPEATABLE = 0.05
"""Largest scatter (relative SD) between the scale factors of repeats that agree."""
GROSS = 0.2
"""Largest scatter that film or rig can explain. Choi 2018, table I: films scatter by 3 to 8 %."""
IMPOSSIBLE = 2.33
"""Number of standard deviations beyond which an enclosure is impossible: 2 % two-sided."""
DRIFTS = 0.995
"""Quantile of Student's t above which the calibrated values count as drifting: 1 % in total,
two-sided. All checks share 5 % of false alarms."""
SHARPEST = 0.005
"""Relative difference of a scale factor after the peak that passes, even if significant."""


def check_span(
    name: str,
    value: float,
    span: tuple[float, float],
    quantity: str,
    advice: str,
    level: Level = "warning",
) -> Check:
    """Check that a value lies in its expected span; `quantity` names it in the sentence."""
    low, high = span
    is_ok = low <= value <= high
    sentence = (
        f"{quantity} {value:.4g} lies {'within' if is_ok else 'outside'} {low:.3g} to {high:.3g}"
    )
    return check(name, is_ok, sentence, f": {advice}", level)


def note_identifiability(brake: Brake) -> Check:
    """Note that peaks determine the product of scale factor and friction, but neither one alone."""
    return check(
        "identifiable",
        True,
        "a peak determines only the product of scale factor and kinetic friction; use the factor "
        f"only with the friction it was fitted with, {brake.film.kinetic:.4g}",
    )


def check_plausibility(factor: float) -> Check:
    """Check the scale factor: a warning outside `PLAUSIBLE`, a failure outside `POSSIBLE`."""
    advice = "check the unit of the force, the friction, the vacuum and the number of sheets"
    low, high = POSSIBLE
    level: Level = "warning" if low <= factor <= high else "failed"
    return check_span("plausible", factor, PLAUSIBLE, "scale factor", advice, level)


def check_stiffness(stiffness: float, sheets_alone: float, told_by: str = "") -> Check:
    """Check that a pull is not stiffer than its sheets; `told_by` names the pulls used."""
    is_ok = stiffness <= sheets_alone
    return check(
        "stiffness",
        is_ok,
        f"the measured stiffness {show(stiffness, 'N/m')}{told_by} is "
        f"{'below' if is_ok else 'above'} the sheets' own, {show(sheets_alone, 'N/m')}",
        ": check the film's modulus and the unit of the elongation",
        "failed",
    )


def check_intervals(values: Mapping[str, float], intervals: Mapping[str, Any]) -> Iterator[Check]:
    """Yield the checks of the 95 % intervals of scale factor and stiffness, which are positive."""
    for name in ("scale_factor", "stiffness"):
        interval = intervals.get(name)
        if interval is not None:
            words = name.replace("_", " ")
            yield interval_check(words, values[name], interval.low, interval.high)


def check_enclosure(factor: float, error: float, sd: float) -> Check:
    """Check the factor on the enclosure's force that the curves need against its own data.

    `error` is the factor's standard error, `sd` the relative standard deviation of the data. If the
    factor is outside the interval of `IMPOSSIBLE`, something else bends the curves.
    """
    spread = float(np.hypot(sd, error / factor)) if factor > 0 else sd
    low, high = (float(np.exp(sign * IMPOSSIBLE * spread)) for sign in (-1, 1))
    advice = (
        "no enclosure does that, so something else bends the curves, such as static friction or "
        "another overlap, and the scale factor is wrong"
    )
    words = "the factor on the enclosure's force"
    return check_span("enclosure", factor, (low, high), words, advice, "failed")


def warn_about_single_pull() -> Check:
    """Return the warning that a single pull has no repeat to be compared with."""
    return check("repeats", False, "one pull only: its repeatability is unknown")


def check_scatter(
    spread: float,
    own_error: float,
    used: str,
    name: str = "repeats",
    quantity: str = "scale factors",
    limit: float = REPEATABLE,
) -> Check:
    """Check that values scatter by at most `limit` (relative SD) or three of their own errors.

    A scatter above `GROSS` fails: some of the pulls have a different unit, vacuum or brake.
    """
    is_ok = spread <= max(limit, 3 * own_error)
    level: Level = "failed" if spread > max(GROSS, 3 * own_error) else "warning"
    return check(name, is_ok, f"{quantity} of {used} scatter by {spread:.1%} (SD)", level=level)


def check_agreement(factors: Sequence[float], errors: Sequence[float]) -> Check:
    """Check that pulls agree within 5 % or three of their own standard errors."""
    values = np.asarray(factors)
    if len(values) < 2:
        return warn_about_single_pull()
    mean = float(values.mean())
    own_error = float(np.mean(errors)) / mean
    return check_scatter(float(values.std(ddof=1)) / mean, own_error, f"{len(values)} pulls")


def format_percent(part: float) -> str:
    """Return a relative change with its sign, such as +3.2%."""
    return f"{part:+.1%}".replace("-0.0%", "+0.0%")


def check_trend(
    name: str,
    word: str,
    values: Array,
    quantities: Array,
    unit: str,
    *,
    levels: int = 3,
    quantile: float = 0.975,
) -> Check | None:
    """Check whether relative values change with a quantity of the pulls; None if too few values.

    `name` ends in that quantity, `word` names the values, and `levels` is the required number of
    distinct values of the quantity. A change passes if it is small or if its interval (two-sided,
    Student's t at `quantile`) contains zero.
    """
    from scipy.special import stdtrit

    line = fit_line(quantities, values)
    if len(values) < 3 or line is None or not np.ptp(quantities) > 0.05 * float(quantities.max()):
        return None
    if len(np.unique(np.round(quantities / quantities.max(), 3))) < levels:
        return None
    span = float(np.ptp(quantities))
    change = line.slope * span
    half_width = float(stdtrit(line.freedom, quantile)) * line.slope_se * span
    quantity = name.rpartition(" over ")[2]
    sentence = (
        f"over {quantity} from {show(float(quantities.min()), unit, 3)} to "
        f"{show(float(quantities.max()), unit, 3)}"
        f" the {word} changes by {format_percent(change)}"
    )
    interval = f"{format_percent(change - half_width)} to {format_percent(change + half_width)}"
    sentence += f" ({200 * quantile - 100:.0f} % interval {interval})"
    return check(name, abs(change) < SMALL or abs(change) <= half_width, sentence)


def check_no_trend(
    values: Sequence[float],
    quantities: Sequence[float],
    quantity: str,
    unit: str,
    word: str = "scale factor",
) -> Check | None:
    """Check that a value of the pulls does not drift; None if it has fewer than three levels."""
    numbers, x = np.asarray(values, float), np.asarray(quantities, float)
    name = f"trend over {quantity}" if word == "scale factor" else f"{word}'s trend over {quantity}"
    return check_trend(name, word, numbers / numbers.mean(), x, unit, quantile=DRIFTS)


def check_curve_end(predicted_force: float, measured_force: float) -> Check:
    """Check that the calibrated law also fits the end of the curve, not only its peak."""
    deviation = (
        (predicted_force - measured_force) / measured_force if measured_force > 0 else np.inf
    )
    sentence = (
        f"at the end of the pulls the law deviates by {deviation:+.1%} from the measured force"
    )
    return check("shape", abs(deviation) <= 0.15, sentence)


def check_shape(
    deviations: Sequence[float],
    half_width: float | None,
    *,
    alarms: float,
    least: float,
    end: Check | None = None,
) -> Check | None:
    """Check that the curves after the peak have, on average, the scale factor of the peaks.

    `deviations` are the relative differences between the scale factor of each pull's sliding part
    and that of its peak. A mean within the factor's own 95 % interval (relative `half_width`, or
    None), or not significantly different from zero, passes, so that the check is as sharp as the
    interval. A mean above `least` fails if Student's t rejects it with a false-alarm
    probability `alarms`, however wide the interval is. `end` is the check at the curves' end; if
    it is None, too few values yield None.
    """
    from scipy.special import stdtrit

    values = np.asarray(deviations)
    count = len(values)
    if not count:
        explanation = (
            "; too little was recorded after the peaks to fit a scale factor there: pull further"
        )
        return None if end is None else check("shape", False, end.sentence, explanation)
    mean = float(values.mean())
    limit = max(SMALL if half_width is None else half_width, SHARPEST)
    if count > 1:
        error = float(values.std(ddof=1)) / count**0.5
        half_interval, certain_limit = (
            float(stdtrit(count - 1, quantile)) * error for quantile in (0.975, 1 - alarms / 2)
        )
        limit = min(max(limit, half_interval), max(least, certain_limit))
    is_ok = abs(mean) <= limit
    sentence = (
        f"after the peak the scale factor deviates by {format_percent(mean)} from that of the peak "
        f"(±{limit:.1%} is allowed)"
    )
    if end is not None:
        sentence = f"{end.sentence}; {sentence}"
    explanation = ": the law does not explain the peaks, as with static friction or stick–slip" * (
        not is_ok
    )
    return check("shape", is_ok and (end is None or end.passed), sentence, explanation)
