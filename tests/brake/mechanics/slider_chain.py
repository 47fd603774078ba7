"""Half of one face as rubber springs between Coulomb sliders, in displacements: no play.

Equal springs hang between the pulled end and the fixed middle. Every node rubs as a slider that is
elastic, and very stiff, until it yields at q times its share of the length. An increment is the
root of the nodes' balance, by Newton's steps on the tridiagonal system with a line search. The
rubber and its softening are written down here a second time, the energies summed by trapezia.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_banded
from scipy.special import erf

STIFF = 3e3


class Rubber:
    """Yeoh's C1 and C2 [Pa], and Ogden and Roxburgh's r, m [Pa] and beta."""

    def __init__(self, c1: float, c2: float, r: float, m: float, beta: float) -> None:
        self.c1, self.c2, self.r, self.m, self.beta = c1, c2, r, m, beta

    def first(self, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Stress and energy of the first loading."""
        lam = 1 + e
        over = lam**2 + 2 / lam - 3
        stress = 2 * (lam - lam**-2) * (self.c1 + 2 * self.c2 * over)
        return stress, self.c1 * over + self.c2 * over**2

    def stress(self, e: np.ndarray, held: np.ndarray) -> np.ndarray:
        stress, energy = self.first(e)
        below = np.maximum(held - energy, 0)
        return stress * (1 - erf(below / (self.m + self.beta * held)) / self.r)

    def slope(self, e: np.ndarray, held: np.ndarray) -> np.ndarray:
        step = 1e-7
        return (self.stress(e + step, held) - self.stress(e - step, held)) / (2 * step)


class Chain:
    """Both faces of an enclosure; lengths in m, forces in N, energies in J."""

    def __init__(self, rubber: Rubber, section: float, reach: float, nodes: int) -> None:
        self.rubber, self.section, self.h = rubber, section, reach / nodes
        self.w, self.rubs = np.zeros(nodes + 1), np.zeros(nodes)
        self.held, self.heat = np.zeros(nodes), 0.0
        self.shares = np.full(nodes, self.h)
        self.shares[0] = self.h / 2

    def _balance(self, w: np.ndarray, limit: np.ndarray, stiff: float) -> tuple[np.ndarray, ...]:
        tension = self.section * self.rubber.stress(-np.diff(w) / self.h, self.held)
        rubs = np.clip(self.rubs + stiff * (w[:-1] - self.w[:-1]), -limit, limit)
        return tension[:-1] - tension[1:] - rubs[1:], rubs, tension

    def pull(self, slip: float, friction: float) -> float:
        """Move both ends by slip/2 each at a friction [N/m]; the force of both faces."""
        limit = friction * self.shares
        stiff = STIFF * 6 * self.rubber.c1 * self.section / self.h
        found = self._found(slip / 2, limit, stiff)
        w, rubs, tension = found
        slid = (w - self.w)[:-1] - (rubs - self.rubs) / stiff
        self.heat += 4 * float((rubs * slid).sum())
        self.w, self.rubs = w, rubs
        self.held = np.maximum(self.held, self.rubber.first(-np.diff(w) / self.h)[1])
        return 2 * float(tension[0] + rubs[0])

    def _found(
        self, end: float, limit: np.ndarray, stiff: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The nodes in balance, what they rub, and the springs' tension."""
        w = self.w.copy()
        # no spring is crushed at the start: the nodes behind the end come along
        w = np.minimum(w, end) if end < w[0] else w
        w[0] = end
        for _ in range(300):
            off, rubs, tension = self._balance(w, limit, stiff)
            if np.abs(off).max() < 1e-7 * limit.max() + 1e-12:
                return w, rubs, tension
            steep = self.section * self.rubber.slope(-np.diff(w) / self.h, self.held) / self.h
            sticks = np.where(np.abs(rubs[1:]) < limit[1:], stiff, 0.0)
            bands = np.zeros((3, len(off)))
            bands[1] = steep[:-1] + steep[1:] + sticks
            bands[0, 1:], bands[2, :-1] = -steep[1:-1], -steep[1:-1]
            step = np.zeros_like(w)
            step[1:-1] = solve_banded((1, 1), bands, off)
            # the energy is convex: along the step its slope rises, and is brought to zero
            low, high, part = 0.0, 1.0, 1.0
            for _ in range(30):
                near = w + part * step
                crushed = np.diff(near).max() > 0.5 * self.h
                if not crushed and self._balance(near, limit, stiff)[0] @ step[1:-1] >= 0:
                    low = part
                else:
                    high = part
                if part == 1.0 and low == 1.0:
                    break
                part = (low + high) / 2
            w = w + part * step
        raise AssertionError("the chain found no balance")

    def given_back(self, parts: int = 100) -> float:
        """Elastic energy [J]: the area under the softened stress, down to no strain."""
        grid = np.linspace(0, 1, parts + 1)[:, None] * (-np.diff(self.w) / self.h)
        area = np.trapezoid(self.rubber.stress(grid, self.held), grid, axis=0)
        return 4 * self.section * self.h * float(area.sum())

    def softened(self, parts: int = 100) -> float:
        """Energy [J] that the softening took: the greatest energies less what they give back."""
        total = 0.0
        top = np.linspace(0, 40, 40_001)
        for held in self.held:
            strain = float(np.interp(held, self.rubber.first(top)[1], top))
            grid = np.linspace(0, strain, parts + 1)
            total += held - float(np.trapezoid(self.rubber.stress(grid, held), grid))
        return 4 * self.section * self.h * total
