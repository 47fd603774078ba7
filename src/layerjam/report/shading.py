"""Pictures of bodies made of triangles: orthographic view, depth buffer, dark edges.

No graphics card or window is needed: numba compiles a loop over triangles and caches it. Edges are
detected in the picture, where the body, face or depth changes.
"""

import math
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layerjam.mechanics.compilation import compile_loop

FINER = 2
"""Number of samples along each side of a pixel."""
CREASE = math.cos(math.radians(25))
"""Cosine of the angle between two faces of a body; at a larger angle, an edge is drawn."""
STEP = 0.15
"""Jump in depth within a body [mm]; at a larger jump, an edge is drawn."""
INK = 32.0
"""Brightness of an edge."""
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
    wide, tall = high[0] - low[0], high[1] - low[1]
    scale = float((width - 2 * border) / max(wide, tall))
    columns = math.ceil(wide * scale) + 2 * border
    rows = math.ceil(tall * scale) + 2 * border
    corner = float(low[0] - border / scale), float(low[1] - border / scale)
    fine = scale * FINER
    depth = np.full((rows * FINER, columns * FINER), -np.inf, dtype=np.float32)
    face = np.full(depth.shape, -1, dtype=np.int32)
    normals, owners = [], []
    first = 0
    for number, (points, body) in enumerate(zip(views, bodies, strict=True)):
        screen = np.ascontiguousarray((points - (*corner, 0.0)) * (fine, fine, 1.0))
        _fill_triangles(screen, body.triangles, first, depth, face)
        a, b, c = (points[body.triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normals.append(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])
        owners.append(np.full(len(body.triangles), number, dtype=np.int32))
        first += len(body.triangles)
    shades, owner = _compute_shades(bodies, normals, axes), np.concatenate(owners)
    pixels = np.empty((rows, columns, 3), dtype=np.uint8)
    _average_pixels(depth, face, np.concatenate(normals), owner, shades, fine, pixels)
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


@compile_loop(nogil=True)
def _fill_triangles(points, triangles, first, depth, face):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Draw every triangle into the depth buffer; rows of the picture count from the top."""
    rows, columns = depth.shape
    for i in range(len(triangles)):
        a, b, c = points[triangles[i, 0]], points[triangles[i, 1]], points[triangles[i, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area <= 1e-12:  # the triangle is seen from behind, or edge-on
            continue
        low = max(math.floor(min(a[1], b[1], c[1]) - 0.5), 0)
        high = min(math.ceil(max(a[1], b[1], c[1]) - 0.5), rows - 1)
        for v in range(low, high + 1):
            y = v + 0.5
            # where this row of samples enters and leaves the triangle
            start, stop = -0.5, columns - 0.5
            for k in range(3):
                e, f = points[triangles[i, k]], points[triangles[i, (k + 1) % 3]]
                # a sample is inside an edge if (f - e) x (sample - e) >= 0, linear in x
                slope = e[1] - f[1]
                offset = (f[0] - e[0]) * (y - e[1]) - slope * e[0]
                if slope > 0.0:
                    start = max(start, -offset / slope)
                elif slope < 0.0:
                    stop = min(stop, -offset / slope)
                elif offset < 0.0:
                    stop = -1.0
            row = rows - 1 - v
            for u in range(
                max(math.ceil(start - 0.5), 0), min(math.floor(stop - 0.5) + 1, columns)
            ):
                x = u + 0.5
                q = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
                r = ((a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)) / area
                z = (1.0 - q - r) * a[2] + q * b[2] + r * c[2]
                if z > depth[row, u]:
                    depth[row, u] = z
                    face[row, u] = first + i


@compile_loop(nogil=True)
def _find_edges(depth, face, normals, owner, v, u, w, t, fine):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Return whether an edge runs between two neighbouring samples."""
    first, second = face[v, u], face[w, t]
    if first == second:
        return False
    if first < 0 or second < 0 or owner[first] != owner[second]:
        return True
    n, m = normals[first], normals[second]
    if n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < CREASE:
        return True
    # in a plane the depth changes in proportion to its slope
    slope = -((n[0] * (t - u) - n[1] * (w - v)) / max(n[2], 0.05)) / fine
    return abs(depth[w, t] - depth[v, u] - slope) > STEP + abs(slope)


@compile_loop(nogil=True)
def _average_pixels(depth, face, normals, owner, shades, fine, pixels):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Write into `pixels` the shades and edges of the samples, averaged over each pixel."""
    rows, columns = depth.shape
    for v in range(pixels.shape[0]):
        for u in range(pixels.shape[1]):
            red = green = blue = 0.0
            for i in range(FINER * FINER):
                w, t = FINER * v + i // FINER, FINER * u + i % FINER
                front = face[w, t]
                right, below = min(t + 1, columns - 1), min(w + 1, rows - 1)
                if (face[w, right] != front or face[below, t] != front) and (
                    _find_edges(depth, face, normals, owner, w, t, w, right, fine)
                    or _find_edges(depth, face, normals, owner, w, t, below, t, fine)
                ):
                    red, green, blue = red + INK, green + INK, blue + INK
                elif front < 0:
                    red, green, blue = red + 255.0, green + 255.0, blue + 255.0
                else:
                    red += shades[front, 0]
                    green += shades[front, 1]
                    blue += shades[front, 2]
            pixels[v, u, 0] = np.uint8(red / (FINER * FINER) + 0.5)
            pixels[v, u, 1] = np.uint8(green / (FINER * FINER) + 0.5)
            pixels[v, u, 2] = np.uint8(blue / (FINER * FINER) + 0.5)
