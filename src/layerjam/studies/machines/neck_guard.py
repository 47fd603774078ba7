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
import pandas

from layerjam.mechanics.pull import peak
from layerjam.studies.machines.injury import bric, concussion_risk, hic15
from layerjam.studies.machines.pulse import drive
from layerjam.studies.machines.readiness import VacuumSupply, readiness
from layerjam.studies.machines.restraint import (
    Body,
    Ride,
    Strap,
    Trial,
    first,
    least_stiffness,
    limiter_of,
    ride,
)
from layerjam.studies.machines.scenario import Array, declared
from layerjam.studies.machines.verdict import Machine, Result
from layerjam.units import nested, show

STEPS = 8000
"""Of a blow and four times its length after it."""
MOST = 200
"""Brakes side by side that are tried."""
STIFFER = 2.0 ** np.arange(11)
"""Multiples of the straps' stiffness that are tried."""


class Turned(NamedTuple):
    """One blow, in SI."""

    name: str
    ride: Ride
    angular: Array
    """Angular acceleration [rad/s^2]."""
    acceleration: float
    """The greatest."""
    speed: float
    rotation: float
    bric: float
    risk: float
    hic: float


class Record(NamedTuple):
    """For the pictures."""

    turned: tuple[Turned, ...]
    tried: pandas.DataFrame
    """Chains behind the straps there are, with the greatest angular acceleration `turns`."""


@declared("neck-guard")
class NeckGuard(Machine):
    """Everything of the scenario."""

    supply: VacuumSupply = nested(VacuumSupply)

    @property
    def inertia(self) -> float:
        """Moment of inertia with the helmet about the axis of turning [kg m^2]."""
        head = self.head
        own = head.mass * head.gyration**2 * head.helmet_factor
        return float(own + (head.mass + head.helmet_mass) * head.height**2)

    def trial(self) -> tuple[Trial, float]:
        """(the head under the blow, its change of angular velocity [rad/s] without brakes)."""
        blow, r = self.blow, self.guard.lever
        # a pulse of unit change over unit time has this peak
        unit = {"half-sine": math.pi / 2, "haversine": 2.0, "trapezoid": 1.25}[blow.pulse]
        change, after = blow.peak * blow.duration / unit, 4 * blow.duration
        free, dt, change = drive(blow.pulse, change, blow.duration, after, STEPS, Path())
        body = Body(self.inertia / r**2, 1.0, self.guard.slack)
        return Trial(self, body, self.guard.stiffness, free * r, dt), change

    def turned(self, name: str, trial: Trial, strap: Strap) -> Turned:
        """The head's turn under a blow, held by a strap."""
        r = self.guard.lever
        made = ride(trial.drive, trial.dt, trial.body, strap)
        angular = made.acceleration / r
        linear = head_acceleration(angular, made.speed / r, self.head.height)
        top, speed = float(np.abs(angular).max()), float(np.abs(made.speed).max()) / r
        rotation, injury = float(made.way.max()) / r, bric(y=speed)
        risk, hic = concussion_risk(injury), hic15(linear, trial.dt)
        return Turned(name, made, angular, top, speed, rotation, injury, risk, hic)

    def torque(self, chains: int) -> float:
        """Greatest torque [N m] of so many chains of brakes about the axis of turning."""
        brake = self.brake.brake
        top = peak(self.brakes.vacuum, brake.sheets.usable_travel, brake).force
        return chains * float(top) * self.guard.lever

    def analyse(self) -> Result:
        """The head's turn with and without brakes, how many it takes, whether they are ready."""
        brakes, lever = self.brakes, self.guard.lever
        trial, change = self.trial()
        strap = trial.strap()
        bare = self.turned("without brakes", trial, limiter_of(0.0, 1.0))
        guarded = self.turned("with brakes", trial, strap)
        shown, best = self.search(trial)
        ready = readiness(self, self.supply, brakes.vacuum)
        locked = self.torque(brakes.parallel)
        force, end = float(guarded.ride.force.max()), float(strap.travel) * brakes.series
        slip = float(guarded.ride.slip[-1])
        found = Result(scenario=self, record=Record((bare, guarded), shown), warnings=ready.said)
        found.add("kg m^2", inertia=self.inertia)
        found.add("rad/s", change=change)
        found.take("turn", bare._asdict(), "bare_")
        found.take("turn", guarded._asdict(), "")
        found.add("1", reduction=1 - guarded.acceleration / bare.acceleration)
        found.add("N", brake_force=force, neck_compression=force)
        found.add("N m", brake_torque=force * lever, locked_torque=locked)
        found.add("m", slip=slip, travel=end)
        found.add("1", bottomed_out=bool(slip >= end * (1 - 1e-9)))
        found.add("s", vacuum_time=ready.time)
        found.take("needed", best, "needed_")
        found.bound("N/m", stiffness=strap.stiffness, fall=least_stiffness(strap))
        found.bound("N m", felt=locked if self.supply.mode == "standing" else 0.0)
        found.warnings += [
            f"the brakes press head and neck together with up to {show(force, 'N')}; no limit for "
            "that was found in a source",
            "only the turning is modelled: HIC15 leaves the blow's straight push out",
        ]
        found.warnings += self.slid(slip, guarded.ride.pace)
        found.judge()
        found.limits += ready.limits
        found.brakes_needed = best.get("count")
        found.needed = self.needed(best, ready.time)
        return found

    def search(self, trial: Trial) -> tuple[pandas.DataFrame, dict[str, Any]]:
        """(1 to MOST chains behind the straps there are, the first number that is enough or {}).

        Where none does behind these straps (`as_built` False), behind the softest of STIFFER times
        them that will do, `stiffness`. Brakes that snap do not count.
        """
        counts, webbing = np.arange(1, MOST + 1), self.guard.stiffness * STIFFER
        rows = trial.tried(webbing=webbing, parallel=counts)
        rows["turns"] = rows.acceleration / self.guard.lever
        fine = rows[rows.sound & (rows.turns <= self.limits.acceleration)]
        shown = rows[rows.as_built]
        if fine.empty:
            return shown, {}
        best = first(fine, "webbing", "count")
        return shown, best | {
            "stiffness": best["webbing"],
            "torque": self.torque(best["parallel"]),
        }

    def needed(self, best: dict[str, Any], time: float) -> str:
        """What it would take, in sentences."""
        limit = show(self.limits.acceleration, "rad/s^2")
        ready = (
            f"Made on the blow itself, the vacuum would have to stand within a part of its "
            f"{show(self.blow.duration, 's')}; this line takes "
            f"{show(time, 's', 3) if math.isfinite(time) else 'for ever'}."
        )
        if not best:
            words = f"No number of brakes up to {MOST} side by side keeps the head below {limit}."
            return f"{words} {ready}"
        words = (
            f"It takes {best['count']} brakes ({show(best['mass'], 'kg')}) to keep the "
            f"head below {limit}"
        )
        if not best["as_built"]:
            words += (
                f", and straps of {show(best['stiffness'], 'N/m')}: those of "
                f"{show(self.guard.stiffness, 'N/m')} are too soft for any number to act in time"
            )
        return (
            f"{words}. Jammed all the time they hold the head with "
            f"{show(best['torque'], 'N m')}. {ready}"
        )


def head_acceleration(angular: Array, turning: Array, height: float) -> Array:
    """Size of the centre of gravity's acceleration [m/s^2], tangential and centripetal."""
    return height * np.hypot(angular, turning**2)
