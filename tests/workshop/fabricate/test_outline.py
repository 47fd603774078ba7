"""Area, length of cut and kerf of flat parts against polygons and an independent offset."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations, pairwise

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.workshop.fabricate.jigs import RIM, make_coupon, make_jig, make_link, make_yoke
from layerjam.workshop.fabricate.outline import (
    Circle,
    Outline,
    bounding_box,
    make_sheet,
    make_spacer,
)
from workshop.fabricate.flat import of_bulges, polygon, sheets


def test_the_paper_s_sheet_has_the_specification_s_numbers() -> None:
    part = make_sheet(85, 13, clamp_length=6, hole=3)
    assert part.area() == pytest.approx(1097.39491, abs=5e-6)
    assert part.cut_length() == pytest.approx(204.13717, abs=5e-6)
    # 0.0255 g each of 0.254 mm film of 1420 kg/m³, as the specification's table has it
    assert make_spacer(6, 13, hole=3).area() * 0.254 * 1.42e-3 == pytest.approx(0.0255, abs=5e-5)


@given(sheets())
def test_area_and_length_are_those_of_the_drawn_path(part: Outline) -> None:
    area, length = of_bulges([tuple(v) for v in part.path()])
    holes = [h.diameter for h in part.holes]
    assert part.area() == pytest.approx(area - sum(math.pi * d**2 / 4 for d in holes), rel=1e-12)
    assert part.cut_length() == pytest.approx(length + sum(math.pi * d for d in holes), rel=1e-12)


@settings(max_examples=12)
@given(sheets())
def test_the_polygon_lies_within_its_chord_and_is_valid(part: Outline) -> None:
    drawn = polygon(part)
    assert drawn.is_valid and drawn.exterior.is_ccw
    assert drawn.area == pytest.approx(part.area(), rel=1e-5)
    coarse = shapely.Polygon(part.points(0.5)).exterior
    assert coarse.hausdorff_distance(shapely.Polygon(part.points(1e-3)).exterior) < 0.501


@pytest.mark.slow
@given(sheets())
def test_the_rim_is_the_least_material_beside_a_hole(part: Outline) -> None:
    shape = polygon(part, 1e-3)
    middles = [shapely.Point(h.x, h.y) for h in part.holes]
    least = [shape.exterior.distance(middle) - part.holes[0].diameter / 2 for middle in middles]
    least += [a.distance(b) - part.holes[0].diameter for a, b in pairwise(middles)]
    assert part.least_gap() == pytest.approx(min(least), abs=2e-3)


@given(st.lists(st.tuples(st.floats(8, 77), st.floats(-4, 4)), min_size=2, max_size=4))
def test_the_least_gap_is_that_of_the_nearest_holes_or_edge(middles: list[tuple[float, float]]):
    """Far from the round corners; holes in any order."""
    part = replace(make_sheet(85, 13, clamp_length=6, hole=3), holes=())
    x, low, right, high = part.box()
    holes = [Circle(x + a, (low + high) / 2 + b, 1.0 + i / 4) for i, (a, b) in enumerate(middles)]
    gaps = [
        math.dist(a[:2], b[:2]) - (a.diameter + b.diameter) / 2 for a, b in combinations(holes, 2)
    ]
    for hole in holes:
        sides = hole.x - x, right - hole.x, hole.y - low, high - hole.y
        gaps.append(min(sides) - hole.diameter / 2)
    assert replace(part, holes=holes).least_gap() == pytest.approx(min(gaps), abs=1e-9)


@settings(max_examples=12)
@given(sheets(), st.floats(0.01, 0.9))
def test_the_kerf_is_an_exact_offset(part: Outline, kerf: float) -> None:
    # an independent offset of the polygon, whose round corners have many corners
    exact = shapely.Polygon(part.points(1e-4))
    offset = exact.buffer(kerf / 2, quad_segs=100)
    grown = shapely.Polygon(part.add_kerf(kerf).points(1e-4))
    assert grown.hausdorff_distance(offset) < 4e-4
    assert [h.diameter for h in part.add_kerf(kerf).holes] == pytest.approx(
        [h.diameter - kerf for h in part.holes], rel=1e-14
    )
    middles = [(h.x, h.y) for h in part.holes]
    assert [(h.x, h.y) for h in part.add_kerf(kerf).holes] == middles
    # what a burn of half the kerf on either side leaves is the part itself
    left = grown.buffer(-kerf / 2, quad_segs=100)
    assert left.hausdorff_distance(exact) < 4e-4


def test_no_kerf_changes_nothing() -> None:
    part = make_sheet(85, 13, clamp_length=6, hole=3)
    assert part.add_kerf(0.0) is part


def test_holes_stand_in_a_row_across_the_clamp() -> None:
    part = make_sheet(85, 40, clamp_length=8, hole=3, screws=4)
    assert [(h.x, h.y) for h in part.holes] == [(4, -15), (4, -5), (4, 5), (4, 15)]


def test_where_two_arcs_meet_no_line_has_no_length() -> None:
    part = make_spacer(6, 13, hole=2, clamp_radius=3)
    path = part.path()
    assert len(path) == 6 and sum(v.bulge > 0 for v in path) == 4
    area, length = of_bulges([tuple(v) for v in path])
    assert area - math.pi == pytest.approx(part.area(), rel=1e-13)
    assert length + 2 * math.pi == pytest.approx(part.cut_length(), rel=1e-13)


def test_a_part_moves_as_a_whole() -> None:
    comb = make_coupon(3.0, 3.0)[1]
    moved = comb.translate(5, -2)
    assert moved.box() == pytest.approx(
        [a + b for a, b in zip(comb.box(), (5, -2) * 2, strict=True)]
    )
    assert moved.cuts[0].start == pytest.approx(
        (comb.cuts[0].start[0] + 5, comb.cuts[0].start[1] - 2)
    )
    assert (moved.area(), moved.cut_length()) == (comb.area(), comb.cut_length())


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_a_yoke_s_eye_hangs_in_the_middle_and_meets_no_pin(count: int) -> None:
    part = make_yoke(count, 21.8, 6.1)
    *pins, eye = part.holes
    assert part.length == pytest.approx((count - 1) * 21.8 + 20)
    assert sum(h.x for h in pins) / count == pytest.approx(eye.x)
    assert all(math.dist(h[:2], eye[:2]) > 12 for h in pins)
    assert [b.x - a.x for a, b in pairwise(pins)] == pytest.approx([21.8] * (count - 1))
    _inside(part)


def test_link_and_jig_hold_the_pins_where_they_belong() -> None:
    joint = make_link(12.0, 3.0, 6.1)
    assert joint.holes[1].x - joint.holes[0].x == 15
    board = make_jig(154.4, 6.1)
    assert board.holes[1].x - board.holes[0].x == pytest.approx(154.4)
    _inside(joint)
    _inside(board)


def _inside(part: Outline) -> None:
    """Every hole keeps its rim of material."""
    edge = shapely.Polygon(part.points(1e-4)).exterior
    for hole in part.holes:
        assert edge.distance(shapely.Point(hole.x, hole.y)) >= RIM - 1e-3


def test_the_comb_leaves_eleven_kerfs() -> None:
    comb, kerf = make_coupon(3.0, 3.0)[1], 0.2
    lines = shapely.union_all(
        [shapely.Polygon(comb.points()).exterior, *(shapely.LineString(c) for c in comb.cuts)]
    )
    window = shapely.Polygon(comb.points()).buffer(kerf / 2, join_style="mitre")
    slats = shapely.Polygon(comb.points()).difference(lines.buffer(kerf / 2)).geoms
    widths = [slat.bounds[2] - slat.bounds[0] for slat in slats]
    assert len(widths) == 10
    slack = window.bounds[2] - window.bounds[0] - sum(widths)
    assert slack == pytest.approx(11 * kerf, rel=1e-9)


def test_no_coupon_touches_another() -> None:
    parts = make_coupon(3.0, 3.0)
    shapes = [shapely.Polygon(part.points()) for part in parts]
    for i, one in enumerate(shapes):
        assert all(one.distance(other) > 2.9 for other in shapes[i + 1 :])
    assert bounding_box(parts)[2] <= 170
