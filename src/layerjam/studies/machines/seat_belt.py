"""Seat belt (paper, Fig. 13a): in a crash, an occupant is thrown into a belt with brakes.

The part of the occupant that the shoulder belt restrains is one mass. In the frame of the car, the
car's deceleration drives it and the belt restrains it: m x'' = m a(t) - g T(g x - slack). T is the
belt tension. g is the payout per metre of chest travel, and therefore also the ratio of the force
on the chest to T. Airbag, knees, pretensioner, chest compression and the lap belt's share are
ignored.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import pandas

from layerjam.brake.mechanics.ageing import aged_holding_force
from layerjam.brake.mechanics.energy import slip_work
from layerjam.core.units import nested, show
from layerjam.studies.machines.injury import filter_signal
from layerjam.studies.machines.pulse import make_drive
from layerjam.studies.machines.readiness import VacuumSupply, check_readiness
from layerjam.studies.machines.restraint import (
    Body,
    Ride,
    Strap,
    Trial,
    best_row,
    can_snap,
    least_stiffness,
    make_limiter,
    simulate_ride,
)
from layerjam.studies.machines.scenario import Array, declare_fields
from layerjam.studies.machines.verdict import Machine, Result

STEPS = 8000
MOST_SERIES, MOST_PARALLEL = 24, 1024
STIFFER = 2.0 ** np.arange(9)
"""Factors by which stiffer webbing is examined."""
LEVELS = 40
"""Number of vacuums tried in the search for the lowest sufficient one."""


class HeldOccupant(NamedTuple):
    """Motion of the occupant in one kind of restraint, in SI units."""

    name: str
    ride: Ride
    chest: Array
    """Filtered acceleration of the chest [m/s^2]."""
    excursion: float
    chest_acceleration: float
    belt_force: float


class Record(NamedTuple):
    """Data for the pictures."""

    drive: Array
    held: tuple[HeldOccupant, ...]


@declare_fields("seat-belt")
class SeatBelt(Machine):
    """Seat belt with all data of its scenario."""

    supply: VacuumSupply = nested(VacuumSupply)

    def make_trial(self) -> tuple[Trial, float]:
        """Return (trial of the restrained mass in the pulse, its velocity change [m/s])."""
        crash, belt = self.crash, self.belt
        # at constant force, stopping takes twice the space divided by the speed; a rebound follows
        duration = crash.duration + 4 * self.limits.space / crash.change
        pulse = crash.pulse, crash.change, crash.duration
        push, dt, change = make_drive(*pulse, duration, STEPS, self.folder)
        body = Body(self.occupant.mass * self.occupant.share, belt.payout, belt.slack)
        return Trial(self, body, belt.stiffness, push, dt), change

    def analyse(self) -> Result:
        """Compare loads and excursion for brakes, webbing alone and the ideal limiter."""
        belt, brakes, brake = self.belt, self.brakes, self.brake.brake
        trial, change = self.make_trial()
        adjusts = brakes.mode == "tuned"
        vacuum = self.tune_vacuum(trial) if adjusts else brakes.vacuum
        strap, force = trial.strap(vacuum=vacuum), self.find_least_limiter(trial)
        restraints = (
            self.run_case("with brakes", trial, strap),
            self.run_case("webbing alone", trial, make_limiter(math.inf, belt.stiffness)),
            self.run_case("limiter of constant force", trial, make_limiter(force, belt.stiffness)),
        )
        brake_ride, end = restraints[0].ride, float(strap.travel) * brakes.series
        is_bottomed_out = bool(brake_ride.slip[-1] >= end * (1 - 1e-9))
        may_snap = bool(can_snap(strap))
        ready = check_readiness(self, self.supply, vacuum, tuned=adjusts)
        best, lowest_force = self.find_belts(trial)
        result = Result(
            scenario=self, record=Record(trial.drive, restraints), warnings=ready.notices
        )
        for prefix, restraint in zip(("", "webbing_", "limiter_"), restraints, strict=True):
            result.add_group("loads", restraint._asdict(), prefix)
        result.add(
            "N", chest_force=float(brake_ride.force.max()) * belt.payout, limiter_force=force
        )
        result.add("N", steady_force=belt.stiffness * brake.sheets.overlap)
        result.add("m", slip=float(brake_ride.slip[-1]), travel=end)
        result.add("1", bottomed_out=is_bottomed_out, snaps=may_snap)
        # use the vacuum in this crash, not the site's full vacuum
        work = float(slip_work(brake.sheets.usable_travel, vacuum, brake))
        result.add("J", energy_capacity=brakes.count * work)
        result.add("J", energy_put_in=float(brake_ride.put_in.max()))
        result.add("J", energy_slipped=float(brake_ride.heat[-1]))
        result.add("Pa", vacuum=vacuum)
        result.add("m/s", change=change)
        result.add("s", vacuum_time=ready.time)
        if brake.film.ageing is not None and math.isfinite(ready.time):
            # force at breakaway if the crash occurs as soon as the vacuum is present
            aged_force = float(aged_holding_force(ready.time, vacuum, brake))
            result.add("N", aged_holding_force=aged_force * brakes.parallel)
        result.add_group("needed", best, "needed_")
        result.add_group("least", lowest_force, "least_")
        result.add_bounds("N/m", stiffness=strap.stiffness, fall=least_stiffness(strap))
        if may_snap:
            result.warnings.append(
                "the stiffness of the belt is below the rate at which the brakes' force "
                "falls: they snap"
            )
        if is_bottomed_out:
            result.warnings.append(
                f"the brakes use up their travel, {show(end, 'm')}; then the belt is held "
                "by end stops"
            )
        result.warnings += self.note_slip(float(brake_ride.slip[-1]), brake_ride.pace)
        result.add_limits()
        result.limits += ready.limits
        result.brakes_needed = best.get("count")
        result.needed = self.describe_need(best, lowest_force, force)
        return result

    def run_case(self, name: str, trial: Trial, strap: Strap) -> HeldOccupant:
        """Return the occupant restrained by a strap, filtered as in a crash laboratory."""
        motion = simulate_ride(trial.drive, trial.dt, trial.body, strap)
        acceleration = motion.force * self.belt.payout / float(trial.body.mass)
        chest = filter_signal(acceleration, trial.dt, self.filter.chest)
        belt = filter_signal(motion.force, trial.dt, self.filter.belt)
        return HeldOccupant(
            name, motion, chest, *(float(array.max()) for array in (motion.way, chest, belt))
        )

    def list_stopping_belts(self, trial: Trial, **grid: Any) -> pandas.DataFrame:
        """Return a grid's belts that stop the occupant within the space and with travel left."""
        rows = trial.run_grid(**grid)
        names = {"way": "excursion", "held": "chest_acceleration", "force": "belt_force"}
        rows = rows[rows.stops & (rows.way <= self.limits.space)].rename(columns=names)
        is_allowed = rows.chest_acceleration <= self.limits.chest
        is_allowed &= rows.belt_force <= self.limits.belt
        return rows.assign(meets_loads=is_allowed, stiffness=rows.webbing, burdens=~is_allowed)

    def tune_vacuum(self, trial: Trial) -> float:
        """Return the lowest of LEVELS vacuums [Pa] that is sufficient, else `brakes.vacuum`."""
        levels = self.brakes.vacuum * np.arange(1, LEVELS + 1) / LEVELS
        stopping_vacuums = self.list_stopping_belts(trial, vacuum=levels).vacuum
        return float(stopping_vacuums.min()) if len(stopping_vacuums) else self.brakes.vacuum

    def find_least_limiter(self, trial: Trial) -> float:
        """Return the smallest constant force [N] with which the occupant stops, or infinity."""
        from scipy.optimize import brentq

        def simulate_throw(force: float) -> Ride:
            strap = make_limiter(force, self.belt.stiffness)
            return simulate_ride(trial.drive, trial.dt, trial.body, strap)

        def excess(force: float) -> float:
            return float(simulate_throw(force).way.max()) - self.limits.space

        webbing = float(simulate_throw(math.inf).force.max())
        return math.inf if excess(webbing) > 0 else float(brentq(excess, 0.0, webbing, rtol=1e-12))

    def find_belts(self, trial: Trial) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return (required belt, belt with the smallest force), both empty if none is sufficient.

        A grid of chains is examined, then every number near the best. The best belt stops the
        occupant within the space with travel left, and has the fewest brakes that also meet the
        limits of chest and belt. If none does, it has the fewest brakes that stop the occupant
        (`meets_loads` False). If none stops the occupant with the existing webbing (`as_built`
        False), it has the softest sufficient webbing of STIFFER times that stiffness (`stiffness`).
        Belts whose brakes may snap are excluded.
        """
        # a chain whose travel exceeds the whole available payout is never used up
        end = self.brake.brake.sheets.usable_travel
        longest = math.ceil(self.limits.space * self.belt.payout / end) + 1
        series = np.arange(1, min(max(longest, 2), MOST_SERIES) + 1)
        parallel = np.unique(np.round(np.geomspace(1, MOST_PARALLEL, 40))).astype(int)
        webbing = self.belt.stiffness * STIFFER
        rows = self.list_stopping_belts(trial, webbing=webbing, series=series, parallel=parallel)
        rows = rows[rows.sound]
        if rows.empty:
            return {}, {}
        fewest = "burdens", "count", "belt_force"
        best = best_row(rows[rows.webbing == rows.webbing.min()], *fewest)
        place = int(np.searchsorted(parallel, best["parallel"]))
        counts = np.arange(parallel[max(place - 1, 0)], best["parallel"] + 1)
        chain = {"webbing": best["webbing"], "series": best["series"], "parallel": counts}
        rows, lowest_force = self.list_stopping_belts(trial, **chain), best_row(rows, "belt_force")
        return best_row(rows[rows.sound], *fewest), lowest_force | {
            "belt_force_count": lowest_force["count"]
        }

    def describe_need(
        self, best: dict[str, Any], lowest_force: dict[str, Any], force: float
    ) -> str:
        """Describe the requirements as a sentence."""
        if not best:
            return (
                f"No number of brakes up to {MOST_PARALLEL} in parallel stops the "
                f"occupant within {show(self.limits.space, 'm')}."
            )
        words = (
            f"Stopping in the available space requires {best['count']} brakes ({best['parallel']} "
            f"in parallel, {best['series']} in series, {show(best['mass'], 'kg')}), with "
            f"{show(best['belt_force'], 'N')} in the belt and a chest acceleration of "
            f"{show(best['chest_acceleration'], 'm/s^2')}"
        )
        if not best["as_built"]:
            steady = self.belt.stiffness * self.brake.brake.sheets.overlap
            words += (
                f", and webbing of {show(best['stiffness'], 'N/m')}: behind webbing of "
                f"{show(self.belt.stiffness, 'N/m')}, brakes of this overlap slide steadily up to "
                f"only {show(steady, 'N')}, and snap above that"
            )
        if not best["meets_loads"]:
            words += (
                ". No number of these brakes also meets the load limits: the lowest force "
                f"in the belt is {show(lowest_force['belt_force'], 'N')}, with "
                f"{lowest_force['count']} of them"
            )
        if force > self.limits.belt:
            words += (
                f". Even an ideal limiter of constant force needs {show(force, 'N')} in this "
                f"space, more than the {show(self.limits.belt, 'N')} allowed"
            )
        return words + "."
