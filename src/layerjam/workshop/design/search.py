"""Block-by-block sweep of all designs of a specification; it keeps the Pareto front and highlights.

A block of designs is cut into chunks that fit into the cache, one per core. The outcome depends
neither on the number of cores nor on the order in which they finish.
"""

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.threads import Workers
from layerjam.workshop.design.front import find_front
from layerjam.workshop.design.grid import PIECE, Array, Kernel, Numbers
from layerjam.workshop.design.merit import LATE_MERITS, MERITS, STOP_MERITS
from layerjam.workshop.design.requirements import DesignSpecification
from layerjam.workshop.design.robust import FEW, Assessment, Samples, assess

CHUNK = PIECE
"""Number of designs that one core computes at a time."""
BLOCK = 1 << 20
"""Number of designs in a block, the smallest unit that is stored, repeated or sent to a machine."""
FAMILIES = 8
"""Number of best families (film, thickness, whole numbers); a finer search may reorder them."""
FIRST_LOOK = 128
"""Number of designs, with the best scores of a chunk, whose probabilities are computed first."""
SURER = 4
"""Number of probabilities, from the confidence in steps of 1/FEW, for which designs are kept."""


@dataclass(frozen=True)
class SweepResult:
    """Outcome of a run over designs; two runs can be added.

    `failed` counts the built designs that violate each constraint. `low` and `high` are the lowest
    and highest values of each merit (infinite if no design has it). `numbers`, ascending, are the
    highlighted designs; `asked` contains the quantities in constraints and objectives and, last,
    the probability that the design meets all constraints, shape (quantities, n). The probability
    is NaN if the average brake does not meet them, if no confidence is required, or for designs
    whose probability could not change the outcome.
    """

    examined: int
    built: int
    feasible: int
    failed: Numbers
    low: Array
    high: Array
    numbers: Numbers
    asked: Array


class Highlights(NamedTuple):
    """Highlighted designs of a run, as indices into its `numbers`."""

    scores: Array
    """Score of every design: sum of weight times signed ln(objective); lower is better."""
    front: Numbers
    """Designs that no other design dominates."""
    best: list[int]
    """Best designs in the best families, of designs that may reach the confidence if any do."""
    average: int | None
    """Best design of those that meet the constraints with the average brake."""
    surest: int | None
    """Design with the highest known probability of meeting all constraints."""
    obstacle: dict[int, int]
    """{constraint: the best design that only this constraint excludes}."""
    reach: dict[int, int]
    """{constraint: the design nearest to meeting it, among those that meet all others}."""


class Search:
    """Sweep over the designs of a specification."""

    def __init__(self, spec: DesignSpecification, block: int = BLOCK) -> None:
        self.size = block
        self.spec, self.kernel = spec, Kernel(spec.grid, spec.evaluation)
        self.row = {n: i for i, n in enumerate(spec.merits)}
        if spec.drawn_merits and spec.evaluation.draw is None:
            raise QuantityError.of(
                spec.drawn_merits[0], "needs a function that draws brakes (Evaluation.draw)"
            )
        self.samples = Samples(spec, self.kernel) if spec.confidence else None
        self.wanted = [*(c.name for c in spec.constraints), *(o.name for o in spec.objectives)]
        self.signs = np.array([o.sign for o in spec.objectives])
        self.weights = np.array([o.weight for o in spec.objectives])

    def count_blocks(self) -> int:
        """Return the number of blocks."""
        return -(-self.spec.grid.size // self.size)

    def run_block(self, index: int, pool: Workers | None = None) -> SweepResult:
        """Return the outcome of block number `index`."""
        first = index * self.size
        end = min(first + self.size, self.spec.grid.size)
        starts = range(first, end, CHUNK)
        spread: Callable[..., Iterable[SweepResult]] = map if pool is None else pool.map
        return self.add_runs(spread(lambda s: self.run_chunk(s, min(CHUNK, end - s)), starts))

    def run_all(self, progress: Callable[[str, float], None] | None = None) -> SweepResult:
        """Return the outcome of all designs, in memory."""
        total = self.count_blocks()
        results: list[SweepResult] = []
        with Workers() as pool:
            for index in range(total):
                results = [self.add_runs([*results, self.run_block(index, pool)])]
                if progress is not None:
                    progress("designs", (index + 1) / total)
        return results[0]

    def quantity(self, name: str, values: Array, numbers: Numbers) -> Array:
        """Return the values of a merit, from the kernel's rows, or of a design variable."""
        if name in self.row:
            return values[self.row[name]]
        return np.asarray(self.spec.grid.columns(numbers)[name], float)

    def run_chunk(self, first: int, count: int) -> SweepResult:
        """Return the outcome of `count` designs starting at index `first`."""
        numbers = np.arange(first, first + count, dtype=np.int64)
        values = self.kernel.merits(numbers)
        is_built = np.isfinite(values[self.row["mass"]])
        if not is_built.all():
            numbers, values = numbers[is_built], values[:, is_built]
        # drawn merits are computed faster than a stop, and they exclude many designs
        drawn_rows = self._late_drawn_merits(numbers, values)
        late_rows = [drawn_rows] if len(drawn_rows) else []
        if self.spec.evaluation.stop is not None:
            late_rows.insert(0, self._late_stop_merits(numbers, values, drawn_rows))
        if late_rows:  # a copy takes a tenth of the time of a chunk
            values = np.concatenate([values, *late_rows])
        quantities = np.stack([self.quantity(name, values, numbers) for name in self.wanted])
        meets = self.check_constraints(quantities)
        fits = np.asarray(meets.all(axis=0))
        chance = (
            np.full(len(numbers), math.nan)
            if self.samples is None
            else self._find_chances(self.samples, numbers, quantities, fits)
        )
        is_finite = np.isfinite(values)
        run = SweepResult(
            examined=count,
            built=len(numbers),
            feasible=int(fits.sum()),
            failed=(~meets).sum(axis=1),
            low=values.min(axis=1, initial=math.inf, where=is_finite),
            high=values.max(axis=1, initial=-math.inf, where=is_finite),
            numbers=numbers,
            asked=np.concatenate([quantities, chance[None]]),
        )
        return self._keep_highlights(run)

    def _find_chances(
        self, samples: Samples, numbers: Numbers, quantities: Array, fits: npt.NDArray[np.bool_]
    ) -> Array:
        """Return the probabilities of designs that may be highlighted, NaN for the others.

        These are the front and the designs with the best scores, until each of the best families
        has one that surely reaches the confidence. If none does, these are all designs.
        """
        chance = np.full(len(numbers), math.nan)
        costs, scores = self._score(quantities)
        order = np.flatnonzero(fits)
        front = order[find_front(costs[fits])]
        order = order[np.argsort(scores[fits], kind="stable")]
        chance[front] = samples.find_probabilities(numbers[front])
        family, sure_families, size = self.families(numbers), set[int](), FIRST_LOOK
        while len(order) and len(sure_families) < FAMILIES:
            part, order, size = order[:size], order[size:], 4 * size
            unknown = part[np.isnan(chance[part])]
            chance[unknown] = samples.find_probabilities(numbers[unknown])
            # a design without a finite score is not chosen, so it settles no family
            sure = (chance[part] >= self._share(SURER - 1)) & np.isfinite(scores[part])
            sure_families |= {*family[part[sure]].tolist()}
            order = order[~np.isin(family[order], [*sure_families])]
        return chance

    def _share(self, steps: int) -> float:
        """Return the share of samples that a design needs for the confidence, with more steps."""
        return self.spec.confidence + steps / FEW - 1e-9

    def _score(self, quantities: Array) -> tuple[Array, Array]:
        """Return the signed ln(objective) of designs, (n, objectives), and their scores."""
        with np.errstate(divide="ignore", invalid="ignore"):
            costs = np.log(quantities[len(self.spec.constraints) :]).T * self.signs
        return costs, costs @ self.weights

    def _late_stop_merits(self, numbers: Numbers, values: Array, drawn_rows: Array) -> Array:
        """Return stop merits of designs with at most one violation so far, NaN for the others."""
        count = self._count_violations(numbers, values)
        for c in self.spec.constraints:
            if c.name in self.spec.drawn_merits:
                count += ~c.is_met(drawn_rows[self.spec.drawn_merits.index(c.name)])
        candidates = (count <= 1) & self.can_stop(values)
        rows = np.full((len(STOP_MERITS), len(numbers)), math.nan)
        rows[:, candidates] = self.kernel.stops(numbers[candidates])
        return rows

    def _late_drawn_merits(self, numbers: Numbers, values: Array) -> Array:
        """Return drawn merits of designs with at most one violation so far, NaN for the others."""
        candidates = self._count_violations(numbers, values) <= 1
        rows = np.full((len(self.spec.drawn_merits), len(numbers)), math.nan)
        rows[:, candidates] = self.drawn_merits(numbers[candidates])
        return rows

    def drawn_merits(self, numbers: Numbers) -> Array:
        """Return the requested drawn merits, shape (merits, n)."""
        merits = self.kernel.drawn_merits(numbers) if self.spec.drawn_merits else {}
        shape = (len(self.spec.drawn_merits), len(numbers))
        return np.array([merits[n] for n in self.spec.drawn_merits]).reshape(shape)

    def _count_violations(self, numbers: Numbers, values: Array) -> Numbers:
        """Return the number of constraints, except late ones, that each design violates."""
        count = np.zeros(len(numbers), int)
        for c in self.spec.constraints:
            if c.name not in LATE_MERITS:
                count += ~c.is_met(self.quantity(c.name, values, numbers))
        return count

    def can_stop(self, values: Array) -> npt.NDArray[np.bool_]:
        """Return whether travel and stretch of each design can absorb the energy of the mass."""
        row, stop = self.row, self.spec.evaluation.stop
        stretch = values[row["max_force"]] ** 2 / (2 * values[row["stiffness"]])
        capacity = values[row["energy_capacity"]] + stretch
        energy = 0.0 if stop is None else stop.mass * stop.speed**2 / 2
        return np.asarray(capacity > energy * (1 - 1e-9))

    def check_constraints(self, quantities: Array) -> npt.NDArray[np.bool_]:
        """Return which constraints are met, shape (constraints, n)."""
        constraints = self.spec.constraints
        rows = [c.is_met(row) for c, row in zip(constraints, quantities, strict=False)]
        return np.array(rows, bool).reshape(len(constraints), quantities.shape[1])

    def find_highlights(self, run: SweepResult) -> Highlights:
        """Return the highlighted designs of a run."""
        quantities, constraints = run.asked, self.spec.constraints
        is_broken = ~self.check_constraints(quantities)
        failures = is_broken.sum(axis=0)
        costs, scores = self._score(quantities[:-1])
        fits, chance = failures == 0, quantities[-1]
        best: set[int] = set()
        if self.spec.confidence:
            # few samples determine a probability only roughly: keep surer designs too
            for steps in range(SURER):
                likely = fits & (chance >= self._share(steps))
                best |= {*self._best_of_families(run.numbers, scores, likely)}
        obstacle, reach = dict[int, int](), dict[int, int]()
        for i, c in enumerate(constraints):
            has_same_failures = failures == is_broken[i]
            if (k := _masked_argmin(scores, has_same_failures & is_broken[i])) is not None:
                obstacle[i] = k
            excess = quantities[i] if c.most else -quantities[i]
            if (k := _masked_argmin(excess, has_same_failures)) is not None:
                reach[i] = k
        return Highlights(
            scores,
            np.flatnonzero(fits)[find_front(costs[fits])],
            sorted(best, key=lambda k: (scores[k], k))
            or self._best_of_families(run.numbers, scores, fits),
            _masked_argmin(scores, fits),
            _masked_argmin(-chance, fits),
            obstacle,
            reach,
        )

    def _best_of_families(
        self, numbers: Numbers, scores: Array, candidates: npt.NDArray[np.bool_]
    ) -> list[int]:
        """Return the best design in each of the best families."""
        family, remaining, best = self.families(numbers), candidates.copy(), list[int]()
        while len(best) < FAMILIES and (place := _masked_argmin(scores, remaining)) is not None:
            best.append(place)
            remaining &= family != family[place]
        return best

    def _keep_highlights(self, run: SweepResult) -> SweepResult:
        highlights = self.find_highlights(run)
        single_designs = [
            *highlights.best,
            *highlights.obstacle.values(),
            *highlights.reach.values(),
        ]
        single_designs += [k for k in (highlights.average, highlights.surest) if k is not None]
        places = np.unique(np.concatenate([highlights.front, np.array(single_designs, np.int64)]))
        return evolve(run, numbers=run.numbers[places], asked=run.asked[:, places])

    def families(self, numbers: Numbers) -> Numbers:
        """Return a number for the family (same film, thickness, whole numbers) of each design."""
        grid = self.spec.grid
        film, *places = grid.digits(numbers)
        out = film
        for name, place in zip(grid.axes, places, strict=True):
            if name in ("count", "series", "parallel"):
                out = out * len(grid.axes[name]) + place
        return np.asarray(out)

    def add_runs(self, parts: Iterable[SweepResult]) -> SweepResult:
        """Return the sum of several runs, in their order."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        pairs = zip(_JOIN.items(), columns, strict=True)
        sums = {name: join(column) for (name, join), column in pairs}
        return self._keep_highlights(SweepResult(**sums))

    def summary(self, run: SweepResult) -> dict[str, Any]:
        """Return a run as JSON, with its designs identified by number."""
        picks, numbers, family = self.find_highlights(run), run.numbers, self.families(run.numbers)
        spans = {"low": run.low, "high": run.high}
        return {
            "examined": run.examined,
            "built": run.built,
            "feasible": run.feasible,
            "best": [[picks.scores[k], int(numbers[k]), int(family[k])] for k in picks.best],
            "surest": None if picks.surest is None else int(numbers[picks.surest]),
            "alone": {i: [picks.scores[k], int(numbers[k])] for i, k in picks.obstacle.items()},
            "reach": {i: [run.asked[i, k], int(numbers[k])] for i, k in picks.reach.items()},
            "failed": dict(enumerate(run.failed.tolist())),
            **{
                key: {
                    n: v for n, v in zip(self.row, ends.tolist(), strict=True) if math.isfinite(v)
                }
                for key, ends in spans.items()
            },
        }

    def design(self, number: int) -> dict[str, Any]:
        """Return the variables and all merits of one design."""
        return self.designs(np.array([number], np.int64))[0]

    def assess(self, number: int) -> Assessment:
        """Return the probabilities that one design meets the constraints."""
        return assess(self.spec, self.spec.grid.point(number), self.design(number))

    def designs(self, numbers: Numbers) -> list[dict[str, Any]]:
        """Return several designs, each with its variables and all merits."""
        if len(numbers) == 0:
            return []
        rows = self.kernel.all_merits(numbers)
        merits = dict(zip(self.spec.evaluation.all_names, rows, strict=True))
        merits |= self.kernel.drawn_merits(numbers)
        return [
            {
                "number": int(number),
                **self.spec.grid.values(number),
                **{n: float(merits[n][row]) if n in merits else math.nan for n in MERITS},
            }
            for row, number in enumerate(numbers.tolist())
        ]


_JOIN: Mapping[str, Callable[..., Any]] = {
    **dict.fromkeys(("examined", "built", "feasible"), sum),
    "failed": functools.partial(np.sum, axis=0),
    "low": functools.partial(np.min, axis=0),
    "high": functools.partial(np.max, axis=0),
    "numbers": np.concatenate,
    "asked": functools.partial(np.concatenate, axis=1),
}
"""How two or more values of each field of SweepResult become one."""


def _masked_argmin(values: Array, mask: npt.NDArray[np.bool_]) -> int | None:
    places = np.flatnonzero(mask & np.isfinite(values))
    return int(places[np.argmin(values[places])]) if len(places) else None
