"""Feasibility test of a specification before a sweep, which evaluates corners of boxes of designs.

Many merits are monotonic in every variable, so their best value in a box of designs is at a corner.
A box in which no design can meet a constraint is discarded; the others are cut in two. If no box is
left, no design meets all constraints.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.workshop.design.grid import Array, Numbers
from layerjam.workshop.design.merit import LATE_MERITS, VARIABLES
from layerjam.workshop.design.requirements import Constraint
from layerjam.workshop.design.search import Search
from layerjam.workshop.design.stopping import gravity_along_pull, least_peak

MOST_BOXES = 1_000_000
"""Maximum number of boxes to examine; beyond it, only the sweep can decide."""
UNBUILDABLE = "none of the designs can be built: travel, overlap and width contradict one another"
FEASIBLE, IMPOSSIBLE, UNKNOWN = "feasible", "impossible", "unknown"

_FOLLOWS: dict[str, tuple[str, str]] = {
    "holding_force": ("count width overlap vacuum parallel", "offset free_left free_right"),
    "max_force": (
        "count width overlap vacuum wall parallel usable_travel",
        "offset free_left free_right",
    ),
    "usable_travel": ("overlap usable_travel series", "offset"),
    "energy_capacity": (
        "count width overlap usable_travel vacuum wall series parallel",
        "offset free_left free_right",
    ),
    "mass": (
        "count width overlap free_left free_right offset wall fittings_mass series parallel",
        "",
    ),
    "volume": ("count width overlap free_left free_right offset wall series parallel", ""),
    "length": ("overlap free_left free_right offset series", ""),
    "clamped_length": ("overlap free_left free_right offset series", ""),
    "height": ("count wall", ""),
    "stiffness": ("count width parallel", "overlap free_left free_right offset series"),
    "buckling_force": ("width", "free_left free_right offset"),
    "rise_time": ("vacuum series parallel", ""),
    "gas_work": ("vacuum series parallel", ""),
}
"""{merit: (variables with which it rises, those with which it falls)}; no other variables affect
it. Free lengths change the friction only if the sheets fan out. For merits that are not listed, the
direction is unknown.
"""


def merit_direction(merit: str, variable: str, tied: bool) -> int | None:
    """Return 1 if a merit rises with a variable, -1 if it falls, 0 if neither; None if unknown.

    If `tied`, the usable travel follows the overlap. Otherwise, a weak brake's force at the end of
    travel, and its work, may fall as the overlap increases.
    """
    if merit in ("sheet_stress", "clamp_stress", "stress_margin"):
        return _stress_direction(merit, variable, tied)
    if merit not in _FOLLOWS:
        return (1 if merit == variable else 0) if merit in VARIABLES else None
    if not tied and variable == "overlap":
        if merit in ("max_force", "energy_capacity"):
            return None
        if merit == "usable_travel":
            return 0
    up, down = (words.split() for words in _FOLLOWS[merit])
    return (variable in up) - (variable in down)


def _stress_direction(merit: str, variable: str, tied: bool) -> int | None:
    sign = -1 if merit == "stress_margin" else 1
    if variable == "count":
        return None  # with an odd number of sheets, one side has one more
    if variable == "width":
        return 0 if merit == "sheet_stress" else -sign
    if variable == "parallel":
        return 0
    force = merit_direction("max_force", variable, tied)
    return None if force is None else force * sign


@dataclass(frozen=True)
class Proof:
    """Outcome of a feasibility test."""

    outcome: str
    number: int | None = None
    """Index of a design that meets the constraints, or None."""


class BestValue(NamedTuple):
    """Best value of a quantity under other constraints; `value` is None if there is none."""

    value: float | None
    exact: bool
    """False if better values are possible."""


ROUNDS = 24


class Boxes:
    """Boxes of designs in one search."""

    def __init__(
        self, search: Search, progress: Callable[[str, float], None] | None = None
    ) -> None:
        self.search, self.grid = search, search.spec.grid
        self.progress = progress or (lambda *_: None)

    def directions(self, merit: str) -> list[int | None]:
        """Return the direction, or None, of a merit with each variable."""
        tied = "usable_travel" not in self.grid.axes
        return [merit_direction(merit, variable, tied) for variable in self.grid.axes]

    def initial_boxes(self) -> tuple[Numbers, Numbers]:
        """Return the indices of the two extreme corners of the initial boxes, one box per film."""
        shape = np.array(self.grid.shape, np.int64)
        low, high = np.zeros((shape[0], len(shape)), np.int64), np.tile(shape - 1, (shape[0], 1))
        low[:, 0] = high[:, 0] = np.arange(shape[0])
        return low, high

    def best_corners(self, low: Numbers, high: Numbers, c: Constraint) -> tuple[Numbers, Any]:
        """Return the best corner of each box for a constraint, and whether it is a bound."""
        best, is_exact = low.copy(), np.ones(len(low), bool)
        for axis, sign in enumerate(self.directions(c.name), 1):
            is_open = high[:, axis] > low[:, axis]
            if sign is None:
                is_exact &= ~is_open
            elif sign == (-1 if c.most else 1):
                best[:, axis] = high[:, axis]
        return best, is_exact

    def prove_feasibility(self, constraints: Sequence[Constraint]) -> Proof:
        """Return a proof that a design, or none, meets all constraints with bounds at corners."""
        rules = [c for c in constraints if c.name not in LATE_MERITS]
        if not rules:
            return Proof(UNKNOWN)
        is_complete = len(rules) == len(constraints)
        low, high = self.initial_boxes()
        count = 0
        # an unknown direction provides no bound until the box is only one value wide
        unsure = [None in d for d in zip(*(self.directions(c.name) for c in rules), strict=True)]
        first = np.where([False, *unsure], 1e3, 1.0)
        while len(low):
            count += len(low)
            self.progress("checking feasibility", min(count / MOST_BOXES, 1.0))
            if count > MOST_BOXES:
                return Proof(UNKNOWN)
            is_open = np.ones(len(low), bool)
            for c in rules:
                best, is_exact = self.best_corners(low, high, c)
                numbers = self.grid.number(best.T)
                rows = self.search.kernel.all_merits(numbers, stop=False)
                is_built = np.isfinite(rows[self.search.row["mass"]])
                meets = {o: o.is_met(self.search.quantity(o.name, rows, numbers)) for o in rules}
                is_open &= ~(is_exact & is_built & ~meets[c])
                good = np.all([is_built, *meets.values()], axis=0)
                if good.any():  # merits that are computed later may still exclude this design
                    number = int(numbers[np.argmax(good)])
                    return Proof(FEASIBLE, number) if is_complete else Proof(UNKNOWN)
            is_single = (low == high).all(axis=1)
            if (is_single & is_open).any() and not is_complete:
                return Proof(UNKNOWN)
            # a single design was evaluated above, and returned if it met all constraints
            is_open &= ~is_single
            low, high = _bisect_boxes(low[is_open], high[is_open], first)
        return Proof(IMPOSSIBLE)

    def best_value(self, c: Constraint, others: Sequence[Constraint]) -> BestValue:
        """Return the best value of a quantity while the others are met, to 1e-4 of the limit."""
        if not others and (best := self.best_corner_value(c)) is not None:
            return BestValue(best, True)
        number = self.prove_feasibility(others).number if others else self.grid.size - 1
        if number is None:
            return BestValue(None, False)
        value, limit = self.constraint_value(number, c), c.limit
        for _ in range(ROUNDS):
            if not math.isfinite(value):
                return BestValue(None, False)
            if abs(limit - value) <= 1e-4 * abs(limit):
                return BestValue(value, True)
            middle = (value + limit) / 2
            proof = self.prove_feasibility([*others, evolve(c, limit=middle)])
            if proof.number is not None:
                value = self.constraint_value(proof.number, c)
            elif proof.outcome == IMPOSSIBLE:
                limit = middle
            else:
                return BestValue(value, False)
        return BestValue(value, True)

    def best_corner_value(self, c: Constraint) -> float | None:
        """Return the best value of a constraint's quantity from corners, or None if unbounded."""
        best, is_exact = self.best_corners(*self.initial_boxes(), c)
        values = self.constraint_values(self.grid.number(best.T), c)
        if not is_exact.all() or not np.isfinite(values).all():
            return None
        return float(values.min() if c.most else values.max())

    def constraint_values(self, numbers: Numbers, c: Constraint) -> Array:
        """Return a constraint's quantity (not one of a stop) for designs, given their numbers."""
        merits = self.search.kernel.all_merits(numbers, stop=False)
        return self.search.quantity(c.name, merits, numbers)

    def constraint_value(self, number: int, c: Constraint) -> float:
        """Return a constraint's quantity for one design, given its number."""
        return float(self.constraint_values(np.array([number]), c)[0])


def _bisect_boxes(low: Numbers, high: Numbers, first: Any) -> tuple[Numbers, Numbers]:
    """Return the boxes, each cut in two along its longest side, with sides weighted by `first`."""
    if not len(low):
        return low, high
    side = np.argmax((high - low) * first, axis=1)
    rows = np.arange(len(low))
    middle = (low[rows, side] + high[rows, side]) // 2
    upper, lower = low.copy(), high.copy()
    upper[rows, side], lower[rows, side] = middle + 1, middle
    return np.concatenate([low, upper]), np.concatenate([lower, high])


@dataclass(frozen=True)
class Exclusion:
    """Reason why no design meets a specification: constraints that cannot be met together."""

    constraint: str | None
    """Constraint that fails, or None if nothing can be built."""
    reason: str
    reachable: float | None = None
    """Best value of the constraint's quantity if the others are met."""
    unit: str = "1"
    others: tuple[str, ...] = ()
    """Constraints that must be relaxed to meet it; empty if it fails alone."""
    short: float = 0.0
    """Relative shortfall from the limit."""


def prove_impossible(
    search: Search, progress: Callable[[str, float], None] | None = None
) -> Exclusion | None:
    """Return the constraints that cannot be met together, or None if that cannot be proved."""
    boxes = Boxes(search, progress)
    anything = Constraint("mass", False, 0.0)
    if boxes.prove_feasibility([anything]).outcome == IMPOSSIBLE:
        return Exclusion(None, UNBUILDABLE)
    exclusion = _physical_exclusion(search)
    if exclusion is not None:
        return exclusion
    rules = list(search.spec.constraints)
    for c in rules:
        if boxes.prove_feasibility([c]).outcome == IMPOSSIBLE:
            return _make_exclusion(boxes, c, [])
    if boxes.prove_feasibility(rules).outcome != IMPOSSIBLE:
        return None
    core = [c for c in rules if c.name not in LATE_MERITS]
    for c in tuple(core):
        others = [o for o in core if o is not c]
        if boxes.prove_feasibility(others).outcome == IMPOSSIBLE:
            core = others
    return min(
        (_make_exclusion(boxes, c, [o for o in core if o is not c]) for c in core),
        key=_relative_shortfall,
    )


def _relative_shortfall(k: Exclusion) -> float:
    return math.inf if k.reachable is None or not math.isfinite(k.reachable) else k.short


def _make_exclusion(boxes: Boxes, c: Constraint, others: list[Constraint]) -> Exclusion:
    best = boxes.best_value(c, others)
    words = f" together with {' and '.join(map(str, others))}" if others else ""
    reason = f"{c} cannot be met{words}{describe_shortfall(c, best.value, best.exact)}"
    shortfall = math.inf if best.value is None else c.shortfall(best.value)
    return Exclusion(str(c), reason, best.value, c.unit, tuple(map(str, others)), shortfall)


def describe_shortfall(c: Constraint, best: float | None, exact: bool = True) -> str:
    """Return the shortfall from a constraint, as the end of a sentence."""
    if best is None or not math.isfinite(best):
        return ""
    bound_text = (
        f"{'lowest' if c.most else 'highest'} {'reachable value' if exact else 'value found'}"
    )
    shortfall = c.shortfall(best)
    words = f"{shortfall:.2g} times the limit" if shortfall > 2 else f"{shortfall:.2%}"
    return f": the {bound_text} is {show(best, c.unit)}, {words} {'over' if c.most else 'short'}"


def _physical_exclusion(search: Search) -> Exclusion | None:
    """Return the reason why no brake of the grid, or no brake at all, can stop the mass."""
    stop = search.spec.evaluation.stop
    if stop is None or stop.travel is None:
        return None
    boxes = Boxes(search)
    min_stiffness = boxes.best_corner_value(Constraint("stiffness", True, 1.0))
    if min_stiffness is None or not min_stiffness > 0:
        return None
    strongest = boxes.best_corner_value(Constraint("max_force", False, 1.0))
    force = min(f for f in (stop.force, strongest, math.inf) if f is not None)
    if math.isinf(force):
        return None
    distance = stop.travel + force / min_stiffness
    fall = gravity_along_pull(stop, search.spec.evaluation.base)
    least_force = float(least_peak(stop.mass, stop.speed, distance, fall))
    slip = Constraint("stop_slip", True, stop.travel)
    if stop.force is not None and stop.force < least_force:
        peak = Constraint("stop_peak", True, stop.force)
        reason = (
            f"{peak} cannot be met by any brake: {show(stop.mass, 'kg')} at "
            f"{show(stop.speed, 'm/s')} within {show(distance, 'm')} (slip and stretch) "
            f"need at least {show(least_force, 'N')}"
        )
        return Exclusion(str(peak), reason, least_force, "N", (str(slip),))
    if strongest is not None and strongest < least_force:
        reason = (
            f"{slip} needs at least {show(least_force, 'N')}; the strongest of these "
            f"brakes reaches {show(strongest, 'N')}"
        )
        return Exclusion(str(slip), reason, strongest, "N")
    energy = stop.mass * stop.speed**2 / 2
    c = Constraint("energy_capacity", False, energy - force**2 / (2 * min_stiffness))
    if c.limit <= 0 or boxes.prove_feasibility([c]).outcome != IMPOSSIBLE:
        return None
    best = boxes.best_corner_value(c)
    reason = (
        f"the mass carries {show(energy, 'J')}{describe_shortfall(c, best)} "
        "(largest energy_capacity of these brakes)"
    )
    return Exclusion(str(c), reason, best, "J")
