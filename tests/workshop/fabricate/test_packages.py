"""3MF and STL as an independent reader finds them."""

from __future__ import annotations

import io
import zipfile

import lib3mf
import numpy as np
import pytest
import trimesh

from built_parts import parts_of
from layerjam.workshop.fabricate.mesh import make_mesh
from layerjam.workshop.fabricate.package import write_3mf, write_stl

PARTS = {name: part for name, part in parts_of().items() if part.printed}
MESHES = [make_mesh(part.solid) for part in PARTS.values()]


def objects(data: bytes) -> tuple[list, list[str]]:
    """Mesh objects of a 3MF read in strict mode, and the reader's warnings."""
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromBuffer(data)
    warnings = [str(reader.GetWarning(k)) for k in range(reader.GetWarningCount())]
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    found = model.GetMeshObjects()
    out = []
    while found.MoveNext():
        out.append(found.GetCurrentMeshObject())
    items, count = model.GetBuildItems(), 0
    while items.MoveNext():
        count += 1
    assert count == len(out)
    return out, warnings


def test_the_package_is_strict_and_holds_every_part() -> None:
    found, warnings = objects(write_3mf(MESHES, "a brake"))
    assert warnings == []
    assert {one.GetName() for one in found} == set(PARTS)
    for one in found:
        assert one.IsManifoldAndOriented()
        corners = np.array(
            [list(one.GetVertex(k).Coordinates) for k in range(one.GetVertexCount())]
        )
        rows = [list(one.GetTriangle(k).Indices) for k in range(one.GetTriangleCount())]
        a, b, c = (corners[np.array(rows)[:, k]] for k in range(3))
        volume = float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)
        assert volume == pytest.approx(PARTS[one.GetName()].solid.volume, rel=1e-3)


def test_the_package_has_no_date() -> None:
    data = write_3mf(MESHES, "a brake")
    assert data == write_3mf(MESHES, "a brake")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert {about.date_time for about in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


@pytest.mark.parametrize("made", MESHES, ids=lambda m: m.name)
def test_an_stl_is_watertight_once_its_corners_are_merged(made) -> None:
    data = write_stl(made)
    found = trimesh.load(io.BytesIO(data), file_type="stl", process=True)
    assert found.is_watertight and found.is_winding_consistent
    assert found.volume == pytest.approx(PARTS[made.name].solid.volume, rel=1e-3)
    low, high = PARTS[made.name].solid.bounds
    assert found.bounds[0] == pytest.approx(low, abs=0.02)
    assert found.bounds[1] == pytest.approx(high, abs=0.02)
