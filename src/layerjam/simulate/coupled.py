"""Brake and line together in time: the sleeve stretches, the pump goes on, the vacuum changes.

Waveform relaxation: the slip over time gives the vacuum over time (the line's equations), that
gives the slip over time (the brake's solver in time), and so on until neither changes. The force
P A_s that goes with a volume A_s per slip is not added to the brake's law: a brake calibrated by a
pull has it in its calibration (`gas_force` says how large it is).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.fluid.closed_forms import pumps_flow, reachable
from layerjam.fluid.line import Line
from layerjam.fluid.network import (
    CHAMBER,
    SIZE,
    Drive,
    Response,
    at_pressure,
    rates,
)
from layerjam.mechanics.hysteresis import Cycle, brake_cycle
from layerjam.mechanics.stop.exact import Stop
from layerjam.simulate.drop import OUTCOMES, drop
from layerjam.simulate.drop_in_time import TimedStop, drop_in_time
from layerjam.simulate.record import DropRecord
from layerjam.simulate.vacuum_history import History
from layerjam.units import show

Array = npt.NDArray[np.float64]
TOLERANCE = 1e-6
"""Relative change of slip, peak and vacuum from one round to the next that counts as none."""
ROUNDS = 25
NODES = 241
"""Times at which a round hands the vacuum over; straight lines in between."""
PULL_SAMPLES = 1024
"""Moves of a pull; shorter rows are filled up to a whole number of these, for the compiler."""
MATTERS = 0.01
"""Relative change of slip or peak from which on the coupling is said to matter."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CoupledStop:
    """A stop with its line, and the same stop at constant vacuum beside it."""

    timed: TimedStop
    record: DropRecord
    line: Response
    """Chamber, tube and reservoir from the taut rope to the standstill; in water pressure alone."""
    constant: Stop
    """The exact stop at the vacuum of the taut rope."""
    changes: tuple[float, ...]
    """Largest relative change of slip, peak and vacuum, round by round."""
    water: bool = False

    @property
    def rounds(self) -> int:
        """How many it took."""
        return len(self.changes)

    @property
    def remaining(self) -> float:
        """What the last round still changed [1]."""
        return self.changes[-1]

    @property
    def vacuum_change(self) -> float:
        """From the taut rope to the standstill [Pa]."""
        return float(self.line.vacuum[-1] - self.line.vacuum[0])

    @property
    def slip_change(self) -> float:
        """Against constant vacuum [m]."""
        return self.timed.slip - float(self.constant.slip)

    @property
    def peak_change(self) -> float:
        """Of the peak force, against constant vacuum [N]."""
        return self.timed.peak_force - float(self.constant.peak_force)

    @property
    def matters(self) -> bool:
        """Whether slip or peak differ by more than 1 % from constant vacuum, or the outcome."""
        slip, peak = float(self.constant.slip), float(self.constant.peak_force)
        if self.timed.outcome is not OUTCOMES[int(self.constant.outcome)]:
            return True
        return abs(self.slip_change) > MATTERS * slip or abs(self.peak_change) > MATTERS * peak

    @property
    def gas_force(self) -> float:
        """P A_s at the taut rope [N]: the force that the volume per slip stands for."""
        return float(self.line.vacuum[0]) * self.line.line.chamber.volume_per_slip

    @property
    def gas_imbalance(self) -> float:
        """Gas that cannot be accounted for, over all there was [1]; 0 in water, which has none."""
        return 0.0 if self.water else self.line.imbalance

    @property
    def energy_imbalance(self) -> float:
        """Energy of the mass that is neither heat, nor stored, nor still motion, over all [1]."""
        made = self.record
        brought = made.mass * made.speed**2 / 2 + made.mass * made.gravity * made.travel[-1]
        left = made.mass * self.timed.end_speed**2 / 2
        return abs(brought - self.timed.heat - self.timed.stored - left) / float(brought)


def boyle(vacuum: float, slip: float, line: Line) -> float:
    """Vacuum [Pa] after a slip [m] of a chamber shut off, at constant temperature, not drawn in."""
    a, chamber = line.site.atmosphere, line.chamber
    return a - (a - vacuum) * chamber.volume / (chamber.volume + chamber.volume_per_slip * slip)


def line_along(
    line: Line, start: Array, time: Array, slip: Array, drive: Drive, water: bool = False
) -> Response:
    """The line at times [s] while the brake slips [m] as given, shape (N,) each.

    The slip is joined by monotone cubics (PCHIP), so that its rate has no jumps. Air by LSODA at a
    relative error of 1e-9, gas conserved to rounding; water C P = F t + A_s slip, until it boils.
    """
    if water:
        return _water_along(line, start, time, slip, drive)
    from scipy.integrate import solve_ivp
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(time, slip)
    pace = curve.derivative()

    def change(t: float, state: Array) -> Array:
        moved = drive._replace(slip=float(curve(t)), pace=float(pace(t)))
        return rates(state, moved, line)

    scale = np.maximum(np.abs(start), np.abs(start[CHAMBER]) * 1e-6)
    made: Any = solve_ivp(
        change, (float(time[0]), float(time[-1])), start, method="LSODA", t_eval=time, rtol=1e-9,
        atol=1e-10 * np.maximum(scale, 1e-6),
    )  # fmt: skip
    if not made.success:
        raise QuantityError(f"line: cannot be integrated along the stop: {made.message[:100]}")
    return Response(line=line, time=made.t, states=made.y.T)


def _water_along(line: Line, start: Array, time: Array, slip: Array, drive: Drive) -> Response:
    chamber = line.chamber
    assert chamber.compliance is not None
    flow = drive.pump * pumps_flow(line)
    taken = flow * (time - time[0]) + chamber.volume_per_slip * (slip - slip[0])
    begin = line.site.atmosphere - start[CHAMBER]
    vacuum = np.minimum(begin + taken / chamber.compliance, max(reachable(line, True), begin))
    states = np.zeros((len(time), SIZE))
    states[:, CHAMBER] = states[:, CHAMBER + 1] = line.site.atmosphere - vacuum
    return Response(line=line, time=time, states=states)


def coupled_drop(
    file: BrakeFile,
    line: Line,
    *,
    mass: float,
    speed: float,
    start: Array | float,
    drive: Drive = Drive(),
    rope_stiffness: float | None = None,
    gravity: float | None = None,
    water: bool = False,
    tolerance: float = TOLERANCE,
    rounds: int = ROUNDS,
    nodes: int = NODES,
) -> CoupledStop:
    """Stop a mass [kg] that arrives with `speed` [m/s] while the line goes on; all in SI.

    `start` is the line's state at the taut rope, or its vacuum [Pa]; `drive` holds pump and
    reservoir during the stop (its slip is not used). Raises QuantityError where the rounds do not
    settle to `tolerance`, and for what is no drop.
    """
    a = line.site.atmosphere
    state = at_pressure(line, a - start) if isinstance(start, int | float) else start
    vacuum = a - float(state[CHAMBER])
    case = {"mass": mass, "speed": speed, "rope_stiffness": rope_stiffness, "gravity": gravity}
    constant, record = drop(file, vacuum=vacuum, **case)  # type: ignore[arg-type]
    made = line_along(line, state, *_nodes(record.time, record.slip, nodes), drive, water)
    timed: TimedStop | None = None
    step: float | None = None
    changes: list[float] = []
    for _ in range(rounds):
        before, was = timed, made
        timed, record = drop_in_time(
            file, vacuum=History(made.time, made.vacuum), step=step, **case  # type: ignore[arg-type]
        )  # fmt: skip
        step = record.step
        made = line_along(line, state, *_nodes(record.time, record.slip, nodes), drive, water)
        old = (constant.slip, constant.peak_force) if before is None else before[:2]
        changes.append(
            max(
                abs(timed.slip - old[0]) / max(timed.slip, 1e-9),
                abs(timed.peak_force - old[1]) / timed.peak_force,
                _apart(was, made) / a,
            )
        )
        if changes[-1] <= tolerance:
            return CoupledStop(
                timed=timed, record=record, line=made, constant=constant, changes=tuple(changes),
                water=water,
            )  # fmt: skip
    raise _unsettled(line, changes, tolerance)


@dataclass(frozen=True, kw_only=True, eq=False)
class CoupledPull:
    """A pull with its line; arrays of shape (N,), SI."""

    elongation: Array
    """Of the crosshead [m]."""
    force: Array
    """[N]; NaN from where the brake snaps."""
    slip: Array
    """[m]"""
    work: Array
    """Done on the brake so far [J]."""
    heat: Array
    """Dissipated so far [J]."""
    stored: Array
    """Elastic energy held [J]."""
    constant: Array
    """Force of the same pull at the vacuum it begins with [N]."""
    line: Response
    changes: tuple[float, ...]
    """Largest relative change of slip, force and vacuum, round by round."""

    @property
    def matters(self) -> bool:
        """Whether the force differs anywhere by more than 1 % of its peak at constant vacuum."""
        apart = np.nanmax(np.abs(self.force - self.constant))
        return bool(apart > MATTERS * np.nanmax(self.constant))


def coupled_pull(
    file: BrakeFile,
    line: Line,
    *,
    speed: float,
    travel: float,
    start: Array | float,
    drive: Drive = Drive(pump=0.0),
    water: bool = False,
    tolerance: float = TOLERANCE,
    rounds: int = ROUNDS,
    samples: int = PULL_SAMPLES,
) -> CoupledPull:
    """Pull the crosshead at `speed` [m/s] over `travel` [m] while the line goes on; all in SI.

    The vacuum is taken over before each of `samples` moves, so that work and heat are of first
    order in their number. Raises QuantityError where the rounds do not settle to `tolerance`.
    """
    a = line.site.atmosphere
    state = at_pressure(line, a - start) if isinstance(start, int | float) else start
    elongation = np.linspace(0.0, travel, samples)
    time = elongation / speed

    def pulled(vacuum: Any) -> Cycle:
        more = (0, -samples % PULL_SAMPLES)
        rows = np.pad(elongation, more, mode="edge"), np.pad(vacuum, more, mode="edge")
        made = brake_cycle(*rows, file.brake)
        return Cycle(*(np.asarray(values)[:samples] for values in made))

    cycle = pulled(np.full(samples, a - float(state[CHAMBER])))
    constant = cycle.force
    made = line_along(line, state, *_nodes(time, cycle.slip, NODES), drive, water)
    changes: list[float] = []
    for _ in range(rounds):
        before, was = cycle, made
        cycle = pulled(np.interp(time, made.time, made.vacuum))
        made = line_along(line, state, *_nodes(time, cycle.slip, NODES), drive, water)
        moved = np.nanmax(np.abs(cycle.force - before.force)) / np.nanmax(cycle.force)
        slid = np.max(np.abs(cycle.slip - before.slip)) / travel
        changes.append(float(max(moved, slid, _apart(was, made) / a)))
        if changes[-1] <= tolerance:
            return CoupledPull(
                elongation=elongation, force=cycle.force, slip=cycle.slip, work=cycle.work,
                heat=cycle.heat, stored=cycle.stored, constant=constant, line=made,
                changes=tuple(changes),
            )  # fmt: skip
    raise _unsettled(line, changes, tolerance)


def _apart(was: Response, now: Response) -> float:
    """Greatest difference of two vacuums over time [Pa]."""
    return float(np.max(np.abs(np.interp(now.time, was.time, was.vacuum) - now.vacuum)))


def _unsettled(line: Line, changes: list[float], tolerance: float) -> QuantityError:
    return QuantityError(
        f"chamber.volume_per_slip: {show(line.chamber.volume_per_slip, 'm^2')} couples brake and "
        f"line so strongly that {len(changes)} rounds still change by {changes[-1]:.1e}; "
        f"{tolerance:.0e} is allowed"
    )


def _nodes(time: Any, slip: Any, nodes: int) -> tuple[Array, Array]:
    """The slip [m] at equally spaced times [s], by monotone cubics."""
    from scipy.interpolate import PchipInterpolator

    times, first = np.unique(np.asarray(time, float), return_index=True)
    grid = np.linspace(times[0], times[-1], nodes)
    curve = PchipInterpolator(times, np.asarray(slip, float)[first])
    return grid, np.maximum(curve(grid), 0.0)
