"""Impact in an accelerometer log: peak, filtered peak, velocity change, duration and HIC.

The offset is the mean of the section before the event. Subtracting it removes the sensor's bias,
and also gravity if the sensor was at rest. A sensor in free fall reads 0 g before the event, so
gravity remains in the later signal. With `falling`, gravity is subtracted from the velocity change.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from layerjam.brake.simulate.accelerometer import CLASSES, LEAST_RATE, STANDARD_GRAVITY, cfc_filter
from layerjam.core.brief import brief
from layerjam.core.errors import FitError, Notice, QuantityError, count_text
from layerjam.core.outputs import fact, number, outputs
from layerjam.core.units import show
from layerjam.laboratory.identify.logs.correlated import average_bins
from layerjam.laboratory.identify.logs.flat_top import find_flat_top, find_noisy_top
from layerjam.laboratory.identify.logs.sampling import Gap, sample_evenly
from layerjam.laboratory.measure.trace import Array

SHARE = 0.05
"""Fraction of the peak that ends the quiet section before the event and delimits the pulse."""


def _span_length(ends: Sequence[float]) -> str:
    return f"{ends[0]:.6g} s to {ends[1]:.6g} s"


@outputs
class Pulse:
    """Results of one impact; accelerations have the offset removed and keep their sign.

    The pulse is the section around the peak in which the filtered signal exceeds 5 % of the peak.
    The velocity change is the integral of the unfiltered signal over the same pulse down to zero.
    """

    peak: float = number("m/s^2", "maximum acceleration")
    peak_g: float = number("1", "maximum acceleration in g")
    peak_time: float = number("s", "time of the peak")
    filtered_peak: float = number("m/s^2", "maximum filtered acceleration")
    filtered_peak_g: float = number("1", "maximum acceleration in g")
    filtered_peak_time: float = number("s", "time of the filtered peak")
    filter: str = fact("filter class")
    velocity_change: float = number("m/s", "velocity change over the pulse")
    velocity_change_se: float = number("m/s", "its standard error")
    duration: float = number("s", "duration of the pulse")
    pulse: Sequence[float] = number("s", "start and end of the pulse", shown=_span_length)
    hic: float | None = number("1", "head injury criterion")
    hic_window: Sequence[float] | None = number("s", "window of the criterion", shown=_span_length)
    offset: float = number("m/s^2", "offset of the sensor, from the quiet part of the record")
    offset_se: float = number("m/s^2", "its standard error")
    quiet: Sequence[float] = number("s", "start and end of the quiet part", shown=_span_length)
    sampling: float = number("Hz", "sampling rate")
    saturated: bool = fact("whether the sensor saturated")
    samples: int = number("1", "samples of the log", listed=False)


@brief
@outputs
class Crash(Pulse):
    """One impact with its signal; times [s] are those of the log, shape (N,).

    `filtered` is `acceleration` [m/s²] filtered to the class `cfc`, or unfiltered if `cfc` is None.
    `whole` states whether the log contains the entire pulse, `pulse_gaps` the gaps in it.
    `saturation` [m/s²] is the level at which the sensor saturated, or None. `flat_top` is the level
    at which it may have saturated.
    """

    time: Array
    acceleration: Array
    filtered: Array
    cfc: int | None
    whole: bool
    pulse_gaps: tuple[Gap, ...]
    saturation: float | None
    flat_top: float | None
    warnings: tuple[str, ...]

    def velocity(self) -> Array:
        """Return the unfiltered velocity change [m/s] since the start of the log, shape (N,)."""
        mean = (self.acceleration[1:] + self.acceleration[:-1]) / 2
        return np.concatenate([[0.0], np.cumsum(mean * np.diff(self.time))])


def reduce_crash(
    time: Array,
    acceleration: Array,
    *,
    cfc: int | None = 180,
    sampling: float | None = None,
    before: float | None = None,
    limit: float | None = None,
    falling: bool = False,
    hic: float | None = None,
    gravity: float = STANDARD_GRAVITY,
) -> Crash:
    """Return peak, filtered peak and velocity change of the largest pulse in a log.

    `time` [s] and `acceleration` [m/s²] have shape (N,). `cfc` is a class of SAE J211-1 or None.
    `before` is the length [s] of the quiet section at the start (detected if None), `limit` the
    sensor's range [m/s²], `hic` the longest window [s] of the head injury criterion, or None.
    Raises FitError for too few samples or no quiet section, QuantityError for a low rate.
    """
    even = sample_evenly(time, acceleration, sampling)
    time, acceleration, rate = even.time, even.signal, even.rate
    _check_class(cfc, rate, is_stated=sampling is not None)

    def apply_filter(values: Array) -> Array:
        return cfc_filter(values, rate, cfc) if cfc is not None else values

    quiet, quiet_notes = _count_quiet_samples(time, apply_filter(acceleration), rate, before)
    quiet_part = acceleration[:quiet]
    offset, offset_se = float(quiet_part.mean()), _mean_standard_error(quiet_part)
    signal = acceleration - offset
    filtered_signal = apply_filter(signal)
    top, high = (int(np.argmax(np.abs(values))) for values in (signal, filtered_signal))
    first, last = _find_pulse_range(filtered_signal, high, SHARE)
    start, end = _find_pulse_ends(filtered_signal, high, first, last)
    length = (end - start) / rate
    change = float(np.trapezoid(signal[start : end + 1], time[start : end + 1]))
    change -= float(np.sign(filtered_signal[high])) * gravity * length * falling
    noise = float(np.std(quiet_part)) * np.sqrt(length / rate)
    tops, unknown = _find_saturation(acceleration, quiet, limit)
    drift = _note_drift(signal, last, rate, offset_se)
    value, span = (None, None) if hic is None else head_injury_criterion(filtered_signal, rate, hic)
    return Crash(
        time=time,
        acceleration=signal,
        filtered=filtered_signal,
        peak=float(signal[top]),
        peak_g=float(signal[top]) / STANDARD_GRAVITY,
        peak_time=float(time[top]),
        filtered_peak=float(filtered_signal[high]),
        filtered_peak_g=float(filtered_signal[high]) / STANDARD_GRAVITY,
        filtered_peak_time=float(time[high]),
        cfc=cfc,
        filter="none" if cfc is None else f"cfc{cfc}",
        sampling=rate,
        samples=len(time),
        offset=offset,
        offset_se=offset_se,
        quiet=(float(time[0]), float(time[quiet - 1])),
        pulse=(float(time[first]), float(time[last])),
        duration=float(time[last]) - float(time[first]),
        velocity_change=change,
        velocity_change_se=float(np.hypot(offset_se * length, noise)),
        whole=first > 0 and last < len(signal) - 1,
        pulse_gaps=tuple(g for g in even.gaps if g.end > time[start] and g.start < time[end]),
        **tops,
        saturated=tops["saturation"] is not None,
        hic=value,
        hic_window=None if span is None else (float(time[span[0]]), float(time[span[1]])),
        warnings=(*even.notes, *quiet_notes, *unknown, *drift),
    )


def _check_class(cfc: int | None, rate: float, is_stated: bool) -> None:
    if cfc is not None and cfc not in CLASSES:
        classes = ", ".join(map(str, CLASSES))
        raise QuantityError(f"filter: CFC {cfc} is not an SAE J211-1 class; classes: {classes}")
    if cfc is not None and rate < LEAST_RATE * cfc * (1 - 1e-9):
        sampled_classes = [c for c in CLASSES if rate >= LEAST_RATE * c * (1 - 1e-9)]
        reason = (
            f"{show(rate, 'Hz')} is too slow for CFC {cfc}; SAE J211-1 requires at least "
            f"ten times the class, {show(float(LEAST_RATE * cfc), 'Hz')} "
            f"(--filter {f'cfc{max(sampled_classes)}' if sampled_classes else 'none'})"
        )
        if is_stated:
            raise QuantityError.of("sampling", reason)
        raise FitError(f"its sampling rate of {reason}")


def _count_quiet_samples(
    time: Array, acceleration: Array, rate: float, before: float | None
) -> tuple[int, list[str]]:
    """Return the number of samples before the event, and how it was determined."""
    if before is not None:
        count = int(np.sum(time < time[0] + before))
        if not 5 <= count < len(time):
            raise FitError(
                f"the first {show(before, 's')} contains {count_text(count, 'sample')}; the part "
                "before the event needs at least 5, and the event must follow"
            )
        return count, []
    first = acceleration[: max(len(time) // 50, 5)]
    gap = np.abs(acceleration - float(np.median(first)))
    noise = float(np.median(gap[: len(first)]))
    loud = np.flatnonzero(gap > min(max(SHARE * gap.max(), 8 * noise), 2 * SHARE * gap.max()))
    count = int(loud[0] * 0.9)
    if count < 5:
        raise FitError(
            "no quiet part precedes the event, so the offset is unknown; give the length "
            "of the quiet part (--before), or record with a pre-trigger"
        )
    return count, [
        f"the offset is the mean of the first {show(count / rate, 's')}, before the signal exceeds "
        f"{SHARE:.0%} of its peak"
    ]


def _mean_standard_error(values: Array) -> float:
    """Return a mean's standard error from at most twenty block means, to include slow noise."""
    runs = average_bins(values, min(20, len(values)))
    return float(np.std(runs, ddof=1) / np.sqrt(len(runs)))


def _find_pulse_range(signal: Array, high: int, share: float) -> tuple[int, int]:
    """Return the ends of the pulse: its samples have the peak's sign and exceed `share` of it."""
    below_share = signal * np.sign(signal[high]) <= share * abs(signal[high])
    left, right = np.flatnonzero(below_share[:high]), np.flatnonzero(below_share[high:])
    first = int(left[-1]) if left.size else 0
    last = high + int(right[0]) if right.size else len(signal) - 1
    return first, last


def _find_pulse_ends(signal: Array, high: int, first: int, last: int) -> tuple[int, int]:
    """Return the pulse's zero crossings if they are near its 5 % points, otherwise those points."""
    start, end = _find_pulse_range(signal, high, 0.0)
    length = last - first
    return (
        start if start > 0 and first - start <= length else first,
        end if end < len(signal) - 1 and end - last <= length else last,
    )


def _find_saturation(
    acceleration: Array, quiet: int, limit: float | None
) -> tuple[dict[str, Any], list[str]]:
    """Return `saturation` and `flat_top` of a Crash, and a note about the latter.

    It is at the sensor's range, or at a top that is flatter than chance or a smooth pulse allows.
    """
    peak = float(np.max(np.abs(acceleration)))
    if limit is not None and peak >= limit * (1 - 1e-3):
        return {"saturation": peak, "flat_top": None}, []
    top = find_flat_top(acceleration, quiet) or find_noisy_top(acceleration, quiet)
    level = None if top is None else abs(top.level)
    if top is None or top.certain:
        return {"saturation": level, "flat_top": None}, []
    note = Notice(
        f"the top is flat: {top.count} equal samples at "
        f"{top.level / STANDARD_GRAVITY:.4g} g. Whether the sensor or its converter ended "
        "there, or the pulse was flat, is unknown from this record: its steps are too "
        "coarse, it shows no noise, or its noise goes on; give the sensor's range (--range)",
        "flat-top",
    )
    return {"saturation": None, "flat_top": level}, [note]


def _note_drift(signal: Array, last: int, rate: float, offset_se: float) -> list[str]:
    """Return a note about drift, from the levels at the end of the log and before the event."""
    tail = signal[last:][-max((len(signal) - last) // 2, 1) :]
    if len(tail) < 20:
        return []
    level, se = float(tail.mean()), _mean_standard_error(tail)
    if abs(level) <= 4 * np.hypot(se, offset_se) + 0.002 * float(np.abs(signal).max()):
        return []
    return [
        f"the level after the event is {level / STANDARD_GRAVITY:.3g} g off the one before: "
        "gravity along another axis, a drift, or motion that goes on; only the part before is "
        "taken as zero"
    ]


def head_injury_criterion(
    signal: Array, rate: float, longest: float
) -> tuple[float, tuple[int, int]]:
    """Return HIC = max (t2 - t1) (mean |a|/g over t1 to t2)^2.5 for windows up to `longest` [s].

    Returns the value [s] and the window's end samples. It uses |a|, because a resultant is never
    negative.
    """
    size = np.abs(signal) / STANDARD_GRAVITY
    area = np.concatenate([[0.0], np.cumsum((size[1:] + size[:-1]) / 2 / rate)])
    best, span = 0.0, (0, 1)
    for width in range(1, min(round(longest * rate), len(signal) - 1) + 1):
        mean = (area[width:] - area[:-width]) * rate / width
        best_start = int(np.argmax(mean))
        value = width / rate * float(max(mean[best_start], 0.0)) ** 2.5
        if value > best:
            best, span = value, (best_start, best_start + width)
    return best, span
