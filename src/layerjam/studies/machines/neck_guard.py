"""Helmet and neck guard (paper, Fig. 13b): a blow turns the head, brakes to the shoulders hold it.

The helmeted head turns about one axis of the neck: I w' = t(t) - r T(r angle - slack), with t the
blow's torque, given as the angular acceleration it causes without brakes, and T the tension of the
brakes at their lever arm r. It is the strap of the seat belt with way = r angle and mass = I/r^2.
The neck's own stiffness and muscles, the shoulders' give and the head's straight motion are left
out; brakes hold one direction of turning only.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from layerjam.mechanics.pull import peak
from layerjam.studies.machines import restraint
from layerjam.studies.machines.injury import bric, concussion_risk, hic15
from layerjam.studies.machines.pulse import SHAPES, drive
from layerjam.studies.machines.readiness import MODE, VacuumSupply, readiness
from layerjam.studies.machines.restraint import Body, Ride, Strap, extremes, limiter_of, ride
from layerjam.studies.machines.scenario import Array, Brakes, Kind, Scenario, Word
from layerjam.studies.machines.verdict import Bound, Facts, Result
from layerjam.units import nested, quantity, record, show

STEPS = 8000
"""Of a blow and four times its length after it."""
MOST = 200
"""Brakes side by side that are tried."""
STIFFER = 2.0 ** np.arange(11)
"""Multiples of the straps' stiffness that are tried."""


@record
class Head:
    """The head with its helmet."""

    mass: float = quantity("kg", "mass of the head", lo=0.1, hi=50)
    gyration: float = quantity("m", "radius of gyration of the bare head", lo=1e-3, hi=1)
    helmet_mass: float = quantity("kg", "mass of the helmet", hi=20, default=0.0)
    helmet_factor: float = quantity(
        "1", "moment of inertia with the helmet over that without", lo=1, hi=10, default=1.0
    )
    height: float = quantity(
        "m", "from the axis of turning to the centre of gravity with helmet", hi=1
    )


@record
class Blow:
    """The blow, as the head would turn without brakes."""

    peak: float = quantity("rad/s^2", "greatest angular acceleration", open_lo=True, hi=1e6)
    duration: float = quantity("s", "length of the blow", lo=1e-4, hi=1)


@record
class Guard:
    """How the brakes are fastened."""

    lever: float = quantity("m", "lever arm of the brakes about the axis of turning", lo=1e-3, hi=1)
    stiffness: float = quantity("N/m", "stiffness of helmet, straps and vest", lo=100, hi=1e9)
    slack: float = quantity("m", "slack of the straps", hi=0.2, default=0.0)


@record
class NeckLimits:
    """What may not be exceeded."""

    acceleration: float = quantity("rad/s^2", "angular acceleration of the head", lo=1, hi=1e6)
    rotation: float = quantity("rad", "turn of the head", open_lo=True, hi=6.3)
    bric: float = quantity("1", "brain injury criterion", open_lo=True, hi=10)
    hic: float = quantity("1", "HIC15 of the head", open_lo=True, hi=1e5)
    free_torque: float = quantity(
        "N m", "torque the wearer may feel when turning the head at will", open_lo=True, hi=1e4
    )


@record
class NeckGuard:
    """Everything of the scenario."""

    head: Head = nested(Head)
    blow: Blow = nested(Blow)
    guard: Guard = nested(Guard)
    brakes: Brakes = nested(Brakes)
    supply: VacuumSupply = nested(VacuumSupply)
    limits: NeckLimits = nested(NeckLimits)


KIND = Kind(
    numbers=NeckGuard,
    words={
        "blow.pulse": Word(text="half-sine, haversine or trapezoid", choices=SHAPES),
        "supply.mode": MODE,
    },
)


class Turned(NamedTuple):
    """One blow, in SI."""

    name: str
    ride: Ride
    acceleration: Array
    """Angular [rad/s^2]."""
    peak: float
    speed: float
    rotation: float
    bric: float
    hic: float


class Record(NamedTuple):
    """For the pictures."""

    turned: tuple[Turned, ...]
    counts: Array
    peaks: Array
    """Greatest angular acceleration for so many brakes [rad/s^2]."""
    limits: NeckLimits
    lever: float


def inertia(head: Head) -> float:
    """Moment of inertia of the helmeted head about the axis of turning [kg m^2]."""
    own = head.mass * head.gyration**2 * head.helmet_factor
    return own + (head.mass + head.helmet_mass) * head.height**2


def blow_of(numbers: NeckGuard, shape: str) -> tuple[Array, float, float]:
    """(free angular acceleration [rad/s^2], the step [s], its change of angular velocity)."""
    # a pulse of unit change over unit time has this peak
    unit = {"half-sine": math.pi / 2, "haversine": 2.0, "trapezoid": 1.25}[shape]
    change = numbers.blow.peak * numbers.blow.duration / unit
    return drive(shape, change, numbers.blow.duration, 4 * numbers.blow.duration, STEPS, Path())


def head_acceleration(angular: Array, turning: Array, height: float) -> Array:
    """Size of the centre of gravity's acceleration [m/s^2], tangential and centripetal."""
    return height * np.hypot(angular, turning**2)


def turned(name: str, numbers: NeckGuard, free: Array, dt: float, strap: Strap) -> Turned:
    """The head's turn under a blow, held by a strap."""
    r = numbers.guard.lever
    body = Body(inertia(numbers.head) / r**2, 1.0, numbers.guard.slack)
    made = ride(free * r, dt, body, strap)
    angular = made.acceleration / r
    linear = head_acceleration(angular, made.speed / r, numbers.head.height)
    top, speed = float(np.abs(angular).max()), float(np.abs(made.speed).max()) / r
    rotation, injury = float(made.way.max()) / r, hic15(linear, dt)
    return Turned(name, made, angular, top, speed, rotation, bric(y=speed), injury)


def analyse(scenario: Scenario) -> Result:
    """The head's turn with and without brakes, how many it takes, and whether they are ready."""
    numbers: NeckGuard = scenario.numbers
    brakes = numbers.brakes
    free, dt, change = blow_of(numbers, scenario.words["blow.pulse"])
    strap = restraint.strap_of(
        brakes.parallel,
        brakes.series,
        brakes.vacuum,
        numbers.guard.stiffness,
        scenario.brake.brake,
    )
    bare = turned("without brakes", numbers, free, dt, limiter_of(0.0, 1.0))
    guarded = turned("with brakes", numbers, free, dt, strap)
    counts, peaks, need = search(scenario, free, dt)
    mode = scenario.words["supply.mode"]
    ready = readiness(scenario, numbers.supply, mode, brakes.vacuum, brakes.count, tuned=False)
    locked = brakes.parallel * _peak(scenario) * numbers.guard.lever
    force, end = float(guarded.ride.force.max()), float(strap.travel) * brakes.series
    slip = float(guarded.ride.slip[-1])
    own = Facts(scenario)
    own.add("kg m^2", inertia=inertia(numbers.head))
    own.add("rad/s", change=change)
    for prefix, one in (("bare_", bare), ("", guarded)):
        for unit, values in _numbers(one).items():
            own.add(unit, **{prefix + key: value for key, value in values.items()})
    own.add("1", reduction=1 - guarded.peak / bare.peak)
    own.add("N", brake_force=force, neck_compression=force)
    own.add("N m", brake_torque=force * numbers.guard.lever, locked_torque=locked)
    own.add("m", slip=slip, travel=end)
    own.add("1", bottomed_out=bool(slip >= end * (1 - 1e-9)))
    own.add("s", vacuum_time=ready.time)
    for unit, keys in NEEDED.items():
        own.add(unit, **{key: need[key] for key in keys})
    own.bound("N/m", stiffness=strap.stiffness, fall=strap.fall)
    own.bound("N m", felt=locked if mode == "standing" else 0.0)
    said = [
        *ready.said,
        f"the brakes press head and neck together with up to {show(force, 'N')}; no limit for that "
        "was found in a source",
        "only the turning is modelled: HIC15 leaves the blow's straight push out",
    ]
    return own.result(
        [*own.limits(BOUNDS), *ready.limits],
        brakes_needed=need["needed_count"],
        needed=_needed(need, scenario, ready.time),
        warnings=said,
        record=Record((bare, guarded), counts, peaks, numbers.limits, numbers.guard.lever),
    )


BOUNDS = (
    Bound("greatest angular acceleration of the head", "acceleration", "acceleration"),
    Bound("turn of the head", "rotation", "rotation"),
    Bound("BrIC", "bric", "bric"),
    Bound("HIC15 from turning alone", "hic", "hic"),
    Bound("stiffness of the straps, below which the brakes snap", "stiffness", "fall", least=True),
    Bound("torque against the wearer's own turning", "felt", "free_torque"),
)


def _peak(scenario: Scenario) -> float:
    """Greatest force of one brake [N]."""
    brake = scenario.brake.brake
    vacuum = scenario.numbers.brakes.vacuum
    return float(peak(vacuum, brake.sheets.usable_travel, brake).force)


def _numbers(made: Turned) -> dict[str, dict[str, float]]:
    """Of one blow, by unit and key."""
    return {
        "rad/s^2": {"acceleration": made.peak},
        "rad/s": {"speed": made.speed},
        "rad": {"rotation": made.rotation},
        "1": {"bric": made.bric, "risk": concussion_risk(made.bric), "hic": made.hic},
    }


def peaks_of(
    scenario: Scenario, free: Array, dt: float, counts: Any, webbing: Any
) -> tuple[Array, Any]:
    """(greatest angular acceleration [rad/s^2], whether it counts) for chains and straps [N/m].

    Brakes that snap do not count.
    """
    numbers: NeckGuard = scenario.numbers
    r = numbers.guard.lever
    straps = restraint.strap_of(
        counts, numbers.brakes.series, numbers.brakes.vacuum, webbing, scenario.brake.brake
    )
    body = Body(inertia(numbers.head) / r**2, 1.0, numbers.guard.slack)
    most = extremes(free[::4] * r, 4 * dt, body, straps)
    return most.acceleration / r, ~np.asarray(restraint.snaps(straps))


def search(scenario: Scenario, free: Array, dt: float) -> tuple[Array, Array, dict[str, Any]]:
    """Greatest angular acceleration for 1 to MOST chains, and the first number that keeps to it.

    Where none does behind the straps there are (`needed_as_built` False), behind the softest of
    STIFFER times them that will do, `needed_stiffness`.
    """
    numbers: NeckGuard = scenario.numbers
    counts, limit = np.arange(1, MOST + 1), numbers.limits.acceleration
    levels = numbers.guard.stiffness * STIFFER
    grid, lanes = (a.ravel() for a in np.meshgrid(levels, counts, indexing="ij"))
    peaks, sound = peaks_of(scenario, free, dt, lanes, grid)
    shown = counts.astype(float), peaks[:MOST]
    fine = np.flatnonzero((peaks <= limit) & sound)
    if not len(fine):
        return *shown, dict.fromkeys(key for keys in NEEDED.values() for key in keys)
    first, stiffness = int(lanes[fine[0]]), float(grid[fine[0]])
    count = first * numbers.brakes.series
    return *shown, {
        "needed_count": count,
        "needed_as_built": stiffness == numbers.guard.stiffness,
        "needed_mass": count * scenario.mass,
        "needed_torque": first * _peak(scenario) * numbers.guard.lever,
        "needed_stiffness": stiffness,
    }


NEEDED = {
    "1": ("needed_count", "needed_as_built"),
    "kg": ("needed_mass",),
    "N m": ("needed_torque",),
    "N/m": ("needed_stiffness",),
}
"""What it would take, by unit."""


def _needed(need: dict[str, Any], scenario: Scenario, time: float) -> str:
    numbers: NeckGuard = scenario.numbers
    limit = show(numbers.limits.acceleration, "rad/s^2")
    ready = (
        f"Made on the blow itself, the vacuum would have to stand within a part of its "
        f"{show(numbers.blow.duration, 's')}; this line takes "
        f"{show(time, 's', 3) if math.isfinite(time) else 'for ever'}."
    )
    if need["needed_count"] is None:
        return (
            f"No number of brakes up to {MOST} side by side keeps the head below {limit}. {ready}"
        )
    words = (
        f"It takes {need['needed_count']} brakes ({show(need['needed_mass'], 'kg')}) to keep the "
        f"head below {limit}"
    )
    if not need["needed_as_built"]:
        words += (
            f", and straps of {show(need['needed_stiffness'], 'N/m')}: those of "
            f"{show(numbers.guard.stiffness, 'N/m')} are too soft for any number to act in time"
        )
    return (
        f"{words}. Jammed all the time they hold the head with "
        f"{show(need['needed_torque'], 'N m')}. {ready}"
    )
