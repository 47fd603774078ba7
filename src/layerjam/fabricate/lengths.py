"""The lengths that follow from a brake and the choices of its maker; all in mm.

Inside this folder geometry is in mm, as makers' files are; records and JSON stay in SI. x points
along the pull, y across the sheets, z through the stack, whose middle is z = 0.

Of a brake whose sheets are arrays all lengths are arrays too: a search asks for many at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.workshop import LEAST_SCREW_HOLE, M5, Build
from layerjam.errors import LayerjamError, QuantityError
from layerjam.fabricate.screws import LENGTHS, Thread, sold_length, thread_for
from layerjam.units import show

M5_BORE = 4.2
"""Hole into which M5 is cut [mm]; the thread's minor diameter is 4.134 mm."""
M5_PITCH, M5_LEAST = 0.8, 4.0
"""Pitch of M5, and the least length of it in printed resin [mm]: five turns, ours.

A fitting turned in by hand with 0.5 N m pulls with 500 N (K = 0.2); 0.6 pi d L of a resin that
bears 40 MPa, 23 MPa in shear, holds that from 2.3 mm on.
"""
GLUED = 0.1
"""By how much the bore is wider than a tube that is glued in [mm]."""
PORT_WALL = 2.0
SPARE = 0.1
"""By how much the air bore stays above the tray's floor [mm]."""
ROUND_BELOW, FLATTEST = 1.25, 3.0
"""Aspect below which the neck is round, and at most [1]."""
ATMOSPHERES, SEAL_MARGIN = 2.0, 1.05
"""Pressure of the tie that seals [atmospheres], and how much more the neck's shape gives."""
BOLT_SPACING = 45.0
KEY_HEIGHT, KEY_DEPTH = 4.0, 5.0
"""Height of the mould's keys and depth of their holes [mm]."""
FLANGE = 6.0
"""Plastic around the hole of a mould's bolt [mm]."""


R = TypeVar("R")


def mm(value: Any) -> Any:
    """Return a length in mm from one in m, without the dust of the conversion."""
    return _tidy(value * 1e3, 14)


def _tidy(value: Any, digits: int) -> Any:
    """Return a number without the dust of rounding behind its `digits`."""
    if np.ndim(value):
        return np.round(value, digits - 3)
    return float(f"{value:.{digits}g}")


def _whole(value: Any) -> Any:
    """Return a count: an int, or whole numbers in an array of floats."""
    return value if np.ndim(value) else int(value)


def change_arrays(record: R, change: Callable[[Any], Any]) -> R:
    """Return a record with every array in it, and in the records it holds, changed."""
    made: dict[str, Any] = {}
    for f in fields(record):  # type: ignore[arg-type]
        value = getattr(record, f.name)
        if is_dataclass(value) and not isinstance(value, type):
            made[f.name] = change_arrays(value, change)
        elif isinstance(value, np.ndarray) and value.ndim:
            made[f.name] = change(value)
    return replace(record, **made)  # type: ignore[type-var]


class CannotBuildError(LayerjamError):
    """No such brake can be drawn: an answer, not bad input. `key` says why, for programs."""

    key: ClassVar[str] = "cannot-build"

    def __init__(
        self, reason: str, text: str, value: float | None = None, limit: float | None = None
    ) -> None:
        super().__init__(text)
        self.reason, self.value, self.limit = reason, value, limit
        """What kind of reason, and value and limit in SI where there are any."""


@dataclass(frozen=True, kw_only=True)
class Side:
    """What lies at one end of the brake."""

    name: str
    """left or right."""
    sheets: int
    """Sheets that are clamped here."""
    spacers: int
    """Spacers between them: one for every sheet of the other side."""
    clamped: float
    """c_i: length of a sheet and of a spacer in the cap."""
    tray: float
    """T: clamped length and air space."""
    reach: float
    """Length of the cap inside the enclosure: tray, back wall and neck."""


@dataclass(frozen=True, kw_only=True)
class Mould:
    """The enclosure's mould, parted at z = 0, and what is cast in it."""

    inner_width: float
    inner_height: float
    outer_width: float
    outer_height: float
    """Sections of core and cavity, shrinkage included."""
    casting: float
    """Length of the cavity."""
    core: float
    """Length of the core, held at both ends."""
    length: float
    width: float
    half: float
    """Height of one half."""
    flange: float
    bolts: int
    """Positions of bolts in each flange; those in the middle are keys."""


@dataclass(frozen=True, kw_only=True)
class Lengths:
    """Section 2.1 of the specification and what follows from it [mm]."""

    count: int
    width: float
    thickness: float
    sheet_length: float
    hole: float
    screws: int
    """Screws in each cap."""
    stack: float
    """H = n t."""
    free: float
    """D: from cap to cap."""
    left: Side
    right: Side
    thread: Thread
    screw_length: int
    floor: float
    """f: plastic under the head and under the nut."""
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
    """Width and length of the head that takes the pin."""
    head_height: float
    raised: float
    """z of the air bore's axis: in a thin stack it lies higher, above the tray's floor."""
    port: float
    """Diameter of the port's bore."""
    port_length: float
    inner_width: float
    inner_height: float
    wall: float
    """Wall of the enclosure."""
    sleeve: float
    """Length of the enclosure when trimmed."""
    pin_to_pin: float
    overall: float
    strap: float
    """Longest distance of the pins in use: pin to pin and the usable travel."""
    mould: Mould

    @property
    def sides(self) -> tuple[Side, Side]:
        """Left and right."""
        return self.left, self.right

    @property
    def same_caps(self) -> bool:
        """Whether one cap serves both ends, of all brakes."""
        return np.allclose(self.left.clamped, self.right.clamped, rtol=1e-9, atol=0.0)


def lengths(brake: Brake, build: Build) -> Lengths:
    """All lengths of a build [mm].

    Raises QuantityError for a hole that takes no screw, or for parts that contradict each other,
    CannotBuildError where no screw that is sold is long enough.
    """
    sheets = brake.sheets
    thread, screw, floor, heights = _clamp(brake, build)
    width, stack = mm(sheets.width), _whole(sheets.count) * mm(sheets.thickness)
    clearance = mm(build.sleeve_clearance)
    inner = width + 2 * clearance, stack + 2 * clearance
    girth = 2 * (inner[0] + inner[1])
    flattest = build.tie_tension / mm(build.tie_width) * 1e6
    flattest /= SEAL_MARGIN * ATMOSPHERES * brake.site.atmosphere
    neck_a, neck_b = _neck(width / heights[2], (1 + build.neck_stretch) * girth, flattest)
    bore = M5_BORE if build.port == M5 else mm(float(build.port)) + GLUED
    port_length = bore + 2 * PORT_WALL
    raised = np.maximum(0.0, mm(build.air_bore) / 2 + SPARE - stack / 2)
    head = mm(build.pin) + 2 * mm(build.pin_wall)
    left, right = (_side(brake, build, name) for name in ("left", "right"))
    free = sum(map(mm, (sheets.free_left, sheets.overlap, sheets.free_right)))
    sleeve = free + left.reach + right.reach
    pins = sleeve + 2 * (port_length + head / 2)
    slot = width + 2 * mm(build.side)
    return Lengths(
        count=_whole(sheets.count),
        width=width,
        thickness=mm(sheets.thickness),
        sheet_length=mm(sheets.length),
        hole=mm(brake.mount.screw_hole),
        screws=_whole(brake.mount.screws_across(sheets.width)),
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
        head_height=port_length + 2 * raised,
        raised=raised,
        port=bore,
        port_length=port_length,
        inner_width=inner[0],
        inner_height=inner[1],
        wall=mm(brake.enclosure.wall),
        sleeve=sleeve,
        pin_to_pin=pins,
        overall=pins + head,
        strap=pins + mm(sheets.usable_travel),
        mould=_mould(build, inner, mm(brake.enclosure.wall), sleeve),
    )


def _clamp(brake: Brake, build: Build) -> tuple[Thread, Any, Any, tuple[Any, Any, Any]]:
    """Thread, screw length, floors and heights of plate, shelf and cap; NaN without a screw."""
    hole = mm(brake.mount.screw_hole)
    thread = thread_for(hole)
    if thread is None:
        raise QuantityError.of(
            "mount.screw_hole",
            f"{show(brake.mount.screw_hole, 'm')} takes no screw; at least "
            f"{show(LEAST_SCREW_HOLE, 'm')} is needed for M2",
        )
    stack = _whole(brake.sheets.count) * mm(brake.sheets.thickness)
    least = stack + 2 * mm(build.floor) + thread.nut_height
    screw = sold_length(least, thread)
    if np.ndim(screw) == 0 and np.isnan(screw):
        raise CannotBuildError(
            "screw-length",
            f"a stack {show(stack * 1e-3, 'm')} high needs a screw of {show(least * 1e-3, 'm')}; "
            f"the longest that is drawn is {LENGTHS[-1]} mm: fewer or thinner sheets",
            least * 1e-3,
            LENGTHS[-1] * 1e-3,
        )
    floor = mm(build.floor) + (screw - least) / 2
    room = mm(build.head_room)
    plate, shelf = thread.head_height + room + floor, thread.nut_height + room + floor
    return thread, _whole(screw), floor, (plate, shelf, plate + stack + shelf)


def _side(brake: Brake, build: Build, name: str) -> Side:
    sheets, left = brake.sheets, name == "left"
    many, few = (_whole(sheets.count) + 1) // 2, _whole(sheets.count) // 2
    free = mm(sheets.free_left if left else sheets.free_right)
    clamped = _tidy(mm(sheets.length) - free - mm(sheets.overlap), 13)
    tray = clamped + mm(build.plenum)
    return Side(
        name=name,
        sheets=many if left else few,
        spacers=few if left else many,
        clamped=clamped,
        tray=tray,
        reach=tray + mm(build.back) + mm(build.neck_length),
    )


def _neck(aspect: Any, girth: Any, flattest: float) -> tuple[Any, Any]:
    """Half axes of the ellipse of a given girth, as flat as the cap unless the seal forbids it.

    A tie presses least where the ellipse is flattest, by its tension over its width and the radius
    a²/b there; `flattest` is the greatest such radius [mm] that seals. A shape beyond it becomes so
    much rounder, and round below `ROUND_BELOW`.
    """
    shape = np.clip(aspect, 1.0, FLATTEST)
    shape = np.minimum(shape, flattest * ellipse_girth(1.0, 1 / shape) / girth)
    shape = np.where(shape < ROUND_BELOW, 1.0, shape)
    half = girth / ellipse_girth(1.0, 1 / shape)
    return half, half / shape


def ellipse_girth(a: Any, b: Any) -> Any:
    """Girth of an ellipse of half axes a and b, by the arithmetic-geometric mean.

    Six rounds are exact to rounding for any b from a/100 to a.
    """
    mean, other, rest, weight = a, b, (a * a + b * b) / 2, 0.5
    for _ in range(6):
        half = (mean - other) / 2
        weight *= 2
        rest = rest - weight * half * half
        mean, other = (mean + other) / 2, (mean * other) ** 0.5
    return 2 * np.pi * rest / mean


def _mould(build: Build, inner: tuple[float, float], wall: float, sleeve: float) -> Mould:
    """The mould of an enclosure; its cavity is larger by the shrinkage."""
    grown = 1 + build.shrinkage
    inner_width, inner_height = inner[0] * grown, inner[1] * grown
    outer_width, outer_height = (inner[0] + 2 * wall) * grown, (inner[1] + 2 * wall) * grown
    casting = (sleeve + 2 * mm(build.trim)) * grown
    core = (sleeve + 2 * mm(build.trim) + 2 * mm(build.core_print)) * grown
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
        bolts=_whole(np.maximum(3, spans + 1)),
    )


def nut_overhang(lengths: Lengths) -> Any:
    """Return how far the corner of a nut lies in front of the tray's face [mm]; below 0 behind."""
    shorter = np.minimum(lengths.left.clamped, lengths.right.clamped)
    return lengths.thread.nut / np.sqrt(3) - shorter / 2
