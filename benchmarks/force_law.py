"""The force law on ten million points, against copying its arrays and against plain NumPy."""

from __future__ import annotations

import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.timing import Row, median
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import brake_force

POINTS = 10_000_000
_MEMORY = f"""
import resource, jax, numpy as np
jax.config.update("jax_enable_x64", True)
from layerjam import brake_force, load
random = np.random.default_rng(0)
slip, vacuum = random.uniform(0, 0.06, {POINTS}), random.uniform(0, 94.5e3, {POINTS})
np.asarray(brake_force(slip, vacuum, load("choi2018-kapton").brake))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)
"""


def in_numpy(slip: np.ndarray, vacuum: np.ndarray, brake: Brake) -> np.ndarray:
    """The same law as a user would write it in NumPy."""
    sheets = brake.sheets
    c = brake.scale_factor * brake.film.kinetic * (sheets.count - 1) * sheets.width * vacuum
    stiff = brake.enclosure.modulus * sheets.width * brake.enclosure.wall
    q = brake.film.friction_on_silicone * sheets.width * vacuum
    reach = (sheets.free_left + sheets.overlap + sheets.free_right) / 2
    sleeve = np.where(
        slip < q * reach**2 / stiff,
        2 * np.sqrt(stiff * q * slip),
        stiff * slip / reach + q * reach,
    )
    return c * np.maximum(sheets.overlap - slip, 0) + sleeve


def rows() -> list[Row]:
    """Seconds of the law, and the peak memory of a process that does only this."""
    brake = load("choi2018-kapton").brake
    random = np.random.default_rng(0)
    slip, vacuum = random.uniform(0, 0.06, POINTS), random.uniform(0, 94.5e3, POINTS)
    there = jnp.asarray(slip), jnp.asarray(vacuum)
    result = np.asarray(brake_force(slip, vacuum, brake))
    worst = float(np.abs(result - in_numpy(slip, vacuum, brake)).max())
    copy = median(lambda: [a.copy() for a in (slip, vacuum, result)])
    numpy = median(lambda: in_numpy(slip, vacuum, brake), 5)
    law = median(lambda: jax.block_until_ready(brake_force(*there, brake)))
    whole = median(lambda: np.asarray(brake_force(slip, vacuum, brake)))
    memory = subprocess.run(
        [sys.executable, "-c", _MEMORY], check=True, capture_output=True, text=True
    )
    return [
        Row("JAX arrays", law, None, copy, "copying in- and outputs", target_ratio=2.0),
        Row("JAX arrays", law, None, numpy, f"NumPy (differs by {worst:.0e} N)"),
        Row("NumPy in and out", whole, None, numpy, "NumPy"),
        Row("peak memory, NumPy in and out", float(memory.stdout), 1.5, unit="GB"),
    ]
