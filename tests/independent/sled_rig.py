"""A friction rig by NumPy alone: a sled on a film, pulled by a string, and its faulty load cell.

It shares no code with layerjam. The string of stiffness k takes up its slack and stretches until
static friction breaks; the sled then jumps by (Fs - Fk)/k and slides, at a friction that wanders
along the film. Sampling can miss the peak, as on a real machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Rig:
    """One test, in SI units; everything after `noise` is a fault."""

    static: float = 0.712
    kinetic: float = 0.6
    stiffness: float = 300.0
    speed: float = 2.5e-3
    travel: float = 0.11
    rate: float = 50.0
    rest: float = 3.0
    """Time before the crosshead moves [s]."""
    texture: float = 0.01
    """Relative SD of friction along the film, with a correlation length of 1 mm."""
    noise: float = 2e-3
    """White noise of the load cell [N]."""
    slack: float = 2e-3
    zero: float = 0.0
    drift: float = 0.0
    """Change of the zero with time [N/s]."""
    tilt: float = 0.0
    """Change of the force with travel [N/m], as of a cable that is dragged along."""
    gain: float = 1.0
    step: float = 0.0
    """Resolution of the load cell [N]."""
    limit: float = np.inf
    """Force at which the cell saturates [N], before the noise of its amplifier is added."""
    spike: float = 0.0
    """Height of a disturbance [N], and the number of samples that it lasts."""
    spike_width: int = 1
    spike_at: float = 0.5
    """Its place, as a part of the time while the crosshead moves."""
    home: float = 0.0
    """Time at rest at the end, after a quick return that leaves the string slack [s]."""


def run(rig: Rig, seed: int) -> tuple[Array, Array, Array]:
    """Return time [s], travel of the crosshead [m] and force of the load cell [N], shape (N,)."""
    draw = np.random.default_rng(seed)
    back = rig.travel / (4 * rig.speed) if rig.home else 0.0
    moving = rig.travel / rig.speed
    time = np.arange(0.0, rig.rest + moving + back + rig.home, 1 / rig.rate)
    pulled = np.clip(time - rig.rest, 0.0, moving) * rig.speed
    returned = np.clip(time - rig.rest - moving, 0.0, back) * 4 * rig.speed
    travel = pulled - returned
    true = _friction(rig, pulled, draw)
    true = np.where(returned > 0, np.maximum(true - rig.stiffness * returned, 0.0), true)
    reading = rig.gain * true + rig.zero + rig.drift * time + rig.tilt * travel
    reading = np.minimum(reading, rig.limit) + rig.noise * draw.standard_normal(len(time))
    if rig.spike:
        first = int((rig.rest + rig.spike_at * moving) * rig.rate)
        reading[first : first + rig.spike_width] += rig.spike
    if rig.step:
        reading = np.round(reading / rig.step) * rig.step
    return time, travel, reading


def _friction(rig: Rig, pulled: Array, draw: np.random.Generator) -> Array:
    """Return the force in the string [N] at the crosshead's outward travel [m]."""
    stretched = rig.stiffness * np.maximum(pulled - rig.slack, 0.0)
    knots = np.arange(0.0, rig.travel + 2e-3, 1e-3)
    film = 1 + rig.texture * np.interp(pulled, knots, draw.standard_normal(len(knots)))
    broken = np.maximum.accumulate(stretched >= rig.static)
    return np.where(broken, rig.kinetic * film, stretched)


def write(path: Path, rig: Rig, seed: int, force_digits: int = 4) -> Path:
    """Write one test as a CSV file in the layout of a common test machine."""
    rows = np.column_stack(run(rig, seed))
    lines = ["Time (s),Load (N),Displacement (mm)"]
    lines += [f"{t:.3f},{f:.{force_digits}f},{u * 1e3:.3f}" for t, u, f in rows.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def campaign(folder: Path, count: int, seed: int, scatter: float = 0.02, **rig: Any) -> list[Path]:
    """Write some tests, whose friction scatters by `scatter` (relative SD)."""
    draw = np.random.default_rng([seed, 1])
    base = Rig(**rig)
    paths = []
    for number in range(1, count + 1):
        factor = 1 + scatter * draw.standard_normal()
        own = {"static": base.static * factor, "kinetic": base.kinetic * factor}
        path = folder / f"sled-{number}.csv"
        paths.append(write(path, Rig(**{**rig, **own}), seed * 100 + number))
    return paths
