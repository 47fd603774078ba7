"""Flat parts as SVG: one user unit is one mm, hairlines, arcs as arcs."""

from collections.abc import Sequence
from xml.sax.saxutils import escape

from layerjam.fabricate.dxf import BAR, Frame
from layerjam.fabricate.outline import Outline, Vertex, around

RED, BLUE, GREY = "#ff0000", "#0000ff", "#808080"
_EDGE = 1.0
"""Margin around the parts, so that no line is clipped [mm]."""


def svg(parts: Sequence[Outline], frame: Frame | None = None, notes: Sequence[str] = ()) -> bytes:
    """Return the bytes of the file: red is cut, blue is cut first, grey (a `frame`) is not cut.

    `notes` are sentences for the reader of the file; they are not drawn.
    """
    left, low, right, high = around(parts)
    if frame is not None:
        left, low = min(left, 0), min(low, -24.0)
        right, high = max(right, frame.length, BAR), max(high, frame.width)
    wide, tall = right - left + 2 * _EDGE, high - low + 2 * _EDGE
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_n(wide)}mm" height="{_n(tall)}mm" '
        f'viewBox="{_n(left - _EDGE)} {_n(-high - _EDGE)} {_n(wide)} {_n(tall)}" '
        'fill="none" stroke-width="0.1">'
    ]
    lines += [f"<desc>{escape(note)}</desc>" for note in notes]
    if frame is not None:
        lines += _info(frame)
    lines.append(f'<g id="cut-inside" stroke="{BLUE}">')
    for part in parts:
        for hole in part.holes:
            x, y, radius = _n(hole.x), _n(-hole.y), _n(hole.diameter / 2)
            lines.append(f'<circle cx="{x}" cy="{y}" r="{radius}"/>')
        for (a, b), (c, d) in part.cuts:
            lines.append(f'<path d="M{_n(a)} {_n(-b)}L{_n(c)} {_n(-d)}"/>')
    lines += ["</g>", f'<g id="cut" stroke="{RED}">']
    lines += [f'<path d="{path_data(part.path())}"/>' for part in parts]
    lines += ["</g>", "</svg>", ""]
    return "\n".join(lines).encode()


def path_data(path: Sequence[Vertex]) -> str:
    """Return the SVG data of a closed path; its y points down."""
    words = [f"M{_n(path[0].x)} {_n(-path[0].y)}"]
    for begin, stop in zip(path, [*path[1:], path[0]], strict=True):
        end = f"{_n(stop.x)} {_n(-stop.y)}"
        radius = _n(abs(stop.x - begin.x))
        words.append(f"A{radius} {radius} 0 0 0 {end}" if begin.bulge else f"L{end}")
    return "".join(words) + "Z"


def _info(frame: Frame) -> list[str]:
    text = f'fill="{GREY}" stroke="none" font-family="sans-serif" font-size="4"'
    width, height = _n(frame.length), _n(frame.width)
    return [
        f'<g id="info" stroke="{GREY}">',
        f'<rect x="0" y="{_n(-frame.width)}" width="{width}" height="{height}"/>',
        f'<path d="M0 12L{_n(BAR)} 12M0 10L0 14M{_n(BAR)} 10L{_n(BAR)} 14"/>',
        f'<text x="2" y="10" {text}>{_n(BAR)} mm</text>',
        f'<text x="2" y="20" {text}>{escape(frame.words)}</text>',
        "</g>",
    ]


def _n(number: float) -> str:
    return f"{number:.12f}".rstrip("0").rstrip(".") if number else "0"
