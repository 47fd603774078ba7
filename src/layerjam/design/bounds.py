"""Can a specification be met at all? Proved by the corners of boxes of designs, before a sweep.

Many merits rise or fall with every variable; the best value in a box of designs is then that of one
corner. A box none of whose designs can meet a constraint is thrown away, the others are cut in two.
Nothing left: proved that nothing meets them all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from layerjam.design.grid import Array, Numbers
from layerjam.design.merit import LATE_MERITS, VARIABLES
from layerjam.design.requirements import Constraint
from layerjam.design.search import Search
from layerjam.design.stopping import gravity, least_peak
from layerjam.units import show

MOST_BOXES = 1_000_000
"""Boxes looked at before the answer is left to the sweep."""
UNBUILDABLE = "none of the designs can be built: travel, overlap and width contradict"
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
    "height": ("count wall", ""),
    "stiffness": ("count width parallel", "overlap free_left free_right offset series"),
    "buckling_force": ("width", "free_left free_right offset"),
    "rise_time": ("vacuum series parallel", ""),
    "gas_work": ("vacuum series parallel", ""),
}
"""Merit: variables with which it rises, and with which it falls; none of the others changes it.
Free lengths change the friction only of sheets that fan out. Of merits that are missing nothing is
claimed."""


def direction(merit: str, variable: str, tied: bool) -> int | None:
    """1, -1 or 0 where a merit rises, falls or stays with a variable; None where not known.

    `tied`: the usable travel follows the overlap. With a travel of its own the force at the end of
    a weak brake may fall with the overlap, and so may the work.
    """
    if merit in ("sheet_stress", "clamp_stress", "stress_margin"):
        return _stress(merit, variable, tied)
    if merit not in _FOLLOWS:
        return (1 if merit == variable else 0) if merit in VARIABLES else None
    if not tied and variable == "overlap":
        if merit in ("max_force", "energy_capacity"):
            return None
        if merit == "usable_travel":
            return 0
    up, down = (words.split() for words in _FOLLOWS[merit])
    return (variable in up) - (variable in down)


def _stress(merit: str, variable: str, tied: bool) -> int | None:
    """Stress follows the force of one brake, which is proportional to its width."""
    turn = -1 if merit == "stress_margin" else 1
    if variable == "count":
        return None  # of odd and even numbers of sheets, one side has as many or one more
    if variable == "width":
        return 0 if merit == "sheet_stress" else -turn
    if variable == "parallel":
        return 0
    force = direction("max_force", variable, tied)
    return None if force is None else force * turn


@dataclass(frozen=True)
class Proof:
    """How a search by boxes ended."""

    outcome: str
    number: int | None = None
    """A design that meets the constraints, where one was met."""


class Reached(NamedTuple):
    """The best value of a quantity under other constraints; None where none was found."""

    value: float | None
    exact: bool
    """False where better ones are not excluded."""


ROUNDS = 24


class Boxes:
    """Boxes of designs of one search; `prove` says whether constraints can be met together."""

    def __init__(
        self, search: Search, progress: Callable[[str, float], None] | None = None
    ) -> None:
        self.search, self.grid = search, search.spec.grid
        self.progress = progress or (lambda *_: None)

    def signs(self, merit: str) -> list[int | None]:
        """What is known of how a merit rises and falls with each variable."""
        tied = "usable_travel" not in self.grid.axes
        return [direction(merit, variable, tied) for variable in self.grid.axes]

    def whole(self) -> tuple[Numbers, Numbers]:
        """Digits of the two corners of the boxes to begin with, one for each film."""
        shape = np.array(self.grid.shape, np.int64)
        low, high = np.zeros((shape[0], len(shape)), np.int64), np.tile(shape - 1, (shape[0], 1))
        low[:, 0] = high[:, 0] = np.arange(shape[0])
        return low, high

    def corner(self, low: Numbers, high: Numbers, c: Constraint) -> tuple[Numbers, Any]:
        """Digits of the corner best for a constraint, and for which boxes that is a bound."""
        best, sure = low.copy(), np.ones(len(low), bool)
        for axis, sign in enumerate(self.signs(c.name), 1):
            wide = high[:, axis] > low[:, axis]
            if sign is None:
                sure &= ~wide
            elif sign == (-1 if c.most else 1):
                best[:, axis] = high[:, axis]
        return best, sure

    def prove(self, constraints: Sequence[Constraint]) -> Proof:
        """Whether designs meet all constraints that are bounded by corners."""
        rules = [c for c in constraints if c.name not in LATE_MERITS]
        if not rules:
            return Proof(UNKNOWN)
        whole = len(rules) == len(constraints)
        low, high = self.whole()
        looked = 0
        # where nothing is claimed a box says nothing until it is one value wide
        unsure = [None in signs for signs in zip(*(self.signs(c.name) for c in rules), strict=True)]
        first = np.where([False, *unsure], 1e3, 1.0)
        while len(low):
            looked += len(low)
            self.progress("can it be met at all", min(looked / MOST_BOXES, 1.0))
            if looked > MOST_BOXES:
                return Proof(UNKNOWN)
            alive = np.ones(len(low), bool)
            for c in rules:
                best, sure = self.corner(low, high, c)
                numbers = self.grid.number(best.T)
                rows = self.search.kernel.at(numbers, stop=False)
                built = np.isfinite(rows[self.search.row["mass"]])
                held = {o: o.holds(self.search.quantity(o.name, rows, numbers)) for o in rules}
                alive &= ~(sure & built & ~held[c])
                good = np.all([built, *held.values()], axis=0)
                if good.any():  # what is left out may still exclude it, bounds cannot
                    number = int(numbers[np.argmax(good)])
                    return Proof(FEASIBLE, number) if whole else Proof(UNKNOWN)
            single = (low == high).all(axis=1)
            if (single & alive).any() and not whole:
                return Proof(UNKNOWN)
            # a single design was looked at itself: had it met all, it would be the answer
            alive &= ~single
            low, high = _cut(low[alive], high[alive], first)
        return Proof(IMPOSSIBLE)

    def farthest(self, c: Constraint, others: Sequence[Constraint]) -> Reached:
        """The best value of c's quantity while the others hold, to 1e-4 of the limit."""
        if not others and (best := self.single(c)) is not None:
            return Reached(best, True)
        number = self.prove(others).number if others else self.grid.size - 1
        if number is None:
            return Reached(None, False)
        reached, limit = self.value(number, c), c.limit
        for _ in range(ROUNDS):
            if not math.isfinite(reached):
                return Reached(None, False)
            if abs(limit - reached) <= 1e-4 * abs(limit):
                return Reached(reached, True)
            middle = (reached + limit) / 2
            tried = self.prove([*others, replace(c, limit=middle)])
            if tried.number is not None:
                reached = self.value(tried.number, c)
            elif tried.outcome == IMPOSSIBLE:
                limit = middle
            else:
                return Reached(reached, False)
        return Reached(reached, True)

    def single(self, c: Constraint) -> float | None:
        """The best value of c's quantity by the corners alone; None where they do not tell."""
        best, sure = self.corner(*self.whole(), c)
        values = self.values(self.grid.number(best.T), c)
        if not sure.all() or not np.isfinite(values).all():
            return None
        return float(values.min() if c.most else values.max())

    def values(self, numbers: Numbers, c: Constraint) -> Array:
        """The quantity of a constraint, not of the stop, of designs by number."""
        return self.search.quantity(c.name, self.search.kernel.at(numbers, stop=False), numbers)

    def value(self, number: int, c: Constraint) -> float:
        """That of one design."""
        return float(self.values(np.array([number]), c)[0])


def _cut(low: Numbers, high: Numbers, first: Any) -> tuple[Numbers, Numbers]:
    """Every box cut in two along its longest side, counted in `first`."""
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
    """Why nothing meets a specification: constraints that exclude each other."""

    constraint: str | None
    """The one that fails; None where nothing can be built at all."""
    reason: str
    reachable: float | None = None
    """The best value of its quantity while the others hold."""
    unit: str = "1"
    others: tuple[str, ...] = ()
    """Those that must be given up for it; empty where it fails alone."""
    short: float = 0.0
    """By how much it is missed, over the limit."""


def impossible(
    search: Search, progress: Callable[[str, float], None] | None = None
) -> Exclusion | None:
    """The constraints that cannot be met together, None where that is not proved."""
    boxes = Boxes(search, progress)
    anything = Constraint("mass", False, 0.0)
    if boxes.prove([anything]).outcome == IMPOSSIBLE:
        return Exclusion(None, UNBUILDABLE)
    found = _physics(search)
    if found is not None:
        return found
    rules = list(search.spec.constraints)
    for c in rules:
        if boxes.prove([c]).outcome == IMPOSSIBLE:
            return _excluded(boxes, c, [])
    if boxes.prove(rules).outcome != IMPOSSIBLE:
        return None
    core = [c for c in rules if c.name not in LATE_MERITS]
    for c in tuple(core):
        rest = [o for o in core if o is not c]
        if boxes.prove(rest).outcome == IMPOSSIBLE:
            core = rest
    return min((_excluded(boxes, c, [o for o in core if o is not c]) for c in core), key=_shortfall)


def _shortfall(k: Exclusion) -> float:
    return math.inf if k.reachable is None or not math.isfinite(k.reachable) else k.short


def _excluded(boxes: Boxes, c: Constraint, others: list[Constraint]) -> Exclusion:
    reached = boxes.farthest(c, others)
    words = f" together with {' and '.join(map(str, others))}" if others else ""
    reason = f"{c} cannot be met{words}{by(c, reached.value, reached.exact)}"
    short = math.inf if reached.value is None else c.short(reached.value)
    return Exclusion(str(c), reason, reached.value, c.unit, tuple(map(str, others)), short)


def by(c: Constraint, reached: float | None, exact: bool = True) -> str:
    """By how much a constraint is missed, as the end of a sentence."""
    if reached is None or not math.isfinite(reached):
        return ""
    least = ("least" if c.most else "greatest") + (" reachable is" if exact else " found is")
    short = c.short(reached)
    words = f"{short:.2g} times the limit" if short > 2 else f"{short:.2%}"
    return f": the {least} {show(reached, c.unit)}, {words} {'over' if c.most else 'short'}"


def _physics(search: Search) -> Exclusion | None:
    """A stop that no brake of the grid, or none at all, could give."""
    wanted = search.spec.evaluation.stop
    if wanted is None or wanted.travel is None:
        return None
    soft = Boxes(search)
    least = soft.single(Constraint("stiffness", True, 1.0))
    if least is None or not least > 0:
        return None
    most = soft.single(Constraint("max_force", False, 1.0))
    force = min(f for f in (wanted.force, most, math.inf) if f is not None)
    if math.isinf(force):
        return None
    distance = wanted.travel + force / least
    fall = gravity(wanted, search.spec.evaluation.base)
    due = float(least_peak(wanted.mass, wanted.speed, distance, fall))
    slip = Constraint("stop_slip", True, wanted.travel)
    if wanted.force is not None and wanted.force < due:
        peak = Constraint("stop_peak", True, wanted.force)
        reason = (
            f"{peak} cannot be met by any brake: {show(wanted.mass, 'kg')} at "
            f"{show(wanted.speed, 'm/s')} within {show(distance, 'm')} (slip and stretch) take at "
            f"least {show(due, 'N')}"
        )
        return Exclusion(str(peak), reason, due, "N", (str(slip),))
    if most is not None and most < due:
        reason = (
            f"{slip} takes at least {show(due, 'N')}; the strongest of these brakes gives "
            f"{show(most, 'N')}"
        )
        return Exclusion(str(slip), reason, most, "N")
    brought = wanted.mass * wanted.speed**2 / 2
    c = Constraint("energy_capacity", False, brought - force**2 / (2 * least))
    if c.limit <= 0 or soft.prove([c]).outcome != IMPOSSIBLE:
        return None
    reached = soft.single(c)
    reason = (
        f"the mass brings {show(brought, 'J')}{by(c, reached)}: energy_capacity of the greatest of "
        "these brakes"
    )
    return Exclusion(str(c), reason, reached, "J")
