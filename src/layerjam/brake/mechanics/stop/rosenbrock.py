"""A stiffly accurate Rosenbrock method for three unknowns and an integral, for many cases.

It is Rodas by Hairer and Wanner (Solving Ordinary Differential Equations II, IV.7): order 4,
L-stable, with an embedded order 3. It needs no iteration, so that every step costs the same.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics.arrays import put, repeat, xp

GAMMA = 0.25
_A = np.zeros((6, 6))
_A[1, :1] = 1.544
_A[2, :2] = 0.9466785280815826, 0.2557011698983284
_A[3, :3] = 3.314825187068521, 2.896124015972201, 0.9986419139977817
_A[4, :4] = 1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950
_A[5, :5] = *_A[4, :4], 1.0
_C = np.zeros((6, 6))
_C[1, :1] = -5.6688
_C[2, :2] = -2.430093356833875, -0.2063599157091915
_C[3, :3] = -0.1073529058151375, -9.594562251023355, -20.47028614809616
_C[4, :4] = 7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160
_C[5, :3] = 8.083246795921522, -7.981132988064893, -31.52159432874371
_C[5, 3:5] = 16.31930543123136, -6.058818238834054

Rates = Callable[[Any], Any]
"""Function from four numbers, shape (4, ...), to their rates.

Three are coupled; the fourth is an integral over them, on which none depends.
"""


class Step(NamedTuple):
    """Result of a step."""

    after: Any
    """State after the step, shape (4, ...)."""
    error: Any
    """Difference between the two orders."""


def _solve_3x3(rows: list[list[Any]], right: Any) -> list[Any]:
    """Return x of a 3 x 3 system, by Cramer's rule on rows scaled to size 1."""
    sizes = [xp.maximum(xp.maximum(abs(a), abs(b)), abs(c)) for a, b, c in rows]
    (a, b, c), (d, e, f), (g, h, i) = (
        [value / size for value in row] for row, size in zip(rows, sizes, strict=True)
    )
    p, q, r = (value / size for value, size in zip(right, sizes, strict=True))
    ei, di, dh = e * i - f * h, d * i - f * g, d * h - e * g
    determinant = a * ei - b * di + c * dh
    x = p * ei - b * (q * i - f * r) + c * (q * h - e * r)
    y = a * (q * i - f * r) - p * di + c * (d * r - q * g)
    z = a * (e * r - q * h) - b * (d * r - q * g) + p * dh
    return [x / determinant, y / determinant, z / determinant]


def rosenbrock(rates: Rates, state: Any, h: Any) -> Step:
    """Return one step of `h` [s] from four numbers, shape (4, ...); `rates` is autonomous."""
    from jax import jvp  # only compiled solvers take such steps
    from jax import numpy as jnp

    units = (jnp.zeros_like(state).at[j].set(1.0) for j in range(3))
    columns = [jvp(rates, (state,), (unit,))[1] for unit in units]
    diagonal = 1 / (GAMMA * h)
    rows = [[-columns[j][i] + (diagonal if i == j else 0.0) for j in range(3)] for i in range(3)]

    def stage(i: Any, carry: tuple[Any, Any]) -> tuple[Any, Any]:
        _, stages = carry
        point = state + jnp.tensordot(jnp.asarray(_A)[i], stages, 1)
        right = rates(point) + jnp.tensordot(jnp.asarray(_C)[i], stages, 1) / h
        solution = _solve_3x3(rows, right[:3])
        last = (right[3] + sum(columns[j][3] * solution[j] for j in range(3))) / diagonal
        new = jnp.stack([*solution, last])
        return point, put(stages, i, new)

    # solve one after another in a loop, because unrolled code takes ten times longer to compile
    no_stages = jnp.zeros((6, *state.shape))
    point, stages = repeat(6, stage, (state, no_stages))
    return Step(point + stages[5], stages[5])
