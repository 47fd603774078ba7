"""Every design of a specification, block by block: what stays is the front and a few to tell of.

A block of designs is cut into chunks that stay in the cache, one core each; the outcome does not
depend on how many cores there are or in which order they finish.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.design.grid import PIECE, Array, Kernel, Numbers
from layerjam.design.merit import LATE_MERITS, MERITS, STOP_MERITS
from layerjam.design.requirements import DesignSpecification
from layerjam.errors import QuantityError
from layerjam.mechanics.threads import Workers

CHUNK = PIECE
"""Designs computed at a time by one core."""
BLOCK = 1 << 20
"""Designs in one block, the least that is kept, repeated or sent to another machine."""
FAMILIES = 8
"""Best families (film, thickness, whole numbers) kept: a finer search may change their order."""


@dataclass(frozen=True)
class SweepResult:
    """What a run of designs comes to; any two runs add up to that of both.

    `failed` counts the built designs that break each constraint, `low` and `high` span each merit
    (infinite where no design has it). Of the designs that are spoken of, `numbers` rise, and
    `asked` are the quantities of their constraints and objectives, shape (quantities, n).
    """

    examined: int
    built: int
    feasible: int
    failed: Numbers
    low: Array
    high: Array
    numbers: Numbers
    asked: Array


class Told(NamedTuple):
    """The designs of a run that are spoken of, as places among its `numbers`."""

    scores: Array
    """Of every design: sum of weight times signed ln(objective); less is better."""
    front: Numbers
    """Those that no other beats."""
    best: list[int]
    """The best of each of the best families."""
    alone: dict[int, int]
    """Constraint to the best design that it alone forbids."""
    reach: dict[int, int]
    """Constraint to the design that comes nearest to it among those that meet all the others."""


class Search:
    """Sweeps a specification's designs."""

    def __init__(self, spec: DesignSpecification, block: int = BLOCK) -> None:
        self.size = block
        self.spec, self.kernel = spec, Kernel(spec.grid, spec.evaluation)
        self.row = {n: i for i, n in enumerate(spec.merits)}
        if spec.drawn and spec.evaluation.draw is None:
            raise QuantityError.of(
                spec.drawn[0], "needs `draw` in the evaluation: what draws a brake"
            )
        self.wanted = [*(c.name for c in spec.constraints), *(o.name for o in spec.objectives)]
        self.signs = np.array([o.sign for o in spec.objectives])
        self.weights = np.array([o.weight for o in spec.objectives])

    def blocks(self) -> int:
        """How many blocks all designs make."""
        return -(-self.spec.grid.size // self.size)

    def block(self, index: int, pool: Workers | None = None) -> SweepResult:
        """What block number `index` comes to."""
        first = index * self.size
        end = min(first + self.size, self.spec.grid.size)
        starts = range(first, end, CHUNK)
        spread: Callable[..., Iterable[SweepResult]] = map if pool is None else pool.map
        return self.sum(spread(lambda s: self.chunk(s, min(CHUNK, end - s)), starts))

    def all(self, progress: Callable[[str, float], None] | None = None) -> SweepResult:
        """What all designs come to, in memory."""
        total = self.blocks()
        whole: list[SweepResult] = []
        with Workers() as pool:
            for index in range(total):
                whole = [self.sum([*whole, self.block(index, pool)])]
                if progress is not None:
                    progress("designs", (index + 1) / total)
        return whole[0]

    def quantity(self, name: str, values: Array, numbers: Numbers) -> Array:
        """A merit from the kernel's rows, or a variable of the designs."""
        if name in self.row:
            return values[self.row[name]]
        return np.asarray(self.spec.grid.columns(numbers)[name], float)

    def chunk(self, first: int, count: int) -> SweepResult:
        """What `count` designs from `first` on come to."""
        numbers = np.arange(first, first + count, dtype=np.int64)
        values = self.kernel.merits(numbers)
        built = np.isfinite(values[self.row["mass"]])
        numbers, values = numbers[built], values[:, built]
        # what is drawn is known sooner than the end of a stop, and rules many out
        drawn = self._drawn(numbers, values)
        if self.spec.evaluation.stop is not None:
            values = np.concatenate([values, self._stops(numbers, values, drawn)])
        values = np.concatenate([values, drawn])
        asked = np.stack([self.quantity(name, values, numbers) for name in self.wanted])
        held = self.held(asked)
        low, high = (np.where(np.isfinite(values), values, end) for end in (math.inf, -math.inf))
        run = SweepResult(
            examined=count,
            built=len(numbers),
            feasible=int(held.all(axis=0).sum()),
            failed=(~held).sum(axis=1),
            low=low.min(axis=1, initial=math.inf),
            high=high.max(axis=1, initial=-math.inf),
            numbers=numbers,
            asked=asked,
        )
        return self._thinned(run)

    def _stops(self, numbers: Numbers, values: Array, drawn: Array) -> Array:
        """The stop's merits of designs that may meet all but one constraint, else NaN."""
        broken = self._broken(numbers, values)
        for c in self.spec.constraints:
            if c.name in self.spec.drawn:
                broken += ~c.holds(drawn[self.spec.drawn.index(c.name)])
        near = (broken <= 1) & self.may_stop(values)
        made = np.full((len(STOP_MERITS), len(numbers)), math.nan)
        made[:, near] = self.kernel.stops(numbers[near])
        return made

    def _drawn(self, numbers: Numbers, values: Array) -> Array:
        """The drawn merits of designs that may meet all but one constraint, else NaN."""
        near = self._broken(numbers, values) <= 1
        made = np.full((len(self.spec.drawn), len(numbers)), math.nan)
        made[:, near] = self.drawn(numbers[near])
        return made

    def drawn(self, numbers: Numbers) -> Array:
        """The drawn merits that are asked for, shape (merits, n)."""
        found = self.kernel.drawn(numbers) if self.spec.drawn else {}
        shape = (len(self.spec.drawn), len(numbers))
        return np.array([found[n] for n in self.spec.drawn]).reshape(shape)

    def _broken(self, numbers: Numbers, values: Array) -> Numbers:
        """How many constraints each design breaks, those on merits that come later left out."""
        broken = np.zeros(len(numbers), int)
        for c in self.spec.constraints:
            if c.name not in LATE_MERITS:
                broken += ~c.holds(self.quantity(c.name, values, numbers))
        return broken

    def may_stop(self, values: Array) -> npt.NDArray[np.bool_]:
        """Designs whose whole travel and stretch take up the energy that the mass brings."""
        row, wanted = self.row, self.spec.evaluation.stop
        stretch = values[row["max_force"]] ** 2 / (2 * values[row["stiffness"]])
        taken = values[row["energy_capacity"]] + stretch
        brings = 0.0 if wanted is None else wanted.mass * wanted.speed**2 / 2
        return np.asarray(taken > brings * (1 - 1e-9))

    def held(self, asked: Array) -> npt.NDArray[np.bool_]:
        """Which constraints hold, shape (constraints, n)."""
        constraints = self.spec.constraints
        made = [c.holds(row) for c, row in zip(constraints, asked, strict=False)]
        return np.array(made, bool).reshape(len(constraints), asked.shape[1])

    def told(self, run: SweepResult) -> Told:
        """Which designs of a run are spoken of."""
        asked, constraints = run.asked, self.spec.constraints
        broken = ~self.held(asked)
        failures = broken.sum(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            costs = np.log(asked[len(constraints) :]).T * self.signs
            scores = costs @ self.weights
        fits = failures == 0
        family, left, best = self.family(run.numbers), fits.copy(), list[int]()
        while len(best) < FAMILIES and (at := _least(scores, left)) is not None:
            best.append(at)
            left &= family != family[at]
        alone, reach = {}, {}
        for i, c in enumerate(constraints):
            others = failures == broken[i]
            alone[i] = _least(scores, others & broken[i])
            reach[i] = _least(asked[i] if c.most else -asked[i], others)
        places = np.flatnonzero(fits)
        return Told(scores, places[front(costs[fits])], best, _found(alone), _found(reach))

    def _thinned(self, run: SweepResult) -> SweepResult:
        """The same with those designs only that are spoken of."""
        told = self.told(run)
        single = [*told.best, *told.alone.values(), *told.reach.values()]
        kept = np.unique(np.concatenate([told.front, np.array(single, np.int64)]))
        return replace(run, numbers=run.numbers[kept], asked=run.asked[:, kept])

    def family(self, numbers: Numbers) -> Numbers:
        """One number for all designs of the same film, thickness and whole numbers."""
        grid = self.spec.grid
        film, *rest = grid.digits(numbers)
        out = film
        for name, place in zip(grid.axes, rest, strict=True):
            if name in ("count", "series", "parallel"):
                out = out * len(grid.axes[name]) + place
        return np.asarray(out)

    def sum(self, parts: Iterable[SweepResult]) -> SweepResult:
        """The SweepResult of several runs together, in their order."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        examined, built, feasible, failed, low, high, numbers, asked = columns
        run = SweepResult(
            examined=sum(examined),
            built=sum(built),
            feasible=sum(feasible),
            failed=np.sum(failed, axis=0),
            low=np.min(low, axis=0),
            high=np.max(high, axis=0),
            numbers=np.concatenate(numbers),
            asked=np.concatenate(asked, axis=1),
        )
        return self._thinned(run)

    def summary(self, run: SweepResult) -> dict[str, Any]:
        """A run as JSON takes it, its designs by number."""
        told, numbers, family = self.told(run), run.numbers, self.family(run.numbers)
        spans = {"low": run.low, "high": run.high}
        return {
            "examined": run.examined,
            "built": run.built,
            "feasible": run.feasible,
            "best": [[told.scores[at], int(numbers[at]), int(family[at])] for at in told.best],
            "alone": {i: [told.scores[at], int(numbers[at])] for i, at in told.alone.items()},
            "reach": {i: [run.asked[i, at], int(numbers[at])] for i, at in told.reach.items()},
            "failed": dict(enumerate(run.failed.tolist())),
            **{
                key: {
                    n: v for n, v in zip(self.row, ends.tolist(), strict=True) if math.isfinite(v)
                }
                for key, ends in spans.items()
            },
        }

    def design(self, number: int) -> dict[str, Any]:
        """One design: its variables and all its merits."""
        return self.designs(np.array([number], np.int64))[0]

    def designs(self, numbers: Numbers) -> list[dict[str, Any]]:
        """Several designs at once, each with its variables and all its merits."""
        if len(numbers) == 0:
            return []
        found = dict(zip(self.spec.evaluation.all_names, self.kernel.at(numbers), strict=True))
        found |= self.kernel.drawn(numbers)
        return [
            {
                "number": int(number),
                **self.spec.grid.values(number),
                **{n: float(found[n][at]) if n in found else math.nan for n in MERITS},
            }
            for at, number in enumerate(numbers.tolist())
        ]


def _least(values: Array, among: npt.NDArray[np.bool_]) -> int | None:
    """Place of the least finite value among some; None where there is none."""
    there = np.flatnonzero(among & np.isfinite(values))
    return int(there[np.argmin(values[there])]) if len(there) else None


def _found(places: dict[int, int | None]) -> dict[int, int]:
    return {i: at for i, at in places.items() if at is not None}


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
