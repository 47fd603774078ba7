"""cut/pattern.pdf is at its true size: judged by another reader of PDFs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pypdfium2
import pypdfium2.raw as pdfium
import pytest

from layerjam.workshop.fabricate.nest import CutPart, Piece, nest_tightly
from layerjam.workshop.fabricate.outline import Outline, make_sheet, make_spacer
from layerjam.workshop.figures import build_files as drawn
from layerjam.workshop.figures.build_files import FORMATS, find_paper, typeset_pattern

MM = 25.4 / 72
LINE = 0.1


@contextmanager
def _pages(data: bytes) -> Iterator[list[pypdfium2.PdfPage]]:
    document = pypdfium2.PdfDocument(data)
    pages = list(document)
    yield pages
    for page in pages:
        page.close()
    document.close()


def _pieces(count: int, kerf: float, length: float = 85, width: float = 13) -> list[Piece]:
    parts = [
        CutPart("sheet", make_sheet(length, width, clamp_length=6, hole=3).add_kerf(kerf), count),
        CutPart("spacer", make_spacer(6, width, hole=3).add_kerf(kerf), count),
    ]
    return nest_tightly(parts, margin=5, gap=3, bounds=(1169, 777))


def _boxes(page: pypdfium2.PdfPage) -> list[list[float]]:
    found = page.get_objects(filter=[pdfium.FPDF_PAGEOBJ_PATH])
    return [[edge * MM for edge in each.get_bounds()] for each in found]


@pytest.mark.parametrize(
    ("count", "kerf", "length", "width"),
    [(11, 0.0, 85, 13), (11, 0.2, 85, 13), (2, 0.1, 400, 100), (60, 0.0, 150, 80)],
)
def test_true_to_two_micrometres(count: int, kerf: float, length: float, width: float) -> None:
    data = typeset_pattern(_pieces(count, kerf, length, width))
    assert data is not None
    sheets = holes = spacers = rulers = 0
    with _pages(data) as pages:
        for page in pages:
            size = sorted(edge * MM for edge in page.get_size())
            assert any(size == pytest.approx(paper, abs=0.01) for paper in FORMATS.values())
            wide, tall = (edge * MM for edge in page.get_size())
            for left, low, right, high in _boxes(page):
                assert left > 5 and low > 5 and right < wide - 5 and high < tall - 5
                # this reader counts the line's width on either side
                size_of = right - left - 2 * LINE, high - low - 2 * LINE
                sheets += size_of == pytest.approx((length + kerf, width + kerf), abs=2e-3)
                spacers += size_of == pytest.approx((6 + kerf, width + kerf), abs=2e-3)
                holes += size_of == pytest.approx((3 - kerf, 3 - kerf), abs=2e-3)
                rulers += size_of[0] == pytest.approx(100, abs=2e-3) and size_of[1] < 5
            words = page.get_textpage()
            assert "100 mm long" in words.get_text_bounded()
            words.close()
        assert rulers == len(pages)
    assert (sheets, spacers, holes) == (count, count, 2 * count)


def test_a_cropped_pattern_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Paper of a standard format on which the parts do not lie: what an image fitted by crops."""
    monkeypatch.setattr(drawn, "find_paper", lambda parts: drawn.Paper("A4", 210.0, 297.0))
    with pytest.raises(AssertionError):
        test_true_to_two_micrometres(2, 0.1, 400, 100)


def test_holes_lie_in_their_parts() -> None:
    data = typeset_pattern(_pieces(5, 0.0))
    assert data is not None
    with _pages(data) as (page,):
        boxes = _boxes(page)
    small = [b for b in boxes if b[2] - b[0] < 3.5]
    large = [b for b in boxes if b[3] - b[1] > 12]
    for hole in small:
        inside = [b for b in large if b[0] < hole[0] and hole[2] < b[2] and b[1] < hole[1] < b[3]]
        (part,) = inside
        assert (hole[0] + hole[2]) / 2 - part[0] == pytest.approx(3 + LINE, abs=2e-3)
        assert (hole[1] + hole[3]) / 2 == pytest.approx((part[1] + part[3]) / 2, abs=2e-3)


def test_corners_are_round_and_the_page_is_as_light_as_drawn() -> None:
    """Black on the rendered page lies on the outline and nowhere else: radius 6 corners."""
    part = Outline(length=60, width=40, start=6, end=6)
    piece = Piece(
        name="film-1", length=70, width=50, parts=[part.translate(5, 25)], counts=[("p", 1)]
    )
    data = typeset_pattern([piece])
    assert data is not None
    with _pages(data) as (page,):
        image = page.render(scale=10 * MM, grayscale=True).to_numpy()
    dark = [(x / 10 + 0.05, y / 10 + 0.05) for y, x in zip(*(image < 200).nonzero(), strict=True)]
    corner = [(x, y) for x, y in dark if 9 <= x < 16 and 9 <= y < 16]
    assert len(corner) > 60
    for x, y in corner:
        assert ((16 - x) ** 2 + (16 - y) ** 2) ** 0.5 == pytest.approx(6, abs=0.15)


def test_the_same_bytes_and_the_notes() -> None:
    pieces = _pieces(11, 0.0)
    data = typeset_pattern(pieces, ["Never cut this film with a laser."])
    assert data == typeset_pattern(pieces, ["Never cut this film with a laser."])
    assert data is not None
    with _pages(data) as (page,):
        words = page.get_textpage()
        text = words.get_text_bounded()
        words.close()
    assert "Never cut this film" in text and "11 × sheet, 11 × spacer" in text


def test_larger_than_any_paper_is_no_pattern() -> None:
    part = Outline(length=3000, width=20)
    piece = Piece(name="film-1", length=3010, width=30, parts=[part], counts=[("p", 1)])
    assert typeset_pattern([piece]) is None
    assert find_paper([Outline(length=2000, width=20)]) == ("4A0", 2378, 1682)
    assert find_paper([Outline(length=180, width=20)]) == ("A4", 210, 297)
