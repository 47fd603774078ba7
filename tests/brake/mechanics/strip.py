"""Half of one sleeve face as springs and Coulomb friction: a general solver, no Masing, no root.

Cells of length h hang between the pulled end and the fixed middle; each cell's centre rubs with at
most q h. Every increment is the convex problem min 1/2 f'Gf + f'(u_el - u_old), |f| <= q h, solved
by bounded least squares; nothing is assumed about which cells slide.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear


class Strip:
    """Both faces of a sleeve, from one half face; lengths in m, forces in N."""

    def __init__(self, stiffness: float, friction: float, reach: float, cells: int) -> None:
        self.h = reach / cells
        self.stiffness, self.reach = stiffness, reach
        self.s = (np.arange(cells) + 0.5) * self.h
        far = np.maximum.outer(self.s, self.s)
        near = np.minimum.outer(self.s, self.s)
        green = near * (reach - far) / (stiffness * reach)  # both ends held
        self.root = np.linalg.cholesky(green)
        self.green = green
        self.limit = friction * self.h
        self.u = np.zeros(cells)
        self.f = np.zeros(cells)
        self.heat = 0.0

    def pull(self, slip: float) -> float:
        """Move both ends by slip/2 each; the force of both faces."""
        elastic = slip / 2 * (1 - self.s / self.reach)
        gap = np.linalg.solve(self.root, elastic - self.u)
        bound = self.limit
        solved = lsq_linear(self.root.T, -gap, bounds=(-bound, bound), method="bvls", tol=1e-14)
        self.f = solved.x
        moved = elastic + self.green @ self.f
        self.heat += 4 * float(-self.f @ (moved - self.u))
        self.u = moved
        return self.force(slip)

    def tensions(self, slip: float) -> tuple[np.ndarray, np.ndarray]:
        """Tension between the pulled end, the cells and the middle, and those pieces' lengths."""
        ends = np.concatenate([[slip / 2], self.u, [0.0]])
        lengths = np.full(len(ends) - 1, self.h)
        lengths[[0, -1]] = self.h / 2
        return -self.stiffness * np.diff(ends) / lengths, lengths

    def force(self, slip: float) -> float:
        return 2 * float(self.tensions(slip)[0][0])

    def stored(self, slip: float) -> float:
        tension, lengths = self.tensions(slip)
        return 4 * float((tension**2 * lengths).sum() / (2 * self.stiffness))
