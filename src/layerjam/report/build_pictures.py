"""Pictures of a build for whoever holds the parts: exploded, stacking, mould, assembled."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from layerjam.fabricate import mould
from layerjam.fabricate.lengths import Side
from layerjam.report import build_scene as parts
from layerjam.report import style
from layerjam.report.build_scene import Scene
from layerjam.report.shading import Body, Shot, View, shoot

Point = tuple[float, float, float]


class Label(NamedTuple):
    """Words, the body or the point in space that they name, and whether they stand above."""

    words: str
    what: Body | Point
    above: bool | None = None

    def place(self, shot: Shot) -> tuple[float, float]:
        """Column and row in a picture: of a body, where it is seen."""
        if isinstance(self.what, Body):
            return shot.where(self.what) or shot.place(_middle(self.what))
        return shot.place(self.what)


Seen = tuple[Shot, list[Label]]
SHOWN = 12
"""Layers of the stacking picture; of more the middle ones are left out."""
_LETTER = 0.062
"""Width of a letter in a label [in]."""


def shots(world: Scene) -> dict[str, Seen]:
    """{picture: (what is seen, (words, the point they name) of each part)}."""
    makers: Mapping[str, Callable[[Scene], Seen]] = {
        "exploded": _exploded,
        "stacking": _stacking,
        "mould": _mould,
        "assembled": _assembled,
    }
    return {name: make(world) for name, make in makers.items()}


def _middle(body: Body) -> Point:
    low, high = body.corners.min(axis=0), body.corners.max(axis=0)
    x, y, z = (low + high) / 2
    return float(x), float(y), float(z)


def exploded(world: Scene) -> dict[str, list[Body]]:
    """{name: bodies} of every part of one brake, apart, on both sides."""
    lengths = world.lengths
    out = 0.35 * lengths.free + 20
    lift = lengths.cap_height + 8
    alike: dict[str, list[Body]] = {}
    fan = min(4.0, 36 / lengths.count)
    for index in range(lengths.count):
        raised = (index - (lengths.count - 1) / 2) * fan
        sheet, spacer = parts.layer(world, index, raised)
        own, word = (-1, "left") if index % 2 == 0 else (1, "right")
        alike.setdefault(f"{word} sheet", []).append(sheet.moved(own * out * 0.35))
        alike.setdefault("spacer", []).append(spacer.moved(-own * out * 0.62))
    for side in lengths.sides:
        for name, body in _of_side(world, side, -1 if side.name == "left" else 1, out, lift):
            alike.setdefault(name, []).append(body)
    below = -(lengths.count * fan / 2 + lengths.cap_height + 12)
    alike["enclosure"] = [parts.sleeve(world).moved(z=below)]
    return alike


def _exploded(world: Scene) -> Seen:
    """Every part of one brake with its name."""
    alike = exploded(world)
    shot = shoot([body for some in alike.values() for body in some])
    (tube,) = alike["enclosure"]
    points = [Label("enclosure", tube)]
    for name, some in alike.items():
        if "sheet" not in name and name != "enclosure":  # of equal parts the first one seen well
            shown = [int(shot.seen(body).sum()) for body in some]
            first = next(i for i, area in enumerate(shown) if area >= 0.5 * max(shown))
            points.append(Label(name, some[first]))
    # the middle of a sheet lies under the others: its free end is seen
    for word, at in (("left", -1), ("right", 1)):
        corners = alike[f"{word} sheet"][-1].corners
        x = corners[:, 0].min() + 12 if at < 0 else corners[:, 0].max() - 12
        top = float(corners[:, 2].max())
        points.append(Label(f"{word} sheets", (float(x), 0.0, top), True))
    return shot, points


def _of_side(
    world: Scene, side: Side, sign: int, out: float, lift: float
) -> Iterator[tuple[str, Body]]:
    """Printed and bought parts of one side, apart; `sign` points outwards."""
    yield "cap", parts.cap(world, side).moved(sign * out)
    yield "clamp plate", parts.plate(world, side).moved(sign * out, z=lift)
    for screw in parts.screws(world, side):
        yield "screw", screw.moved(sign * out, z=2 * lift)
    for nut in parts.nuts(world, side):
        yield "nut", nut.moved(sign * (out - 14), z=-lift)
    yield "dowel", parts.dowel(world, side).moved(sign * out, z=1.6 * lift)
    yield "fitting", parts.fitting(world, side).moved(sign * out, y=-sign * 18.0)
    yield "cable tie", parts.tie(world, side, 1.2).moved(sign * (out - 6), z=-1.7 * lift)


def _stacking(world: Scene) -> Seen:
    """The left clamp with its layers spread, cut off beyond the begin of the overlap."""
    lengths = world.lengths
    side = lengths.left
    seen = min(lengths.sheet_length, side.clamped + 2.2 * max(lengths.width, 12))
    begin = lengths.free + lengths.right.clamped - lengths.sheet_length
    seen = max(seen, min(lengths.sheet_length, side.clamped + begin + 12))
    short = replace(world.sheets[0], length=seen, end=0.0)
    bodies, named = [parts.cap(world, side)], dict[str, Body | Point]()
    fan = min(1.6, 22 / lengths.count) + lengths.thickness
    shown = _shown(lengths.count)
    for place, index in enumerate(shown):
        low = -lengths.stack / 2 + place * fan
        high = low + lengths.thickness
        if index % 2 == 0:
            bodies.append(parts.slab(short, low, high, parts.LEFT).moved(-side.clamped))
            edge = seen - side.clamped - 3
            named["left sheet"] = (edge, -lengths.width / 2, (low + high) / 2)
        else:
            spacer = parts.slab(world.spacers[0], low, high, parts.SPACER)
            bodies.append(spacer.moved(-side.clamped))
            tip = replace(world.sheets[1], holes=(), start=world.sheets[1].end, end=0.0)
            other = replace(tip, length=max(seen - side.clamped - begin, 4.0))
            bodies.append(parts.slab(other, low, high, parts.RIGHT).moved(begin))
            level = (low + high) / 2
            named["spacer"] = (-1.0, -lengths.width / 2, level)
            named["right sheet"] = (begin + 3, -lengths.width / 2, level)
    top = -lengths.stack / 2 + len(shown) * fan
    rise = top - lengths.stack / 2 + 8
    bodies.append(parts.plate(world, side).moved(z=rise))
    bodies += [screw.moved(z=rise + lengths.screw_length) for screw in parts.screws(world, side)]
    bodies += [nut.moved(x=side.clamped + 4, z=-1) for nut in parts.nuts(world, side)]
    named["clamp plate"] = bodies[-2 * lengths.screws - 1]
    named["screw"] = bodies[-lengths.screws - 1]
    named["nut, slid in from the front"] = bodies[-lengths.screws]
    named["cap"] = bodies[0]
    return shoot(bodies, View(-58, 24), width=1000), [Label(*each) for each in named.items()]


def _shown(count: int) -> list[int]:
    """Layers of a picture: all, or the lowest and highest ones of a thick stack."""
    if count <= SHOWN:
        return list(range(count))
    return [*range(SHOWN // 2), *range(count - SHOWN // 2, count)]


def mould_apart(world: Scene) -> dict[str, Body]:
    """Both halves ("top", "bottom") and the "core", apart."""
    found, lift = parts.tools(world), _mould_lift(world)
    return found | {
        "top": found["top"].moved(z=2 * lift),
        "core": found["core"].moved(z=lift),
    }


def _mould_lift(world: Scene) -> float:
    return 1.2 * world.lengths.mould.half + 14


def _mould(world: Scene) -> Seen:
    """The mould and its bolts, apart."""
    lengths, found = world.lengths, mould_apart(world)
    top, core = found["top"], found["core"]
    roof = 2 * _mould_lift(world) + lengths.mould.half
    (low, sprue), *vents = mould.openings(lengths, world.build)
    bolts, keys = mould.places(lengths)
    raised = parts.bolts(world, roof + 12 + 2 * lengths.mould.half)
    points = [
        Label("upper half", (0.0, 0.0, roof)),
        Label("core", core),
        Label("lower half", (-0.3 * lengths.mould.length, -lengths.mould.width / 2, -3.0)),
        Label(f"sprue {sprue:g} mm", (*low, roof)),
        Label(f"vents {vents[0][1]:g} mm", (*vents[0][0], roof), True),
        Label("key", (*keys[0], 4.0)),
        Label(f"{len(bolts)} bolts with nuts", raised[0]),
    ]
    return shoot([top, core, found["bottom"], *raised], View(-62, 32)), points


def _assembled(world: Scene) -> Seen:
    """The brake without its enclosure, and below with it, ties, fittings and dowels."""
    lengths = world.lengths
    bare: list[Body] = []
    for side in lengths.sides:
        bare += [parts.cap(world, side), parts.plate(world, side)]
        bare += [*parts.screws(world, side), *parts.nuts(world, side)]
    for index in range(lengths.count):
        bare += parts.layer(world, index)
    board = parts.jig(world)
    bare += board
    lift = lengths.cap_height + 0.3 * lengths.free + 14
    worn = [
        body
        for side in lengths.sides
        for body in (
            parts.cap(world, side),
            parts.dowel(world, side),
            parts.fitting(world, side),
            parts.tie(world, side, 0.7 * lengths.wall),
        )
    ]
    tube = parts.tube(world, lengths.right)
    end = board[0].corners[:, 0].min(), board[0].corners[:, 1].min(), board[0].corners[:, 2].mean()
    points = [
        Label("jig", (float(end[0]) + 4, float(end[1]), lift + float(end[2]))),
        Label("stack in its clamps", (0.4 * lengths.free, 0.0, lift + lengths.stack / 2)),
        Label("groove for the tie", (-lengths.left.reach + 4, 0.0, lift + lengths.neck_b)),
        Label("enclosure", (0.55 * lengths.free, -lengths.width / 2, 0.0)),
        Label("cable tie", worn[-1]),
        Label("dowel", worn[-3]),
        Label("fitting", worn[-2]),
        Label("tube", tube),
    ]
    seen = [body.moved(z=lift) for body in bare]
    return shoot([*seen, parts.mounted_sleeve(world), *worn, tube]), points


@style.styled
def labelled(shot: Shot, points: Sequence[Label], width: float = 8.2) -> style.Figure:
    """A picture with the names of its parts above and below, each with a line to its part."""
    rows, columns, _ = shot.pixels.shape
    strip = 0.3
    tall = width * rows / columns
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, tall + 2 * strip))
    whole = tall + 2 * strip
    axes = figure.add_axes((0, strip / whole, 1, tall / whole))
    axes.imshow(shot.pixels, interpolation="none", aspect="equal")
    style.bare(axes)
    upper: list[tuple[str, float, float]] = []
    lower: list[tuple[str, float, float]] = []
    for label in points:
        x, y = label.place(shot)
        higher = y <= rows / 2 if label.above is None else label.above
        (upper if higher else lower).append((label.words, x, y))
    inch = columns / width
    for group, level, va in ((upper, -0.08 * inch, "bottom"), (lower, rows + 0.08 * inch, "top")):
        for (words, x, y), at in _spread(group, inch, columns):
            axes.annotate(
                words,
                (x, y),
                (at, level),
                ha="center",
                va=va,
                fontsize=style.WORDS,
                annotation_clip=False,
                arrowprops={"arrowstyle": "-", "color": style.INK, "lw": 0.6, "shrinkB": 0},
            )
            axes.plot(x, y, "o", ms=2.2, color=style.INK)
    axes.set(xlim=(0, columns), ylim=(rows, 0))
    return figure


def _spread(
    group: Sequence[tuple[str, float, float]], inch: float, columns: int
) -> list[tuple[tuple[str, float, float], float]]:
    """Where each label of a row stands: over its part, or beside its neighbour."""
    ordered = sorted(group, key=lambda p: p[1])
    half = [inch * _LETTER * (len(words) + 2) / 2 for words, _, _ in ordered]
    at = [max(x, h) for (_, x, _), h in zip(ordered, half, strict=True)]
    for i in range(1, len(at)):
        at[i] = max(at[i], at[i - 1] + half[i - 1] + half[i])
    for i in range(len(at) - 1, -1, -1):
        most = columns - half[i] if i == len(at) - 1 else at[i + 1] - half[i + 1] - half[i]
        at[i] = min(at[i], most)
    return list(zip(ordered, at, strict=True))
