"""What fingers do with a chart on a phone: two zoom it, one moves it or the page."""

from __future__ import annotations

import pytest

from workbench.access import LONG, WHOLE, ZOOM, at, opened

pytestmark = pytest.mark.slow
CHART = at("pull-chart")
APART = [(-20, -20), (20, 20)], [(-80, -70), (80, 70)]


class Phone:
    """A tab on a screen that is touched; places are from the middle of the chart [px]."""

    def __init__(self, context):
        self.page = context.new_page()
        self._screen = context.new_cdp_session(self.page)

    def touch(self, kind, *fingers):
        points = [{"id": k, "x": x, "y": y} for k, (x, y) in enumerate(fingers)]
        self._screen.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def drag(self, begin, end, steps=10):
        """Fingers from where they come down to where they are lifted."""
        box = self.page.locator(f"{CHART} canvas").first.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        for step in range(steps + 1):
            share = step / steps
            fingers = [
                (x + a + (c - a) * share, y + b + (d - b) * share)
                for (a, b), (c, d) in zip(begin, end, strict=True)
            ]
            self.touch("touchMove" if step else "touchStart", *fingers)
            self.page.wait_for_timeout(20)
        self.touch("touchEnd")
        self.page.wait_for_timeout(400)

    def look(self):
        """(zoom, how far the page has scrolled)."""
        assert self.page.evaluate("visualViewport.scale") == 1
        return self.page.evaluate(ZOOM, CHART), self.page.evaluate("scrollY")


@pytest.fixture(scope="module")
def phone(chromium, workbench):
    """One phone for all tests of this file, with the pull on it."""
    size = {"width": 390, "height": 844}
    context = chromium.new_context(viewport=size, has_touch=True, is_mobile=True)
    made, errors = Phone(context), []
    made.page.on("pageerror", lambda error: errors.append(str(error)))
    opened(made.page, workbench, "pull")
    made.page.wait_for_selector(f"{CHART} canvas", timeout=LONG)
    yield made
    assert errors == []
    context.close()


@pytest.fixture
def whole(phone):
    """The phone with the whole chart in the middle of its screen."""
    phone.page.locator(CHART).evaluate("e => e.scrollIntoView({block: 'center'})")
    phone.page.wait_for_timeout(300)
    assert phone.look()[0] in ({}, WHOLE)
    yield phone
    phone.page.get_by_role("button", name="Show all: Force versus elongation").dispatch_event(
        "click"
    )
    phone.page.wait_for_timeout(100)


def test_two_fingers_zoom_the_chart_and_one_moves_it(whole):
    before = whole.look()[1]
    whole.drag(*APART)
    near, scrolled = whole.look()
    assert all(10 < end - start < 60 for start, end in near.values())
    assert scrolled == before
    whole.drag([(0, 0)], [(60, 40)])
    moved, scrolled = whole.look()
    assert scrolled == before
    assert moved["x"][0] < near["x"][0] - 3 and moved["y0"][0] > near["y0"][0] + 3
    for side, (start, end) in moved.items():
        assert end - start == pytest.approx(near[side][1] - near[side][0])
    whole.drag(*APART[::-1])
    far, scrolled = whole.look()
    assert scrolled == before
    assert all(end - start > 60 for start, end in far.values())


def test_one_finger_on_a_whole_chart_moves_the_page(whole):
    before = whole.look()[1]
    whole.drag([(0, -60)], [(0, 60)])
    zoom, scrolled = whole.look()
    assert zoom == WHOLE and scrolled < before - 60


def test_beside_a_zoomed_curve_one_finger_moves_the_page(whole):
    """Nobody is caught in a chart as large as the screen."""
    whole.drag(*APART)
    near, before = whole.look()
    whole.drag([(-165, -60)], [(-165, 60)])  # over the numbers of the axis
    zoom, scrolled = whole.look()
    assert zoom == near and scrolled < before - 60


def test_a_double_tap_shows_all_again(whole):
    whole.drag(*APART)
    assert whole.look()[0] != WHOLE
    whole.page.locator(CHART).evaluate("e => e.scrollIntoView({block: 'center'})")
    box = whole.page.locator(f"{CHART} canvas").first.bounding_box()
    spot = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for _ in range(2):
        whole.touch("touchStart", spot)
        whole.page.wait_for_timeout(30)
        whole.touch("touchEnd")
        whole.page.wait_for_timeout(80)
    whole.page.wait_for_timeout(400)
    assert whole.look()[0] == WHOLE


def test_the_buttons_are_as_large_as_a_finger(whole):
    whole.drag(*APART)
    for button in whole.page.locator(f"{CHART} .chart-tools button").all():
        box = button.bounding_box()
        assert min(box["width"], box["height"]) >= 32
    whole.page.get_by_role("button", name="Show all: Force versus elongation").tap()
    whole.page.wait_for_timeout(300)
    assert whole.look()[0] == WHOLE
