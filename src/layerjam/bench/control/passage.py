"""A tube between pump and chamber: two volumes, and the rise of vacuum that may be expected.

With p = atmosphere - v of chamber and side (the tube's gas, where pump and vent act),

    v' = passes (p^2 - s^2) - leak v,
    volume w' = -passes (p^2 - s^2) + u k (top - w) - vent w,    s = atmosphere - w,

all rates relative to the chamber. The rise that the law expects is proportional to the pump command
and decreases linearly with the vacuum; behind a tube, a parabola limits it (`owed_rise`).
"""

import functools
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
DEEPEST = 0.05
"""Lowest pressure for which the expected rise is fitted, as a fraction of the atmosphere."""
GRID = 400


UNBOUNDED = 1e15
"""Rise [Pa/s] that stands for "not limited by a tube"."""


class Owed(NamedTuple):
    """Rise of the vacuum expected of a healthy pump; it never exceeds the true rise.

    At a command u and a vacuum v, it is the smaller of u rate (top - weight v) and most - less v +
    bend v^2. The latter is the parabola of a vacuum that rises at full pump power behind a tube.
    """

    rate: float
    top: float
    weight: float = 1.0
    most: float = UNBOUNDED
    less: float = 0.0
    bend: float = 0.0
    ratio: float = 1.0
    """Largest ratio of the true rise to the expected one, at any pump command."""

    def rise_at(self, vacuum: Any, command: Any = 1.0) -> Any:
        """Return the rise [Pa/s] before subtracting the leak; vacuum [Pa] and command broadcast."""
        through = self.most - (self.less - self.bend * vacuum) * vacuum
        return np.minimum(command * self.rate * (self.top - self.weight * vacuum), through)


@dataclass(frozen=True, kw_only=True)
class Passage:
    """Tube of the plant, relative to the chamber's volume."""

    volume: float
    """Gas volume of the tube relative to that of the chamber [1]."""
    passes: float
    """Ratio of flow to the difference between the squared pressures [1/(s Pa)]."""
    atmosphere: float
    """Pressure around the line [Pa]."""
    vacuum: float
    """Highest vacuum for which the detectors are tuned [Pa]."""

    def pump_pressure(self, p: Any, rate: Any, lowest: float) -> Any:
        """Return the pressure at the pump [Pa] at which it draws the flow that arrives from p."""
        half_flow = rate / (2 * self.passes)
        square = p * p + 2 * half_flow * lowest + half_flow * half_flow
        return (p * p + 2 * half_flow * lowest) / (np.sqrt(square) + half_flow)

    def rise(self, vacuum: Any, rate: Any, top: float) -> Any:
        """Return the rise of the chamber's vacuum [Pa/s] while a pump with this rate runs."""
        p, low = self.atmosphere - np.asarray(vacuum, float), self.atmosphere - top
        s = self.pump_pressure(p, rate, low)
        # the gas in the tube is also pumped out, as far as its pressure follows the chamber's
        follows = p / (s + rate / (2 * self.passes))
        return rate * (s - low) / (1 + self.volume * follows)

    def exchange_time(self, vacuum: float) -> float:
        """Return the time constant [s] with which the pressures of chamber and tube equalise."""
        p = max(self.atmosphere - vacuum, DEEPEST * self.atmosphere)
        return self.volume / (1 + self.volume) / (2 * self.passes * p)

    def pump_lag(self, rate: Any, p: Any) -> Any:
        """Return the time constant [s] after which a pump acts on a chamber at p [Pa absolute]."""
        return self.volume / (rate + 2 * self.passes * p * (1 + self.volume))

    lag = pump_lag  # former name

    def delayed_rise(self, rate: float, owed: Owed, switched: bool) -> float:
        """Return the largest part [Pa] of the expected rise that the tube delays beyond the lag.

        The lower the pressure and the slower the pump, the longer the delay.
        """
        a = self.atmosphere
        vacuum = np.linspace(0.0, min(self.vacuum, owed.top), GRID)
        command = _pump_commands(switched)
        delay = self.pump_lag(command * rate, a - vacuum) - self.pump_lag(rate, a)
        return float((owed.rise_at(vacuum, command) * delay).max())

    def filling_time(self, vacuum: float) -> float:
        """Return the time constant [s] of the chamber filling or emptying through the tube."""
        p = max(self.atmosphere - vacuum, DEEPEST * self.atmosphere)
        return 1 / (2 * self.passes * p)

    def rise_after_stop(self, vacuum: float, rate: float, top: float) -> float:
        """Return by how much the vacuum still rises [Pa] after a pump at full power stops.

        A vent counts as a pump that reaches only the atmosphere (`top` zero); the rise is then
        negative.
        """
        p = self.atmosphere - vacuum
        s = self.pump_pressure(p, rate, self.atmosphere - top)
        return float(self.volume / (1 + self.volume) * (p - s))


def _pump_commands(switched: bool) -> Array:
    """Return the commands of a running pump, shape (C, 1).

    If the pump can only be switched on and off, the only command is full power.
    """
    return np.ones((1, 1)) if switched else np.linspace(0.05, 1.0, 20)[:, None]


@functools.lru_cache(maxsize=64)
def owed_rise(passage: Passage, rate: float, top: float, switched: bool) -> Owed:
    """Return the rise expected of a healthy pump behind a tube, up to the passage's highest vacuum.

    The parabola is fitted to the relative rise at full pump power; the tube does not limit a slow
    pump. Both limits are then scaled down until the smaller one never exceeds the true rise.
    """
    deepest = min(passage.vacuum, (1 - DEEPEST) * top)
    vacuum = np.linspace(0.0, deepest, GRID)
    full_rise, unheld = passage.rise(vacuum, rate, top), rate / (1 + passage.volume)
    bend, slope, limit = np.polyfit(vacuum / top, full_rise, 2, w=1 / full_rise)
    fit = Owed(unheld, top, 1.0, float(limit), float(-slope / top), float(bend / top**2))
    commands = _pump_commands(switched)
    ratio = passage.rise(vacuum, commands * rate, top) / fit.rise_at(vacuum, commands)
    low, high = float(ratio.min()), float(ratio.max())
    if not switched:  # with the slowest pump, the vacuum rises along the line
        high = max(high, 1.0)
    return Owed(
        rate=low * unheld,
        top=top,
        most=low * fit.most,
        less=low * fit.less,
        bend=low * fit.bend,
        ratio=high / low,
    )


def balance_vacuum(passage: Passage, rate: float, top: float, leak: float) -> float:
    """Return the vacuum [Pa] at which full pump power and the leak balance through the tube."""
    a = passage.atmosphere
    low, high = 0.0, top
    while high - low > 1e-12 * top:
        v = 0.5 * (low + high)
        s = a - top + leak * v / rate
        if passage.passes * ((a - v) ** 2 - s * s) > leak * v:
            low = v
        else:
            high = v
    return high
