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
import pandas

from layerjam.mechanics.ageing import aged_holding_force
from layerjam.mechanics.energy import slip_work
from layerjam.studies.machines.injury import filtered
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
    snaps,
)
from layerjam.studies.machines.scenario import Array, declared
from layerjam.studies.machines.verdict import Machine, Result
from layerjam.units import nested, show

STEPS = 8000
MOST_SERIES, MOST_PARALLEL = 24, 1024
STIFFER = 2.0 ** np.arange(9)
"""Multiples of the webbing's stiffness that are tried."""
LEVELS = 40
"""Vacuums tried for the tuned one."""


class Held(NamedTuple):
    """One way of holding the occupant, in SI."""

    name: str
    ride: Ride
    chest: Array
    """Acceleration of the chest [m/s^2], filtered."""
    excursion: float
    chest_acceleration: float
    belt_force: float


class Record(NamedTuple):
    """For the pictures."""

    drive: Array
    held: tuple[Held, ...]


@declared("seat-belt")
class SeatBelt(Machine):
    """Everything of the scenario."""

    supply: VacuumSupply = nested(VacuumSupply)

    def trial(self) -> tuple[Trial, float]:
        """(the held part of the occupant in the car's pulse, its change of velocity [m/s])."""
        crash, belt = self.crash, self.belt
        # a constant force takes twice the space over the speed to stop; then the rebound
        after = crash.duration + 4 * self.limits.space / crash.change
        pulse = crash.pulse, crash.change, crash.duration
        push, dt, change = drive(*pulse, after, STEPS, self.folder)
        body = Body(self.occupant.mass * self.occupant.share, belt.payout, belt.slack)
        return Trial(self, body, belt.stiffness, push, dt), change

    def analyse(self) -> Result:
        """Loads and excursion with the brakes, with webbing alone and with the least limiter."""
        belt, brakes, brake = self.belt, self.brakes, self.brake.brake
        trial, change = self.trial()
        adjusts = brakes.mode == "tuned"
        vacuum = self.tuned(trial) if adjusts else brakes.vacuum
        strap, force = trial.strap(vacuum=vacuum), self.least_limiter(trial)
        made = (
            self.held("with brakes", trial, strap),
            self.held("webbing alone", trial, limiter_of(math.inf, belt.stiffness)),
            self.held("limiter of constant force", trial, limiter_of(force, belt.stiffness)),
        )
        braked, end = made[0].ride, float(strap.travel) * brakes.series
        bottomed, soft = bool(braked.slip[-1] >= end * (1 - 1e-9)), bool(snaps(strap))
        ready = readiness(self, self.supply, vacuum, tuned=adjusts)
        best, least = self.search(trial)
        found = Result(scenario=self, record=Record(trial.drive, made), warnings=ready.said)
        for prefix, one in zip(("", "webbing_", "limiter_"), made, strict=True):
            found.take("loads", one._asdict(), prefix)
        found.add("N", chest_force=float(braked.force.max()) * belt.payout, limiter_force=force)
        found.add("N", steady_force=belt.stiffness * brake.sheets.overlap)
        found.add("m", slip=float(braked.slip[-1]), travel=end)
        found.add("1", bottomed_out=bottomed, snaps=soft)
        # at the vacuum of this crash, not at the site's full one
        each = float(slip_work(brake.sheets.usable_travel, vacuum, brake))
        found.add("J", energy_capacity=brakes.count * each)
        found.add("J", energy_put_in=float(braked.put_in.max()))
        found.add("J", energy_slipped=float(braked.heat[-1]))
        found.add("Pa", vacuum=vacuum)
        found.add("m/s", change=change)
        found.add("s", vacuum_time=ready.time)
        if brake.film.ageing is not None and math.isfinite(ready.time):
            # what breaks away when the crash comes as soon as the vacuum stands
            rested = float(aged_holding_force(ready.time, vacuum, brake))
            found.add("N", aged_holding_force=rested * brakes.parallel)
        found.take("needed", best, "needed_")
        found.take("least", least, "least_")
        found.bound("N/m", stiffness=strap.stiffness, fall=least_stiffness(strap))
        if soft:
            found.warnings.append(
                "the belt is softer than the brakes' force falls: they snap through"
            )
        if bottomed:
            found.warnings.append(
                f"the brakes use up their {show(end, 'm')}; behind it the belt holds on stops"
            )
        found.warnings += self.slid(float(braked.slip[-1]), braked.pace)
        found.judge()
        found.limits += ready.limits
        found.brakes_needed = best.get("count")
        found.needed = self.needed(best, least, force)
        return found

    def held(self, name: str, trial: Trial, strap: Strap) -> Held:
        """The occupant in a strap, as a crash laboratory would read it."""
        made = ride(trial.drive, trial.dt, trial.body, strap)
        felt = made.force * self.belt.payout / float(trial.body.mass)
        chest = filtered(felt, trial.dt, self.filter.chest)
        belt = filtered(made.force, trial.dt, self.filter.belt)
        return Held(name, made, chest, *(float(array.max()) for array in (made.way, chest, belt)))

    def stopping(self, trial: Trial, **grid: Any) -> pandas.DataFrame:
        """The belts of a grid that stop the occupant in the space, on travel left, with loads."""
        rows = trial.tried(**grid)
        names = {"way": "excursion", "held": "chest_acceleration", "force": "belt_force"}
        rows = rows[rows.stops & (rows.way <= self.limits.space)].rename(columns=names)
        inside = rows.chest_acceleration <= self.limits.chest
        inside &= rows.belt_force <= self.limits.belt
        return rows.assign(meets_loads=inside, stiffness=rows.webbing, burdens=~inside)

    def tuned(self, trial: Trial) -> float:
        """The least vacuum [Pa] of LEVELS at which the occupant stops in the space, on travel left.

        Up to `brakes.vacuum`, which stands where no less will do.
        """
        levels = self.brakes.vacuum * np.arange(1, LEVELS + 1) / LEVELS
        fine = self.stopping(trial, vacuum=levels).vacuum
        return float(fine.min()) if len(fine) else self.brakes.vacuum

    def least_limiter(self, trial: Trial) -> float:
        """The least constant force [N] that stops the occupant within the space.

        Where even stiff webbing does not, the limiter never limits: infinite.
        """
        from scipy.optimize import brentq

        def thrown(force: float) -> Ride:
            strap = limiter_of(force, self.belt.stiffness)
            return ride(trial.drive, trial.dt, trial.body, strap)

        def over(force: float) -> float:
            return float(thrown(force).way.max()) - self.limits.space

        webbing = float(thrown(math.inf).force.max())
        return math.inf if over(webbing) > 0 else float(brentq(over, 0.0, webbing, rtol=1e-12))

    def search(self, trial: Trial) -> tuple[dict[str, Any], dict[str, Any]]:
        """(what it takes, the belt with the least force); empty where nothing does.

        A grid of chains, then every number near the best. Of the belts that stop the occupant in
        the space without using up their travel, the fewest brakes that also keep chest and belt in
        their limits; where none does, the fewest that stop (`meets_loads` False). Where none stops
        behind the webbing there is (`as_built` False), behind the softest of STIFFER times it that
        will do (`stiffness`). Belts in which the brakes may snap do not count.
        """
        # a chain longer than the whole payout of the space is never used up
        end = self.brake.brake.sheets.usable_travel
        longest = math.ceil(self.limits.space * self.belt.payout / end) + 1
        series = np.arange(1, min(max(longest, 2), MOST_SERIES) + 1)
        parallel = np.unique(np.round(np.geomspace(1, MOST_PARALLEL, 40))).astype(int)
        webbing = self.belt.stiffness * STIFFER
        rows = self.stopping(trial, webbing=webbing, series=series, parallel=parallel)
        rows = rows[rows.sound]
        if rows.empty:
            return {}, {}
        fewest = "burdens", "count", "belt_force"
        best = first(rows[rows.webbing == rows.webbing.min()], *fewest)
        at = int(np.searchsorted(parallel, best["parallel"]))
        near = np.arange(parallel[max(at - 1, 0)], best["parallel"] + 1)
        chain = {"webbing": best["webbing"], "series": best["series"], "parallel": near}
        rows, least = self.stopping(trial, **chain), first(rows, "belt_force")
        return first(rows[rows.sound], *fewest), least | {"belt_force_count": least["count"]}

    def needed(self, best: dict[str, Any], least: dict[str, Any], force: float) -> str:
        """What it would take, as a sentence."""
        if not best:
            return (
                f"No number of brakes up to {MOST_PARALLEL} side by side stops the occupant within "
                f"{show(self.limits.space, 'm')}."
            )
        words = (
            f"It takes {best['count']} brakes ({best['parallel']} side by side, "
            f"{best['series']} in a row, {show(best['mass'], 'kg')}) to stop in the "
            f"space at hand, with {show(best['belt_force'], 'N')} in the belt and "
            f"{show(best['chest_acceleration'], 'm/s^2')} of the chest"
        )
        if not best["as_built"]:
            steady = self.belt.stiffness * self.brake.brake.sheets.overlap
            words += (
                f", and webbing of {show(best['stiffness'], 'N/m')}: behind webbing of "
                f"{show(self.belt.stiffness, 'N/m')} brakes of this overlap slide steadily up to "
                f"{show(steady, 'N')} only, and snap beyond"
            )
        if not best["meets_loads"]:
            words += (
                f". No number of these brakes keeps the loads too: the least force in the belt is "
                f"{show(least['belt_force'], 'N')}, with {least['count']} of them"
            )
        if force > self.limits.belt:
            words += (
                f". Even an ideal limiter of constant force needs {show(force, 'N')} in this "
                f"space, more than the {show(self.limits.belt, 'N')} allowed"
            )
        return words + "."
