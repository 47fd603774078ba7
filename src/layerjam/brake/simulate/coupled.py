"""Coupled simulation of brake and line: enclosure stretch, pump and vacuum affect one another.

The method is waveform relaxation. The slip determines the vacuum (equations of the line), and the
vacuum determines the slip (solver of the brake in time); this is repeated until neither changes. If
the gas volume grows by A_s per unit slip, the vacuum P adds a force P A_s (`gas_force`). It is not
added to the brake's law, because a brake calibrated by a pull already includes it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.closed_forms import reachable_vacuum, total_pump_flow
from layerjam.brake.fluid.line import Line, water_compliance
from layerjam.brake.fluid.network import (
    CHAMBER,
    SIZE,
    Drive,
    Response,
    state_at_pressure,
    state_rates,
)
from layerjam.brake.simulate.drop import TimedStop, drop
from layerjam.brake.simulate.drop_in_time import drop_in_time
from layerjam.brake.simulate.record import DropRecord
from layerjam.brake.simulate.vacuum_history import History
from layerjam.core.errors import QuantityError
from layerjam.core.units import show

Array = npt.NDArray[np.float64]
TOLERANCE = 1e-6
"""Relative change of slip, peak and vacuum between iterations at convergence."""
ROUNDS = 25
NODES = 241
"""Number of instants at which an iteration samples the vacuum for the brake's solver."""
MATTERS = 0.01
"""Relative change of slip or peak above which the coupling matters."""


@dataclass(frozen=True, eq=False)
class CoupledStop:
    """Stop coupled with its vacuum line, and the same stop at constant vacuum for comparison."""

    timed: TimedStop
    record: DropRecord
    line: Response
    """State of chamber, tube and reservoir until the standstill; for water only the pressure."""
    constant: TimedStop
    """The exact stop at the vacuum at which the rope becomes taut."""
    changes: tuple[float, ...]
    """Largest relative change of slip, peak and vacuum in each iteration."""

    @property
    def rounds(self) -> int:
        """Number of iterations."""
        return len(self.changes)

    @property
    def last_change(self) -> float:
        """Relative change in the last iteration [1]."""
        return self.changes[-1]

    @property
    def vacuum_change(self) -> float:
        """Change of vacuum from when the rope is taut to the standstill [Pa]."""
        return float(self.line.vacuum[-1] - self.line.vacuum[0])

    @property
    def slip_change(self) -> float:
        """Change of slip relative to constant vacuum [m]."""
        return self.timed.slip - self.constant.slip

    @property
    def peak_change(self) -> float:
        """Change of peak force relative to constant vacuum [N]."""
        return self.timed.peak_force - self.constant.peak_force

    @property
    def is_significant(self) -> bool:
        """Return whether the coupling changes the outcome, or slip or peak by more than 1 %."""
        stop, constant = self.timed, self.constant
        return (
            stop.outcome is not constant.outcome
            or abs(self.slip_change) > MATTERS * constant.slip
            or abs(self.peak_change) > MATTERS * constant.peak_force
        )

    @property
    def gas_force(self) -> float:
        """P A_s when the rope becomes taut [N]: the force due to the volume per slip."""
        return float(self.line.vacuum[0]) * self.line.line.chamber.volume_per_slip

    matters, remaining = is_significant, last_change  # former names


def integrate_line_along(
    line: Line, start: Array, time: Array, slip: Array, drive: Drive, water: bool = False
) -> Response:
    """Return the state of the line at times [s] for a given slip of the brake [m], shape (N,) each.

    Monotone cubics (PCHIP) interpolate the slip, so that the slip speed is continuous. For air,
    LSODA integrates with a relative error of 1e-9 and conserves gas to within rounding. For water,
    C P = F t + A_s slip until the water boils.
    """
    if water:
        return _integrate_water_along(line, start, time, slip, drive)
    from scipy.integrate import solve_ivp
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(time, slip)
    pace = curve.derivative()

    def change(t: float, state: Array) -> Array:
        drive_now = drive._replace(slip=float(curve(t)), pace=float(pace(t)))
        return state_rates(state, drive_now, line)

    scale = np.maximum(np.abs(start), np.abs(start[CHAMBER]) * 1e-6)
    span, tolerance = (float(time[0]), float(time[-1])), 1e-10 * np.maximum(scale, 1e-6)
    result: Any = solve_ivp(change, span, start, "LSODA", time, rtol=1e-9, atol=tolerance)
    if not result.success:
        raise QuantityError(f"line: cannot be integrated along the stop: {result.message[:100]}")
    return Response(line=line, time=result.t, states=result.y.T)


def _integrate_water_along(
    line: Line, start: Array, time: Array, slip: Array, drive: Drive
) -> Response:
    volume = drive.pump * total_pump_flow(line) * (time - time[0])
    volume = volume + line.chamber.volume_per_slip * (slip - slip[0])
    begin = line.site.atmosphere - start[CHAMBER]
    vacuum = begin + volume / water_compliance(line)
    states = np.zeros((len(time), SIZE))
    states[:, :2] = (
        line.site.atmosphere - np.minimum(vacuum, max(reachable_vacuum(line, True), begin))[:, None]
    )
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
    """Stop a mass [kg] that arrives with `speed` [m/s] while the line is active; all in SI.

    `start` is the line's state at the taut rope, or its vacuum [Pa]; `drive` sets pump and
    reservoir during the stop (its slip is not used). Raises QuantityError if the iterations do not
    converge to `tolerance`, or for invalid inputs.
    """
    a = line.site.atmosphere
    state = state_at_pressure(line, a - start) if isinstance(start, int | float) else start
    vacuum = a - float(state[CHAMBER])
    case: Any = {"mass": mass, "speed": speed, "rope_stiffness": rope_stiffness, "gravity": gravity}
    constant, record = drop(file, vacuum=vacuum, **case)
    response = integrate_line_along(line, state, *_time_nodes(record, nodes), drive, water)
    slip, peak, step = constant.slip, constant.peak_force, None
    changes: list[float] = []
    for _ in range(rounds):
        previous, history = response, History(response.time, response.vacuum)
        stop, record = drop_in_time(file, vacuum=history, step=step, **case)
        response = integrate_line_along(line, state, *_time_nodes(record, nodes), drive, water)
        slip_change = abs(stop.slip - slip) / max(stop.slip, 1e-9)
        peak_change = abs(stop.peak_force - peak) / stop.peak_force
        changes.append(max(slip_change, peak_change, _vacuum_difference(previous, response) / a))
        if changes[-1] <= tolerance:
            return CoupledStop(stop, record, response, constant, tuple(changes))
        slip, peak, step = stop.slip, stop.peak_force, record.step
    raise QuantityError(
        f"chamber.volume_per_slip: {show(line.chamber.volume_per_slip, 'm^2')} couples brake and "
        f"line so strongly that iteration {len(changes)} still changes the stop by "
        f"{changes[-1]:.1e}; at most {tolerance:.0e} is allowed"
    )


def _vacuum_difference(old: Response, new: Response) -> float:
    return float(np.max(np.abs(np.interp(new.time, old.time, old.vacuum) - new.vacuum)))


def _time_nodes(record: DropRecord, nodes: int) -> tuple[Array, Array]:
    """Return equally spaced times [s] of a stop and the slip [m] there, by monotone cubics."""
    from scipy.interpolate import PchipInterpolator

    times, first = np.unique(record.time, return_index=True)
    grid = np.linspace(times[0], times[-1], nodes)
    curve = PchipInterpolator(times, record.slip[first])
    return grid, np.maximum(curve(grid), 0.0)
