"""A printed part as a short list of prisms, the single description behind all formats [mm].

A prism is a section swept along an axis, added to the part or cut from it. The closed-form volume
(here), mesh (`mesh`) and STEP solid (`step`) follow from this list and must agree. Added prisms may
touch but never overlap; cuts are inside added prisms, and the shared volume of two cuts is stated.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

Axis = Literal["x", "y", "z"]
PLANE: dict[Axis, tuple[Axis, Axis]] = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}
"""{axis of the sweep: axes of a section's coordinates}, in cyclic order to avoid mirroring."""
CHORD = 0.01
"""Maximum distance of a mesh from a round surface [mm]."""
Point = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """Rectangle between two opposite corners; `radius` rounds all four."""

    low: Point
    high: Point
    radius: float = 0.0

    @classmethod
    def from_centre(cls, centre: Point, width: float, height: float, radius: float = 0.0) -> "Box":
        """Return the rectangle with the given sides, centred on a point."""
        (u, v), half_width, up = centre, width / 2, height / 2
        return cls((u - half_width, v - up), (u + half_width, v + up), radius)

    @property
    def area(self) -> float:
        """Area [mm²]."""
        (a, b), (c, d) = self.low, self.high
        return (c - a) * (d - b) - (4 - math.pi) * self.radius**2

    def outline(self) -> list[Point]:
        """Return the corners, or points along the rounded corners, anticlockwise."""
        (a, b), (c, d), r = self.low, self.high, self.radius
        if not r:
            return [(a, b), (c, b), (c, d), (a, d)]
        steps = segment_count(r, math.pi / 2)
        angles = [k * math.pi / 2 / steps for k in range(1, steps)]
        bend = [(r * math.cos(angle), r * math.sin(angle)) for angle in angles]
        corners = [
            ((c, d - r), [(c - r + u, d - r + v) for u, v in bend], (c - r, d)),
            ((a + r, d), [(a + r - v, d - r + u) for u, v in bend], (a, d - r)),
            ((a, b + r), [(a + r - u, b + r - v) for u, v in bend], (a + r, b)),
            ((c - r, b), [(c - r + v, b + r - u) for u, v in bend], (c, b + r)),
        ]
        return [point for first, middle, last in corners for point in (first, *middle, last)]


@dataclass(frozen=True)
class Ellipse:
    """Ellipse with its axes along those of the section; a circle if its half axes are equal."""

    centre: Point
    first: float
    second: float

    @classmethod
    def circle(cls, centre: Point, diameter: float) -> "Ellipse":
        """Return the circle with a given diameter around a point."""
        return cls(centre, diameter / 2, diameter / 2)

    @property
    def area(self) -> float:
        """Area [mm²]."""
        return math.pi * self.first * self.second

    def outline(self) -> list[Point]:
        """Return points along the edge, anticlockwise."""
        (u, v), count = self.centre, 4 * segment_count(max(self.first, self.second), math.pi / 2)
        angles = (2 * math.pi * k / count for k in range(count))
        return [(u + self.first * math.cos(a), v + self.second * math.sin(a)) for a in angles]


def segment_count(radius: float, angle: float) -> int:
    """Return the number of chords that approximate an arc to within CHORD."""
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
        """Volume [mm³]."""
        return self.section.area * (self.end - self.start)


@dataclass(frozen=True)
class Solid:
    """A part: its name, which is also that of its files, and its prisms."""

    name: str
    prisms: tuple[Prism, ...]
    shared_volume: float = 0.0
    """Volume that two cuts have in common [mm³]."""

    @property
    def volume(self) -> float:
        """Volume in closed form [mm³]."""
        return sum(-p.volume if p.cut else p.volume for p in self.prisms) + self.shared_volume

    @property
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Lowest and highest x, y and z of the added prisms [mm]."""
        low = {axis: math.inf for axis in PLANE}
        high = {axis: -math.inf for axis in PLANE}
        for prism in self.prisms:
            if prism.cut:
                continue
            for axis, (first, last) in _prism_extent(prism).items():
                low[axis] = np.minimum(low[axis], first)
                high[axis] = np.maximum(high[axis], last)
        return (low["x"], low["y"], low["z"]), (high["x"], high["y"], high["z"])

    @property
    def size(self) -> tuple[float, float, float]:
        """Extent along x, y and z [mm]."""
        low, high = self.bounds
        return high[0] - low[0], high[1] - low[1], high[2] - low[2]


def _prism_extent(prism: Prism) -> dict[Axis, Point]:
    section, (first, second) = prism.section, PLANE[prism.axis]
    if isinstance(section, Box):
        (a, b), (c, d) = section.low, section.high
    else:
        (u, v) = section.centre
        a, b, c, d = u - section.first, v - section.second, u + section.first, v + section.second
    return {prism.axis: (prism.start, prism.end), first: (a, c), second: (b, d)}


def add(axis: Axis, start: float, end: float, section: Section) -> Prism:
    """Return a prism that is added to a part."""
    return Prism(axis, start, end, section)


def cut(axis: Axis, start: float, end: float, section: Section) -> Prism:
    """Return a prism that is cut from a part."""
    return Prism(axis, start, end, section, True)


def make_solid(name: str, prisms: Iterable[Prism], shared_volume: float = 0.0) -> Solid:
    """Return the part that consists of these prisms."""
    return Solid(name, tuple(prisms), shared_volume)
