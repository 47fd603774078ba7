"""Pulls without a test machine, and the machines the tests measure with."""

from __future__ import annotations

from typing import Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.lab import machine as virtual
from layerjam.measure.trace import Trace
from layerjam.mechanics.pull import force_at_elongation

FULL = 94.5e3
QUIET: dict[str, Any] = {
    "load_cell_noise": 0.0, "force_quantisation": 0.0, "elongation_quantisation": 0.0,
}  # fmt: skip


def curve(
    brake: Brake, vacuum: float = FULL, travel: float = 0.04, rows: int = 4001, path: str = "curve"
) -> Trace:
    """The model's own curve, without any noise."""
    u = np.linspace(0.0, travel, rows)
    force = np.asarray(force_at_elongation(u, vacuum, brake))
    return Trace(force=force, elongation=u, time=u / 0.013, path=path, format="model")


def noisy(
    brake: Brake, seed: int, noise: float = 0.15, vacuum: float = FULL, speed: float = 0.013
) -> Trace:
    """A pull at 1000 Hz to 40 mm, with nothing but white noise."""
    machine = virtual.Machine(**(QUIET | {"load_cell_noise": noise}), seed=seed)
    return virtual.pull(brake, vacuum, speed, 0.04, machine)
