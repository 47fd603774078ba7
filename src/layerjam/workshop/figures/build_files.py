"""Pictures of a build as files: shaded ones as PNG, and all as SVG with labels."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from layerjam._version import __version__
from layerjam.brake.device.workshop import Build
from layerjam.core.drawing.page import typeset_file
from layerjam.core.drawing.style import format_svg
from layerjam.core.units import show
from layerjam.workshop.fabricate.bom import list_items
from layerjam.workshop.fabricate.drawing import Drawing
from layerjam.workshop.fabricate.dxf import BAR
from layerjam.workshop.fabricate.film import auxiliary_plates
from layerjam.workshop.fabricate.lengths import Lengths
from layerjam.workshop.fabricate.nest import Piece
from layerjam.workshop.fabricate.outline import Circle, Outline, bounding_box
from layerjam.workshop.figures import build_drawings as drawings
from layerjam.workshop.figures.assembly_steps import (
    PATTERN,
    Step,
    array_steps,
    cap_steps,
    film_steps,
    final_steps,
    list_first_checks,
    list_tools,
    sleeve_steps,
    stack_steps,
)
from layerjam.workshop.figures.build_pictures import add_labels, make_shots
from layerjam.workshop.figures.build_scene import make_scene

Block = dict[str, Any]
MARKS = {"passed": "ok", "note": "-", "warning": "LOOK", "failed": "FAIL"}


def typeset_assembly(
    drawing: Drawing,
    svgs: Mapping[str, str],
    coupons: bool = False,
    files: Collection[str] | None = None,
) -> bytes:
    """Return the PDF's bytes; `svgs` maps the names of the pictures to SVG.

    `files` are the other files of the build; None means all possible files. Raises
    MissingExtraError if typst is not installed.
    """
    data = {
        "title": f"How to build {drawing.file.name}",
        "lead": drawing.file.title or "A layer-jamming brake",
        "footer": f"layerjam {__version__}",
        "banner": [
            "We have never cut, printed or cast this design. Build one, do the checks on "
            "the last pages, and only then build more.",
            *drawing.film.notes,
        ],
        "numbers": _list_numbers(drawing),
        "parts": _list_chapters(drawing, coupons, files),
    }
    return typeset_file("assembly", data, {f"{name}.svg": svg for name, svg in svgs.items()})


def _list_numbers(drawing: Drawing) -> list[tuple[str, str]]:
    lengths = drawing.lengths
    mass = sum(row.mass for row in drawing.masses)
    return [
        (str(drawing.brakes), "brake" if drawing.brakes == 1 else "brakes"),
        (show(mass, "kg", 3), "each as drawn, without fittings"),
        (show(lengths.pin_to_pin * 1e-3, "m"), "pin to pin at rest"),
        (show(lengths.strap * 1e-3, "m"), "pin to pin, extended"),
        (show(drawing.torque, "N m", 2), "on each clamp screw"),
    ]


def _list_chapters(
    drawing: Drawing, coupons: bool, files: Collection[str] | None
) -> list[dict[str, Any]]:
    tools = {"kind": "text", "text": list_tools(drawing)}
    parts = [picture("exploded"), _make_parts_list(drawing, files), tools]
    film = [to_steps(film_steps(drawing, coupons, files)), picture("film", _width_share(drawing))]
    stack = [picture("layers", 0.86), to_steps(stack_steps(drawing)), picture("stacking", 0.62)]
    chapters: list[tuple[str, bool, list[Block]]] = [
        ("Parts", False, parts),
        ("Cut the film", True, film),
        ("Print caps and plates", True, [to_steps(cap_steps(drawing)), picture("section")]),
        ("Cast the enclosure", True, [picture("mould", 0.8), to_steps(sleeve_steps(drawing))]),
        ("Stack and clamp", True, stack),
        ("Close the brake", True, [picture("assembled", 0.86), to_steps(final_steps(drawing))]),
    ]
    if drawing.brakes > 1:
        join = [picture("boards", 0.7), to_steps(array_steps(drawing))]
        chapters.append(("Join the brakes", False, join))
    verdicts = [[MARKS[check.level], check.code, check.text] for check in drawing.checks]
    chapters += [
        ("Check the first brake", True, [to_steps(list_first_checks(drawing, coupons))]),
        ("Drawing checks", False, [{"kind": "checks", "rows": verdicts}]),
        ("Assumptions", False, [{"kind": "list", "items": drawing.assumptions()}]),
    ]
    return [
        {"title": f"{number}  {title}", "page": page, "blocks": blocks}
        for number, (title, page, blocks) in enumerate(chapters, 1)
    ]


def picture(name: str, share: float = 1.0) -> Block:
    """Return a picture that occupies a fraction of the page's width."""
    return {"kind": "picture", "name": name, "share": share}


def to_steps(instructions: Iterable[str | Step]) -> Block:
    """Return numbered steps with the commands that belong to them."""
    steps = (Step(step) if isinstance(step, str) else step for step in instructions)
    rows = [{"text": step.text, "commands": list(step.commands)} for step in steps]
    return {"kind": "steps", "steps": rows}


def _width_share(drawing: Drawing) -> float:
    """Return the fraction of the width at which the film's picture leaves space for the steps."""
    if not drawing.film.pieces:
        return 0.5
    piece = drawing.film.pieces[0]
    return min(0.8, 0.8 * piece.length / piece.width)


def _make_parts_list(drawing: Drawing, files: Collection[str] | None) -> Block:
    rows = [
        [
            row.item,
            row.what,
            f"{row.quantity} {row.unit}" if row.unit == "g" else row.quantity,
            row.file,
            row.basis,
        ]
        for row in list_items(drawing, files)
    ]
    return {
        "kind": "table",
        "head": ["part", "description", "quantity", "file", ""],
        "columns": ["auto", "1fr", "auto", "auto", "auto"],
        "right": [2],
        "rows": rows,
    }


FORMATS = {
    "A4": (210.0, 297.0),
    "A3": (297.0, 420.0),
    "A2": (420.0, 594.0),
    "A1": (594.0, 841.0),
    "A0": (841.0, 1189.0),
    "2A0": (1189.0, 1682.0),
    "4A0": (1682.0, 2378.0),
}
"""Sheets of paper [mm], smallest first; A4 is the smallest."""
BORDER, STRIP = 10.0, 24.0
"""Margin that a printer leaves white, and height of the ruler below the parts [mm]."""
ROUND = 4 / 3 * (2**0.5 - 1)
"""Length of a quarter circle's Bézier handles, in radii; the error is 0.03 % of the radius."""


class Paper(NamedTuple):
    """A paper format in portrait or landscape [mm]."""

    name: str
    width: float
    height: float


def find_paper(parts: Sequence[Outline]) -> Paper | None:
    """Return the smallest format into which the parts and the ruler fit, or None."""
    left, low, right, high = bounding_box(parts)
    wide = max(right - left, BAR) + 2 * BORDER
    tall = high - low + 2 * BORDER + STRIP
    for name, (short, long) in FORMATS.items():
        for width, height in ((short, long), (long, short)):
            if wide <= width and tall <= height:
                return Paper(name, width, height)
    return None


def typeset_pattern(pieces: Sequence[Piece], notes: Sequence[str] = ()) -> bytes | None:
    """Return the PDF's bytes, one page per piece; None if a piece is larger than any paper.

    `notes` are sentences for every page. Raises MissingExtraError if typst is not installed.
    """
    pages = []
    for piece in pieces:
        paper = find_paper(piece.parts)
        if paper is None:
            return None
        pages.append(_make_pattern_page(piece, paper, notes))
    return typeset_file("pattern", {"pages": pages})


def _make_pattern_page(piece: Piece, paper: Paper, notes: Sequence[str]) -> dict[str, Any]:
    """Return the data for the template: curves in mm from the page's upper left corner."""
    left, _, _, high = bounding_box(piece.parts)
    origin = BORDER - left, BORDER + high
    curves = []
    for part in piece.parts:
        curves += [_place_hole(hole, origin) for hole in part.holes] + [_place_edge(part, origin)]
    counts = ", ".join(f"{count} × {name}" for name, count in piece.counts)
    return {
        "width": paper.width,
        "height": paper.height,
        "curves": curves,
        "ruler": [BORDER, paper.height - BORDER - STRIP / 2, BAR],
        "title": f"{piece.name}: {counts}",
        "notes": list(notes),
    }


def _place_edge(part: Outline, origin: tuple[float, float]) -> list[list[float]]:
    path = part.path()
    curve = [[path[0].x, path[0].y]]
    for begin, stop in zip(path, [*path[1:], path[0]], strict=True):
        x, y, u, v = begin.x, begin.y, stop.x, stop.y
        if begin.bulge:
            # an anticlockwise quarter starts along x if x and y both increase or both decrease
            level = (u - x) * (v - y) > 0
            first = (x + ROUND * (u - x), y) if level else (x, y + ROUND * (v - y))
            second = (u, v - ROUND * (v - y)) if level else (u - ROUND * (u - x), v)
            curve.append([*first, *second, u, v])
        else:
            curve.append([u, v])
    return [_convert_to_page(numbers, origin) for numbers in curve]


def _place_hole(hole: Circle, origin: tuple[float, float]) -> list[list[float]]:
    x, y, r = hole.x, hole.y, hole.diameter / 2
    k = ROUND * r
    curve = [
        [x + r, y],
        [x + r, y + k, x + k, y + r, x, y + r],
        [x - k, y + r, x - r, y + k, x - r, y],
        [x - r, y - k, x - k, y - r, x, y - r],
        [x + k, y - r, x + r, y - k, x + r, y],
    ]
    return [_convert_to_page(numbers, origin) for numbers in curve]


def _convert_to_page(numbers: Sequence[float], origin: tuple[float, float]) -> list[float]:
    """Convert coordinates on the part to coordinates on the page, where y points downwards."""
    return [origin[1] - n if i % 2 else origin[0] + n for i, n in enumerate(numbers)]


class Pictures(NamedTuple):
    """Pictures of a build by name."""

    plain: dict[str, bytes]
    """PNG of the shaded pictures, without words."""
    svgs: dict[str, str]
    """SVG of every picture, with names or dimensions."""

    def files(self) -> dict[str, bytes]:
        """Return {path: bytes}."""
        pngs = {f"pictures/{name}.png": png for name, png in self.plain.items()}
        return pngs | {f"pictures/{name}.svg": svg.encode() for name, svg in self.svgs.items()}


def draw_pictures(build: Build, lengths: Lengths, pieces: Sequence[Piece]) -> Pictures:
    """Draw separated parts, stacking, mould, assembly, layers, film and section.

    Raises MissingExtraError if matplotlib or manifold3d is not installed.
    """
    world = make_scene(build, lengths)
    views = make_shots(world)
    figures = {name: add_labels(shot, labels) for name, (shot, labels) in views.items()}
    figures |= {"section": drawings.draw_section(world), "layers": drawings.draw_layer_order(world)}
    if pieces:
        figures["film"] = drawings.draw_film(pieces[0])
    return Pictures(
        {name: shot.png() for name, (shot, _) in views.items()},
        {name: format_svg(figure) for name, figure in figures.items()},
    )


def make_documents(
    drawing: Drawing, coupons: bool = False, others: Collection[str] | None = None
) -> dict[str, bytes]:
    """Return {path: bytes} of the pictures, assembly.pdf and cut/pattern.pdf of a build.

    `others` are its other files; None means all possible files. There is no pattern if a piece of
    film is larger than any paper. Raises MissingExtraError if an extra is not installed.
    """
    drawn_ones = draw_pictures(drawing.build, drawing.lengths, drawing.film.pieces)
    if drawing.brakes > 1:
        flat_parts = auxiliary_plates(
            drawing.build, drawing.lengths, drawing.parallel, drawing.series
        )
        drawn_ones.svgs["boards"] = format_svg(drawings.draw_boards(list(flat_parts.items())))
    content = drawn_ones.files()
    pattern_text = typeset_pattern(drawing.film.pieces, drawing.film.notes)
    if pattern_text is not None:
        content[PATTERN] = pattern_text
    files = None if others is None else {*others, *content}
    content["assembly.pdf"] = typeset_assembly(drawing, drawn_ones.svgs, coupons, files)
    return content
