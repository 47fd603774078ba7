"""Sheets with friction between them, bent: finite elements that know none of the laws' formulas.

Every sheet has its own axial displacement u_i(x), all share the angle theta(x) (they stay pressed
together); interface j slips by u_{j+1} - u_j + t theta against a friction q. A load that only grows
minimises the potential energy, found here by Newton's method with a line search.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Beam:
    """Sheets, their stiffnesses E A [N] and E I [N m^2], friction q [N/m], lengths [m].

    A brake has three lengths and its sheets by turns on the left and on the right cap; a stack has
    one, all sheets held at its left end.
    """

    count: int
    thickness: float
    axial: float
    bending: float
    flow: float
    lengths: tuple[float, ...]
    elements: int = 24
    slack: float = 1e-9
    """Elastic slip of an interface [m] before it rubs."""

    @property
    def is_brake(self) -> bool:
        return len(self.lengths) == 3

    def heights(self) -> Array:
        return (np.arange(self.count) - (self.count - 1) / 2) * self.thickness

    def mesh(self) -> tuple[Array, Array]:
        """Nodes, and which of the lengths an element belongs to."""
        cells = (1, self.elements, 1) if self.is_brake else (self.elements,)
        ends = np.concatenate([[0.0], np.cumsum(self.lengths)])
        x = np.concatenate(
            [
                [0.0],
                *(
                    a + (b - a) * np.arange(1, m + 1) / m
                    for a, b, m in zip(ends, ends[1:], cells, strict=False)
                ),
            ]
        )
        return x, np.repeat(np.arange(len(cells)), cells)

    def has(self, sheet: int, part: int) -> bool:
        """Whether a sheet runs through one of the lengths."""
        return not self.is_brake or part != (2 if sheet % 2 == 0 else 0)

    def numbered(self, part: Array) -> tuple[Array, int]:
        """Unknown of each sheet at each node, -1 where it is not; and how many unknowns there are.

        First the angles, then how far the right cap moves.
        """
        nodes = len(part) + 1
        where, size = np.full((self.count, nodes), -1), nodes + 1
        for i in range(self.count):
            for a in range(nodes):
                if any(self.has(i, part[e]) for e in (a - 1, a) if 0 <= e < nodes - 1):
                    where[i, a], size = size, size + 1
        return where, size

    def assembled(self) -> tuple[Array, Array, Array, Array]:
        """Stiffness, unit load, slips as rows, and what each of them rubs with."""
        x, part = self.mesh()
        where, size = self.numbered(part)
        stiff, slips, weights = np.zeros((size, size)), [], []
        for e, h in enumerate(np.diff(x)):
            here = [i for i in range(self.count) if self.has(i, part[e])]
            pairs = [((e, e + 1), len(here) * self.bending / h)]
            pairs += [((where[i, e], where[i, e + 1]), self.axial / h) for i in here]
            for at, k in pairs:
                stiff[np.ix_(at, at)] += k * np.array([[1, -1], [-1, 1]])
            for j in range(self.count - 1) if len(here) == self.count else ():
                row = np.zeros(size)
                for a in (e, e + 1):
                    row[where[j + 1, a]] += 0.5
                    row[where[j, a]] -= 0.5
                    row[a] += 0.5 * self.thickness
                slips.append(row)
                weights.append(self.flow * h)
        ties = self.ties(where, size)
        load = np.zeros(size)
        if self.is_brake:
            load[len(x) - 1] = 1.0
        else:
            load[: len(x) - 1] += np.diff(x) / 2
            load[1 : len(x)] += np.diff(x) / 2
        return ties.T @ stiff @ ties, ties.T @ load, np.array(slips) @ ties, np.array(weights)

    def ties(self, where: Array, size: int) -> Array:
        """What the caps hold: left ends at rest, right sheets at the height of a turned cap."""
        last = where.shape[1] - 1
        ties, held = np.eye(size), {0} if self.is_brake else {0, last + 1}
        for i, y in enumerate(self.heights()):
            if not self.is_brake or i % 2 == 0:
                held.add(where[i, 0])
                continue
            end = where[i, last]
            ties[end] = 0.0
            ties[end, last + 1], ties[end, last] = 1.0, -y
            held.add(end)
        return ties[:, [d for d in range(size) if d not in held]]

    def bent(self, loads: Array) -> Array:
        """A stack: deflections [m] of its end under forces; a brake: angles [rad] under moments."""
        stiff, load, rows, weights = self.assembled()
        z, out = np.zeros(len(load)), []
        for amount in loads:
            for slack in self.slack * np.array([1e3, 1e2, 10.0, 1.0]):
                z = _rest(stiff, amount * load, rows, weights, z, slack)
            out.append(float(load @ z))
        return np.array(out)


def _rest(stiff: Array, load: Array, rows: Array, weight: Array, z: Array, slack: float) -> Array:
    """Least potential energy: Newton steps, each followed to where the energy stops falling."""

    def push(at: Array) -> Array:
        return stiff @ at - load + rows.T @ (weight * np.clip(rows @ at / slack, -1, 1))

    for _ in range(100):
        now = push(z)
        if np.abs(now).max() < 1e-7 * np.abs(load).max():
            return z
        stuck = np.abs(rows @ z) < slack
        share = np.where(stuck, 1.0, 1e-9)  # what slips all over stays solvable
        tangent = stiff + (rows.T * (share * weight / slack)) @ rows
        step = -np.linalg.solve(tangent, now)
        low, high = 0.0, 1.0
        line = (stiff @ z - load) @ step, step @ stiff @ step, rows @ z, rows @ step

        def slope(way: float, line: tuple[Any, ...] = line) -> float:
            """How fast the energy grows along the step."""
            start, rise, slips, rates = line
            rubs = weight * np.clip((slips + way * rates) / slack, -1, 1)
            return float(start + way * rise + rubs @ rates)

        if slope(1.0) > 0:
            for _ in range(40):
                middle = (low + high) / 2
                low, high = (middle, high) if slope(middle) < 0 else (low, middle)
        z = z + high * step
    raise AssertionError(f"the sheets did not come to rest: {np.abs(now).max()}")
