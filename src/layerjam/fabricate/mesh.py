"""A part as a closed mesh of triangles, by manifold3d (extra `build`) [mm]."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layerjam.errors import MissingExtraError
from layerjam.fabricate.solid import PLANE, Axis, Prism, Solid

AXES: tuple[Axis, ...] = ("x", "y", "z")
FINEST = 1e-4
"""Edges shorter than this are collapsed: a file of 32-bit numbers could not hold them [mm]."""


@dataclass(frozen=True)
class Mesh:
    """A closed, consistently oriented surface: corners (n, 3) in mm and triangles (m, 3)."""

    name: str
    corners: NDArray[np.float64]
    triangles: NDArray[np.int64]

    @property
    def volume(self) -> float:
        """The volume inside [mm³]."""
        a, b, c = (self.corners[self.triangles[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    @property
    def handles(self) -> int:
        """Holes that go through: the genus, by Euler's formula for one closed surface."""
        edges = len(self.triangles) * 3 // 2
        return 1 - (len(self.corners) - edges + len(self.triangles)) // 2


@functools.lru_cache(maxsize=64)
def mesh(part: Solid) -> Mesh:
    """The part's mesh, always the same for the same part.

    Raises MissingExtraError without the extra `build`, and RuntimeError for a mesh that is not
    closed, which would be an error of this program.
    """
    with MissingExtraError.raise_if_missing("the mesh of a printed part (manifold3d)", "build"):
        from manifold3d import Error, Manifold, OpType

    added = [_swept(p) for p in part.prisms if not p.cut]
    cuts = [_swept(p) for p in part.prisms if p.cut]
    whole = Manifold.batch_boolean(added, OpType.Add)
    if cuts:
        whole = whole - Manifold.batch_boolean(cuts, OpType.Add)
    whole = whole.simplify(FINEST)
    if whole.status() != Error.NoError or whole.is_empty():
        raise RuntimeError(f"the mesh of {part.name} failed: {whole.status()}")
    found = whole.to_mesh64()
    corners = np.asarray(found.vert_properties, dtype=float)[:, :3]
    return _ordered(part.name, corners, np.asarray(found.tri_verts, dtype=np.int64))


def _swept(prism: Prism) -> Any:
    """One prism as a closed mesh; its planes lie exactly where its numbers say.

    Two prisms meet in one plane only if both have the same number for it, to the last bit: a
    library that sweeps outlines rounds them, and leaves skins too thin to be seen.
    """
    from manifold3d import Manifold, Mesh64

    outline = np.array(prism.section.outline())
    count = len(outline)
    corners = np.empty((2 * count, 3))
    along = AXES.index(prism.axis)
    for half, level in ((slice(count), prism.start), (slice(count, None), prism.end)):
        corners[half, along] = level
        for place, axis in enumerate(PLANE[prism.axis]):
            corners[half, AXES.index(axis)] = outline[:, place]
    this = np.arange(count)
    after = (this + 1) % count
    fan = np.stack([np.zeros(count - 2, dtype=int), this[1:-1], this[2:]], axis=1)
    walls = [(this, after, after + count), (this, after + count, this + count)]
    sides = [np.stack(rows, axis=1) for rows in walls]
    triangles = np.concatenate([fan[:, ::-1], fan + count, *sides])
    return Manifold(Mesh64(corners, triangles.astype(np.uint64)))


def _ordered(name: str, corners: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    """Corners and triangles in an order that depends on where they are alone."""
    order = np.lexsort(corners.T[::-1])
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    turned = rank[triangles]
    first = turned.argmin(axis=1)
    rows = np.arange(len(turned))[:, None]
    turned = turned[rows, (first[:, None] + np.arange(3)) % 3]
    return Mesh(name, corners[order], turned[np.lexsort(turned.T[::-1])])
