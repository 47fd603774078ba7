"""Pictures of bodies made of triangles: orthographic view, depth buffer, dark edges.

No graphics card or window is needed: C, or NumPy, fills the triangles (`picture_loops.py`). Edges
are detected in the picture, where the body, face or depth changes.
"""

import math
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layerjam.workshop.figures.picture_loops import FINER, average_pixels, fill_triangles

LIGHT = (-0.25, -0.45, 0.86)
PALE, DARK = 0.52, 0.5
"""Brightness of an unlit face, and the contribution of light."""


@dataclass(frozen=True, eq=False)
class Body:
    """A closed surface in one colour: corners (n, 3) in mm, triangles (m, 3), "#rrggbb"."""

    corners: NDArray[np.float64]
    triangles: NDArray[np.int64]
    colour: str

    def shift(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> "Body":
        """Return the body moved by x, y and z [mm]."""
        return Body(self.corners + np.array([x, y, z]), self.triangles, self.colour)

    def turn(self, length: float) -> "Body":
        """Return the body rotated by half a turn about the vertical axis at half of `length`."""
        return Body(
            self.corners * (-1, -1, 1) + np.array([length, 0, 0]), self.triangles, self.colour
        )


@dataclass(frozen=True)
class View:
    """Direction of view [deg]: azimuth from +x, elevation above the table."""

    azimuth: float = -62.0
    elevation: float = 26.0

    def axes(self) -> NDArray[np.float64]:
        """Return the unit vectors to the right, upwards and towards the viewer, as rows."""
        a, e = math.radians(self.azimuth), math.radians(self.elevation)
        right = (-math.sin(a), math.cos(a), 0.0)
        up = (-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e))
        toward = (math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e))
        return np.array([right, up, toward])


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture: pixels (rows, columns, 3), and the projection of points in space."""

    pixels: NDArray[np.uint8]
    axes: NDArray[np.float64]
    corner: tuple[float, float]
    """Horizontal and vertical coordinate of the picture's lower left corner [mm]."""
    scale: float
    """Pixels per mm."""
    bodies: Sequence[Body]
    owner: NDArray[np.int32]
    """Index of the body that each pixel shows, -1 for none."""

    def visible_mask(self, body: Body) -> NDArray[np.bool_]:
        """Return the mask of the pixels that show a body of the picture."""
        number = next(i for i, item in enumerate(self.bodies) if item is body)
        return self.owner == number

    def find_middle(self, body: Body) -> tuple[float, float] | None:
        """Return the column and row in the middle of a body's visible part; None if hidden."""
        rows, columns = np.nonzero(self.visible_mask(body))
        if not len(rows):
            return None
        nearest = np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2)
        return float(columns[nearest]) + 0.5, float(rows[nearest]) + 0.5

    def project(self, point: Sequence[float]) -> tuple[float, float]:
        """Return the column and row of a point in space [mm]."""
        right, up, _ = self.axes @ np.asarray(point, dtype=float)
        rows = self.pixels.shape[0]
        return (right - self.corner[0]) * self.scale, rows - (up - self.corner[1]) * self.scale

    def png(self) -> bytes:
        """Return the picture as PNG; the same pixels produce the same bytes."""
        rows, columns, _ = self.pixels.shape
        raw = np.zeros((rows, 1 + 3 * columns), dtype=np.uint8)
        raw[:, 1:] = self.pixels.reshape(rows, -1)
        head = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
        parts = ((b"IHDR", head), (b"IDAT", zlib.compress(raw.tobytes(), 6)), (b"IEND", b""))
        return b"\x89PNG\r\n\x1a\n" + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in parts
        )


def render_bodies(
    bodies: Sequence[Body], view: View = View(), width: int = 1400, border: int = 12
) -> Shot:
    """Render the bodies on white, as large as possible within a square of `width` pixels."""
    axes = view.axes()
    views = [body.corners @ axes.T for body in bodies]
    low = np.min([points.min(axis=0) for points in views], axis=0)
    high = np.max([points.max(axis=0) for points in views], axis=0)
    wide, height = high[0] - low[0], high[1] - low[1]
    scale = float((width - 2 * border) / max(wide, height))
    columns = math.ceil(wide * scale) + 2 * border
    rows = math.ceil(height * scale) + 2 * border
    corner = float(low[0] - border / scale), float(low[1] - border / scale)
    fine_scale = scale * FINER
    depth = np.full((rows * FINER, columns * FINER), -np.inf, dtype=np.float32)
    face = np.full(depth.shape, -1, dtype=np.int32)
    normals, owners = [], []
    first = 0
    for number, (points, body) in enumerate(zip(views, bodies, strict=True)):
        screen = np.ascontiguousarray((points - (*corner, 0.0)) * (fine_scale, fine_scale, 1.0))
        fill_triangles(screen, body.triangles, first, depth, face)
        a, b, c = (points[body.triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normals.append(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])
        owners.append(np.full(len(body.triangles), number, dtype=np.int32))
        first += len(body.triangles)
    shades, owner = _compute_shades(bodies, normals, axes), np.concatenate(owners)
    pixels = np.empty((rows, columns, 3), dtype=np.uint8)
    average_pixels(depth, face, np.concatenate(normals), owner, shades, fine_scale, pixels)
    faces = face[::FINER, ::FINER]
    return Shot(
        pixels, axes, corner, scale, bodies, np.where(faces < 0, -1, owner[faces]).astype(np.int32)
    )


def _compute_shades(
    bodies: Sequence[Body], normals: Sequence[NDArray[np.float64]], axes: NDArray[np.float64]
) -> NDArray[np.float64]:
    light = axes @ (np.array(LIGHT) / np.linalg.norm(LIGHT))
    colors = []
    for body, normal in zip(bodies, normals, strict=True):
        paint = np.array([int(body.colour[i : i + 2], 16) for i in (1, 3, 5)], dtype=float)
        bright = PALE + DARK * np.clip(normal @ light, 0.0, 1.0)
        colors.append(np.minimum(bright[:, None] * paint, 255.0))
    return np.concatenate(colors)
