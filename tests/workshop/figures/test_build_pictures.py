"""Pictures and drawings of a build: layers where they belong, words that can be read."""

from __future__ import annotations

import re

import numpy as np
import pytest

from core.drawing.legible import faults, words_of
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.workshop.fabricate.choices import resolve_choices
from layerjam.workshop.fabricate.film import lay_out_film
from layerjam.workshop.fabricate.lengths import compute_lengths
from layerjam.workshop.figures import build_drawings, build_pictures, build_scene
from layerjam.workshop.figures.build_files import draw_pictures
from layerjam.workshop.figures.build_scene import Scene
from layerjam.workshop.figures.shading import Body

KAPTON = load("choi2018-kapton")
BRAKES = {
    "odd": KAPTON,
    "even": KAPTON.with_(count=6),
    "unlike sides": KAPTON.with_(free_left="8 mm", count=9),
    "thick and wide": KAPTON.with_(
        count=40, width="60 mm", screw_hole="4.1 mm", clamped_length="12 mm", length="91 mm"
    ),
    "two sheets": KAPTON.with_(count=2),
}


QUICK = ("two sheets",)


def world_of(file: BrakeFile) -> Scene:
    build = resolve_choices(file).build
    return build_scene.make_scene(build, compute_lengths(file.brake, build))


@pytest.mark.parametrize("name", BRAKES)
def test_every_layer_is_filled_at_both_caps(name: str) -> None:
    world = world_of(BRAKES[name])
    known = world.lengths
    last = -known.stack / 2
    for index in range(known.count):
        sheet, spacer = build_scene.make_layer(world, index)
        for body in (sheet, spacer):
            low, high = body.corners[:, 2].min(), body.corners[:, 2].max()
            assert (low, high) == pytest.approx((last, last + known.thickness), abs=1e-9)
        last += known.thickness
        ends = [(b.corners[:, 0].min(), b.corners[:, 0].max()) for b in (sheet, spacer)]
        left, right = (0, 1) if index % 2 == 0 else (1, 0)
        # the lowest layer is a left sheet; each part sits at the back of its tray
        assert ends[left][0] == pytest.approx(-known.left.clamped)
        assert ends[right][1] == pytest.approx(known.free + known.right.clamped)
        of_sheet = ends[0][1] - ends[0][0]
        assert of_sheet == pytest.approx(known.sheet_length)
        side = known.right if index % 2 == 0 else known.left
        assert ends[1][1] - ends[1][0] == pytest.approx(side.clamped)
    assert last == pytest.approx(known.stack / 2)


def test_the_parts_touch_and_do_not_hit() -> None:
    world = world_of(KAPTON)
    known = world.lengths
    for side in known.sides:
        for y, screw in enumerate(build_scene.make_screws(world, side)):
            top = known.stack / 2 + known.plate_height
            assert screw.corners[:, 2].max() <= top and y == 0
            assert screw.corners[:, 2].min() >= -known.stack / 2 - known.shelf_height
        cap, plate = build_scene.make_cap(world, side), build_scene.make_plate(world, side)
        assert np.ptp(plate.corners[:, 1]) < known.slot
        top = known.stack / 2 + known.plate_height
        assert plate.corners[:, 2].max() == pytest.approx(top)
        assert np.ptp(cap.corners[:, 0]) == pytest.approx(18 + 8.2 + 12)
    worn = build_scene.make_mounted_sleeve(world)
    flat = np.abs(worn.corners[:, 0] - known.free / 2) < 0.3 * known.free
    assert not flat.any() or np.ptp(worn.corners[flat, 1]) == pytest.approx(known.width + 2)
    a, b, c = (worn.corners[worn.triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0  # its outside faces outwards


@pytest.mark.parametrize(
    "name",
    [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in BRAKES],
)
def test_the_words_of_every_picture_can_be_read(name: str) -> None:
    file = BRAKES[name]
    world = world_of(file)
    pieces = lay_out_film(file, world.build, world.lengths).pieces
    figures = {
        "section": build_drawings.draw_section(world),
        "layers": build_drawings.draw_layer_order(world),
        "film": build_drawings.draw_film(pieces[0]),
    }
    for shown, (shot, labels) in build_pictures.make_shots(world).items():
        figures[shown] = build_pictures.add_labels(shot, labels)
        for label in labels:
            column, row = label.locate(shot)
            rows, columns, _ = shot.pixels.shape
            assert 0 <= column <= columns and 0 <= row <= rows
    for shown, figure in figures.items():
        assert faults(figure) == [], shown


@pytest.mark.parametrize("name", [*QUICK, pytest.param("odd", marks=pytest.mark.slow)])
def test_every_part_is_seen_where_its_name_points(name: str) -> None:
    shots = build_pictures.make_shots(world_of(BRAKES[name]))
    for shown, (shot, labels) in shots.items():
        for label in labels:
            if isinstance(label.target, Body):
                column, row = label.locate(shot)
                assert shot.find_middle(label.target) is not None, (shown, label.words)
                assert shot.visible_mask(label.target)[int(row), int(column)], (shown, label.words)


def test_the_section_states_the_lengths() -> None:
    world = world_of(KAPTON)
    words = {text.get_text() for text in words_of(build_drawings.draw_section(world))}
    assert {"head 12", "port 8.2", "neck 8", "back 3", "air 1", "clamp 6", "free 11"} <= words
    assert {"plate 4.603", "stack 2.794", "shelf 4.003", "head 8.2"} <= words


@pytest.mark.parametrize(("name", "top"), [("odd", "left sheet"), ("even", "right sheet")])
def test_the_layers_are_listed_from_below(name: str, top: str) -> None:
    figure = build_drawings.draw_layer_order(world_of(BRAKES[name]))
    rows: dict[float, dict[float, str]] = {}
    for text in words_of(figure):
        x, y = text.get_position()
        rows.setdefault(round(y, 2), {})[x] = text.get_text()
    listed = [rows[y] for y in sorted(rows) if 50 in rows[y] and "below" not in rows[y][50]]
    assert len(listed) == BRAKES[name].brake.sheets.count
    assert [row[50] for row in listed][::2] == ["left sheet"] * ((len(listed) + 1) // 2)
    assert listed[-1][50] == top
    for index, row in enumerate(listed):
        here, there = (12.5, 87.5) if index % 2 == 0 else (87.5, 12.5)
        assert row[here] == f"{index + 1}  sheet" and row[there] == f"{index + 1}  spacer"


def test_the_files_and_the_parts_that_are_named() -> None:
    world = world_of(KAPTON)
    pieces = lay_out_film(KAPTON, world.build, world.lengths).pieces
    made = draw_pictures(world.build, world.lengths, pieces)
    shaded = ("exploded", "stacking", "mould", "assembled")
    assert set(made.files()) == {
        *(f"pictures/{name}.png" for name in shaded),
        *(f"pictures/{name}.svg" for name in (*shaded, "section", "layers", "film")),
    }
    seen = build_pictures.make_shots(world)
    said = {label.words for _, labels in seen.values() for label in labels}
    for part in (
        "cap",
        "clamp plate",
        "screw",
        "nut",
        "spacer",
        "left sheets",
        "right sheets",
        "enclosure",
        "cable tie",
        "dowel",
        "fitting",
        "upper half",
        "lower half",
        "core",
    ):
        assert part in said
    assert any(re.match(r"\d+ bolts", words) for words in said)
