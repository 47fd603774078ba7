"""What curves say of a value: interval, bootstrap over repeats, how far one curve moves it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.identify.calibration.further import further
from layerjam.identify.calibration.intervals import Interval, Population
from layerjam.identify.curves import Curve, condition_words
from layerjam.identify.shape import SHAPE

SEED = 1
"""Of the bootstrap, so that the same files give the same numbers."""
BOOTSTRAP = "bootstrap over repeats, with t"
FEWEST_DEGREES = 0.5
"""Degrees of freedom below which no interval is stated."""
Contrasts = Mapping[str, np.ndarray]
Covariance = Mapping[str, Mapping[str, float]]
"""{value: {value: covariance}}, symmetric, each in the product of the two values' units."""


@dataclass(frozen=True, kw_only=True)
class Influence:
    """By how much a value moves without a file, and without all files of a condition.

    Each from the greatest to the least; `most_influential` is the first file, None without any.
    """

    most_influential: str | None
    files: Mapping[str, float]
    conditions: Mapping[str, float]


def estimates(
    population: Population,
    contrasts: Contrasts,
    curves: Sequence[Curve],
    groups: Sequence[Sequence[int]],
    method: str,
    logarithmic: Collection[str] = (),
    *,
    mountings: Sequence[Sequence[int]],
    shared: Mapping[str, float] | None = None,
) -> dict[str, Any]:
    """The fields of a Calibration that a population of curves tells, by name of the contrast.

    And `scatter`: the standard error from the scatter between curves alone, and its degrees of
    freedom.

    `groups` are the places of the curves of each condition, `mountings` those of each mounting,
    which intervals rest on; of `logarithmic` values the logarithm is estimated. `shared` {name:
    standard uncertainty over the value} is what all curves have in common, so that their scatter
    does not contain it.
    """
    shared = shared or {}
    values: dict[str, float] = {}
    intervals: dict[str, Interval | None] = {}
    scatter: dict[str, tuple[float, float] | None] = {}
    units = population.joined(mountings)
    together = units.count < population.count
    resampled = bootstrap_errors(units, [range(units.count)] if together else groups, contrasts)
    bootstrap: dict[str, Interval | None] = {}
    for name, contrast in contrasts.items():
        at, found = float(contrast @ population.estimate), units.standard_error(contrast)
        if found is not None and found[1] < FEWEST_DEGREES:
            found = None
        value = values[name] = float(np.exp(at)) if name in logarithmic else at
        size, common = value if name in logarithmic else 1.0, shared.get(name, 0.0)
        scatter[name] = found and (size * found[0], found[1])
        again = resampled[name]
        again = again and (size * again[0], again[1])
        intervals[name] = interval_of(name, value, scatter[name], common, method)
        bootstrap[name] = interval_of(name, value, again, common, BOOTSTRAP)
    names = [c.name for c in curves]
    alike = {condition_words(curves[group[0]]): group for group in groups}
    logs = {name: values[name] for name in logarithmic}
    sizes = {name: 1.0 if name in logarithmic else value for name, value in values.items()}
    told = {n: logs.get(n, 1.0) * contrast for n, contrast in contrasts.items() if intervals[n]}
    covariance = covariance_of(units, told)
    for name in covariance:
        covariance[name][name] += (values[name] * shared.get(name, 0.0)) ** 2
    return {
        "values": values,
        "scatter": scatter,
        "covariance": covariance,
        "standard_errors": {n: i and i.standard_error for n, i in intervals.items()},
        "intervals": intervals,
        "bootstrap": bootstrap,
        "leave_one_out": moves(population, contrasts, names, alike, logs),
        "further": further(population, contrasts, alike, sizes, shared, units),
    }


def covariance_of(population: Population, contrasts: Contrasts) -> dict[str, dict[str, float]]:
    """The sandwich covariance of linear combinations of the estimate; none where it is unknown."""
    whole = population.covariance()
    whole = (whole + whole.T) / 2
    if not np.isfinite(whole).all():
        return {}
    return {
        one: {other: float(np.sum(whole * np.outer(a, b))) for other, b in contrasts.items()}
        for one, a in contrasts.items()
    }


def interval_of(
    name: str,
    value: float,
    found: tuple[float, float] | None,
    shared: float,
    method: str,
) -> Interval | None:
    """The interval of a value from its standard error and degrees of freedom.

    `shared` is its standard uncertainty, over the value, that the scatter does not contain. That
    one is taken as known exactly.
    """
    if found is None:
        return None
    parts = [found, (value * shared, math.inf)] if shared else [found]
    return Interval.about(value, parts, method, positive=name in SHAPE and value > 0)


def moves(
    population: Population,
    contrasts: Contrasts,
    names: Sequence[str],
    groups: Mapping[str, Sequence[int]],
    logarithmic: Mapping[str, float] | None = None,
) -> dict[str, Influence]:
    """For every value what leaving out a file, or the files of a condition, does to it.

    `names` are the files', `groups` the places of the files of each condition, `logarithmic`
    {name: value} the values whose logarithm is estimated. To first order, which is what a sum of
    squares is about its least. A file that alone tells the value moves nothing.
    """
    single = {name: (place,) for place, name in enumerate(distinct(names))}
    sets = single, groups if len(groups) > 1 else {}
    shifts = [
        {
            words: shift
            for words, out in some.items()
            if len(out) < population.count and (shift := population.shift(out)) is not None
        }
        for some in sets
    ]
    made = {}
    for name, contrast in contrasts.items():
        value = (logarithmic or {}).get(name)
        files, conditions = (_ranked(some, contrast, value) for some in shifts)
        most = next(iter(files), None)
        made[name] = Influence(most_influential=most, files=files, conditions=conditions)
    return made


def _ranked(
    shifts: Mapping[str, np.ndarray], contrast: np.ndarray, value: float | None
) -> dict[str, float]:
    by = {words: float(contrast @ shift) for words, shift in shifts.items()}
    if value is not None:
        by = {words: value * float(np.expm1(moved)) for words, moved in by.items()}
    return dict(sorted(by.items(), key=lambda moved: -abs(moved[1])))


def distinct(names: Sequence[str]) -> list[str]:
    """The names, those that repeat numbered: files of one name in several folders, or specimens."""
    count, out = Counter(names), []
    seen: Counter[str] = Counter()
    for name in names:
        seen[name] += 1
        out.append(f"{name} ({seen[name]})" if count[name] > 1 else name)
    return out


def bootstrap_errors(
    population: Population, groups: Sequence[Sequence[int]], contrasts: Contrasts
) -> dict[str, tuple[float, float] | None]:
    """Standard deviation of the estimate over resampled repeats, and degrees of freedom.

    None if too few repeats can be resampled, or one of them alone tells the value.
    """
    if population.count < 2:
        return dict.fromkeys(contrasts)
    draws, degrees = population.bootstrap(groups, SEED)
    return {
        name: (float((draws @ contrast).std()), float(degrees))
        if degrees >= 1 and population.standard_error(contrast) is not None
        else None
        for name, contrast in contrasts.items()
    }
