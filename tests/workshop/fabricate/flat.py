"""Random flat parts for the tests of films, and readers that know nothing of our code."""

from __future__ import annotations

import io
import math
from itertools import pairwise

import ezdxf
import shapely
from ezdxf.document import Drawing
from hypothesis import strategies as st

from layerjam.workshop.fabricate.outline import Outline, make_sheet


@st.composite
def sheets(draw: st.DrawFn) -> Outline:
    """A sheet as `layerjam build` may draw one."""
    width = draw(st.floats(8, 100))
    clamped = draw(st.floats(6, 30))
    screws = draw(st.integers(1, max(1, int(width / 10))))
    return make_sheet(
        clamped + width + draw(st.floats(0, 400)),
        width,
        clamp_length=clamped,
        hole=draw(st.floats(2, min(5, width / screws - 2))),
        screws=screws,
        tip_radius=draw(st.floats(0, width / 2 - 0.01)),
        clamp_radius=draw(st.floats(0, min(width / 2 - 0.01, clamped / 2))),
    )


def opened(data: bytes) -> Drawing:
    """The document as an independent reader sees it, audited without a finding."""
    document = ezdxf.read(io.StringIO(data.decode("cp1252")))
    audit = document.audit()
    assert not audit.errors and not audit.fixes
    return document


def of_bulges(points: list[tuple[float, float, float]]) -> tuple[float, float]:
    """Area and length of a closed path of (x, y, bulge), by the segments' formulas."""
    area = length = 0.0
    for (x, y, bulge), (u, v, _) in pairwise([*points, points[0]]):
        chord = math.dist((x, y), (u, v))
        area += (x * v - u * y) / 2
        if bulge:
            angle = 4 * math.atan(bulge)
            radius = chord / 2 / math.sin(angle / 2)
            area += radius**2 / 2 * (angle - math.sin(angle))
            length += radius * angle
        else:
            length += chord
    return area, length


def polygon(part: Outline, chord: float = 1e-4) -> shapely.Polygon:
    """The part as a polygon, its holes as circles of many corners."""
    rings = []
    for hole in part.holes:
        angles = [2 * math.pi * i / 4000 for i in range(4000)]
        r = hole.diameter / 2
        rings.append([(hole.x + r * math.cos(a), hole.y + r * math.sin(a)) for a in angles])
    return shapely.Polygon(part.points(chord), rings)
