"""Flat parts: rectangles with rounded ends and round holes, in mm.

Sheets, spacers, yokes, links, the jig and the coupons are all such parts, so that area, length of
cut and the offset by the kerf are closed forms and no library for offsets is needed.

x runs along the part from its first end, y across it; y = 0 lies in the middle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

QUARTER = math.sqrt(2) - 1
"""Bulge of a quarter of a circle: tan(90°/4)."""


class Circle(NamedTuple):
    """A round hole [mm]."""

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
    """A corner of a closed path [mm]; `bulge` is that of the segment to the next corner.

    The bulge is the tangent of a quarter of the arc's angle: 0 for a line.
    """

    x: float
    y: float
    bulge: float


class Cut(NamedTuple):
    """A straight cut that does not close [mm]; only coupons have such."""

    start: tuple[float, float]
    end: tuple[float, float]

    @property
    def length(self) -> float:
        """Length [mm]."""
        return math.dist(self.start, self.end)


@dataclass(frozen=True, kw_only=True)
class Outline:
    """A part of `length` × `width`, its corners rounded by `start` (at x = 0) and `end` [mm]."""

    length: float
    width: float
    start: float = 0.0
    end: float = 0.0
    holes: Sequence[Circle] = ()
    cuts: Sequence[Cut] = ()
    origin: tuple[float, float] = (0.0, 0.0)
    """Where the middle of the first end lies."""

    def area(self) -> float:
        """Area of the part [mm²], without its holes."""
        corners = (2 - math.pi / 2) * (self.start**2 + self.end**2)
        return self.length * self.width - corners - sum(hole.area for hole in self.holes)

    def cut_length(self) -> float:
        """Length of all lines that are cut [mm]."""
        edge = 2 * (self.length + self.width) - (4 - math.pi) * (self.start + self.end)
        inside = [hole.length for hole in self.holes] + [cut.length for cut in self.cuts]
        return edge + sum(inside)

    def grown(self, kerf: float) -> Outline:
        """The lines along which a cut of the width `kerf` [mm] leaves just this part.

        Exact: half the kerf outwards all round, holes smaller by the kerf. A sharp corner becomes
        round by half the kerf.
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

    def moved(self, x: float, y: float) -> Outline:
        """The part somewhere else [mm]."""
        return replace(
            self,
            holes=[h._replace(x=h.x + x, y=h.y + y) for h in self.holes],
            cuts=[Cut((a + x, b + y), (c + x, d + y)) for (a, b), (c, d) in self.cuts],
            origin=(self.origin[0] + x, self.origin[1] + y),
        )

    def box(self) -> tuple[float, float, float, float]:
        """Least x, least y, greatest x and greatest y [mm]."""
        x, y = self.origin
        return x, y - self.width / 2, x + self.length, y + self.width / 2

    def rim(self) -> Any:
        """Least material between a hole and the edge or another hole [mm]; below 0 they cut."""
        least = [self._to_edge(hole) for hole in self.holes]
        for i, one in enumerate(self.holes):
            for other in self.holes[i + 1 :]:
                apart = np.hypot(one.x - other.x, one.y - other.y)
                least.append(apart - (one.diameter + other.diameter) / 2)
        return np.min(np.broadcast_arrays(*least), axis=0) if least else math.inf

    def _to_edge(self, hole: Circle) -> Any:
        left, low, right, high = self.box()
        sides = hole.x - left, right - hole.x, hole.y - low, high - hole.y
        across = np.minimum(sides[2], sides[3])
        least = np.minimum(np.minimum(sides[0], sides[1]), across)
        for along, radius in ((sides[0], self.start), (sides[1], self.end)):
            # a rounded corner is nearer than both sides
            corner = radius - np.hypot(radius - along, radius - across)
            inside = (along < radius) & (across < radius)
            least = np.where(inside, np.minimum(least, corner), least)
        return least - hole.diameter / 2

    def path(self) -> list[Vertex]:
        """The closed edge, anticlockwise from the first end's lower corner."""
        left, low, right, high = self.box()
        a, b = self.start, self.end
        corners = (
            ((left + a, low), (right - b, low), b),
            ((right, low + b), (right, high - b), b),
            ((right - b, high), (left + a, high), a),
            ((left, high - a), (left, low + a), a),
        )
        made: list[Vertex] = []
        for begin, stop, radius in corners:
            made.append(Vertex(*begin, 0.0))
            if radius > 0:
                made.append(Vertex(*stop, QUARTER))
        after = [*made[1:], made[0]]
        # where two arcs meet there is no line between them
        return [v for v, w in zip(made, after, strict=True) if v.bulge or not _same(v, w)]

    def points(self, chord: float = 0.01) -> list[tuple[float, float]]:
        """The closed edge as a polygon whose chords leave the arcs by at most `chord` [mm]."""
        path = self.path()
        made = []
        for vertex, after in zip(path, [*path[1:], path[0]], strict=True):
            made.append((vertex.x, vertex.y))
            if vertex.bulge:
                made += _between(vertex, after, chord)
        return made


def _same(one: Vertex, other: Vertex) -> bool:
    """Whether two corners are one, but for rounding."""
    return math.dist(one[:2], other[:2]) < 1e-9


def _between(begin: Vertex, stop: Vertex, chord: float) -> list[tuple[float, float]]:
    """Points inside a quarter of a circle, anticlockwise."""
    radius = abs(stop.x - begin.x)
    most = 2 * math.acos(1 - chord / radius) if chord < radius else math.pi / 2
    steps = math.ceil(math.pi / 2 / most)
    # the centre lies to the left of the way: above, left of, below or right of the begin
    dx, dy = stop.x - begin.x, stop.y - begin.y
    x, y = (begin.x + stop.x - dy) / 2, (begin.y + stop.y + dx) / 2
    first = math.atan2(begin.y - y, begin.x - x)
    angles = (first + i * math.pi / 2 / steps for i in range(1, steps))
    return [(x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles]


def around(parts: Sequence[Outline]) -> tuple[float, float, float, float]:
    """Least x, least y, greatest x and greatest y of several parts [mm]."""
    boxes = [part.box() for part in parts]
    low, high = boxes[0][:2], boxes[0][2:]
    for box in boxes[1:]:
        low = min(low[0], box[0]), min(low[1], box[1])
        high = max(high[0], box[2]), max(high[1], box[3])
    return (*low, *high)


def clamp_holes(clamped: float, width: float, screws: int, hole: float) -> list[Circle]:
    """The screws' holes in a sheet or a spacer [mm], in a row across the clamped end."""
    row = (width * ((i + 0.5) / screws - 0.5) for i in range(screws))
    return [Circle(clamped / 2, y, hole) for y in row]


def sheet(
    length: float,
    width: float,
    *,
    clamped: float,
    hole: float,
    screws: int = 1,
    tip_radius: float = 1.0,
    clamp_radius: float = 0.5,
) -> Outline:
    """One sheet [mm], its clamped end at x = 0; `hole` is a diameter."""
    return Outline(
        length=length,
        width=width,
        start=clamp_radius,
        end=tip_radius,
        holes=clamp_holes(clamped, width, screws, hole),
    )


def spacer(
    clamped: float, width: float, *, hole: float, screws: int = 1, clamp_radius: float = 0.5
) -> Outline:
    """One spacer [mm]: it fills the gap between two sheets inside a cap."""
    return Outline(
        length=clamped,
        width=width,
        start=clamp_radius,
        end=clamp_radius,
        holes=clamp_holes(clamped, width, screws, hole),
    )
