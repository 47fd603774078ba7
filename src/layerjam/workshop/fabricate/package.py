"""Meshes as 3MF and STL, written directly, with the same bytes for the same mesh."""

import io
import zipfile
from collections.abc import Sequence

import numpy as np

from layerjam.workshop.fabricate.mesh import Mesh

EPOCH = (1980, 1, 1, 0, 0, 0)
"""Date of every file in a package: the earliest one that the format allows."""
SPACING = 5.0
"""Distance between two objects on the build plate [mm]."""
MODEL = "3D/3dmodel.model"
TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    f'<Relationship Target="/{MODEL}" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)


def write_stl(mesh: Mesh) -> bytes:
    """Return a binary STL file in mm; the format has neither units nor connectivity."""
    corners = mesh.corners[mesh.triangles].astype("<f4")
    normals = np.cross(
        mesh.corners[mesh.triangles[:, 1]] - mesh.corners[mesh.triangles[:, 0]],
        mesh.corners[mesh.triangles[:, 2]] - mesh.corners[mesh.triangles[:, 0]],
    )
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.zeros(
        len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")]
    )
    rows["normal"] = normals / np.where(size > 0, size, 1)
    rows["corners"] = corners
    head = f"layerjam {mesh.name}, mm".encode("ascii").ljust(80)
    return head + np.uint32(len(rows)).tobytes() + rows.tobytes()


def write_3mf(meshes: Sequence[Mesh], title: str) -> bytes:
    """Return a 3MF package in mm: one named object for each mesh, side by side."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, text in (
            ("[Content_Types].xml", TYPES),
            ("_rels/.rels", RELATIONS),
            (MODEL, _model_xml(meshes, title)),
        ):
            entry = zipfile.ZipInfo(name, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            archive.writestr(entry, text.encode(), compresslevel=6)
    return stream.getvalue()


def _model_xml(meshes: Sequence[Mesh], title: str) -> str:
    out = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<model unit="millimeter" xml:lang="en-US" '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">',
        f'<metadata name="Title">{title}</metadata>',
        "<resources>",
    ]
    items, y = [], 0.0
    for number, mesh in enumerate(meshes, 1):
        out.append(f'<object id="{number}" type="model" name="{mesh.name}"><mesh><vertices>')
        out += [
            f'<vertex x="{_format_number(a)}" y="{_format_number(b)}" z="{_format_number(c)}"/>'
            for a, b, c in mesh.corners.tolist()
        ]
        out.append("</vertices><triangles>")
        out += [f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.triangles.tolist()]
        out.append("</triangles></mesh></object>")
        low, high = mesh.corners.min(axis=0).tolist(), mesh.corners.max(axis=0).tolist()
        place = " ".join(_format_number(v) for v in (-low[0], y - low[1], -low[2]))
        items.append(f'<item objectid="{number}" transform="1 0 0 0 1 0 0 0 1 {place}"/>')
        y += high[1] - low[1] + SPACING
    return "\n".join([*out, "</resources>", "<build>", *items, "</build>", "</model>", ""])


def _format_number(value: float) -> str:
    """Return a number rounded to the nanometre, without an exponent or a negative zero."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
