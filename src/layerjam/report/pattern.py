"""Pieces of film on paper at their true size, with a ruler: cut/pattern.pdf of a build."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from layerjam.fabricate.dxf import BAR
from layerjam.fabricate.nest import Piece
from layerjam.fabricate.outline import Circle, Outline, around
from layerjam.report.typeset import typeset

FORMATS = {
    "A4": (210.0, 297.0),
    "A3": (297.0, 420.0),
    "A2": (420.0, 594.0),
    "A1": (594.0, 841.0),
    "A0": (841.0, 1189.0),
    "2A0": (1189.0, 1682.0),
    "4A0": (1682.0, 2378.0),
}
"""Sheets of paper [mm], smallest first; a smaller one than A4 no office has."""
BORDER, STRIP = 10.0, 24.0
"""Paper that a printer leaves white, and the strip of the ruler below the parts [mm]."""
ROUND = 4 / 3 * (2**0.5 - 1)
"""How far the handles of a quarter of a circle reach, in radii: off by 0.03 % of the radius."""


class Paper(NamedTuple):
    """A format, upright or across [mm]."""

    name: str
    width: float
    height: float


def holds(paper: str) -> tuple[float, float]:
    """The greatest length and width of film parts on a format laid across [mm]."""
    short, long = FORMATS[paper]
    return long - 2 * BORDER, short - 2 * BORDER - STRIP


def paper_for(parts: Sequence[Outline]) -> Paper | None:
    """The smallest format that holds the parts and the ruler; None where none does."""
    left, low, right, high = around(parts)
    wide = max(right - left, BAR) + 2 * BORDER
    tall = high - low + 2 * BORDER + STRIP
    for name, (short, long) in FORMATS.items():
        for width, height in ((short, long), (long, short)):
            if wide <= width and tall <= height:
                return Paper(name, width, height)
    return None


def pattern(pieces: Sequence[Piece], notes: Sequence[str] = ()) -> bytes | None:
    """The PDF's bytes, one page a piece; None where a piece is larger than any paper.

    `notes` are sentences for every page. Raises MissingExtraError without typst.
    """
    pages = []
    for piece in pieces:
        paper = paper_for(piece.parts)
        if paper is None:
            return None
        pages.append(_page(piece, paper, notes))
    return typeset("pattern", {"pages": pages})


def _page(piece: Piece, paper: Paper, notes: Sequence[str]) -> dict[str, Any]:
    """What the template draws: curves in mm from the page's upper left corner."""
    left, _, _, high = around(piece.parts)
    at = BORDER - left, BORDER + high
    curves = []
    for part in piece.parts:
        curves += [_hole(hole, at) for hole in part.holes] + [_edge(part, at)]
    counts = ", ".join(f"{count} × {name}" for name, count in piece.counts)
    return {
        "width": paper.width,
        "height": paper.height,
        "curves": curves,
        "ruler": [BORDER, paper.height - BORDER - STRIP / 2, BAR],
        "title": f"{piece.name}: {counts}",
        "notes": list(notes),
    }


def _edge(part: Outline, at: tuple[float, float]) -> list[list[float]]:
    path = part.path()
    made = [[path[0].x, path[0].y]]
    for begin, stop in zip(path, [*path[1:], path[0]], strict=True):
        x, y, u, v = begin.x, begin.y, stop.x, stop.y
        if begin.bulge:
            # an anticlockwise quarter leaves along x where x and y grow or shrink together
            level = (u - x) * (v - y) > 0
            one = (x + ROUND * (u - x), y) if level else (x, y + ROUND * (v - y))
            two = (u, v - ROUND * (v - y)) if level else (u - ROUND * (u - x), v)
            made.append([*one, *two, u, v])
        else:
            made.append([u, v])
    return [_down(numbers, at) for numbers in made]


def _hole(hole: Circle, at: tuple[float, float]) -> list[list[float]]:
    x, y, r = hole.x, hole.y, hole.diameter / 2
    k = ROUND * r
    made = [
        [x + r, y],
        [x + r, y + k, x + k, y + r, x, y + r],
        [x - k, y + r, x - r, y + k, x - r, y],
        [x - r, y - k, x - k, y - r, x, y - r],
        [x + k, y - r, x + r, y - k, x + r, y],
    ]
    return [_down(numbers, at) for numbers in made]


def _down(numbers: Sequence[float], at: tuple[float, float]) -> list[float]:
    """Points of the part as points of the page, where y points down."""
    return [at[1] - n if i % 2 else at[0] + n for i, n in enumerate(numbers)]
