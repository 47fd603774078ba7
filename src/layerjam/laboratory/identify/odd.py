"""Outliers among values, as shifts of the mean, corrected for the number of values.

The scatter is estimated from the other values alone, so that an outlier cannot be masked by the
scatter it causes. For one value this is Grubbs' test. The joint removal of two or three values is
tested in the same way (Cook and Weisberg 1982, section 2.2), so that two outliers cannot mask each
other.
"""

import functools
from collections.abc import Sequence

import numpy as np

from layerjam.laboratory.measure.trace import Array

FEWEST = 3
"""Minimum number of values for identifying an outlier: two cannot show which one is wrong."""
FIRST = 0.8
"""Fraction of the false alarms spent on single values; larger sets share the remainder."""
GROSS = 1.3
"""Ratio to the median beyond which a value may be a gross outlier. The friction of a film scatters
by 8 % (Table I), so a deviation of one third is four standard deviations."""
SPREADS = 6.0
"""Number of standard deviations of the others beyond which a value is a gross outlier."""
PART = 4
"""Smallest number of values per outlier."""
MINORITY = 2
"""Largest number of values that may be left out without a decision, of at least eight."""
SIMULATED = 2_000_000
"""Number of normal values from which a critical value is computed."""


def find_outliers(
    values: Array, alarms: float, min_difference: float, limit: float = float("inf")
) -> tuple[int, ...]:
    """Return the indices of outliers among normal values, shape (N,), in ascending order.

    `alarms` limits the fraction of faultless sets in which any outlier is reported (Bonferroni over
    all sets of the same size). A value within `min_difference` of the others' mean is never an
    outlier; a value more than `limit` from the median always is.
    """
    count = len(values)
    if count < FEWEST:
        return ()
    distant = np.flatnonzero(np.abs(values - np.median(values)) > limit)
    sizes = range(1, max(1, min(count // PART, count - 3)) + 1)
    best: tuple[float, tuple[int, ...]] = (1.0, ())
    for size in sizes:
        share = FIRST if size == 1 else (1 - FIRST) / (len(sizes) - 1)
        chance, indices = _find_likeliest_outliers(values, size)
        others_mean = np.delete(values, indices).mean()
        if np.abs(values[list(indices)] - others_mean).min() <= min_difference:
            continue
        ratio = chance / (alarms * (share if len(sizes) > 1 else 1.0))
        best = min(best, (ratio, indices))
    return tuple(sorted({*distant.tolist(), *best[1]}))


def mean_without_outliers(values: Array, out: Sequence[int]) -> float:
    """Return the mean of the values not in `out`; the median of all if `out` contains them all."""
    peers = np.delete(values, list(out))
    return float(peers.mean() if len(peers) else np.median(values))


def outlier_limit(count: int) -> int:
    """Return how many of `count` values may be left out without a decision.

    One of four to seven, two of eight or more. Among three or fewer, or if more values deviate,
    the values do not show which of them are right.
    """
    return min(MINORITY, count // PART)


def find_gross_outliers(values: Sequence[float | None]) -> dict[int, float]:
    """Return {index: ratio to the median} of positive values that no scatter explains.

    Such a value deviates from the median by more than `GROSS` and by more than `SPREADS` standard
    deviations. These are estimated from the median deviation, so fewer than half of the values can
    be outliers. Among fewer than `FEWEST` values there are none.
    """
    pairs = {i: float(np.log(v)) for i, v in enumerate(values) if v is not None and v > 0}
    if len(pairs) < FEWEST:
        return {}
    logs = np.array(list(pairs.values()))
    gaps = logs - np.median(logs)
    spread = 1.4826 * float(np.median(np.abs(gaps)))
    outside = np.abs(gaps) > max(float(np.log(GROSS)), SPREADS * spread)
    return {
        i: float(np.exp(d)) for i, d, out in zip(pairs, gaps, outside, strict=True) if bool(out)
    }


def _find_likeliest_outliers(values: Array, size: int) -> tuple[float, tuple[int, ...]]:
    """Return (probability, indices) of the `size` values that differ most from the others.

    They are the lowest and the highest values, some from each end of the sorted values.
    """
    from scipy.special import comb, fdtrc

    count = len(values)
    freedom = count - 1 - size
    order = np.argsort(values)
    sums = [
        (float(((peers := np.delete(values, out)) - peers.mean()) @ (peers - peers.mean())), out)
        for low in range(size + 1)
        if (out := [*order[:low].tolist(), *order[count - (size - low) :].tolist()])
    ]
    remainder, out = min(sums)
    total = float((values - values.mean()) @ (values - values.mean()))
    if not remainder > 1e-18 * total:
        return 0.0, tuple(out)
    ratio = (total - remainder) / size / (remainder / freedom)
    chance = float(comb(count, size)) * float(fdtrc(size, freedom, ratio))
    return chance, tuple(out)


def find_shifted_group(
    values: Array, groups: Sequence[Sequence[int]], alarms: float, min_difference: float
) -> tuple[tuple[int, ...], float] | None:
    """Return the group whose mean differs most from the others', and the difference, or None.

    The test is Student's t, with the scatter within the group and within the others, for all groups
    of at least two values.
    """
    from scipy.special import stdtr

    count = len(values)
    candidates = [g for g in groups if 2 <= len(g) <= count - 2]
    tests = 1 if len(groups) == 2 else len(candidates)
    best: tuple[float, tuple[int, ...], float] | None = None
    for group in candidates:
        members, peers = values[list(group)], np.delete(values, list(group))
        gap = float(members.mean() - peers.mean())
        squares = float(
            ((members - members.mean()) ** 2).sum() + ((peers - peers.mean()) ** 2).sum()
        )
        error = float(np.sqrt(squares / (count - 2) * (1 / len(members) + 1 / len(peers))))
        chance = 0.0 if error <= 1e-9 * abs(gap) else 2 * float(stdtr(count - 2, -abs(gap) / error))
        if best is None or (chance, -abs(gap)) < (best[0], -abs(best[2])):
            best = chance, tuple(group), gap
    if best is None or best[0] * tests > alarms or abs(best[2]) <= min_difference:
        return None
    return best[1], best[2]


def find_two_groups(values: Array, alarms: float, min_difference: float) -> tuple[int, ...] | None:
    """Return the indices of the smaller of two groups of normal values, shape (N,), or None.

    The values are divided at the point that explains most of their variance, into groups of at
    least two. The groups are separate if their means differ by more than `min_difference`, and
    if at most a fraction `alarms` of normal samples of that size can be divided too.
    """
    count = len(values)
    if count < 4:
        return None
    order = np.argsort(values)
    shares = _explained_shares(values[order][None])[0]
    size = int(shares.argmax()) + 2
    low, high = order[:size], order[size:]
    if float(values[high].mean() - values[low].mean()) <= min_difference:
        return None
    if shares.max() <= _critical_share(count, alarms):
        return None
    smaller = low if len(low) <= len(high) else high
    return tuple(sorted(smaller.tolist()))


def _explained_shares(rows: Array) -> Array:
    """Return the share of variance that each division explains, (samples, N - 3).

    `rows` (samples, N) is sorted; division n has n + 2 values in its lower group.
    """
    count = rows.shape[1]
    offsets = rows - rows.mean(axis=1, keepdims=True)
    size = np.arange(2, count - 1)
    group_squares = np.cumsum(offsets, axis=1)[:, 1:-2] ** 2 * count / (size * (count - size))
    total = np.maximum((offsets**2).sum(axis=1, keepdims=True), 1e-300)
    return np.asarray(group_squares / total)


@functools.cache
def _critical_share(count: int, alarms: float) -> float:
    """Return the share of variance that the best division exceeds with probability `alarms`."""
    random = np.random.Generator(np.random.PCG64(count))
    samples = np.sort(random.standard_normal((max(SIMULATED // count, 2000), count)), axis=1)
    return float(np.quantile(_explained_shares(samples).max(axis=1), 1 - alarms))
