"""Campaigns with a stated truth for the tests of fits over many curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from laboratory.campaigns import bench as virtual
from laboratory.campaigns.bench import FULL, QUIET
from layerjam.brake.device.brake import Brake
from layerjam.laboratory.identify.curves import Curve, make_curves
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.shape import change_shape
from strategies import KAPTON

TRUTH = (0.9, 120e3, 1.3)
"""Scale factor, stiffness, sleeve's factor."""


def campaign(
    vacuums: Sequence[float] = (FULL,),
    repeats: int = 3,
    *,
    brake: Brake = KAPTON,
    truth: tuple[float, float, float] = TRUTH,
    spread: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    speeds: Sequence[float] = (0.013,),
    travel: float = 0.04,
    exponent: float = 0.0,
    slope: float = 0.0,
    offset: float = 0.0,
    slack: float = 0.0,
    seed: int = 1,
) -> tuple[Curve, ...]:
    """Pulls of a brake with `truth`; friction changes with vacuum/60 kPa and speed/10 mm/s.

    Each pull has its own mounting.
    """
    random = np.random.default_rng(seed)
    pulls = []
    for vacuum in vacuums:
        for speed in speeds:
            for _ in range(repeats):
                own = [
                    t * (1 + s * random.standard_normal())
                    for t, s in zip(truth, spread, strict=True)
                ]
                own[0] *= (vacuum / 60e3) ** exponent * np.exp(slope * np.log10(speed / 0.01))
                machine = virtual.Machine(
                    **(QUIET | {"load_cell_noise": noise}), zero_offset=offset,
                    sampling_rate=4000 * speed / 0.04, seed=int(random.integers(1 << 31)),
                )  # fmt: skip
                trace = virtual.pull(change_shape(brake, *own), vacuum, speed, travel, machine)
                trace.elongation[:] += slack * random.standard_normal()
                facts = replace(trace.facts, mounting=len(pulls) + 1)
                trace = replace(trace, facts=facts)
                pulls.append((trace, pull_features(trace), vacuum))
    return make_curves(pulls)
