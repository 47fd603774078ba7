"""The drawing of a brake has the lengths of its file, whatever brake it is."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from core.drawing.legible import faults
from layerjam.brake.device.load import load
from layerjam.brake.figures.device_drawing import BLUE, DRAWN, ORANGE, draw_device
from layerjam.workshop.commands.show import show

KAPTON = load("choi2018-kapton")


def of(**sheets: Any) -> Any:
    changed = replace(KAPTON.brake.sheets, **sheets)
    length = changed.overlap + max(changed.free_left, changed.free_right) + 0.05
    changed = replace(changed, length=max(changed.length, length))
    return replace(KAPTON, brake=replace(KAPTON.brake, sheets=changed))


def sides(axes: Any) -> tuple[list[Any], list[Any]]:
    """Ends of the sheets held left and of those held right, shape (sheets, 2) [mm]."""
    from matplotlib.colors import to_rgba

    boxes = [p for p in axes.patches if isinstance(p, Rectangle)]
    found = []
    for color in (BLUE, ORANGE):
        mine = [p for p in boxes if p.get_facecolor() == to_rgba(color)]
        found.append([(p.get_x(), p.get_x() + p.get_width()) for p in mine])
    return found[0], found[1]


@pytest.mark.parametrize("count", [2, 3, 11, 60])
def test_lengths_along_the_pull_are_to_scale(count: int) -> None:
    sheets = replace(
        KAPTON.brake.sheets, count=count, free_left=0.007, free_right=0.019, overlap=0.05,
        usable_travel=0.03,
    )  # fmt: skip
    file = replace(KAPTON, brake=replace(KAPTON.brake, sheets=sheets))
    rest, _, pulled, _ = draw_device(file).axes
    for axes, slip in ((rest, 0.0), (pulled, 30.0)):
        left, right = map(np.asarray, sides(axes))
        assert len(left) + len(right) == min(count, DRAWN)
        assert left[:, 1] == pytest.approx(7 + 50)
        assert right[:, 0] == pytest.approx(7 + slip)
        assert left[:, 1].min() - right[:, 0].max() == pytest.approx(50 - slip)
    left, right = sides(rest)
    assert left[0][0] == 0 and right[0][1] == pytest.approx(7 + 50 + 19)


@pytest.mark.parametrize(
    "sheets",
    [
        {"free_left": 1e-3, "free_right": 1e-3},
        {"free_left": 0.1, "free_right": 2e-3},
        {"overlap": 0.012, "usable_travel": 1e-3},
        {"overlap": 2.0, "usable_travel": 1.99},
        {"count": 10_000, "thickness": 1e-6, "width": 0.5},
    ],
)
def test_odd_brakes_can_be_read(sheets: dict[str, Any]) -> None:
    assert faults(draw_device(of(**sheets))) == []


def test_show_draws_it() -> None:
    figure = show("choi2018-ptfe").plot()
    said = {text.get_text() for axes in figure.axes for text in axes.texts}
    assert {"overlap $L_2$ = 68 mm", "slip $x$ = 60 mm", "vacuum $P$ presses"} <= said
