"""DXF files as a cutting service reads them."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import combinations, pairwise

import pytest
import shapely
from hypothesis import given, settings

from layerjam.workshop.fabricate.dxf import Frame, write_dxf
from layerjam.workshop.fabricate.jigs import make_coupon
from layerjam.workshop.fabricate.outline import Outline, make_sheet
from workshop.fabricate.flat import of_bulges, opened, sheets

SHEET = make_sheet(85, 13, clamp_length=6, hole=3)


@settings(max_examples=15)
@given(sheets())
def test_a_service_finds_one_closed_outline_and_its_holes(part: Outline) -> None:
    document = opened(write_dxf([part]))
    assert document.dxfversion == "AC1015"
    assert document.header["$INSUNITS"] == 4 and document.header["$MEASUREMENT"] == 1
    (outline,) = document.modelspace().query("LWPOLYLINE")
    holes = document.modelspace().query("CIRCLE")
    assert len(document.modelspace()) == 1 + len(part.holes)
    assert outline.closed and outline.dxf.layer == "CUT"
    assert {hole.dxf.layer for hole in holes} == {"CUT_INSIDE"}
    area, length = of_bulges(outline.get_points("xyb"))
    area -= sum(3.141592653589793 * hole.dxf.radius**2 for hole in holes)
    length += sum(2 * 3.141592653589793 * hole.dxf.radius for hole in holes)
    assert area == pytest.approx(part.area(), rel=1e-12)
    assert length == pytest.approx(part.cut_length(), rel=1e-12)
    left, low, right, high = part.box()
    assert document.header["$EXTMIN"][:2] == pytest.approx((left, low), abs=1e-12)
    assert document.header["$EXTMAX"][:2] == pytest.approx((right, high), abs=1e-12)


def test_the_hole_sits_where_the_screw_goes() -> None:
    (hole,) = opened(write_dxf([SHEET])).modelspace().query("CIRCLE")
    (outline,) = opened(write_dxf([SHEET])).modelspace().query("LWPOLYLINE")
    xs, ys = zip(*outline.get_points("xy"), strict=True)
    assert hole.dxf.center.x - min(xs) == pytest.approx(3, abs=1e-9)
    assert hole.dxf.center.y - min(ys) == pytest.approx(6.5, abs=1e-9)


def test_a_frame_says_the_unit_and_is_not_cut() -> None:
    frame = Frame(length=95, width=23, words="film-1: 1 × sheet")
    document = opened(write_dxf([SHEET.translate(5, 11.5)], frame))
    info = document.modelspace().query('*[layer=="INFO"]')
    (edge,) = info.query("LWPOLYLINE")
    box = shapely.Polygon(edge.get_points("xy")).bounds
    assert box == (0, 0, 95, 23)
    bar = max(info.query("LINE"), key=lambda line: line.dxf.start.distance(line.dxf.end))
    assert bar.dxf.start.distance(bar.dxf.end) == 100
    words = {text.dxf.text for text in info.query("TEXT")}
    assert words == {"100 mm", "film-1: 1 × sheet"}
    assert len(document.modelspace().query('*[layer=="CUT"]')) == 1


def test_no_line_is_cut_twice() -> None:
    """Of every two lines, none lies on the other; the comb's end on its frame."""
    lines = []
    for part in make_coupon(3.0, 3.0):
        ring = shapely.LinearRing(part.points())
        lines += [shapely.LineString(pair) for pair in pairwise(ring.coords)]
        lines += [shapely.LineString(cut) for cut in part.cuts]
    for one, other in combinations(lines, 2):
        assert one.intersection(other).length == 0 and not one.crosses(other)


CODE = """
import hashlib, sys
from layerjam.workshop.fabricate.dxf import Frame, write_dxf
from layerjam.workshop.fabricate.outline import make_sheet
part = make_sheet(85, 13, clamp_length=6, hole=3)
data = write_dxf([part], Frame(length=95, width=23, words="a × b"))
sys.stdout.write(hashlib.sha256(data).hexdigest())
"""


def test_the_same_bytes_in_another_zone_locale_and_process() -> None:
    import hashlib

    import ezdxf

    here = write_dxf([SHEET], Frame(length=95, width=23, words="a × b"))
    before = ezdxf.options.write_fixed_meta_data_for_testing
    assert before is False
    away = {"TZ": "Asia/Kathmandu", "LC_ALL": "C", "PYTHONHASHSEED": "7"}
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **away},
        timeout=60,
    )
    assert done.stdout == hashlib.sha256(here).hexdigest()
