"""Flat parts as DXF: mm in the header, closed outlines with arcs, reproducible bytes."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from layerjam.core.errors import MissingExtraError
from layerjam.workshop.fabricate.outline import Outline, bounding_box

if TYPE_CHECKING:
    from ezdxf.layouts import Modelspace

CUT, INSIDE, INFO = "CUT", "CUT_INSIDE", "INFO"
LAYERS = {CUT: 1, INSIDE: 5, INFO: 8}
"""{layer: colour}; red is cut, blue is cut first, grey is not cut."""
BAR = 100.0
"""Length of the scale bar [mm]."""
_LETTERS = 4.0


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Content of the INFO layer for a piece of film: its edge [mm] and a line of text."""

    length: float
    width: float
    words: str


def write_dxf(
    parts: Sequence[Outline], frame: Frame | None = None, notes: Sequence[str] = ()
) -> bytes:
    """Return the bytes of a DXF file; if `frame` is None, it contains only lines to cut.

    `notes` are comments for people, which machines ignore. The format is R2000, the oldest version
    with a unit and with arcs in an outline. Raises MissingExtraError if ezdxf is not installed.
    """
    with MissingExtraError.raise_if_missing("film patterns as DXF (ezdxf)", "build"):
        import ezdxf
    with _fix_metadata():
        document = ezdxf.new("R2000", units=4)
        document.header["$MEASUREMENT"] = 1
        for name, colour in LAYERS.items():
            if frame is not None or name != INFO:
                document.layers.add(name, color=colour, lineweight=0)
        space = document.modelspace()
        for part in parts:
            _draw_part(space, part)
        if frame is not None:
            _draw_info(space, frame, notes)
        left, low, right, high = bounding_box(parts)
        space.reset_extents((left, low, 0), (right, high, 0))
        stream = io.StringIO()
        document.write(stream)
    comments = "".join(f"999\n{note}\n" for note in notes)
    return (comments + stream.getvalue()).encode(document.output_encoding, errors="dxfreplace")


@contextmanager
def _fix_metadata() -> Iterator[None]:
    """Prevent ezdxf from writing the time and a random identifier into a file."""
    import ezdxf

    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def _draw_polygon(space: "Modelspace", points: Sequence[tuple[float, ...]], layer: str) -> None:
    options: dict[str, Any] = {"close": True, "dxfattribs": {"layer": layer}}
    space.add_lwpolyline(points, format="xyb", **options)


def _draw_part(space: "Modelspace", part: Outline) -> None:
    for hole in part.holes:
        space.add_circle((hole.x, hole.y), hole.diameter / 2, dxfattribs={"layer": INSIDE})
    for cut in part.cuts:
        space.add_line(cut.start, cut.end, dxfattribs={"layer": INSIDE})
    _draw_polygon(space, part.path(), CUT)


def _draw_info(space: "Modelspace", frame: Frame, notes: Sequence[str]) -> None:
    """Draw the film's edge, and below it the scale bar and the text, away from all cuts."""
    layer = {"layer": INFO}
    corners = [(0, 0, 0), (frame.length, 0, 0), (frame.length, frame.width, 0), (0, frame.width, 0)]
    _draw_polygon(space, corners, INFO)
    low = -3 * _LETTERS
    space.add_line((0, low), (BAR, low), dxfattribs=layer)
    for x in (0, BAR):
        space.add_line((x, low - 2), (x, low + 2), dxfattribs=layer)
    text_positions = [
        (words, low - 2 * _LETTERS * i) for i, words in enumerate((frame.words, *notes), 1)
    ]
    for words, y in ((f"{BAR:g} mm", low + 2), *text_positions):
        text = space.add_text(words, height=_LETTERS, dxfattribs=layer)
        text.set_placement((2, y))
