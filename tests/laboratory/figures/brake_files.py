"""A small campaign of one brake in files: friction, calibration and validation pulls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from laboratory.campaigns import bench as virtual
from layerjam.brake.device.load import load
from layerjam.core.drawing.page import Picture

NORMAL_FORCE = "2.45 N"
BRAKE = "choi2018-kapton"


def draw_nothing(pictures: Sequence[Picture], _: object) -> dict[str, str]:
    """Return {name: an empty SVG}, for a report whose figures are looked at elsewhere."""
    return {picture.name: "<svg></svg>" for picture in pictures}


@dataclass(frozen=True)
class Campaign:
    """Where the files lie."""

    friction: list[Path]
    pulls: list[Path]
    validate: list[Path]


def campaign(folder: Path) -> Campaign:
    """Three friction tests, three pulls, and 2 vacuums x 2 speeds x 2 repeats; repeats scatter."""
    file, random = load(BRAKE), np.random.default_rng(5)
    slow = virtual.Machine(sampling_rate=40.0, load_cell_noise=0.002, load_cell_range=10.0, seed=2)
    fast = virtual.Machine(sampling_rate=1000.0, load_cell_noise=0.15, seed=2)
    friction = [
        virtual.write_bluehill(
            virtual.friction(0.32, 0.24, 2.45, machine=slow, repeat=n, kinetic_sd=0.004),
            folder / f"friction-{n}.csv",
        )
        for n in (1, 2, 3)
    ]

    def pulled(name: str, vacuum: float, speed: float, repeat: int, count: int) -> Path:
        brake = replace(file.brake, scale_factor=0.875 * (1 + 0.02 * random.standard_normal()))
        trace = virtual.pull(brake, vacuum, speed, 0.04, fast, repeat=count, name=BRAKE)
        facts = replace(trace.facts, repeat=repeat)
        return virtual.write_bluehill(replace(trace, facts=facts), folder / f"{name}.csv")

    pulls = [pulled(f"pull-{n}", 94.5e3, 0.013, n, n) for n in (1, 2, 3)]
    validate = []
    for vacuum in (80.6e3, 46.1e3):
        for speed in (0.007, 0.019):
            for n in (1, 2):
                name = f"check-{vacuum / 1e3:g}kPa-{speed * 1e3:g}mms-{n}"
                validate.append(pulled(name, vacuum, speed, n, 10 + len(validate)))
    return Campaign(friction, pulls, validate)
