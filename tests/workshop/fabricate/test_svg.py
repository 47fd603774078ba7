"""SVG files as a browser, Inkscape or a laser's program reads them."""

from __future__ import annotations

import io
import re

import pytest
import svgelements
from hypothesis import given, settings

from layerjam.workshop.fabricate.dxf import Frame
from layerjam.workshop.fabricate.film import write_svg
from layerjam.workshop.fabricate.jigs import make_coupon
from layerjam.workshop.fabricate.outline import Outline, bounding_box, make_sheet
from workshop.fabricate.flat import sheets

PX = 96 / 25.4
"""Pixels of an SVG's reader in a millimetre."""


def _shapes(data: bytes, layer: str = "") -> list[svgelements.Path]:
    read = svgelements.SVG.parse(io.StringIO(data.decode()), reify=True)
    return [svgelements.Path(s) for s in read.elements() if isinstance(s, svgelements.Shape)]


@settings(max_examples=15)
@given(sheets())
def test_lengths_are_in_mm(part: Outline) -> None:
    data = write_svg([part])
    total = sum(shape.length(error=1e-9) for shape in _shapes(data)) / PX
    assert total == pytest.approx(part.cut_length(), rel=1e-5)
    wide, tall = map(float, re.findall(rb'(?:width|height)="([\d.]+)mm"', data)[:2])
    box = [float(n) for n in re.findall(rb'viewBox="([^"]+)"', data)[0].split()]
    assert (wide, tall) == (box[2], box[3])
    assert (wide, tall) == pytest.approx((part.length + 2, part.width + 2), rel=1e-12)


def test_the_picture_is_upright_and_holds_all() -> None:
    part = make_sheet(85, 20, clamp_length=6, hole=3, screws=2).translate(5, 30)
    part = Outline(**{**vars(part), "holes": part.holes[:1]})
    (hole,) = re.findall(rb'<circle cx="([^"]+)" cy="([^"]+)" r="([^"]+)"', write_svg([part]))
    x, y, radius = map(float, hole)
    # y points down in an SVG: the lower hole stays the lower one
    assert (x, y, radius) == pytest.approx((8, -25, 1.5))


def test_a_frame_is_grey_and_only_lines_to_cut_are_red_or_blue() -> None:
    parts = make_coupon(3.0, 3.0)
    left, low, right, high = bounding_box(parts)
    moved = [part.translate(5 - left, 5 - low) for part in parts]
    frame = Frame(length=right - left + 10, width=high - low + 10, words="cut <first> & keep")
    text = write_svg(moved, frame).decode()
    assert "cut &lt;first&gt; &amp; keep" in text and "100 mm" in text
    groups = {m[1]: m[2] for m in re.finditer(r'<g id="([\w-]+)" stroke="(#\w+)"', text)}
    assert groups == {"info": "#808080", "cut-inside": "#0000ff", "cut": "#ff0000"}
    cut = text[text.index('id="cut-inside"') :]
    total = sum(
        s.length(error=1e-9) for s in _shapes(f"{text[: text.index('<g')]}<g {cut}".encode())
    )
    assert total / PX == pytest.approx(sum(part.cut_length() for part in parts), rel=1e-5)
