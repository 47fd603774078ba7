"""The verdict a fit carries: whether its numbers deserve belief, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.identify.straight import straight_line
from layerjam.measure.trace import Array
from layerjam.units import show
from layerjam.verdict import Check, Level, check, interval_check

__all__ = ["Check", "check"]

PLAUSIBLE = (0.5, 2.0)
"""Scale factors beyond this are suspect; the paper's are 0.875 and 1.24."""
POSSIBLE = (0.3, 3.0)
"""Scale factors beyond this fail: friction off by more than that is another film or unit."""
SMALL = 0.05
"""Relative change, or difference, below which a trend is let pass whatever its interval."""

REPEATABLE = 0.05
"""Scatter between repeats' scale factors (SD, relative) up to which they agree."""
GROSS = 0.2
"""The same above which no film or rig explains it. Choi 2018, table I: films scatter by 3 to 8 %.
"""
DRIFTS = 0.995
"""Quantile of Student's t that a drift of the calibrated numbers must pass, either way: 1 % in all.
Five of a hundred false alarms are for all checks together."""
SHARPEST = 0.005
"""Relative difference of a scale factor after the peak that is let pass however sure it is."""


def within(
    name: str,
    value: float,
    span: tuple[float, float],
    what: str,
    advice: str,
    level: Level = "warning",
) -> Check:
    """Whether a value lies where one expects it; `what` names it."""
    low, high = span
    fine = low <= value <= high
    sentence = f"{what} {value:.4g} lies {'within' if fine else 'outside'} {low:.3g} to {high:.3g}"
    return check(name, fine, sentence, f": {advice}", level)


def identifiable(brake: Brake) -> Check:
    """Peaks give the product of scale factor and friction, never either alone."""
    return check(
        "identifiable",
        True,
        "a peak fixes only the product of scale factor and kinetic friction; the factor holds "
        f"together with the friction it was fitted with, {brake.film.kinetic:.4g}",
    )


def plausible(factor: float) -> Check:
    """The scale factor lies in the expected range; far outside it no brake explains it."""
    advice = "check the unit of the force, the friction, the vacuum and the number of sheets"
    low, high = POSSIBLE
    level: Level = "warning" if low <= factor <= high else "failed"
    return within("plausible", factor, PLAUSIBLE, "scale factor", advice, level)


def stiffness_possible(stiffness: float, sheets_alone: float, told_by: str = "") -> Check:
    """A rig in series cannot make the sheets stiffer; `told_by` says which pulls tell it."""
    fine = stiffness <= sheets_alone
    return check(
        "stiffness",
        fine,
        f"the measured stiffness {show(stiffness, 'N/m')}{told_by} is "
        f"{'below' if fine else 'above'} the sheets' own, {show(sheets_alone, 'N/m')}",
        ": the film's modulus or the elongation's unit is wrong",
        "failed",
    )


def interval_checks(values: Mapping[str, float], intervals: Mapping[str, Any]) -> Iterator[Check]:
    """Checks of the 95 % intervals of scale factor and stiffness, positive by nature."""
    for name in ("scale_factor", "stiffness"):
        interval = intervals.get(name)
        if interval is not None:
            words = name.replace("_", " ")
            yield interval_check(words, values[name], interval.low, interval.high)


def one_pull_only() -> Check:
    """A single pull cannot be compared with a repeat."""
    return check("repeats", False, "one pull only: nothing says how well it repeats")


def repeats(
    spread: float,
    own_error: float,
    used: str,
    name: str = "repeats",
    what: str = "scale factors",
    most: float = REPEATABLE,
) -> Check:
    """Values scatter by at most `most` (SD, relative) or three of their own errors.

    A scatter above `GROSS` fails: several of the pulls have another unit, vacuum or brake.
    """
    fine = spread <= max(most, 3 * own_error)
    level: Level = "failed" if spread > max(GROSS, 3 * own_error) else "warning"
    return check(name, fine, f"{what} of {used} scatter by {spread:.1%} (SD)", level=level)


def agreement(factors: Sequence[float], errors: Sequence[float]) -> Check:
    """Pulls agree with each other within 5 % or three of their own standard errors."""
    values = np.asarray(factors)
    if len(values) < 2:
        return one_pull_only()
    mean = float(values.mean())
    own = float(np.mean(errors)) / mean
    return repeats(float(values.std(ddof=1)) / mean, own, f"{len(values)} pulls")


def percent(part: float) -> str:
    """A relative change with its sign, such as +3.2%."""
    return f"{part:+.1%}".replace("-0.0%", "+0.0%")


def trend(
    name: str,
    word: str,
    values: Array,
    over: Array,
    unit: str,
    *,
    levels: int = 3,
    quantile: float = 0.975,
) -> Check | None:
    """Whether relative values change over a quantity of the pulls; None where too few tell.

    `name` ends in that quantity, `word` says what the values are of, `levels` how many distinct
    values of the quantity are needed. A change passes that is small, or whose interval (Student's t
    at `quantile`, either way) holds zero.
    """
    from scipy.special import stdtrit

    line = straight_line(over, values)
    if len(values) < 3 or line is None or not np.ptp(over) > 0.05 * float(over.max()):
        return None
    if len(np.unique(np.round(over / over.max(), 3))) < levels:
        return None
    span = float(np.ptp(over))
    change = line.slope * span
    reach = float(stdtrit(line.freedom, quantile)) * line.slope_se * span
    what = name.rpartition(" over ")[2]
    sentence = (
        f"over {what} from {show(float(over.min()), unit, 3)} to {show(float(over.max()), unit, 3)}"
        f" the {word} changes by {percent(change)}"
    )
    interval = f"{percent(change - reach)} to {percent(change + reach)}"
    sentence += f" ({200 * quantile - 100:.0f} % interval {interval})"
    return check(name, abs(change) < SMALL or abs(change) <= reach, sentence)


def no_trend(
    values: Sequence[float],
    over: Sequence[float],
    what: str,
    unit: str,
    word: str = "scale factor",
) -> Check | None:
    """A number of pulls does not drift; None with fewer than three distinct values of `what`."""
    each, x = np.asarray(values, float), np.asarray(over, float)
    name = f"trend over {what}" if word == "scale factor" else f"{word}'s trend over {what}"
    return trend(name, word, each / each.mean(), x, unit, quantile=DRIFTS)


def end_of_curve(predicted: float, measured: float) -> Check:
    """The calibrated law also meets the end of the curve, not only the peak it was fitted to."""
    off = (predicted - measured) / measured if measured > 0 else np.inf
    sentence = f"at the end of the pulls the calibrated law is {off:+.1%} off the measured force"
    return check("shape", abs(off) <= 0.15, sentence)


def shape(
    off: Sequence[float],
    half_width: float | None,
    *,
    alarms: float,
    least: float,
    end: Check | None = None,
) -> Check | None:
    """The curves after the peak say the peaks' scale factor, on the mean over the pulls.

    `off` is by which part the scale factor of each pull's sliding part lies off its peak's. What
    lies within the factor's own 95 % interval (relative `half_width`, None where there is none) or
    within Student's t of zero passes, so that the check is as sharp as the interval it vouches for.
    However wide that is, a mean of more than `least` does not pass where Student's t has it with
    `alarms` false alarms. `end` is the check at the curves' end, where that belongs to it; without,
    None where no pull tells.
    """
    from scipy.special import stdtrit

    values = np.asarray(off)
    count = len(values)
    if not count:
        why = "; too little was recorded after the peaks to tell a scale factor there: pull further"
        return None if end is None else check("shape", False, end.sentence, why)
    mean = float(values.mean())
    limit = max(SMALL if half_width is None else half_width, SHARPEST)
    if count > 1:
        error = float(values.std(ddof=1)) / count**0.5
        within, sure = (
            float(stdtrit(count - 1, quantile)) * error for quantile in (0.975, 1 - alarms / 2)
        )
        limit = min(max(limit, within), max(least, sure))
    fine = abs(mean) <= limit
    sentence = (
        f"after the peak the curves have a scale factor {percent(mean)} off the peaks' "
        f"(up to ±{limit:.1%} passes)"
    )
    if end is not None:
        sentence = f"{end.sentence}; {sentence}"
    why = ": the peaks are not the law's, as with static friction or stick-slip" * (not fine)
    return check("shape", fine and (end is None or end.passed), sentence, why)
