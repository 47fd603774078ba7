"""What a vacuum costs: work of a jam, power to hold it, joules dissipated per joule pumped.

Least work is that of an isothermal, reversible pump that pushes the gas out into the atmosphere,
dW = ln(a/p) dN, with N = p V counted at one temperature and a the atmosphere. Real pumps take many
times as much; their electric energy is known where `pump.power` is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from layerjam.fluid.flow import leaking
from layerjam.fluid.line import Line, water_compliance
from layerjam.fluid.network import CHAMBER, PUMPED, SIDE, Response
from layerjam.fluid.pump import intake


def emptying_work(p: float, volume: float, atmosphere: float) -> float:
    """Least work [J] to bring a vessel [m^3] from the atmosphere down to p [Pa absolute].

    V (a - p - p ln(a/p)), at most V a.
    """
    return volume * (atmosphere - p - (p * math.log(atmosphere / p) if p > 0 else 0.0))


def jam_work(vacuum: float, line: Line, water: bool = False, standing: float = 0.0) -> float:
    """Least work of a pump [J] for one jam, from a idle vacuum [Pa] to another, without leak.

    Air: the integral of ln(a/p) d(pV) with V = V0 - C_w vacuum; water: C P^2/2.
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
    """Least work [J] to bring the reservoir back from one absolute pressure [Pa] to another."""
    if line.reservoir is None:
        return 0.0
    volume, a = line.reservoir.volume, line.site.atmosphere
    return emptying_work(after, volume, a) - emptying_work(before, volume, a)


def pumped_work(made: Response) -> float:
    """Least work [J] of the gas that the pump took out along a run, the leak's share included.

    Trapezoids over the samples of a Response.
    """
    a = made.line.site.atmosphere
    at = made.states[:, CHAMBER if made.line.tube is None else SIDE]
    if not (at > 0).all():
        return math.nan
    ratio = np.log(a / at)
    gone = np.diff(made.states[:, PUMPED])
    return float(np.sum(gone * (ratio[1:] + ratio[:-1]) / 2))


def electric_energy(duration: float, line: Line) -> float | None:
    """What the pumps draw [J] while they run full on; None where their power is not known."""
    if line.pump.power is None:
        return None
    return line.pump.power * line.pump.count * duration


class Holding(NamedTuple):
    """What it takes to hold a vacuum against the leak."""

    leak: float
    """Throughput of the leak [Pa m^3/s]."""
    least_power: float
    """Isothermal and reversible [W]."""
    duty: float
    """Part of the time, or of the flow, that the pumps are needed; above 1 they cannot hold it."""
    electric_power: float | None
    """Duty times electric power [W]; None where that is not known or the duty is above 1."""


def holding(vacuum: float, line: Line) -> Holding:
    """Standing cost of a vacuum [Pa] in air; the leak's gas comes out through the pump at p."""
    a = line.site.atmosphere
    p = a - vacuum
    leak = leaking(p, a, line.leak.laminar, line.leak.orifice)
    if leak == 0:
        return Holding(0.0, 0.0, 0.0, None if line.pump.power is None else 0.0)
    able = line.pump.count * intake(p, line.pump, a)
    duty = leak / able if able > 0 else math.inf
    least = leak * math.log(a / p) if p > 0 else math.inf
    if line.pump.power is None or duty > 1:
        return Holding(leak, least, duty, None)
    return Holding(leak, least, duty, duty * line.pump.power * line.pump.count)


def per_joule(dissipated: float, spent: float | None) -> float | None:
    """Joules the brake turns into heat per joule spent on its vacuum; None where none is known."""
    return None if spent is None or spent <= 0 else dissipated / spent
