"""Everything that is cut from film: parts, pieces of stock, files and verdicts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from layerjam.device.file import BrakeFile
from layerjam.device.workshop import Build
from layerjam.fabricate import boards, cutting
from layerjam.fabricate.dxf import Frame, dxf
from layerjam.fabricate.lengths import Lengths, Side, mm
from layerjam.fabricate.nest import SLACK, Piece, Wanted, nest, nest_least, too_large
from layerjam.fabricate.outline import Outline, sheet, spacer
from layerjam.fabricate.svg import svg
from layerjam.fabricate.verdicts import ROUNDING, Check, say
from layerjam.units import show

LARGEST = (1169.0, 777.0)
"""Length and width of the pieces where no stock is given: what A0 holds with a ruler [mm]."""
LEAST_HOLE, HOLE_BY_THICKNESS, LEAST_RIM = 1.0, 1.5, 1.0
"""What a service cuts: least hole [mm] and [sheet thicknesses], least material beside it [mm]."""


@dataclass(frozen=True, kw_only=True)
class Film:
    """The film of a build; numbers in SI, outlines in mm."""

    parts: Sequence[Wanted]
    """Sheets and spacers at their nominal size; one name each for equal ones."""
    pieces: Sequence[Piece]
    """The same on pieces of stock, the kerf included."""
    checks: Sequence[Check]
    notes: Sequence[str]
    """Sentences that every file carries."""
    used: float
    """Share of the stock that becomes parts."""

    @property
    def area(self) -> float:
        """Area of all parts [m²]."""
        return 1e-6 * sum(part.outline.area() * part.count for part in self.parts)

    @property
    def cut_length(self) -> float:
        """Length of all cuts, at nominal size [m]."""
        return 1e-3 * sum(part.outline.cut_length() * part.count for part in self.parts)

    def files(self) -> dict[str, bytes]:
        """{path: bytes} of one part each for a service, and of whole pieces for one's own cutter.

        Raises MissingExtraError without ezdxf.
        """
        made = {}
        for part in self.parts:
            made[f"cut/{part.name}.dxf"] = dxf([part.outline], notes=self.notes)
            made[f"cut/{part.name}.svg"] = svg([part.outline], notes=self.notes)
        for piece in self.pieces:
            counts = ", ".join(f"{count} {name}" for name, count in piece.counts)
            size = f"{piece.length:.4g} x {piece.width:.4g} mm"
            words = f"{piece.name}: {size}, {counts}; film runs along x"
            frame = Frame(length=piece.length, width=piece.width, words=words)
            made[f"cut/{piece.name}.dxf"] = dxf(piece.parts, frame, self.notes)
            made[f"cut/{piece.name}.svg"] = svg(piece.parts, frame, self.notes)
        return made


def film(file: BrakeFile, build: Build, lengths: Lengths, copies: int = 1) -> Film:
    """The film of `copies` brakes, with the checks C1, C2 (of the laser's bed), C3 and C15.

    Where a part is larger than the stock there are no pieces, and C1 says so. Raises QuantityError
    for a laser and a film of which nothing is known.
    """
    parts = film_parts(build, lengths, copies)
    cut = [Wanted(part.name, part.outline.grown(mm(build.kerf)), part.count) for part in parts]
    stock = _stock(build)
    bed = _along(cut, build.laser_bed) if build.laser_bed else None
    margin, gap = mm(build.margin), mm(build.gap)
    room = stock or bed
    over = too_large(cut, room, margin) if room else None
    pieces: list[Piece] = []
    if over is None and stock:
        pieces = nest(cut, stock=stock, margin=margin, gap=gap)
    elif over is None:
        pieces = nest_least(cut, margin=margin, gap=gap, most=bed or LARGEST)
    checks = [_stock_check(pieces, over, stock), _bed_check(pieces, over, bed, stock)]
    checks += [*hole_checks(parts, lengths), cutting.laser_check(file, build.cutter)]
    area = sum(piece.length * piece.width for piece in pieces)
    filled = sum(part.outline.area() * part.count for part in parts)
    return Film(
        parts=parts,
        pieces=pieces,
        checks=checks,
        notes=cutting.notes(file, build.cutter),
        used=filled / area if area else 0.0,
    )


def film_parts(build: Build, lengths: Lengths, copies: int = 1) -> list[Wanted]:
    """Sheets and spacers of `copies` brakes, nominal; left and right apart where they differ."""
    made = []
    for kind, draw in (("sheet", _sheet), ("spacer", _spacer)):
        counts = {side.name: getattr(side, f"{kind}s") for side in lengths.sides}
        if lengths.same_caps:
            outline = draw(build, lengths, lengths.left)
            made.append(Wanted(kind, outline, copies * sum(counts.values())))
            continue
        for side in lengths.sides:
            outline = draw(build, lengths, side)
            made.append(Wanted(f"{kind}-{side.name}", outline, copies * counts[side.name]))
    return made


def _sheet(build: Build, lengths: Lengths, side: Side) -> Outline:
    tip, clamp = mm(build.tip_radius), mm(build.clamp_radius)
    return sheet(
        lengths.sheet_length,
        lengths.width,
        clamped=side.clamped,
        hole=lengths.hole,
        screws=lengths.screws,
        tip_radius=tip,
        clamp_radius=clamp,
    )


def _spacer(build: Build, lengths: Lengths, side: Side) -> Outline:
    return spacer(
        side.clamped,
        lengths.width,
        hole=lengths.hole,
        screws=lengths.screws,
        clamp_radius=mm(build.clamp_radius),
    )


def _stock(build: Build) -> tuple[float, float] | None:
    """Length and width of the stock [mm], where it was given."""
    if build.stock_length is None or build.stock_width is None:
        return None
    return mm(build.stock_length), mm(build.stock_width)


def _along(parts: Sequence[Wanted], bed: Sequence[float]) -> tuple[float, float]:
    """The laser's bed [mm], its longer side along the film unless only the other holds a part."""
    short, long = sorted(map(mm, bed))
    widest = max(part.outline.width for part in parts)
    longest = max(part.outline.length for part in parts)
    return (short, long) if widest > short and longest <= short else (long, short)


def stock_margin(parts: Sequence[Wanted], build: Build) -> Any:
    """Return how many times stock and laser bed hold each part: 1 or more can be cut."""
    around, most = mm(build.kerf) + 2 * mm(build.margin), math.inf
    sizes = [(p.outline.length + around, p.outline.width + around) for p in parts]
    rooms = [room for room in (_stock(build),) if room]
    if build.laser_bed:
        bed = sorted(map(mm, build.laser_bed), reverse=True)
        rooms = rooms or [(bed[0], bed[1]), (bed[1], bed[0])]
        if (stock := _stock(build)) is not None:
            most = min(b / s for b, s in zip(bed, sorted(stock, reverse=True), strict=True))
    if not rooms:
        return math.inf
    held = [
        np.min(np.broadcast_arrays(*(room[k] / size[k] for size in sizes for k in (0, 1))), axis=0)
        for room in rooms
    ]
    return np.minimum(np.max(held, axis=0), most) * (1 + ROUNDING)


Excess = tuple[str, str, float]
"""What is too large, along which axis, and by how much [mm]."""


def _stock_check(
    pieces: Sequence[Piece], over: Excess | None, stock: tuple[float, float] | None
) -> Check:
    if over is not None and stock is not None:
        what, axis, by = over
        return _too_large("C1", "stock", f"{what} with its margins", axis, by, "--stock")
    if over is not None:
        return Check(code="C1", key="stock", words=partial(say, "the laser's bed holds no part"))
    sizes = [f"{show(p.length * 1e-3, 'm')} × {show(p.width * 1e-3, 'm')}" for p in pieces]
    many = "1 piece" if len(pieces) == 1 else f"{len(pieces)} pieces"
    said = f"all film parts lie on {many} of {' and '.join(dict.fromkeys(sizes))}"
    return Check(code="C1", key="stock", words=partial(say, said), passes=True)


def _bed_check(
    pieces: Sequence[Piece],
    over: Excess | None,
    bed: tuple[float, float] | None,
    stock: tuple[float, float] | None,
) -> Check:
    """C2 of the film: a piece may be turned on the bed, with all its parts."""
    if bed is None:
        words = partial(say, "laser bed not given, not checked")
        return Check(code="C2", key="laser-bed", words=words)
    if over is not None and stock is None:
        what, axis, by = over
        return _too_large("C2", "laser-bed", f"{what} with its margins", axis, by, "--laser-bed")
    for piece in pieces:
        for axis, side, room in zip(
            ("shorter side", "longer side"),
            sorted((piece.length, piece.width)),
            sorted(bed),
            strict=True,
        ):
            if side > room + SLACK:
                what = f"the film {piece.name}"
                return _too_large("C2", "laser-bed", what, axis, side - room, "--stock")
    words = partial(say, "every piece lies on the laser bed")
    return Check(code="C2", key="laser-bed", words=words, passes=True)


def _too_large(code: str, key: str, what: str, axis: str, by: float, option: str) -> Check:
    room = {"stock": "stock", "laser-bed": "laser bed"}[key]
    said = f"{what} is {show(by * 1e-3, 'm')} larger than the {room} along its {axis}; "
    said += f"another {option} or a smaller brake is needed"
    return Check(
        code=code, key=key, words=partial(say, said), value=by * 1e-3, limit=0.0, unit="m",
        otherwise="refused",
    )  # fmt: skip


def hole_checks(parts: Sequence[Wanted], lengths: Lengths) -> Iterator[Check]:
    """C3: what a service can cut."""
    rim = np.min([part.outline.rim() for part in parts], axis=0)
    least = np.maximum(LEAST_HOLE, HOLE_BY_THICKNESS * lengths.thickness)
    pairs = (("hole-size", lengths.hole, least), ("holes", rim, LEAST_RIM))
    for key, value, limit in pairs:
        yield Check(
            code="C3",
            key=key,
            words=partial(_hole_words, key, value, limit),
            value=value * 1e-3,
            limit=limit * 1e-3,
            at_most=False,
            unit="m",
            otherwise="refused",
        )


def _hole_words(key: str, value: float, limit: float, ok: bool | None) -> str:
    size, least = show(max(value, 0.0) * 1e-3, "m"), show(limit * 1e-3, "m")
    if key == "hole-size":
        said, remedy = f"screw holes of {size}", "a larger mount.screw_hole or thinner film"
    else:
        said = f"{size} of film beside the screw holes"
        remedy = "a smaller mount.screw_hole, fewer screws or a longer clamp"
    return f"{said}, at least {least} is cut" + ("" if ok else f": {remedy} is needed")


def more_files(
    build: Build, lengths: Lengths, parallel: int, series: int, coupons: bool
) -> dict[str, bytes]:
    """{path: bytes} of what is no part of a brake: jig, yoke, link, coupons; all nominal."""
    flat = plates(build, lengths, parallel, series)
    made = {f"cut/{name}.dxf": dxf([part]) for name, part in flat.items()}
    if coupons:
        made["cut/coupon.dxf"] = dxf(boards.coupon(lengths.hole, mm(build.gap)))
    return made


def plates(build: Build, lengths: Lengths, parallel: int, series: int) -> dict[str, Outline]:
    """Jig, yoke and link by name, as far as an array needs them [mm]."""
    bore = mm(build.pin) + mm(build.pin_clearance)
    made = {"jig": boards.jig(lengths.pin_to_pin, bore)}
    if parallel > 1:
        made["yoke"] = boards.yoke(parallel, pitch(build, lengths), bore)
    if series > 1:
        made["link"] = boards.link(lengths.head, mm(build.gap), bore)
    return made


def pitch(build: Build, lengths: Lengths) -> float:
    """Distance of two brakes side by side [mm]: of their enclosures or of their heads."""
    return max(lengths.tray_width + 2 * lengths.wall, lengths.head) + mm(build.gap)
