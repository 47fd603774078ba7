"""Flat parts: rectangles with rounded ends and round holes, in mm.

All flat parts (sheets, spacers, yokes, links, the jig and the coupons) have this shape, so area,
cut length and kerf offset have closed forms and need no library.

x runs along the part from its first end, y across it; y = 0 is in the middle.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

QUARTER = math.sqrt(2) - 1
"""DXF bulge of a quarter circle: tan(90°/4)."""


class Circle(NamedTuple):
    """Round hole [mm]."""

    x: float
    y: float
    diameter: float

    @property
    def area(self) -> float:
        """Area [mm²]."""
        return math.pi * self.diameter**2 / 4

    @property
    def length(self) -> float:
        """Circumference [mm]."""
        return math.pi * self.diameter


class Vertex(NamedTuple):
    """Corner of a closed path [mm]; `bulge` belongs to the segment to the next corner.

    The bulge is the tangent of a quarter of the arc's angle, or 0 for a straight line.
    """

    x: float
    y: float
    bulge: float


class Cut(NamedTuple):
    """Straight open cut [mm], which only coupons have."""

    start: tuple[float, float]
    end: tuple[float, float]

    @property
    def length(self) -> float:
        """Length [mm]."""
        return math.dist(self.start, self.end)


@dataclass(frozen=True, kw_only=True)
class Outline:
    """Part of `length` × `width`, with corner radii `start` (at x = 0) and `end` [mm]."""

    length: float
    width: float
    start: float = 0.0
    end: float = 0.0
    holes: Sequence[Circle] = ()
    cuts: Sequence[Cut] = ()
    origin: tuple[float, float] = (0.0, 0.0)
    """Position of the middle of the first end [mm]."""

    def area(self) -> float:
        """Return the area of the part [mm²], without its holes."""
        corners = (2 - math.pi / 2) * (self.start**2 + self.end**2)
        return self.length * self.width - corners - sum(hole.area for hole in self.holes)

    def cut_length(self) -> float:
        """Return the total length of the cuts [mm]."""
        edge = 2 * (self.length + self.width) - (4 - math.pi) * (self.start + self.end)
        inner_lengths = [hole.length for hole in self.holes] + [cut.length for cut in self.cuts]
        return edge + sum(inner_lengths)

    def add_kerf(self, kerf: float) -> "Outline":
        """Return the outline along which a cut of width `kerf` [mm] leaves exactly this part.

        The edge moves outwards by half the kerf, and the diameter of holes decreases by the kerf.
        Sharp corners get a radius of half the kerf.
        """
        if kerf == 0:
            return self
        return replace(
            self,
            length=self.length + kerf,
            width=self.width + kerf,
            start=self.start + kerf / 2,
            end=self.end + kerf / 2,
            holes=[hole._replace(diameter=hole.diameter - kerf) for hole in self.holes],
            origin=(self.origin[0] - kerf / 2, self.origin[1]),
        )

    def translate(self, x: float, y: float) -> "Outline":
        """Return the part moved by x and y [mm]."""
        return replace(
            self,
            holes=[h._replace(x=h.x + x, y=h.y + y) for h in self.holes],
            cuts=[Cut((a + x, b + y), (c + x, d + y)) for (a, b), (c, d) in self.cuts],
            origin=(self.origin[0] + x, self.origin[1] + y),
        )

    def box(self) -> tuple[float, float, float, float]:
        """Return the smallest x and y and the largest x and y [mm]."""
        x, y = self.origin
        return x, y - self.width / 2, x + self.length, y + self.width / 2

    def least_gap(self) -> Any:
        """Return the smallest gap [mm] from a hole to an edge or hole; negative if they overlap."""
        distances = [self._edge_distance(hole) for hole in self.holes]
        for i, first in enumerate(self.holes):
            for second in self.holes[i + 1 :]:
                distance = np.hypot(first.x - second.x, first.y - second.y)
                distances.append(distance - (first.diameter + second.diameter) / 2)
        return np.min(np.broadcast_arrays(*distances), axis=0) if distances else math.inf

    def _edge_distance(self, hole: Circle) -> Any:
        left, low, right, high = self.box()
        sides = hole.x - left, right - hole.x, hole.y - low, high - hole.y
        near_y = np.minimum(sides[2], sides[3])
        distance = np.minimum(np.minimum(sides[0], sides[1]), near_y)
        for near_x, radius in ((sides[0], self.start), (sides[1], self.end)):
            # a rounded corner may be nearer than either side
            corner = radius - np.hypot(radius - near_x, radius - near_y)
            is_inside = (near_x < radius) & (near_y < radius)
            distance = np.where(is_inside, np.minimum(distance, corner), distance)
        return distance - hole.diameter / 2

    def path(self) -> list[Vertex]:
        """Return the closed edge, anticlockwise from the first end's lower corner."""
        left, low, right, high = self.box()
        a, b = self.start, self.end
        corners = (
            ((left + a, low), (right - b, low), b),
            ((right, low + b), (right, high - b), b),
            ((right - b, high), (left + a, high), a),
            ((left, high - a), (left, low + a), a),
        )
        vertices: list[Vertex] = []
        for begin, stop, radius in corners:
            vertices.append(Vertex(*begin, 0.0))
            if radius > 0:
                vertices.append(Vertex(*stop, QUARTER))
        # there is no line between two arcs that meet
        pairs = zip(vertices, [*vertices[1:], vertices[0]], strict=True)
        return [v for v, w in pairs if v.bulge or math.dist(v[:2], w[:2]) >= 1e-9]

    def points(self, chord: float = 0.01) -> list[tuple[float, float]]:
        """Return the closed edge as a polygon within `chord` [mm] of the arcs."""
        path = self.path()
        polygon = []
        for vertex, following in zip(path, [*path[1:], path[0]], strict=True):
            polygon.append((vertex.x, vertex.y))
            if vertex.bulge:
                polygon += _arc_points(vertex, following, chord)
        return polygon


def _arc_points(begin: Vertex, stop: Vertex, chord: float) -> list[tuple[float, float]]:
    radius = abs(stop.x - begin.x)
    greatest_step = 2 * math.acos(1 - chord / radius) if chord < radius else math.pi / 2
    steps = math.ceil(math.pi / 2 / greatest_step)
    # the centre is to the left of the path: above, left of, below or right of the start
    dx, dy = stop.x - begin.x, stop.y - begin.y
    x, y = (begin.x + stop.x - dy) / 2, (begin.y + stop.y + dx) / 2
    first = math.atan2(begin.y - y, begin.x - x)
    angles = (first + i * math.pi / 2 / steps for i in range(1, steps))
    return [(x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles]


def bounding_box(parts: Sequence[Outline]) -> tuple[float, float, float, float]:
    """Return the smallest x and y and the largest x and y of several parts [mm]."""
    lefts, lows, rights, highs = zip(*(part.box() for part in parts), strict=True)
    return min(lefts), min(lows), max(rights), max(highs)


def clamp_holes(clamp_length: float, width: float, screws: int, hole: float) -> list[Circle]:
    """Return the screw holes of a sheet or a spacer [mm], in a row across its clamped end."""
    row = (width * ((i + 0.5) / screws - 0.5) for i in range(screws))
    return [Circle(clamp_length / 2, y, hole) for y in row]


def make_sheet(
    length: float,
    width: float,
    *,
    clamp_length: float,
    hole: float,
    screws: int = 1,
    tip_radius: float = 1.0,
    clamp_radius: float = 0.5,
) -> Outline:
    """Return one sheet [mm], with its clamped end at x = 0; `hole` is a diameter."""
    return Outline(
        length=length,
        width=width,
        start=clamp_radius,
        end=tip_radius,
        holes=clamp_holes(clamp_length, width, screws, hole),
    )


def make_spacer(
    clamp_length: float, width: float, *, hole: float, screws: int = 1, clamp_radius: float = 0.5
) -> Outline:
    """Return one spacer [mm], which fills the gap between two sheets inside a cap."""
    options = {"clamp_length": clamp_length, "hole": hole, "clamp_radius": clamp_radius}
    return make_sheet(clamp_length, width, screws=screws, tip_radius=clamp_radius, **options)
