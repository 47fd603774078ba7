"""Detection of sensor or converter saturation in the extreme samples of a record.

A converter rounds to a quantum q. With noise of standard deviation s, a sample whose true value is
m is converted to the code M with the probability

    p(m) = N((M + q/2 - m)/s) - N((M - q/2 - m)/s)        (N: the normal distribution)

so the probability of k samples of M in a row is the product of their p. Near the top of a smooth
pulse m is a cubic, fitted to the k samples and as many on either side. If that product is below
CHANCE, the top is flatter than a smooth pulse can be with this converter: it is cut off or truly
flat. The most favourable flat top, m = M throughout, has the product p(M)^k. If this is below
CHANCE, the noise has vanished, which only saturation explains. Otherwise the record counts as cut
off if q is less than FINE of the pulse height, because no force remains that constant naturally. If
q is larger, the record is inconclusive.

Correlated noise produces longer runs: if neighbours have the correlation r, k counts as k (1 -
r)/(1 + r) samples.
"""

import math
from dataclasses import dataclass

import numpy as np

from layerjam.laboratory.measure.saturation import find_plateau
from layerjam.laboratory.measure.trace import Array

LEAST = 3
"""Minimum number of identical extreme samples in a row for the test."""
LEAST_NOISY = 40
"""Minimum number of samples whose noise can be compared with that of the quiet part."""
CHANCE = 1e-5
"""Probability below which a flat top is not due to chance."""
FINE = 1 / 64
"""Smallest relative change of a pulse near its top, unless it is cut off."""
QUIETEST = 0.1
"""Minimum noise relative to the quantum; a smaller estimate is raised to this value."""
SAME = 1e-9
"""Difference, relative to the span, below which two values count as identical despite rounding."""
WHOLE_STEP = 0.1
"""Largest deviation of a converter's steps from whole quanta, in quanta."""
FEWER = 10
"""Upper limit of the smallest step of a record without noise, in quanta."""


@dataclass(frozen=True)
class FlatTop:
    """Identical extreme samples in a row, more than chance explains.

    `level` is their value, in the unit of the record, and `count` their number. `certain` means
    that the sensor or converter saturated there; otherwise the pulse itself may be flat.
    """

    level: float
    count: int
    certain: bool


@dataclass(frozen=True)
class _Grain:
    """Quantum and noise of a record, in its unit; `correlation` of neighbouring noise samples.

    `computed` means that the record has neither noise nor a converter's steps.
    """

    quantum: float
    noise: float
    correlation: float
    computed: bool


def find_flat_top(record: Array, quiet: int) -> FlatTop | None:
    """Return the flat top of a record; None if chance explains its extreme samples.

    `record` has shape (N,) and is evenly sampled and unprocessed; its first `quiet` samples, before
    the pulse, contain the noise.
    """
    span = float(np.ptp(record))
    if span == 0.0:
        return None
    quiet_part = record[:quiet]
    zero = float(quiet_part.mean())
    peak = float(np.abs(record - zero).max())
    grain: _Grain | None = None
    best = None
    for level in (float(record.max()), float(record.min())):
        height = abs(level - zero)
        first, last = _find_longest_run(np.abs(record - level) <= SAME * span)
        if last - first < LEAST or height < 0.5 * peak:
            continue
        grain = grain or _estimate_quantum_and_noise(record, quiet_part, span)
        top = _judge_run(record, level, first, last, height, grain)
        if top is not None and (best is None or top.certain > best.certain):
            best = top
    return best


def find_noisy_top(record: Array, quiet: int) -> FlatTop | None:
    """Return the flat top of a record with noise behind the saturation; None if it is not flat.

    It is certain if the noise is much smaller there than in the quiet part: half of its SD, which
    chance reaches in `LEAST_NOISY` samples with a probability below CHANCE. Equal noise may be that
    of a pulse that is flat by itself.
    """
    quiet_part = record[:quiet]
    zero = float(quiet_part.mean())
    sign = 1.0 if float(record.max()) - zero >= zero - float(record.min()) else -1.0
    plateau = find_plateau(sign * (record - zero), float(quiet_part.std(ddof=1)))
    if plateau is None:
        return None
    quieter = plateau.count >= LEAST_NOISY and plateau.scatter < plateau.noise / 2
    return FlatTop(zero + sign * plateau.level, plateau.count, quieter)


def _find_longest_run(is_equal: np.ndarray) -> tuple[int, int]:
    ends = np.flatnonzero(np.diff(np.concatenate([[0], is_equal.astype(int), [0]])))
    longest = int(np.argmax(ends[1::2] - ends[::2]))
    return int(ends[2 * longest]), int(ends[2 * longest + 1])


def _estimate_quantum_and_noise(record: Array, still: Array, span: float) -> _Grain:
    """Return the smallest step between two values of the record, and the noise of the quiet part.

    Without noise, neighbouring codes may be missing; the result is then the step of which all
    others are multiples.
    """
    steps = np.diff(np.unique(record))
    steps = steps[steps > SAME * span]
    smallest_step = float(steps.min()) if steps.size else span
    # steps that are rounded to decimal digits differ in width
    similar_steps = steps[steps < 1.2 * smallest_step]
    quantum = float(similar_steps.mean()) if similar_steps.size else span
    noise, is_computed = _estimate_noise_sd(still, quantum), False
    if noise == 0:
        parts = steps[:, None] / smallest_step * np.arange(1, FEWER)
        is_multiple = np.all(np.abs(parts - np.round(parts)) < WHOLE_STEP, axis=0)
        is_computed = not is_multiple.any()
        quantum = smallest_step / (int(np.argmax(is_multiple)) + 1)
    deviations = still - still.mean()
    power = float(deviations @ deviations)
    correlation = float(deviations[1:] @ deviations[:-1]) / power if power > 0 else 0.0
    noise = max(noise, QUIETEST * quantum)
    return _Grain(quantum, noise, min(max(correlation, 0.0), 0.95), is_computed)


def _estimate_noise_sd(still: Array, quantum: float) -> float:
    """Return the standard deviation of the noise behind these codes, 0 if all are the same.

    For fine codes, Sheppard's correction is applied. For coarse codes it is the smallest value
    whose likelihood, at the best mean, exceeds 1/8 of the maximum.
    """
    variance = float(np.var(still))
    if variance == 0.0:
        return 0.0
    if variance > quantum**2:
        return math.sqrt(variance - quantum**2 / 12)
    codes, counts = np.unique(np.round((still - still[0]) / quantum), return_counts=True)
    spread = np.geomspace(0.05, 1.5, 35)[:, None, None]
    centre = np.linspace(codes[0] - 0.5, codes[-1] + 0.5, 21 * (len(codes) + 1))[:, None]
    likely = (_log_probability((centre - codes) / spread, 1 / spread) @ counts).max(axis=1)
    return float(spread[np.flatnonzero(likely > likely.max() - math.log(8))[0], 0, 0]) * quantum


def _judge_run(
    record: Array, level: float, first: int, last: int, height: float, grain: _Grain
) -> FlatTop | None:
    """Return the flat top of the identical samples [`first`, `last`); None if due to chance."""
    count = last - first
    share = (1 - grain.correlation) / (1 + grain.correlation)
    quantum = grain.quantum / grain.noise
    deviations = (_fit_cubic(record, first, last) - level) / grain.noise
    smooth = share * float(np.sum(_log_probability(deviations, quantum)))
    if smooth >= math.log(CHANCE):
        return None
    flat_probability = share * count * float(_log_probability(np.zeros(1), quantum)[0])
    is_fine_grained = grain.quantum < FINE * height
    certain = not grain.computed and (is_fine_grained or flat_probability < math.log(CHANCE))
    return FlatTop(level, count, certain)


def _fit_cubic(record: Array, first: int, last: int) -> Array:
    """Return the cubic through a run and as many samples on either side, evaluated at the run."""
    margin = max(last - first, 4)
    begin, end = max(first - margin, 0), min(last + margin, len(record))
    place = (np.arange(begin, end) - (first + last - 1) / 2) / (last - first + margin)
    cubic = np.polynomial.Polynomial.fit(place, record[begin:end], 3)
    return np.asarray(cubic(place[first - begin : last - begin]))


def _log_probability(deviations: Array, quantum: Array | float) -> Array:
    """Return the log probability of a code for true values at these distances from its centre.

    Distances and `quantum` are in units of the noise.
    """
    from scipy.special import ndtr

    chance = ndtr(quantum / 2 - deviations) - ndtr(-quantum / 2 - deviations)
    return np.asarray(np.log(np.maximum(chance, 1e-300)))
