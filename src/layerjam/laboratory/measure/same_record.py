"""Detection of a record that was exported twice, with a different sampling, unit or separator.

Repeats of one brake look similar, but the noise of the load cell identifies a record. The noise is
compared by means of second differences, which contain almost nothing else.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field

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


@dataclass
class Records:
    """Records read so far, by name."""

    seen: dict[str, Trace] = field(default_factory=dict)

    def find_original(self, trace: Trace) -> str | None:
        """Return the name of an earlier record of which this is a copy, or None."""
        part = _select_peak_window(trace)
        return next(
            (name for name, earlier in self.seen.items() if is_same_record(earlier, part)), None
        )

    def add(self, name: str, trace: Trace) -> None:
        """Store a record."""
        self.seen[name] = _select_peak_window(trace)


def is_same_record(first: Trace, second: Trace) -> bool:
    """Return whether two traces are the same record: curves equal up to noise, and equal noise."""
    return noise_correlation(first, second) >= ALIKE


def noise_correlation(trace: Trace, other_trace: Trace) -> float:
    """Return the noise correlation of two records [-]; 0 unless their curves agree within noise."""
    best = 0.0
    for clock in ("elongation", "time"):
        first, second = _select_rising_part(trace, clock), _select_rising_part(other_trace, clock)
        if first is not None and second is not None:
            best = max(best, *_correlate(first, second))
    return best


def _select_peak_window(trace: Trace) -> Trace:
    start = max(0, min(int(trace.force.argmax()) - SAMPLE_LIMIT // 2, len(trace) - SAMPLE_LIMIT))
    part = slice(start, start + SAMPLE_LIMIT)
    time = None if trace.time is None else trace.time[part]
    return Trace(trace.force[part], trace.elongation[part], time, trace.path, trace.format)


def _select_rising_part(trace: Trace, clock: str) -> tuple[Array, Array] | None:
    """Return time or elongation up to its maximum, and the force, with each value only once."""
    values = getattr(trace, clock)
    if values is None or len(values) < LEAST:
        return None
    clock_values, first = np.unique(values[: int(values.argmax()) + 1], return_index=True)
    return (clock_values, trace.force[first]) if len(first) >= LEAST else None


def _correlate(curve: tuple[Array, Array], other_curve: tuple[Array, Array]) -> Iterator[float]:
    """Yield the noise correlations with a common origin of the clock, and with a common start.

    A record with every n-th sample stored may start with a different sample.
    """
    yield 0.0
    dense, sparse = sorted((curve, other_curve), key=lambda pair: _find_clock_step(pair[0]))
    step = _find_clock_step(dense[0])
    limit = min(int(np.ceil(_find_clock_step(sparse[0]) / step)), STARTS)
    start = dense[0][0] - sparse[0][0]
    if not any(_is_close_copy((sparse[0] + offset, sparse[1]), dense) for offset in (0.0, start)):
        return
    for offset in (0.0, *(start + n * step for n in range(-limit, limit + 1))):
        yield from _correlate_samples((sparse[0] + offset, sparse[1]), dense)


def _is_close_copy(sparse: tuple[Array, Array], dense: tuple[Array, Array]) -> bool:
    """Return whether two curves differ by little more than noise, as copies do."""
    part = slice(None, None, max(1, len(sparse[0]) // SAMPLE))
    gaps = np.abs(sparse[1][part] - np.interp(sparse[0][part], *dense))
    second = np.abs(sparse[1][1:-1] - (sparse[1][2:] + sparse[1][:-2]) / 2)
    return bool(np.median(gaps) <= 10 * np.median(second))


def _find_clock_step(clock: Array) -> float:
    return float(np.median(np.diff(clock)))


def _correlate_samples(sparse: tuple[Array, Array], dense: tuple[Array, Array]) -> Iterator[float]:
    """Yield the correlations at the samples of the sparser record.

    The denser record is sampled at these points, and averaged around them, as programs resample.
    """
    low, high = max(sparse[0][0], dense[0][0]), min(sparse[0][-1], dense[0][-1])
    spans = [clock[-1] - clock[0] for clock in (sparse[0], dense[0])]
    if high - low < SHARED * min(spans):
        return
    is_inside = (sparse[0] >= low) & (sparse[0] <= high)
    grid, force = sparse[0][is_inside], sparse[1][is_inside]
    if len(grid) < LEAST:
        return
    yield _correlate_forces(force, np.interp(grid, *dense))
    steps = np.diff(dense[0]) * (dense[1][1:] + dense[1][:-1]) / 2
    total = np.concatenate([[0.0], np.cumsum(steps)])
    edges = np.concatenate([grid[:1], (grid[1:] + grid[:-1]) / 2, grid[-1:]])
    means = np.diff(np.interp(edges, dense[0], total)) / np.diff(edges)
    yield _correlate_forces(force, means)
    if len(grid) >= 2 * LEAST:
        yield _correlate_forces(_smooth_values(force), _smooth_values(means), 2)


def _smooth_values(values: Array) -> Array:
    return np.asarray((values[2:] + 2 * values[1:-1] + values[:-2]) / 4)


def _correlate_forces(force: Array, other_force: Array, step: int = 1) -> float:
    """Return the correlation of second differences; 0 without noise or if the curves differ."""
    noise = [v[step:-step] - (v[2 * step :] + v[: -2 * step]) / 2 for v in (force, other_force)]
    sizes = [float(np.median(np.abs(part))) for part in noise]
    if min(sizes) < QUIET * float(np.ptp(force)):
        return 0.0
    if float(np.median(np.abs(force - other_force))) > CLOSE_CURVES * min(sizes):
        return 0.0
    ends = [MOST_SIZE * size for size in sizes]
    first, second = (np.clip(n, -end, end) for n, end in zip(noise, ends, strict=True))
    return float(np.corrcoef(first, second)[0, 1])
