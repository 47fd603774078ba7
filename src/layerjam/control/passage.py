"""A tube between pump and chamber: two volumes, and what a regulator may expect of a rise.

With p = atmosphere - v of chamber and side (the tube's gas, where pump and vent act),

    v' = passes (p^2 - s^2) - leak v,
    volume w' = -passes (p^2 - s^2) + u k (top - w) - vent w,    s = atmosphere - w,

all rates over the chamber's volume. The law owes the chamber a rise that falls straight with the
vacuum; behind a tube the rise is curved, so that it takes a straight line below it (`straight`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
DEEPEST = 0.05
"""Share of the atmosphere up to which the owed rise is made right where a target is deeper."""
GRID = 400


class Straight(NamedTuple):
    """A rise that falls straight with the vacuum, nowhere above the true one."""

    rate: float
    top: float
    ratio: float
    """The true rise over it at most, at any command of the pump."""


@dataclass(frozen=True, kw_only=True)
class Passage:
    """A tube as the plant has it, over the chamber's volume."""

    volume: float
    """Gas of the tube over that of the chamber [1]."""
    passes: float
    """Flow over the difference of the squared pressures [1/(s Pa)]."""
    atmosphere: float
    """Pressure around the line [Pa]."""
    vacuum: float
    """Greatest vacuum that the detectors are tuned to [Pa]."""

    def side(self, p: Any, rate: float, lowest: float) -> Any:
        """Pressure at the pump [Pa] while it draws as much as the tube passes from p."""
        half = rate / (2 * self.passes)
        within = p * p + 2 * half * lowest + half * half
        return (p * p + 2 * half * lowest) / (np.sqrt(within) + half)

    def rise(self, vacuum: Any, rate: float, top: float) -> Any:
        """Rise of the chamber's vacuum [Pa/s] under a pump of this rate, once it runs."""
        p, low = self.atmosphere - np.asarray(vacuum, float), self.atmosphere - top
        s = self.side(p, rate, low)
        # the tube's own gas is drawn as well, as far as its pressure follows the chamber's
        follows = p / (s + rate / (2 * self.passes))
        return rate * (s - low) / (1 + self.volume * follows)

    def exchange(self, vacuum: float) -> float:
        """Time constant [s] in which chamber and tube come to one pressure."""
        p = max(self.atmosphere - vacuum, DEEPEST * self.atmosphere)
        return self.volume / (1 + self.volume) / (2 * self.passes * p)

    def lag(self, rate: Any, p: Any) -> Any:
        """Time constant [s] after which a pump draws on the chamber at p [Pa absolute]."""
        return self.volume / (rate + 2 * self.passes * p)

    def missing(self, rate: float, owed: Straight) -> float:
        """Rise [Pa] of what is owed that comes late at most, beyond the lag at no vacuum.

        The thinner the gas and the slower the pump, the longer the tube takes.
        """
        a = self.atmosphere
        p = np.linspace(a - min(self.vacuum, owed.top), a, GRID)
        command = np.linspace(0.05, 1.0, 20)[:, None]
        late = self.lag(command * rate, p) - self.lag(rate, a)
        return float((command * owed.rate * (p - (a - owed.top)) * late).max())

    def filling(self, vacuum: float) -> float:
        """Time constant [s] in which the chamber fills or empties through the tube."""
        p = max(self.atmosphere - vacuum, DEEPEST * self.atmosphere)
        return 1 / (2 * self.passes * p)

    def still(self, vacuum: float, rate: float, top: float) -> float:
        """How far the vacuum still rises once a full pump stops [Pa].

        A vent is a pump that only reaches the atmosphere, `top` zero: then it falls, below zero.
        """
        p = self.atmosphere - vacuum
        s = self.side(p, rate, self.atmosphere - top)
        return float(self.volume / (1 + self.volume) * (p - s))


def straight(passage: Passage, rate: float, top: float) -> Straight:
    """The line below the rise that stays closest to it in ratio, up to the passage's vacuum."""
    a = passage.atmosphere
    low = a - top
    deepest = max(a - passage.vacuum, low + DEEPEST * top)
    p = np.linspace(deepest, a, GRID)
    full = passage.rise(a - p, rate, top)
    best = Straight(0.0, top, math.inf)
    for zero in np.linspace(low, deepest, 80, endpoint=False):
        over = full / (p - zero)
        found = Straight(float(over.min()), float(a - zero), 0.0)
        # a slow pump is held up less than the full one, in proportion
        gentle = rate * (p - low) / (1 + passage.volume)
        ratio = float((np.maximum(full, gentle) / (found.rate * (p - zero))).max())
        if ratio < best.ratio:
            best = found._replace(ratio=ratio)
    return best


def reached(passage: Passage, rate: float, top: float, leak: float) -> float:
    """Vacuum [Pa] at which full pump and leak balance through the tube."""
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
