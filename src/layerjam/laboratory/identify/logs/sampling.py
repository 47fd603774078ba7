"""Sampling of a log: even steps, steps with jitter, gaps, and resampling on even steps."""

from dataclasses import dataclass

import numpy as np

from layerjam.core.errors import FitError, Notice, are_text
from layerjam.core.units import show
from layerjam.laboratory.measure.trace import Array

JITTER = 0.1
"""Largest deviation of a step from the usual one, relative to it, that counts as even sampling."""
MISSING = 1.6
"""Smallest step, in usual steps, in which a sample is missing."""
FEWEST = 20


@dataclass(frozen=True, kw_only=True)
class Gap:
    """Part of a log, from `start` to `end` [s], in which `missing` samples were lost."""

    start: float
    end: float
    missing: int

    def __str__(self) -> str:
        samples = are_text(self.missing, "sample")
        return f"{samples} missing after {show(self.start, 's', 6)}"


@dataclass(frozen=True, kw_only=True)
class EvenSignal:
    """A signal with its time [s], shape (N,), and its sampling rate [Hz]."""

    time: Array
    signal: Array
    rate: float
    gaps: tuple[Gap, ...] = ()
    notes: tuple[str, ...] = ()


def find_gaps(time: Array) -> tuple[Gap, ...]:
    """Return the gaps in ascending time stamps [s]; stamps of a coarse clock may repeat."""
    stamps = np.unique(time)
    steps = np.diff(stamps)
    if len(steps) < FEWEST:
        return ()
    median_step = float(np.median(steps))
    return tuple(
        Gap(
            start=float(stamps[i]),
            end=float(stamps[i + 1]),
            missing=round(steps[i] / median_step) - 1,
        )
        for i in np.flatnonzero(steps >= MISSING * median_step).tolist()
    )


def sample_evenly(time: Array, signal: Array, rate: float | None = None) -> EvenSignal:
    """Return a signal of shape (N,) with even steps, as a filter requires.

    Steps within a tenth of the usual one are used as they are. Stamps of a coarse clock are
    replaced by even ones if each is within one clock step of its place. Other signals are resampled
    by linear interpolation, and a note says so. A `rate` [Hz] replaces all stamps. Raises FitError
    if there are too few samples.
    """
    count = len(time)
    if count < FEWEST:
        raise FitError(f"a pulse needs at least {FEWEST} samples; there are {count}")
    if rate is not None:
        return EvenSignal(time=time[0] + np.arange(count) / rate, signal=signal, rate=rate)
    steps = np.diff(time)
    mean = float(time[-1] - time[0]) / (count - 1)
    if (np.abs(steps - np.median(steps)) <= JITTER * np.median(steps)).all():
        return EvenSignal(time=time, signal=signal, rate=1 / mean)
    even_times = time[0] + mean * np.arange(count)
    if (steps == 0).any() and np.abs(time - even_times).max() <= steps[steps > 0].min() * (
        1 + 1e-9
    ):
        note = f"time stamps are rounded; the rate is their mean, {show(1 / mean, 'Hz')}"
        return EvenSignal(time=even_times, signal=signal, rate=1 / mean, notes=(note,))
    stamps, first = np.unique(time, return_index=True)
    means = np.add.reduceat(signal, first) / np.diff(np.append(first, count))
    median_step = float(np.median(np.diff(stamps)))
    grid = np.arange(stamps[0], stamps[-1] + 1e-9 * median_step, median_step)
    gaps = find_gaps(time)
    gap_text = "".join(f"; {gap}" for gap in gaps[:3])
    note = (
        f"its steps vary from {show(float(steps.min()), 's')} to {show(float(steps.max()), 's')}; "
        f"it was resampled at {show(1 / median_step, 'Hz')} by linear interpolation{gap_text}"
    )
    return EvenSignal(
        time=grid,
        signal=np.interp(grid, stamps, means),
        rate=1 / median_step,
        gaps=gaps,
        notes=(Notice(note, "resampled"),),
    )
