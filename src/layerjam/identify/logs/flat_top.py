"""Whether a record's greatest samples are the end of a sensor or converter, or chance.

A converter rounds to a quantum q. Behind noise of standard deviation s, a sample whose true value
is m shows the code M with the probability

    p(m) = N((M + q/2 - m)/s) - N((M - q/2 - m)/s)        (N: the normal distribution)

so k samples in a row show M with the product of their p. Near the top of a smooth pulse m is a
cubic, fitted to the k samples and as many on either side. Where that product is below CHANCE, the
top is flatter than a smooth pulse behind this converter can be. It is then either cut off or truly
flat. Of a flat top at its most favourable, m = M all along, the product is p(M)^k: below CHANCE the
noise has gone, which only an end does. Otherwise the record is held to be cut off where q is less
than FINE of the pulse's height, for no force stays within that by itself; and else nobody can tell.

Noise that is correlated makes longer runs: with the correlation r of neighbours, k counts for
k (1 - r)/(1 + r) samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from layerjam.measure.trace import Array

LEAST = 3
"""Equal greatest samples in a row below which nothing is looked at."""
CHANCE = 1e-5
"""Probability below which chance does not explain a flat top."""
FINE = 1 / 64
"""Part of its height within which no pulse stays constant by itself."""
QUIETEST = 0.1
"""Noise over the quantum that is taken where less, or none, is seen: less would not be."""
SAME = 1e-9
"""Part of the span below which two values are one: what arithmetic leaves of equal ones."""
WHOLE = 0.1
"""Part of a quantum by which the steps of a converter's record may be off whole quanta."""
FEWER = 10
"""The smallest step of a record without noise is less than so many quanta."""


@dataclass(frozen=True)
class FlatTop:
    """Equal greatest samples that chance does not explain.

    `level` is their value, in the record's unit, `count` how many they are in a row; `certain` says
    whether the sensor or converter ended there. Else the pulse may be flat.
    """

    level: float
    count: int
    certain: bool


@dataclass(frozen=True)
class _Grain:
    """Quantum and noise of a record, in its unit; `correlation` of neighbours in the noise.

    `computed`: it shows neither noise nor a converter's steps.
    """

    quantum: float
    noise: float
    correlation: float
    computed: bool


def flat_top(record: Array, quiet: int) -> FlatTop | None:
    """What the record's greatest or lowest samples show, None where chance explains them.

    `record` has shape (N,), evenly sampled, as the converter gave it; its first `quiet` samples are
    before the pulse and show the noise.
    """
    span = float(np.ptp(record))
    if span == 0.0:
        return None
    still = record[:quiet]
    rest = float(still.mean())
    reach = float(np.abs(record - rest).max())
    grain: _Grain | None = None
    found = None
    for level in (float(record.max()), float(record.min())):
        height = abs(level - rest)
        first, last = _longest(np.abs(record - level) <= SAME * span)
        if last - first < LEAST or height < 0.5 * reach:
            continue
        grain = grain or _grain(record, still, span)
        top = _judged(record, level, first, last, height, grain)
        if top is not None and (found is None or top.certain > found.certain):
            found = top
    return found


def _longest(there: np.ndarray) -> tuple[int, int]:
    ends = np.flatnonzero(np.diff(np.concatenate([[0], there.astype(int), [0]])))
    at = int(np.argmax(ends[1::2] - ends[::2]))
    return int(ends[2 * at]), int(ends[2 * at + 1])


def _grain(record: Array, still: Array, span: float) -> _Grain:
    """The smallest step between two values of the record, and the noise of the quiet part.

    Without noise neighbouring codes may be missing: then the step of which all are multiples.
    """
    steps = np.diff(np.unique(record))
    steps = steps[steps > SAME * span]
    least = float(steps.min()) if steps.size else span
    # rounded to digits, a step is not always as wide
    near = steps[steps < 1.2 * least]
    quantum = float(near.mean()) if near.size else span
    noise, computed = _noise(still, quantum), False
    if noise == 0:
        parts = steps[:, None] / least * np.arange(1, FEWER)
        whole = np.all(np.abs(parts - np.round(parts)) < WHOLE, axis=0)
        computed, quantum = not whole.any(), least / (int(np.argmax(whole)) + 1)
    off = still - still.mean()
    power = float(off @ off)
    beside = float(off[1:] @ off[:-1]) / power if power > 0 else 0.0
    noise = max(noise, QUIETEST * quantum)
    return _Grain(quantum, noise, min(max(beside, 0.0), 0.95), computed)


def _noise(still: Array, quantum: float) -> float:
    """Standard deviation of the noise that shows these codes, 0 where all are equal.

    Of fine codes by Sheppard's correction; of coarse ones the least that is likely (its likelihood,
    at the best mean, above 1/8 of the greatest).
    """
    variance = float(np.var(still))
    if variance == 0.0:
        return 0.0
    if variance > quantum**2:
        return math.sqrt(variance - quantum**2 / 12)
    codes, counts = np.unique(np.round((still - still[0]) / quantum), return_counts=True)
    spread = np.geomspace(0.05, 1.5, 35)[:, None, None]
    centre = np.linspace(codes[0] - 0.5, codes[-1] + 0.5, 21 * (len(codes) + 1))[:, None]
    likely = (_log_chance((centre - codes) / spread, 1 / spread) @ counts).max(axis=1)
    return float(spread[np.flatnonzero(likely > likely.max() - math.log(8))[0], 0, 0]) * quantum


def _judged(
    record: Array, level: float, first: int, last: int, height: float, grain: _Grain
) -> FlatTop | None:
    """What the run of equal samples from `first` to before `last` is."""
    count = last - first
    share = (1 - grain.correlation) / (1 + grain.correlation)
    quantum = grain.quantum / grain.noise
    off = (_curve(record, first, last) - level) / grain.noise
    smooth = share * float(np.sum(_log_chance(off, quantum)))
    if smooth >= math.log(CHANCE):
        return None
    flat = share * count * float(_log_chance(np.zeros(1), quantum)[0])
    fine = grain.quantum < FINE * height
    certain = not grain.computed and (fine or flat < math.log(CHANCE))
    return FlatTop(level, count, certain)


def _curve(record: Array, first: int, last: int) -> Array:
    """The cubic through a run and as many samples on either side, at the run's."""
    beside = max(last - first, 4)
    begin, end = max(first - beside, 0), min(last + beside, len(record))
    place = (np.arange(begin, end) - (first + last - 1) / 2) / (last - first + beside)
    fitted = np.polynomial.Polynomial.fit(place, record[begin:end], 3)
    return np.asarray(fitted(place[first - begin : last - begin]))


def _log_chance(off: Array, quantum: Array | float) -> Array:
    """Logarithm of the chance that a value so far from a code's middle shows this code.

    Both over the noise.
    """
    from scipy.special import ndtr

    chance = ndtr(quantum / 2 - off) - ndtr(-quantum / 2 - off)
    return np.asarray(np.log(np.maximum(chance, 1e-300)))
