"""A collision that is warned of: the vacuum that comes in time, and the stop it gives.

The line stands at a vacuum while it waits. With the warning the pump goes full on and, after its
delay, the reservoir's valve opens; at the end of the warning the rope is taut. Two modes of the
paper: `full`, all the vacuum that comes in time, and `tuned`, just what stops the estimate within
the travel, capped by what comes in time, then shut off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.fluid.closed_forms import lowest, pumps_flow, reachable
from layerjam.fluid.line import Line
from layerjam.fluid.network import CHAMBER, SIZE, Drive, Response, at_pressure, respond
from layerjam.mechanics.stop.exact import NEVER_SLID, STOPPED, Stop, stop
from layerjam.simulate.coupled import CoupledStop, coupled_drop
from layerjam.simulate.drop import OUTCOMES, spring_of
from layerjam.simulate.record import Outcome

Array = npt.NDArray[np.float64]
STOPS = (Outcome.STOPPED, Outcome.NEVER_SLID)
LEVELS, GRID = 7, 65
"""Rounds of a search for the least vacuum and vacuums tried in each: to 2e-13 of the range."""
SAMPLES = 401
SHORTEST = 1e-9
"""Time [s] that counts as none: the integrator of the line cannot step over much less."""


@dataclass(frozen=True, kw_only=True)
class Arrival:
    """What is expected, in SI; standard deviations are zero where it is certain."""

    mass: float
    speed: float
    warning: float
    """From the warning to the taut rope [s]."""
    travel: float
    """Slip within which it should stop [m]."""
    mass_sd: float = 0.0
    speed_sd: float = 0.0
    standing: float = 0.0
    """Vacuum held while waiting [Pa]."""
    rope_stiffness: float | None = None
    gravity: float = 0.0
    """Along the pull [m/s^2]."""


@dataclass(frozen=True, kw_only=True)
class Mode:
    """One way to use the warning: the vacuum at the taut rope, and the stop of the estimate."""

    vacuum: float
    """At the taut rope [Pa]."""
    constant: Stop
    """Exact, at that vacuum held."""
    coupled: CoupledStop | None
    """With the line going on; None where the volume does not depend on slip."""

    @property
    def slip(self) -> float:
        """At the standstill or the end of travel [m]."""
        return float(self.constant.slip) if self.coupled is None else self.coupled.timed.slip

    @property
    def peak_force(self) -> float:
        """Greatest force [N]."""
        if self.coupled is None:
            return float(self.constant.peak_force)
        return self.coupled.timed.peak_force

    @property
    def heat(self) -> float:
        """Dissipated energy [J]."""
        return float(self.constant.heat) if self.coupled is None else self.coupled.timed.heat

    @property
    def end_speed(self) -> float:
        """Left at the end of travel [m/s]."""
        if self.coupled is None:
            return float(self.constant.end_speed)
        return self.coupled.timed.end_speed

    @property
    def outcome(self) -> Outcome:
        """How it ended."""
        if self.coupled is None:
            return OUTCOMES[int(self.constant.outcome)]
        return self.coupled.timed.outcome

    def within(self, travel: float) -> bool:
        """Whether it stopped after at most this slip [m]."""
        return self.outcome in STOPS and self.slip <= travel * (1 + 1e-9)


def before_the_stop(
    line: Line,
    duration: float,
    standing: float = 0.0,
    stored: float | None = None,
    water: bool = False,
    samples: int = SAMPLES,
) -> Response:
    """The line from the warning on [s], pump full on and the reservoir's valve after its delay.

    It begins at a standing vacuum [Pa]; the reservoir at `stored` [Pa absolute], as low as pump and
    leak come to unless given. In water C dP/dt = F, up to where it boils.
    """
    a = line.site.atmosphere
    if water:
        return _water(line, duration, standing, samples)
    kept = lowest(line) if stored is None else stored
    start = at_pressure(line, a - standing, kept)
    if duration <= SHORTEST:
        return Response(line=line, time=np.zeros(1), states=start[None])
    tank = line.reservoir
    opens = np.inf if tank is None else tank.delay
    if opens >= duration - SHORTEST:
        return respond(line, duration, Drive(), start, samples)
    if opens <= SHORTEST:
        return respond(line, duration, Drive(store=1.0), start, samples)
    first = respond(line, opens, Drive(), start, max(samples // 4, 2))
    then = respond(line, duration - opens, Drive(store=1.0), first.states[-1], samples)
    return Response(
        line=line, time=np.append(first.time, opens + then.time[1:]),
        states=np.vstack([first.states, then.states[1:]]),
    )  # fmt: skip


def _water(line: Line, duration: float, standing: float, samples: int) -> Response:
    assert line.chamber.compliance is not None
    time = np.linspace(0.0, duration, samples if duration else 1)
    rise = pumps_flow(line) / line.chamber.compliance
    vacuum = np.minimum(standing + rise * time, max(reachable(line, True), standing))
    states = np.zeros((len(time), SIZE))
    states[:, :2] = (line.site.atmosphere - vacuum)[:, None]
    return Response(line=line, time=time, states=states)


def let_go(line: Line, duration: float, standing: float, water: bool = False) -> float:
    """Least vacuum [Pa] that venting for so long [s] leaves of a standing one.

    By the vent valve after its delay, or the pumps run backwards; all of it stays without either.
    """
    a = line.site.atmosphere
    back = line.pump.backwards * line.pump.count
    if water:
        assert line.chamber.compliance is not None
        return max(standing - back * duration / line.chamber.compliance, 0.0)
    wait = line.valve.delay if line.valve is not None else 0.0
    if (line.valve is None and back == 0) or duration <= wait + SHORTEST or standing == 0:
        return standing
    drive = Drive(pump=-1.0) if line.valve is None else Drive(pump=0.0, vent=1.0)
    made = respond(line, duration - wait, drive, at_pressure(line, a - standing), 2)
    return max(float(made.vacuum[-1]), 0.0)


def needed_vacuum(brake: Brake, case: Arrival) -> float | None:
    """Least vacuum [Pa] that stops the estimate within the travel; None where none does.

    The tuned vacuum where there is one; what holds the mass where that is more.
    """
    spring = spring_of(brake, case.rope_stiffness)
    low, high = 0.0, brake.site.atmosphere
    for _ in range(LEVELS):
        tried = np.linspace(low, high, GRID)
        made = stop(case.mass, case.speed, tried, spring, case.gravity, brake)
        outcome, slip = np.asarray(made.outcome), np.asarray(made.slip)
        good = ((outcome == STOPPED) | (outcome == NEVER_SLID)) & (slip <= case.travel)
        if not good.any():
            return None
        first = int(np.argmax(good))
        if first == 0:
            return float(tried[0])
        low, high = float(tried[first - 1]), float(tried[first])
    return high


def stop_at(
    file: BrakeFile, case: Arrival, vacuum: float, line: Line | None = None,
    state: Array | None = None, drive: Drive = Drive(pump=0.0), water: bool = False,
) -> Mode:  # fmt: skip
    """The stop of the estimate at a vacuum [Pa]; coupled where a line has a volume per slip."""
    brake = file.brake
    spring = spring_of(brake, case.rope_stiffness)
    raw = stop(case.mass, case.speed, vacuum, spring, case.gravity, brake)
    exact = Stop(*(float(v) for v in raw))
    together = None
    if line is not None and line.chamber.volume_per_slip > 0:
        together = coupled_drop(
            file, line, mass=case.mass, speed=case.speed, gravity=case.gravity,
            rope_stiffness=case.rope_stiffness, water=water, drive=drive,
            start=vacuum if state is None else state,
        )  # fmt: skip
    return Mode(vacuum=vacuum, constant=exact, coupled=together)


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """The vacuum that comes in time, the stop in both modes, and what would be needed."""

    case: Arrival
    brake: BrakeFile
    rising: Response
    """The line during the warning."""
    reached: float
    needed: float | None
    full: Mode
    tuned: Mode
    capped: bool
    """Whether the tuned vacuum is more than what comes in time (or there is none)."""


def plan(
    file: BrakeFile, line: Line, case: Arrival, *, stored: float | None = None, water: bool = False
) -> Plan:
    """Plan one collision; all in SI, checked by the caller."""
    rising = before_the_stop(line, case.warning, case.standing, stored, water)
    state = rising.states[-1]
    reached = line.site.atmosphere - float(state[CHAMBER])
    needed = needed_vacuum(file.brake, case)
    opened = line.reservoir is not None and line.reservoir.delay < case.warning
    drive = Drive(store=1.0 if opened else 0.0)
    full = stop_at(file, case, reached, line, state, drive, water)
    if needed is None or needed >= reached:
        return Plan(case=case, brake=file, rising=rising, reached=reached, needed=needed,
                    full=full, tuned=full, capped=True)  # fmt: skip
    least = let_go(line, case.warning, case.standing, water) if needed < case.standing else 0.0
    tuned = stop_at(file, case, max(needed, least), line, None, Drive(pump=0.0), water)
    return Plan(case=case, brake=file, rising=rising, reached=reached, needed=needed, full=full,
                tuned=tuned, capped=False)  # fmt: skip
