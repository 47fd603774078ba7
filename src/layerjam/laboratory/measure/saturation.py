"""Saturation of a sensor, seen through the noise of its record.

A saturated sensor repeats one number if nothing follows it. With an amplifier's or a converter's
noise behind it, the record has a plateau at its top instead: constant but for white noise, and with
a corner at its beginning. A smooth maximum has no corner, and a sharp one no plateau.

The samples that the noise can explain as the top (`BAND`) are compared with both. Over the top of a
smooth maximum, a parabola spans the whole band; over a plateau it spans next to nothing. The corner
is found by comparing two fits to the rise and the top: a cubic, and a line that ends in a constant.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from layerjam.laboratory.measure.noise import find_quantum, noise_sd, running_mean

Array = npt.NDArray[np.float64]

SMOOTH = 5
"""Samples of the running mean with which the top is found."""
BAND = 9.5
"""Depth of the top, in standard deviations of that mean: the range of its noise over a record."""
LEAST = 6
"""Smallest number of samples of a plateau."""
CLOSE = 3.5
"""Distance of its first and last samples from its level, in standard deviations of the noise."""
CURVED = 9.2
"""Largest reduction of chi-squared by a parabola instead of a constant over a plateau: chance
exceeds it in 1 % of plateaus (two degrees of freedom)."""
NOISIER = (1.05, 1.5)
"""Largest scatter over N samples of a plateau, in standard deviations of the noise: the first
number plus the second over the root of N."""
FINE = 12
"""Smallest number of steps of a coarse converter in the rise just before a plateau."""
LIKELIER = 12.0
"""Smallest log likelihood ratio of a corner to a cubic."""
LOWEST = 0.3
"""Smallest part of the plateau's height from which the rise to it is fitted."""
FALLS = 10.0
"""Fall after the plateau that ends it, in standard deviations of the noise."""
LONG = 120
"""Smallest number of samples of a plateau that ends in a gradual fall: the noise hides the
curvature of shorter tops."""
SUDDEN, DEEP = 3, 0.03
"""Largest number of samples, and smallest relative depth, of the sudden fall after any other."""


@dataclass(frozen=True)
class Plateau:
    """Plateau at the top of a record: `level` in its unit, with a standard error; `count` samples.

    `start` and `end` are indices. `ends` states whether the record falls again after it, which a
    steady force does not do by itself. `noise` is that of one sample before, `scatter` that on it.
    """

    level: float
    error: float
    start: int
    end: int
    noise: float
    scatter: float
    ends: bool

    @property
    def count(self) -> int:
        """Number of samples."""
        return self.end - self.start


def find_plateau(record: Array, noise: float | None = None) -> Plateau | None:
    """Return the plateau at the top of a record, shape (N,); None if the top is not flat.

    `noise` is the standard deviation of one sample, by default estimated from the record. If the
    resolution hides the noise, the rise just before the plateau must have many steps.
    """
    span = float(np.ptp(record))
    if len(record) < 3 * LEAST or span == 0:
        return None
    quantum = find_quantum(record)
    noise = noise_sd(record) if noise is None else noise
    is_coarse = quantum > 2 * noise
    noise = max(float(np.hypot(noise, quantum / 12**0.5)), 1e-9 * span)
    start, end = _locate_top(record, noise)
    edge = (end - start) // 12  # the noise hides the last samples of the rise among the others
    part = record[start + edge : end - edge]
    if start == 0 or end - start < LEAST or not _is_flat(part, noise):
        return None
    rise = float(part.mean() - record[max(2 * start - end, 0) : start].min())
    if (is_coarse and rise < FINE * quantum) or not _has_corner(record, start, end, noise):
        return None
    level, scatter = float(part.mean()), float(part.std(ddof=1))
    ends = _has_fall(record[end:], level, noise, end - start >= LONG)
    return Plateau(level, scatter / len(part) ** 0.5, start, end, noise, scatter, ends)


def _has_fall(samples: Array, level: float, noise: float, is_long: bool) -> bool:
    """Return whether the samples after a plateau fall below it: most of them, or all at once."""
    if len(samples) < LEAST:
        return False
    deep = samples < level - max(FALLS * noise, DEEP * level)
    if deep[:SUDDEN].any() and deep[SUDDEN:LEAST].any():
        return True
    return is_long and float(np.median(samples)) < level - FALLS * noise


def _locate_top(record: Array, noise: float) -> tuple[int, int]:
    """Return the ends of the samples around the maximum that the noise explains as its level."""
    smooth = running_mean(record, SMOOTH)
    top = int(np.argmax(smooth))
    start, end = _extend_section(top, top, smooth < smooth[top] - BAND * noise / SMOOTH**0.5)
    # the running mean is too low within half its length of either end
    start, end = start + SMOOTH // 2, end - SMOOTH // 2
    if end <= start:
        return top, top
    level = float(record[start:end].mean())
    return _extend_section(start, end, np.abs(record - level) > CLOSE * noise)


def _extend_section(first: int, last: int, outside: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """Return the section from `first` to `last`, extended until a sample is outside."""
    before, after = outside[:first][::-1], outside[last:]
    return (
        first - int(before.argmax()) if before.any() else 0,
        last + int(after.argmax()) if after.any() else len(outside),
    )


def _is_flat(part: Array, noise: float) -> bool:
    """Return whether a constant with white noise describes the part."""
    # the noise hides the last samples of the rise among those of the plateau
    edge = len(part) // 12
    part = part[edge : len(part) - edge]
    count = len(part)
    if float(part.std(ddof=1)) > noise * (NOISIER[0] + NOISIER[1] / count**0.5):
        return False
    place = np.linspace(-1, 1, count)
    parabola = np.polynomial.Polynomial.fit(place, part, 2)(place)
    return float(((parabola - part.mean()) ** 2).sum()) <= CURVED * noise**2


def _has_corner(record: Array, start: int, end: int, noise: float) -> bool:
    """Return whether a line that ends in a constant describes rise and top better than a cubic."""
    level = float(record[start:end].mean())
    low = np.flatnonzero(record[:start] < LOWEST * level)
    first = max(int(low[-1]) if len(low) else 0, start - (end - start) - SMOOTH)
    part = record[first:end]
    place = np.linspace(-1, 1, len(part))
    cubic = np.polynomial.Polynomial.fit(place, part, 3)(place)
    misfit = float(((part - cubic) ** 2).sum())
    corner = min(
        _line_misfit(place[:k], part[:k]) + float(((part[k:] - part[k:].mean()) ** 2).sum())
        for k in range(max(start - first - SMOOTH, 1), start - first + SMOOTH // 2)
    )
    return misfit - corner > 2 * LIKELIER * noise**2


def _line_misfit(x: Array, y: Array) -> float:
    if len(x) < 3:
        return 0.0
    line = np.polynomial.Polynomial.fit(x, y, 1)(x)
    return float(((y - line) ** 2).sum())
