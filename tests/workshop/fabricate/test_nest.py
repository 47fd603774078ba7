"""Film parts in rows: all there, apart, inside, never turned."""

from __future__ import annotations

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.workshop.fabricate.nest import CutPart, Piece, find_excess, nest_parts, nest_tightly
from layerjam.workshop.fabricate.outline import Outline, make_sheet, make_spacer


@st.composite
def wanted(draw: st.DrawFn) -> list[CutPart]:
    width, count = draw(st.floats(8, 100)), draw(st.integers(2, 60))
    kerf = draw(st.sampled_from((0.0, 0.2)))
    lengths = [draw(st.floats(30, 300)), draw(st.floats(30, 300))]
    clamps = [draw(st.floats(6, 20)), draw(st.floats(6, 20))]
    parts = []
    for side, (long, clamped) in enumerate(zip(lengths, clamps, strict=True)):
        shape = make_sheet(long, width, clamp_length=clamped, hole=2.5, tip_radius=1)
        parts.append(CutPart(f"sheet-{side}", shape.add_kerf(kerf), (count + 1 - side) // 2))
        filler = make_spacer(clamped, width, hole=2.5)
        parts.append(CutPart(f"spacer-{side}", filler.add_kerf(kerf), (count + side) // 2))
    return parts


def _judge(pieces: list[Piece], parts: list[CutPart], margin: float, gap: float) -> None:
    for part in parts:
        laid = sum(dict(piece.counts).get(part.name, 0) for piece in pieces)
        assert laid == part.count
    sizes = sorted((p.outline.length, p.outline.width) for p in parts for _ in range(p.count))
    laid = sorted((o.length, o.width) for piece in pieces for o in piece.parts)
    assert laid == sizes  # never turned, none lost
    for piece in pieces:
        boxes = [shapely.box(*part.box()) for part in piece.parts]
        film = shapely.box(0, 0, piece.length, piece.width).buffer(-margin + 1e-6, join_style=2)
        assert all(film.covers(box) for box in boxes)
        tree = shapely.STRtree(boxes)
        near = tree.query(boxes, predicate="dwithin", distance=gap - 1e-6)
        assert near.shape[1] == len(boxes)  # each is near itself only


@given(wanted(), st.floats(1, 10), st.floats(1, 8))
def test_on_a_given_stock(parts: list[CutPart], margin: float, gap: float) -> None:
    pieces = nest_parts(parts, stock=(610, 400), margin=margin, gap=gap)
    _judge(pieces, parts, margin, gap)
    assert {(piece.length, piece.width) for piece in pieces} == {(610, 400)}
    names = [piece.name for piece in pieces]
    assert names == [f"film-{i + 1}" for i in range(len(pieces))]


@settings(max_examples=25)
@given(wanted(), st.floats(1, 10), st.floats(1, 8))
def test_on_the_least_rectangle(parts: list[CutPart], margin: float, gap: float) -> None:
    pieces = nest_tightly(parts, margin=margin, gap=gap, bounds=(1169, 797))
    _judge(pieces, parts, margin, gap)
    for piece in pieces:
        assert piece.length <= 1169 + 1e-6 and piece.width <= 797 + 1e-6
        right, high = piece.used()
        assert (piece.length, piece.width) == pytest.approx((right + margin, high + margin))
    if len(pieces) == 1:
        (whole,) = pieces
        # no single column of parts is a smaller piece of film
        column = nest_parts(
            parts,
            stock=(max(p.outline.length for p in parts) + 2 * margin, 1e5),
            margin=margin,
            gap=gap,
        )[0]
        tall = column.used()[1] + margin
        assert whole.length * whole.width <= column.length * tall + 1e-6 or tall > 797


def test_the_paper_s_brake_fits_a_sheet_of_office_paper() -> None:
    parts = [
        CutPart("sheet", make_sheet(85, 13, clamp_length=6, hole=3), 11),
        CutPart("spacer", make_spacer(6, 13, hole=3), 11),
    ]
    (piece,) = nest_tightly(parts, margin=5, gap=3, bounds=(1169, 797))
    assert piece.length < 210 and piece.width < 297
    assert dict(piece.counts) == {"sheet": 11, "spacer": 11}
    lined = sum(p.outline.area() * p.count for p in parts) / (piece.length * piece.width)
    assert lined > 0.6


def test_a_part_that_no_stock_holds_is_named() -> None:
    part = CutPart("sheet", make_sheet(85, 13, clamp_length=6, hole=3), 2)
    assert find_excess([part], (95, 23), 5) is None
    assert find_excess([part], (90, 23), 5) == ("sheet", "length", 5)
    assert find_excess([part], (95, 20), 5) == ("sheet", "width", 3)
    with pytest.raises(ValueError, match="larger than the stock"):
        nest_parts([part], stock=(90, 23), margin=5, gap=3)
    # without a stock it gets what it needs
    (long,) = nest_tightly([part], margin=5, gap=3, bounds=(50, 50))
    assert (long.length, long.width) == pytest.approx((95, 39))


def test_many_sheets_take_a_moment() -> None:
    part: Outline = make_sheet(300, 100, clamp_length=10, hole=3)
    pieces = nest_parts([CutPart("sheet", part, 3000)], stock=(640, 450), margin=5, gap=3)
    assert len(pieces) == 375
