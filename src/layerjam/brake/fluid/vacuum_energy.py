"""Energy of a vacuum: work to jam, power to hold, and heat in the brake per energy spent.

The minimum work is that of an isothermal, reversible pump to the atmosphere a: dW = ln(a/p) dN,
with N = p V at one temperature. Real pumps need many times as much; their electric energy is known
if `pump.power` is.
"""

import math
from typing import NamedTuple

import numpy as np

from layerjam.brake.fluid.flow import leak_throughput
from layerjam.brake.fluid.line import Line, water_compliance
from layerjam.brake.fluid.network import CHAMBER, PUMPED, SIDE, Response
from layerjam.brake.fluid.pump import pump_throughput


def emptying_work(p: float, volume: float, atmosphere: float) -> float:
    """Return the minimum work [J] to evacuate a vessel [m^3] from atmosphere to p [Pa absolute].

    It is V (a - p - p ln(a/p)), at most V a.
    """
    return volume * (atmosphere - p - (p * math.log(atmosphere / p) if p > 0 else 0.0))


def jam_work(vacuum: float, line: Line, water: bool = False, standing: float = 0.0) -> float:
    """Return a pump's minimum work [J] from an idle vacuum [Pa] to a higher one, without a leak.

    It is the integral of ln(a/p) d(pV) with V = V0 - C_w vacuum for air, C P^2/2 for water.
    """
    if standing:
        return jam_work(vacuum, line, water) - jam_work(standing, line, water)
    chamber, a = line.chamber, line.site.atmosphere
    if water:
        return water_compliance(line) * vacuum**2 / 2
    p = a - vacuum
    logarithm = p * p * math.log(a / p) if p > 0 else 0.0
    shrunk = chamber.shrink * ((a * a - p * p) / 2 - logarithm)
    return emptying_work(p, chamber.volume - chamber.shrink * a, a) + shrunk


def refill_work(before: float, after: float, line: Line) -> float:
    """Return the minimum work [J] to pump the reservoir from pressure `before` to `after` [Pa]."""
    if line.reservoir is None:
        return 0.0
    volume, a = line.reservoir.volume, line.site.atmosphere
    return emptying_work(after, volume, a) - emptying_work(before, volume, a)


def pumped_work(response: Response) -> float:
    """Return the minimum work [J] for the gas pumped during a run, including leaks.

    It uses the trapezoidal rule over the samples of a Response.
    """
    a = response.line.site.atmosphere
    inlet = response.states[:, CHAMBER if response.line.tube is None else SIDE]
    if not (inlet > 0).all():
        return math.nan
    ratio = np.log(a / inlet)
    amounts = np.diff(response.states[:, PUMPED])
    return float(np.sum(amounts * (ratio[1:] + ratio[:-1]) / 2))


def electric_energy(duration: float, line: Line) -> float | None:
    """Return the electric energy [J] of the pumps at full power; None if their power is unknown."""
    if line.pump.power is None:
        return None
    return line.pump.power * line.pump.count * duration


class Holding(NamedTuple):
    """Cost of holding a vacuum against the leak."""

    leak: float
    """Throughput of the leak at this vacuum [Pa m^3/s]."""
    least_power: float
    """Power of an isothermal, reversible pump [W]."""
    duty: float
    """Fraction of the time, or of the flow, that the pumps need; above 1 they are too weak."""
    electric_power: float | None
    """Duty times electric power [W]; None if the power is unknown or the duty is above 1."""


def holding_cost(vacuum: float, line: Line) -> Holding:
    """Return the cost of holding a vacuum [Pa] in air; the leaked gas is pumped out at p."""
    a = line.site.atmosphere
    p = a - vacuum
    leak = leak_throughput(p, a, line.leak.laminar, line.leak.orifice)
    if leak == 0:
        return Holding(0.0, 0.0, 0.0, None if line.pump.power is None else 0.0)
    able = line.pump.count * pump_throughput(p, line.pump, a)
    duty = leak / able if able > 0 else math.inf
    min_power = leak * math.log(a / p) if p > 0 else math.inf
    if line.pump.power is None or duty > 1:
        return Holding(leak, min_power, duty, None)
    return Holding(leak, min_power, duty, duty * line.pump.power * line.pump.count)


def heat_per_joule(heat: float, cost: float | None) -> float | None:
    """Return the ratio of heat in the brake to energy spent on its vacuum; None if unknown."""
    return None if cost is None or cost <= 0 else heat / cost
