"""Which of several values is unlike the others: shifts of the mean, corrected for their number.

The others' scatter is estimated from the others alone, so that an odd value does not hide behind
the scatter it makes. For one value that is Grubbs' test; for two or three the same test of their
common removal (Cook and Weisberg 1982, section 2.2), so that two odd values cannot hide each other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from layerjam.measure.trace import Array

FEWEST = 3
"""Values below which none can be called odd: of two nothing says which."""
FIRST = 0.8
"""Share of the false alarms that is spent on a single value; sets of several share the rest."""
GROSS = 1.3
"""Ratio to the median beyond which a value may be a gross outlier: the friction of a film scatters
by 8 % (Table I), so a third off is four standard deviations."""
SPREADS = 6.0
"""Standard deviations of the other values beyond which a value is a gross outlier."""
PART = 4
"""At most one value in so many can be odd together."""


def odd_ones(
    values: Array, alarms: float, least: float, most: float = float("inf")
) -> tuple[int, ...]:
    """Indices of the odd values among normal ones, shape (N,), in rising order.

    `alarms` is the share of sets of like values in which any is called odd, at most (Bonferroni
    over all sets of the same size). What lies within `least` of the others' mean is never odd, what
    lies more than `most` off the median always.
    """
    count = len(values)
    if count < FEWEST:
        return ()
    far = np.flatnonzero(np.abs(values - np.median(values)) > most)
    sizes = range(1, max(1, min(count // PART, count - 3)) + 1)
    chosen: tuple[float, tuple[int, ...]] = (1.0, ())
    for size in sizes:
        share = FIRST if size == 1 else (1 - FIRST) / (len(sizes) - 1)
        chance, which = _likeliest(values, size)
        rest = np.delete(values, which).mean()
        if np.abs(values[list(which)] - rest).min() <= least:
            continue
        ratio = chance / (alarms * (share if len(sizes) > 1 else 1.0))
        chosen = min(chosen, (ratio, which))
    return tuple(sorted({*far.tolist(), *chosen[1]}))


def middle_of_others(values: Array, out: Sequence[int]) -> float:
    """Return the mean of the values not in `out`; the median of all if `out` has every value."""
    rest = np.delete(values, list(out))
    return float(rest.mean() if len(rest) else np.median(values))


def gross_outliers(values: Sequence[float | None]) -> dict[int, float]:
    """Return {index: ratio to the median} of positive values that no scatter explains.

    Such a value is off the median by more than `GROSS` and by more than `SPREADS` standard
    deviations, estimated from the median deviation, so that fewer than half of the values can be
    outliers. Fewer than `FEWEST` values have none.
    """
    known = {i: float(np.log(v)) for i, v in enumerate(values) if v is not None and v > 0}
    if len(known) < FEWEST:
        return {}
    logs = np.array(list(known.values()))
    off = logs - np.median(logs)
    spread = 1.4826 * float(np.median(np.abs(off)))
    outside = np.abs(off) > max(float(np.log(GROSS)), SPREADS * spread)
    return {i: float(np.exp(d)) for i, d, out in zip(known, off, outside, strict=True) if bool(out)}


def _likeliest(values: Array, size: int) -> tuple[float, tuple[int, ...]]:
    """(probability among like values, indices) of the set of `size` that is most unlike the rest.

    It stands at the ends of the values in order: some at the low end, the others at the high one.
    """
    from scipy.special import comb, fdtrc

    count = len(values)
    freedom = count - 1 - size
    order = np.argsort(values)
    sums = [
        (float(((rest := np.delete(values, out)) - rest.mean()) @ (rest - rest.mean())), out)
        for low in range(size + 1)
        if (out := [*order[:low].tolist(), *order[count - (size - low) :].tolist()])
    ]
    left, out = min(sums)
    whole = float((values - values.mean()) @ (values - values.mean()))
    if not left > 1e-18 * whole:
        return 0.0, tuple(out)
    ratio = (whole - left) / size / (left / freedom)
    chance = float(comb(count, size)) * float(fdtrc(size, freedom, ratio))
    return chance, tuple(out)


def group_apart(
    values: Array, groups: Sequence[Sequence[int]], alarms: float, least: float
) -> tuple[tuple[int, ...], float] | None:
    """The group whose mean lies furthest off the others', and by how much; None where none does.

    Student's t with the scatter within group and rest, over all groups of two values or more.
    """
    from scipy.special import stdtr

    count = len(values)
    tried = [g for g in groups if 2 <= len(g) <= count - 2]
    tests = 1 if len(groups) == 2 else len(tried)
    best: tuple[float, tuple[int, ...], float] | None = None
    for group in tried:
        inside, rest = values[list(group)], np.delete(values, list(group))
        off = float(inside.mean() - rest.mean())
        squares = float(((inside - inside.mean()) ** 2).sum() + ((rest - rest.mean()) ** 2).sum())
        error = float(np.sqrt(squares / (count - 2) * (1 / len(inside) + 1 / len(rest))))
        chance = 0.0 if error <= 1e-9 * abs(off) else 2 * float(stdtr(count - 2, -abs(off) / error))
        if best is None or (chance, -abs(off)) < (best[0], -abs(best[2])):
            best = chance, tuple(group), off
    if best is None or best[0] * tests > alarms or abs(best[2]) <= least:
        return None
    return best[1], best[2]
