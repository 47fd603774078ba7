"""Pictures of a build for the person who assembles it: exploded, stacking, mould, assembled."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from layerjam.core.drawing import style
from layerjam.workshop.fabricate import mould
from layerjam.workshop.fabricate.lengths import Side
from layerjam.workshop.figures import build_scene as parts
from layerjam.workshop.figures.build_scene import Scene
from layerjam.workshop.figures.shading import Body, Shot, View, render_bodies

Point = tuple[float, float, float]


class Label(NamedTuple):
    """A label, the body or point in space that it labels, and whether it is above the picture."""

    words: str
    target: Body | Point
    above: bool | None = None

    def locate(self, shot: Shot) -> tuple[float, float]:
        """Return the target's column and row in a picture; for a body, those of a visible point."""
        if isinstance(self.target, Body):
            return shot.find_middle(self.target) or shot.project(_body_centre(self.target))
        return shot.project(self.target)


LabelledShot = tuple[Shot, list[Label]]
SHOWN = 12
"""Largest number of layers in the stacking picture; middle ones are omitted."""
_LETTER = 0.062
"""Width of one character in a label [in]."""


def make_shots(world: Scene) -> dict[str, LabelledShot]:
    """Return {picture: (shot, labels of its parts)}."""
    makers: Mapping[str, Callable[[Scene], LabelledShot]] = {
        "exploded": _draw_exploded,
        "stacking": _draw_stacking,
        "mould": _draw_mould,
        "assembled": _draw_assembled,
    }
    return {name: make(world) for name, make in makers.items()}


def _body_centre(body: Body) -> Point:
    low, high = body.corners.min(axis=0), body.corners.max(axis=0)
    x, y, z = (low + high) / 2
    return float(x), float(y), float(z)


def separate_parts(world: Scene) -> dict[str, list[Body]]:
    """Return {name: bodies} of every part of one brake, separated, on both sides."""
    lengths = world.lengths
    out = 0.35 * lengths.free + 20
    lift = lengths.cap_height + 8
    bodies_by_kind: dict[str, list[Body]] = {}
    fan = min(4.0, 36 / lengths.count)
    for index in range(lengths.count):
        height = (index - (lengths.count - 1) / 2) * fan
        sheet, spacer = parts.make_layer(world, index, height)
        sign, word = (-1, "left") if index % 2 == 0 else (1, "right")
        bodies_by_kind.setdefault(f"{word} sheet", []).append(sheet.shift(sign * out * 0.35))
        bodies_by_kind.setdefault("spacer", []).append(spacer.shift(-sign * out * 0.62))
    for side in lengths.sides:
        for name, body in _separate_side(world, side, -1 if side.name == "left" else 1, out, lift):
            bodies_by_kind.setdefault(name, []).append(body)
    below = -(lengths.count * fan / 2 + lengths.cap_height + 12)
    bodies_by_kind["enclosure"] = [parts.make_sleeve(world).shift(z=below)]
    return bodies_by_kind


def _draw_exploded(world: Scene) -> LabelledShot:
    bodies_by_kind = separate_parts(world)
    shot = render_bodies([body for bodies in bodies_by_kind.values() for body in bodies])
    (tube,) = bodies_by_kind["enclosure"]
    points = [Label("enclosure", tube)]
    for name, bodies in bodies_by_kind.items():
        # of identical parts, label the first one that is clearly visible
        if "sheet" not in name and name != "enclosure":
            areas = [int(shot.visible_mask(body).sum()) for body in bodies]
            first = next(i for i, area in enumerate(areas) if area >= 0.5 * max(areas))
            points.append(Label(name, bodies[first]))
    # the other sheets hide the middle of a sheet, but its free end is visible
    for word, side in (("left", -1), ("right", 1)):
        corners = bodies_by_kind[f"{word} sheet"][-1].corners
        x = corners[:, 0].min() + 12 if side < 0 else corners[:, 0].max() - 12
        top = float(corners[:, 2].max())
        points.append(Label(f"{word} sheets", (float(x), 0.0, top), True))
    return shot, points


def _separate_side(
    world: Scene, side: Side, sign: int, out: float, lift: float
) -> Iterator[tuple[str, Body]]:
    """Return printed and bought parts of one side, separated; `sign` points outwards."""
    yield "cap", parts.make_cap(world, side).shift(sign * out)
    yield "clamp plate", parts.make_plate(world, side).shift(sign * out, z=lift)
    for screw in parts.make_screws(world, side):
        yield "screw", screw.shift(sign * out, z=2 * lift)
    for nut in parts.make_nuts(world, side):
        yield "nut", nut.shift(sign * (out - 14), z=-lift)
    yield "dowel", parts.make_dowel(world, side).shift(sign * out, z=1.6 * lift)
    yield "fitting", parts.make_fitting(world, side).shift(sign * out, y=-sign * 18.0)
    yield "cable tie", parts.make_tie(world, side, 1.2).shift(sign * (out - 6), z=-1.7 * lift)


def _draw_stacking(world: Scene) -> LabelledShot:
    """Draw the left clamp with its layers spread, cut off at the start of the overlap."""
    lengths = world.lengths
    side = lengths.left
    length = min(lengths.sheet_length, side.clamped + 2.2 * max(lengths.width, 12))
    begin = lengths.free + lengths.right.clamped - lengths.sheet_length
    length = max(length, min(lengths.sheet_length, side.clamped + begin + 12))
    short_sheet = replace(world.sheets[0], length=length, end=0.0)
    bodies, targets = [parts.make_cap(world, side)], dict[str, Body | Point]()
    fan = min(1.6, 22 / lengths.count) + lengths.thickness
    layers = _select_layers(lengths.count)
    for place, index in enumerate(layers):
        low = -lengths.stack / 2 + place * fan
        high = low + lengths.thickness
        if index % 2 == 0:
            bodies.append(parts.make_slab(short_sheet, low, high, parts.LEFT).shift(-side.clamped))
            edge = length - side.clamped - 3
            targets["left sheet"] = (edge, -lengths.width / 2, (low + high) / 2)
        else:
            spacer = parts.make_slab(world.spacers[0], low, high, parts.SPACER)
            bodies.append(spacer.shift(-side.clamped))
            tip = replace(world.sheets[1], holes=(), start=world.sheets[1].end, end=0.0)
            right = replace(tip, length=max(length - side.clamped - begin, 4.0))
            bodies.append(parts.make_slab(right, low, high, parts.RIGHT).shift(begin))
            level = (low + high) / 2
            targets["spacer"] = (-1.0, -lengths.width / 2, level)
            targets["right sheet"] = (begin + 3, -lengths.width / 2, level)
    top = -lengths.stack / 2 + len(layers) * fan
    rise = top - lengths.stack / 2 + 8
    bodies.append(parts.make_plate(world, side).shift(z=rise))
    bodies += [
        screw.shift(z=rise + lengths.screw_length) for screw in parts.make_screws(world, side)
    ]
    bodies += [nut.shift(x=side.clamped + 4, z=-1) for nut in parts.make_nuts(world, side)]
    targets["clamp plate"] = bodies[-2 * lengths.screws - 1]
    targets["screw"] = bodies[-lengths.screws - 1]
    targets["nut, slid in from the front"] = bodies[-lengths.screws]
    targets["cap"] = bodies[0]
    return render_bodies(bodies, View(-58, 24), width=1000), [
        Label(*item) for item in targets.items()
    ]


def _select_layers(count: int) -> list[int]:
    """Return the layers to draw: all, or only the lowest and highest ones of a thick stack."""
    if count <= SHOWN:
        return list(range(count))
    return [*range(SHOWN // 2), *range(count - SHOWN // 2, count)]


def separate_mould(world: Scene) -> dict[str, Body]:
    """Return both halves ("top", "bottom") and the "core", separated."""
    tools, lift = parts.make_mould(world), _mould_lift(world)
    return tools | {"top": tools["top"].shift(z=2 * lift), "core": tools["core"].shift(z=lift)}


def _mould_lift(world: Scene) -> float:
    return 1.2 * world.lengths.mould.half + 14


def _draw_mould(world: Scene) -> LabelledShot:
    lengths, tools = world.lengths, separate_mould(world)
    top, core = tools["top"], tools["core"]
    roof = 2 * _mould_lift(world) + lengths.mould.half
    (low, sprue), *vents = mould.vent_positions(lengths, world.build)
    bolts, keys = mould.bolt_positions(lengths)
    bodies = parts.make_bolts(world, roof + 12 + 2 * lengths.mould.half)
    points = [
        Label("upper half", (0.0, 0.0, roof)),
        Label("core", core),
        Label("lower half", (-0.3 * lengths.mould.length, -lengths.mould.width / 2, -3.0)),
        Label(f"sprue {sprue:g} mm", (*low, roof)),
        Label(f"vents {vents[0][1]:g} mm", (*vents[0][0], roof), True),
        Label("key", (*keys[0], 4.0)),
        Label(f"{len(bolts)} bolts with nuts", bodies[0]),
    ]
    return render_bodies([top, core, tools["bottom"], *bodies], View(-62, 32)), points


def _draw_assembled(world: Scene) -> LabelledShot:
    """Draw the brake without its enclosure, and below it the complete brake."""
    lengths = world.lengths
    parts_without_sleeve: list[Body] = []
    for side in lengths.sides:
        parts_without_sleeve += [parts.make_cap(world, side), parts.make_plate(world, side)]
        parts_without_sleeve += [*parts.make_screws(world, side), *parts.make_nuts(world, side)]
    for index in range(lengths.count):
        parts_without_sleeve += parts.make_layer(world, index)
    board = parts.make_jig(world)
    parts_without_sleeve += board
    lift = lengths.cap_height + 0.3 * lengths.free + 14
    outer = [
        body
        for side in lengths.sides
        for body in (
            parts.make_cap(world, side),
            parts.make_dowel(world, side),
            parts.make_fitting(world, side),
            parts.make_tie(world, side, 0.7 * lengths.wall),
        )
    ]
    tube = parts.make_tube(world, lengths.right)
    end = board[0].corners[:, 0].min(), board[0].corners[:, 1].min(), board[0].corners[:, 2].mean()
    points = [
        Label("jig", (float(end[0]) + 4, float(end[1]), lift + float(end[2]))),
        Label("stack in its clamps", (0.4 * lengths.free, 0.0, lift + lengths.stack / 2)),
        Label("groove for the tie", (-lengths.left.reach + 4, 0.0, lift + lengths.neck_b)),
        Label("enclosure", (0.55 * lengths.free, -lengths.width / 2, 0.0)),
        Label("cable tie", outer[-1]),
        Label("dowel", outer[-3]),
        Label("fitting", outer[-2]),
        Label("tube", tube),
    ]
    upper = [body.shift(z=lift) for body in parts_without_sleeve]
    return render_bodies([*upper, parts.make_mounted_sleeve(world), *outer, tube]), points


@style.use_style
def add_labels(shot: Shot, points: Sequence[Label], width: float = 8.2) -> style.Figure:
    """Add the names of a picture's parts above and below it, each with a line to its part."""
    rows, columns, _ = shot.pixels.shape
    strip = 0.3
    tall = width * rows / columns
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, tall + 2 * strip))
    height = tall + 2 * strip
    axes = figure.add_axes((0, strip / height, 1, tall / height))
    axes.imshow(shot.pixels, interpolation="none", aspect="equal")
    style.hide_axes(axes)
    upper: list[tuple[str, float, float]] = []
    lower: list[tuple[str, float, float]] = []
    for label in points:
        x, y = label.locate(shot)
        higher = y <= rows / 2 if label.above is None else label.above
        (upper if higher else lower).append((label.words, x, y))
    inch = columns / width
    for group, level, va in ((upper, -0.08 * inch, "bottom"), (lower, rows + 0.08 * inch, "top")):
        for (words, x, y), place in _spread_labels(group, inch, columns):
            style.add_leader(axes, words, (x, y), (place, level), va, annotation_clip=False)
            axes.plot(x, y, "o", ms=2.2, color=style.INK)
    axes.set(xlim=(0, columns), ylim=(rows, 0))
    return figure


def _spread_labels(
    group: Sequence[tuple[str, float, float]], inch: float, columns: int
) -> list[tuple[tuple[str, float, float], float]]:
    """Return the position of each label of a row: above its part, or next to another label."""
    labels = sorted(group, key=lambda p: p[1])
    half_widths = [inch * _LETTER * (len(words) + 2) / 2 for words, _, _ in labels]
    spots = [max(x, h) for (_, x, _), h in zip(labels, half_widths, strict=True)]
    for i in range(1, len(spots)):
        spots[i] = max(spots[i], spots[i - 1] + half_widths[i - 1] + half_widths[i])
    for i in range(len(spots) - 1, -1, -1):
        limit = (
            columns - half_widths[i]
            if i == len(spots) - 1
            else spots[i + 1] - half_widths[i + 1] - half_widths[i]
        )
        spots[i] = min(spots[i], limit)
    return list(zip(labels, spots, strict=True))
