"""Brakes to build, and what an independent reader makes of their parts."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load
from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate.lengths import Lengths, compute_lengths
from layerjam.workshop.fabricate.parts import Part, make_parts

KAPTON = load("choi2018-kapton")


def lengths_of(brake: Brake = KAPTON.brake, build: Build = Build()) -> Lengths:
    return compute_lengths(brake, build)


def parts_of(brake: Brake = KAPTON.brake, build: Build = Build()) -> dict[str, Part]:
    return {part.name: part for part in make_parts(compute_lengths(brake, build), build)}


class Read(NamedTuple):
    """What Open CASCADE reads from a STEP file."""

    volume: float
    valid: bool
    solids: int
    low: tuple[float, float, float]
    high: tuple[float, float, float]


def read_step(path: Path) -> Read:
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    shape = reader.OneShape()
    found, box = GProp_GProps(), Bnd_Box()
    BRepGProp.VolumeProperties_s(shape, found)
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    explorer, count = TopExp_Explorer(shape, TopAbs_SOLID), 0
    while explorer.More():
        count += 1
        explorer.Next()
    low, high = box.CornerMin(), box.CornerMax()
    return Read(
        found.Mass(),
        BRepCheck_Analyzer(shape).IsValid(),
        count,
        (low.X(), low.Y(), low.Z()),
        (high.X(), high.Y(), high.Z()),
    )


def some_brakes(seed: int, count: int) -> list[Brake]:
    """Random brakes as the acceptance asks for them; not all of them can be built."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(count):
        thickness = float(np.exp(rng.uniform(np.log(25e-6), np.log(500e-6))))
        clamped, overlap = rng.uniform(5e-3, 14e-3), rng.uniform(20e-3, 120e-3)
        left, right = rng.uniform(3e-3, 25e-3, 2)
        if rng.random() < 0.3:
            right = left
        made.append(
            KAPTON.brake.with_(
                count=int(rng.integers(2, 61)),
                thickness=thickness,
                width=float(np.exp(rng.uniform(np.log(8e-3), np.log(100e-3)))),
                length=float(clamped + overlap + max(left, right)),
                overlap=float(overlap),
                usable_travel=float(overlap * 0.8),
                free_left=float(left),
                free_right=float(right),
                clamped_length=float(clamped),
                screw_hole=float(rng.choice([2e-3, 2.6e-3, 3e-3, 3.2e-3, 4e-3])),
                wall=float(rng.uniform(0.4e-3, 3e-3)),
            )
        )
    return made


def pairs(values: list[float]) -> list[tuple[float, float]]:
    return list(itertools.pairwise(values))
