"""Flat drawings of a build: the section of a cap with its dimensions, the layers, the film [mm]."""

from collections.abc import Sequence
from typing import Any

from layerjam.core.drawing import style
from layerjam.core.drawing.style import GREY, INK, Axes
from layerjam.workshop.fabricate.lengths import Lengths, mm
from layerjam.workshop.fabricate.nest import Piece
from layerjam.workshop.fabricate.outline import Outline
from layerjam.workshop.figures.build_scene import (
    BOARD,
    LEFT,
    PLATE,
    PRINTED,
    RIGHT,
    SILICONE,
    SPACER,
    STEEL,
    Scene,
)

SHOWN = 14
"""Largest number of layers in the drawing; middle layers of thicker stacks are omitted."""
_LETTER = 0.066
"""Width of one character in a dimension's label [in]."""
Part = tuple[str, float, float]


def _draw_box(
    axes: Axes, x: tuple[float, float], z: tuple[float, float], color: str, **options: Any
) -> None:
    from matplotlib.patches import Rectangle

    options = {"facecolor": color, "edgecolor": INK, "lw": 0.7, **options}
    axes.add_patch(Rectangle((x[0], z[0]), x[1] - x[0], z[1] - z[0], **options))


def _draw_circle(axes: Axes, center: tuple[float, float], size: float, lw: float = 0.7) -> None:
    from matplotlib.patches import Circle

    axes.add_patch(Circle(center, size / 2, facecolor="white", edgecolor=INK, lw=lw))


def _write(
    axes: Axes, x: float, y: float, text: str, ha: str, va: str = "center", **options: Any
) -> None:
    axes.text(x, y, text, ha=ha, va=va, **{"fontsize": style.WORDS, **options})


def _make_figure(
    low: tuple[float, float], high: tuple[float, float], width: float
) -> tuple[Any, Axes]:
    """Return a figure without a frame, with the same scale on both axes; `width` is in inches."""
    from matplotlib.figure import Figure

    wide, height = high[0] - low[0], high[1] - low[1]
    figure = Figure(figsize=(width, width * height / wide))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    style.hide_axes(axes)
    return figure, axes


@style.use_style
def draw_section(world: Scene) -> style.Figure:
    """Draw a section of the left cap through a screw's axis, to scale, with dimensions in mm."""
    lengths, build, side = world.lengths, world.build, world.lengths.left
    neck, rear = -side.reach, -side.tray - mm(build.back)
    end = neck - lengths.port_length - lengths.head
    free = world.lengths.free + lengths.right.clamped - lengths.sheet_length
    edge = free + 6
    top = lengths.stack / 2 + lengths.plate_height
    low = -lengths.stack / 2 - lengths.shelf_height
    bottom_edge = min(low, -lengths.head_height / 2, -lengths.neck_b) - lengths.wall
    top_edge = max(top, lengths.head_height / 2, lengths.neck_b) + lengths.wall
    unit = (edge - end) / 62
    figure, axes = _make_figure(
        (end - 12 * unit, bottom_edge - 12 * unit), (edge + 14 * unit, top_edge + 7 * unit), 8.2
    )
    _draw_enclosure(axes, world, edge)
    _draw_printed_parts(axes, world)
    _draw_layers(axes, lengths, edge, free)
    _draw_screw(axes, lengths)
    chain = [
        ("head", end, neck - lengths.port_length),
        ("port", neck - lengths.port_length, neck),
        ("neck", neck, rear),
        ("back", rear, -side.tray),
        ("air", -side.tray, -side.clamped),
        ("clamp", -side.clamped, 0.0),
        ("free", 0.0, free),
    ]
    _draw_dimension_chain(axes, chain, bottom_edge - 2.5 * unit, unit)
    stack = lengths.stack / 2
    _draw_heights(
        axes,
        edge + 2 * unit,
        [("plate", stack, top), ("stack", -stack, stack), ("shelf", low, -stack)],
        unit,
    )
    half_height = lengths.head_height / 2
    _draw_heights(axes, end - 2 * unit, [("head", -half_height, half_height)], -unit)
    _draw_names(axes, world, top_edge, unit, edge)
    return figure


def _draw_printed_parts(axes: Axes, world: Scene) -> None:
    lengths, build, side = world.lengths, world.build, world.lengths.left
    rear, neck = -side.tray - mm(build.back), -side.reach
    head = neck - lengths.port_length - lengths.head
    stack, thread = lengths.stack / 2, lengths.thread
    top, low = stack + lengths.plate_height, -stack - lengths.shelf_height
    half_height, b = lengths.head_height / 2, lengths.neck_b
    _draw_box(axes, (head, neck), (-half_height, half_height), PRINTED)
    pin = neck - lengths.port_length - lengths.head / 2
    bore = (mm(build.pin) + mm(build.pin_clearance)) / 2
    _draw_box(axes, (pin - bore, pin + bore), (-half_height, half_height), "white")
    _draw_box(axes, (neck, rear), (-b, b), PRINTED)
    middle, slot, depth = (neck + rear) / 2, mm(build.tie_slot) / 2, mm(build.tie_depth)
    for sign in (-1, 1):
        groove = sorted((sign * (b - depth), sign * b))
        _draw_box(axes, (middle - slot, middle + slot), (groove[0], groove[1]), "white")
    _draw_box(axes, (rear, -side.tray), (low, top), PRINTED)
    _draw_box(axes, (-side.tray, 0), (low, -stack), PRINTED)
    _draw_box(axes, (-side.tray, 0), (-stack, top), "white")
    pocket = -side.clamped / 2 - (thread.nut + mm(build.fit)) / 3**0.5
    _draw_box(axes, (pocket, 0), (low, low + thread.nut_height + mm(build.head_room)), "white")
    _draw_box(axes, (-side.tray + mm(build.fit), 0), (stack, top), "#d5dbe2")
    _draw_box(axes, (-side.tray + mm(build.fit), 0), (stack, stack + lengths.floor), PLATE)
    air, port = lengths.air_axis, neck - lengths.port_length / 2
    half_air = mm(build.air_bore) / 2
    _draw_box(axes, (port, -side.tray), (air - half_air, air + half_air), "white")
    _draw_circle(axes, (port, air), lengths.port)


def _draw_layers(axes: Axes, lengths: Lengths, edge: float, free: float) -> None:
    side = lengths.left
    for index in range(lengths.count):
        z = -lengths.stack / 2 + index * lengths.thickness
        high = z + lengths.thickness
        thin = {"lw": min(0.5, 1.2 * lengths.thickness)}
        if index % 2 == 0:
            _draw_box(axes, (-side.clamped, edge), (z, high), LEFT, **thin)
        else:
            _draw_box(axes, (-side.clamped, 0), (z, high), SPACER, **thin)
            _draw_box(axes, (free, edge), (z, high), RIGHT, **thin)


def _draw_screw(axes: Axes, lengths: Lengths) -> None:
    thread, x = lengths.thread, -lengths.left.clamped / 2
    low, high = -lengths.stack / 2 - lengths.floor, lengths.stack / 2 + lengths.floor
    tip = high - lengths.screw_length
    _draw_box(axes, (x - thread.size / 2, x + thread.size / 2), (tip, high), STEEL)
    head = thread.head / 2
    _draw_box(axes, (x - head, x + head), (high, high + thread.head_height), STEEL)
    radius = thread.nut / 3**0.5
    _draw_box(axes, (x - radius, x + radius), (low - thread.nut_height, low), "#7b818a")


def _draw_enclosure(axes: Axes, world: Scene, edge: float) -> None:
    from matplotlib.patches import Polygon

    lengths, build, side = world.lengths, world.build, world.lengths.left
    rear, neck = -side.tray - mm(build.back), -side.reach
    stack = lengths.inner_height / 2
    slope = min(0.45 * lengths.free, (lengths.cap_height - lengths.inner_height) / 2 + 2, edge - 1)
    for sign, tray in (
        (1, lengths.stack / 2 + lengths.plate_height),
        (-1, lengths.stack / 2 + lengths.shelf_height),
    ):
        inner = [(neck, lengths.neck_b), (rear - 0.8, lengths.neck_b), (rear, tray), (0.0, tray)]
        inner += [(slope, stack), (edge, stack)]
        thin = 0.75 * lengths.wall
        walls = [thin, thin, thin, thin, lengths.wall, lengths.wall]
        outer = [(x, z + w) for (x, z), w in zip(inner, walls, strict=True)]
        points = [(x, sign * z) for x, z in [*inner, *outer[::-1]]]
        axes.add_patch(Polygon(points, facecolor=SILICONE, edgecolor=INK, lw=0.7))


def _draw_dimension(axes: Axes, start: tuple[float, float], stop: tuple[float, float]) -> None:
    line = {"arrowstyle": "<->", "lw": 0.7, "color": INK, "mutation_scale": 6}
    axes.annotate("", start, stop, arrowprops={**line, "shrinkA": 0, "shrinkB": 0})


def _draw_dimension_chain(axes: Axes, parts: Sequence[Part], level: float, unit: float) -> None:
    """Draw dimensions in a row below the drawing, with the labels of narrow ones on a lower row."""
    edges = [-1e9, -1e9, -1e9]
    for words, start, stop in parts:
        for x in (start, stop):
            axes.plot((x, x), (level + 1.6 * unit, level - 0.6 * unit), color=GREY, lw=0.5)
        _draw_dimension(axes, (start, level), (stop, level))
        text = f"{words} {stop - start:.4g}"
        text_width = len(text) * 1.02 * unit * _LETTER / 0.097
        middle = (start + stop) / 2
        row = next(
            (i for i, edge in enumerate(edges) if middle - text_width / 2 > edge), len(edges) - 1
        )
        edges[row] = middle + text_width / 2
        z = level - (1.4 + 2.2 * row) * unit
        _write(axes, middle, z, text, "center", "top")


def _draw_heights(axes: Axes, x: float, parts: Sequence[Part], unit: float) -> None:
    """Draw height dimensions next to the drawing; a negative `unit` puts the text on the left."""
    for words, low, high in parts:
        for z in (low, high):
            axes.plot((x - 1.2 * unit, x + 0.6 * unit), (z, z), color=GREY, lw=0.5)
        _draw_dimension(axes, (x, low), (x, high))
        text = f"{words} {high - low:.4g}"
        _write(axes, x + unit, (low + high) / 2, text, "left" if unit > 0 else "right")


def _draw_names(axes: Axes, world: Scene, above: float, unit: float, edge: float) -> None:
    lengths, side = world.lengths, world.lengths.left
    neck, stack = -side.reach, lengths.stack / 2
    port = neck - lengths.port_length / 2
    labels = [
        ("dowel", neck - lengths.port_length - lengths.head / 2, 0.0),
        ("port", port, lengths.air_axis),
        ("tie", neck + mm(world.build.neck_length) / 2, lengths.neck_b - 0.3),
        ("air", -side.tray - mm(world.build.back) / 2, lengths.air_axis),
        ("screw", -side.clamped / 2, stack + lengths.floor + lengths.thread.head_height / 2),
        ("spacers", -0.2 * side.clamped, stack - 1.5 * lengths.thickness),
        ("enclosure", 0.5 * edge, stack + lengths.inner_height / 2 - stack + lengths.wall / 2),
    ]
    min_gap = 6.2 * unit
    last = -1e9
    for words, x, z in sorted(labels, key=lambda each: each[1]):
        last = max(x, last + min_gap)
        style.add_leader(axes, words, (x, z), (last, above + 4 * unit), "bottom")


@style.use_style
def draw_layer_order(world: Scene) -> style.Figure:
    """Draw the layers from the bottom as they lie in both caps, thickness not to scale."""
    from matplotlib.figure import Figure

    lengths = world.lengths
    layers: list[int | None] = list(range(lengths.count))
    if lengths.count > SHOWN:
        half = SHOWN // 2
        layers = [*range(half), None, *range(lengths.count - half, lengths.count)]
    figure = Figure(figsize=(8.2, 0.55 + 0.2 * len(layers)))
    axes = figure.add_axes((0, 0, 1, 1))
    style.hide_axes(axes)
    for row, index in enumerate(layers):
        z = row + 0.15, row + 0.85
        if index is None:
            _write(axes, 50, row + 0.5, f"… {lengths.count - SHOWN} more, alternating …", "center")
            continue
        is_left = index % 2 == 0
        _draw_box(axes, (14, 78) if is_left else (22, 86), z, LEFT if is_left else RIGHT)
        _draw_box(axes, (80, 86) if is_left else (14, 20), z, SPACER)
        words, ink = ("left sheet", INK) if is_left else ("right sheet", "white")
        size = style.WORDS - 1
        _write(axes, 50, row + 0.5, words, "center", color=ink, fontsize=size)
        for x, ha, is_sheet in ((12.5, "right", is_left), (87.5, "left", not is_left)):
            text = f"{index + 1}  sheet" if is_sheet else f"{index + 1}  spacer"
            _write(axes, x, row + 0.5, text, ha, fontsize=size)
    high = len(layers) + 0.3
    for x, words in ((17, "left cap"), (50, "from below, number 1 first"), (83, "right cap")):
        _write(axes, x, high, words, "center", "bottom", weight="bold")
    axes.set(xlim=(0, 100), ylim=(-0.2, len(layers) + 1.6))
    return figure


@style.use_style
def draw_boards(boards: Sequence[tuple[str, Outline]]) -> style.Figure:
    """Draw the boards, which are cut in addition to the sheets, each with its length."""
    from matplotlib.patches import Polygon

    length = max(part.length for _, part in boards)
    unit = length / 60
    height = sum(part.width + 7 * unit for _, part in boards)
    figure, axes = _make_figure(
        (-12 * unit, -5 * unit), (length + 3 * unit, height - 5 * unit), 8.2
    )
    low = 0.0
    for name, part in boards[::-1]:
        outline = part.translate(0.0, low + part.width / 2)
        axes.add_patch(Polygon(outline.points(0.05), facecolor=BOARD, edgecolor=INK, lw=0.7))
        for hole in outline.holes:
            _draw_circle(axes, hole[:2], hole.diameter)
        _write(axes, -unit, low + part.width / 2, name, "right")
        _draw_dimension_chain(axes, [("length", 0.0, part.length)], low - 1.6 * unit, unit)
        low += part.width + 7 * unit
    return figure


@style.use_style
def draw_film(piece: Piece) -> style.Figure:
    """Draw a piece of film with the outlines of the parts to be cut from it."""
    from matplotlib.patches import Polygon

    long, wide = piece.length, piece.width
    unit = max(long, wide) / 60
    figure, axes = _make_figure(
        (-5 * unit, -7 * unit),
        (long + 3 * unit, wide + 2 * unit),
        8.2 * min(1.0, 1.1 * long / wide),
    )
    _draw_box(axes, (0, long), (0, wide), style.SHADE, edgecolor=GREY)
    for part in piece.parts:
        fill = SPACER if part.length < 0.5 * piece.parts[0].length else LEFT
        axes.add_patch(Polygon(part.points(0.05), facecolor=fill, edgecolor=INK, lw=0.6))
        for hole in part.holes:
            _draw_circle(axes, hole[:2], hole.diameter, 0.6)
    _draw_dimension_chain(axes, [(f"{piece.name}, length", 0.0, long)], -2 * unit, unit)
    arrow, level = {"arrowstyle": "->", "lw": 1.0, "color": INK}, -5.6 * unit
    axes.annotate("", (long, level), (0.7 * long, level), arrowprops=arrow)
    _write(axes, 0.69 * long, level, "film direction", "right")
    _write(axes, -1 * unit, wide / 2, f"width {wide:.4g}", "right", rotation=90)
    return figure
