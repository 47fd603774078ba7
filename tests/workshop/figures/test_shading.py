"""The depth buffer against rays, and a picture's file against another reader."""

from __future__ import annotations

import io
import subprocess
from pathlib import Path

import numpy as np
import pytest

from layerjam.brake.kernel import compiler
from layerjam.brake.kernel.compiler import SHADING, find_on_path
from layerjam.workshop.figures import picture_loops
from layerjam.workshop.figures.picture_loops import average_pixels, fill_triangles
from layerjam.workshop.figures.shading import Body, View, render_bodies

COLOURS = ("#ff0000", "#00ff00", "#0000ff", "#ffff00", "#00ffff", "#ff00ff")
FACES = (
    (0, 2, 1),
    (1, 2, 3),
    (4, 5, 6),
    (5, 7, 6),
    (0, 1, 4),
    (1, 5, 4),
    (2, 6, 3),
    (3, 6, 7),
    (0, 4, 2),
    (2, 4, 6),
    (1, 3, 5),
    (3, 7, 5),
)


def boxes(seed: int) -> list[Body]:
    """Random boxes, some of them through one another."""
    rng = np.random.default_rng(seed)
    made = []
    for colour in COLOURS:
        low = rng.uniform(0, 30, 3)
        high = low + rng.uniform(2, 15, 3)
        corners = np.array([[(low, high)[k >> i & 1][i] for i in range(3)] for k in range(8)])
        made.append(Body(corners, np.array(FACES), colour))
    return made


def seen_first(bodies: list[Body], start: np.ndarray, way: np.ndarray) -> int:
    """Number of the body that a ray meets first, by slabs; -1 for none."""
    best, found = np.inf, -1
    for number, body in enumerate(bodies):
        low, high = body.corners.min(axis=0), body.corners.max(axis=0)
        ends = np.sort(np.stack([(low - start) / way, (high - start) / way]), axis=0)
        into, out = ends[0].max(), ends[1].min()
        if into < out and into < best:
            best, found = into, number
    return found


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_body_is_seen(seed: int) -> None:
    bodies = boxes(seed)
    shot = render_bodies(bodies, View(-62 + 40 * seed, 26 + 10 * seed), width=160)
    right, up, toward = shot.axes
    rng = np.random.default_rng(seed)
    tried = 0
    for _ in range(400):
        row, column = rng.integers(0, shot.pixels.shape[0]), rng.integers(0, shot.pixels.shape[1])
        rgb = shot.pixels[row, column].astype(int)
        if rgb.min() > 0 and rgb.max() < 255:
            continue  # an edge runs through this pixel
        away = 1e3
        middle = (column + 0.5) / shot.scale + shot.corner[0]
        high = (shot.pixels.shape[0] - row - 0.5) / shot.scale + shot.corner[1]
        start = middle * right + high * up + away * toward
        number = seen_first(bodies, start, -toward)
        if number < 0:
            assert (rgb == 255).all()
        else:
            lit = rgb > 60
            assert lit.any()
            assert "".join("ff" if on else "00" for on in lit) == COLOURS[number][1:]
        tried += 1
    assert tried > 250


def test_a_point_lands_where_it_is_drawn() -> None:
    """A small box's middle is the middle of its pixels, in a picture with a large one behind."""
    small = boxes(1)[0]
    corners = (small.corners - small.corners.mean(axis=0)) * 0.1 + (5.0, -30.0, 12.0)
    bodies = [Body(corners, small.triangles, "#ff0000"), boxes(2)[1]]
    shot = render_bodies(bodies, width=600)
    reds = (shot.pixels[:, :, 0] > 90) & (shot.pixels[:, :, 1] < 60) & (shot.pixels[:, :, 2] < 60)
    rows, columns = np.nonzero(reds)
    column, row = shot.project((5.0, -30.0, 12.0))
    assert columns.mean() + 0.5 == pytest.approx(column, abs=1.5)
    assert rows.mean() + 0.5 == pytest.approx(row, abs=1.5)


def test_half_a_turn_keeps_the_outside_outside() -> None:
    body = boxes(3)[0].turn(40.0)
    a, b, c = (body.corners[body.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    sides = np.ptp(body.corners, axis=0)
    assert volume == pytest.approx(np.prod(sides))


def test_the_file_holds_the_pixels() -> None:
    import matplotlib.image

    shot = render_bodies(boxes(5), width=120)
    read = matplotlib.image.imread(io.BytesIO(shot.png()), format="png")
    assert (np.rint(read[:, :, :3] * 255).astype(np.uint8) == shot.pixels).all()
    assert shot.png() == render_bodies(boxes(5), width=120).png()


def test_edges_between_bodies_are_dark_and_flat_faces_are_not() -> None:
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 10) for x in (0, 10)], dtype=float)
    one = Body(corners, np.array(FACES), "#808080")
    shot = render_bodies([one, one.shift(x=10.0)], View(-90, 89.9), width=300)
    row = shot.pixels[shot.pixels.shape[0] // 2, :, 0]
    middle = len(row) // 2
    assert row[middle - 2 : middle + 2].min() < 90  # the joint of two bodies in one plane
    assert np.ptp(row[20 : middle - 5].astype(int)) <= 1  # the diagonal of a face does not show


@pytest.fixture
def in_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures as on a machine without a compiled library."""
    monkeypatch.setattr(picture_loops, "_load_library", lambda: None)


def drawn(seed: int) -> bytes:
    """The samples and pixels of random triangles, many of them partly outside the picture."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-20, 80, (90, 3)).round(rng.integers(0, 3))
    triangles = rng.integers(0, 90, (60, 3))
    depth = np.full((64, 50), -np.inf, dtype=np.float32)
    face = np.full(depth.shape, -1, dtype=np.int32)
    fill_triangles(points, triangles[:40], 0, depth, face)
    fill_triangles(points, triangles[40:], 40, depth, face)
    normals = rng.normal(size=(60, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    owner = rng.integers(0, 3, 60).astype(np.int32)
    pixels = np.empty((32, 25, 3), dtype=np.uint8)
    average_pixels(depth, face, normals, owner, rng.uniform(0, 255, (60, 3)), 0.8, pixels)
    assert (face >= 0).any()
    return depth.tobytes() + face.tobytes() + pixels.tobytes()


@pytest.mark.parametrize("seed", range(8))
def test_numpy_draws_the_pixels_of_c(seed: int, request: pytest.FixtureRequest) -> None:
    view = View(-62 + 17 * seed, 5 + 3 * seed)
    one = drawn(seed), render_bodies(boxes(seed), view, width=150).png()
    request.getfixturevalue("in_numpy")
    assert one == (drawn(seed), render_bodies(boxes(seed), view, width=150).png())


@pytest.mark.skipif(find_on_path() is None, reason="there is no C compiler here")
def test_the_loops_compile_without_a_warning(tmp_path: Path) -> None:
    command = [*(find_on_path() or ()), *compiler.FLAGS, "-Wall", "-Wextra", "-Werror", "-pedantic"]
    subprocess.run([*command, "-c", str(SHADING[0]), "-o", str(tmp_path / "a.o")], check=True)
