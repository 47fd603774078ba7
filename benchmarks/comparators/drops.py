"""The drops that every method is given, and what it has to answer.

A mass arrives with a speed on a taut rope, the brake in series, at a constant vacuum. Kept are
drops in which the brake slides: most stop within the travel, some run to its end.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.load import load

BRAKE = "choi2018-kapton"
SEED = 8
ROPE = 16.8e3
MASS, SPEED, VACUUM = (0.3, 3.0), (0.5, 3.5), (40e3, 101e3)
"""Bounds of the uniform draws [kg, m/s, Pa]."""

Array = np.ndarray


class Force(NamedTuple):
    """The sliding brake's force over slip s, constants of shape (n,).

    onset - c s + root sqrt(s) below the saturation slip, onset - c s + step + rise s beyond.
    """

    c: Array
    onset: Array
    root: Array
    saturation: Array
    step: Array
    rise: Array

    def at(self, slip: Array) -> Array:
        """Force [N] at a slip [m]."""
        spread = self.root * np.sqrt(slip)
        sleeve = np.where(slip < self.saturation, spread, self.step + self.rise * slip)
        return self.onset - self.c * slip + sleeve


class Answer(NamedTuple):
    """What is compared, arrays of shape (n,)."""

    travel: Array
    """Slip of the brake at standstill, or the whole travel where that is used up [m]."""
    peak: Array
    """Greatest force until then [N]."""


@dataclass(frozen=True)
class Drops:
    """n drops on one brake: arrays of shape (n,) in SI units."""

    mass: Array
    speed: Array
    vacuum: Array
    brake: Brake
    spring: float
    """Rope and brake in series [N/m]."""
    gravity: float

    def __len__(self) -> int:
        return len(self.mass)

    def first(self, n: int) -> Drops:
        """The first n of them."""
        return replace(self, mass=self.mass[:n], speed=self.speed[:n], vacuum=self.vacuum[:n])

    @property
    def travel(self) -> float:
        """Where the brake's travel ends [m]."""
        return self.brake.sheets.usable_travel

    @cached_property
    def force(self) -> Force:
        """Constants of the brake's force, written out from the paper's equations."""
        brake, sheets = self.brake, self.brake.sheets
        c = brake.scale_factor * brake.film.kinetic * (sheets.count - 1)
        c = c * sheets.width * self.vacuum
        stiff = brake.enclosure.modulus * sheets.width * brake.enclosure.wall
        q = brake.film.friction_on_silicone * sheets.width * self.vacuum
        reach = (sheets.free_left + sheets.overlap + sheets.free_right) / 2
        return Force(
            c=c,
            onset=c * sheets.overlap,
            root=2 * np.sqrt(stiff * q),
            saturation=q * reach**2 / stiff,
            step=q * reach,
            rise=np.full_like(c, stiff / reach),
        )


def given(mass: Array, speed: Array, vacuum: Array) -> Drops:
    """Drops on the benchmark's brake and rope."""
    brake = load(BRAKE).brake
    own = brake.stiffness_measured
    assert own is not None
    spring = 1 / (1 / own + 1 / ROPE)
    arrays = [np.asarray(a, dtype=float) for a in (mass, speed, vacuum)]
    return Drops(*arrays, brake=brake, spring=spring, gravity=brake.site.gravity)


def population(n: int, seed: int = SEED) -> Drops:
    """n random drops in which the brake slides; fewer are the first of more."""
    random = np.random.default_rng(seed)
    low, high = zip(MASS, SPEED, VACUUM, strict=True)
    kept = np.empty((0, 3))
    while len(kept) < n:
        rows = random.uniform(low, high, (max(2 * (n - len(kept)), 1000), 3))
        some = given(*rows.T)
        weight = some.mass * some.gravity
        elastic = weight + np.sqrt(weight**2 + some.spring * some.mass * some.speed**2)
        kept = np.concatenate([kept, rows[elastic > some.force.onset]])
    return given(*np.ascontiguousarray(kept[:n].T))
