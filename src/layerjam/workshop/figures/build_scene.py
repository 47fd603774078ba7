"""The parts of a build as bodies in space, for its pictures [mm].

The left cap's face is at x = 0, the sheets extend towards +x, and the middle of the stack is at z =
0. The right side is the left side rotated by half a turn about the vertical axis, so that both
plates are on top.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate import cap as caps
from layerjam.workshop.fabricate import jigs, mould
from layerjam.workshop.fabricate.film import film_parts
from layerjam.workshop.fabricate.lengths import Lengths, Side, mm
from layerjam.workshop.fabricate.mesh import make_mesh
from layerjam.workshop.fabricate.outline import Outline
from layerjam.workshop.fabricate.solid import Box, Ellipse, Solid, add, cut, make_solid
from layerjam.workshop.figures.shading import Body

PRINTED, PLATE, STEEL, BRASS = "#8f9bab", "#aab4c0", "#565b63", "#c9a84c"
LEFT, RIGHT, SPACER = "#e3a33b", "#c46a1f", "#f0dfbc"
SILICONE, CORE, TIE = "#86b4d8", "#e3a33b", "#33373d"
BOARD, TUBE = "#d9c7a3", "#dfe7ee"
Ring = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Scene:
    """Build, lengths and outlines of the parts in the pictures."""

    build: Build
    lengths: Lengths
    sheets: tuple[Outline, Outline]
    spacers: tuple[Outline, Outline]
    """Spacers of the left and of the right side, without tolerances."""


def make_scene(build: Build, lengths: Lengths) -> Scene:
    """Return the scene of a build."""
    outlines = {part.name: part.outline for part in film_parts(build, lengths)}

    def find_pair(kind: str) -> tuple[Outline, Outline]:
        if kind in outlines:
            return outlines[kind], outlines[kind]
        return outlines[f"{kind}-left"], outlines[f"{kind}-right"]

    return Scene(build, lengths, find_pair("sheet"), find_pair("spacer"))


def make_body(part: Solid, colour: str) -> Body:
    """Return a solid as a body."""
    surface = make_mesh(part)
    return Body(surface.corners, surface.triangles, colour)


def make_slab(outline: Outline, low: float, high: float, colour: str) -> Body:
    """Return a flat part as a body, from z = `low` to `high`."""
    holes = (_list_points(hole.x, hole.y, -hole.diameter / 2, 40) for hole in outline.holes)
    return _extrude([outline.points(0.05), *holes], low, high, colour)


def _list_points(x: float, y: float, radius: float, count: int) -> Ring:
    """Return points on a circle; a negative radius makes them clockwise, as those of a hole."""
    turns = [2 * math.pi * k / count for k in range(count)]
    return [(x + abs(radius) * math.cos(a), y + radius * math.sin(a)) for a in turns]


def _extrude(rings: Sequence[Ring], low: float, high: float, colour: str) -> Body:
    """Extrude rings upwards; holes are clockwise."""
    from manifold3d import CrossSection, Manifold

    section = CrossSection([np.array(ring) for ring in rings])
    prism = Manifold.extrude(section, high - low).to_mesh64()
    corners = np.asarray(prism.vert_properties, dtype=float)[:, :3]
    triangles = np.asarray(prism.tri_verts, dtype=np.int64)
    return Body(corners + np.array([0, 0, low]), triangles, colour)


def make_cap(world: Scene, side: Side) -> Body:
    """Return a cap in its mounted position."""
    part = make_body(caps.make_cap(world.lengths, world.build, side, "cap"), PRINTED)
    return _place(world, side, part)


def make_plate(world: Scene, side: Side) -> Body:
    """Return a clamp plate in its mounted position."""
    return _place(
        world, side, make_body(caps.make_plate(world.lengths, world.build, side, "plate"), PLATE)
    )


def make_screws(world: Scene, side: Side) -> list[Body]:
    """Return the screws of one cap, each a head and a shank."""
    lengths, thread = world.lengths, world.lengths.thread
    seat = lengths.stack / 2 + lengths.floor
    bodies = []
    for y in caps.screw_positions(lengths, side):
        center = -side.clamped / 2, y
        shank = add("z", seat - lengths.screw_length, seat, Ellipse.circle(center, thread.size))
        head = add("z", seat, seat + thread.head_height, Ellipse.circle(center, thread.head))
        middle = seat + 0.5 * thread.head_height
        key = cut("z", middle, seat + thread.head_height, Ellipse.circle(center, 0.9 * thread.size))
        screw = make_body(make_solid("screw", [shank, head, key]), STEEL)
        bodies.append(_place(world, side, screw))
    return bodies


def make_nuts(world: Scene, side: Side) -> list[Body]:
    """Return the nuts of one cap, each inserted from the front."""
    lengths, thread = world.lengths, world.lengths.thread
    top = -lengths.stack / 2 - lengths.floor
    bodies = []
    for y in caps.screw_positions(lengths, side):
        hexagon = _list_points(-side.clamped / 2, y, thread.nut / math.sqrt(3), 6)
        hole = _list_points(-side.clamped / 2, y, -thread.size / 2, 24)
        nut = _extrude([hexagon, hole], top - thread.nut_height, top, STEEL)
        bodies.append(_place(world, side, nut))
    return bodies


def make_layer(world: Scene, index: int, shift: float = 0.0) -> tuple[Body, Body]:
    """Return the sheet and spacer of a layer, counted from 0 at the bottom, moved up by `shift`."""
    lengths, is_left = world.lengths, index % 2 == 0
    low = -lengths.stack / 2 + index * lengths.thickness + shift
    high = low + lengths.thickness
    side, twin = (lengths.left, lengths.right)[:: 1 if is_left else -1]
    number = 0 if is_left else 1
    sheet = make_slab(world.sheets[number], low, high, LEFT if is_left else RIGHT).shift(
        -side.clamped
    )
    spacer = make_slab(world.spacers[1 - number], low, high, SPACER).shift(-twin.clamped)
    return _place(world, side, sheet), _place(world, twin, spacer)


def make_dowel(world: Scene, side: Side) -> Body:
    """Return the dowel pin of one cap; it is longer than the head is high."""
    lengths, size = world.lengths, mm(world.build.pin)
    end = side.reach + lengths.port_length + lengths.head / 2
    half_length = lengths.head_height / 2 + 6
    pin = make_solid("pin", [add("z", -half_length, half_length, Ellipse.circle((-end, 0), size))])
    return _place(world, side, make_body(pin, STEEL))


def make_jig(world: Scene) -> list[Body]:
    """Return the board below both caps, with its dowels."""
    lengths, build = world.lengths, world.build
    board = jigs.make_jig(lengths.pin_to_pin, caps.pin_hole_diameter(build))
    left_length = lengths.left.reach + lengths.port_length + lengths.head / 2
    ground = -max(lengths.stack / 2 + lengths.shelf_height, lengths.neck_b) - 0.2
    bodies = [make_slab(board, ground - 6, ground, BOARD).shift(-left_length - board.holes[0].x)]
    for x in (-left_length, lengths.pin_to_pin - left_length):
        pin = Ellipse.circle((x, 0), mm(build.pin))
        shank = add("z", ground - 6, lengths.head_height / 2 + 4, pin)
        bodies.append(make_body(make_solid("pin", [shank]), STEEL))
    return bodies


def make_bolts(world: Scene, z: float) -> list[Body]:
    """Return the mould's bolts in their positions, with heads at z = `z`."""
    size = mm(world.build.mould_bolt)
    bodies = []
    for place in mould.bolt_positions(world.lengths)[0]:
        shank = add("z", z - 2 * world.lengths.mould.half, z, Ellipse.circle(place, 0.88 * size))
        head = add("z", z, z + 0.8 * size, Ellipse.circle(place, 1.5 * size))
        bodies.append(make_body(make_solid("bolt", [shank, head]), STEEL))
    return bodies


def make_tube(world: Scene, side: Side) -> Body:
    """Return a piece of tube on a fitting."""
    lengths = world.lengths
    x, face = -(side.reach + lengths.port_length / 2), lengths.head / 2
    ring = add("y", face + 6, face + 24, Ellipse.circle((0, x), max(lengths.port, 2.5)))
    return _place(world, side, make_body(make_solid("tube", [ring]), TUBE))


def make_fitting(world: Scene, side: Side) -> Body:
    """Return a fitting in the port as a plain stub, because its type is the builder's choice."""
    lengths = world.lengths
    x = -(side.reach + lengths.port_length / 2)
    face, size = lengths.head / 2, lengths.port
    rings = [
        add("y", face - 4, face, Ellipse.circle((0, x), size)),
        add("y", face, face + 3, Ellipse.circle((0, x), size + 2.5)),
        add("y", face + 3, face + 9, Ellipse.circle((0, x), max(size - 1, 1.5))),
    ]
    return _place(world, side, make_body(make_solid("fitting", rings), BRASS))


def make_tie(world: Scene, side: Side, gap: float = 0.0) -> Body:
    """Return a cable tie around the neck, `gap` mm above the bottom of the groove."""
    lengths, build = world.lengths, world.build
    depth, wide = mm(build.tie_depth), mm(build.tie_width)
    a, b = lengths.neck_a - depth + gap, lengths.neck_b - depth + gap
    middle = -(side.reach - mm(build.neck_length) / 2)
    ends = middle - wide / 2, middle + wide / 2
    rings = [
        add("x", *ends, Ellipse((0, 0), a + 1.2, b + 1.2)),
        cut("x", *ends, Ellipse((0, 0), a, b)),
        add("x", *ends, Box((-2.4, b + 1.0), (2.4, b + 4.2))),
    ]
    return _place(world, side, make_body(make_solid("tie", rings), TIE))


def make_sleeve(world: Scene) -> Body:
    """Return the trimmed, unstretched enclosure in its position."""
    lengths = world.lengths
    middle = (lengths.free + lengths.right.reach - lengths.left.reach) / 2
    return make_body(mould.make_sleeve(lengths), SILICONE).shift(middle)


def make_mounted_sleeve(world: Scene) -> Body:
    """Return the mounted enclosure: over both trays, tied to both necks, thin where stretched."""
    lengths, build = world.lengths, world.build
    rear, neck = mm(build.back), mm(build.neck_length)
    low = -lengths.stack / 2 - lengths.shelf_height
    high = lengths.stack / 2 + lengths.plate_height
    wall, thin = lengths.wall, 0.7 * lengths.wall
    tray = _box_rings(lengths.tray_width / 2, low, high, thin)
    flat_rings = _box_rings(
        lengths.inner_width / 2, -lengths.inner_height / 2, lengths.inner_height / 2, wall
    )
    oval = _oval_rings(lengths.neck_a, lengths.neck_b, thin)
    slope = min(0.45 * lengths.free, (lengths.cap_height - lengths.inner_height) / 2 + 2)
    ends = []
    for side in lengths.sides:
        tail = side.tray + rear
        steps = [(-tail - 2 * (1 - t), _blend_rings(oval, tray, t)) for t in np.linspace(0, 1, 9)]
        ends.append([(-tail - neck, oval), *steps, (0.0, tray)])
    stations = [*ends[0], (slope, flat_rings), (lengths.free - slope, flat_rings)]
    stations += [(lengths.free - x, ring) for x, ring in ends[1][::-1]]
    return _make_loft(stations)


AROUND = 96
"""Number of points around the enclosure."""
Rings = tuple[NDArray[np.float64], NDArray[np.float64]]


def _box_rings(half: float, low: float, high: float, wall: float) -> Rings:
    """Return the outer and inner points (y, z) around a rectangle."""
    middle, up = (high + low) / 2, (high - low) / 2
    around = np.array([_square_point(k) for k in range(AROUND)])
    outer, inner = (around * (half + w, up + w) + (0, middle) for w in (wall, 0.0))
    return outer, inner


def _oval_rings(a: float, b: float, wall: float) -> Rings:
    """Return the outer and inner points around an ellipse, at the angles of points on a square."""
    around = np.array([_square_point(k) for k in range(AROUND)])
    around /= np.linalg.norm(around, axis=1)[:, None]
    outer, inner = (around * (a + w, b + w) for w in (wall, 0.0))
    return outer, inner


def _blend_rings(first: Rings, second: Rings, share: float) -> Rings:
    outer, inner = (a + (b - a) * share for a, b in zip(first, second, strict=True))
    return outer, inner


def _square_point(k: int) -> tuple[float, float]:
    quarter, part = divmod(k, AROUND // 4)
    t = 2 * part / (AROUND // 4) - 1
    return ((1.0, t), (-t, 1.0), (-1.0, -t), (t, -1.0))[quarter]


def _make_loft(stations: Sequence[tuple[float, Rings]]) -> Body:
    """Return a tube through the rings at given x positions, closed at both ends."""
    count = len(stations)
    corners = [
        np.column_stack([np.full(AROUND, x), rings[layer]])
        for layer in (0, 1)
        for x, rings in stations
    ]
    this = np.arange(AROUND)
    next_index = (this + 1) % AROUND
    triangles = []

    def add_strip(ring: int, next_ring: int) -> None:
        a, b = AROUND * ring, AROUND * next_ring
        triangles.append(np.column_stack([a + this, b + next_index, a + next_index]))
        triangles.append(np.column_stack([a + this, b + this, b + next_index]))

    for i in range(count - 1):
        add_strip(i + 1, i)
        add_strip(count + i, count + i + 1)
    add_strip(0, count)
    add_strip(2 * count - 1, count - 1)
    return Body(np.concatenate(corners), np.concatenate(triangles).astype(np.int64), SILICONE)


def make_mould(world: Scene) -> dict[str, Body]:
    """Return both halves of the mould, and the core, in their positions in the closed mould."""
    build, lengths = world.build, world.lengths
    return {
        "top": make_body(mould.make_top(lengths, build), PRINTED),
        "core": make_body(mould.make_core(lengths), CORE),
        "bottom": make_body(mould.make_bottom(lengths, build), PRINTED),
    }


def _place(world: Scene, side: Side, part: Body) -> Body:
    """Return a body of one side, given the body of the left side."""
    return part if side.name == "left" else part.turn(world.lengths.free)
