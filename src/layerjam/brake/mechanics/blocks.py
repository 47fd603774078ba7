"""Laws of points on large arrays: in blocks whose intermediate results stay in the cache."""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from layerjam.brake.mechanics.arrays import leaves, map_leaves

BLOCK = 2**15
"""Number of points of a block."""


def in_blocks(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of numbers whose points do not depend on each other, for large arrays.

    All points are computed at once if arrays of the arguments or of the result differ in shape.
    """

    @functools.wraps(function)
    def call(*numbers: Any) -> Any:
        if not any(type(value) is np.ndarray and value.size > BLOCK for value in numbers):
            return function(*numbers)
        shapes = {leaf.shape for leaf in leaves(numbers) if np.ndim(leaf)}
        if len(shapes) > 1:
            return function(*numbers)
        [shape] = shapes
        # a record without arrays stays the same one, which keeps what it has computed
        has_arrays = [any(map(np.ndim, leaves(value))) for value in numbers]

        def compute(start: int) -> Any:
            def cut(leaf: Any) -> Any:
                return leaf.reshape(-1)[start : start + BLOCK] if np.ndim(leaf) else leaf

            pairs = zip(numbers, has_arrays, strict=True)
            return function(*(map_leaves(cut, v) if varies else v for v, varies in pairs))

        part = compute(0)
        if any(np.shape(leaf) != (BLOCK,) for leaf in leaves(part)):
            return function(*numbers)
        total = map_leaves(lambda leaf: np.empty(shape, leaf.dtype), part)
        for start in range(0, int(np.prod(shape)), BLOCK):
            part = compute(start) if start else part
            for leaf, values in zip(leaves(total), leaves(part), strict=True):
                leaf.reshape(-1)[start : start + BLOCK] = values
        return total

    return call
