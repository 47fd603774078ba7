"""Random histories of elongation and vacuum that reach every corner of the brake's memory."""

from __future__ import annotations

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.kernel.parameters import parameters


def history(brake: Brake, seed: int, n: int = 1024) -> tuple[np.ndarray, np.ndarray]:
    """Elongation [m] and vacuum [Pa], shape (n,): walks, jumps, loops, holds; steps and ramps.

    The elongation stays below the overlap, so that the sheets do not part.
    """
    rng = np.random.default_rng(seed)
    far = 0.95 * brake.sheets.overlap
    kind = seed % 4
    if kind == 0:
        path = np.abs(np.cumsum(rng.normal(0, 0.05 * far, n)))
        path = far - np.abs(far - path % (2 * far))
    elif kind == 1:
        path = rng.uniform(0, far, n)
    elif kind == 2:  # loops inside loops, a little above the stuck part
        stuck = most(brake) / parameters(brake).stiffness
        path = rng.uniform(0.1, 0.6) * far + 3 * stuck * rng.uniform(-1, 1, n)
        path = np.clip(path, 0, far)
    else:  # out and back in small steps
        turns = rng.uniform(0, far, 12)
        path = np.interp(np.linspace(0, 11, n), np.arange(12), turns)
    path = np.where(rng.random(n) < 0.1, np.roll(path, 1), path)
    full = brake.site.atmosphere
    steps = np.repeat(full * rng.random(n) ** 2, 16)[:n]
    ramps = full * np.abs(np.interp(np.arange(n), np.arange(0, n + 64, 64), _zigzag(rng, n)))
    steady = np.full(n, 0.9 * full)
    # so little that the enclosure closes the brake, and slides back as a whole
    least = np.repeat(np.exp(rng.uniform(np.log(3e-5), np.log(0.03), n)) * full, 8)[:n]
    weak = np.where(rng.random(n) < 0.03, 0.0, np.where(np.arange(n) % 64 < 48, least, steps))
    vacuum = (steps, ramps, steady, weak)[seed // 4 % 4]
    return path, vacuum


def _zigzag(rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.uniform(0, 1, len(np.arange(0, n + 64, 64)))


def most(brake: Brake) -> float:
    """What the sheets hold at the site's full vacuum [N]."""
    p, full = parameters(brake), brake.site.atmosphere
    return p.contact * full * (full / p.test_pressure) ** p.exponent * p.overlap
