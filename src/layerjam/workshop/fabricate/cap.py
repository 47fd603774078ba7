"""The cap and its clamp plate (section 2.3 of the specification) [mm].

The face of the cap is at x = 0, and the sheets extend towards +x; the middle of the stack is at z =
0, with the plate above it.
"""

import functools
import math
from collections.abc import Iterator

from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate.lengths import Lengths, Side, mm
from layerjam.workshop.fabricate.outline import clamp_holes
from layerjam.workshop.fabricate.solid import Box, Ellipse, Prism, Solid, add, cut, make_solid


def screw_positions(lengths: Lengths, side: Side) -> list[float]:
    """Return the y coordinate of every screw, which is also that of its hole in the sheets [mm]."""
    row = clamp_holes(side.clamped, lengths.width, lengths.screws, lengths.hole)
    return [hole.y for hole in row]


def make_cap(lengths: Lengths, build: Build, side: Side, name: str) -> Solid:
    """Return the cap of one side: tray, neck with groove, and head with port and pin."""
    back_depth, neck = side.tray + mm(build.back), mm(build.neck_length)
    end = back_depth + neck
    port = end + lengths.port_length / 2
    prisms = [
        *_make_tray(lengths, build, side),
        *_make_neck(lengths, build, back_depth),
        *_make_head(lengths, build, end),
    ]
    axis_height, half_width = lengths.air_axis, lengths.head / 2
    bore = mm(build.air_bore)
    free = mm(build.back) + neck + lengths.port_length / 2
    prisms += [
        cut("x", -port, -side.tray, Ellipse.circle((0, axis_height), bore)),
        cut("y", 0, half_width, Ellipse.circle((axis_height, -port), lengths.port)),
    ]
    return make_solid(name, prisms, shared_volume(bore / 2, lengths.port / 2, free))


def _make_tray(lengths: Lengths, build: Build, side: Side) -> Iterator[Prism]:
    """Yield the tray for sheets and plate, with nut pockets and screw holes."""
    top = lengths.stack / 2 + lengths.plate_height
    bottom = -lengths.stack / 2 - lengths.shelf_height
    width, slot = lengths.tray_width / 2, lengths.slot / 2
    block = Box((-width, bottom), (width, top), mm(build.edge))
    yield add("x", -side.tray - mm(build.back), 0, block)
    yield cut("x", -side.tray, 0, Box((-slot, -lengths.stack / 2), (slot, top)))
    nut = lengths.thread.nut + mm(build.fit)
    ceiling = bottom + lengths.thread.nut_height + mm(build.head_room)
    for y in screw_positions(lengths, side):
        pocket = Box((y - nut / 2, bottom), (y + nut / 2, ceiling))
        yield cut("x", -side.clamped / 2 - nut / math.sqrt(3), 0, pocket)
        hole = Ellipse.circle((-side.clamped / 2, y), lengths.thread.clearance)
        yield cut("z", ceiling, -lengths.stack / 2, hole)


def _make_neck(lengths: Lengths, build: Build, back_wall: float) -> Iterator[Prism]:
    """Yield the round neck for the cable tie: two collars and a groove between them."""
    length, slot, depth = mm(build.neck_length), mm(build.tie_slot), mm(build.tie_depth)
    a, b = lengths.neck_a, lengths.neck_b
    first, last = -back_wall - (length + slot) / 2, -back_wall - (length - slot) / 2
    yield add("x", -back_wall - length, first, Ellipse((0, 0), a, b))
    yield add("x", first, last, Ellipse((0, 0), a - depth, b - depth))
    yield add("x", last, -back_wall, Ellipse((0, 0), a, b))


def _make_head(lengths: Lengths, build: Build, end: float) -> Iterator[Prism]:
    length, side, height = lengths.port_length + lengths.head, lengths.head, lengths.head_height
    yield add("x", -end - length, -end, Box.from_centre((0, 0), side, height, mm(build.edge)))
    pin = Ellipse.circle((-end - lengths.port_length - side / 2, 0), pin_hole_diameter(build))
    yield cut("z", -height / 2, height / 2, pin)


def pin_hole_diameter(build: Build) -> float:
    """Return the diameter of the hole for the dowel pin."""
    return mm(build.pin) + mm(build.pin_clearance)


@functools.lru_cache(maxsize=256)
def shared_volume(bore: float, port: float, length: float) -> float:
    """Return the volume [mm³] shared by the air bore and the port, which ends at the bore's axis.

    `bore` and `port` are radii. The volume is the integral of u·min(v, length) over the bore's
    height, where u and v are the half widths of bore and port. The quadrature is Gauss-Chebyshev.
    """
    count = 256
    total = 0.0
    for k in range(1, count + 1):
        angle = k * math.pi / (count + 1)
        half_chord = math.sqrt(port**2 - (bore * math.cos(angle)) ** 2)
        total += math.sin(angle) ** 2 * min(half_chord, length)
    return bore**2 * math.pi / (count + 1) * total


def make_plate(lengths: Lengths, build: Build, side: Side, name: str) -> Solid:
    """Return one side's clamp plate, with a channel from front to back for each screw head."""
    fit, thread = mm(build.fit), lengths.thread
    low, high = lengths.stack / 2, lengths.stack / 2 + lengths.plate_height
    half_width, depth = lengths.slot / 2 - fit, -(side.tray - fit)
    prisms = [add("x", depth, 0, Box((-half_width, low), (half_width, high)))]
    head, floor = thread.head + fit, low + lengths.floor
    for y in screw_positions(lengths, side):
        prisms.append(cut("x", depth, 0, Box((y - head / 2, floor), (y + head / 2, high))))
        hole = Ellipse.circle((-side.clamped / 2, y), thread.clearance)
        prisms.append(cut("z", low, floor, hole))
    return make_solid(name, prisms)
