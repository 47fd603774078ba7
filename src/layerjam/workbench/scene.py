"""The stack of sheets as boxes in a 3-D view."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui
from nicegui.elements.scene.scene_object3d import Object3D

from layerjam.brake.device.brake import Brake
from layerjam.core.drawing.style import BLUE, GREY, ORANGE
from layerjam.core.units import show
from layerjam.workbench import live
from layerjam.workbench.widgets import button, dress, hint
from layerjam.workshop.fabricate.outline import clamp_holes

UNIT = 0.01
"""Metres per unit of the scene."""
MAX_SHEETS = 24
"""Largest number of drawn sheets."""
TIGHT, LOOSE = 0.04, 0.7
"""Drawn gap between sheets, relative to their thickness, at full vacuum and without vacuum."""
GROUND, NIGHT = "#eef2f5", "#262d34"
INK = "#6b7a88"
"""Colour that is visible on light and dark backgrounds."""
_LABEL = "font: 600 13px sans-serif; color: var(--stack-ink); white-space: nowrap"


Point = tuple[float, float, float]


VIEWS = {
    "whole": (-0.5, -0.72, 0.45),
    "left end": (-0.95, -0.42, 0.32),
    "right end": (0.95, -0.42, 0.32),
    "side": (0.0, -1.22, 0.0),
}
"""Directions from which the brake is seen."""


@dataclass(frozen=True)
class Box:
    """A box of the scene; `centre` and `size` in scene units, x along the pull and z up."""

    name: str
    centre: Point
    size: Point
    color: str
    opacity: float = 1.0


@dataclass(frozen=True)
class Stack:
    """Drawing of a brake, and data for its caption."""

    boxes: tuple[Box, ...]
    labels: tuple[tuple[str, str, Point], ...]
    """(name, text, position) of each label."""
    scale: int
    drawn: int
    low: Point
    """Lowest corner of a box that contains the drawing at any vacuum, and at full travel."""
    high: Point


def find_magnification(thickness: float, count: int, width: float) -> int:
    """Return the magnification of thicknesses (1, 2, 5, 10, ...) that makes the stack visible."""
    for power in range(6):
        for step in (1, 2, 5):
            times = step * 10**power
            if times * thickness * count >= 0.8 * width:
                return times
    return 10**6


def build_stack(brake: Brake, slip: float, share: float) -> Stack:
    """Return the drawing at a slip [m] and a fraction of full vacuum (0 to 1).

    Lengths and width are to scale; thicknesses are exaggerated. Sheets of the two ends alternate;
    if the number is odd, the left end has one more, as in eq. 1.
    """
    sheets, clamp_length = brake.sheets, brake.mount.clamped_length
    count = min(sheets.count, MAX_SHEETS)
    scale = find_magnification(sheets.thickness, count, sheets.width)
    thick = sheets.thickness * scale
    gap = thick * (LOOSE + (TIGHT - LOOSE) * share)
    height, loosest = (count * thick + (count - 1) * g for g in (gap, thick * LOOSE))
    free, lap, free_right = sheets.free_left, sheets.overlap, sheets.free_right
    # the left cap is fixed, and the origin is the middle of the brake at rest
    start, end = -(free + lap + free_right) / 2, (free + lap + free_right) / 2 + slip
    boxes = [
        _sheet_box(i, thick, (i + 0.5) * thick + i * gap - height / 2, brake, (start, end))
        for i in range(count)
    ]
    cap = max(1.2 * clamp_length, 0.06 * (free + lap + free_right))
    total_height = height + 3 * thick
    for name, inner, side in (("left cap", start, -1), ("right cap", end, 1)):
        middle = inner + side * cap / 2
        boxes.append(
            _make_box(name, (middle, 0, 0), (cap, 1.25 * sheets.width, total_height), GREY)
        )
        boxes += _screw_boxes(name, middle, total_height / 2, brake)
    room = (0.25 + 1.5 * (1 - share)) * thick
    around = (end - start, sheets.width + 2 * room, height + 2 * room)
    boxes.append(_make_box("enclosure", ((start + end) / 2, 0, 0), around, "#9fb4c4", 0.28))
    low = -total_height / 2 - 2.5 * thick
    left, right = start + free + slip, start + free + lap
    overlap_mark = ((left + right) / 2, -sheets.width / 2, low)
    boxes.append(_make_box("overlap", overlap_mark, (max(right - left, 1e-5), 0.0006, 0.0012), INK))
    tip = start + free + lap + free_right + sheets.usable_travel
    boxes += _ghost_boxes(end + cap, tip, cap, (1.25 * sheets.width, total_height, height))
    labels = (
        ("overlap", f"overlap {show(lap - slip, 'm', 3)}", _scale_point(*overlap_mark)),
        ("left", "left end", _scale_point(start - cap / 2, 0, total_height / 2)),
        ("right", "right end", _scale_point(end + cap / 2, 0, total_height / 2)),
        (
            "ghost",
            f"slip of up to {show(sheets.usable_travel, 'm', 3)}",
            _scale_point(tip, 0, total_height / 2),
        ),
    )
    deep, half_width = loosest / 2 + 4 * thick, 1.25 * sheets.width / 2
    corners = (
        _scale_point(start - cap, -half_width, -deep),
        _scale_point(tip + cap, half_width, deep),
    )
    return Stack(tuple(boxes), labels, scale, count, *corners)


def _ghost_boxes(start: float, end: float, cap: float, size: Point) -> Iterator[Box]:
    wide, tall, height = size
    yield _make_box("ghost cap", (end + cap / 2, 0, 0), (cap, wide, tall), GREY, 0.22)
    if end > start:
        yield _make_box(
            "ghost", ((start + end) / 2, 0, 0), (end - start, wide / 1.25, height), ORANGE, 0.14
        )


def _sheet_box(number: int, thick: float, z: float, brake: Brake, span: tuple[float, float]) -> Box:
    """Return a sheet at its height; the left cap holds sheets with an even index."""
    sheets, clamp_length = brake.sheets, brake.mount.clamped_length
    if number % 2 == 0:
        ends = (span[0] - clamp_length, span[0] + sheets.free_left + sheets.overlap)
    else:
        ends = (span[1] - sheets.free_right - sheets.overlap, span[1] + clamp_length)
    size = (ends[1] - ends[0], sheets.width, thick)
    color = ORANGE if number % 2 else BLUE
    return _make_box(f"sheet {number}", (sum(ends) / 2, 0, z), size, color)


def _screw_boxes(name: str, x: float, z: float, brake: Brake) -> Iterator[Box]:
    width, hole = brake.sheets.width, max(brake.mount.screw_hole, 0.001)
    row = clamp_holes(0.0, width, int(brake.mount.count_screws(width)), hole)
    for number, place in enumerate(row):
        size = (hole, hole, 0.5 * hole)
        yield _make_box(f"screw {number} {name}", (x, place.y, z), size, "#39424b")


def _scale_point(x: float, y: float, z: float) -> Point:
    return (x / UNIT, y / UNIT, z / UNIT)


def _make_box(name: str, centre: Point, size: Point, color: str, opacity: float = 1.0) -> Box:
    return Box(name, _scale_point(*centre), _scale_point(*size), color, opacity)


def describe_stack(brake: Brake, stack: Stack, slip: float) -> str:
    """Return the picture's caption: its dimensions, and what is not to scale."""
    sheets = brake.sheets
    left_count = (sheets.count + 1) // 2
    note = f", {stack.drawn} of them drawn" if stack.drawn < sheets.count else ""
    return (
        f"{sheets.count} sheets{note}, {left_count} held on the left (blue) and "
        f"{sheets.count - left_count} on the right (orange); they overlap by "
        f"{show(sheets.overlap - slip, 'm', 3)} of {show(sheets.overlap, 'm', 3)}. "
        f"Lengths and width have the same scale; the thickness is drawn {stack.scale} "
        "times larger. The gaps indicate the vacuum; they are not computed."
    )


class Slab(Object3D, component=Path(__file__).with_name("slab.js")):
    """A unit cube with drawn edges, which is stretched and moved to become a box."""

    def __init__(self, color: str, opacity: float) -> None:
        super().__init__(color, opacity)


class CameraView:
    """A scene with a camera, buttons for view directions, and a light or dark background."""

    space: type[ui.scene] = ui.scene

    def __init__(
        self, views: Mapping[str, Point], height: int, ident: str, classes: str, **words: str
    ) -> None:
        self._view, self._dark = views["whole"], False
        self._corners: tuple[Point, Point] | None = None
        camera = ui.scene.perspective_camera(fov=28)
        look: dict[str, Any] = {"grid": False, "background_color": GROUND, "fps": 20}
        self.scene = self.space(width=640, height=height, camera=camera, click_events=[], **look)
        dress(self.scene, ident, classes, role="img", aria_label=words["label"])
        self.scene.on("init", js_handler=f"() => layerjamStill(getElement({self.scene.id}))")
        self.scene.on("init", lambda: self._fit_camera(0.0))
        with ui.row().classes("gap-1 items-center") as self.row:
            ui.label("View").classes("text-sm")
            for name, place in views.items():
                key = f"{ident}-{name.replace(' ', '-')}"
                view = button(
                    name, partial(self._turn_camera, place), key, look="flat dense no-caps"
                )
                dress(view, aria_label=f"{words['button']}: {name}")
            hint("drag to rotate, scroll to zoom")

    def set_ground_colour(self, dark: bool) -> None:
        """Set the background colour."""
        if dark != self._dark:
            self._dark = dark
            ground = NIGHT if dark else GROUND
            self.scene.client.run_javascript(
                f"const view = getElement({self.scene.id}); view.ground = '{ground}'; "
                "view.renderer.setClearColor(view.ground)"
            )

    def enclose_box(self, low: Point, high: Point) -> None:
        """Move the camera so that it shows a whole box from the selected direction."""
        if self._corners != (low, high):
            self._corners = (low, high)
            self._fit_camera(0.3)

    def _turn_camera(self, place: Point) -> None:
        self._view = place
        self._fit_camera(0.3)

    def _fit_camera(self, duration: float) -> None:
        """Move the camera as close as the view of the whole brake allows, within `duration` [s]."""
        if self._corners is not None:
            args = json.dumps([*self._corners, self._view, duration])
            self.scene.client.run_javascript(
                f"const view = getElement({self.scene.id}); "
                f"if (view?.renderer) layerjamFit(view, ...{args})"
            )


class StackView(CameraView):
    """The 3-D view; boxes are created once and then only moved and stretched."""

    scene: live.Space
    space = live.Space

    def __init__(self, ident: str, classes: str = "w-full h-80", views: bool = True) -> None:
        self._boxes: dict[str, Any] = {}
        self._labels: dict[str, tuple[str, Any]] = {}
        words = {"label": "The stack of sheets", "button": "View from"}
        with ui.element("div").classes("w-full"):
            super().__init__(VIEWS, 320, ident, classes, **words)
            self.row.set_visibility(views)

    def show(self, stack: Stack, words: str, dark: bool = False) -> None:
        """Update the scene."""
        self.set_ground_colour(dark)
        self.scene.describe_scene(words)
        with self.scene.batch_changes():
            for box in stack.boxes:
                if box.name not in self._boxes:
                    self._boxes[box.name] = Slab(box.color, box.opacity)
                self._boxes[box.name].scale(*box.size).move(*box.centre)
            for name, text, place in stack.labels:
                self._write_label(name, text, place)
            for name in {*self._boxes} - {box.name for box in stack.boxes}:
                self._boxes.pop(name).delete()
        self.enclose_box(stack.low, stack.high)

    def _write_label(self, name: str, text: str, place: Point) -> None:
        old = self._labels.get(name)
        if old is not None and old[0] != text:
            old[1].delete()
            old = None
        if old is None:
            side = "padding-top: 44px" if name == "overlap" else "padding-bottom: 40px"
            old = self._labels[name] = (text, self.scene.text(text, f"{_LABEL}; {side}"))
        old[1].move(*place)
