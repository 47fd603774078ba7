"""Load cycles: a crosshead that reverses and pulls again, seen in the elongation alone."""

from dataclasses import dataclass

import numpy as np

from layerjam.core.errors import count_text
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.laboratory.identify.stick_slip import turning_points
from layerjam.laboratory.measure.trace import Array, Trace

REVERSAL = 0.02
"""Smallest reversal of the crosshead, relative to the range of its travel."""


@dataclass(frozen=True, kw_only=True)
class Cycles:
    """Load cycles of a record: the samples at which its first loading and unloading end.

    `count` is the number of reversals, `fall` [m] the mean travel back.
    """

    loading_end: int
    unloading_end: int
    count: int
    fall: float
    elongation: float
    unused: int

    def __str__(self) -> str:
        times = "once" if self.count == 1 else f"{self.count} times"
        samples = count_text(self.unused, "sample")
        return (
            f"the crosshead reverses {times}, by {show(self.fall, 'm', 3)}, and pulls again: load "
            f"cycles. Only the first loading, up to {show(self.elongation, 'm')}, is used; "
            f"{samples} after the first return {'is' if self.unused == 1 else 'are'} not"
        )


def find_cycles(elongation: Array) -> Cycles | None:
    """Return the load cycles in a record of elongation [m], shape (N,); None if it has one loading.

    A crosshead that backs off before the first loading does not count as a reversal.
    """
    min_swing = REVERSAL * float(np.ptp(elongation))
    peaks, troughs = turning_points(elongation, min_swing)
    lowest = np.minimum.accumulate(elongation)
    peaks = peaks[elongation[peaks] - lowest[peaks] > min_swing]
    troughs = troughs[troughs > peaks[0]] if len(peaks) else troughs[:0]
    if not len(troughs):
        return None
    return_travels = elongation[peaks[: len(troughs)]] - elongation[troughs[: len(peaks)]]
    return Cycles(
        loading_end=int(peaks[0]),
        unloading_end=int(troughs[0]),
        count=len(troughs),
        fall=float(return_travels.mean()),
        elongation=float(elongation[peaks[0]]),
        unused=len(elongation) - int(troughs[0]) - 1,
    )


def select_first_cycle(trace: Trace) -> tuple[Trace, Cycles | None]:
    """Return the first loading and unloading of a trace, and its load cycles, if any."""
    cycles = find_cycles(trace.elongation)
    if cycles is None:
        return trace, None
    part = slice(0, cycles.unloading_end + 1)
    cut = evolve(
        trace,
        force=trace.force[part],
        elongation=trace.elongation[part],
        time=None if trace.time is None else trace.time[part],
    )
    return cut, cycles
