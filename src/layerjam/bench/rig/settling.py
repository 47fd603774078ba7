"""Detection of the end of a step in a procedure, from the board's settings and samples."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.bench.control import law
from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.recorder import Block
from layerjam.bench.rig.telemetry import PERIOD

SETTLED = 0.5
"""Time within the band after which a target vacuum counts as reached [s]."""


@dataclass(frozen=True)
class Watch:
    """Values in the board's own law that determine when a step is done."""

    rise: float
    top: float
    fall: float
    leak: float
    tube: tuple[float, float, float]
    regulator: tuple[float, ...]
    settle_time: float
    zero: float

    @classmethod
    def from_bench(cls, bench: Bench) -> "Watch":
        """Return the values in the settings of a board."""
        first, second = bench.regulator
        return cls(
            rise=second[0],
            top=second[1],
            fall=second[2],
            leak=second[3],
            tube=(second[18], second[19], second[20]),
            regulator=first,
            settle_time=second[15] * PERIOD * 1e-6,
            zero=second[16],
        )

    def rise_time(self, begin: float, end: float) -> float:
        """Return the time [s] from one vacuum [Pa] to another at full power; inf if impossible."""
        vacuum, count = begin, 0
        while vacuum < end:
            healthy_rise = law.healthy_rise(1.0, vacuum, self.rise, self.top, self.fall, *self.tube)
            healthy_rise -= self.leak * vacuum
            if healthy_rise <= 1e-9 * end:
                return math.inf
            vacuum, count = vacuum + healthy_rise, count + 1
        return count * PERIOD * 1e-6


def measure_scatter(vacuum: np.ndarray[Any, Any]) -> float:
    """Return three standard deviations of a sensor at rest plus two of its steps [Pa]."""
    steps = np.diff(vacuum[np.isfinite(vacuum)].astype(float))
    if not len(steps):
        return 0.0
    steps = steps - np.median(steps)
    changes = np.abs(steps)[np.abs(steps) > 0]
    if not len(changes):
        return 0.0
    return 3.0 * float(np.std(steps)) / math.sqrt(2) + 2.0 * float(changes.min())


def last_vacuum(block: Block) -> float:
    """Return the last reading [Pa]; NaN if it is not reliable."""
    return float(block.rows["vacuum"][-1])


def steady_test(watch: Watch, target: float, noise: float, start: int) -> Callable[[Block], bool]:
    """Return a function that tests whether the last half second is at the target [Pa]."""
    outside = start

    def is_steady(block: Block) -> bool:
        nonlocal outside
        for time, reading in zip(block.us, block.rows["vacuum"], strict=True):
            if not law.is_reached(watch.regulator, float(reading), target, noise):
                outside = int(time)
        return int(block.us[-1]) - outside >= SETTLED * 1e6

    return is_steady
