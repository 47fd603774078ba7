"""What single curves do to an answer: leave one out, and the bootstrap over repeats."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.identify.calibration.intervals import Interval, Population, quantile

SEED = 1
"""Of the bootstrap, so that the same files give the same numbers."""
Contrasts = Mapping[str, np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Move:
    """What was left out (a file, or all files of a condition) and by how much the value moves."""

    left_out: str
    by: float
    condition: bool


def moves(
    population: Population,
    contrasts: Contrasts,
    names: Sequence[str],
    groups: Mapping[str, Sequence[int]],
    logarithmic: Mapping[str, float] | None = None,
) -> dict[str, tuple[Move, ...]]:
    """For every value all moves, files first, each from the greatest to the least.

    `names` are the files', `groups` the places of the files of each condition, `logarithmic`
    {name: value} the values whose logarithm is estimated. To first order, which is what a sum of
    squares is about its least. Without a file that alone tells the value there is no move.
    """
    found: dict[str, list[Move]] = {name: [] for name in contrasts}
    names = distinct(names)
    sets: list[tuple[Sequence[int], str, bool]] = [((i,), n, False) for i, n in enumerate(names)]
    if len(groups) > 1:
        sets += [(group, words, True) for words, group in groups.items()]
    for out, words, condition in sets:
        shift = population.shift(out) if len(out) < population.count else None
        if shift is None:
            continue
        for name, contrast in contrasts.items():
            by = float(contrast @ shift)
            if logarithmic is not None and name in logarithmic:
                by = logarithmic[name] * float(np.expm1(by))
            found[name].append(Move(left_out=words, by=by, condition=condition))
    return {
        name: tuple(sorted(all_of, key=lambda m: (m.condition, -abs(m.by))))
        for name, all_of in found.items()
    }


def distinct(names: Sequence[str]) -> list[str]:
    """The names, those that repeat numbered: files of one name in several folders, or specimens."""
    count, out = Counter(names), []
    seen: Counter[str] = Counter()
    for name in names:
        seen[name] += 1
        out.append(f"{name} ({seen[name]})" if count[name] > 1 else name)
    return out


def bootstrap_intervals(
    population: Population, groups: Sequence[Sequence[int]], contrasts: Contrasts
) -> dict[str, Interval | None]:
    """95 % intervals on the scale of the estimate: standard deviation of resampled repeats, with t.

    None where too few repeats can be resampled, or one of them alone tells the value.
    """
    draws, degrees = population.bootstrap(groups, SEED)
    out: dict[str, Interval | None] = {}
    for name, contrast in contrasts.items():
        if degrees < 1 or population.standard_error(contrast) is None:
            out[name] = None
            continue
        at, error = float(contrast @ population.estimate), float((draws @ contrast).std())
        wide = quantile(degrees) * error
        out[name] = Interval(
            low=at - wide,
            high=at + wide,
            standard_error=error,
            degrees_of_freedom=degrees,
            method="bootstrap over repeats, with t",
        )
    return out
