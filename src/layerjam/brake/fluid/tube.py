"""Delay of a tube: the pressure wave, the lag due to its resistance, and both with cells.

A wave of small amplitude travels at c = sqrt(n R T). This is 290 m/s at constant temperature (n =
1, narrow tubes) and 343 m/s without heat exchange (n = 1.4). In N cells, per unit length,

    A dp/dt = -n dq/dx,    dq/dt = R T (-A dp/dx - 32 mu q / (p d^2)),

with q the throughput. These are the continuity and momentum equations with laminar friction,
without the convective term, which is small far below c. For constant q they are exactly
Poiseuille's law for a gas.
"""

import math

import numpy as np
import numpy.typing as npt

from layerjam.brake.fluid.flow import SPECIFIC_GAS, TEMPERATURE, VISCOSITY, tube_conductance
from layerjam.brake.fluid.line import Line, Tube

Array = npt.NDArray[np.float64]
LAMINAR_UP_TO = 2300.0
"""Reynolds number up to which flow in a pipe is laminar (handbook)."""


def sound_speed(polytropic: float = 1.0) -> float:
    """Return the speed of a pressure wave [m/s] in air at 20 degC for this exponent."""
    return math.sqrt(polytropic * SPECIFIC_GAS * TEMPERATURE)


def wave_delay(tube: Tube, polytropic: float = 1.0) -> float:
    """Return the travel time [s] of a pressure wave along the tube."""
    return tube.length / sound_speed(polytropic)


def filling_lag(line: Line, p: float) -> float:
    """Return the time constant [s] of chamber volume and tube resistance at p [Pa absolute].

    It is V / (2 n K p), which is longer for thinner gas; inf at p = 0, and 0 without a tube.
    """
    if line.tube is None:
        return 0.0
    volume = line.chamber.volume - line.chamber.shrink * (line.site.atmosphere - p)
    passes = 2 * line.polytropic * tube_conductance(line.tube.length, line.tube.bore) * p
    return volume / passes if p > 0 else math.inf


def reynolds_number(throughput: float, bore: float) -> float:
    """Return the Reynolds number of a throughput [Pa m^3/s]: 4 (q / R T) / (pi d mu)."""
    return 4 * throughput / (SPECIFIC_GAS * TEMPERATURE * math.pi * bore * VISCOSITY)


def tube_area(tube: Tube) -> float:
    """Return the cross-sectional area [m^2]."""
    return math.pi / 4 * tube.bore**2


def chamber_cell_volume(tube: Tube) -> float:
    """Return the gas volume of the tube that is counted with the chamber [m^3]: half a cell."""
    return tube_area(tube) * tube.length / tube.cells / 2 if tube.cells else 0.0


def cell_volumes(tube: Tube) -> Array:
    """Return the gas volumes at the cells' far ends [m^3], shape (N,); half a cell at the pump."""
    volumes = np.full(tube.cells, tube_area(tube) * (tube.length / tube.cells))
    volumes[-1] /= 2
    return volumes


def cell_rates(
    p: float, nodes: Array, flows: Array, out: float, tube: Tube, polytropic: float
) -> tuple[Array, Array]:
    """Return the rates of the pressures [Pa/s] at the cells' far ends and of the flows, shape (N,).

    `p` is the chamber's pressure, `out` the throughput that leaves at the pump [Pa m^3/s]. Each end
    has half a cell of gas, which makes the scheme second-order in 1/N.
    """
    step = tube.length / tube.cells
    ends = np.concatenate(([p], nodes))
    mean = (ends[1:] + ends[:-1]) / 2
    # a trial step of the integrator may pass through zero, where no gas flows
    drag = 32 * VISCOSITY * flows / (np.maximum(mean, 1e-3) * tube.bore**2)
    pace = SPECIFIC_GAS * TEMPERATURE * (-tube_area(tube) * np.diff(ends) / step - drag)
    return polytropic * (flows - np.append(flows[1:], out)) / cell_volumes(tube), pace
