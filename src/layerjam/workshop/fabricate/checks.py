"""Checks of a build as drawn: C2 (printer), C4 to C6, C10, C11, C13 and C14."""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import permutations
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake, enclosure_mass, mass, sheet_mass
from layerjam.brake.device.workshop import M5, PORT_WALL, Build, Casting, find_changed_input
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.units import get, show
from layerjam.workshop.fabricate.cap import pin_hole_diameter
from layerjam.workshop.fabricate.lengths import (
    ATMOSPHERES,
    KEY_DEPTH,
    M5_LEAST,
    Lengths,
    ellipse_girth,
    mm,
)
from layerjam.workshop.fabricate.masses import MassRow
from layerjam.workshop.fabricate.parts import Part
from layerjam.workshop.fabricate.silicone import silicone_checks
from layerjam.workshop.fabricate.strength import strength_checks
from layerjam.workshop.fabricate.verdicts import Check, finding

HEAD_RIM = 0.4
"""Length by which the clamp must exceed the diameter of a screw's head [mm]."""
SHARE_OF_BREAK = 1 / 3
"""Maximum stretch of the enclosure over the cap, as a fraction of its elongation at break."""
MASS_BOUND, PART_BOUND = 0.10, 0.01
Limits = Iterator[tuple[tuple[str, ...], Any, Any, str]]


def drawable_limits(build: Build, lengths: Lengths) -> Limits:
    """Yield (inputs, value [mm], upper limit [mm], name of the limit) for each drawing rule."""
    wall, clamp = mm(build.wall), mm(build.clamp_radius)
    mould = lengths.mould
    step = (mould.length - mould.flange) / (mould.bolts - 1)
    neck = lengths.neck_b - lengths.air_axis - mm(build.air_bore) / 2 - wall
    key = mm(build.key) + mm(build.key_clearance)
    shorter = np.minimum(lengths.left.clamped, lengths.right.clamped)
    yield (
        ("tie_depth", "air_bore", "wall", "neck_stretch"), mm(build.tie_depth), neck,
        "the space in the neck next to the air bore and the wall",
    )  # fmt: skip
    yield ("air_bore", "port"), mm(build.air_bore), lengths.port, "the port's bore"
    yield (
        ("edge", "pin_wall"), mm(build.edge), mm(min(PORT_WALL, build.pin_wall)),
        "the head's thinnest wall",
    )  # fmt: skip
    yield (
        ("key", "key_clearance", "mould_bolt", "wall"), key, mould.flange - 2 * wall,
        "the mould's flange minus two walls",
    )  # fmt: skip
    yield ("mould_bolt",), mm(build.mould_bolt), step, "the distance between two bolts"
    yield ("sprue",), mm(build.sprue), lengths.mould.outer_width, "the enclosure's width"
    yield ("vent",), mm(build.vent), mould.outer_width / 2, "half the enclosure's width"
    yield ("mould_wall",), KEY_DEPTH - mould.half, 0.0, "the depth of the keys' holes, 5 mm"
    yield (
        ("core_clearance", "mould_wall", "wall"), mm(build.core_clearance),
        mm(build.mould_wall) - wall, "the mould's wall minus one printed wall",
    )  # fmt: skip
    yield (
        ("core_clearance", "enclosure.wall"), mm(build.core_clearance), lengths.wall,
        "the enclosure's wall: the core could touch the mould",
    )  # fmt: skip
    yield (
        ("key_clearance", "enclosure.wall"), mm(build.key_clearance), 2 * lengths.wall,
        "twice the enclosure's wall: the mould's halves could close it",
    )  # fmt: skip
    yield ("clamp_radius",), clamp, shorter / 2, "half the spacers' length"
    yield (
        ("tip_radius", "clamp_radius"), mm(build.tip_radius), lengths.sheet_length - clamp,
        "the sheets minus the corners of the other end",
    )  # fmt: skip


def check_drawability(brake: Brake, build: Build, lengths: Lengths) -> None:
    """Raise QuantityError if choices cannot be drawn together.

    The error names a choice that differs from its default, otherwise an input from the brake.
    """
    for names, value, limit, name in drawable_limits(build, lengths):
        if value < limit:
            continue
        build_keys = [n for n in names if "." not in n]
        key = find_changed_input(build, *build_keys)
        path = f"build.{key}"
        if getattr(build, key) == getattr(Build(), key):
            path = next((n for n in names if "." in n), path)
        entry = getattr(build, key) if path == f"build.{key}" else get(brake, path)
        text = f"{entry:.0%} " if key == "neck_stretch" else f"{show(entry, 'm')} "
        if path != f"build.{names[0]}":
            text += f"conflicts with build.{names[0]}: {show(getattr(build, names[0]), 'm')} "
        raise QuantityError.of(
            path, f"{text}is not less than {name}, {show(max(float(limit), 0.0) * 1e-3, 'm')}"
        )


def part_checks(
    brake: Brake,
    build: Build,
    casting: Casting,
    lengths: Lengths,
    parts: Sequence[Part],
    force: Any,
    friction_source: str = "",
) -> Iterator[Check]:
    """Yield checks C2 (printer) and C4 to C13 for a force [N], or for arrays in a search."""
    yield from printing_checks(build, parts)
    yield from clamping_checks(build, lengths)
    yield from check_enclosure(brake, build, casting, lengths)
    yield from strength_checks(force, brake, build, lengths, friction_source)
    yield wall_check(build, lengths)
    yield seal_check(brake, build, lengths)
    yield from silicone_checks(build, casting, lengths)


def _length_check(code: str, key: str, value: Any, limit: Any, text: str, remedy: str) -> Check:
    """Return the check that a length [mm] is sufficient; a brake that fails it cannot be drawn."""
    return Check(
        code=code,
        key=key,
        words=partial(_describe_length, value, limit, text, remedy),
        value=value * 1e-3,
        limit=limit * 1e-3,
        at_most=False,
        unit="m",
        otherwise="refused",
    )


def _describe_length(value: float, limit: float, text: str, remedy: str, ok: bool | None) -> str:
    return text.format(value=_to_mm(value), need=_to_mm(limit)) + (remedy if ok is False else "")


def clamping_checks(build: Build, lengths: Lengths) -> Iterator[Check]:
    """Yield C4: room for heads, nuts and the thread of a fitting."""
    thread, wall = lengths.thread, mm(build.wall)
    for side in lengths.sides[: 1 if lengths.has_same_caps else 2]:
        yield _length_check(
            "C4",
            "clamp-length",
            side.clamped,
            thread.head + HEAD_RIM,
            f"{side.name} clamp: {{value}} long; an {thread.name} head needs {{need}}",
            ": use longer sheets and mount.clamped_length, or a smaller mount.screw_hole",
        )
    for part, size in (("nut", thread.nut), ("head", thread.head)):
        yield _length_check(
            "C4",
            f"{part}-width",
            lengths.width / lengths.screws,
            size + mm(build.fit) + 2 * wall,
            f"{{value}} of width per screw; an {thread.name} {part} and its walls need {{need}}",
            ": use fewer screws (mount.screws), wider sheets, or a smaller mount.screw_hole",
        )
    if build.port == M5:
        yield _length_check(
            "C4",
            "port-thread",
            lengths.head / 2,
            M5_LEAST,
            "the port's thread is {value} deep; M5 in printed resin needs {need}",
            ": use a larger build.pin_wall",
        )


def screw_notices(lengths: Lengths) -> Iterator[Notice]:
    """Yield notices about a screw that is not in the standard, or that may jam in the film."""
    thread = lengths.thread
    if lengths.screw_length > thread.longest:
        yield Notice(
            f"ISO 4762 lists {thread.name} up to {thread.longest} mm long; {thread.name} "
            f"× {lengths.screw_length} is sold, but buy it before you print anything",
            "screw-length",
        )
    if lengths.hole < thread.close - 1e-9:
        hole, close_fit = (show(value * 1e-3, "m") for value in (lengths.hole, thread.close))
        yield Notice(
            f"{thread.name} through film holes of {hole}: cutting is accurate to about "
            f"0.1 mm, so the screw may jam; mount.screw_hole = '{close_fit}' (ISO 273, fine) "
            "leaves room",
            "tight-hole",
        )


def check_enclosure(brake: Brake, build: Build, cast: Casting, lengths: Lengths) -> Iterator[Check]:
    """Yield C5 and C6: the enclosure's stretch, and free length for its descent to the stack."""
    edge = (8 - 2 * math.pi) * mm(build.edge)
    girths = {
        "tray": 2 * (lengths.tray_width + lengths.cap_height) - edge,
        "head": 2 * (lengths.head + lengths.head_height) - edge,
        "neck": ellipse_girth(lengths.neck_a, lengths.neck_b),
    }
    limit = None
    if cast.elongation_at_break is not None:
        limit = SHARE_OF_BREAK * cast.elongation_at_break
    for place, girth in girths.items():
        stretch = girth / lengths.girth - 1
        yield Check(
            code="C5",
            key=f"sleeve-over-{place}",
            words=partial(_describe_stretch, place, stretch, limit),
            value=stretch,
            limit=limit,
            otherwise="refused",
        )
    free = mm(np.minimum(brake.sheets.free_left, brake.sheets.free_right))
    need = (lengths.cap_height - lengths.stack) / 2
    yield Check(
        code="C6",
        key="free-length",
        words=partial(_describe_descent, free, need),
        value=free * 1e-3,
        limit=need * 1e-3,
        at_most=False,
        unit="m",
    )


def _describe_stretch(place: str, stretch: float, limit: float | None, ok: bool | None) -> str:
    text = f"stretch of the enclosure over the {place}: {stretch:+.0%} of its girth"
    if limit is None:
        return text + " (enclosure.elongation_at_break is not given)"
    return text if ok else (
        f"{text}, more than a third of its elongation at break, {limit:.0%}: use a softer "
        "silicone, or a smaller mount.screw_hole, which lowers the cap"
    )  # fmt: skip


def _describe_descent(free: float, limit: float, ok: bool | None) -> str:
    length, descent = _to_mm(free), _to_mm(limit)
    if ok:
        return f"the enclosure descends from the cap within {descent}; the free length is {length}"
    return (
        f"free length {length}; the enclosure needs {descent} to come down from the "
        "cap, and therefore bridges part of the overlap"
    )


def wall_thicknesses(build: Build, lengths: Lengths) -> dict[str, Any]:
    """Return {wall: thickness [mm]} of the printed parts that stay in the brake.

    Rounded edges count as sharp corners. A wall that the brake lacks has an infinite thickness.
    """
    thread, fit, back_wall = lengths.thread, mm(build.fit), mm(build.back)
    bore, hole, nut = mm(build.air_bore) / 2, thread.clearance / 2, thread.nut + fit
    pitch, free = lengths.width / lengths.screws, math.inf
    top, low = lengths.stack / 2 + lengths.plate_height, lengths.stack / 2 + lengths.shelf_height
    shorter = np.minimum(lengths.left.clamped, lengths.right.clamped)
    screw_span = lengths.width - pitch
    pocket = nut / math.sqrt(3)
    neck, slot, depth = mm(build.neck_length), mm(build.tie_slot), mm(build.tie_depth)
    # the rims of the neck are free if neither the tray nor the head is behind them
    half_width = np.minimum(lengths.tray_width, lengths.head) / 2
    high = np.minimum(np.minimum(top, low), lengths.head_height / 2)
    proud = (lengths.neck_a > half_width) | (lengths.neck_b > high)
    return {
        "floor under head and nut": lengths.floor,
        "tray's side": mm(build.cheek),
        "tray's back": back_wall,
        "tray behind the nut": shorter / 2 + mm(build.plenum) + back_wall - pocket,
        "tray next to the nut": (lengths.tray_width - screw_span - nut) / 2,
        "tray in front of the screw hole": shorter / 2 - hole,
        "plate behind the screw hole": shorter / 2 + mm(build.plenum) - fit - hole,
        "plate next to the head": (lengths.slot - 2 * fit - screw_span - thread.head - fit) / 2,
        "tray above the air bore": top - lengths.air_axis - bore,
        "neck around the air bore": lengths.neck_b - depth - lengths.air_axis - bore,
        "neck next to the tie": np.where(proud, (neck - slot) / 2 if depth else neck, free),
        "head next to the air bore": lengths.head / 2 - bore,
        "head around the port": mm(PORT_WALL),
        "head around the pin": (lengths.head - pin_hole_diameter(build)) / 2,
        "between two nuts": np.where(lengths.screws > 1, pitch - nut, free),
        "between two heads": np.where(lengths.screws > 1, pitch - thread.head - fit, free),
    }


def wall_check(build: Build, lengths: Lengths) -> Check:
    """Return check C10: the thinnest wall."""
    thicknesses = wall_thicknesses(build, lengths)
    thinnest = np.min(np.broadcast_arrays(*thicknesses.values()), axis=0)
    place = "" if np.ndim(thinnest) else min(thicknesses, key=lambda name: float(thicknesses[name]))
    return _length_check(
        "C10", "least-wall", thinnest, mm(build.wall),
        f"thinnest wall {{value}} ({place}); {{need}} is needed",
        f": use a smaller build.wall, or a larger {WALL_INPUTS.get(place, 'mount.clamped_length')}",
    )  # fmt: skip


WALL_INPUTS = {
    "floor under head and nut": "build.floor",
    "tray's side": "build.cheek",
    "tray's back": "build.back",
    "tray behind the nut": "build.back",
    "tray next to the nut": "build.cheek",
    "plate behind the screw hole": "build.plenum",
    "plate next to the head": "sheets.width",
    "tray above the air bore": "build.floor",
    "neck around the air bore": "build.neck_stretch",
    "neck next to the tie": "build.neck_length",
    "head next to the air bore": "build.pin_wall",
    "head around the pin": "build.pin_wall",
    "between two nuts": "sheets.width",
    "between two heads": "sheets.width",
}
"""{wall: input that makes it thicker}; for any other wall, it is mount.clamped_length."""


def seal_check(brake: Brake, build: Build, lengths: Lengths) -> Check:
    """Return check C11: the pressure of the tie at the flattest point of the neck."""
    a, b = lengths.neck_a * 1e-3, lengths.neck_b * 1e-3
    pressure = build.tie_tension * np.minimum(b / a**2, 1 / b) / build.tie_width
    need = ATMOSPHERES * brake.site.atmosphere
    return Check(
        code="C11",
        key="seal",
        words=partial(_describe_seal, build.tie_tension, pressure, need),
        value=pressure,
        limit=need,
        at_most=False,
        unit="Pa",
        otherwise="failed",
    )


def _describe_seal(tension: float, pressure: float, limit: float, ok: bool | None) -> str:
    text = (
        f"a tie tightened to {show(tension, 'N')} presses on the neck with {show(pressure, 'Pa')}; "
        f"a seal needs at least {show(limit, 'Pa')}"
    )
    min_force = show(float(f"{tension * limit / pressure * 1.01:.2g}"), "N")
    return text + (
        "" if ok else f": tighten the tie to {min_force} (build.tie_tension), or use a narrower tie"
    )


def printing_checks(build: Build, parts: Sequence[Part]) -> Iterator[Check]:
    """Yield C2 (printer): whether each printed part fits into the printer, parallel to its axes."""
    if build.print_bed is None:
        yield finding("C2", "print-bed", "not checked: the printer's build volume is not given")
        return
    bed = [mm(side) for side in build.print_bed]
    for part in parts:
        if not part.printed:
            continue
        turns = [
            np.maximum.reduce(
                np.broadcast_arrays(*(side - room for side, room in zip(sides, bed, strict=True)))
            )
            for sides in permutations(part.solid.size)
        ]
        excess = np.minimum.reduce(np.broadcast_arrays(*turns))
        yield Check(
            code="C2",
            key="print-bed",
            words=partial(_describe_fit, part.name, part.solid.size, bed),
            value=np.maximum.reduce(np.broadcast_arrays(*part.solid.size)) * 1e-3,
            limit=max(bed) * 1e-3,
            unit="m",
            passes=excess <= 1e-9,
            otherwise="refused",
        )


def _describe_fit(name: str, sides: Sequence[float], bed: Sequence[float], ok: bool | None) -> str:
    size = " × ".join(f"{side:.4g}" for side in sides)
    if ok:
        return f"{name}, {size} mm, fits the printer"
    excess, axis = min(
        max((side - room, name) for side, room, name in zip(turn, bed, "xyz", strict=True))
        for turn in permutations(sides)
    )
    return f"{name}, {size} mm, is too large for the printer by {_to_mm(excess)} along {axis}"


def mass_checks(brake: Brake, rows: Sequence[MassRow]) -> Iterator[Check]:
    """Yield C14: the mass as drawn, compared with the model in total and part by part."""
    row_of = {row.name: row for row in rows}
    sheets = sum(row.mass for name, row in row_of.items() if name.startswith("sheet"))
    pairs = (
        ("whole brake, without parts of unknown mass", sum(r.mass for r in rows), mass(brake)),
        ("sheets", sheets, brake.sheets.count * sheet_mass(brake)),
        ("enclosure from cap to cap", row_of["enclosure, cap to cap"].mass, enclosure_mass(brake)),
    )
    for (part, part_mass, model), bound in zip(pairs, (MASS_BOUND, *[PART_BOUND] * 2), strict=True):
        error = part_mass / model - 1
        text = f"{part}: {show(part_mass, 'kg')} as drawn, {error:+.1%} relative to "
        text += f"{show(model, 'kg')} of the model"
        limits = {"value": error, "limit": bound, "passes": abs(error) <= bound}
        yield finding("C14", f"mass-{part.split()[0]}", text, **limits)


def _to_mm(value: float) -> str:
    return f"{value:.4g} mm"
