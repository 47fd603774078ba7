"""The pictures of a build as files: shaded ones as PNG, all of them with their words as SVG."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

from layerjam._version import __version__
from layerjam.device.workshop import Build
from layerjam.fabricate.bom import items
from layerjam.fabricate.drawing import Drawing
from layerjam.fabricate.dxf import BAR
from layerjam.fabricate.film import plates
from layerjam.fabricate.lengths import Lengths
from layerjam.fabricate.nest import Piece
from layerjam.fabricate.outline import Circle, Outline, around
from layerjam.report import assembly_steps as steps
from layerjam.report import build_drawings as drawings
from layerjam.report.assembly_steps import PATTERN
from layerjam.report.build_pictures import labelled, shots
from layerjam.report.build_scene import scene
from layerjam.report.style import drawn
from layerjam.report.typeset import typeset
from layerjam.units import show

Block = dict[str, Any]
MARKS = {"passed": "ok", "note": "-", "warning": "LOOK", "failed": "FAIL"}


def assembly(
    made: Drawing,
    named: Mapping[str, str],
    coupons: bool = False,
    there: Collection[str] | None = None,
) -> bytes:
    """The PDF's bytes; `named` holds the pictures as SVG by name.

    `there` are the files beside it, all that there can be without it. Raises MissingExtraError
    without typst.
    """
    data = {
        "title": f"How to build {made.file.name}",
        "lead": made.file.title or "A layer-jamming brake",
        "footer": f"layerjam {__version__}",
        "banner": [
            "This design was never cut, printed or cast by us. Build one, do the checks on the "
            "last pages, and only then build more.",
            *made.film.notes,
        ],
        "numbers": _numbers(made),
        "parts": _parts(made, coupons, there),
    }
    return typeset("assembly", data, {f"{name}.svg": svg for name, svg in named.items()})


def _numbers(made: Drawing) -> list[tuple[str, str]]:
    found = made.lengths
    mass = sum(row.mass for row in made.masses)
    return [
        (str(made.brakes), "brake" if made.brakes == 1 else "brakes"),
        (show(mass, "kg", 3), "each as drawn, without fittings"),
        (show(found.pin_to_pin * 1e-3, "m"), "pin to pin at rest"),
        (show(found.strap * 1e-3, "m"), "pin to pin, pulled out"),
        (show(made.torque, "N m", 2), "on each clamp screw"),
    ]


def _parts(made: Drawing, coupons: bool, there: Collection[str] | None) -> list[dict[str, Any]]:
    chapters: list[tuple[str, bool, list[Block]]] = [
        (
            "1  Parts",
            False,
            [picture("exploded"), _list(made, there), {"kind": "text", "text": steps.tools(made)}],
        ),
        (
            "2  Cut the film",
            True,
            [numbered(steps.film(made, coupons, there)), picture("film", _share(made))],
        ),
        ("3  Print caps and plates", True, [numbered(steps.caps(made)), picture("section")]),
        ("4  Cast the enclosure", True, [picture("mould", 0.8), numbered(steps.sleeve(made))]),
        (
            "5  Stack and clamp",
            True,
            [picture("layers", 0.86), numbered(steps.stack(made)), picture("stacking", 0.62)],
        ),
        ("6  Close it", True, [picture("assembled", 0.86), numbered(steps.close(made))]),
    ]
    if made.brakes > 1:
        chapters.append(
            ("7  Join the brakes", False, [picture("boards", 0.7), numbered(steps.array(made))])
        )
    number = len(chapters) + 1
    chapters += [
        (f"{number}  Check the first one", True, [numbered(steps.first(made, coupons))]),
        (f"{number + 1}  What the drawing was checked for", False, [_checks(made)]),
        (f"{number + 2}  What is assumed", False, [{"kind": "list", "items": made.assumptions()}]),
    ]
    return [{"title": t, "page": page, "blocks": blocks} for t, page, blocks in chapters]


def picture(name: str, share: float = 1.0) -> Block:
    """A picture at a share of the page's width."""
    return {"kind": "picture", "name": name, "share": share}


def numbered(found: Sequence[steps.Step]) -> Block:
    """Numbered steps with the commands that belong to them."""
    rows = [{"text": step.text, "commands": list(step.commands)} for step in found]
    return {"kind": "steps", "steps": rows}


def _share(made: Drawing) -> float:
    """Share of the width at which the film's picture leaves room for the steps."""
    if not made.film.pieces:
        return 0.5
    piece = made.film.pieces[0]
    return min(0.8, 0.8 * piece.length / piece.width)


def _list(made: Drawing, there: Collection[str] | None) -> Block:
    rows = [
        [
            row.item,
            row.what,
            f"{row.quantity} {row.unit}" if row.unit == "g" else row.quantity,
            row.file,
            row.basis,
        ]
        for row in items(made, there)
    ]
    return {
        "kind": "table",
        "head": ["part", "what", "how many", "file", ""],
        "columns": ["auto", "1fr", "auto", "auto", "auto"],
        "right": [2],
        "rows": rows,
    }


def _checks(made: Drawing) -> Block:
    rows = [[MARKS[check.level], check.code, check.text] for check in made.checks]
    return {"kind": "checks", "rows": rows}


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


class Pictures(NamedTuple):
    """Pictures by name."""

    plain: dict[str, bytes]
    """PNG of what is shaded, without words."""
    named: dict[str, str]
    """SVG of every picture, with names or dimensions."""

    def files(self) -> dict[str, bytes]:
        """{path: bytes}."""
        made = {f"pictures/{name}.png": png for name, png in self.plain.items()}
        return made | {f"pictures/{name}.svg": svg.encode() for name, svg in self.named.items()}


def pictures(build: Build, lengths: Lengths, pieces: Sequence[Piece]) -> Pictures:
    """Exploded, stacking, mould, assembled; layers, film, and the section with dimensions.

    Raises MissingExtraError without matplotlib or manifold3d.
    """
    world = scene(build, lengths)
    seen = shots(world)
    figures = {name: labelled(shot, labels) for name, (shot, labels) in seen.items()}
    figures |= {"section": drawings.section(world), "layers": drawings.order(world)}
    if pieces:
        figures["film"] = drawings.film(pieces[0])
    return Pictures(
        {name: shot.png() for name, (shot, _) in seen.items()},
        {name: drawn(figure) for name, figure in figures.items()},
    )


def papers(
    made: Drawing, coupons: bool = False, others: Collection[str] | None = None
) -> dict[str, bytes]:
    """{path: bytes} of the pictures, assembly.pdf and cut/pattern.pdf of a build.

    `others` are its other files, all that there can be without it. No pattern where a piece of film
    is larger than any paper. Raises MissingExtraError without matplotlib, manifold3d or typst.
    """
    drawn_ones = pictures(made.build, made.lengths, made.film.pieces)
    if made.brakes > 1:
        flat_parts = plates(made.build, made.lengths, made.parallel, made.series)
        drawn_ones.named["boards"] = drawn(drawings.plates(list(flat_parts.items())))
    content = drawn_ones.files()
    flat = pattern(made.film.pieces, made.film.notes)
    if flat is not None:
        content[PATTERN] = flat
    there = None if others is None else {*others, *content}
    content["assembly.pdf"] = assembly(made, drawn_ones.named, coupons, there)
    return content
