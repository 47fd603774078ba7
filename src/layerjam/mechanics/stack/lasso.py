"""One increment of the stack: a weighted one-dimensional fused lasso, solved exactly.

The kernels are plain loops for numba, because array code with state and branches is slow.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
F = TypeVar("F", bound=Callable[..., Any])


_INNER: dict[str, Any] = dict.fromkeys(("no_cpython_wrapper", "no_cfunc_wrapper"), True)
_INNER |= {"error_model": "numpy", "_nrt": False}
"""These loops allocate nothing, and only other loops call them. Without these options, reference
counting of the arrays in their tuples took four fifths of the time of a pull."""


def inline_kernel(function: F) -> F:
    """Compile a small kernel inline, because tuples of arrays are slow to pass."""
    loop: Any = numba.njit(forceinline=True, **_INNER)(function)
    return loop


def kernel(function: F) -> F:
    """Compile a loop for other loops to call, not for Python.

    It has no cache of its own (see `stack.kernel_stamp`).
    """
    loop: Any = numba.njit(**_INNER)(function)
    return loop


@kernel
def fused_lasso(d: Array, b: Array, c: Array, z: Array, work: Array) -> None:  # pragma: no cover
    """Find z minimising 1/2 sum d (z - b)^2 + sum c |z_{i+1} - z_i|, exactly; `work` is (4, 2 n).

    Dynamic programming over the derivative of the cost (Johnson 2013). The cost of z_i over all
    terms to its left has a piecewise linear derivative. An interface clips this derivative to its
    bound, the box of the dual variable f_i, which adds two knots. Each knot is visited once, so the
    time is linear.
    """
    n = len(d)
    x, slope, level, bounds = work[0], work[1], work[2], work[3]
    left, right = n - 1, n
    low, high = bounds[:n], bounds[n:]
    low[0], high[0] = b[0] - c[0] / d[0], b[0] + c[0] / d[0]
    x[left], x[right] = low[0], high[0]
    slope[left], level[left] = d[0], -d[0] * b[0] + c[0]
    slope[right], level[right] = -d[0], d[0] * b[0] + c[0]
    for k in range(1, n):
        first_slope, first_level = d[k], -d[k] * b[k] - c[k - 1]
        last_slope, last_level = -d[k], d[k] * b[k] - c[k - 1]
        bound = c[k] if k < n - 1 else 0.0
        i = left
        while i <= right and first_slope * x[i] + first_level <= -bound:
            first_slope += slope[i]
            first_level += level[i]
            i += 1
        if k == n - 1:
            z[k] = -first_level / first_slope
            break
        j = right
        while j >= i and -last_slope * x[j] - last_level >= bound:
            last_slope += slope[j]
            last_level += level[j]
            j -= 1
        low[k] = (-bound - first_level) / first_slope
        high[k] = -(bound + last_level) / last_slope
        left, right = i - 1, j + 1
        x[left], slope[left], level[left] = low[k], first_slope, first_level + bound
        x[right], slope[right], level[right] = high[k], last_slope, last_level + bound
    for k in range(n - 2, -1, -1):
        z[k] = min(max(z[k + 1], low[k]), high[k])
