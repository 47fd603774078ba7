"""The vacuum that stops a mass after a travel, tried; and what would do where there is none.

One function, `tuned_stop`, says whether a case can be tuned. Whatever is advised has passed it: a
search over many cases finds it, and the case by itself confirms it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.device.brake import Brake
from layerjam.device.mount import Rope
from layerjam.mechanics.stop.tune import speed_range, tuned_stop
from layerjam.simulate.quantities import ARRIVAL_SPEED, MASS, STOP_TRAVEL
from layerjam.simulate.speed import counted, follows_speed
from layerjam.units import spec_of

Array = npt.NDArray[np.float64]
MOST_SHEETS, MOST_BRAKES = 499, 999
TRAVELS = SPEEDS = 500
"""Travels of the brake that are tried, and speeds; as many again between two of them."""
AT_ONCE = 1024
"""Cases of one call: always as many, so that the law is compiled once."""
FEW = 65
"""The same, and the number of travels and speeds, where every stop has to be integrated."""
MARGINS = np.array([1e-12, 1e-9, 1e-6, 1e-3])
"""How far inside the ends of a range of speeds a speed is tried, over that end."""
DIGITS = 4
"""Of an advised travel, which is read and typed again."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """What is to be stopped, after which slip, by how many brakes side by side; SI."""

    brake: Brake
    mass: float
    speed: float
    travel: float
    gravity: float
    """Along the pull."""
    rope: float | None = None
    share: int = 1
    """Brakes side by side."""

    def but(self, **other: Any) -> Case:
        """The case with another `speed`, `travel`, `share`, or `count` of sheets."""
        count = other.pop("count", None)
        if count is not None:
            sheets = replace(self.brake.sheets, count=count)
            other["brake"] = replace(self.brake, sheets=sheets)
        return replace(self, **other)

    def of_one(self) -> tuple[Any, ...]:
        """What `tuned_stop` takes: each brake bears its share of mass and rope."""
        rope = None if self.rope is None else self.rope / self.share
        mass = self.mass / self.share
        return (mass, self.speed, self.travel, rope, self.gravity, self.brake)


def tuned(case: Case) -> float | None:
    """The vacuum [Pa] that stops the mass after just the travel; None where there is none."""
    found = float(np.ravel(tuned_stop(*_placed(case)))[0])
    return found if math.isfinite(found) else None


def _placed(case: Case) -> tuple[Any, ...]:
    """What `tuned_stop` takes; where every stop is integrated, always of one shape."""
    mass, speed, travel, rope, gravity, brake = case.of_one()
    if not follows_speed(brake):
        return mass, speed, travel, rope, gravity, counted(brake)
    mass, speed, travel = (np.zeros(FEW) + value for value in (mass, speed, travel))
    return mass, speed, travel, rope, gravity, brake


def _at_once(case: Case, whole: int = AT_ONCE) -> int:
    """How many cases are tried in one call."""
    return FEW if follows_speed(case.brake) else whole


def tried(case: Case, name: str, values: Array) -> npt.NDArray[np.bool_]:
    """Whether the case can be tuned with each of other values of one of its numbers."""
    size = _at_once(case)
    pieces = [values[i : i + size] for i in range(0, len(values), size)]
    return np.concatenate([_tried(case, name, piece, size) for piece in pieces])


def _tried(case: Case, name: str, values: Array, size: int) -> npt.NDArray[np.bool_]:
    usual = {
        "count": float(case.brake.sheets.count),
        "speed": case.speed,
        "travel": case.travel,
        "share": float(case.share),
    }
    columns: dict[str, Any] = {key: np.full(size, value) for key, value in usual.items()}
    columns[name][: len(values)] = values
    found = np.asarray(tuned_stop(*_placed(case.but(**columns))))
    return np.isfinite(found)[: len(values)]


def _first(case: Case, name: str, values: Array) -> Any:
    """The first of the values with which the case can be tuned, by itself too; None for none."""
    size = _at_once(case)
    for i in range(0, len(values), size):
        piece = values[i : i + size]
        for value in piece[tried(case, name, piece)].tolist():
            if tuned(case.but(**{name: value})) is not None:
                return value
    return None


def other_travel(case: Case) -> float | None:
    """The nearest shorter travel [m] that would do, else the nearest longer one; None for none."""
    usable = case.brake.sheets.usable_travel
    count = _at_once(case, TRAVELS)
    grid = np.linspace(0.0, usable, count + 1)[1:]
    shorter, longer = grid[grid < case.travel][::-1], grid[grid > case.travel]
    for side in (shorter, longer):
        fine = np.flatnonzero(tried(case, "travel", side)) if side.size else side
        if not fine.size:
            continue
        k = int(fine[0])
        before = side[k - 1] if k else case.travel
        near = _typed(np.linspace(before, side[k], count + 1)[1:], usable)
        found = _first(case, "travel", near[near != case.travel])
        if found is not None:
            return float(found)
    return None


def _typed(travels: Array, usable: float) -> Array:
    """Travels [m] as they are read and typed again, within what can be asked for."""
    rounded = np.array([float(f"{x:.{DIGITS}g}") for x in travels.tolist()])
    least = STOP_TRAVEL.lo
    return rounded[(rounded <= usable) & (rounded >= least)]


def other_sheets(case: Case) -> int | None:
    """The least greater number of sheets that would do, else the nearest smaller one."""
    count = case.brake.sheets.count
    more, fewer = range(count + 1, MOST_SHEETS + 1), range(min(count - 1, MOST_SHEETS), 1, -1)
    found = _first(case, "count", np.array([*more, *fewer], float))
    return None if found is None else int(found)


def more_brakes(case: Case) -> int | None:
    """The least number of brakes side by side that would do, each with its share of the rope."""
    most = min(float(MOST_BRAKES), case.mass / MASS.lo)
    if case.rope is not None:
        most = min(most, case.rope / spec_of(Rope, "stiffness").lo)
    shares = np.arange(2.0, most + 1)
    found = _first(case, "share", shares) if shares.size else None
    return None if found is None else int(found)


def balanced_speeds(case: Case) -> tuple[float, float]:
    """Speeds [m/s] between which the balance can be met; NaN where the weight cannot be held.

    On a soft rope the mass does not get there from all of them: `speeds` are those that do.
    """
    mass, _, travel, rope, gravity, brake = _placed(case)
    low, high = speed_range(mass, travel, rope, gravity, brake)
    return float(np.ravel(low)[0]), float(np.ravel(high)[0])


def speeds(case: Case) -> tuple[float, float] | None:
    """Slowest and fastest arrival [m/s] stopped after just the travel by some vacuum, or None.

    Both are tried. Where some in between fail, the longest run without a gap.
    """
    low, high = balanced_speeds(case)
    low, high = max(low, ARRIVAL_SPEED.lo), min(high, ARRIVAL_SPEED.hi)
    if not low <= high:
        return None
    count = _at_once(case, SPEEDS)
    inside = np.linspace(low, high, count)[1:-1]
    grid = np.unique([*low * (1 + MARGINS), *inside, *high * (1 - MARGINS)])
    grid = grid[(grid >= low) & (grid <= high)]
    fine = tried(case, "speed", grid)
    if not fine.any():
        return None
    first, last = _longest_run(fine)
    slowest, fastest = grid[first], grid[last]
    if first:
        slowest = _last(case, np.linspace(slowest, grid[first - 1], count))
    if last + 1 < len(grid):
        fastest = _last(case, np.linspace(fastest, grid[last + 1], count))
    ends = tuple(_alone(case, v, grid[(first + last) // 2]) for v in (slowest, fastest))
    return None if None in ends else (ends[0], ends[1])  # type: ignore[return-value]


def _longest_run(fine: npt.NDArray[np.bool_]) -> tuple[int, int]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], fine.astype(int), [0]])))
    starts, ends = edges[::2], edges[1::2]
    k = int(np.argmax(ends - starts))
    return int(starts[k]), int(ends[k]) - 1


def _last(case: Case, values: Array) -> float:
    """The last of the values before the first that fails; the first itself is known to do."""
    fine = tried(case, "speed", values)
    fails = np.flatnonzero(~fine)
    return float(values[max(int(fails[0]) - 1, 0)] if fails.size else values[-1])


def _alone(case: Case, end: float, middle: float) -> float | None:
    """The end of the range, or as little inside it as its own trial asks for."""
    margins: Iterator[float] = iter((0.0, *MARGINS.tolist()))
    near = (float(end + (middle - end) * margin) for margin in margins)
    return next((v for v in near if tuned(case.but(speed=v)) is not None), None)
