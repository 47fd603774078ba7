"""Pareto front of many designs, by sorting, division into halves, and staircases.

Rows are taken in lexicographic order, in which a row can only be dominated by an earlier one (Kung,
Luccio and Preparata, Journal of the ACM 22, 1975, 469-476). Before that, a few good rows remove
most of the others. A front of n rows takes n log n operations for two objectives, and one more
factor log n for each further one.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
LEAF = 64
"""Number of rows that are compared in pairs, without further division."""
WORTHWHILE = 0.05
"""Smallest fraction of rows that a good row must remove for another one to be tried."""


def find_front(costs: Array) -> Numbers:
    """Return indices, ascending, of the rows of (n, objectives) that no other row dominates.

    Lower costs are better. Only the first of identical rows is kept. Rows with NaN are never kept.
    """
    rows = np.flatnonzero(np.isfinite(costs).all(axis=1))
    columns = np.ascontiguousarray(costs[rows].T)
    rows, columns = _remove_clearly_dominated(rows, columns)
    order = np.lexsort(columns[::-1])
    return np.sort(rows[order[_front_in_order(columns[1:, order])]])


def _remove_clearly_dominated(rows: Numbers, columns: Array) -> tuple[Numbers, Array]:
    """Return the rows, and their columns, that a few rows with low sums do not dominate."""
    good_rows, good_columns = [rows[:0]], [columns[:, :0]]
    while len(rows) > LEAF:
        sums = columns.sum(axis=0)
        lowest_rows = np.flatnonzero(
            sums == sums.min()
        )  # rounding may make a dominated row one of them
        best = lowest_rows[np.lexsort(columns[::-1, lowest_rows])[0]]
        good_rows.append(rows[[best]])
        good_columns.append(columns[:, [best]])
        is_kept: Mask = np.any(columns < columns[:, best, None], axis=0)
        rows, columns = rows[is_kept], columns[:, is_kept]
        if len(rows) > (1 - WORTHWHILE) * is_kept.size:
            break
    front = np.concatenate([*good_rows, rows])
    place = np.argsort(front)
    return front[place], np.concatenate([*good_columns, columns], axis=1)[:, place]


def _front_in_order(columns: Array) -> Numbers:
    """Return the places of the rows that no earlier row equals or undercuts in every column."""
    depth, count = columns.shape
    if depth == 0 or count == 0:
        return np.arange(min(count, 1))
    if depth == 1:
        lowest = np.minimum.accumulate(columns[0])
        return np.flatnonzero(np.append(True, columns[0, 1:] < lowest[:-1]))
    if count <= LEAF:
        beaten = (columns[:, :, None] <= columns[:, None, :]).all(axis=0)
        return np.flatnonzero(~np.triu(beaten, 1).any(axis=0))
    half_count = count // 2
    first = _front_in_order(columns[:, :half_count])
    second = half_count + _front_in_order(columns[:, half_count:])
    is_kept = ~_are_beaten(columns[:, second], columns[:, first])
    return np.concatenate([first, second[is_kept]])


def _are_beaten(columns: Array, others: Array) -> Mask:
    """Return which rows some other equals or undercuts in every column."""
    depth, count = columns.shape
    if count == 0 or others.shape[1] == 0:
        return np.zeros(count, bool)
    if depth == 1:
        return np.asarray(columns[0] >= others[0].min())
    if depth == 2:
        return _are_above_staircase(columns, others)
    if count * others.shape[1] <= LEAF * LEAF:
        pairs: Any = others[:, :, None] <= columns[:, None, :]
        return np.asarray(pairs.all(axis=0).any(axis=0))
    middle = np.partition(others[0], others.shape[1] // 2)[others.shape[1] // 2]
    is_below = columns[0] < middle
    beaten = np.zeros(count, bool)
    beaten[is_below] = _are_beaten(columns[:, is_below], others[:, others[0] < middle])
    beaten[~is_below] = _are_beaten(columns[1:, ~is_below], others[1:, others[0] <= middle])
    is_open = ~(is_below | beaten)
    beaten[is_open] = _are_beaten(columns[:, is_open], others[:, others[0] > middle])
    return beaten


def _are_above_staircase(columns: Array, others: Array) -> Mask:
    """Return which rows some other equals or undercuts in both columns."""
    order = np.argsort(others[0], kind="stable")
    lowest = np.append(np.inf, np.minimum.accumulate(others[1, order]))
    return np.asarray(lowest[np.searchsorted(others[0, order], columns[0], "right")] <= columns[1])
