"""Statistics of a value over curves: interval, bootstrap, and the influence of each curve."""

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.laboratory.identify.calibration.intervals import (
    Interval,
    Population,
    predict_further_pulls,
)
from layerjam.laboratory.identify.curves import Curve, describe_condition
from layerjam.laboratory.identify.shape import SHAPE

SEED = 1
"""Seed of the bootstrap: the same files yield the same results."""
BOOTSTRAP = "bootstrap over repeats, with t"
FEWEST_DEGREES = 0.5
"""Degrees of freedom below which no interval is stated."""
Contrasts = Mapping[str, np.ndarray]
Covariance = Mapping[str, Mapping[str, float]]
"""{value: {value: covariance}}, symmetric, each in the product of the two values' units."""


@dataclass(frozen=True, kw_only=True)
class Influence:
    """Shift of a value when one file, or all files of a condition, are left out.

    Shifts are sorted, largest first; `most_influential` is the first file, or None.
    """

    most_influential: str | None
    files: Mapping[str, float]
    conditions: Mapping[str, float]


def make_estimates(
    population: Population,
    contrasts: Contrasts,
    curves: Sequence[Curve],
    groups: Sequence[Sequence[int]],
    method: str,
    logarithmic: Collection[str] = (),
    *,
    mountings: Sequence[Sequence[int]],
    common_errors: Mapping[str, float] | None = None,
) -> dict[str, Any]:
    """Return the fields of a Calibration from a population of curves, keyed by contrast.

    `scatter` is the standard error from the scatter between curves alone, with its degrees of
    freedom. `groups` lists the indices of the curves of each condition, `mountings` those of each
    mounting; intervals are based on mountings. For `logarithmic` values the logarithm is estimated.
    `common_errors` {name: relative standard uncertainty} affects all curves alike, so their scatter
    does not contain it.
    """
    common_errors = common_errors or {}
    values: dict[str, float] = {}
    intervals: dict[str, Interval | None] = {}
    scatter: dict[str, tuple[float, float] | None] = {}
    units = population.join_groups(mountings)
    together = units.count < population.count
    resamples = bootstrap_errors(units, [range(units.count)] if together else groups, contrasts)
    bootstrap: dict[str, Interval | None] = {}
    for name, contrast in contrasts.items():
        center, error = float(contrast @ population.estimate), units.standard_error(contrast)
        if error is not None and error[1] < FEWEST_DEGREES:
            error = None
        value = values[name] = float(np.exp(center)) if name in logarithmic else center
        size, common = value if name in logarithmic else 1.0, common_errors.get(name, 0.0)
        scatter[name] = error and (size * error[0], error[1])
        repeat = resamples[name]
        repeat = repeat and (size * repeat[0], repeat[1])
        intervals[name] = make_interval(name, value, scatter[name], common, method)
        bootstrap[name] = make_interval(name, value, repeat, common, BOOTSTRAP)
    names = [c.name for c in curves]
    group_of_condition = {describe_condition(curves[group[0]]): group for group in groups}
    logs = {name: values[name] for name in logarithmic}
    sizes = {name: 1.0 if name in logarithmic else value for name, value in values.items()}
    log_contrasts = {
        n: logs.get(n, 1.0) * contrast for n, contrast in contrasts.items() if intervals[n]
    }
    covariance = estimate_covariance(units, log_contrasts)
    for name in covariance:
        covariance[name][name] += (values[name] * common_errors.get(name, 0.0)) ** 2
    return {
        "values": values,
        "scatter": scatter,
        "covariance": covariance,
        "standard_errors": {n: i and i.standard_error for n, i in intervals.items()},
        "intervals": intervals,
        "bootstrap": bootstrap,
        "leave_one_out": compute_shifts(population, contrasts, names, group_of_condition, logs),
        "further": predict_further_pulls(
            population, contrasts, group_of_condition, sizes, common_errors, units
        ),
    }


def estimate_covariance(
    population: Population, contrasts: Contrasts
) -> dict[str, dict[str, float]]:
    """Return the sandwich covariance of linear combinations of the estimate; empty if unknown."""
    matrix = population.covariance()
    matrix = (matrix + matrix.T) / 2
    if not np.isfinite(matrix).all():
        return {}
    return {
        first: {second: float(np.sum(matrix * np.outer(a, b))) for second, b in contrasts.items()}
        for first, a in contrasts.items()
    }


def make_interval(
    name: str,
    value: float,
    error: tuple[float, float] | None,
    common: float,
    method: str,
) -> Interval | None:
    """Return the interval of a value from its standard error and degrees of freedom.

    `common` is the relative standard uncertainty that the scatter does not include. It is treated
    as exactly known.
    """
    if error is None:
        return None
    parts = [error, (value * common, math.inf)] if common else [error]
    return Interval.about(value, parts, method, positive=name in SHAPE and value > 0)


def compute_shifts(
    population: Population,
    contrasts: Contrasts,
    names: Sequence[str],
    groups: Mapping[str, Sequence[int]],
    logarithmic: Mapping[str, float] | None = None,
) -> dict[str, Influence]:
    """Return the shift of every value without each file, and without the files of each condition.

    `groups` lists the indices of the files of each condition; `logarithmic` {name: value} contains
    the values whose logarithm is estimated. The shifts are first-order. A file that alone
    determines the value has no shift.
    """
    single_places = {name: (place,) for place, name in enumerate(number_duplicates(names))}
    sets = single_places, groups if len(groups) > 1 else {}
    shifts = [
        {
            words: shift
            for words, out in group.items()
            if len(out) < population.count and (shift := population.shift(out)) is not None
        }
        for group in sets
    ]
    influences = {}
    for name, contrast in contrasts.items():
        value = (logarithmic or {}).get(name)
        files, conditions = (_rank_shifts(group, contrast, value) for group in shifts)
        most_influential = next(iter(files), None)
        influences[name] = Influence(
            most_influential=most_influential, files=files, conditions=conditions
        )
    return influences


def _rank_shifts(
    shifts: Mapping[str, np.ndarray], contrast: np.ndarray, value: float | None
) -> dict[str, float]:
    shift_of = {words: float(contrast @ shift) for words, shift in shifts.items()}
    if value is not None:
        shift_of = {words: value * float(np.expm1(item)) for words, item in shift_of.items()}
    return dict(sorted(shift_of.items(), key=lambda item: -abs(item[1])))


def number_duplicates(names: Sequence[str]) -> list[str]:
    """Return the names with duplicates numbered (files in several folders, or specimens)."""
    count, out = Counter(names), []
    occurrences: Counter[str] = Counter()
    for name in names:
        occurrences[name] += 1
        out.append(f"{name} ({occurrences[name]})" if count[name] > 1 else name)
    return out


def bootstrap_errors(
    population: Population, groups: Sequence[Sequence[int]], contrasts: Contrasts
) -> dict[str, tuple[float, float] | None]:
    """Return the bootstrap standard deviation over repeats, and its degrees of freedom.

    None if too few repeats can be resampled, or one of them alone determines the value.
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
