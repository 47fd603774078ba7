"""Drawing of a brake from its file: sheets, caps, enclosure, every named length and force.

Lengths along the pull are to scale; thicknesses are drawn larger, as the figure states.
"""

from dataclasses import dataclass
from importlib.resources import files

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.drawing import style
from layerjam.core.drawing.style import BLUE, GREY, INK, MM, ORANGE, RED
from layerjam.core.units import show

SKIN, CAP = "#dfe9ee", "#b9c2ca"
DRAWN = 11
"""Largest number of sheets in the drawing; if there are more, a label states their number."""
LOOSE, JAMMED, SHEET = 1.0, 0.62, 0.5
"""Pitch of the sheets at rest and under vacuum, and their thickness, in units of the drawing."""
SIDE = 15.0
"""Half of the drawing's height, in the same units."""


@dataclass(frozen=True)
class Shape:
    """Lengths along the pull, width and thickness [mm], and the numbers of sheets."""

    left: float
    overlap: float
    right: float
    cap: float
    travel: float
    width: float
    thickness: float
    count: int
    sheets: int
    """Number of drawn sheets."""

    @property
    def length(self) -> float:
        """Distance between the caps at rest."""
        return self.left + self.overlap + self.right

    @property
    def room(self) -> float:
        """Space for a label next to the caps."""
        return 0.16 * (self.length + self.travel)


def make_shape(brake: Brake) -> Shape:
    """Return the lengths of a brake's drawing, here and in brake_drawing.js."""
    sheets = brake.sheets
    free = sheets.free_left + sheets.overlap + sheets.free_right
    return Shape(
        left=sheets.free_left * MM,
        overlap=sheets.overlap * MM,
        right=sheets.free_right * MM,
        cap=max(brake.mount.clamped_length, 0.06 * free) * MM,
        travel=sheets.usable_travel * MM,
        width=sheets.width * MM,
        thickness=sheets.thickness * MM,
        count=sheets.count,
        sheets=min(sheets.count, DRAWN),
    )


def read_asset(name: str) -> str:
    """Return the text of a file in this folder, such as brake_drawing.js."""
    return (files("layerjam.brake.figures") / name).read_text(encoding="utf-8")


@style.use_style
def draw_device(file: BrakeFile) -> style.Figure:
    """Draw the brake at rest and at its usable travel, from the side and in cross-section."""
    brake, shape = file.brake, make_shape(file.brake)
    figure, axes = style.make_axes(2, 2, 8.6, 5.0, width_ratios=(4.4, 1))
    loose, loose_end, pull, pull_end = axes
    for pane in axes:
        style.hide_axes(pane)
    end = shape.length + shape.travel + shape.cap + shape.room
    for pane in (loose, pull):
        pane.set(xlim=(-shape.cap - shape.room, end), ylim=(-SIDE, SIDE))
    _draw_side_view(loose, shape, 0.0, LOOSE)
    _draw_side_view(pull, shape, shape.travel, JAMMED)
    _label_rest_view(loose, shape, brake)
    _label_travel_view(pull, shape, brake)
    _draw_end_view(loose_end, brake, shape, LOOSE)
    _draw_end_view(pull_end, brake, shape, JAMMED)
    style.add_title(loose, "Full of air: the sheets slide freely")
    style.add_title(pull, "Evacuated: the sheets press together, and friction resists")
    style.add_title(loose_end, "Across")
    figure.suptitle(
        f"{file.name}: lengths to scale, thicknesses not to scale",
        x=0.01,
        ha="left",
        fontsize=8.5,
        color=GREY,
    )
    return figure


def _draw_side_view(axes: style.Axes, shape: Shape, travel: float, pitch: float) -> None:
    from matplotlib.patches import Polygon, Rectangle

    end = shape.length + travel
    high, low = _body_height(shape, LOOSE), _body_height(shape, pitch)
    slope = min(0.5 * min(shape.left, shape.right), 0.04 * end)
    upper = [(0, high), (slope, low), (end - slope, low), (end, high)]
    skin = [*upper, *((x, -y) for x, y in reversed(upper))]
    axes.add_patch(Polygon(skin, closed=True, fc=SKIN, ec=GREY, lw=0.9))
    for number in range(shape.sheets):
        y = (number - (shape.sheets - 1) / 2) * pitch
        from_left = number % 2 == 0
        inset = 0.0 if pitch == LOOSE else slope
        start = inset if from_left else shape.left + travel
        stop = shape.left + shape.overlap if from_left else end - inset
        color = BLUE if from_left else ORANGE
        size = (stop - start, SHEET)
        axes.add_patch(Rectangle((start, y - SHEET / 2), *size, fc=color, ec="white", lw=0.3))
        root = (0.0 if from_left else end, y * LOOSE / pitch)
        if pitch != LOOSE:
            first = slope if from_left else end - slope
            axes.plot((root[0], first), (root[1], y), color=color, lw=2.2, solid_capstyle="butt")
    for x in (-shape.cap, end):
        box = Rectangle((x, -high), shape.cap, 2 * high, fc=CAP, ec=GREY, lw=0.9, zorder=3)
        axes.add_patch(box)


def _body_height(shape: Shape, pitch: float) -> float:
    return (shape.sheets - 1) / 2 * pitch + SHEET + 0.45


def _add_size(axes: style.Axes, start: float, stop: float, y: float, text: str, **how: str) -> None:
    """Draw a length between two arrow heads, with its name below."""
    line = {"arrowstyle": "<|-|>", "color": INK, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (start, y), (stop, y), arrowprops={**line, "mutation_scale": 6})
    for x in (start, stop):
        axes.plot((x, x), (y - 0.7, y + 0.7), color=INK, lw=0.6)
    ha = how.get("ha", "center")
    x = {"left": start, "right": stop}.get(ha, (start + stop) / 2)
    style.add_label(axes, x, y - 0.9, text, ha=ha, va="top")


def _label_rest_view(axes: style.Axes, shape: Shape, brake: Brake) -> None:
    sheets, high = brake.sheets, _body_height(shape, LOOSE)
    y, edge = -high - 1.6, shape.left + shape.overlap
    narrow = 0.1 * (shape.length + shape.travel)
    lower = y - 3.2 * (min(shape.left, shape.right) < narrow)
    _add_size(axes, shape.left, edge, y, f"overlap $L_2$ = {show(sheets.overlap, 'm')}")
    left = f"$L_1$ = {show(sheets.free_left, 'm')}"
    right = f"$L_3$ = {show(sheets.free_right, 'm')}"
    _add_size(axes, 0, shape.left, lower, left, ha="right" if shape.left < narrow else "center")
    _add_size(
        axes, edge, shape.length, lower, right, ha="left" if shape.right < narrow else "center"
    )
    style.add_label(axes, -shape.cap / 2, high + 1.4, "cap", ha="center")
    style.add_label(
        axes,
        shape.left + shape.overlap / 2,
        high + 1.4,
        "silicone enclosure, airtight",
        ha="center",
        color=GREY,
    )
    note = "" if sheets.count <= DRAWN else f", {DRAWN} of them drawn"
    style.add_label(
        axes,
        shape.length + shape.cap + 0.02 * shape.length,
        1.2,
        f"$n$ = {sheets.count} sheets{note}\n{show(sheets.thickness, 'm')} thick ($t$)",
        ha="left",
    )
    place = (shape.length + shape.cap + 0.02 * shape.length, -2.4)
    style.add_label(axes, *place, "held left", ha="left", color=BLUE)
    style.add_label(axes, place[0], place[1] - 2.2, "held right", ha="left", color=ORANGE)


def _label_travel_view(axes: style.Axes, shape: Shape, brake: Brake) -> None:
    sheets, high, low = brake.sheets, _body_height(shape, LOOSE), _body_height(shape, JAMMED)
    start, edge = shape.left + shape.travel, shape.left + shape.overlap
    end, y = shape.length + shape.travel, -high - 1.6
    overlap_left = sheets.overlap - sheets.usable_travel
    _add_size(axes, start, edge, y, f"overlap $L_2 − x$ = {show(overlap_left, 'm')}")
    _add_size(
        axes,
        shape.length,
        end,
        high + 3.2,
        f"slip $x$ = {show(sheets.usable_travel, 'm')}",
    )
    axes.plot((shape.length,) * 2, (-high, high + 2.4), color=GREY, lw=0.8, ls=style.DASHED)
    push = {"arrowstyle": "-|>", "color": RED, "lw": 1.2, "mutation_scale": 8}
    for share in (0.2, 0.4, 0.6, 0.8):
        x = share * end
        for side in (1, -1):
            tip, tail = side * (low + 0.1), side * (low + 2.6)
            if side > 0 or not start - 2 < x < edge + 2:
                axes.annotate("", (x, tip), (x, tail), arrowprops=push)
    style.add_label(axes, 0.3 * end, low + 3.6, "vacuum $P$ presses", ha="center", color=RED)
    pull = {"arrowstyle": "-|>", "color": INK, "lw": 2.2, "mutation_scale": 14}
    reach = 0.6 * shape.room
    for root, sign in ((-shape.cap, -1), (end + shape.cap, 1)):
        axes.annotate("", (root + sign * reach, 0), (root, 0), arrowprops=pull)
        style.add_label(axes, root + sign * reach / 2, 2.2, "force $F$", ha="center")


def _draw_end_view(axes: style.Axes, brake: Brake, shape: Shape, pitch: float) -> None:
    from matplotlib.patches import FancyBboxPatch, Rectangle

    half = 6.0
    axes.set(xlim=(-1.5 * half, 1.5 * half), ylim=(-SIDE, SIDE))
    high = _body_height(shape, pitch)
    corner = f"round,pad=0,rounding_size={0.5 * high}"
    box = ((-half - 1, -high), 2 * half + 2, 2 * high)
    axes.add_patch(FancyBboxPatch(*box, boxstyle=corner, fc=SKIN, ec=GREY, lw=0.9))
    for number in range(shape.sheets):
        y = (number - (shape.sheets - 1) / 2) * pitch
        color = BLUE if number % 2 == 0 else ORANGE
        start = (-half, y - SHEET / 2)
        axes.add_patch(Rectangle(start, 2 * half, SHEET, fc=color, ec="white", lw=0.3))
    if pitch == LOOSE:
        width, wall = show(brake.sheets.width, "m"), show(brake.enclosure.wall, "m")
        _add_size(axes, -half, half, -high - 1.6, f"width $W$ = {width}\nwall {wall}")
