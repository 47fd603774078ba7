"""Eleven errors planted in the generator: whoever reads only the files must find each of them.

The reader carries the specification's formulas itself; it takes nothing from the program but files
and the numbers that it prints.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import math
import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import ezdxf
import numpy as np
import pytest
import trimesh

from built_parts import KAPTON
from layerjam.brake.device.brake import enclosure_mass
from layerjam.workshop.commands.build import _drawing_quantities
from layerjam.workshop.fabricate import bom, drawing, film, folder, masses, outline, package, parts
from layerjam.workshop.fabricate.choices import resolve_choices

KERF = 0.2
N, W, T, L, C, HOLE, FREE = 11, 13.0, 0.254, 85.0, 6.0, 3.0, 90.0
FORCE = 250.79964
Content = dict[str, Any]


def made() -> tuple[Content, dict[str, Any]]:
    chosen = resolve_choices(KAPTON, None, {"kerf": KERF * 1e-3, "cutter": "laser"})
    found = drawing.draw_build(KAPTON, chosen, FORCE)
    return folder.make_files(found, with_step=False, coupons=False), _drawing_quantities(found)


def cap_volume() -> float:
    """Section 2.3 of the specification in numbers, the crossing of the bores by a plain sum."""
    thick = N * T
    floor = 1.2 + (8 - thick - 2.4 - 2.4) / 2
    plate, shelf = 3 + 0.2 + floor, 2.4 + 0.2 + floor
    high, wide, slot, tray = plate + thick + shelf, 16.8, 13.6, 7.0
    neck = 1.25 * 2 * (W + thick) / (2 * math.pi)
    rounded = 4 - math.pi
    z = np.linspace(-2.1, 2.1, 200_001)
    u, v = np.sqrt(np.maximum(1 - z**2, 0)), np.sqrt(np.maximum(2.1**2 - z**2, 0))
    length = 8.2 / 2 + 8 + 3
    bores = np.trapezoid(2 * u * length + v * 12 - u * np.minimum(v, length), z)
    return float(
        (wide * high - rounded) * (tray + 3)
        - slot * (thick + plate) * tray
        + math.pi * (neck**2 * 4.5 + (neck - 0.6) ** 2 * 3.5)
        + (12 * 8.2 - rounded) * 20.2
        - 5.7 * 2.6 * (3 + 5.7 / math.sqrt(3))
        - math.pi * 3.4**2 * floor / 4
        - math.pi * 6.1**2 * 8.2 / 4
        - bores
    )


def plate_volume() -> float:
    floor = 1.2 + (8 - N * T - 2.4 - 2.4) / 2
    high = 3 + 0.2 + floor
    return (13.2 * high - 5.7 * 3.2) * 6.8 - math.pi * 3.4**2 * floor / 4


def area_of(points: list[tuple[float, float, float]]) -> float:
    """Area of a closed path of lines and arcs, from corners and bulges."""
    total = 0.0
    for (x, y, bulge), (a, b, _) in zip(points, [*points[1:], points[0]], strict=True):
        total += (x * b - a * y) / 2
        chord = math.dist((x, y), (a, b))
        if bulge:
            angle = 4 * math.atan(bulge)
            radius = chord / (2 * math.sin(angle / 2))
            total += radius**2 / 2 * (angle - math.sin(angle))
    return total


def film_faults(content: Content) -> set[str]:
    found = set()
    sheet = ezdxf.read(io.StringIO(content["cut/sheet.dxf"].decode()))
    if sheet.header["$INSUNITS"] != 4:
        found.add("units")
    space = sheet.modelspace()
    (hole,) = space.query("CIRCLE")
    near = min(hole.dxf.center.x, L - hole.dxf.center.x)
    if abs(near - C / 2) > 1e-9:
        found.add("hole")
    (path,) = space.query("LWPOLYLINE")
    corners = [(x, y, b) for x, y, b in path.get_points("xyb")]
    area = L * W - (2 - math.pi / 2) * (1 + 0.25)
    if abs(area_of(corners) / area - 1) > 1e-9:
        found.add("area")
    closed, bores = [], 0
    for name, data in content.items():
        if re.fullmatch(r"cut/film-\d+\.dxf", name):
            page = ezdxf.read(io.StringIO(data.decode())).modelspace()
            closed += [p for p in page.query("LWPOLYLINE") if p.dxf.layer == "CUT"]
            bores += len(page.query("CIRCLE[layer=='CUT_INSIDE']"))
    if len(closed) != 2 * N or bores != 2 * N:
        found.add("counts")
    spans = [[x for x, _ in p.get_points("xy")] for p in closed]
    grown = sorted({round(max(span) - min(span), 6) for span in spans})
    if grown != [round(C + KERF, 6), round(L + KERF, 6)]:
        found.add("kerf")
    return found


def print_faults(content: Content) -> set[str]:
    found = set()
    known = {"cap": cap_volume(), "plate": plate_volume()}
    for name, volume in known.items():
        read = trimesh.load(io.BytesIO(content[f"print/{name}.stl"]), file_type="stl")
        if not read.is_watertight or abs(read.volume / volume - 1) > 1e-3:
            found.add(name)
    with zipfile.ZipFile(io.BytesIO(content["print/print.3mf"])) as archive:
        text = archive.read("3D/3dmodel.model").decode()
    body = text.split('name="cap"')[1].split("</mesh>")[0]
    places = re.findall(r'x="([^"]+)" y="([^"]+)" z="([^"]+)"', body)
    size = np.ptp(np.array(places, dtype=float), axis=0)
    if abs(size[0] - 38.2) > 0.02:
        found.add("package")
    return found


def list_faults(content: Content, facts: dict[str, Any]) -> set[str]:
    found = set()
    rows = {row["item"]: row["quantity"] for row in csv.DictReader(io.StringIO(content["bom.csv"]))}
    wanted = {"sheet": N, "spacer": N, "cap": 2, "plate": 2, "screw": 2, "nut": 2, "cable tie": 2}
    if any(rows[item] != str(count) for item, count in wanted.items()):
        found.add("parts list")
    mass = {row["name"]: row["count"] * row["each"] for row in facts["mass_parts"]}
    film = 1420 * T * 1e-9
    spacer = C * W - (4 - math.pi) * 0.25 - math.pi * HOLE**2 / 4
    if abs(mass["spacer"] / (N * spacer * film) - 1) > 1e-9:
        found.add("spacer mass")
    tube = next(value for name, value in mass.items() if "cap to cap" in name)
    if abs(tube / enclosure_mass(KAPTON.brake) - 1) > 1e-12:
        found.add("tube mass")
    if abs(facts["mass"] / sum(mass.values()) - 1) > 1e-12:
        found.add("sum")
    if abs(facts["sleeve_length"] - (FREE + 36) * 1e-3) > 1e-12:
        found.add("tube length")
    return found


def faults(content: Content, facts: dict[str, Any]) -> set[str]:
    return film_faults(content) | print_faults(content) | list_faults(content, facts)


def without(function: Callable[..., Any], unwanted: Callable[[Any], bool]) -> Callable[..., Any]:
    """A part without some of its prisms."""

    def wrapped(*given: Any) -> Any:
        whole = function(*given)
        kept = tuple(p for p in whole.prisms if not unwanted(p))
        return dataclasses.replace(whole, prisms=kept)

    return wrapped


def plant(patch: pytest.MonkeyPatch, name: str) -> None:
    if name == "3MF in inches":
        number = package._format_number
        patch.setattr(package, "_format_number", lambda value: number(value / 25.4))
    elif name == "tube without a neck":
        lengths = drawing.compute_lengths
        short = lambda *a: replace(lengths(*a), sleeve=lengths(*a).sleeve - 16)  # noqa: E731
        patch.setattr(drawing, "compute_lengths", short)
    elif name == "hole 1 mm off":
        holes = outline.clamp_holes
        moved = lambda *a: [h._replace(x=h.x + 1) for h in holes(*a)]  # noqa: E731
        patch.setattr(outline, "clamp_holes", moved)
    elif name == "a spacer missing in the mass":
        listed = masses.film_parts
        patch.setattr(masses, "film_parts", lambda *a: fewer(listed(*a)))
    elif name == "a spacer missing in the film":
        listed = film.film_parts
        patch.setattr(film, "film_parts", lambda *a: fewer(listed(*a)))
    elif name == "half the kerf":
        grown = outline.Outline.add_kerf
        patch.setattr(outline.Outline, "add_kerf", lambda self, kerf: grown(self, kerf / 2))
    elif name == "DXF in metres":
        written = film.write_dxf
        metres = lambda *a, **k: re.sub(  # noqa: E731
            rb"(\$INSUNITS\s+70\s+)4", rb"\g<1>6", written(*a, **k)
        )
        patch.setattr(film, "write_dxf", metres)
    elif name == "no air bore":
        round_one = lambda p: p.cut and p.axis == "x" and hasattr(p.section, "first")  # noqa: E731
        patch.setattr(parts, "make_cap", without(parts.make_cap, round_one))
    elif name == "no screw hole in the plate":
        patch.setattr(parts, "make_plate", without(parts.make_plate, lambda p: p.axis == "z"))
    elif name == "inside out":
        meshed = folder.make_mesh
        turned = lambda s: replace(meshed(s), triangles=meshed(s).triangles[:, ::-1])  # noqa: E731
        patch.setattr(folder, "make_mesh", turned)
    elif name == "screws of one cap":
        bought = bom._bought_items
        half = lambda m: [  # noqa: E731
            replace(row, quantity="1") if row.item == "screw" else row for row in bought(m)
        ]
        patch.setattr(bom, "_bought_items", half)


def fewer(wanted: list[Any]) -> list[Any]:
    """The film's parts with one spacer less."""
    return [one if one.name != "spacer" else _less(one) for one in wanted]


def _less(one: Any) -> Any:
    count = one.count - 1
    return one._replace(count=count) if hasattr(one, "_replace") else replace(one, count=count)


FAULTS = {
    "3MF in inches": "package",
    "tube without a neck": "tube length",
    "hole 1 mm off": "hole",
    "a spacer missing in the mass": "spacer mass",
    "a spacer missing in the film": "counts",
    "half the kerf": "kerf",
    "DXF in metres": "units",
    "no air bore": "cap",
    "no screw hole in the plate": "plate",
    "inside out": "cap",
    "screws of one cap": "parts list",
}


def test_a_right_folder_has_no_fault() -> None:
    assert faults(*made()) == set()


@pytest.mark.parametrize("name", sorted(FAULTS))
def test_a_planted_fault_is_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plant(monkeypatch, name)
    assert FAULTS[name] in faults(*made())
