"""Seat belt (paper, Fig. 13a): an occupant thrown into a belt with brakes in it.

The part of the occupant that the shoulder belt holds is one mass. In the car's frame it is driven
by the car's deceleration and held by the belt: m x'' = m a(t) - g T(g x - slack), with T the belt's
tension, g the payout a metre of the chest's way (and so the chest's force over T). Airbag, knees,
pretensioner, chest compression and the lap belt's share are left out.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from layerjam.mechanics.energy import energy_capacity
from layerjam.studies.machines import restraint
from layerjam.studies.machines.injury import filtered
from layerjam.studies.machines.pulse import drive
from layerjam.studies.machines.readiness import MODE, VacuumSupply, readiness
from layerjam.studies.machines.restraint import (
    Body,
    Ride,
    Strap,
    extremes,
    limiter_of,
    ride,
)
from layerjam.studies.machines.scenario import Array, Brakes, Kind, Scenario, Word
from layerjam.studies.machines.verdict import Bound, Facts, Result
from layerjam.units import nested, quantity, record, show

STEPS, COARSE = 8000, 4
"""Steps of a run for the curves; the search takes every fourth."""
MOST_SERIES, MOST_PARALLEL = 24, 1024
STIFFER = 2.0 ** np.arange(9)
"""Multiples of the webbing's stiffness that are tried."""
LEVELS = 40
"""Vacuums tried for the tuned one."""


@record
class Occupant:
    """Who wears it."""

    mass: float = quantity("kg", "mass of the occupant", lo=1, hi=500)
    share: float = quantity("1", "part of the mass that this belt holds", lo=0.01, hi=1)


@record
class Crash:
    """The car's pulse."""

    change: float = quantity("m/s", "change of the car's velocity", lo=0.01, hi=100)
    duration: float = quantity("s", "length of the pulse", lo=1e-3, hi=2)


@record
class Belt:
    """The belt without the brakes."""

    stiffness: float = quantity("N/m", "stiffness of the belt's webbing", lo=100, hi=1e9)
    payout: float = quantity("1", "payout of the belt per displacement of the chest", lo=0.1, hi=3)
    slack: float = quantity("m", "slack of the belt", hi=0.5, default=0.0)


@record
class Filters:
    """Channel frequency classes of SAE J211-1 (60, 180, 600 or 1000)."""

    chest: int = quantity("1", "class for the chest's acceleration", lo=60, hi=1000, whole=True)
    belt: int = quantity("1", "class for the belt's force", lo=60, hi=1000, whole=True)


@record
class BeltLimits:
    """What may not be exceeded."""

    chest: float = quantity("m/s^2", "acceleration of the chest", open_lo=True, hi=1e5)
    belt: float = quantity("N", "force in the belt", open_lo=True, hi=1e6)
    space: float = quantity(
        "m", "displacement of the chest before it strikes something", lo=1e-3, hi=5
    )
    mass: float = quantity("kg", "mass of all brakes", open_lo=True, hi=1e3)


@record
class SeatBelt:
    """Everything of the scenario."""

    occupant: Occupant = nested(Occupant)
    crash: Crash = nested(Crash)
    belt: Belt = nested(Belt)
    brakes: Brakes = nested(Brakes)
    supply: VacuumSupply = nested(VacuumSupply)
    filter: Filters = nested(Filters)
    limits: BeltLimits = nested(BeltLimits)


KIND = Kind(
    numbers=SeatBelt,
    words={
        "crash.pulse": Word(text="half-sine, haversine, trapezoid or the path of a log"),
        "brakes.mode": Word(text="full or tuned vacuum", choices=("full", "tuned")),
        "supply.mode": MODE,
    },
)


class Held(NamedTuple):
    """One way of holding the occupant, in SI."""

    name: str
    ride: Ride
    chest: Array
    """Acceleration of the chest [m/s^2], filtered."""
    belt: Array
    """Force of the belt [N], filtered."""
    excursion: float
    peak_chest: float
    peak_belt: float
    bottomed: bool

    @property
    def loads(self) -> tuple[float, float, float]:
        """Excursion [m], peak of the chest [m/s^2] and of the belt [N]."""
        return self.excursion, self.peak_chest, self.peak_belt


class Record(NamedTuple):
    """For the pictures."""

    drive: Array
    dt: float
    held: tuple[Held, ...]
    counts: dict[str, Any]
    limits: BeltLimits


def held(name: str, scenario: Scenario, push: Array, dt: float, strap: Strap) -> Held:
    """The occupant in a strap, as a crash laboratory would read it."""
    numbers: SeatBelt = scenario.numbers
    body = body_of(numbers)
    made = ride(push, dt, body, strap)
    chest = filtered(made.force * numbers.belt.payout / float(body.mass), dt, numbers.filter.chest)
    belt = filtered(made.force, dt, numbers.filter.belt)
    end = float(strap.travel) * float(strap.series)
    bottomed = bool(made.slip[-1] >= end * (1 - 1e-9))
    way, most_chest, most_belt = (float(array.max()) for array in (made.way, chest, belt))
    return Held(name, made, chest, belt, way, most_chest, most_belt, bottomed)


def body_of(numbers: SeatBelt) -> Body:
    """The held part of the occupant."""
    mass = numbers.occupant.mass * numbers.occupant.share
    return Body(mass, numbers.belt.payout, numbers.belt.slack)


def analyse(scenario: Scenario) -> Result:
    """Loads and excursion with the brakes, with webbing alone and with the least limiter."""
    numbers: SeatBelt = scenario.numbers
    brakes, belt, words = numbers.brakes, numbers.belt, scenario.words
    # a constant force takes twice the space over the speed to stop; then the rebound
    after = numbers.crash.duration + 4 * numbers.limits.space / numbers.crash.change
    crash, pulse = numbers.crash, words["crash.pulse"]
    push, dt, change = drive(pulse, crash.change, crash.duration, after, STEPS, scenario.folder)
    coarse, long = push[::COARSE], COARSE * dt
    adjusts = words["brakes.mode"] == "tuned"
    vacuum = tuned(scenario, coarse, long) if adjusts else brakes.vacuum
    strap = restraint.strap_of(
        brakes.parallel, brakes.series, vacuum, belt.stiffness, scenario.brake.brake
    )
    force = least_limiter(scenario, coarse, long)
    ways = {
        "with brakes": strap,
        "webbing alone": limiter_of(math.inf, belt.stiffness),
        "limiter of constant force": limiter_of(force, belt.stiffness),
    }
    made = tuple(held(name, scenario, push, dt, way) for name, way in ways.items())
    need = search(scenario, coarse, long)
    mode = words["supply.mode"]
    ready = readiness(scenario, numbers.supply, mode, vacuum, brakes.count, tuned=adjusts)
    own, braked = Facts(scenario), made[0]
    for prefix, one in zip(("", "webbing_", "limiter_"), made, strict=True):
        for (unit, key), load in zip(LOADS.items(), one.loads, strict=True):
            own.add(unit, **{prefix + key: load})
    brake, end = scenario.brake.brake, float(strap.travel) * brakes.series
    own.add("N", chest_force=float(braked.ride.force.max()) * belt.payout, limiter_force=force)
    own.add("N", steady_force=belt.stiffness * brake.sheets.overlap)
    own.add("m", slip=float(braked.ride.slip[-1]), travel=end)
    own.add("1", bottomed_out=braked.bottomed, snaps=bool(restraint.snaps(strap)))
    own.add("J", energy_capacity=brakes.count * float(energy_capacity(brake)))
    own.add("J", energy_put_in=float(braked.ride.put_in.max()))
    own.add("J", energy_slipped=float(braked.ride.heat[-1]))
    own.add("Pa", vacuum=vacuum)
    own.add("m/s", change=change)
    own.add("s", vacuum_time=ready.time)
    for unit, keys in NEEDED.items():
        own.add(unit, **{key: need[key] for key in keys})
    own.bound("N/m", stiffness=strap.stiffness, fall=strap.fall)
    said = list(ready.said)
    if own.values["snaps"]:
        said.append("the belt is softer than the brakes' force falls: they snap through")
    if braked.bottomed:
        said.append(f"the brakes use up their {show(end, 'm')}; behind it the belt holds on stops")
    return own.result(
        [*own.limits(BOUNDS), *ready.limits],
        brakes_needed=need["needed_count"],
        needed=_needed(need, scenario, force),
        warnings=said,
        record=Record(push, dt, made, need, numbers.limits),
    )


BOUNDS = (
    Bound("displacement of the chest", "excursion", "space"),
    Bound("acceleration of the chest", "chest_acceleration", "chest"),
    Bound("force in the belt", "belt_force", "belt"),
    Bound("stiffness of the belt, below which the brakes snap", "stiffness", "fall", least=True),
    Bound("mass of the brakes", "mass", "mass"),
)
LOADS = {"m": "excursion", "m/s^2": "chest_acceleration", "N": "belt_force"}
"""Keys of a way of holding, by unit."""


def tuned(scenario: Scenario, push: Array, dt: float) -> float:
    """The least vacuum [Pa] of LEVELS at which the occupant stops in the space and on travel left.

    Up to `brakes.vacuum`, which stands where no less will do.
    """
    numbers: SeatBelt = scenario.numbers
    brakes = numbers.brakes
    levels = brakes.vacuum * np.arange(1, LEVELS + 1) / LEVELS
    straps = restraint.strap_of(
        brakes.parallel, brakes.series, levels, numbers.belt.stiffness, scenario.brake.brake
    )
    most = extremes(push, dt, body_of(numbers), straps)
    end = brakes.series * scenario.brake.brake.sheets.usable_travel
    fine = (most.way <= numbers.limits.space) & (most.end_speed <= 0)
    fine &= most.slip < end * (1 - 1e-9)
    return float(levels[int(np.argmax(fine))]) if fine.any() else brakes.vacuum


def least_limiter(scenario: Scenario, push: Array, dt: float) -> float:
    """The least constant force [N] that stops the occupant within the space, by 40 halvings.

    Where even stiff webbing does not, the limiter never limits: infinite.
    """
    numbers: SeatBelt = scenario.numbers
    body, space = body_of(numbers), numbers.limits.space
    high = float(extremes(push, dt, body, limiter_of(math.inf, numbers.belt.stiffness)).force)
    if float(extremes(push, dt, body, limiter_of(high, numbers.belt.stiffness)).way) > space:
        return math.inf
    low = 0.0
    for _ in range(5):
        # 256 at once, five times: to a part in 10^12
        forces = np.linspace(low, high, 257)[1:]
        way = extremes(push, dt, body, limiter_of(forces, numbers.belt.stiffness)).way
        first = int(np.argmax(way <= space))
        low, high = (low if first == 0 else float(forces[first - 1])), float(forces[first])
    return high


class Row(NamedTuple):
    """A belt that was tried: its webbing [N/m], brakes, and what the occupant felt."""

    webbing: float
    series: int
    parallel: int
    way: float
    chest: float
    belt: float

    @property
    def brakes(self) -> int:
        """Brakes in all."""
        return self.series * self.parallel

    def inside(self, limits: BeltLimits) -> bool:
        """Whether chest and belt stay in their limits."""
        return self.chest <= limits.chest and self.belt <= limits.belt


def tried(
    scenario: Scenario, push: Array, dt: float, webbing: Any, series: Any, parallel: Any
) -> list[Row]:
    """The belts, of webbings [N/m] and numbers of brakes, that stop in the space on travel left.

    Belts in which the brakes may snap do not count.
    """
    numbers: SeatBelt = scenario.numbers
    brake = scenario.brake.brake
    webbing, series, parallel = (a.ravel() for a in np.meshgrid(webbing, series, parallel))
    straps = restraint.strap_of(parallel, series, numbers.brakes.vacuum, webbing, brake)
    most = extremes(push, dt, body_of(numbers), straps)
    left = most.slip < series * brake.sheets.usable_travel * (1 - 1e-9)
    stops = (most.way <= numbers.limits.space) & (most.end_speed <= 0) & left
    stops &= ~np.asarray(restraint.snaps(straps))
    return [
        Row(
            float(webbing[i]),
            int(series[i]),
            int(parallel[i]),
            *(float(array[i]) for array in (most.way, most.held, most.force)),
        )
        for i in np.flatnonzero(stops)
    ]


def search(scenario: Scenario, push: Array, dt: float) -> dict[str, Any]:
    """How many brakes it takes: a grid of chains, then every number near the best.

    Of the belts that stop the occupant in the space without using up their travel, the fewest
    brakes that also keep chest and belt in their limits; where none does, the fewest that stop
    (`needed_meets_loads` False). Where none stops behind the webbing there is (`needed_as_built`
    False), behind the softest of STIFFER times it that will do (`needed_stiffness`). None where
    nothing does. `least_belt_force` is the least of all belts of the grid.
    """
    numbers: SeatBelt = scenario.numbers
    limits = numbers.limits
    # a chain longer than the whole payout of the space is never used up
    end = scenario.brake.brake.sheets.usable_travel
    longest = math.ceil(limits.space * numbers.belt.payout / end) + 1
    series = np.arange(1, min(max(longest, 2), MOST_SERIES) + 1)
    parallel = np.unique(np.round(np.geomspace(1, MOST_PARALLEL, 40))).astype(int)
    rows = tried(scenario, push, dt, numbers.belt.stiffness * STIFFER, series, parallel)
    if not rows:
        return dict.fromkeys(key for keys in NEEDED.values() for key in keys)
    softest = min(row.webbing for row in rows)
    best = _best([row for row in rows if row.webbing == softest], limits)
    at = int(np.searchsorted(parallel, best.parallel))
    near = np.arange(parallel[max(at - 1, 0)], best.parallel + 1)
    best = _best([best, *tried(scenario, push, dt, softest, best.series, near)], limits)
    least = min(rows, key=lambda row: row.belt)
    return {
        "needed_series": best.series,
        "needed_parallel": best.parallel,
        "needed_count": best.brakes,
        "needed_meets_loads": best.inside(limits),
        "needed_as_built": best.webbing == numbers.belt.stiffness,
        "least_belt_force_count": least.brakes,
        "needed_mass": best.brakes * scenario.mass,
        "needed_excursion": best.way,
        "needed_chest_acceleration": best.chest,
        "needed_belt_force": best.belt,
        "least_belt_force": least.belt,
        "needed_stiffness": best.webbing,
    }


_COUNTS = "needed_series needed_parallel needed_count needed_meets_loads needed_as_built"
NEEDED = {
    "1": (*_COUNTS.split(), "least_belt_force_count"),
    "kg": ("needed_mass",),
    "m": ("needed_excursion",),
    "m/s^2": ("needed_chest_acceleration",),
    "N": ("needed_belt_force", "least_belt_force"),
    "N/m": ("needed_stiffness",),
}
"""What it would take, by unit."""


def _best(rows: list[Row], limits: BeltLimits) -> Row:
    """The fewest brakes among those within the loads, else among all."""
    inside = [row for row in rows if row.inside(limits)]
    return min(inside or rows, key=lambda row: (row.brakes, row.belt))


def _needed(need: dict[str, Any], scenario: Scenario, force: float) -> str:
    """What it would take, as a sentence."""
    numbers: SeatBelt = scenario.numbers
    if need["needed_count"] is None:
        return (
            f"No number of brakes up to {MOST_PARALLEL} side by side stops the occupant within "
            f"{show(numbers.limits.space, 'm')}."
        )
    words = (
        f"It takes {need['needed_count']} brakes ({need['needed_parallel']} side by side, "
        f"{need['needed_series']} in a row, {show(need['needed_mass'], 'kg')}) to stop in the "
        f"space at hand, with {show(need['needed_belt_force'], 'N')} in the belt and "
        f"{show(need['needed_chest_acceleration'], 'm/s^2')} of the chest"
    )
    if not need["needed_as_built"]:
        steady = numbers.belt.stiffness * scenario.brake.brake.sheets.overlap
        words += (
            f", and webbing of {show(need['needed_stiffness'], 'N/m')}: behind webbing of "
            f"{show(numbers.belt.stiffness, 'N/m')} brakes of this overlap slide steadily up to "
            f"{show(steady, 'N')} only, and snap beyond"
        )
    if not need["needed_meets_loads"]:
        words += (
            f". No number of these brakes keeps the loads too: the least force in the belt is "
            f"{show(need['least_belt_force'], 'N')}, with {need['least_belt_force_count']} of them"
        )
    if force > numbers.limits.belt:
        words += (
            f". Even an ideal limiter of constant force needs {show(force, 'N')} in this space, "
            f"more than the {show(numbers.limits.belt, 'N')} allowed"
        )
    return words + "."
