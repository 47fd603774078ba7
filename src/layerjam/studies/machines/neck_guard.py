"""Helmet and neck guard (paper, Fig. 13b): brakes restrain a head that a blow turns.

The head with its helmet turns about one axis of the neck: I w' = t(t) - r T(r angle - slack). t is
the torque of the blow, given as the angular acceleration without brakes, and T the tension of the
brakes at their lever arm r. The equation is that of the seat belt's strap, with travel = r angle
and mass = I/r^2. The stiffness and muscles of the neck, the compliance of the shoulders and the
linear motion of the head are ignored. The brakes resist rotation in one direction only.
"""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas

from layerjam.brake.mechanics.pull import peak
from layerjam.core.units import nested, show
from layerjam.studies.machines.injury import bric, concussion_risk, hic15
from layerjam.studies.machines.pulse import make_drive
from layerjam.studies.machines.readiness import VacuumSupply, check_readiness
from layerjam.studies.machines.restraint import (
    Body,
    Ride,
    Strap,
    Trial,
    best_row,
    least_stiffness,
    make_limiter,
    simulate_ride,
)
from layerjam.studies.machines.scenario import Array, declare_fields
from layerjam.studies.machines.verdict import Machine, Result

STEPS = 8000
"""Number of time steps for a blow and for the period after it, which is four times as long."""
CHAIN_LIMIT = 200
"""Largest number of parallel brakes examined."""
STIFFER = 2.0 ** np.arange(11)
"""Factors by which stiffer straps are examined."""


class HeadTurn(NamedTuple):
    """Response to one blow, in SI units."""

    name: str
    ride: Ride
    angular: Array
    """Angular acceleration [rad/s^2]."""
    acceleration: float
    """Maximum acceleration of the head [m/s^2]."""
    speed: float
    rotation: float
    bric: float
    risk: float
    hic: float


class Record(NamedTuple):
    """Data for the pictures."""

    turned: tuple[HeadTurn, ...]
    tried: pandas.DataFrame
    """One row per number of chains of existing straps; `turns`: peak angular acceleration."""


@declare_fields("neck-guard")
class NeckGuard(Machine):
    """Neck guard with all data of its scenario."""

    supply: VacuumSupply = nested(VacuumSupply)

    @property
    def inertia(self) -> float:
        """Moment of inertia, with the helmet, about the axis of rotation [kg m^2]."""
        head = self.head
        about_center = head.mass * head.gyration**2 * head.helmet_factor
        return float(about_center + (head.mass + head.helmet_mass) * head.height**2)

    def make_trial(self) -> tuple[Trial, float]:
        """Return (trial of the head under the blow, change in angular velocity [rad/s])."""
        blow, r = self.blow, self.guard.lever
        # peak of a pulse with unit velocity change in unit time
        unit = {"half-sine": math.pi / 2, "haversine": 2.0, "trapezoid": 1.25}[blow.pulse]
        change, time_after = blow.peak * blow.duration / unit, 4 * blow.duration
        free, dt, change = make_drive(blow.pulse, change, blow.duration, time_after, STEPS, Path())
        body = Body(self.inertia / r**2, 1.0, self.guard.slack)
        return Trial(self, body, self.guard.stiffness, free * r, dt), change

    def simulate_turn(self, name: str, trial: Trial, strap: Strap) -> HeadTurn:
        """Return the motion of a head that is restrained by a strap during a blow."""
        r = self.guard.lever
        ride_made = simulate_ride(trial.drive, trial.dt, trial.body, strap)
        angular = ride_made.acceleration / r
        linear = head_acceleration(angular, ride_made.speed / r, self.head.height)
        top, speed = float(np.abs(angular).max()), float(np.abs(ride_made.speed).max()) / r
        rotation, injury = float(ride_made.way.max()) / r, bric(y=speed)
        risk, hic = concussion_risk(injury), hic15(linear, trial.dt)
        return HeadTurn(name, ride_made, angular, top, speed, rotation, injury, risk, hic)

    def torque(self, chains: int) -> float:
        """Return the maximum torque [N m] of `chains` of brakes about the axis of rotation."""
        brake = self.brake.brake
        top = peak(self.brakes.vacuum, brake.sheets.usable_travel, brake).force
        return chains * float(top) * self.guard.lever

    def analyse(self) -> Result:
        """Analyse the head's rotation with and without brakes, their number and their readiness."""
        brakes, lever = self.brakes, self.guard.lever
        trial, change = self.make_trial()
        strap = trial.strap()
        bare_turn = self.simulate_turn("without brakes", trial, make_limiter(0.0, 1.0))
        with_brakes = self.simulate_turn("with brakes", trial, strap)
        table, best = self.find_chains(trial)
        ready = check_readiness(self, self.supply, brakes.vacuum)
        locked_torque = self.torque(brakes.parallel)
        force, end = float(with_brakes.ride.force.max()), float(strap.travel) * brakes.series
        slip = float(with_brakes.ride.slip[-1])
        result = Result(
            scenario=self, record=Record((bare_turn, with_brakes), table), warnings=ready.notices
        )
        result.add("kg m^2", inertia=self.inertia)
        result.add("rad/s", change=change)
        result.add_group("turn", bare_turn._asdict(), "bare_")
        result.add_group("turn", with_brakes._asdict(), "")
        result.add("1", reduction=1 - with_brakes.acceleration / bare_turn.acceleration)
        result.add("N", brake_force=force, neck_compression=force)
        result.add("N m", brake_torque=force * lever, locked_torque=locked_torque)
        result.add("m", slip=slip, travel=end)
        result.add("1", bottomed_out=bool(slip >= end * (1 - 1e-9)))
        result.add("s", vacuum_time=ready.time)
        result.add_group("needed", best, "needed_")
        result.add_bounds("N/m", stiffness=strap.stiffness, fall=least_stiffness(strap))
        result.add_bounds("N m", felt=locked_torque if self.supply.mode == "standing" else 0.0)
        result.warnings += [
            f"the brakes press head and neck together with up to {show(force, 'N')}; no "
            "source gives a limit for that",
            "only rotation is modelled: HIC15 ignores the linear acceleration of the blow",
        ]
        result.warnings += self.note_slip(slip, with_brakes.ride.pace)
        result.add_limits()
        result.limits += ready.limits
        result.brakes_needed = best.get("count")
        result.needed = self.describe_need(best, ready.time)
        return result

    def find_chains(self, trial: Trial) -> tuple[pandas.DataFrame, dict[str, Any]]:
        """Return (rows for 1 to CHAIN_LIMIT chains, row of the smallest sufficient number or {}).

        If none is enough with these straps (`as_built` False), the softest sufficient straps of
        STIFFER times their stiffness are used (`stiffness`). Brakes that may snap are excluded.
        """
        counts, webbing = np.arange(1, CHAIN_LIMIT + 1), self.guard.stiffness * STIFFER
        rows = trial.run_grid(webbing=webbing, parallel=counts)
        rows["turns"] = rows.acceleration / self.guard.lever
        sound_rows = rows[rows.sound & (rows.turns <= self.limits.acceleration)]
        table = rows[rows.as_built]
        if sound_rows.empty:
            return table, {}
        best = best_row(sound_rows, "webbing", "count")
        return table, best | {
            "stiffness": best["webbing"],
            "torque": self.torque(best["parallel"]),
        }

    def describe_need(self, best: dict[str, Any], time: float) -> str:
        """Describe the requirements in sentences."""
        limit = show(self.limits.acceleration, "rad/s^2")
        ready = (
            "If the pump started at the moment of the blow, the vacuum would be needed "
            f"within a fraction of its {show(self.blow.duration, 's')}; this line takes "
            f"{show(time, 's', 3) if math.isfinite(time) else 'forever'}."
        )
        if not best:
            words = (
                f"No number of brakes up to {CHAIN_LIMIT} in parallel keeps the head below {limit}."
            )
            return f"{words} {ready}"
        words = (
            f"Keeping the head below {limit} requires {best['count']} brakes "
            f"({show(best['mass'], 'kg')})"
        )
        if not best["as_built"]:
            words += (
                f", and straps of {show(best['stiffness'], 'N/m')}: those of "
                f"{show(self.guard.stiffness, 'N/m')} are too soft for any number to act in time"
            )
        return (
            f"{words}. Permanently jammed, they hold the head with a torque "
            f"of {show(best['torque'], 'N m')}. {ready}"
        )


def head_acceleration(angular: Array, turning: Array, height: float) -> Array:
    """Return the magnitude of the acceleration of the centre of gravity [m/s^2]."""
    return height * np.hypot(angular, turning**2)
