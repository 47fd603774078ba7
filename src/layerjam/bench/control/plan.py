"""A collision with a warning: the vacuum that is reached in time, and the resulting stop.

The line waits at its idle vacuum (`standby`); the rope becomes taut at the end of the warning. The
two modes are the paper's. `full` uses all the vacuum that is reached in time. `tuned` uses the
vacuum that just stops the estimated mass within the travel, or that reached in time if it is lower;
the line is then shut off.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.bench.control.standby import Standby
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.network import CHAMBER, Drive, Response
from layerjam.brake.mechanics.limits import sheet_stress
from layerjam.brake.mechanics.speed_effects import depends_on_speed
from layerjam.brake.mechanics.stop.exact import NEVER_SLID, STOPPED, Stop, stop
from layerjam.brake.mechanics.stop.paced_tune import is_held
from layerjam.brake.simulate.coupled import CoupledStop, coupled_drop
from layerjam.brake.simulate.drop import OUTCOMES, series_spring
from layerjam.brake.simulate.drop_in_time import TimedStop
from layerjam.brake.simulate.least_vacuum import find_least_vacuum
from layerjam.brake.simulate.record import Outcome
from layerjam.core.brief import brief
from layerjam.core.units import show, show_at_least
from layerjam.core.verdict import Check, check

Array = npt.NDArray[np.float64]
STOPS = (Outcome.STOPPED, Outcome.NEVER_SLID)
NUMBERS = ("slip", "peak_force", "heat", "end_speed")


@dataclass(frozen=True, kw_only=True)
class Arrival:
    """Expected collision, in SI units; standard deviations are zero for values known exactly."""

    mass: float
    speed: float
    warning: float
    """Time from the warning until the rope is taut [s]."""
    travel: float
    """Slip within which the mass should stop [m]."""
    mass_sd: float = 0.0
    speed_sd: float = 0.0
    standing: float = 0.0
    """Idle vacuum, held while waiting [Pa]."""
    rope_stiffness: float | None = None
    gravity: float = 0.0
    """Component of gravity along the pull [m/s^2]."""


@dataclass(frozen=True, kw_only=True)
class Mode:
    """One way to use the warning: vacuum when the rope becomes taut, and the resulting stop.

    Slip, forces, heat and speed are NaN if the brake snaps.
    """

    vacuum: float
    """Vacuum when the rope becomes taut [Pa]."""
    slip: float
    """Slip at standstill or at the end of travel [m]."""
    peak_force: float
    """Maximum force [N]."""
    peak_g: float
    """Peak force relative to the weight at the site; NaN without gravity."""
    heat: float
    """Energy dissipated [J]."""
    end_speed: float
    """Remaining speed at the end of travel [m/s]."""
    outcome: Outcome
    coupled: CoupledStop | None
    """Stop with the line's dynamics; None if the volume does not depend on slip."""

    def stops_within(self, travel: float) -> bool:
        """Return whether the mass stopped within a slip of `travel` [m]."""
        return self.outcome in STOPS and self.slip <= travel * (1 + 1e-9)


def needed_vacuum(brake: Brake, case: Arrival) -> float | None:
    """Return the lowest vacuum [Pa] that stops the estimated mass within the travel, or None.

    This is the tuned vacuum if there is one, or the vacuum that holds the mass if that is higher.
    """
    spring = series_spring(brake, case.rope_stiffness)
    return find_least_vacuum(
        lambda vacuums: _stops_within(vacuums, case, spring, brake), brake.site.atmosphere
    )


def _stops_within(vacuums: Array, case: Arrival, spring: float, brake: Brake) -> Any:
    """Return whether the estimated mass stops within the travel at each of several vacuums [Pa]."""
    result = stop(case.mass, case.speed, vacuums, spring, case.gravity, brake)
    outcome, slip = np.asarray(result.outcome), np.asarray(result.slip)
    good = ((outcome == STOPPED) | (outcome == NEVER_SLID)) & (slip <= case.travel)
    if depends_on_speed(brake):
        good &= np.asarray(
            is_held(np.minimum(slip, case.travel), vacuums, case.mass * case.gravity, brake)
        )
    return good


def _is_on_knife_edge(file: BrakeFile, case: Arrival, vacuum: float) -> bool:
    """Return whether the slip jumps to the end of travel just below the required vacuum."""
    mode, below = (predict_stop(file, case, vacuum * share) for share in (1.0, 1 - 1e-6))
    return mode.slip < case.travel * (1 - 1e-3) and not below.stops_within(case.travel)


def predict_stop(
    file: BrakeFile,
    case: Arrival,
    vacuum: float,
    during: "During | None" = None,
    water: bool = False,
) -> Mode:
    """Return the stop of the estimated mass at a vacuum [Pa], which the line may change."""
    spring = series_spring(file.brake, case.rope_stiffness)
    result: Stop | TimedStop = stop(case.mass, case.speed, vacuum, spring, case.gravity, file.brake)
    coupling = None
    if during is not None and (during.leaks or during.line.chamber.volume_per_slip > 0):
        coupling = coupled_drop(
            file,
            during.line,
            mass=case.mass,
            speed=case.speed,
            gravity=case.gravity,
            rope_stiffness=case.rope_stiffness,
            water=water,
            drive=during.drive,
            start=vacuum if during.state is None else during.state,
        )
        result = coupling.timed
    outcome = OUTCOMES[int(result.outcome)] if coupling is None else coupling.timed.outcome
    has_snapped, weight = outcome is Outcome.SNAPS, case.mass * file.brake.site.gravity
    numbers = {name: math.nan if has_snapped else float(getattr(result, name)) for name in NUMBERS}
    peak_g = numbers["peak_force"] / weight if weight else math.nan
    return Mode(vacuum=vacuum, **numbers, peak_g=peak_g, outcome=outcome, coupled=coupling)


class During(NamedTuple):
    """State of the line during a stop."""

    line: Line
    drive: Drive
    state: Array | None = None
    """State when the rope becomes taut; None if the whole line is at the chamber's vacuum."""
    leaks: bool = False
    """Whether the leak continues during the stop even if the volume does not depend on slip."""


@brief
@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """Plan for one collision: vacuum reached in time, and stops in both modes."""

    case: Arrival
    brake: BrakeFile
    standby: Standby
    rising: Response
    """Response of the line during the warning."""
    reached: float
    needed: float | None
    full: Mode
    tuned: Mode
    capped: bool
    """Whether the required vacuum exceeds the vacuum reached in time, or does not exist."""
    knife_edge: bool
    """Whether the mass uses up its travel at 1 ppm less than the required vacuum."""


def plan_stop(
    file: BrakeFile,
    line: Line,
    case: Arrival,
    *,
    stored: float | None = None,
    water: bool = False,
    leaks: bool = False,
) -> Plan:
    """Plan for one collision; all values are in SI and checked by the caller.

    With `leaks`, the line leaks during the stop even if its volume does not depend on slip.
    """
    standby = Standby(line, case.standing, stored, water)
    rising = standby.respond(case.warning)
    state = rising.states[-1]
    vacuum = line.site.atmosphere - float(state[CHAMBER])
    need = needed_vacuum(file.brake, case)
    edge = need is not None and _is_on_knife_edge(file, case, need)
    opened = line.reservoir is not None and line.reservoir.delay < case.warning
    drive = Drive(store=1.0 if opened else 0.0)
    full_stop = tuned_mode = predict_stop(
        file, case, vacuum, During(line, drive, state, leaks), water
    )
    capped = need is None or need >= vacuum
    if need is not None and not capped:
        lowest = standby.vacuum_after_venting(case.warning) if need < case.standing else 0.0
        shut = During(line, Drive(pump=0.0), leaks=leaks)
        tuned_mode = predict_stop(file, case, max(need, lowest), shut, water)
    return Plan(
        case=case,
        brake=file,
        standby=standby,
        rising=rising,
        reached=vacuum,
        needed=need,
        full=full_stop,
        tuned=tuned_mode,
        capped=capped,
        knife_edge=edge,
    )


def checks_of_plan(
    plan: Plan, chance: float, safe: float | None, confidence: float
) -> Iterator[Check]:
    """Yield the checks of a plan.

    `chance` is that of exceeding the travel, and `safe` the vacuum [Pa] at which it is
    no more than 1 - `confidence`, None if there is none.
    """
    if plan.needed is not None:
        yield _check_knife_edge(plan, plan.needed, safe, confidence)
    yield from _check_strength(plan)
    sentence = f"the probability that the slip exceeds the travel is {chance:.1%}"
    limit = 1 - confidence
    yield check("chance", chance <= limit + 1e-12, sentence, f", more than {limit * 100:.4g}%")


def _check_knife_edge(plan: Plan, lowest: float, safe: float | None, confidence: float) -> Check:
    """Return the check that slightly less than the planned vacuum still stops the mass."""
    atmosphere = plan.brake.brake.site.atmosphere
    vacuum = show_at_least(lowest, "Pa", atmosphere)
    if not plan.knife_edge:
        return check("knife edge", True, f"the stop hardly changes just below {vacuum}")
    sentence = f"at {vacuum} the mass barely comes to rest; with 1 ppm less vacuum it does not"
    share = f"{confidence * 100:.4g} % of the stops"
    if safe is None:
        advice = f", and no vacuum available at the site keeps {share} within the travel"
    else:
        advice = f". With {show_at_least(safe, 'Pa', atmosphere)}, {share} stay within the travel"
    return check("knife edge", False, sentence, advice, "failed")


def _check_strength(plan: Plan) -> Iterator[Check]:
    """Yield the check of the sheets' stress at the peak force, if the film's strength is known."""
    brake, forces = plan.brake.brake, (plan.full.peak_force, plan.tuned.peak_force)
    peak = max((force for force in forces if math.isfinite(force)), default=None)
    if peak is None or brake.film.strength is None:
        return
    stress, limit = float(sheet_stress(peak, brake)), brake.film.strength
    sentence = (
        f"at {show(peak, 'N')} the stress in the sheets is {show(stress, 'Pa')}; "
        f"{show(limit, 'Pa')} is allowed"
    )
    yield check("sheet strength", stress <= limit, sentence, ": they stretch or tear", "failed")
