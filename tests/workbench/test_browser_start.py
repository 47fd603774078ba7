"""The first page in a browser: the vacuum goes along, the kilogram falls, the views."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.slow
LONG = 90_000


def at(ident: str) -> str:
    return f'[data-testid="{ident}"]'


def says(page, ident: str, words: str) -> None:
    page.wait_for_function(
        "([place, words]) => document.querySelector(place)?.innerText.includes(words)",
        arg=[at(ident), words], timeout=LONG,
    )  # fmt: skip


def seen(page) -> tuple[float, float, float, float]:
    """The part of its view that the brake takes: from left to right, from top to bottom."""
    view = page.locator(at("start-scene"))
    view.evaluate("view => { view.children[1].style.visibility = 'hidden'; }")  # its words
    image = np.asarray(Image.open(io.BytesIO(view.screenshot())).convert("RGB"), float)
    there = np.abs(image - image[9, 9]).max(axis=2)[4:-4, 4:-4] > 12  # without its rim
    height, width = there.shape
    xs, ys = np.flatnonzero(there.any(axis=0)), np.flatnonzero(there.any(axis=1))
    assert len(xs), "the view is empty"
    return xs[0] / width, xs[-1] / width, ys[0] / height, ys[-1] / height


@pytest.fixture
def start(tab):
    says(tab, "start-words", "The brake resists a pull")
    tab.wait_for_selector(f"{at('start-chart')} canvas", timeout=LONG)
    return tab


def test_one_vacuum_a_kilogram_another_brake(start):
    says(start, "brake-here-origin", "paper")
    start.locator(f"{at('start-vacuum')} [tabindex='0']").first.focus()
    for _ in range(30):
        start.keyboard.press("ArrowLeft")
    says(start, "start-words", "16.5 kg")
    moved = start.input_value(at("start-vacuum-number"))
    start.click(at("start-drop"))
    says(start, "start-happened", "1 kg falls 30 cm: the brake slips")
    start.wait_for_function("layerjamDrop.time() > 0", timeout=LONG)
    start.evaluate("scrollTo(0, 9999)")
    start.click(at("tab-pull"))
    start.wait_for_selector(f"{at('pull-chart')} canvas", timeout=LONG)
    assert start.input_value(at("pull-vacuum-number")) == moved
    start.wait_for_function("scrollY === 0", timeout=LONG)
    start.click(at("tab-drop"))
    start.wait_for_selector(f"{at('drop-chart')} canvas", timeout=LONG)
    start.wait_for_function("layerjamDrop.time() === 0", timeout=LONG)
    start.click(at("tab-start"))
    start.click(at("start-try-choi2018-ptfe"))
    says(start, "brake-here-name", "PTFE")
    assert not [e for e in start.errors if "WebGL" not in e]


def test_the_brake_fills_its_view_whatever_is_resized(start):
    start.wait_for_timeout(1500)
    sizes = [(1280, 800), (1280, 620), (500, 800), (1900, 1000)]
    for width, height in sizes:
        start.set_viewport_size({"width": width, "height": height})
        start.wait_for_timeout(1000)
        left, right, low, high = seen(start)
        assert left > 0 and right < 1 and low > 0 and high < 1, (width, height)
        assert max(right - left, high - low) > 0.65, (width, height)
        assert abs(left + right - 1) < 0.1 and abs(low + high - 1) < 0.25, (width, height)
    # resized where it is not seen, it is drawn anew when it is
    start.click(at("tab-brake"))
    start.wait_for_selector(at("brake-numbers"), timeout=LONG)
    start.set_viewport_size({"width": 1000, "height": 700})
    start.click(at("tab-start"))
    start.wait_for_timeout(1500)
    left, right, _, _ = seen(start)
    assert left > 0 and 0.6 < right < 1
    assert not [e for e in start.errors if "WebGL" not in e]
