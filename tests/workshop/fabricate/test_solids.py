"""Every part stands once as prisms; closed form, mesh and STEP must agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from built_parts import KAPTON, lengths_of, parts_of, read_step
from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate.mesh import make_mesh
from layerjam.workshop.fabricate.mould import make_casting
from layerjam.workshop.fabricate.solid import Box, Ellipse, Solid, add, cut
from layerjam.workshop.fabricate.step import write_step

THROUGH = {"cap": 3, "plate": 1, "mould-bottom": 8, "mould-top": 11, "core": 0, "sleeve": 1}
"""Holes that go through: pin, air and screw; bolts; sprue and vents."""


def test_volumes_of_the_specification() -> None:
    printed = {
        "cap": 3613.35961, "plate": 276.39516, "mould-bottom": 38074.80927,
        "mould-top": 37748.55487, "core": 5666.232, "sleeve": 4484.088,
    }  # fmt: skip
    found = parts_of()
    assert set(found) == set(printed)
    for name, volume in printed.items():
        assert found[name].solid.volume == pytest.approx(volume, abs=5.1e-6), name
    assert make_casting(lengths_of()).volume == pytest.approx(4839.968, abs=1e-6)


def sampled(part: Solid, count: int, seed: int) -> tuple[float, float]:
    """Volume and its standard error from points thrown at the prisms: no formula, no library."""
    rng = np.random.default_rng(seed)
    low, high = np.array(part.bounds)
    at = dict(zip("xyz", (low + (high - low) * rng.random((count, 3))).T, strict=True))
    inside = np.zeros(count, dtype=bool)
    for prism in sorted(part.prisms, key=lambda p: p.cut):
        u, v = (at[axis] for axis in {"x": "yz", "y": "zx", "z": "xy"}[prism.axis])
        section = prism.section
        if isinstance(section, Ellipse):
            (a, b) = section.centre
            within = ((u - a) / section.first) ** 2 + ((v - b) / section.second) ** 2 <= 1
        else:
            (a, b), (c, d), r = section.low, section.high, section.radius
            du = np.maximum(np.maximum(a + r - u, u - c + r), 0)
            dv = np.maximum(np.maximum(b + r - v, v - d + r), 0)
            within = (u >= a) & (u <= c) & (v >= b) & (v <= d) & (du**2 + dv**2 <= r**2)
        within &= (at[prism.axis] >= prism.start) & (at[prism.axis] <= prism.end)
        inside = inside & ~within if prism.cut else inside | within
    box, share = float(np.prod(high - low)), float(inside.mean())
    return box * share, box * (share * (1 - share) / count) ** 0.5


@pytest.mark.parametrize("name", ["cap", "plate", "mould-bottom", "mould-top"])
def test_the_closed_form_counts_what_the_prisms_fill(name: str) -> None:
    part = parts_of()[name].solid
    volume, error = sampled(part, 200_000, 1)
    assert abs(volume - part.volume) < 4 * error


def test_the_crossing_of_two_bores_is_taken_once() -> None:
    part = parts_of()["cap"].solid
    rng = np.random.default_rng(2)
    axis = -18 - 8.2 / 2
    y, z = 1.1 * rng.random(400_000), 2.2 * rng.random(400_000) - 1.1
    x = axis + rng.random(400_000) * 2.2
    both = (y**2 + z**2 <= 1) & ((x - axis) ** 2 + z**2 <= 2.1**2)
    box = 2.2 * 1.1 * 2.2
    assert part.shared_volume == pytest.approx(box * both.mean(), rel=0.01)


@pytest.mark.parametrize("name", sorted(THROUGH))
def test_the_mesh_is_closed_and_has_its_holes(name: str) -> None:
    part = parts_of()[name].solid
    made = make_mesh(part)
    assert made.hole_count == THROUGH[name]
    assert made.volume == pytest.approx(part.volume, rel=1e-3)
    low, high = part.bounds
    assert made.corners.min(0) == pytest.approx(low, abs=1e-9)
    assert made.corners.max(0) == pytest.approx(high, abs=1e-9)
    edges = np.sort(
        np.concatenate(
            [made.triangles[:, [0, 1]], made.triangles[:, [1, 2]], made.triangles[:, [2, 0]]]
        )
    )
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert (counts == 2).all()
    again = make_mesh(part)
    assert np.array_equal(made.corners, again.corners)
    assert np.array_equal(made.triangles, again.triangles)


def test_two_cuts_in_one_plane_leave_no_skin() -> None:
    third = 1 / 3
    block = add("x", 0.0, 1.0, Box((0.1, 0.1), (0.1 + third, 0.7)))
    pocket = cut("x", 0.0, 1.0, Box((0.2, 0.1 + third), (0.3, 0.7)))
    hole = cut("z", 0.1, 0.1 + third, Ellipse.circle((0.5, 0.25), 0.02))
    assert make_mesh(Solid("thin", (block, pocket, hole))).hole_count == 1


@pytest.mark.parametrize(
    "name",
    [n if n in ("plate", "sleeve") else pytest.param(n, marks=pytest.mark.slow) for n in THROUGH],
)
def test_the_step_file_read_back(name: str, tmp_path, capfd) -> None:
    part = parts_of()[name].solid
    data = write_step(part, "1")
    assert data == write_step(part, "1")
    path = tmp_path / f"{name}.step"
    path.write_bytes(data)
    printed = capfd.readouterr()
    assert printed.out == ""
    found = read_step(path)
    assert found.valid and found.solids == 1
    assert found.volume == pytest.approx(part.volume, rel=1e-6)
    assert found.low == pytest.approx(part.bounds[0], abs=1e-5)
    assert found.high == pytest.approx(part.bounds[1], abs=1e-5)
    text = data.decode()
    assert f"PRODUCT('{name}','{name}'" in text and ".MILLI." in text
    assert "10303 214" in text


def test_a_flat_neck_and_several_screws() -> None:
    brake = KAPTON.brake.with_(width="60 mm", free_left="9 mm", screw_hole="3.2 mm")
    build = replace(Build(), port=4e-3, tie_tension=75.0)  # a hand's pull would not seal it
    lengths = lengths_of(brake, build)
    assert lengths.screws == 3 and lengths.neck_a == pytest.approx(3 * lengths.neck_b)
    found = parts_of(brake, build)
    assert {"cap-left", "cap-right", "plate-left", "plate-right"} < set(found)
    for name in ("cap-left", "cap-right"):
        made = make_mesh(found[name].solid)
        assert made.hole_count == 5
        assert made.volume == pytest.approx(found[name].solid.volume, rel=1e-3)
