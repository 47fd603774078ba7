"""Detection of a record that was exported twice, with a different sampling, unit or separator.

Repeats of one brake look similar, but the noise of the load cell identifies a record. The noise is
compared by means of second differences, which contain almost nothing else.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from layerjam.laboratory.measure.trace import Array, Trace

LEAST, SAMPLE_LIMIT = 30, 20_000
"""Minimum number of common samples for a comparison, and maximum number stored of a record."""
ALIKE = 0.75
"""Correlation of the noise above which two records are the same. Repeats of virtual brakes reach
0.46. Strokes of a printed actuator reach 0.84, but their curves differ by 1.5 times the noise."""
CLOSE_CURVES = 1.0
"""Ratio of the curves' median difference to that of the noise, below which records may match."""
QUIET = 1e-5
"""Noise, relative to the range of forces, below which a record counts as computed, so that two such
records may be alike without being copies."""
SHARED = 0.5
"""Fraction of the shorter record that both must have in common."""
MOST_SIZE = 4.5
"""Level, relative to its median size, at which noise is clipped so that no jump dominates."""
SAMPLE = 200
"""Number of points at which two curves are compared before their noise is compared."""
STARTS = 50
"""Number of samples of the denser record that are tried as the start of the sparser record."""


@dataclass(frozen=True)
class _Curve:
    """Rising part of a record: increasing times or elongations, and forces."""

    clock: Array
    force: Array
    step: float
    """Median step of the clock."""
    noise: float
    """Median second difference of the force, halved [N]."""

    @property
    def start(self) -> float:
        return float(self.clock[0])

    def shift(self, offset: float) -> "_Curve":
        """Return the curve with a later origin of the clock."""
        return replace(self, clock=self.clock + offset)


_Curves = dict[str, _Curve]
"""Curves of one record versus elongation and versus time, if it has them."""


@dataclass
class Records:
    """Records read so far, by name."""

    seen: dict[str, _Curves] = field(default_factory=dict)

    def find_original(self, trace: Trace) -> str | None:
        """Return the name of an earlier record of which this is a copy, or None."""
        curves = _make_curves(trace)
        return next(
            (name for name, earlier in self.seen.items() if _correlate(earlier, curves) >= ALIKE),
            None,
        )

    def add(self, name: str, trace: Trace) -> None:
        """Store a record."""
        self.seen[name] = _make_curves(trace)


def is_same_record(first: Trace, second: Trace) -> bool:
    """Return whether two traces are the same record: curves equal up to noise, and equal noise."""
    return noise_correlation(first, second) >= ALIKE


def noise_correlation(trace: Trace, other_trace: Trace) -> float:
    """Return the noise correlation of two records [-]; 0 unless their curves agree within noise."""
    return _correlate(_make_curves(trace), _make_curves(other_trace))


def _make_curves(trace: Trace) -> _Curves:
    start = max(0, min(int(trace.force.argmax()) - SAMPLE_LIMIT // 2, len(trace) - SAMPLE_LIMIT))
    part = slice(start, start + SAMPLE_LIMIT)
    clocks = {"elongation": trace.elongation, "time": trace.time}
    curves = {
        name: _select_rising_part(values[part], trace.force[part])
        for name, values in clocks.items()
        if values is not None
    }
    return {name: curve for name, curve in curves.items() if curve is not None}


def _select_rising_part(values: Array, force: Array) -> _Curve | None:
    """Return the curve up to the maximum of the clock, with each value of the clock only once."""
    if len(values) < LEAST:
        return None
    clock, first = np.unique(values[: int(values.argmax()) + 1], return_index=True)
    if len(first) < LEAST:
        return None
    force = force[first]
    return _Curve(clock, force, float(np.median(np.diff(clock))), _size(_find_noise(force)))


def _correlate(first: _Curves, second: _Curves) -> float:
    pairs = [(first[name], second[name]) for name in first if name in second]
    return max((value for pair in pairs for value in _correlate_curves(*pair)), default=0.0)


def _correlate_curves(first: _Curve, second: _Curve) -> Iterator[float]:
    """Yield the noise correlations with a common origin of the clock, and with a common start.

    A record with every n-th sample stored may start with a different sample.
    """
    yield 0.0
    dense, sparse = sorted((first, second), key=lambda curve: curve.step)
    limit = min(int(np.ceil(sparse.step / dense.step)), STARTS)
    start = dense.start - sparse.start
    if not any(_is_close_copy(sparse.shift(offset), dense) for offset in (0.0, start)):
        return
    for offset in (0.0, *(start + n * dense.step for n in range(-limit, limit + 1))):
        yield from _correlate_samples(sparse.shift(offset), dense)


def _is_close_copy(sparse: _Curve, dense: _Curve) -> bool:
    """Return whether two curves differ by little more than noise, as copies do."""
    part = slice(None, None, max(1, len(sparse.clock) // SAMPLE))
    gaps = np.abs(sparse.force[part] - np.interp(sparse.clock[part], dense.clock, dense.force))
    return bool(np.median(gaps) <= 10 * sparse.noise)


def _correlate_samples(sparse: _Curve, dense: _Curve) -> Iterator[float]:
    """Yield the correlations at the samples of the sparser record.

    The denser record is sampled at these points, and averaged around them, as programs resample.
    """
    low, high = max(sparse.start, dense.start), min(sparse.clock[-1], dense.clock[-1])
    if high - low < SHARED * min(np.ptp(sparse.clock), np.ptp(dense.clock)):
        return
    is_inside = (sparse.clock >= low) & (sparse.clock <= high)
    grid, force = sparse.clock[is_inside], sparse.force[is_inside]
    if len(grid) < LEAST:
        return
    size = _size(_find_noise(force))
    yield _correlate_forces(force, size, np.interp(grid, dense.clock, dense.force))
    steps = np.diff(dense.clock) * (dense.force[1:] + dense.force[:-1]) / 2
    total = np.concatenate([[0.0], np.cumsum(steps)])
    edges = np.concatenate([grid[:1], (grid[1:] + grid[:-1]) / 2, grid[-1:]])
    means = np.diff(np.interp(edges, dense.clock, total)) / np.diff(edges)
    yield _correlate_forces(force, size, means)
    if len(grid) >= 2 * LEAST:
        smooth, smooth_means = _smooth_values(force), _smooth_values(means)
        yield _correlate_forces(smooth, _size(_find_noise(smooth, 2)), smooth_means, 2)


def _smooth_values(values: Array) -> Array:
    return np.asarray((values[2:] + 2 * values[1:-1] + values[:-2]) / 4)


def _find_noise(force: Array, step: int = 1) -> Array:
    """Return the second differences of a force, halved."""
    return np.asarray(force[step:-step] - (force[2 * step :] + force[: -2 * step]) / 2)


def _size(noise: Array) -> float:
    """Return the median size of noise [N]."""
    return float(np.median(np.abs(noise)))


def _correlate_forces(force: Array, size: float, other_force: Array, step: int = 1) -> float:
    """Return the correlation of second differences; 0 without noise or if the curves differ.

    `size` is the median noise of `force`. Most curves differ by more than it, so that this is
    tested first, by counting.
    """
    gaps, least = np.abs(force - other_force), QUIET * float(np.ptp(force))
    if size < least or 2 * np.count_nonzero(gaps <= CLOSE_CURVES * size) < len(gaps) - 1:
        return 0.0
    other_noise = _find_noise(other_force, step)
    sizes = size, _size(other_noise)
    if sizes[1] < least or float(np.median(gaps)) > CLOSE_CURVES * min(sizes):
        return 0.0
    ends = [MOST_SIZE * size for size in sizes]
    noise = _find_noise(force, step), other_noise
    first, second = (np.clip(n, -end, end) for n, end in zip(noise, ends, strict=True))
    return float(np.corrcoef(first, second)[0, 1])
