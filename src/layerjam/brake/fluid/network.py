"""Simulation of a line: chamber, pump's side of the tube and reservoir, with a gas balance.

Nodes are the chamber, the pump's side (tube and its ends) and the reservoir. Their gas is stored as
N [Pa m^3], which is p V at the atmosphere's temperature. Flows only move N between nodes or across
the boundary, so that the balance closes at every step. Pressures follow V p' = n (q - p V'), with q
the throughput at the temperature of the node that it leaves. For n = 1 that is the temperature of
the atmosphere and N = p V. For n above 1, expanding gas cools and becomes denser, so that a
throughput q carries q N/(p V). A tube divided into cells adds to the state the pressures along it
and the flows between the cells; the cells' gas is counted together.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.fluid.flow import leak_throughput, tube_throughput, valve_throughput
from layerjam.brake.fluid.line import Line
from layerjam.brake.fluid.pump import pump_throughput
from layerjam.brake.fluid.tube import cell_rates, cell_volumes, chamber_cell_volume, tube_area
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError

Array = npt.NDArray[np.float64]
CHAMBER, SIDE, RESERVOIR = range(3)
PUMPED, LEAKED, VENTED = 6, 7, 8
"""Indices in the state, after three pressures and three N, of gas that left or entered [Pa m^3]."""
SIZE = 9
"""Length of the state without cells; the pressures and flows of cells come after that."""
SHORTEST = 1e-12
"""Shortest time [s] that the integrator resolves."""


CLOSE, CLOSE_IN_CELLS = 1e-11, 1e-6
"""Relative error tolerances of the integrator: without cells, and with a tube split into cells."""
NUDGE = 1e-6
"""Relative change of one entry of the state for a numerical derivative."""


class Drive(NamedTuple):
    """Inputs: switches and motion, constant over one step, or a function of time in `respond`."""

    pump: float = 1.0
    """Fraction of the pump's full flow; negative if the pump runs backwards."""
    vent: float = 0.0
    """Opening of the vent valve; 1 means open."""
    store: float = 0.0
    """Opening of the reservoir's valve; 1 means open."""
    slip: float = 0.0
    """Slip [m]."""
    pace: float = 0.0
    """Rate of the slip [m/s]."""


def pump_volume(line: Line) -> float:
    """Return the gas volume on the pump's side [m^3]: the tube's except `end_volume`, or 0."""
    return 0.0 if line.tube is None else tube_area(line.tube) * line.tube.length - end_volume(line)


def end_volume(line: Line) -> float:
    """Return the tube's gas volume that is counted with the chamber [m^3]: half a cell, or 0."""
    return 0.0 if line.tube is None else chamber_cell_volume(line.tube)


def cell_count(line: Line) -> int:
    """Return the number of cells of the tube."""
    return 0 if line.tube is None else line.tube.cells


def state_at_pressure(
    line: Line, p: float | None = None, tank_pressure: float | None = None, slip: float = 0.0
) -> Array:
    """Return a state at p [Pa absolute], the reservoir at `tank_pressure` or atmospheric."""
    a = line.site.atmosphere
    p = a if p is None else p
    tank_p = a if tank_pressure is None else tank_pressure
    state = np.zeros(SIZE + 2 * cell_count(line))
    state[SIZE : SIZE + cell_count(line)] = p
    volume = gas_volume(line, p, slip)
    tank = 0.0 if line.reservoir is None else line.reservoir.volume
    state[:6] = p, p, tank_p, p * volume, p * pump_volume(line), tank_p * tank
    return state


def gas_volume(line: Line, p: float, slip: float = 0.0) -> float:
    """Return the gas volume [m^3] at the chamber's pressure, for p [Pa absolute] and a slip [m]."""
    chamber, vacuum = line.chamber, line.site.atmosphere - p
    volume = chamber.volume + chamber.volume_per_slip * slip - chamber.shrink * vacuum
    return volume + end_volume(line)


def relative_density(state: Array, volume: float, line: Line) -> tuple[float, float, float]:
    """Return N/(p V) of chamber, pump's side and reservoir: 1 at the atmosphere's temperature.

    `volume` is that of the chamber [m^3]. The result is 1 for a node without volume or pressure.
    """
    if line.polytropic == 1:
        return 1.0, 1.0, 1.0
    products = [float(state[CHAMBER]) * volume, float(state[SIDE]) * pump_volume(line), 0.0]
    if line.tube is not None and line.tube.cells:
        count = line.tube.cells
        products[SIDE] = float(state[SIZE : SIZE + count] @ cell_volumes(line.tube))
    if line.reservoir is not None:
        products[RESERVOIR] = float(state[RESERVOIR]) * line.reservoir.volume
    chamber, side, tank = (
        float(n) / pv if pv > 0 else 1.0 for n, pv in zip(state[3:6], products, strict=True)
    )
    return chamber, side, tank


def state_rates(state: Array, drive: Drive, line: Line) -> Array:
    """Return the time derivative of the state."""
    a, chamber, n = line.site.atmosphere, line.chamber, line.polytropic
    p, side, tank = (float(v) for v in state[:3])
    joined = line.tube is None
    at_pump = p if joined else side
    volume = gas_volume(line, p, drive.slip)
    speed = drive.pump * line.pump.count
    out = speed * (
        pump_throughput(at_pump, line.pump, a) if speed >= 0 else line.pump.backwards * a
    )
    vent = 0.0
    if line.valve is not None and drive.vent > 0:
        vent = drive.vent * valve_throughput(
            a, at_pump, line.valve.conductance, line.valve.critical_ratio
        )
    leak = leak_throughput(p, a, line.leak.laminar, line.leak.orifice)
    pull = 0.0
    if line.reservoir is not None and drive.store > 0:
        pull = drive.store * valve_throughput(p, tank, line.reservoir.conductance)
    tube_flow, count = 0.0, cell_count(line)
    if count:
        tube_flow = float(state[SIZE + count])
    elif line.tube is not None:
        tube_flow = tube_throughput(p, side, line.tube.length, line.tube.bore)
    into = leak - pull + (vent - out if joined else -tube_flow)
    stretch_flow = p * chamber.volume_per_slip * drive.pace
    dp = n * (into - stretch_flow) / (volume + n * p * chamber.shrink)
    rate = np.zeros(SIZE + 2 * count)
    dense, dense_side, dense_tank = relative_density(state, volume, line)
    outflow = out * ((dense if joined else dense_side) if out > 0 else 1.0)
    to_tank = pull * (dense if pull > 0 else dense_tank)
    to_side = tube_flow * (dense if tube_flow > 0 else dense_side)
    rate[CHAMBER], rate[3] = dp, leak - to_tank + (vent - outflow if joined else -to_side)
    if not joined:
        rate[SIDE] = n * (tube_flow + vent - out) / pump_volume(line)
        rate[4] = to_side + vent - outflow
        if count and line.tube is not None:
            nodes, flows = state[SIZE : SIZE + count], state[SIZE + count :]
            node_rates, rate[SIZE + count :] = cell_rates(p, nodes, flows, out - vent, line.tube, n)
            rate[SIZE : SIZE + count] = node_rates
            rate[SIDE] = node_rates[-1]
    else:
        rate[SIDE] = dp
    if line.reservoir is not None:
        rate[RESERVOIR], rate[5] = n * pull / line.reservoir.volume, to_tank
    rate[PUMPED], rate[LEAKED], rate[VENTED] = outflow, leak, vent
    return rate


def advance(state: Array, drive: Drive, line: Line, dt: float, steps: int = 1) -> Array:
    """Return the state after `steps` fourth-order Runge-Kutta steps over `dt` [s]."""
    h = dt / steps
    for _ in range(steps):
        mid_drive = drive._replace(slip=drive.slip + h / 2 * drive.pace)
        drive_after = drive._replace(slip=drive.slip + h * drive.pace)
        k1 = state_rates(state, drive, line)
        k2 = state_rates(state + h / 2 * k1, mid_drive, line)
        k3 = state_rates(state + h / 2 * k2, mid_drive, line)
        k4 = state_rates(state + h * k3, drive_after, line)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        drive = drive_after
    return state


def gas_imbalance(state: Array, start: Array) -> float:
    """Return the gas that is unaccounted for, relative to the gas present or passed [1]."""
    total, initial_gas = float(state[3:6].sum()), float(start[3:6].sum())
    flows = state[PUMPED:SIZE] - start[PUMPED:SIZE]
    scale = max(total, initial_gas, float(np.abs(flows).sum()))
    return abs(total - initial_gas + flows[0] - flows[1] - flows[2]) / scale


@brief
@dataclass(frozen=True, kw_only=True, eq=False)
class Response:
    """Response of a line: `time` [s], (N,), and `states`, (N, 9 or more), as in `state_rates`."""

    line: Line
    time: Array = field(repr=False)
    states: Array = field(repr=False)

    @property
    def vacuum(self) -> Array:
        """Vacuum in the chamber [Pa]."""
        return self.line.site.atmosphere - self.states[:, CHAMBER]

    @property
    def imbalance(self) -> float:
        """Relative imbalance of the gas from start to end."""
        return gas_imbalance(self.states[-1], self.states[0])

    def crossing(self, vacuum: float) -> float | None:
        """Return the first time [s] at a vacuum [Pa], by cubic interpolation, or None if never."""
        excess = self.vacuum - vacuum
        passes = np.flatnonzero(excess[:-1] * excess[1:] <= 0)
        if not len(passes):
            return None
        i = int(passes[0])
        from scipy.interpolate import CubicSpline
        from scipy.optimize import brentq

        low, high = max(i - 3, 0), min(i + 5, len(excess))
        curve = CubicSpline(self.time[low:high], excess[low:high])
        if excess[i] == 0:
            return float(self.time[i])
        return float(brentq(curve, self.time[i], self.time[i + 1], xtol=1e-15, rtol=1e-14))


def _state_scales(begin: Array, line: Line) -> Array:
    sizes = np.maximum(begin, 1e-9)
    if line.tube is not None and line.tube.cells:  # flows and moved amounts of gas start at zero
        sizes[SIZE + line.tube.cells :] = tube_area(line.tube) * line.site.atmosphere
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
    """Integrate a line over `duration` [s] by SciPy's LSODA with a relative error of `CLOSE`.

    For a tube divided into cells it uses Radau, which steps over waves that have decayed. `drive`
    is constant or a function of time without jumps. `progress` is called with the completed
    fraction. Raises QuantityError if the integrator fails.
    """
    from scipy.integrate import solve_ivp

    if not (math.isfinite(duration) and duration >= SHORTEST):
        raise QuantityError(
            f"duration: {duration} s is not allowed; it must be finite and at least {SHORTEST:g} s"
        )
    begin = state_at_pressure(line) if start is None else start
    drive_at: Callable[[float], Drive] = drive if callable(drive) else lambda _: drive
    sizes = _state_scales(begin, line)

    def state_rate(t: float, state: Array) -> Array:
        if progress is not None:
            progress(t / duration)
        return state_rates(state, drive_at(t), line)

    def estimate_jacobian(t: float, state: Array) -> Array:
        base = state_rate(t, state)
        steps = NUDGE * np.diag(sizes)
        return np.array([(state_rate(t, state + s) - base) / s.sum() for s in steps]).T

    waves: dict[str, Any] = {"method": "Radau", "rtol": CLOSE_IN_CELLS, "jac": estimate_jacobian}
    options = waves if cell_count(line) else {"method": "LSODA", "rtol": CLOSE}
    with warnings.catch_warnings():
        # a failure is reported only once, below
        warnings.filterwarnings("ignore", message="lsoda:", category=UserWarning)
        solution: Any = solve_ivp(
            state_rate,
            (0.0, duration),
            begin,
            t_eval=np.linspace(0.0, duration, samples),
            atol=(1e-8 if cell_count(line) else 1e-9) * sizes,
            **options,
        )
    if not solution.success:
        reason = solution.message[:100]
        raise QuantityError(f"line: cannot be integrated over {duration} s: {reason}")
    return Response(line=line, time=solution.t, states=solution.y.T)
