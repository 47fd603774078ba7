"""A part as a closed triangle mesh, made by manifold3d (extra `build`) [mm]."""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layerjam.core.errors import MissingExtraError
from layerjam.workshop.fabricate.solid import PLANE, Axis, Prism, Solid

AXES: tuple[Axis, ...] = ("x", "y", "z")
FINEST = 1e-4
"""Length below which edges are collapsed, because 32-bit numbers cannot represent them [mm]."""


@dataclass(frozen=True)
class Mesh:
    """Closed, consistently oriented surface: vertices (n, 3) in mm and triangles (m, 3)."""

    name: str
    corners: NDArray[np.float64]
    triangles: NDArray[np.int64]

    @property
    def volume(self) -> float:
        """Enclosed volume [mm³]."""
        a, b, c = (self.corners[self.triangles[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    @property
    def hole_count(self) -> int:
        """Number of through holes: the genus, by Euler's formula for one closed surface."""
        edges = len(self.triangles) * 3 // 2
        return 1 - (len(self.corners) - edges + len(self.triangles)) // 2


@functools.lru_cache(maxsize=64)
def make_mesh(part: Solid) -> Mesh:
    """Return a part's mesh; identical parts have identical meshes.

    Raises MissingExtraError if the `build` extra is not installed, and RuntimeError for a mesh that
    is not closed, which would be a bug.
    """
    with MissingExtraError.raise_if_missing("the mesh of a printed part (manifold3d)", "build"):
        from manifold3d import Error, Manifold, OpType

    bodies = [_sweep_prism(p) for p in part.prisms if not p.cut]
    cuts = [_sweep_prism(p) for p in part.prisms if p.cut]
    union = Manifold.batch_boolean(bodies, OpType.Add)
    if cuts:
        union = union - Manifold.batch_boolean(cuts, OpType.Add)
    union = union.simplify(FINEST)
    if union.status() != Error.NoError or union.is_empty():
        raise RuntimeError(f"the mesh of {part.name} cannot be built: {union.status()}")
    triangles = union.to_mesh64()
    corners = np.asarray(triangles.vert_properties, dtype=float)[:, :3]
    return _sort_mesh(part.name, corners, np.asarray(triangles.tri_verts, dtype=np.int64))


def _sweep_prism(prism: Prism) -> Any:
    """Return one prism as a closed mesh; its faces are exactly at the given coordinates.

    Two prisms meet in one plane only if both have the same coordinate for it, to the last bit. A
    library that sweeps outlines would round the coordinates and leave invisibly thin skins.
    """
    from manifold3d import Manifold, Mesh64

    outline = np.array(prism.section.outline())
    count = len(outline)
    corners = np.empty((2 * count, 3))
    axis_index = AXES.index(prism.axis)
    for half, level in ((slice(count), prism.start), (slice(count, None), prism.end)):
        corners[half, axis_index] = level
        for place, axis in enumerate(PLANE[prism.axis]):
            corners[half, AXES.index(axis)] = outline[:, place]
    corner = np.arange(count)
    next_corner = (corner + 1) % count
    fan = np.stack([np.zeros(count - 2, dtype=int), corner[1:-1], corner[2:]], axis=1)
    walls = [
        (corner, next_corner, next_corner + count),
        (corner, next_corner + count, corner + count),
    ]
    sides = [np.stack(rows, axis=1) for rows in walls]
    triangles = np.concatenate([fan[:, ::-1], fan + count, *sides])
    return Manifold(Mesh64(corners, triangles.astype(np.uint64)))


def _sort_mesh(name: str, corners: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    """Return the mesh with vertices and triangles in an order determined by their positions."""
    order = np.lexsort(corners.T[::-1])
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    ranks = rank[triangles]
    first = ranks.argmin(axis=1)
    rows = np.arange(len(ranks))[:, None]
    ranks = ranks[rows, (first[:, None] + np.arange(3)) % 3]
    return Mesh(name, corners[order], ranks[np.lexsort(ranks.T[::-1])])
