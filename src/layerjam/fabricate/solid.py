"""A printed part as a short list of prisms: the one description that all readers share [mm].

A prism is a section swept along an axis, added to the part or cut from it. Volume by closed form
(here), mesh (`mesh`) and STEP solid (`step`) are read from the same list and must agree. What is
added abuts and never overlaps; what is cut lies within what was added, and where two cuts meet the
volume they share is stated.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

Axis = Literal["x", "y", "z"]
PLANE: dict[Axis, tuple[Axis, Axis]] = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}
"""Axes of a section's first and second coordinate, in cyclic order, so that none is mirrored."""
CHORD = 0.01
"""How far a mesh may lie from a round surface [mm]."""
Point = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """A rectangle between two corners; `radius` rounds them all."""

    low: Point
    high: Point
    radius: float = 0.0

    @classmethod
    def about(cls, centre: Point, width: float, height: float, radius: float = 0.0) -> Box:
        """The rectangle of given sides around a point."""
        (u, v), half, up = centre, width / 2, height / 2
        return cls((u - half, v - up), (u + half, v + up), radius)

    @property
    def area(self) -> float:
        """Its area."""
        (a, b), (c, d) = self.low, self.high
        return (c - a) * (d - b) - (4 - math.pi) * self.radius**2

    def outline(self) -> list[Point]:
        """Its corners, or points along its rounded corners, counter-clockwise."""
        (a, b), (c, d), r = self.low, self.high, self.radius
        if not r:
            return [(a, b), (c, b), (c, d), (a, d)]
        steps = segments(r, math.pi / 2)
        turn = [k * math.pi / 2 / steps for k in range(1, steps)]
        bend = [(r * math.cos(angle), r * math.sin(angle)) for angle in turn]
        corners = [
            ((c, d - r), [(c - r + u, d - r + v) for u, v in bend], (c - r, d)),
            ((a + r, d), [(a + r - v, d - r + u) for u, v in bend], (a, d - r)),
            ((a, b + r), [(a + r - u, b + r - v) for u, v in bend], (a + r, b)),
            ((c - r, b), [(c - r + v, b + r - u) for u, v in bend], (c, b + r)),
        ]
        return [point for first, middle, last in corners for point in (first, *middle, last)]


@dataclass(frozen=True)
class Ellipse:
    """An ellipse with its half axes along the section's two; a circle where they are equal."""

    centre: Point
    first: float
    second: float

    @classmethod
    def circle(cls, centre: Point, diameter: float) -> Ellipse:
        """The circle of a diameter around a point."""
        return cls(centre, diameter / 2, diameter / 2)

    @property
    def area(self) -> float:
        """Its area."""
        return math.pi * self.first * self.second

    def outline(self) -> list[Point]:
        """Points along it, counter-clockwise."""
        (u, v), count = self.centre, 4 * segments(max(self.first, self.second), math.pi / 2)
        angles = (2 * math.pi * k / count for k in range(count))
        return [(u + self.first * math.cos(a), v + self.second * math.sin(a)) for a in angles]


def segments(radius: float, angle: float) -> int:
    """Chords for an arc so that none lies further than CHORD inside of it."""
    return max(2, math.ceil(angle / (2 * math.acos(1 - min(CHORD / radius, 0.5)))))


Section = Box | Ellipse


@dataclass(frozen=True)
class Prism:
    """A section swept along an axis from `start` to `end`, added or cut."""

    axis: Axis
    start: float
    end: float
    section: Section
    cut: bool = False

    @property
    def volume(self) -> float:
        """Its volume."""
        return self.section.area * (self.end - self.start)


@dataclass(frozen=True)
class Solid:
    """A part: its name (which is also that of its files) and its prisms."""

    name: str
    prisms: tuple[Prism, ...]
    shared: float = 0.0
    """Volume that two cuts have in common [mm³]."""

    @property
    def volume(self) -> float:
        """Its volume by closed form [mm³]."""
        return sum(-p.volume if p.cut else p.volume for p in self.prisms) + self.shared

    @property
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Lowest and highest corner of what is added."""
        low = {axis: math.inf for axis in PLANE}
        high = {axis: -math.inf for axis in PLANE}
        for prism in self.prisms:
            if prism.cut:
                continue
            for axis, (first, last) in _extent(prism).items():
                low[axis] = np.minimum(low[axis], first)
                high[axis] = np.maximum(high[axis], last)
        return (low["x"], low["y"], low["z"]), (high["x"], high["y"], high["z"])

    @property
    def size(self) -> tuple[float, float, float]:
        """Extent along x, y and z."""
        low, high = self.bounds
        return high[0] - low[0], high[1] - low[1], high[2] - low[2]


def _extent(prism: Prism) -> dict[Axis, Point]:
    section, (first, second) = prism.section, PLANE[prism.axis]
    if isinstance(section, Box):
        (a, b), (c, d) = section.low, section.high
    else:
        (u, v) = section.centre
        a, b, c, d = u - section.first, v - section.second, u + section.first, v + section.second
    return {prism.axis: (prism.start, prism.end), first: (a, c), second: (b, d)}


def add(axis: Axis, start: float, end: float, section: Section) -> Prism:
    """A prism that is added."""
    return Prism(axis, start, end, section)


def cut(axis: Axis, start: float, end: float, section: Section) -> Prism:
    """A prism that is cut."""
    return Prism(axis, start, end, section, True)


def solid(name: str, prisms: Iterable[Prism], shared: float = 0.0) -> Solid:
    """The part of these prisms."""
    return Solid(name, tuple(prisms), shared)
