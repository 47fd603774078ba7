"""Film for a build: parts, pieces of stock, files and checks."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.workshop import Build
from layerjam.core.units import show
from layerjam.workshop.fabricate import cutting, jigs
from layerjam.workshop.fabricate.dxf import BAR, Frame, write_dxf
from layerjam.workshop.fabricate.lengths import Lengths, Side, mm
from layerjam.workshop.fabricate.nest import (
    SLACK,
    CutPart,
    Piece,
    find_excess,
    nest_parts,
    nest_tightly,
)
from layerjam.workshop.fabricate.outline import (
    Outline,
    Vertex,
    bounding_box,
    make_sheet,
    make_spacer,
)
from layerjam.workshop.fabricate.verdicts import ROUNDING, Check, finding

LARGEST = (1169.0, 777.0)
"""Length and width of the pieces if no stock is given: A0 with space for a ruler [mm]."""
LEAST_HOLE, HOLE_BY_THICKNESS, LEAST_RIM = 1.0, 1.5, 1.0
"""A cutting service's limits: smallest hole [mm], also in sheet thicknesses; smallest rim [mm]."""


@dataclass(frozen=True, kw_only=True)
class Film:
    """Film for a build; numbers are in SI, outlines in mm."""

    parts: Sequence[CutPart]
    """Sheets and spacers at their nominal size; identical ones share a name."""
    pieces: Sequence[Piece]
    """The same parts laid out on pieces of stock, kerf included."""
    checks: Sequence[Check]
    notes: Sequence[str]
    """Sentences that are written to every file."""
    used: float
    """Fraction of the stock that is used for parts."""

    @property
    def area(self) -> float:
        """Total area of the parts [m²]."""
        return 1e-6 * sum(part.outline.area() * part.count for part in self.parts)

    @property
    def cut_length(self) -> float:
        """Total length of the cuts, at nominal size [m]."""
        return 1e-3 * sum(part.outline.cut_length() * part.count for part in self.parts)

    def files(self) -> dict[str, bytes]:
        """Return {path: bytes} of single parts for a service and whole pieces for your own cutter.

        Raises MissingExtraError if ezdxf is not installed.
        """
        content = {}
        for part in self.parts:
            content[f"cut/{part.name}.dxf"] = write_dxf([part.outline], notes=self.notes)
            content[f"cut/{part.name}.svg"] = write_svg([part.outline], notes=self.notes)
        for piece in self.pieces:
            counts = ", ".join(f"{count} {name}" for name, count in piece.counts)
            size = f"{piece.length:.4g} x {piece.width:.4g} mm"
            words = f"{piece.name}: {size}, {counts}; film runs along x"
            frame = Frame(length=piece.length, width=piece.width, words=words)
            content[f"cut/{piece.name}.dxf"] = write_dxf(piece.parts, frame, self.notes)
            content[f"cut/{piece.name}.svg"] = write_svg(piece.parts, frame, self.notes)
        return content


def lay_out_film(file: BrakeFile, build: Build, lengths: Lengths, copies: int = 1) -> Film:
    """Return the film for `copies` brakes, with the checks C1, C2 (laser bed), C3 and C15.

    If a part is larger than the stock, there are no pieces and C1 fails. Raises QuantityError for a
    laser if the film has no laser data.
    """
    parts = film_parts(build, lengths, copies)
    kerf = mm(build.kerf)
    cut = [CutPart(part.name, part.outline.add_kerf(kerf), part.count) for part in parts]
    stock = _stock_size(build)
    bed = _orient_bed(cut, build.laser_bed) if build.laser_bed else None
    margin, gap = mm(build.margin), mm(build.gap)
    bed_size = stock or bed
    excess = find_excess(cut, bed_size, margin) if bed_size else None
    pieces: list[Piece] = []
    if excess is None and stock:
        pieces = nest_parts(cut, stock=stock, margin=margin, gap=gap)
    elif excess is None:
        pieces = nest_tightly(cut, margin=margin, gap=gap, bounds=bed or LARGEST)
    checks = [_stock_check(pieces, excess, stock), _bed_check(pieces, excess, bed, stock)]
    checks += [*hole_checks(parts, lengths), cutting.laser_check(file, build.cutter)]
    area = sum(piece.length * piece.width for piece in pieces)
    part_area = sum(part.outline.area() * part.count for part in parts)
    return Film(
        parts=parts,
        pieces=pieces,
        checks=checks,
        notes=cutting.cutter_notes(file, build.cutter),
        used=part_area / area if area else 0.0,
    )


def film_parts(build: Build, lengths: Lengths, copies: int = 1) -> list[CutPart]:
    """Return the nominal sheets and spacers of `copies` brakes, by side if the sides differ."""
    cut_parts = []
    for kind in ("sheet", "spacer"):
        counts = {side.name: getattr(side, f"{kind}s") for side in lengths.sides}
        if lengths.has_same_caps:
            outline = _make_part(kind, build, lengths, lengths.left)
            cut_parts.append(CutPart(kind, outline, copies * sum(counts.values())))
            continue
        for side in lengths.sides:
            outline = _make_part(kind, build, lengths, side)
            cut_parts.append(CutPart(f"{kind}-{side.name}", outline, copies * counts[side.name]))
    return cut_parts


def _make_part(kind: str, build: Build, lengths: Lengths, side: Side) -> Outline:
    options: dict[str, Any] = {"hole": lengths.hole, "screws": lengths.screws}
    options["clamp_radius"] = mm(build.clamp_radius)
    if kind == "spacer":
        return make_spacer(side.clamped, lengths.width, **options)
    options |= {"clamp_length": side.clamped, "tip_radius": mm(build.tip_radius)}
    return make_sheet(lengths.sheet_length, lengths.width, **options)


def _stock_size(build: Build) -> tuple[float, float] | None:
    if build.stock_length is None or build.stock_width is None:
        return None
    return mm(build.stock_length), mm(build.stock_width)


def _orient_bed(parts: Sequence[CutPart], bed: Sequence[float]) -> tuple[float, float]:
    """Return the laser bed's length and width [mm], swapped if the parts only fit that way."""
    short, long = sorted(map(mm, bed))
    widest = max(part.outline.width for part in parts)
    longest = max(part.outline.length for part in parts)
    return (short, long) if widest > short and longest <= short else (long, short)


def stock_margin(parts: Sequence[CutPart], build: Build) -> Any:
    """Return the ratio of the space on stock and laser bed to the largest part; 1 is sufficient."""
    around, stock_fit = mm(build.kerf) + 2 * mm(build.margin), math.inf
    sizes = [(p.outline.length + around, p.outline.width + around) for p in parts]
    rooms = [room for room in (_stock_size(build),) if room]
    if build.laser_bed:
        bed = sorted(map(mm, build.laser_bed), reverse=True)
        rooms = rooms or [(bed[0], bed[1]), (bed[1], bed[0])]
        if (stock := _stock_size(build)) is not None:
            stock_fit = min(b / s for b, s in zip(bed, sorted(stock, reverse=True), strict=True))
    if not rooms:
        return math.inf
    part_fits = [
        np.min(np.broadcast_arrays(*(room[k] / size[k] for size in sizes for k in (0, 1))), axis=0)
        for room in rooms
    ]
    return np.minimum(np.max(part_fits, axis=0), stock_fit) * (1 + ROUNDING)


Excess = tuple[str, str, float]
"""Name of a part that is too large, the axis, and the excess [mm]."""


def _stock_check(
    pieces: Sequence[Piece], excess: Excess | None, stock: tuple[float, float] | None
) -> Check:
    if excess is not None and stock is not None:
        part, axis, length = excess
        return _size_check("C1", "stock", f"{part} with its margins", axis, length, "--stock")
    if excess is not None:
        return finding("C1", "stock", "no part fits on the laser bed")
    sizes = [f"{show(p.length * 1e-3, 'm')} × {show(p.width * 1e-3, 'm')}" for p in pieces]
    count = "1 piece" if len(pieces) == 1 else f"{len(pieces)} pieces"
    text = f"all film parts fit on {count} of {' and '.join(dict.fromkeys(sizes))}"
    return finding("C1", "stock", text, passes=True)


def _bed_check(
    pieces: Sequence[Piece],
    excess: Excess | None,
    bed: tuple[float, float] | None,
    stock: tuple[float, float] | None,
) -> Check:
    """Return C2 (laser bed): whether each piece fits on the bed, on which it may be turned."""
    if bed is None:
        return finding("C2", "laser-bed", "not checked: the laser bed is not given")
    if excess is not None and stock is None:
        part, axis, amount = excess
        part = f"{part} with its margins"
        return _size_check("C2", "laser-bed", part, axis, amount, "--laser-bed")
    for piece in pieces:
        for axis, side, room in zip(
            ("shorter side", "longer side"),
            sorted((piece.length, piece.width)),
            sorted(bed),
            strict=True,
        ):
            if side > room + SLACK:
                part = f"the film {piece.name}"
                return _size_check("C2", "laser-bed", part, axis, side - room, "--stock")
    return finding("C2", "laser-bed", "every piece fits on the laser bed", passes=True)


def _size_check(code: str, key: str, part: str, axis: str, excess: float, option: str) -> Check:
    bed = {"stock": "stock", "laser-bed": "laser bed"}[key]
    text = f"{part} exceeds the {bed} by {show(excess * 1e-3, 'm')} along its {axis}; "
    text += f"a different {option} or a smaller brake is needed"
    limits = {"value": excess * 1e-3, "limit": 0.0, "unit": "m", "otherwise": "refused"}
    return finding(code, key, text, **limits)


def hole_checks(parts: Sequence[CutPart], lengths: Lengths) -> Iterator[Check]:
    """Yield C3: limits of a cutting service."""
    rim = np.min([part.outline.least_gap() for part in parts], axis=0)
    min_diameter = np.maximum(LEAST_HOLE, HOLE_BY_THICKNESS * lengths.thickness)
    pairs = (("hole-size", lengths.hole, min_diameter), ("holes", rim, LEAST_RIM))
    for key, value, limit in pairs:
        yield Check(
            code="C3",
            key=key,
            words=partial(_describe_hole, key, value, limit),
            value=value * 1e-3,
            limit=limit * 1e-3,
            at_most=False,
            unit="m",
            otherwise="refused",
        )


def _describe_hole(key: str, value: float, limit: float, ok: bool | None) -> str:
    size, min_size = show(max(value, 0.0) * 1e-3, "m"), show(limit * 1e-3, "m")
    if key == "hole-size":
        text, remedy = f"screw holes of {size}", "a larger mount.screw_hole or thinner film"
    else:
        text = f"{size} of film around the screw holes"
        remedy = "a smaller mount.screw_hole, fewer screws or a longer clamp"
    return f"{text}; cutting needs at least {min_size}" + ("" if ok else f": {remedy} is needed")


def auxiliary_files(
    build: Build, lengths: Lengths, parallel: int, series: int, coupons: bool
) -> dict[str, bytes]:
    """Return {path: bytes} of auxiliary parts (jig, yoke, link, coupons), all at nominal size."""
    plates = auxiliary_plates(build, lengths, parallel, series)
    content = {f"cut/{name}.dxf": write_dxf([part]) for name, part in plates.items()}
    if coupons:
        content["cut/coupon.dxf"] = write_dxf(jigs.make_coupon(lengths.hole, mm(build.gap)))
    return content


def auxiliary_plates(
    build: Build, lengths: Lengths, parallel: int, series: int
) -> dict[str, Outline]:
    """Return {name: outline [mm]} of the jig, and of yoke and link if the array needs them."""
    bore = mm(build.pin) + mm(build.pin_clearance)
    outlines = {"jig": jigs.make_jig(lengths.pin_to_pin, bore)}
    if parallel > 1:
        outlines["yoke"] = jigs.make_yoke(parallel, brake_pitch(build, lengths), bore)
    if series > 1:
        outlines["link"] = jigs.make_link(lengths.head, mm(build.gap), bore)
    return outlines


def brake_pitch(build: Build, lengths: Lengths) -> float:
    """Return the distance between the axes of parallel brakes [mm], set by enclosure or head."""
    return max(lengths.tray_width + 2 * lengths.wall, lengths.head) + mm(build.gap)


RED, BLUE, GREY = "#ff0000", "#0000ff", "#808080"
_EDGE = 1.0
"""Margin around the parts, so that no line is clipped [mm]."""


def write_svg(
    parts: Sequence[Outline], frame: Frame | None = None, notes: Sequence[str] = ()
) -> bytes:
    """Return an SVG file as bytes: red is cut, blue is cut first, grey (`frame`) is not cut.

    `notes` are sentences for the reader of the file; they are not drawn.
    """
    left, low, right, high = bounding_box(parts)
    if frame is not None:
        left, low = min(left, 0), min(low, -24.0)
        right, high = max(right, frame.length, BAR), max(high, frame.width)
    wide, tall = right - left + 2 * _EDGE, high - low + 2 * _EDGE
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_text(wide)}mm" height="{_text(tall)}mm" '
        f'viewBox="{_text(left - _EDGE)} {_text(-high - _EDGE)} {_text(wide)} {_text(tall)}" '
        'fill="none" stroke-width="0.1">'
    ]
    lines += [f"<desc>{escape(note)}</desc>" for note in notes]
    if frame is not None:
        lines += _info_lines(frame)
    lines.append(f'<g id="cut-inside" stroke="{BLUE}">')
    for part in parts:
        for hole in part.holes:
            x, y, radius = _text(hole.x), _text(-hole.y), _text(hole.diameter / 2)
            lines.append(f'<circle cx="{x}" cy="{y}" r="{radius}"/>')
        for (a, b), (c, d) in part.cuts:
            lines.append(f'<path d="M{_text(a)} {_text(-b)}L{_text(c)} {_text(-d)}"/>')
    lines += ["</g>", f'<g id="cut" stroke="{RED}">']
    lines += [f'<path d="{path_data(part.path())}"/>' for part in parts]
    lines += ["</g>", "</svg>", ""]
    return "\n".join(lines).encode()


def path_data(path: Sequence[Vertex]) -> str:
    """Return the SVG data of a closed path, with y pointing down."""
    words = [f"M{_text(path[0].x)} {_text(-path[0].y)}"]
    for begin, stop in zip(path, [*path[1:], path[0]], strict=True):
        end = f"{_text(stop.x)} {_text(-stop.y)}"
        radius = _text(abs(stop.x - begin.x))
        words.append(f"A{radius} {radius} 0 0 0 {end}" if begin.bulge else f"L{end}")
    return "".join(words) + "Z"


def _info_lines(frame: Frame) -> list[str]:
    text = f'fill="{GREY}" stroke="none" font-family="sans-serif" font-size="4"'
    width, height = _text(frame.length), _text(frame.width)
    return [
        f'<g id="info" stroke="{GREY}">',
        f'<rect x="0" y="{_text(-frame.width)}" width="{width}" height="{height}"/>',
        f'<path d="M0 12L{_text(BAR)} 12M0 10L0 14M{_text(BAR)} 10L{_text(BAR)} 14"/>',
        f'<text x="2" y="10" {text}>{_text(BAR)} mm</text>',
        f'<text x="2" y="20" {text}>{escape(frame.words)}</text>',
        "</g>",
    ]


def _text(number: float) -> str:
    return f"{number:.12f}".rstrip("0").rstrip(".") if number else "0"
