"""Order of pulls, and whether their scale factors wear off or resemble those of their neighbours.

Each vacuum and speed has its own mean, so a law of vacuum or speed is not mistaken for wear. A step
between two batches is that of two mountings.
"""

import functools
import re
from collections.abc import Hashable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from layerjam.core.verdict import Level
from layerjam.laboratory.identify.curves import Curve, number_conditions
from layerjam.laboratory.identify.fit_checks import SMALL, Check, check, format_percent
from layerjam.laboratory.identify.single_pulls import SinglePull
from layerjam.laboratory.measure.trace import Array

WORN, WEAR_ALARMS = 0.1, 0.002
"""Change over all pulls above which their mean is not the brake's present state, and the fraction
of faultless campaigns in which such a change may be reported."""
ALARMS = 0.005
"""Fraction of faultless campaigns in which successive pulls may resemble each other."""
FEWEST, FEWEST_MOUNTINGS = 5, 4
"""Minimum number of pulls, and of mountings that share several pulls, whose order is tested."""
SAMPLES = 20_000
LAST_NUMBER = re.compile(r"(\d+)\D*$")


class Order(NamedTuple):
    """Indices of the pulls from the first to the last, and the source of this order.

    `known` is False if only the order within each vacuum and speed is known.
    """

    places: list[int]
    source: str
    known: bool = True


def find_order(names: Sequence[str], pulls: Sequence[Curve | SinglePull]) -> Order:
    """Return the order of pulls from the first source that distinguishes them.

    These are the start times in files or sidecars, the stated repeats, the numbers at the end of
    the file names, and the stated mountings. Numbers that start again at each vacuum, as repeats
    do, order its pulls only; the vacuums then follow each other as in the files given.
    """
    repeats = [pull.turn.repeat for pull in pulls]
    mountings = [pull.turn.mounting for pull in pulls]
    numbers: dict[str, Sequence[float | None]] = {
        "repeats": repeats,
        "numbers in file names": _read_numbers(names),
    }
    starts = [pull.turn.start for pull in pulls]
    conditions = number_conditions(pulls)
    all_keys: dict[str, Sequence[float | None]] = {"start times": starts, **numbers}
    for source, keys in all_keys.items():
        if None not in keys and len(set(keys)) == len(pulls):
            return Order(_sort(keys), source)
    if None not in mountings and len(set(mountings)) > 1:
        return Order(_sort(mountings, conditions), "mountings")
    for source, keys in numbers.items():
        if None not in keys and len({*zip(conditions, keys, strict=True)}) == len(pulls):
            return Order(_sort(conditions, keys), source, known=len(set(conditions)) == 1)
    return Order(list(range(len(pulls))), "files given", known=False)


def _sort(*keys: Sequence[float | None]) -> list[int]:
    """Return the indices that sort pulls by the first key, then by the next ones."""
    places = np.lexsort([np.array(column, float) for column in reversed(keys)])
    return [int(place) for place in places]


def _read_numbers(names: Sequence[str]) -> Sequence[float | None]:
    """Return the last number in each name; all None if they do not number a sequence."""
    stems = [name.rpartition(".")[0] or name for name in names]
    numbers = [int(match[1]) if (match := LAST_NUMBER.search(stem)) else None for stem in stems]
    values = [number for number in numbers if number is not None]
    is_sequence = len(values) == len(names) and max(values) - min(values) <= 10 * len(names)
    return numbers if is_sequence else [None] * len(names)


def check_order(rows: Sequence[SinglePull]) -> Iterator[Check]:
    """Yield the checks that the scale factors have no trend and no memory over their order."""
    usable = [row for row in rows if row.vacuum_of_peak is not None]
    if len(usable) < FEWEST:
        return
    order = find_order([row.file for row in usable], usable)
    pulls = [usable[place] for place in order.places]
    logs = np.log([p.vacuum_of_peak / p.vacuum for p in pulls if p.vacuum_of_peak is not None])
    conditions, runs = number_conditions(pulls), _number_runs(pulls)
    is_shared = len(set(runs)) < len(pulls)
    cells = list(zip(conditions, runs, strict=True)) if is_shared else conditions
    means = _group_means(cells)
    trends = [_fit_trend(logs, means, order.known or is_shared)]
    if is_shared:
        trends.append(_fit_mounting_trend(logs, _group_means(conditions), runs))
    known_trends = [trend for trend in trends if trend is not None]
    if known_trends:
        worst = max(known_trends, key=lambda trend: (trend.certain, abs(trend.change)))
        yield _check_wear(worst, order.source)
    offsets = logs - means @ logs
    if len(pulls) - round(float(np.trace(means))) >= FEWEST - 1:
        yield _check_memory(offsets, means)


def _number_runs(pulls: Sequence[SinglePull]) -> list[int]:
    """Return the number of each pull's mounting; pulls of one mounting follow each other.

    If a pull does not state a mounting, each pull counts as one.
    """
    labels: list[Hashable] = [pull.mounting for pull in pulls]
    if None in labels:
        labels = list(range(len(pulls)))
    runs = [list(group) for _, group in groupby(labels)]
    return [number for number, run in enumerate(runs) for _ in run]


def _group_means(cells: Sequence[Hashable]) -> Array:
    """Return the matrix (N, N) that replaces each value by the mean of its cell."""
    is_same_cell = np.array([[float(cell == column) for cell in cells] for column in cells])
    return np.asarray(is_same_cell / is_same_cell.sum(axis=1))


class _Trend(NamedTuple):
    """Relative change from the first to the last pull, and whether it is certain."""

    change: float
    certain: bool


def _fit_trend(logs: Array, means: Array, is_known: bool) -> _Trend | None:
    """Return the trend within cells of pulls in their order; None if they are too few.

    If the order of the cells is not known, some order must continue the trend from cell to cell:
    numbers that start again in each cell may be those of mountings, whose scatter is not a trend.
    """
    place = np.arange(len(logs), dtype=float)
    freedom = len(logs) - round(float(np.trace(means)))
    x, offsets = place - means @ place, logs - means @ logs
    if freedom < 3 or not x @ x > 0:
        return None
    trend = _judge_trend(x, offsets, freedom)
    slope = float(x @ offsets / (x @ x))
    residuals = offsets - x * slope
    certain = trend.certain and float(residuals @ residuals) < _least_step_squares(offsets, means)
    if certain and not is_known:
        certain = _find_slope_between(place, logs, means, slope) > abs(slope) / 2
    return trend._replace(certain=certain)


def _find_slope_between(place: Array, logs: Array, means: Array, slope: float) -> float:
    """Return the slope between cells in the order that continues the slope within them.

    It is positive in the direction of `slope`, and infinite if the cells follow in turn, so that
    their order says nothing.
    """
    centres, levels = means @ place, np.sign(slope) * (means @ logs)
    offsets = place - centres
    middle = np.sort(centres) - place.mean()
    if not middle @ middle > offsets @ offsets:
        return np.inf
    return float(middle @ np.sort(levels) / (middle @ middle))


def _fit_mounting_trend(logs: Array, means: Array, runs: Sequence[int]) -> _Trend | None:
    """Return the trend of the means of mountings; None if they are too few.

    `means` removes the means of vacuums and speeds.
    """
    count = runs[-1] + 1
    member = np.equal.outer(np.arange(count), runs) / np.bincount(runs)[:, None]
    place = np.array(runs, float)
    x, offsets = member @ (place - means @ place), member @ (logs - means @ logs)
    if count < FEWEST_MOUNTINGS or not x @ x > 1e-9:
        return None
    return _judge_trend(x, offsets, count - 1)


def _judge_trend(x: Array, offsets: Array, degrees_of_freedom: int) -> _Trend:
    """Return the trend of `offsets` over `x`, both (N,) with zero mean."""
    from scipy.special import stdtrit

    square = float(x @ x)
    slope = float(x @ offsets) / square
    residuals = offsets - slope * x
    error = float(np.sqrt(residuals @ residuals / (degrees_of_freedom - 1) / square))
    change = float(np.expm1(slope * (len(x) - 1)))
    half_width = float(stdtrit(degrees_of_freedom - 1, 1 - WEAR_ALARMS / 2)) * error
    return _Trend(change, abs(slope) > half_width and abs(change) > SMALL)


def _check_wear(trend: _Trend, source: str) -> Check:
    """Check that the scale factor does not change from the first to the last pull."""
    level: Level = "failed" if abs(trend.change) > WORN else "warning"
    sentence = (
        "from the first to the last pull the scale factor changes by "
        f"{format_percent(trend.change)} (order of the {source})"
    )
    advice = (
        ": the films wear or run in, so the mean of all pulls is not the present state. Calibrate "
        "on pulls after it has settled"
    )
    return check("wear", not trend.certain, sentence, advice, level)


def _least_step_squares(offsets: Array, means: Array) -> float:
    """Return the residual sum of squares about one step, as between two mountings."""
    count = len(offsets)
    steps = np.tri(count, count - 1, -1) - means @ np.tri(count, count - 1, -1)
    squares = (steps**2).sum(axis=0)
    gains = (steps.T @ offsets) ** 2 / np.where(squares > 1e-12, squares, np.inf)
    return float(offsets @ offsets - gains.max())


def _check_memory(offsets: Array, means: Array) -> Check:
    """Check that neighbouring pulls do not resemble each other."""
    value = float(_lag_one_correlations(offsets[None])[0])
    is_ok = value <= _critical_product(means.tobytes(), len(offsets), ALARMS)
    sentence = f"the scale factors of successive pulls correlate by {value:+.2f}"
    advice = ": something drifts from pull to pull, so the pulls are not independent"
    return check("neighbours", is_ok, sentence, advice)


def correlate_neighbours(values: Array, alarms: float) -> tuple[float, bool]:
    """Return the lag-one correlation of values (N,) in their order, and whether it is large.

    Independent values have a large one with probability `alarms`.
    """
    count = len(values)
    means = np.full((count, count), 1 / count)
    value = float(_lag_one_correlations((values - values.mean())[None])[0])
    return value, value > _critical_product(means.tobytes(), count, alarms)


def _lag_one_correlations(offsets: Array) -> Array:
    """Return the lag-one correlation of each row of (samples, N)."""
    squares = np.maximum((offsets**2).sum(axis=1), 1e-300)
    return np.asarray((offsets[:, 1:] * offsets[:, :-1]).sum(axis=1) / squares)


@functools.lru_cache(maxsize=64)
def _critical_product(means: bytes, count: int, alarms: float) -> float:
    """Return the correlation that independent pulls exceed with probability `alarms`."""
    matrix = np.eye(count) - np.frombuffer(means).reshape(count, count)
    random = np.random.Generator(np.random.PCG64(count))
    samples = random.standard_normal((SAMPLES, count)) @ matrix
    return float(np.quantile(_lag_one_correlations(samples), 1 - alarms))
