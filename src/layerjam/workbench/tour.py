"""A minute's walk past the page's controls, for who wants it."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

from nicegui import ui


@dataclass(frozen=True)
class Step:
    """A tab that is opened, the control on it that is pointed at, and what is said of it."""

    tab: str
    target: str
    title: str
    text: str


STEPS = (
    Step(
        "start",
        "start-scene",
        "The brake",
        "Thin sheets in a soft enclosure: the blue ones are held on the left, the orange ones on "
        "the right. The pale shape shows how far the right half can be pulled out.",
    ),
    Step(
        "start",
        "start-vacuum",
        "One vacuum",
        "Pump the air out, and the sheets press on each other. Drag it, or use the arrow keys. "
        "Every tab computes with this vacuum.",
    ),
    Step(
        "pull",
        "pull-chart",
        "The force of a pull",
        "It rises until the sheets slide, then falls as less of them overlaps. Drop the file of "
        "your test machine here, and it is drawn over the curve.",
    ),
    Step(
        "drop",
        "drop-animation",
        "A mass is stopped",
        "In slow motion, beside force and deceleration. The vacuum can be tuned so that the mass "
        "stops within a given slip.",
    ),
    Step(
        "laboratory",
        "laboratory-drop",
        "Your own files",
        "Drop test files here. You see what was understood, correct it, and take a calibrated "
        "brake away.",
    ),
    Step(
        "start",
        "brake-here",
        "Which brake",
        "All tabs compute this brake, and its word says where the numbers come from. The buttons "
        "on the right undo, and copy what you see as a link, a command or Python.",
    ),
)


def begin() -> None:
    """Start it in the browser."""
    ui.run_javascript(f"layerjamTour({json.dumps([asdict(step) for step in STEPS])})")
