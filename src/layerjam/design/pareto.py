"""Which designs no other design beats in every objective."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def front(costs: Array) -> npt.NDArray[np.int64]:
    """Places, rising, of the rows of (n, objectives) that no other row dominates; less is better.

    Of equal rows the first stays. Rows with NaN never do.
    """
    good = np.flatnonzero(np.isfinite(costs).all(axis=1))
    if costs.shape[1] == 1:
        return good[[int(np.argmin(costs[good, 0]))]] if len(good) else good
    # by the sum first: what dominates has the smaller sum and is met early
    keys = costs[good]
    order = good[np.lexsort((good, keys.sum(axis=1)))]
    kept = _kernel()(np.ascontiguousarray(costs[order]))
    return np.sort(order[kept])


@functools.cache
def _kernel() -> Any:
    import numba

    @numba.njit(nogil=True, cache=False)  # type: ignore[untyped-decorator]
    def kept_of(costs):  # type: ignore[no-untyped-def]
        rows, objectives = costs.shape
        kept = np.empty(rows, np.int64)
        held = 0
        for i in range(rows):
            beaten = False
            for j in range(held):
                other = kept[j]
                worse = True
                for k in range(objectives):
                    if costs[other, k] > costs[i, k]:
                        worse = False
                        break
                if worse:
                    beaten = True
                    # what beats one often beats the next
                    kept[j], kept[j // 2] = kept[j // 2], kept[j]
                    break
            if not beaten:
                kept[held] = i
                held += 1
        return kept[:held]

    return kept_of
