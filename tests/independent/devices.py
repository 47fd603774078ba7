"""A population of brakes, their pulls and their stops: NumPy only, no part of layerjam.

The law is that of `pulls`, with a friction that also depends on vacuum and speed. Friction and
stiffness of one device scatter between mountings and between the pulls of one mounting. The stop
is integrated step by step over the slip, with the friction at the speed of each step.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray
SHEETS, WIDTH, OVERLAP, FREE, USABLE = 11, 13e-3, 68e-3, 11e-3, 60e-3
STIFFNESS_OF_WALL = 0.1e6 * WIDTH * 1e-3
GRAVITY = 9.80665
REFERENCE, SPEED = 60e3, 13e-3
"""Vacuum [Pa] and speed [m/s] at which a device has its nominal friction."""
ENCLOSURE, EXPONENT, SLOPE = 0.3, 0.06, 0.03
MOUNTING = (0.03, 0.08)
"""Range of the scatter (SD) between mountings, as in the paper's table I."""
PULL = (0.02, 0.03)
LEAST_SPEED = 1e-3
STEPS = 400


class Film(NamedTuple):
    """Friction on itself and on silicone, scale factor, stiffness [N/m] and a mass to stop [kg]."""

    name: str
    friction: float
    silicone: float
    scale_factor: float
    stiffness: float
    mass: float


FILMS = (
    Film("choi2018-kapton", 0.24, 0.80, 0.875, 131e3, 1.0),
    Film("choi2018-ptfe", 0.05, 0.23, 1.24, 55e3, 0.3),
)


@dataclass(frozen=True, kw_only=True)
class Device:
    """One brake of the population: the middle of its mountings, and what does not change."""

    film: Film
    scale_factor: float
    stiffness: float
    enclosure: float
    exponent: float
    slope: float
    pull_sd: float
    mounting_sd: float = 0.05

    def pull(self, random: np.random.Generator, mounting: Array, vacuum: Any) -> Pull:
        """Pulls at vacuums, each with the deviations (pulls, 2) of its mounting and its own."""
        logs = mounting + self.pull_sd * random.standard_normal(mounting.shape)
        return Pull(
            scale_factor=self.scale_factor * np.exp(logs[:, 0]),
            stiffness=self.stiffness * np.exp(logs[:, 1]),
            vacuum=np.zeros(len(logs)) + vacuum,
            device=self,
        )

    def mount(self, random: np.random.Generator, count: int) -> Array:
        """Deviations of ln(friction) and ln(stiffness) of new mountings, (mountings, 2)."""
        return self.mounting_sd * random.standard_normal((count, 2))


def draw_device(
    random: np.random.Generator, exponent: float | None = None, mounting_sd: float | None = None
) -> Device:
    """A random brake of Kapton or PTFE."""
    film = FILMS[random.integers(len(FILMS))]
    return Device(
        film=film,
        scale_factor=film.scale_factor * random.uniform(0.75, 1.3),
        stiffness=film.stiffness * random.uniform(0.7, 1.4),
        enclosure=float(np.exp(ENCLOSURE * random.standard_normal())),
        exponent=EXPONENT * random.standard_normal() if exponent is None else exponent,
        slope=SLOPE * random.standard_normal(),
        pull_sd=random.uniform(*PULL),
        mounting_sd=random.uniform(*MOUNTING) if mounting_sd is None else mounting_sd,
    )


@dataclass(frozen=True, kw_only=True)
class Pull:
    """Pulls or stops of one device as arrays (pulls,): own friction, stiffness and vacuum [Pa]."""

    scale_factor: Array
    stiffness: Array
    vacuum: Array
    device: Device

    @property
    def per_length(self) -> Array:
        """Friction of the sheets per overlap [N/m] at the speed of pulls."""
        film = self.device.film
        growth = (self.vacuum / REFERENCE) ** self.device.exponent
        friction = self.scale_factor * film.friction * growth
        return friction * (SHEETS - 1) * WIDTH * self.vacuum

    def sleeve(self, slip: Array) -> Array:
        """Force of the enclosure [N]."""
        line = self.device.film.silicone * WIDTH * self.vacuum
        reach = OVERLAP / 2 + FREE
        grips = 2 * np.sqrt(STIFFNESS_OF_WALL * line * slip)
        whole = STIFFNESS_OF_WALL * slip / reach + line * reach
        is_whole = slip > line * reach**2 / STIFFNESS_OF_WALL
        return self.device.enclosure * np.where(is_whole, whole, grips)

    def force(self, slip: Array) -> Array:
        """Force of a slow pull [N]; slips (..., pulls)."""
        return self.per_length * (OVERLAP - slip) + self.sleeve(slip)

    def peak(self) -> Array:
        """Largest force of a slow pull [N], at the top of c (L - x) + e sqrt(x)."""
        root = self.sleeve(np.full_like(self.vacuum, 1e-9)) / 1e-9**0.5
        return self.per_length * OVERLAP + root**2 / (4 * self.per_length)

    def curve(self, elongation: Array) -> Array:
        """Force [N] of each pull at elongations (n,) from rest, (pulls, n)."""
        slip = np.concatenate([[0.0], np.geomspace(1e-8, USABLE, 1200)])[:, None]
        force = self.force(slip)
        reached = slip + force / self.stiffness
        return np.array(
            [
                np.where(elongation < r[0], k * elongation, np.interp(elongation, r, f))
                for r, f, k in zip(reached.T, force.T, self.stiffness, strict=True)
            ]
        )

    def stop(self, mass: float, speed: float, slope: float | None = None) -> Array:
        """Slip [m] at which a falling mass stands still; infinite beyond the usable travel.

        The kinetic energy K changes by (M g - F) dz over the way dz = dx + dF/k of the mass.
        """
        slope = self.device.slope if slope is None else slope
        weight = mass * GRAVITY

        def find_force(slip: float, energy: Array) -> Array:
            v = np.sqrt(2 * np.maximum(energy, 0.0) / mass)
            growth = np.exp(slope * np.log10(np.maximum(v, LEAST_SPEED) / SPEED))
            line = np.full_like(self.vacuum, slip)
            return self.per_length * growth * (OVERLAP - slip) + self.sleeve(line)

        arriving = np.full_like(self.vacuum, mass * speed**2 / 2)
        force = find_force(0.0, arriving)
        energy = arriving + (weight * force - force**2 / 2) / self.stiffness
        stopped = np.where(energy <= 0, 0.0, np.inf)
        slips = USABLE * np.linspace(0, 1, STEPS + 1) ** 2
        for before, slip in pairwise(slips):
            new = find_force(slip, energy)
            way = slip - before + (new - force) / self.stiffness
            left = energy + (weight - (force + new) / 2) * way
            ends = np.isinf(stopped) & (left <= 0)
            share = energy / np.where(ends, energy - left, 1.0)
            stopped = np.where(ends, before + share * (slip - before), stopped)
            force, energy = new, left
        return stopped
