"""Whether a brake can be built as drawn: C2 of the printer, C4 to C6, C10, C11 and C14."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import permutations

from layerjam.device.brake import Brake, enclosure_mass, mass, sheet_mass
from layerjam.device.workshop import Build, Casting
from layerjam.errors import Notice, QuantityError
from layerjam.fabricate.cap import air_height
from layerjam.fabricate.lengths import KEY_DEPTH, PORT_WALL, Lengths, ellipse_girth, mm
from layerjam.fabricate.masses import MassRow
from layerjam.fabricate.parts import Part
from layerjam.fabricate.verdicts import Check
from layerjam.units import show

HEAD_RIM = 0.4
"""Clamped length beyond the screw's head [mm]."""
SHARE_OF_BREAK = 1 / 3
"""Of its elongation at break, to which the enclosure may be stretched over the cap."""
ATMOSPHERES = 2.0
MASS_BOUND, PART_BOUND = 0.10, 0.01


def agree_drawn(build: Build, lengths: Lengths) -> None:
    """Raise QuantityError for choices that cannot be drawn together."""
    wall, depth = mm(build.wall), mm(build.tie_depth)
    room = lengths.neck_b - air_height(lengths, build) - mm(build.air_bore) / 2 - wall
    found = lengths.mould
    step = (found.length - found.flange) / (found.bolts - 1)
    rules = (
        ("tie_depth", depth, room, "what the neck leaves beside air bore and wall"),
        ("air_bore", mm(build.air_bore), lengths.port, "the port's bore"),
        ("edge", mm(build.edge), min(PORT_WALL, mm(build.pin_wall)), "the head's thinnest wall"),
        ("key", mm(build.key) + mm(build.key_clearance), found.flange, "the mould's flange"),
        ("mould_bolt", mm(build.mould_bolt), step, "the distance of two bolts"),
        ("sprue", mm(build.sprue), found.outer_width, "the enclosure's width"),
        ("vent", mm(build.vent), found.outer_width / 2, "half the enclosure's width"),
    )
    for key, value, limit, what in rules:
        if value >= limit:
            given, most = show(getattr(build, key), "m"), show(max(limit, 0.0) * 1e-3, "m")
            raise QuantityError.of(f"build.{key}", f"{given} is not less than {what}, {most}")
    if found.half <= KEY_DEPTH:
        raise QuantityError.of(
            "build.mould_wall",
            f"{show(build.mould_wall, 'm')} leaves no floor below the keys' holes, which are "
            f"{KEY_DEPTH:g} mm deep",
        )


def clamp_checks(build: Build, lengths: Lengths) -> Iterator[Check]:
    """C4: room for heads and nuts."""
    thread, wall = lengths.thread, mm(build.wall)
    need = thread.head + HEAD_RIM
    for side in lengths.sides[: 1 if lengths.same_caps else 2]:
        ok = side.clamped >= need - 1e-9
        text = f"{side.name} clamp {_mm(side.clamped)} long; a head of {thread.name} needs "
        text += _mm(need)
        if not ok:
            text += ": longer sheets and mount.clamped_length, or a smaller mount.screw_hole"
        yield _must("C4", ok, text, side.clamped, need, "clamp-length")
    pitch = lengths.width / lengths.screws
    for what, size in (("nut", thread.nut), ("head", thread.head)):
        need = size + mm(build.fit) + 2 * wall
        ok = pitch >= need - 1e-9
        text = f"{_mm(pitch)} of width a screw; a {what} of {thread.name} with its walls needs "
        text += _mm(need)
        if not ok:
            text += ": fewer screws (mount.screws), wider sheets, or a smaller mount.screw_hole"
        yield _must("C4", ok, text, pitch, need, f"{what}-width")


def screw_notices(lengths: Lengths) -> Iterator[Notice]:
    """What is to be warned of: a screw that no list has, and one that may jam in the film."""
    thread = lengths.thread
    if lengths.screw_length > thread.longest:
        yield Notice(
            f"ISO 4762 lists {thread.name} up to {thread.longest} mm long; {thread.name} × "
            f"{lengths.screw_length} is made, and has to be found before anything is printed",
            "screw-length",
        )
    if lengths.hole < thread.close - 1e-9:
        hole, close = (show(value * 1e-3, "m") for value in (lengths.hole, thread.close))
        yield Notice(
            f"{thread.name} through film holes of {hole}: cutting is good to about 0.1 mm, the "
            f"screw may jam; mount.screw_hole = '{close}' (ISO 273, fine) leaves room",
            "tight-hole",
        )


def sleeve_checks(brake: Brake, build: Build, known: Casting, lengths: Lengths) -> Iterator[Check]:
    """C5 and C6: how far the enclosure is stretched, and whether it comes down on the stack."""
    edge = (8 - 2 * math.pi) * mm(build.edge)
    girths = {
        "tray": 2 * (lengths.tray_width + lengths.cap_height) - edge,
        "head": 2 * (lengths.head + lengths.head_height) - edge,
        "neck": ellipse_girth(lengths.neck_a, lengths.neck_b),
    }
    limit = None
    if known.elongation_at_break is not None:
        limit = SHARE_OF_BREAK * known.elongation_at_break
    for where, girth in girths.items():
        stretch = girth / lengths.girth - 1
        text = f"enclosure over the {where}: {stretch:+.0%} of its girth"
        text += " (enclosure.elongation_at_break is not given)" if limit is None else ""
        if limit is not None and stretch > limit:
            text += f", more than a third of its elongation at break, {limit:.0%}: a softer "
            text += "silicone, or a smaller mount.screw_hole, which lowers the cap"
        yield Check(
            code="C5",
            ok=None if limit is None else stretch <= limit,
            refuses=True,
            text=text,
            value=stretch,
            limit=limit,
            key=f"sleeve-over-{where}",
        )
    free = mm(min(brake.sheets.free_left, brake.sheets.free_right))
    need = (lengths.cap_height - lengths.stack) / 2
    yield Check(
        code="C6",
        ok=free >= need,
        text=f"the enclosure comes down from the cap within {_mm(need)} of {_mm(free)} free length"
        if free >= need
        else f"free length {_mm(free)}; the enclosure needs {_mm(need)} to come down from the cap "
        "and bridges pressed overlap",
        value=free * 1e-3,
        limit=need * 1e-3,
        unit="m",
        key="free-length",
    )


def walls(build: Build, lengths: Lengths) -> dict[str, float]:
    """Every wall of the printed parts that stay in the brake, by name [mm]."""
    thread, fit = lengths.thread, mm(build.fit)
    raised, bore = air_height(lengths, build), mm(build.air_bore) / 2
    pitch = lengths.width / lengths.screws
    top = lengths.stack / 2 + lengths.plate_height
    known = {
        "floor under head and nut": lengths.floor,
        "tray's side": mm(build.cheek),
        "tray's back": mm(build.back),
        "tray beside the nut": (lengths.tray_width - lengths.width + pitch - thread.nut - fit) / 2,
        "plate beside the head": (
            lengths.slot - 2 * fit - lengths.width + pitch - thread.head - fit
        )
        / 2,
        "tray above the air bore": top - raised - bore,
        "neck around the air bore": lengths.neck_b - mm(build.tie_depth) - raised - bore,
        "head beside the air bore": lengths.head / 2 - bore,
        "head around the port": PORT_WALL,
        "head around the pin": mm(build.pin_wall) - mm(build.pin_clearance) / 2,
    }
    if lengths.screws > 1:
        known["between two nuts"] = pitch - thread.nut - fit
        known["between two heads"] = pitch - thread.head - fit
    return known


def wall_check(build: Build, lengths: Lengths) -> Check:
    """C10: the least of all walls."""
    least, where = min((thickness, name) for name, thickness in walls(build, lengths).items())
    need = mm(build.wall)
    return _must(
        "C10", least >= need - 1e-9, f"least wall {_mm(least)} ({where}); {_mm(need)} is needed",
        least, need, "least-wall",
    )  # fmt: skip


def seal_check(brake: Brake, build: Build, lengths: Lengths) -> Check:
    """C11: the tie's pressure on the neck where it is flattest."""
    a, b = lengths.neck_a * 1e-3, lengths.neck_b * 1e-3
    pressure = build.tie_tension * min(b / a**2, 1 / b) / build.tie_width
    need = ATMOSPHERES * brake.site.atmosphere
    remedy = ": pull it tighter (build.tie_tension), or take a narrower one"
    return Check(
        code="C11",
        ok=pressure > need,
        text=f"a tie pulled to {show(build.tie_tension, 'N')} presses on the neck with "
        f"{show(pressure, 'Pa')}; more than {show(need, 'Pa')} seals"
        + ("" if pressure > need else remedy),
        value=pressure,
        limit=need,
        unit="Pa",
        key="seal",
    )


def print_checks(build: Build, parts: Sequence[Part]) -> Iterator[Check]:
    """C2 of the printer: every printed part fits it, along its axes."""
    if build.print_bed is None:
        text = "printer's room not given, not checked"
        yield Check(code="C2", ok=None, text=text, key="print-bed")
        return
    bed = [mm(side) for side in build.print_bed]
    for part in parts:
        if not part.printed:
            continue
        excess, axis = min(
            max((size - room, name) for size, room, name in zip(turned, bed, "xyz", strict=True))
            for turned in permutations(part.solid.size)
        )
        size = " × ".join(f"{side:.4g}" for side in part.solid.size)
        text = f"{part.name}, {size} mm, fits the printer"
        if excess > 1e-9:
            text = (
                f"{part.name}, {size} mm, is too large for the printer by {_mm(excess)} in {axis}"
            )
        yield Check(
            code="C2", ok=excess <= 1e-9, refuses=True, text=text,
            value=max(part.solid.size) * 1e-3, limit=max(bed) * 1e-3, unit="m", key="print-bed",
        )  # fmt: skip


def mass_checks(brake: Brake, rows: Sequence[MassRow]) -> Iterator[Check]:
    """C14: the mass as drawn beside the model's, in all and part by part."""
    drawn = {row.name: row for row in rows}
    sheets = sum(row.mass for name, row in drawn.items() if name.startswith("sheet"))
    pairs = (
        ("whole brake, without what has no mass yet", sum(r.mass for r in rows), mass(brake)),
        ("sheets", sheets, brake.sheets.count * sheet_mass(brake)),
        ("enclosure from cap to cap", drawn["enclosure, cap to cap"].mass, enclosure_mass(brake)),
    )
    for (what, found, model), bound in zip(pairs, (MASS_BOUND, *[PART_BOUND] * 2), strict=True):
        off = found / model - 1
        yield Check(
            code="C14",
            ok=abs(off) <= bound,
            text=f"{what}: {show(found, 'kg')} as drawn, {off:+.1%} against {show(model, 'kg')} of "
            "the model",
            value=off,
            limit=bound,
            key=f"mass-{what.split()[0]}",
        )


def _must(code: str, ok: bool, text: str, value: float, limit: float, key: str) -> Check:
    """A check of a length [mm] that refuses."""
    return Check(
        code=code, ok=ok, refuses=True, text=text, value=value * 1e-3, limit=limit * 1e-3,
        unit="m", key=key,
    )  # fmt: skip


def _mm(value: float) -> str:
    return f"{value:.4g} mm"
