"""When a step of a procedure is done: what the board's law expects, and what its samples show."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.control import law
from layerjam.rig.driver import Bench
from layerjam.rig.recorder import Block
from layerjam.rig.telemetry import PERIOD

SETTLED = 0.5
"""Seconds within the band that make a vacuum reached."""


@dataclass(frozen=True)
class Watch:
    """What the board's own law says of its line, for deciding when a step is done."""

    rise: float
    top: float
    fall: float
    leak: float
    tube: tuple[float, float, float]
    half_band: float
    settle_time: float
    zero: float

    @classmethod
    def of(cls, bench: Bench) -> Watch:
        """From the settings that a board runs by."""
        first, second = bench.regulator
        return cls(
            rise=second[0],
            top=second[1],
            fall=second[2],
            leak=second[3],
            tube=(second[18], second[19], second[20]),
            half_band=first[3],
            settle_time=second[15] * PERIOD * 1e-6,
            zero=second[16],
        )

    def rise_time(self, begin: float, end: float) -> float:
        """Seconds from one vacuum [Pa] to another at full pump; infinite where it never comes."""
        vacuum, count = begin, 0
        while vacuum < end:
            gives = law.given(1.0, vacuum, self.rise, self.top, self.fall, *self.tube)
            gives -= self.leak * vacuum
            if gives <= 1e-9 * end:
                return math.inf
            vacuum, count = vacuum + gives, count + 1
        return count * PERIOD * 1e-6


def scatter(vacuum: np.ndarray[Any, Any]) -> float:
    """Three standard deviations of a sensor at rest and two of its steps [Pa], from readings."""
    steps = np.diff(vacuum[np.isfinite(vacuum)].astype(float))
    if not len(steps):
        return 0.0
    steps = steps - np.median(steps)
    moved = np.abs(steps)[np.abs(steps) > 0]
    if not len(moved):
        return 0.0
    return 3.0 * float(np.std(steps)) / math.sqrt(2) + 2.0 * float(moved.min())


def last(block: Block) -> float:
    """The last reading [Pa]; NaN is no vacuum that could be relied on."""
    return float(block.rows["vacuum"][-1])


def stays(band: float, target: float, begun: int) -> Callable[[Block], bool]:
    """Whether every reading of the last half second was within a band [Pa] of the target."""
    outside = begun

    def done(block: Block) -> bool:
        nonlocal outside
        off = np.flatnonzero(~(np.abs(block.rows["vacuum"] - target) <= band))
        if len(off):
            outside = int(block.us[off[-1]])
        return int(block.us[-1]) - outside >= SETTLED * 1e6

    return done
