"""The band of a calibrated brake on the Pull page: there only where it is known, and pinned."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from layerjam.device.load import load
from layerjam.errors import LayerjamError
from layerjam.identify.calibration.law_spread import LawSpread
from layerjam.identify.shape import SHAPE
from layerjam.report.chart import Curve
from layerjam.workbench import answer as answers
from layerjam.workbench.charts import band_series
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.pull import PIN_BAND, Pull, make_chart
from layerjam.workbench.pages.pull_band import law_error
from layerjam.workbench.pins import BAND, make_call
from layerjam.workbench.state import Pin, State, format_link, parse_link
from layerjam.workbench.takeaway import curves_csv
from workbench.standing import standing

KAPTON = "choi2018-kapton"
CALIBRATED = load(KAPTON).text + "\n# as if calibrated\n"
SURE = np.diag([0.02, 0.05, 0.0]) ** 2
SPREAD = LawSpread(
    names=SHAPE, estimate=np.array([0.0, 11.0, 1.0]), covariance=SURE, scatter=SURE, t=2.0, pulls=5
)


@pytest.fixture
def page():
    made = Pull(Desk(State(page="pull", brake=CALIBRATED, settings={"pull": {"travel": 0.03}})))
    made.desk.laws[CALIBRATED] = SPREAD
    yield made
    made.uploads.close()


def drawn(page):
    """The chart of what the page computes now."""
    answer, whole, reading, shown = page.result = page.compute()
    return answer.result, shown, make_chart(answer, whole, reading, shown, False)


def test_past_the_peak_the_band_is_that_of_the_friction(page):
    """There the sheets' friction alone scatters: by 2 % times t, of what is not the enclosure's."""
    found, shown, chart = drawn(page)
    u, half = shown.elongation, shown.half_width
    force = np.interp(u, found.record.elongation, found.record.force)
    assert found.peak_elongation in u and u[-1] == found.record.elongation[-1]
    past = u > 2 * found.peak_elongation
    brake = page.desk.brake.brake
    bare = brake.scale_factor * brake.film.kinetic * (brake.sheets.count - 1) * 94.5e3
    slip = u - force / brake.stiffness_measured
    friction = bare * brake.sheets.width * (brake.sheets.overlap - slip)
    # the stiffness moves the slip a little, the force with it
    assert half[past] == pytest.approx(2 * 0.02 * friction[past], rel=0.02)
    # before it the stiffness scatters, by 5 %
    rise = (u > 0) & (u < 0.5 * found.peak_elongation)
    assert half[rise] == pytest.approx(2 * 0.05 * force[rise], rel=0.1)
    names = [s["name"] for s in chart["series"]]
    edges = [f"computed, 95 % of 5 pulls, {side}" for side in ("lower", "upper")]
    assert names == ["computed", *edges, ""]
    assert [s["endLabel"]["show"] for s in chart["series"]] == [True, False, False, False]
    assert chart["series"][0]["endLabel"]["formatter"] == "{a}, 95 % of 5 pulls"
    assert "curve 4" not in curves_csv(chart)  # the ground has no name
    assert edges[0] in curves_csv(chart)


def test_the_ground_is_enclosed_by_both_edges():
    x = np.linspace(0, 4, 5)
    made = band_series(Curve(x, x - 1.0), Curve(x, x + 1.0))["data"]
    assert made == [[k, k + 1.0] for k in x] + [[k, k - 1.0] for k in x[::-1]]
    # by the shoelace formula 2 high times 4 wide
    a, b = np.array(made).T
    assert abs(np.dot(a, np.roll(b, 1)) - np.dot(b, np.roll(a, 1))) / 2 == pytest.approx(8)


def test_only_a_brake_calibrated_here_and_only_its_own_law_has_a_band(page):
    assert law_error(page.desk, page.calls()[0]) is not None
    for value in ("stack", "judder", "lumped"):
        page.desk.put_setting("pull", "model", value)
        assert (law_error(page.desk, page.calls()[0]) is None) == (value != "lumped")
    page.desk.put_brake(CALIBRATED + "# edited\n")
    assert law_error(page.desk, page.calls()[0]) is None
    assert drawn(page)[1] is None


def test_a_pinned_band_goes_with_the_link_and_needs_no_calibration_there(page):
    _, before, _ = drawn(page)
    text = law_error(page.desk, page.calls()[0]).text()
    pin = Pin("pull", "tensile", CALIBRATED, {**page.calls()[0].options, BAND: text})
    other = Pull(Desk(parse_link(format_link(State(page="pull", pins=(pin,))))))
    _, shown, chart = drawn(other)
    assert shown is None
    (one,) = other.result[0].pins
    assert one.more.half_width == pytest.approx(before.half_width, rel=1e-12)
    _, quiet, low, high, _ = chart["series"]
    assert quiet["endLabel"]["formatter"] == "{a}, 95 % of 5 pulls"
    for edge, side in ((low, "lower"), (high, "upper")):
        assert edge["name"] == f"{one.label}, 95 % of 5 pulls, {side}"
    assert BAND not in one.answer.call.options
    again = one.more
    assert other.compute()[0].pins[0].more is again  # once
    other.uploads.close()


@pytest.mark.parametrize("text", ["", "[1]", "[5, 2, -1, 0, 0, 1, 0, 1]"])
def test_a_band_that_a_link_made_up_is_refused_in_words(text):
    said = {"vacuum": "60 kPa", "speed": "1 mm/s", "travel": "20 mm", BAND: text}
    page = Pull(Desk(State(page="pull", pins=(Pin("pull", "tensile", KAPTON, said),))))
    assert page.compute()[0].pins == () and page.panel.problem.startswith("band")
    page.uploads.close()


def test_no_other_command_keeps_one():
    with pytest.raises(LayerjamError):
        make_call(Pin("drop", "drop", KAPTON, {"mass": "1 kg", BAND: "[]"}))


@pytest.mark.slow
def test_the_button_is_there_with_the_band_and_pins_it():
    async def use() -> None:
        async with standing(Pull) as (user, pages):
            await user.should_see("Pulled to 40 mm", retries=300)
            await user.should_not_see(PIN_BAND)
            page = pages[-1]
            page.desk.laws[CALIBRATED] = SPREAD
            page.desk.put_brake(CALIBRATED)
            await user.should_see(PIN_BAND, retries=300)
            user.find(PIN_BAND).click()
            await user.should_see("as shown", retries=100)
            (pin,) = page.desk.state.pins
            assert BAND in pin.options
            page.desk.put_setting("pull", "vacuum", 50e3)
            await user.should_see("94.5 kPa", retries=100)
            await page.wait_until_idle()
            assert sum("areaStyle" in s for s in page.panel.chart.options["series"]) == 2

    asyncio.run(use())


def test_the_figure_that_is_taken_away_shows_the_bands(page, monkeypatch):
    """The page's own and a pin's, each around its own curve, named once."""
    said = {**page.calls()[0].options, "vacuum": "60 kPa"}
    text = SPREAD.error_at(60e3, 1e-3).text()
    pin = Pin("pull", "tensile", CALIBRATED, {**said, BAND: text})
    page.desk.state = replace(page.desk.state, pins=(pin,))
    shown, _, _, band = page.compute()
    figures = []
    monkeypatch.setattr(answers, "save", lambda figure, path: figures.append(figure))
    finish = shown.finish
    monkeypatch.setattr(Path, "read_bytes", lambda path: b"")
    assert shown.figure("svg") == b"" and finish is not None
    (axes,) = figures[0].axes
    (pinned,) = shown.pins
    parts = [c for c in axes.collections if isinstance(c, PolyCollection)]
    for part, one, found in (
        (parts[0], pinned.more, pinned.answer.result),
        (parts[1], band, shown.result),
    ):
        x, y = part.get_paths()[0].vertices.T
        force = np.interp(x * 1e-3, found.record.elongation, found.record.force)
        half = np.interp(x * 1e-3, one.elongation, one.half_width)
        assert np.abs(y - force) == pytest.approx(half, abs=1e-9)
    words = [text.get_text() for text in axes.texts]
    assert words.count("band: 95 % of 5 pulls") == 1
