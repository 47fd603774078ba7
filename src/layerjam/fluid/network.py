"""A line in time: chamber, pump's side of the tube, reservoir, with the gas accounted for.

Nodes are the chamber, the pump's side (tube and what sits there) and the reservoir; their gas is
kept as N [Pa m^3], what p V would be at the atmosphere's temperature. Flows only move N from node
to node or in and out, so that what is in the line and what passed its borders add up at every step.
Pressures follow V p' = n (q - p V') with q the throughput at the temperature of the node it leaves.
With n = 1 that is the atmosphere's and N = p V; above 1 gas that expands cools and is denser, so
that a throughput q takes q N/(p V) along. A tube in cells adds the pressures along it and the flows
between them to the state; their gas is counted together.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.errors import QuantityError
from layerjam.fluid.flow import leaking, through_tube, through_valve
from layerjam.fluid.line import Line
from layerjam.fluid.pump import intake
from layerjam.fluid.tube import area, cell_volumes, in_cells, share_at_chamber

Array = npt.NDArray[np.float64]
CHAMBER, SIDE, RESERVOIR = range(3)
PUMPED, LEAKED, VENTED = 6, 7, 8
"""Places in the state after three pressures and three N: gas passed out and in so far [Pa m^3]."""
SIZE = 9
"""Length of the state without cells; the cells' pressures and flows stand behind."""
SHORTEST = 1e-12
"""Time [s] below which the integrator does not get on."""


CLOSE, CLOSE_IN_CELLS = 1e-11, 1e-6
"""Relative error asked of the integrator, and with a tube in cells."""
NUDGE = 1e-6
"""Change of a place of the state, over its size, for the derivative by it."""


class Drive(NamedTuple):
    """What is switched and moved: held over one step, or functions of time in `respond`."""

    pump: float = 1.0
    """Part of the pump's full flow, below zero backwards."""
    vent: float = 0.0
    """1 open."""
    store: float = 0.0
    """1: the reservoir's valve is open."""
    slip: float = 0.0
    """[m]"""
    pace: float = 0.0
    """Rate of the slip [m/s]."""


def side_volume(line: Line) -> float:
    """Gas on the pump's side [m^3]: that of the tube but for `nearby`; 0 without one."""
    return 0.0 if line.tube is None else area(line.tube) * line.tube.length - nearby(line)


def nearby(line: Line) -> float:
    """Gas of the tube that counts with the chamber [m^3]: half a cell of a tube in cells."""
    return 0.0 if line.tube is None else share_at_chamber(line.tube)


def cells(line: Line) -> int:
    """Cells of the tube."""
    return 0 if line.tube is None else line.tube.cells


def at_pressure(
    line: Line, p: float | None = None, stored: float | None = None, slip: float = 0.0
) -> Array:
    """All at one pressure [Pa absolute], the atmosphere unless given; the reservoir at `stored`."""
    a = line.site.atmosphere
    p = a if p is None else p
    store = a if stored is None else stored
    state = np.zeros(SIZE + 2 * cells(line))
    state[SIZE : SIZE + cells(line)] = p
    volume = gas_volume(line, p, slip)
    tank = 0.0 if line.reservoir is None else line.reservoir.volume
    state[:6] = p, p, store, p * volume, p * side_volume(line), store * tank
    return state


def gas_volume(line: Line, p: float, slip: float = 0.0) -> float:
    """Gas that shares the chamber's pressure [m^3], at p [Pa absolute] and a slip [m]."""
    chamber, vacuum = line.chamber, line.site.atmosphere - p
    own = chamber.volume + chamber.volume_per_slip * slip - chamber.shrink * vacuum
    return own + nearby(line)


def denseness(state: Array, volume: float, line: Line) -> tuple[float, float, float]:
    """N/(p V) of chamber, pump's side and reservoir: 1 at the atmosphere's temperature.

    `volume` is the chamber's [m^3]. 1 for a node without volume or pressure.
    """
    if line.polytropic == 1:
        return 1.0, 1.0, 1.0
    filled = [float(state[CHAMBER]) * volume, float(state[SIDE]) * side_volume(line), 0.0]
    if line.tube is not None and line.tube.cells:
        count = line.tube.cells
        filled[SIDE] = float(state[SIZE : SIZE + count] @ cell_volumes(line.tube))
    if line.reservoir is not None:
        filled[RESERVOIR] = float(state[RESERVOIR]) * line.reservoir.volume
    here, side, stored = (
        float(n) / pv if pv > 0 else 1.0 for n, pv in zip(state[3:6], filled, strict=True)
    )
    return here, side, stored


def rates(state: Array, drive: Drive, line: Line) -> Array:
    """Time derivative of the state."""
    a, chamber, n = line.site.atmosphere, line.chamber, line.polytropic
    p, side, stored = (float(v) for v in state[:3])
    joined = line.tube is None
    at_pump = p if joined else side
    volume = gas_volume(line, p, drive.slip)
    speed = drive.pump * line.pump.count
    out = speed * (intake(at_pump, line.pump, a) if speed >= 0 else line.pump.backwards * a)
    vent = 0.0
    if line.valve is not None and drive.vent > 0:
        vent = drive.vent * through_valve(
            a, at_pump, line.valve.conductance, line.valve.critical_ratio
        )
    leak = leaking(p, a, line.leak.laminar, line.leak.orifice)
    pull = 0.0
    if line.reservoir is not None and drive.store > 0:
        pull = drive.store * through_valve(p, stored, line.reservoir.conductance)
    along, count = 0.0, cells(line)
    if count:
        along = float(state[SIZE + count])
    elif line.tube is not None:
        along = through_tube(p, side, line.tube.length, line.tube.bore)
    into = leak - pull + (vent - out if joined else -along)
    moved = p * chamber.volume_per_slip * drive.pace
    dp = n * (into - moved) / (volume + n * p * chamber.shrink)
    made = np.zeros(SIZE + 2 * count)
    here, beside, kept = denseness(state, volume, line)
    gone = out * ((here if joined else beside) if out > 0 else 1.0)
    stowed, piped = pull * (here if pull > 0 else kept), along * (here if along > 0 else beside)
    made[CHAMBER], made[3] = dp, leak - stowed + (vent - gone if joined else -piped)
    if not joined:
        made[SIDE], made[4] = n * (along + vent - out) / side_volume(line), piped + vent - gone
        if count and line.tube is not None:
            nodes, flows = state[SIZE : SIZE + count], state[SIZE + count :]
            pressed, made[SIZE + count :] = in_cells(p, nodes, flows, out - vent, line.tube, n)
            made[SIZE : SIZE + count] = pressed
            made[SIDE] = pressed[-1]
    else:
        made[SIDE] = dp
    if line.reservoir is not None:
        made[RESERVOIR], made[5] = n * pull / line.reservoir.volume, stowed
    made[PUMPED], made[LEAKED], made[VENTED] = gone, leak, vent
    return made


def advance(state: Array, drive: Drive, line: Line, dt: float, steps: int = 1) -> Array:
    """`steps` classical Runge-Kutta steps over `dt` [s] with the drive held; fourth order."""
    h = dt / steps
    for _ in range(steps):
        half = drive._replace(slip=drive.slip + h / 2 * drive.pace)
        after = drive._replace(slip=drive.slip + h * drive.pace)
        k1 = rates(state, drive, line)
        k2 = rates(state + h / 2 * k1, half, line)
        k3 = rates(state + h / 2 * k2, half, line)
        k4 = rates(state + h * k3, after, line)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        drive = after
    return state


def imbalance(state: Array, start: Array) -> float:
    """Gas that cannot be accounted for, over all that was there or passed [1]."""
    held, before = float(state[3:6].sum()), float(start[3:6].sum())
    passed = state[PUMPED:SIZE] - start[PUMPED:SIZE]
    most = max(held, before, float(np.abs(passed).sum()))
    return abs(held - before + passed[0] - passed[1] - passed[2]) / most


@dataclass(frozen=True, kw_only=True, eq=False)
class Response:
    """A line in time: `time` [s], shape (N,), and `states` (N, 9 and more) as `rates` has them."""

    line: Line
    time: Array
    states: Array

    @property
    def vacuum(self) -> Array:
        """In the chamber [Pa]."""
        return self.line.site.atmosphere - self.states[:, CHAMBER]

    @property
    def imbalance(self) -> float:
        """Of the gas, from begin to end."""
        return imbalance(self.states[-1], self.states[0])

    def crossing(self, vacuum: float) -> float | None:
        """When the vacuum [Pa] passes a value first [s], by cubic interpolation; None if never."""
        here = self.vacuum - vacuum
        passes = np.flatnonzero(here[:-1] * here[1:] <= 0)
        if not len(passes):
            return None
        i = int(passes[0])
        from scipy.interpolate import CubicSpline
        from scipy.optimize import brentq

        low, high = max(i - 3, 0), min(i + 5, len(here))
        curve = CubicSpline(self.time[low:high], here[low:high])
        if here[i] == 0:
            return float(self.time[i])
        return float(brentq(curve, self.time[i], self.time[i + 1], xtol=1e-15, rtol=1e-14))


def _sizes(begin: Array, line: Line) -> Array:
    sizes = np.maximum(begin, 1e-9)
    if line.tube is not None and line.tube.cells:  # flows and what has passed begin at nothing
        sizes[SIZE + line.tube.cells :] = area(line.tube) * line.site.atmosphere
        sizes[PUMPED:SIZE] = np.maximum(sizes[PUMPED:SIZE], begin[3])
        sizes[2] = sizes[5] = max(float(sizes[2]), 1.0)
    return sizes


def respond(
    line: Line,
    duration: float,
    drive: Drive | Callable[[float], Drive] = Drive(),
    start: Array | None = None,
    samples: int = 401,
    progress: Callable[[float], None] | None = None,
) -> Response:
    """Integrate a line over `duration` [s] by SciPy's LSODA at a relative error of `CLOSE`.

    A tube in cells by Radau, which steps over waves once they have died away. `drive` is one for
    all the time, or a function of time that has no jumps. `progress` is called with the share done.
    Raises QuantityError where the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    if not (math.isfinite(duration) and duration >= SHORTEST):
        raise QuantityError(
            f"duration: {duration} s is not allowed; it is at least {SHORTEST:g} s and finite"
        )
    begin = at_pressure(line) if start is None else start
    at: Callable[[float], Drive] = drive if callable(drive) else lambda _: drive
    sizes = _sizes(begin, line)

    def change(t: float, state: Array) -> Array:
        if progress is not None:
            progress(t / duration)
        return rates(state, at(t), line)

    def by_each(t: float, state: Array) -> Array:
        base = change(t, state)
        steps = NUDGE * np.diag(sizes)
        return np.array([(change(t, state + s) - base) / s.sum() for s in steps]).T

    waves: dict[str, Any] = {"method": "Radau", "rtol": CLOSE_IN_CELLS, "jac": by_each}
    how = waves if cells(line) else {"method": "LSODA", "rtol": CLOSE}
    with warnings.catch_warnings():
        # what goes wrong is said below, once
        warnings.filterwarnings("ignore", message="lsoda:", category=UserWarning)
        made: Any = solve_ivp(
            change,
            (0.0, duration),
            begin,
            t_eval=np.linspace(0.0, duration, samples),
            atol=(1e-8 if cells(line) else 1e-9) * sizes,
            **how,
        )
    if not made.success:
        raise QuantityError(f"line: cannot be integrated over {duration} s: {made.message[:100]}")
    return Response(line=line, time=made.t, states=made.y.T)
