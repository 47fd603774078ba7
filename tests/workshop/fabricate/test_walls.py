"""C10 against the solid: rays through the mesh of every part that stays in the brake."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from built_parts import KAPTON, some_brakes
from counts import cases
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.workshop import Build
from layerjam.core.errors import LayerjamError
from layerjam.workshop.fabricate import checks
from layerjam.workshop.fabricate.lengths import compute_lengths
from layerjam.workshop.fabricate.mesh import make_mesh
from layerjam.workshop.fabricate.parts import make_parts
from strategies import unchecked

SKIN = 1e-5
"""Depth below a face where a ray starts [mm]."""
THICK = 2.5
"""Thickness up to which walls are looked for: that around the port is always 2 mm [mm]."""
BLOCK = 400


def places(corners: np.ndarray, normals: np.ndarray, rng: np.random.Generator, more: int):
    """Points just below the faces and the directions into the part: near every corner of every
    triangle, at its middle, and `more` at random over the area."""
    weights = np.array([[1, 1, 1], [98, 1, 1], [1, 98, 1], [1, 1, 98]]) / [[3], [100], [100], [100]]
    points = np.einsum("wc,tcx->twx", weights, corners)
    ways = np.broadcast_to(-normals[:, None], points.shape)
    edge = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(edge, axis=1)
    chosen = rng.choice(len(corners), more, p=area / area.sum())
    u, v = rng.random((2, more))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = corners[chosen].transpose(1, 0, 2)
    points = np.concatenate(
        [points.reshape(-1, 3), a + u[:, None] * (b - a) + v[:, None] * (c - a)]
    )
    ways = np.concatenate([ways.reshape(-1, 3), -normals[chosen]])
    return points + SKIN * ways, ways


def least_thickness(surface, rng: np.random.Generator, more: int = 1500) -> float:
    """Shortest way of all rays from a face to the next face where they leave the part."""
    corners = np.asarray(surface.corners)[np.asarray(surface.triangles, int)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normals, axis=1)
    corners, normals = corners[size > 1e-9], normals[size > 1e-9] / size[size > 1e-9, None]
    level = np.einsum("tx,tx->t", corners[:, 0], normals)
    points, ways = places(corners, normals, rng, more)
    least = THICK
    for start in range(0, len(points), BLOCK):
        at, way = points[start : start + BLOCK], ways[start : start + BLOCK]
        rate = way @ normals.T
        gap = level - at @ normals.T
        # faces whose plane is left outwards, nearer than the thinnest place so far
        ray, face = np.nonzero((rate > 1e-6) & (gap > 0) & (gap < least * rate))
        way_there = gap[ray, face] / rate[ray, face]
        hit = at[ray] + way_there[:, None] * way[ray]
        inside = np.ones(len(ray), bool)
        for k in range(3):
            edge = corners[face, (k + 1) % 3] - corners[face, k]
            turn = np.cross(edge, hit - corners[face, k])
            inside &= np.einsum("nx,nx->n", turn, normals[face]) >= 0
        least = min(least, way_there[inside].min(initial=THICK))
    return float(least) + SKIN


def measured(brake: Brake, build: Build, rng: np.random.Generator) -> float:
    """Least wall of caps and plates; rounded edges are drawn as the corners they round."""
    sharp = unchecked(build, edge=0.0)
    found = compute_lengths(brake, sharp)
    return min(
        least_thickness(make_mesh(part.solid), rng)
        for part in make_parts(found, sharp)
        if part.printed and part.stays
    )


def compare(brake: Brake, build: Build, rng: np.random.Generator) -> str | None:
    """Compare C10 with the mesh; the name of the wall, None for a brake that is not drawn."""
    try:
        found = compute_lengths(brake, build)
        checks.check_drawability(brake, build, found)
    except LayerjamError:
        return None
    check = checks.wall_check(build, found)
    if not check.ok or not all(c.ok for c in checks.clamping_checks(build, found)):
        return None
    # facets lie up to 0.01 mm within bores and necks
    assert measured(brake, build, rng) == pytest.approx(check.value * 1e3, abs=0.025), check.text
    return check.text.split("(")[1].split(")")[0]


def some_builds(seed: int, count: int) -> list[Build]:
    """Choices around the defaults, so that each wall is the least one now and then."""
    rng = np.random.default_rng(seed)
    return [
        replace(
            Build(),
            wall=0.4e-3,
            floor=rng.uniform(0.6e-3, 3e-3),
            cheek=rng.uniform(1.2e-3, 4e-3),
            back=rng.uniform(0.6e-3, 4e-3),
            plenum=rng.uniform(0.2e-3, 2e-3),
            neck_length=rng.uniform(4.5e-3, 12e-3),
            tie_depth=rng.choice([0.0, 0.6e-3, 1.2e-3]),
            pin_wall=rng.uniform(1.1e-3, 5e-3),
            air_bore=rng.uniform(1e-3, 3e-3),
        )
        for _ in range(count)
    ]


def test_the_papers_brake_has_its_least_wall_before_the_screw_hole() -> None:
    found = compute_lengths(KAPTON.brake, Build())
    check = checks.wall_check(Build(), found)
    # c/2 less half the hole of an M3: 3 - 1.7
    assert check.value == pytest.approx(1.30e-3) and "screw hole" in check.text
    assert compare(KAPTON.brake, Build(), np.random.default_rng(1)) is not None


def test_the_rims_beside_a_short_necks_tie_are_found() -> None:
    short = replace(Build(), neck_length=4e-3)
    check = checks.wall_check(short, compute_lengths(KAPTON.brake, short))
    assert check.ok is False and check.is_refused and check.value == pytest.approx(0.25e-3)
    thin = unchecked(short, wall=0.2e-3)
    assert measured(KAPTON.brake, thin, np.random.default_rng(2)) == pytest.approx(0.25, abs=0.01)


@pytest.mark.slow
def test_four_random_brakes() -> None:
    rng = np.random.default_rng(3)
    known = zip(some_brakes(31, 4), some_builds(32, 4), strict=True)
    assert any([compare(brake, build, rng) for brake, build in known])


@pytest.mark.slow
def test_many_random_brakes_and_choices() -> None:
    rng = np.random.default_rng(4)
    count = cases(170, 20)
    known = zip(some_brakes(41, count), some_builds(42, count), strict=True)
    found = [name for brake, build in known if (name := compare(brake, build, rng))]
    assert len(found) >= 0.58 * count
    assert len(set(found)) >= 6  # no single wall is the least of all of them
