"""Lengths that follow from a brake and a workshop's choices, all in mm.

Geometry in this folder is in mm, as in workshop files; records and JSON stay in SI. x points along
the pull, y across the sheets, z through the stack, whose middle is z = 0.

If the values of a brake's sheets are arrays, so are its lengths: a search computes many at once.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.workshop import LEAST_SCREW_HOLE, Build
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.workshop.fabricate.screws import LENGTHS, Thread, find_screw_length, find_thread

M5_PITCH, M5_LEAST = 0.8, 4.0
"""Pitch of M5 and shortest thread in printed resin [mm]: layerjam assumes five turns.

A fitting tightened by hand to 0.5 N m pulls with 500 N (K = 0.2). A resin with a strength of 40
MPa, or 23 MPa in shear, carries this force over an area of 0.6 pi d L if L is at least 2.3 mm.
"""
SPARE = 0.1
"""Smallest height of the air bore above the tray's floor [mm]."""
ROUND_BELOW, FLATTEST = 1.25, 3.0
"""Aspect ratio below which the neck is round, and largest aspect ratio [1]."""
ATMOSPHERES, SEAL_MARGIN = 2.0, 1.05
"""Tie pressure required for a seal [atmospheres], and the margin for the shape of the neck."""
BOLT_SPACING = 45.0
KEY_HEIGHT, KEY_DEPTH = 4.0, 5.0
"""Height of the mould's keys and depth of their holes [mm]."""
FLANGE = 6.0
"""Width of a mould's flange in addition to the bolt hole [mm]."""


R = TypeVar("R")


def mm(value: Any) -> Any:
    """Return a length [m] in mm, without rounding errors from the conversion."""
    return _round_value(value * 1e3, 14)


def _round_value(value: Any, digits: int) -> Any:
    if np.ndim(value):
        return np.round(value, digits - 3)
    return float(f"{value:.{digits}g}")


def _to_count(value: Any) -> Any:
    """Return a count as an int; an array of counts is returned unchanged."""
    return value if np.ndim(value) else int(value)


def map_arrays(record: R, change: Callable[[Any], Any]) -> R:
    """Return a record with `change` applied to every array, including those in nested records."""
    changes: dict[str, Any] = {}
    for f in fields(record):  # type: ignore[arg-type]
        value = getattr(record, f.name)
        if is_dataclass(value) and not isinstance(value, type):
            changes[f.name] = map_arrays(value, change)
        elif isinstance(value, np.ndarray) and value.ndim:
            changes[f.name] = change(value)
    return evolve(record, **changes)  # type: ignore[type-var]


class CannotBuildError(LayerjamError):
    """A brake that cannot be drawn: a result, not invalid input; `reason` is the cause."""

    key: ClassVar[str] = "cannot-build"

    def __init__(
        self, reason: str, text: str, value: float | None = None, limit: float | None = None
    ) -> None:
        super().__init__(text)
        self.reason, self.value, self.limit = reason, value, limit
        """Kind of reason, with value and limit in SI or None."""


@dataclass(frozen=True, kw_only=True)
class Side:
    """Sheets, spacers and lengths at one end of the brake."""

    name: str
    """Either "left" or "right"."""
    sheets: int
    """Number of sheets clamped at this end."""
    spacers: int
    """Number of spacers between these sheets, one for every sheet of the opposite side."""
    clamped: float
    """c_i: length of a sheet and of a spacer inside the cap."""
    tray: float
    """T: length of the tray, which is the clamped length plus the air space."""
    reach: float
    """Length of the cap inside the enclosure: tray, back wall and neck."""


@dataclass(frozen=True, kw_only=True)
class Mould:
    """Mould of the enclosure, with its parting plane at z = 0, and the casting."""

    inner_width: float
    inner_height: float
    outer_width: float
    outer_height: float
    """Widths and heights of core (inner) and cavity (outer), shrinkage included."""
    casting: float
    """Length of the cavity."""
    core: float
    """Length of the core, which is held at both ends."""
    length: float
    width: float
    half: float
    """Height of one half of the mould."""
    flange: float
    bolts: int
    """Number of bolt positions in each flange; the middle one has a key."""


@dataclass(frozen=True, kw_only=True)
class Lengths:
    """Lengths as in section 2.1 of the specification [mm]."""

    count: int
    width: float
    thickness: float
    sheet_length: float
    hole: float
    screws: int
    """Number of screws in each cap."""
    stack: float
    """H = n t."""
    free: float
    """D: distance from cap to cap."""
    left: Side
    right: Side
    thread: Thread
    screw_length: int
    floor: float
    """f: thickness of the plastic under the head and under the nut."""
    plate_height: float
    shelf_height: float
    cap_height: float
    slot: float
    tray_width: float
    neck_a: float
    """Half axis of the neck along y."""
    neck_b: float
    """Half axis of the neck along z."""
    girth: float
    """Inner girth of the enclosure at rest."""
    head: float
    """Width and length of the head that holds the pin."""
    head_height: float
    air_axis: float
    """z of the air bore's axis; raised if the bore would otherwise cut into the tray's floor."""
    port: float
    """Diameter of the port's bore."""
    port_length: float
    inner_width: float
    inner_height: float
    wall: float
    """Thickness of the enclosure's wall."""
    sleeve: float
    """Length of the trimmed enclosure."""
    pin_to_pin: float
    overall: float
    strap: float
    """Largest distance between the pins in use: their distance at rest plus the usable travel."""
    mould: Mould

    @property
    def sides(self) -> tuple[Side, Side]:
        """Left and right side."""
        return self.left, self.right

    @cached_property
    def has_same_caps(self) -> bool:
        """Whether one cap fits both ends of every brake."""
        return np.allclose(self.left.clamped, self.right.clamped, rtol=1e-9, atol=0.0)


def compute_lengths(brake: Brake, build: Build) -> Lengths:
    """Return all lengths of a build [mm].

    Raises QuantityError if the hole is too small for any screw, and CannotBuildError if no screw on
    sale is long enough.
    """
    sheets = brake.sheets
    thread, screw, floor, heights = _clamping_lengths(brake, build)
    width, stack = mm(sheets.width), _to_count(sheets.count) * mm(sheets.thickness)
    clearance = mm(build.sleeve_clearance)
    inner = width + 2 * clearance, stack + 2 * clearance
    girth = 2 * (inner[0] + inner[1])
    flattest = build.tie_tension / mm(build.tie_width) * 1e6
    flattest /= SEAL_MARGIN * ATMOSPHERES * brake.site.atmosphere
    neck_a, neck_b = _neck_axes(width / heights[2], (1 + build.neck_stretch) * girth, flattest)
    bore, port_length, head = map(mm, (build.port_bore, build.port_length, build.head))
    axis_height = np.maximum(0.0, mm(build.air_bore) / 2 + SPARE - stack / 2)
    left, right = (_side_lengths(brake, build, name) for name in ("left", "right"))
    free = sum(map(mm, (sheets.free_left, sheets.overlap, sheets.free_right)))
    sleeve = free + left.reach + right.reach
    pins = sleeve + 2 * (port_length + head / 2)
    slot = width + 2 * mm(build.side)
    return Lengths(
        count=_to_count(sheets.count),
        width=width,
        thickness=mm(sheets.thickness),
        sheet_length=mm(sheets.length),
        hole=mm(brake.mount.screw_hole),
        screws=_to_count(brake.mount.count_screws(sheets.width)),
        stack=stack,
        free=free,
        left=left,
        right=right,
        thread=thread,
        screw_length=screw,
        floor=floor,
        plate_height=heights[0],
        shelf_height=heights[1],
        cap_height=heights[2],
        slot=slot,
        tray_width=slot + 2 * mm(build.cheek),
        neck_a=neck_a,
        neck_b=neck_b,
        girth=girth,
        head=head,
        head_height=port_length + 2 * axis_height,
        air_axis=axis_height,
        port=bore,
        port_length=port_length,
        inner_width=inner[0],
        inner_height=inner[1],
        wall=mm(brake.enclosure.wall),
        sleeve=sleeve,
        pin_to_pin=pins,
        overall=pins + head,
        strap=pins + mm(sheets.usable_travel),
        mould=_mould_lengths(build, inner, mm(brake.enclosure.wall), sleeve),
    )


def _clamping_lengths(brake: Brake, build: Build) -> tuple[Thread, Any, Any, tuple[Any, Any, Any]]:
    """Return thread, screw length (NaN if too long), floor, and heights of plate, shelf and cap."""
    hole = mm(brake.mount.screw_hole)
    thread = find_thread(hole)
    if thread is None:
        raise QuantityError.of(
            "mount.screw_hole",
            f"{show(brake.mount.screw_hole, 'm')} is too small for any screw; at least "
            f"{show(LEAST_SCREW_HOLE, 'm')} is needed for M2",
        )
    stack = _to_count(brake.sheets.count) * mm(brake.sheets.thickness)
    min_grip = stack + 2 * mm(build.floor) + thread.nut_height
    screw = find_screw_length(min_grip, thread)
    if np.ndim(screw) == 0 and np.isnan(screw):
        raise CannotBuildError(
            "screw-length",
            f"a stack {show(stack * 1e-3, 'm')} high needs a screw of "
            f"{show(min_grip * 1e-3, 'm')}; the longest available is {LENGTHS[-1]} mm: use "
            "fewer or thinner sheets",
            min_grip * 1e-3,
            LENGTHS[-1] * 1e-3,
        )
    floor = mm(build.floor) + (screw - min_grip) / 2
    head_room = mm(build.head_room)
    plate, shelf = thread.head_height + head_room + floor, thread.nut_height + head_room + floor
    return thread, _to_count(screw), floor, (plate, shelf, plate + stack + shelf)


def _side_lengths(brake: Brake, build: Build, name: str) -> Side:
    sheets, is_left = brake.sheets, name == "left"
    odd_share, even_share = (_to_count(sheets.count) + 1) // 2, _to_count(sheets.count) // 2
    free = mm(sheets.free_left if is_left else sheets.free_right)
    clamped_length = _round_value(mm(sheets.length) - free - mm(sheets.overlap), 13)
    tray = clamped_length + mm(build.plenum)
    return Side(
        name=name,
        sheets=odd_share if is_left else even_share,
        spacers=even_share if is_left else odd_share,
        clamped=clamped_length,
        tray=tray,
        reach=tray + mm(build.back) + mm(build.neck_length),
    )


def _neck_axes(aspect: Any, girth: Any, flattest: float) -> tuple[Any, Any]:
    """Return half axes of an ellipse of a given girth, as flat as the cap if the seal allows it.

    The pressure of a tie is lowest at the flattest point: its tension divided by its width and the
    radius a²/b there; `flattest` is the largest radius [mm] that seals. A flatter shape is made
    rounder until it seals. Below an aspect ratio of `ROUND_BELOW`, it is circular.
    """
    shape = np.clip(aspect, 1.0, FLATTEST)
    shape = np.minimum(shape, flattest * ellipse_girth(1.0, 1 / shape) / girth)
    shape = np.where(shape < ROUND_BELOW, 1.0, shape)
    half = girth / ellipse_girth(1.0, 1 / shape)
    return half, half / shape


def ellipse_girth(a: Any, b: Any) -> Any:
    """Return the girth of an ellipse with half axes a and b, by the arithmetic-geometric mean.

    Six iterations are exact, up to rounding, for any b from a/100 to a.
    """
    mean, geometric, square, weight = a, b, (a * a + b * b) / 2, 0.5
    for _ in range(6):
        half = (mean - geometric) / 2
        weight *= 2
        square = square - weight * half * half
        mean, geometric = (mean + geometric) / 2, (mean * geometric) ** 0.5
    return 2 * np.pi * square / mean


def _mould_lengths(build: Build, inner: tuple[float, float], wall: float, sleeve: float) -> Mould:
    """Return the mould of an enclosure; core and cavity are enlarged by the shrinkage."""
    scale = 1 + build.shrinkage
    inner_width, inner_height = inner[0] * scale, inner[1] * scale
    outer_width, outer_height = (inner[0] + 2 * wall) * scale, (inner[1] + 2 * wall) * scale
    casting = (sleeve + 2 * mm(build.trim)) * scale
    core = (sleeve + 2 * mm(build.trim) + 2 * mm(build.core_print)) * scale
    length = core + 2 * mm(build.mould_wall)
    flange = mm(build.mould_bolt) + FLANGE
    spans = np.ceil((length - flange) / BOLT_SPACING - 1e-9)
    return Mould(
        inner_width=inner_width,
        inner_height=inner_height,
        outer_width=outer_width,
        outer_height=outer_height,
        casting=casting,
        core=core,
        length=length,
        width=outer_width + 2 * flange,
        half=outer_height / 2 + mm(build.mould_wall),
        flange=flange,
        bolts=_to_count(np.maximum(3, spans + 1)),
    )


def nut_overhang(lengths: Lengths) -> Any:
    """Return the overhang of a nut's corner beyond the tray's face [mm]; negative if behind it."""
    shorter = np.minimum(lengths.left.clamped, lengths.right.clamped)
    return lengths.thread.nut / np.sqrt(3) - shorter / 2
