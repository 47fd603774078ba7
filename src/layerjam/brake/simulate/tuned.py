"""Search for the vacuum that stops a mass after a given travel, and advice if there is none.

The function `tuned_stop` determines whether a case can be tuned. All advice is tested: a search
over many cases finds it, and a test of the single case confirms it.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.mount import Rope
from layerjam.brake.mechanics.speed_effects import depends_on_speed, remove_idle_speed_law
from layerjam.brake.mechanics.stop.tune import speed_range, tuned_stop
from layerjam.brake.simulate.quantities import ARRIVAL_SPEED, MASS, STOP_TRAVEL
from layerjam.core.evolve import evolve
from layerjam.core.units import get_spec

Array = npt.NDArray[np.float64]
MOST_SHEETS, MOST_BRAKES = 499, 999
TRAVELS = SPEEDS = 500
"""Number of travels and speeds tried, and number of further ones between two neighbours."""
NEAREST = 128
"""Number of values that a search for the first one tries at once before all others."""
FEW = 65
"""Number of cases per call if every stop must be integrated, so that the law compiles once."""
MARGINS = np.array([1e-12, 1e-9, 1e-6, 1e-3])
"""Relative distances from the ends of a range at which a speed is tried."""
DIGITS = 4
"""Number of significant digits of a suggested travel, which users read and type."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A mass to be stopped, the slip after which it stops, and number of parallel brakes; SI."""

    brake: Brake
    mass: float
    speed: float
    travel: float
    gravity: float
    """Gravity along the pull."""
    rope: float | None = None
    share: int = 1
    """Number of parallel brakes."""

    def with_changes(self, **changes: Any) -> "Case":
        """Return the case with a different `speed`, `travel`, `share`, or `count` of sheets."""
        count = changes.pop("count", None)
        if count is not None:
            sheets = evolve(self.brake.sheets, count=count)
            changes["brake"] = evolve(self.brake, sheets=sheets)
        return evolve(self, **changes)

    def values_per_brake(self) -> tuple[Any, ...]:
        """Return the arguments of `tuned_stop`: each brake carries its share of mass and rope."""
        rope = None if self.rope is None else self.rope / self.share
        mass = self.mass / self.share
        return (mass, self.speed, self.travel, rope, self.gravity, self.brake)


def tuning_vacuum(case: Case) -> float | None:
    """Return the vacuum [Pa] that stops the mass after exactly the travel, or None."""
    vacuum = float(np.ravel(tuned_stop(*_tuning_arguments(case)))[0])
    return vacuum if math.isfinite(vacuum) else None


def _tuning_arguments(case: Case) -> tuple[Any, ...]:
    """Return the arguments of `tuned_stop`, all of the same shape if every stop is integrated."""
    mass, speed, travel, rope, gravity, brake = case.values_per_brake()
    if not depends_on_speed(brake):
        return mass, speed, travel, rope, gravity, remove_idle_speed_law(brake)
    mass, speed, travel = (np.zeros(FEW) + value for value in (mass, speed, travel))
    return mass, speed, travel, rope, gravity, brake


def _count_values(case: Case, usual: int) -> int:
    return FEW if depends_on_speed(case.brake) else usual


def _split(case: Case, values: Array, first: int) -> list[Array]:
    """Return the values in the parts that are tried at once; the `first` ones come alone."""
    if depends_on_speed(case.brake):
        return [values[i : i + FEW] for i in range(0, len(values), FEW)]
    return [part for part in (values[:first], values[first:]) if part.size]


def can_tune(case: Case, name: str, values: Array) -> npt.NDArray[np.bool_]:
    """Return whether the case can be tuned with each of several values of one quantity."""
    parts = _split(case, values, len(values))
    return np.concatenate([_can_tune_part(case, name, part) for part in parts])


def _can_tune_part(case: Case, name: str, values: Array) -> npt.NDArray[np.bool_]:
    defaults = {
        "count": float(case.brake.sheets.count),
        "speed": case.speed,
        "travel": case.travel,
        "share": float(case.share),
    }
    size = _count_values(case, len(values))
    columns: dict[str, Any] = {key: np.full(size, value) for key, value in defaults.items()}
    columns[name][: len(values)] = values
    vacuums = np.asarray(tuned_stop(*_tuning_arguments(case.with_changes(**columns))))
    return np.isfinite(vacuums)[: len(values)]


def _first_tunable_value(case: Case, name: str, values: Array) -> Any:
    """Return the first value with which the single case can be tuned, or None."""
    for part in _split(case, values, NEAREST):
        for value in part[_can_tune_part(case, name, part)].tolist():
            if tuning_vacuum(case.with_changes(**{name: value})) is not None:
                return value
    return None


def suggest_travel(case: Case) -> float | None:
    """Return the nearest shorter travel [m] that works, or the nearest longer one, or None."""
    usable = case.brake.sheets.usable_travel
    count = _count_values(case, TRAVELS)
    grid = np.linspace(0.0, usable, count + 1)[1:]
    shorter, longer = grid[grid < case.travel][::-1], grid[grid > case.travel]
    for side in (shorter, longer):
        tunable_indices = np.flatnonzero(can_tune(case, "travel", side)) if side.size else side
        if not tunable_indices.size:
            continue
        k = int(tunable_indices[0])
        travel_before = side[k - 1] if k else case.travel
        candidates = _round_travels(np.linspace(travel_before, side[k], count + 1)[1:], usable)
        travel = _first_tunable_value(case, "travel", candidates[candidates != case.travel])
        if travel is not None:
            return float(travel)
    return None


def _round_travels(travels: Array, usable: float) -> Array:
    values = np.array([float(f"{x:.{DIGITS}g}") for x in travels.tolist()])
    min_travel = STOP_TRAVEL.lo
    return values[(values <= usable) & (values >= min_travel)]


def suggest_sheet_count(case: Case) -> int | None:
    """Return the next larger number of sheets that works, otherwise the nearest smaller one."""
    count = case.brake.sheets.count
    greater, fewer = range(count + 1, MOST_SHEETS + 1), range(min(count - 1, MOST_SHEETS), 1, -1)
    number = _first_tunable_value(case, "count", np.array([*greater, *fewer], float))
    return None if number is None else int(number)


def suggest_brake_count(case: Case) -> int | None:
    """Return the smallest number of parallel brakes that works, each with its share of the rope."""
    limit = min(float(MOST_BRAKES), case.mass / MASS.lo)
    if case.rope is not None:
        limit = min(limit, case.rope / get_spec(Rope, "stiffness").lo)
    shares = np.arange(2.0, limit + 1)
    share = _first_tunable_value(case, "share", shares) if shares.size else None
    return None if share is None else int(share)


def balanced_speeds(case: Case) -> tuple[float, float]:
    """Return the limits [m/s] of speeds with an energy balance; NaN if the weight cannot be held.

    On a soft rope, the mass uses up the travel at only some of these speeds; `find_tunable_speeds`
    returns those at which it does.
    """
    mass, _, travel, rope, gravity, brake = _tuning_arguments(case)
    low, high = speed_range(mass, travel, rope, gravity, brake)
    return float(np.ravel(low)[0]), float(np.ravel(high)[0])


def find_tunable_speeds(case: Case) -> tuple[float, float] | None:
    """Return the lowest and highest arrival speed [m/s] that some vacuum stops, or None.

    Both ends are tested, as are speeds in between. If some fail, the result is the longest range
    without a gap.
    """
    low, high = balanced_speeds(case)
    low, high = max(low, ARRIVAL_SPEED.lo), min(high, ARRIVAL_SPEED.hi)
    if not low <= high:
        return None
    count = _count_values(case, SPEEDS)
    interior = np.linspace(low, high, count)[1:-1]
    grid = np.unique([*low * (1 + MARGINS), *interior, *high * (1 - MARGINS)])
    grid = grid[(grid >= low) & (grid <= high)]
    is_tunable = can_tune(case, "speed", grid)
    if not is_tunable.any():
        return None
    first, last = _longest_run(is_tunable)
    slowest, fastest = grid[first], grid[last]
    if first:
        slowest = _last_tunable_value(case, np.linspace(slowest, grid[first - 1], count))
    if last + 1 < len(grid):
        fastest = _last_tunable_value(case, np.linspace(fastest, grid[last + 1], count))
    ends = tuple(_confirm_end(case, v, grid[(first + last) // 2]) for v in (slowest, fastest))
    return None if None in ends else (ends[0], ends[1])  # type: ignore[return-value]


def _longest_run(is_tunable: npt.NDArray[np.bool_]) -> tuple[int, int]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_tunable.astype(int), [0]])))
    starts, ends = edges[::2], edges[1::2]
    k = int(np.argmax(ends - starts))
    return int(starts[k]), int(ends[k]) - 1


def _last_tunable_value(case: Case, values: Array) -> float:
    is_tunable = can_tune(case, "speed", values)
    fails = np.flatnonzero(~is_tunable)
    return float(values[max(int(fails[0]) - 1, 0)] if fails.size else values[-1])


def _confirm_end(case: Case, end: float, middle: float) -> float | None:
    """Return the end of the range, or the nearest value inside it for which tuning succeeds."""
    margins: Iterator[float] = iter((0.0, *MARGINS.tolist()))
    tries = (float(end + (middle - end) * margin) for margin in margins)
    cases = ((v, case.with_changes(speed=v)) for v in tries)
    return next((v for v, c in cases if tuning_vacuum(c) is not None), None)
