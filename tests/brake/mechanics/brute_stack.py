"""A stack by brute force: sheets are nodes, every interface sticks or slips, dense solves.

Independent of `mechanics.stack`: no lasso, no tridiagonal system, no secants; it changes
the state of one interface at a time, bisects for the elongation of a break, and moves in the
increments it is given. It knows no enclosure and cannot push.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

_SHARE = 1e-9
"""Share of its friction by which an interface may miss it: ties, and sliding that goes on."""


class BruteStack:
    """The stack of a `Stack` without its enclosure, followed along rising and falling paths."""

    def __init__(self, stack: Any) -> None:
        self.springs, self.right, self.friction = stack.springs, stack.right, stack.friction
        self.ratio, self.length, self.mount = stack.ratio, stack.length, stack.mount
        self.one_by_one = stack.one_by_one
        many = len(self.friction)
        self.opening = np.where(self.right[:-1], -1.0, 1.0)
        self.rest = np.zeros(many)
        """w_{i+1} - w_i at which each interface last slid [m]."""
        self.sign = np.zeros(many, int)
        self.moving = np.zeros(many, bool)
        self.elongation = 0.0

    def pull(self, path: Iterable[float]) -> np.ndarray:
        """Force [N] at every elongation [m]."""
        return np.array([self._step(float(at)) for at in path])

    def kinetic(self) -> np.ndarray:
        return self.friction * (1 - self.opening * self.rest / self.length)

    def _solve(self, elongation: float, sign: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
        """Sheets, cap and interface forces for a pattern: the equations written out one by one."""
        n = len(self.springs)
        matrix, given = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
        cap, force = n, n + 1
        for i, spring in enumerate(self.springs):
            matrix[i, i] = spring
            if self.right[i]:
                matrix[i, cap] = -spring
            if i < n - 1:
                matrix[i, force + i] = -1
            if i > 0:
                matrix[i, force + i - 1] = 1
        if np.isinf(self.mount):
            matrix[cap, cap], given[cap] = 1, elongation
        else:
            matrix[cap, cap] = self.mount + self.springs[self.right].sum()
            matrix[cap, :n] = np.where(self.right, -self.springs, 0.0)
            given[cap] = self.mount * elongation
        for k in range(n - 1):
            row = force + k
            if sign[k] == 0:
                matrix[row, k + 1], matrix[row, k], given[row] = 1, -1, self.rest[k]
                continue
            falls = sign[k] * self.friction[k] * self.opening[k] / self.length[k]
            matrix[row, row], matrix[row, k + 1], matrix[row, k] = 1, falls, -falls
            given[row] = sign[k] * self.friction[k]
        found = np.linalg.solve(matrix, given)
        return found[:n], found[cap], found[force:]

    def _balance(self, elongation: float) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
        """Coulomb's law with kinetic friction for what moves; the rest holds all it is given."""
        sign = np.where(self.moving, self.sign, 0)
        for _ in range(2000):
            sheets, cap, force = self._solve(elongation, sign)
            ahead = np.where(sign != 0, sign * (np.diff(sheets) - self.rest), np.inf)
            over = np.where((sign == 0) & self.moving, np.abs(force) / self.kinetic() - 1, -1)
            if ahead.min() < -1e-15:
                sign[ahead.argmin()] = 0
            elif over.max() > 1e-11:
                sign[over.argmax()] = np.sign(force[over.argmax()])
            else:
                return sheets, cap, force, sign
        raise AssertionError("no pattern was found")

    def _accept(self, sheets: np.ndarray, force: np.ndarray, sign: np.ndarray) -> None:
        """What slid has slid; what did not and carries less than its friction is static again."""
        self.rest = np.where(sign != 0, np.diff(sheets), self.rest)
        slides_on = self.moving & (np.abs(force) >= self.kinetic() * (1 - _SHARE))
        self.moving = (sign != 0) | slides_on
        self.sign = np.where(self.moving, np.sign(force), 0).astype(int)

    def _over(self, force: np.ndarray) -> np.ndarray:
        return np.where(self.moving, -1.0, np.abs(force) / (self.ratio * self.kinetic()) - 1)

    def _release(self, force: np.ndarray, least: float) -> None:
        for k in np.flatnonzero(self._over(force) >= least):
            self.moving[k], self.sign[k] = True, np.sign(force[k])

    def _first_break(self, elongation: float) -> float:
        low, high = self.elongation, elongation
        while (middle := (low + high) / 2) not in (low, high):
            broken = self._over(self._balance(middle)[2]).max() > 0
            low, high = (low, middle) if broken else (middle, high)
        return high

    def _step(self, elongation: float) -> float:
        while True:
            sheets, cap, force, sign = self._balance(elongation)
            if self._over(force).max() <= 1e-10:
                self._accept(sheets, force, sign)
                self.elongation = elongation
                return float((self.springs * (cap - sheets))[self.right].sum())
            at = self._first_break(elongation)
            sheets, _, force, sign = self._balance(at)
            self._accept(sheets, force, sign)
            self.elongation = at
            self._release(force, -_SHARE)
            while (over := self._over((found := self._balance(at))[2])).max() > 1e-10:
                sheets, _, force, sign = found
                if self.one_by_one:
                    worst = float(over.max())
                    self._accept(sheets, force, sign)
                    self._release(force, worst - _SHARE)
                else:
                    self._release(force, 0.0)
            self._accept(found[0], found[2], found[3])
