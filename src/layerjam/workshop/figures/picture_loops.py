"""Depth buffer and edges of a picture, in C, or in NumPy if there is no compiled library."""

import ctypes
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layerjam.brake.kernel.compiler import SHADING
from layerjam.brake.kernel.library import open_library_if_possible
from layerjam.core.threads import cache_threadsafe

FINER = 2
"""Number of samples along each side of a pixel."""
CREASE = math.cos(math.radians(25))
"""Cosine of the angle between two faces of a body; at a larger angle, an edge is drawn."""
STEP = 0.15
"""Jump in depth within a body [mm]; at a larger jump, an edge is drawn."""
INK = 32.0
"""Brightness of an edge."""
Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Indices = NDArray[np.int32]


class _Edges(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_double) for name in ("crease", "step", "ink"))


def fill_triangles(
    points: Floats, triangles: NDArray[np.int64], first: int, depth: Singles, face: Indices
) -> None:
    """Draw every triangle into the depth buffer; rows of the picture count from the top."""
    library = _load_library()
    if library is None:
        _fill_in_numpy(points, triangles, first, depth, face)
        return
    corners, places = np.ascontiguousarray(points), np.ascontiguousarray(triangles, np.int64)
    addresses = (array.ctypes.data for array in (corners, places))
    shape = (len(places), first, *depth.shape)
    library.lj_fill_triangles(*addresses, *shape, depth.ctypes.data, face.ctypes.data)


def average_pixels(
    depth: Singles,
    face: Indices,
    normals: Floats,
    owner: Indices,
    shades: Floats,
    fine_scale: float,
    pixels: NDArray[np.uint8],
) -> None:
    """Write into `pixels` the shades and edges of the samples, averaged over each pixel.

    `fine_scale` is the number of samples per mm.
    """
    library = _load_library()
    if library is None:
        pixels[:] = _average_in_numpy(depth, face, normals, owner, shades, fine_scale)
        return
    samples = depth.ctypes.data, face.ctypes.data
    faces = [np.ascontiguousarray(array) for array in (normals, owner, shades)]
    library.lj_average_pixels(
        *samples, *depth.shape, FINER, *(array.ctypes.data for array in faces), fine_scale,
        _Edges(CREASE, STEP, INK), pixels.ctypes.data,
    )  # fmt: skip


@cache_threadsafe
def _load_library() -> Any:
    library = open_library_if_possible(SHADING, "pictures are drawn")
    if library is not None:
        integer, address = ctypes.c_int64, ctypes.c_void_p
        library.lj_fill_triangles.argtypes = (*(address,) * 2, *(integer,) * 4, *(address,) * 2)
        library.lj_average_pixels.argtypes = (
            *(address,) * 2, *(integer,) * 3, *(address,) * 3, ctypes.c_double,
            ctypes.POINTER(_Edges), address,
        )  # fmt: skip
        library.lj_fill_triangles.restype = library.lj_average_pixels.restype = None
    return library


def _fill_in_numpy(
    points: Floats, triangles: NDArray[np.int64], first: int, depth: Singles, face: Indices
) -> None:
    rows, columns = depth.shape
    upwards, faces = depth[::-1], face[::-1]
    for number, (a, b, c) in enumerate(points[triangles], first):
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area <= 1e-12:  # the triangle is seen from behind, or edge-on
            continue
        low = max(math.floor(min(a[1], b[1], c[1]) - 0.5), 0)
        high = min(math.ceil(max(a[1], b[1], c[1]) - 0.5), rows - 1)
        ups = slice(low, max(high + 1, low))
        y = np.arange(ups.start, ups.stop)[:, None] + 0.5
        # where each row of samples enters and leaves the triangle
        start, stop = np.full_like(y, 0.5), np.full_like(y, columns - 0.5)
        for e, f in ((a, b), (b, c), (c, a)):
            # a sample is inside an edge if (f - e) x (sample - e) >= 0, linear in x
            slope = e[1] - f[1]
            offset = (f[0] - e[0]) * (y - e[1]) - slope * e[0]
            if slope > 0.0:
                start = np.maximum(start, -offset / slope)
            elif slope < 0.0:
                stop = np.minimum(stop, -offset / slope)
            else:
                stop = np.where(offset < 0.0, -1.0, stop)
        begin = math.ceil(start.min(initial=columns) - 0.5)
        ends = begin, max(math.floor(stop.max(initial=0.0) - 0.5) + 1, begin)
        x = np.arange(*ends) + 0.5
        q = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
        r = ((a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)) / area
        z = (1.0 - q - r) * a[2] + q * b[2] + r * c[2]
        part = ups, slice(*ends)
        visible = (x >= start) & (x <= stop) & (z > upwards[part])
        upwards[part][visible] = z[visible]
        faces[part][visible] = number


def _find_edges(
    depth: Singles, face: Indices, normals: Floats, owner: Indices, fine_scale: float
) -> NDArray[np.bool_]:
    """Return whether an edge runs between a sample and the next one, to the right or below."""
    edges = np.zeros(face.shape, bool)
    for axis, is_right in ((1, True), (0, False)):
        place = np.s_[:, :-1] if is_right else np.s_[:-1]
        step = np.diff(depth, axis=axis)
        first, second = face[place], np.roll(face, -1, axis)[place]
        rows, columns = np.nonzero(first != second)
        i, j = first[rows, columns], second[rows, columns]
        n, m = normals[i], normals[j]
        is_edge = (i < 0) | (j < 0) | (owner[i] != owner[j])
        is_edge |= n[:, 0] * m[:, 0] + n[:, 1] * m[:, 1] + n[:, 2] * m[:, 2] < CREASE
        # in a plane the depth changes in proportion to its slope
        slope = -((n[:, 0] if is_right else -n[:, 1]) / np.maximum(n[:, 2], 0.05)) / fine_scale
        is_edge |= np.abs(step[rows, columns] - slope) > STEP + np.abs(slope)
        edges[place][rows, columns] |= is_edge
    return edges


def _average_in_numpy(
    depth: Singles,
    face: Indices,
    normals: Floats,
    owner: Indices,
    shades: Floats,
    fine_scale: float,
) -> NDArray[np.uint8]:
    with np.errstate(invalid="ignore"):  # without a face, the depth is infinite
        is_edge = _find_edges(depth, face, normals, owner, fine_scale)
    colours = np.where((face < 0)[..., None], 255.0, shades[face])
    colours[is_edge] = INK
    total: Any = sum(colours[i // FINER :: FINER, i % FINER :: FINER] for i in range(FINER**2))
    return np.asarray((total / FINER**2 + 0.5).astype(np.uint8))
