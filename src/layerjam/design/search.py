"""Every design of a specification, block by block: what stays is the front and a few to tell of.

A block of designs is cut into chunks that stay in the cache, one core each; the outcome does not
depend on how many cores there are or in which order they finish.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.design.grid import PIECE, Array, Kernel, Numbers
from layerjam.design.merit import MERITS, STOP_MERITS
from layerjam.design.pareto import front
from layerjam.design.requirements import DesignSpecification
from layerjam.mechanics.threads import Workers

CHUNK = PIECE
"""Designs computed at a time by one core."""
BLOCK = 1 << 20
"""Designs in one block, the least that is kept, repeated or sent to another machine."""
FAMILIES = 8
"""Best families (film, thickness, whole numbers) kept: a finer search may change their order."""


@dataclass
class SweepResult:
    """What a run of designs comes to; any two runs add up to that of both.

    `numbers` are the designs kept, `costs` their objectives as ln(merit) with the sign that less is
    better. `best` are (score, number, family) of the best designs of the best families. `alone[c]`
    is (score, number) of the best design that only constraint c forbids, `reach[c]` (value, number)
    of the design that comes nearest to c among those that meet all the others.
    """

    examined: int = 0
    built: int = 0
    feasible: int = 0
    numbers: Numbers = field(default_factory=lambda: np.empty(0, np.int64))
    costs: Array = field(default_factory=lambda: np.empty((0, 0)))
    best: list[tuple[float, int, int]] = field(default_factory=list)
    alone: dict[int, tuple[float, int]] = field(default_factory=dict)
    reach: dict[int, tuple[float, int]] = field(default_factory=dict)
    failed: dict[int, int] = field(default_factory=dict)
    low: dict[str, float] = field(default_factory=dict)
    high: dict[str, float] = field(default_factory=dict)

    def kept(self) -> Numbers:
        """Every design that is spoken of, by number, rising."""
        numbers = [n for _, n, _ in self.best]
        numbers += [n for _, n in (*self.alone.values(), *self.reach.values())]
        return np.unique(np.concatenate([self.numbers, np.array(numbers, np.int64)]))


class Search:
    """Sweeps a specification's designs."""

    def __init__(self, spec: DesignSpecification, block: int = BLOCK) -> None:
        self.size = block
        self.spec, self.kernel = spec, Kernel(spec.grid, spec.evaluation)
        names = spec.evaluation.all_names
        self.row = {n: i for i, n in enumerate(names)}
        self.signs = np.array([o.sign for o in spec.objectives])
        self.weights = np.array([o.weight for o in spec.objectives])
        self.late = [i for i, c in enumerate(spec.constraints) if c.name in STOP_MERITS]

    def blocks(self) -> int:
        """How many blocks all designs make."""
        return -(-self.spec.grid.size // self.size)

    def block(self, index: int, pool: Workers | None = None) -> SweepResult:
        """What block number `index` comes to."""
        first = index * self.size
        end = min(first + self.size, self.spec.grid.size)
        starts = range(first, end, CHUNK)
        work: Iterable[SweepResult]
        if pool is None:
            work = map(lambda s: self.chunk(s, min(CHUNK, end - s)), starts)
        else:
            work = pool.map(lambda s: self.chunk(s, min(CHUNK, end - s)), starts)
        return self.sum(work)

    def all(self, progress: Callable[[str, float], None] | None = None) -> SweepResult:
        """What all designs come to, in memory."""
        total = self.blocks()
        whole = SweepResult()
        with Workers() as pool:
            for index in range(total):
                whole = self.sum([whole, self.block(index, pool)])
                if progress is not None:
                    progress("designs", (index + 1) / total)
        return whole

    def quantity(self, name: str, values: Array, numbers: Numbers) -> Array:
        """A merit from the kernel's rows, or a variable of the designs."""
        if name in self.row:
            return values[self.row[name]]
        digits = self.spec.grid.digits(numbers)
        if name == "thickness":
            return np.asarray(self.spec.grid.thickness[digits[0]])
        return np.asarray(
            self.spec.grid.axes[name][digits[1 + list(self.spec.grid.axes).index(name)]]
        )

    def chunk(self, first: int, count: int) -> SweepResult:
        """What `count` designs from `first` on come to."""
        numbers = np.arange(first, first + count, dtype=np.int64)
        values = self.kernel.merits(numbers)
        constraints = self.spec.constraints
        fine = np.isfinite(values[self.row["mass"]])
        held = np.zeros((len(constraints), count), bool)
        for i, c in enumerate(constraints):
            if i not in self.late:
                held[i] = c.holds(self.quantity(c.name, values, numbers)) & fine
        early = (~held).sum(axis=0) - len(self.late)
        if self.spec.evaluation.stop is not None:
            extra = np.full((2, count), math.nan)
            near = np.flatnonzero(fine & (early <= 1) & self.may_stop(values))
            extra[:, near] = self.kernel.stops(numbers[near])
            values = np.concatenate([values, extra])
            for i in self.late:
                held[i] = constraints[i].holds(values[self.row[constraints[i].name]])
        return self.reduced(numbers, values, held, fine)

    def may_stop(self, values: Array) -> npt.NDArray[np.bool_]:
        """Designs whose whole travel and stretch take up the energy that the mass brings."""
        row, wanted = self.row, self.spec.evaluation.stop
        stretch = values[row["max_force"]] ** 2 / (2 * values[row["stiffness"]])
        taken = values[row["energy_capacity"]] + stretch
        brings = 0.0 if wanted is None else wanted.mass * wanted.speed**2 / 2
        return np.asarray(taken > brings * (1 - 1e-9))

    def reduced(
        self,
        numbers: Numbers,
        values: Array,
        held: npt.NDArray[np.bool_],
        fine: npt.NDArray[np.bool_],
    ) -> SweepResult:
        """The SweepResult of a chunk from its merits and which constraints hold."""
        made = SweepResult(examined=len(numbers), built=int(fine.sum()))
        for name, i in self.row.items():
            row = values[i][np.isfinite(values[i])]
            if len(row):
                made.low[name], made.high[name] = float(row.min()), float(row.max())
        failures = (~held).sum(axis=0)
        scores_of = self._costs(values, numbers)
        fits = np.flatnonzero(fine & (failures == 0))
        made.feasible = len(fits)
        for i, c in enumerate(self.spec.constraints):
            made.failed[i] = int((fine & ~held[i]).sum())
            others = fine & (failures - ~held[i] == 0)
            value = self.quantity(c.name, values, numbers)
            there = np.flatnonzero(others & np.isfinite(value))
            if len(there):
                at = there[np.argmin(value[there]) if c.most else np.argmax(value[there])]
                made.reach[i] = (float(value[at]), int(numbers[at]))
            single = np.flatnonzero(others & ~held[i])
            if len(single):
                cost = scores_of(single) @ self.weights
                at = int(np.argmin(np.where(np.isnan(cost), np.inf, cost)))
                if np.isfinite(cost[at]):
                    made.alone[i] = (float(cost[at]), int(numbers[single[at]]))
        if len(fits):
            costs = scores_of(fits)
            self._keep(made, numbers[fits], costs)
        return made

    def _costs(self, values: Array, numbers: Numbers) -> Callable[[Any], Array]:
        rows = [self.quantity(o.name, values, numbers) for o in self.spec.objectives]

        def of(places: Any) -> Array:
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.stack([np.log(r[places]) for r in rows], axis=1) * self.signs

        return of

    def _keep(self, made: SweepResult, numbers: Numbers, costs: Array) -> None:
        score = costs @ self.weights
        score = np.where(np.isnan(score), np.inf, score)
        family = self.family(numbers)
        for _ in range(FAMILIES):
            at = int(np.argmin(score))
            if not np.isfinite(score[at]):
                break
            made.best.append((float(score[at]), int(numbers[at]), int(family[at])))
            score = np.where(family == family[at], np.inf, score)
        places = front(costs)
        made.numbers, made.costs = numbers[places], costs[places]

    def family(self, numbers: Numbers) -> Numbers:
        """One number for all designs of the same film, thickness and whole numbers."""
        grid = self.spec.grid
        digits = grid.digits(numbers)
        out = digits[0]
        for name, place in zip(grid.axes, digits[1:], strict=True):
            if name in ("count", "series", "parallel"):
                out = out * len(grid.axes[name]) + place
        return np.asarray(out)

    def sum(self, parts: Iterable[SweepResult]) -> SweepResult:
        """The SweepResult of several runs together, in their order."""
        whole = SweepResult()
        numbers, costs = [], []
        for part in parts:
            whole.examined += part.examined
            whole.built += part.built
            whole.feasible += part.feasible
            if len(part.numbers):
                numbers.append(part.numbers)
                costs.append(part.costs)
            whole.best += part.best
            for i, n in part.failed.items():
                whole.failed[i] = whole.failed.get(i, 0) + n
            for name in part.low:
                whole.low[name] = min(part.low[name], whole.low.get(name, math.inf))
                whole.high[name] = max(part.high[name], whole.high.get(name, -math.inf))
            for i, pair in part.alone.items():
                whole.alone[i] = min(pair, whole.alone.get(i, (math.inf, 0)))
            for i, pair in part.reach.items():
                most = self.spec.constraints[i].most
                old = whole.reach.get(i)
                if old is None or (pair[0] < old[0] if most else pair[0] > old[0]):
                    whole.reach[i] = pair
        whole.best = _families(whole.best)
        if numbers:
            rows, cost = np.concatenate(numbers), np.concatenate(costs)
            places = front(cost)
            whole.numbers, whole.costs = rows[places], cost[places]
        return whole

    def design(self, number: int) -> dict[str, Any]:
        """One design: its variables and all its merits."""
        values = self.kernel.at(np.array([number], np.int64))[:, 0]
        found = dict(zip(self.spec.evaluation.all_names, values.tolist(), strict=True))
        return {
            "number": int(number),
            **self.spec.grid.values(number),
            **{n: found.get(n, math.nan) for n in MERITS},
        }


def _families(best: list[tuple[float, int, int]]) -> list[tuple[float, int, int]]:
    """The best design of each of the best families."""
    out: dict[int, tuple[float, int, int]] = {}
    for entry in sorted(best):
        out.setdefault(entry[2], entry)
    return list(out.values())[:FAMILIES]
