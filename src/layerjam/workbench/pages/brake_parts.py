"""The drawn parts of a build, in a 3-D view that the user can rotate."""

import base64
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui.elements.scene.scene_object3d import Object3D

from layerjam.workbench.scene import CameraView, Point

if TYPE_CHECKING:
    from layerjam.workshop.fabricate.drawing import Drawing
    from layerjam.workshop.figures.shading import Body

UNIT = 10.0
"""Millimetres per unit of the scene."""
VIEWS: Mapping[str, Point] = {
    "whole": (0.46, -1.13, 0.52),
    "from the left": (-1.05, -0.4, 0.3),
    "above": (0.0, -0.02, 1.15),
    "below": (0.25, -0.75, -0.8),
}
"""Directions from which the parts are seen."""


@dataclass(frozen=True)
class Surface:
    """All bodies of one colour as one surface, with vertices and triangles for the browser."""

    colour: str
    corners: str
    triangles: str


@dataclass(frozen=True)
class Parts:
    """Surfaces centred in the scene; `size` contains their bounding box's sides [scene units]."""

    surfaces: tuple[Surface, ...]
    size: Point


def collect_parts(drawing: "Drawing", mould: bool) -> Parts:
    """Return the parts of one brake in exploded view, or its opened mould."""
    # import late, because the Brake page opens before the drawing code is loaded
    from layerjam.workshop.figures import build_pictures, build_scene

    world = build_scene.make_scene(drawing.build, drawing.lengths)
    if mould:
        return merge_bodies(build_pictures.separate_mould(world).values())
    parts = build_pictures.separate_parts(world).values()
    return merge_bodies(body for part in parts for body in part)


def merge_bodies(bodies: "Iterable[Body]") -> Parts:
    """Return the bodies as one surface per colour, centred in the scene."""
    by_colour: dict[str, list[Body]] = {}
    for body in bodies:
        by_colour.setdefault(body.colour, []).append(body)
    every = np.concatenate([body.corners for group in by_colour.values() for body in group])
    low, high = every.min(axis=0), every.max(axis=0)
    parts = tuple(
        _make_surface(colour, group, (low + high) / 2) for colour, group in by_colour.items()
    )
    x, y, z = ((high - low) / UNIT).tolist()
    return Parts(parts, (x, y, z))


def _make_surface(colour: str, bodies: "list[Body]", middle: Any) -> Surface:
    first = np.cumsum([0, *(len(body.corners) for body in bodies)])
    corners = np.concatenate([body.corners - middle for body in bodies]) / UNIT
    triangles = np.concatenate([b.triangles + k for b, k in zip(bodies, first, strict=False)])
    arrays = (corners.astype("<f4"), triangles.astype("<u4"))
    return Surface(colour, *(base64.b64encode(a.tobytes()).decode() for a in arrays))


class Solid(Object3D, component=Path(__file__).parents[1] / "solid.js"):
    """A closed surface in one colour."""

    def __init__(self, surface: Surface) -> None:
        super().__init__(surface.colour, surface.corners, surface.triangles)


class PartsView(CameraView):
    """The 3-D view; only surfaces that changed are sent."""

    def __init__(self, ident: str) -> None:
        self._shown: dict[str, tuple[Surface, Solid]] = {}
        words = {"label": "Parts to make, exploded view", "button": "View of the parts"}
        super().__init__(VIEWS, 360, ident, "w-full h-96", **words)

    def show(self, parts: Parts, dark: bool) -> None:
        """Update the scene."""
        self.set_ground_colour(dark)
        current = {surface.colour: surface for surface in parts.surfaces}
        for colour, (surface, solid) in [*self._shown.items()]:
            if current.get(colour) != surface:
                self._shown.pop(colour)
                solid.delete()
        with self.scene:
            for colour, surface in current.items():
                if colour not in self._shown:
                    self._shown[colour] = (surface, Solid(surface))
        x, y, z = (side / 2 for side in parts.size)
        self.enclose_box((-x, -y, -z), (x, y, z))
