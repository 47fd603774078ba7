"""The band around a pull on the Pull page: what it contains, where it is, dashed, and pinned."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.brake.simulate.prediction import Prediction
from layerjam.core.drawing.chart import Curve
from layerjam.core.errors import LayerjamError
from layerjam.workbench import answer as answers
from layerjam.workbench.charts import band_series
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.pull import PIN_BAND, Pull, make_chart
from layerjam.workbench.pages.pull_band import NAME
from layerjam.workbench.pins import BAND, make_call
from layerjam.workbench.state import Pin, State, format_link, parse_link
from layerjam.workbench.takeaway import curves_csv
from workbench.evidenced import add_tests
from workbench.standing import standing

KAPTON = "choi2018-kapton"
TESTED = add_tests(KAPTON)
SHOWN = {"travel": 0.03, "vacuum": 60e3, "speed": 0.01}


@pytest.fixture
def page():
    made = Pull(Desk(State(page="pull", brake=TESTED, settings={"pull": SHOWN})))
    yield made
    made.uploads.close()


def drawn(page):
    """(pull, band, chart) of what the page computes now."""
    answer, whole, reading, shown = page.result = page.compute()
    return answer.result, shown, make_chart(answer, whole, reading, shown, False)


def lines(chart):
    """[(name, dash)] of the series that are lines."""
    return [(s["name"], s["lineStyle"]["type"]) for s in chart["series"] if "areaStyle" not in s]


def test_the_band_contains_the_pulls_of_other_brakes_like_it(page):
    found, band, chart = drawn(page)
    u = band.elongation
    assert found.peak_elongation in u and u[-1] == found.record.elongation[-1]
    file = BrakeFile.read(TESTED, "tested")
    prediction = Prediction(file, 60e3, np.zeros_like(u), 0.01, samples=1000)
    forces = force_at_elongation(u, 60e3, prediction.brakes)
    share = ((forces >= band.low) & (forces <= band.high)).mean(axis=0)[1:]
    assert share == pytest.approx(0.95, abs=0.02)
    page.desk.put_setting("pull", "travel", 0.02)
    _, _, chart = drawn(page)
    names = [s["name"] for s in chart["series"]]
    edges = [f"computed, {NAME}, {side}" for side in ("lower", "upper")]
    assert names == ["computed", *edges, ""]
    assert [s["endLabel"]["show"] for s in chart["series"]] == [True, False, False, False]
    assert chart["series"][0]["endLabel"]["formatter"] == f"{{a}}, {NAME}"
    assert "curve 4" not in curves_csv(chart)  # the ground has no name
    assert edges[0] in curves_csv(chart)


def test_without_tests_there_is_no_band(page):
    page.desk.put_brake(KAPTON)
    assert drawn(page)[1] is None
    page.desk.put_brake(TESTED.replace('value = "13 mm"', 'value = "14 mm"'))  # changed since
    assert page.desk.brake.evidence and drawn(page)[1] is None


def test_the_curve_is_dashed_where_nothing_was_tested(page):
    """Slips were tested up to 20 mm, vacuums from 50 kPa to 70 kPa."""
    page.desk.put_setting("pull", "travel", 0.02)
    assert lines(drawn(page)[2])[0] == ("computed", "solid")
    page.desk.put_setting("pull", "travel", 0.03)
    _, band, chart = drawn(page)
    assert lines(chart)[:2] == [("computed", "solid"), ("computed", "dashed")]
    inside, outside = (s["data"] for s in chart["series"][:2])
    assert inside[-1] == outside[0] and outside[-1][0] == pytest.approx(30)
    assert band.tested_end == pytest.approx(0.0204, abs=1e-3)  # slip and stretch
    assert inside[-1][0] == pytest.approx(band.tested_end * 1e3, abs=0.3)
    page.desk.put_setting("pull", "vacuum", 90e3)
    assert lines(drawn(page)[2])[0] == ("computed", "dashed")


def test_the_ground_is_enclosed_by_both_edges():
    x = np.linspace(0, 4, 5)
    made = band_series(Curve(x, x - 1.0), Curve(x, x + 1.0))["data"]
    assert made == [[k, k + 1.0] for k in x] + [[k, k - 1.0] for k in x[::-1]]
    # by the shoelace formula 2 high times 4 wide
    a, b = np.array(made).T
    assert abs(np.dot(a, np.roll(b, 1)) - np.dot(b, np.roll(a, 1))) / 2 == pytest.approx(8)


@pytest.mark.parametrize("model", ["stack", "judder", "lumped"])
def test_only_the_lumped_law_has_a_band(page, model):
    page.desk.put_setting("pull", "model", model)
    assert (drawn(page)[1] is None) == (model != "lumped")


def test_a_pinned_band_goes_with_the_link(page):
    _, before, _ = drawn(page)
    pin = Pin("pull", "tensile", TESTED, {**page.calls()[0].options, BAND: NAME})
    other = Pull(Desk(parse_link(format_link(State(page="pull", pins=(pin,))))))
    _, _, chart = drawn(other)
    (one,) = other.result[0].pins
    assert one.more.low == pytest.approx(before.low, rel=1e-12)
    quiet = next(s for s in chart["series"] if s["name"] == one.label)
    assert quiet["endLabel"]["show"]
    names = [s["name"] for s in chart["series"]]
    assert {f"{one.label}, {NAME}, {side}" for side in ("lower", "upper")} <= set(names)
    assert BAND not in one.answer.call.options
    again = one.more
    assert other.compute()[0].pins[0].more is again  # once
    other.uploads.close()


def test_a_band_around_a_pull_that_has_none_is_refused_in_words():
    said = {"vacuum": "60 kPa", "speed": "1 mm/s", "elongation": "20 mm", "model": "stack"}
    pin = Pin("pull", "tensile", KAPTON, {**said, BAND: NAME})
    page = Pull(Desk(State(page="pull", pins=(pin,))))
    assert page.compute()[0].pins == () and page.panel.problem.startswith("band")
    page.uploads.close()


def test_no_other_command_keeps_one():
    with pytest.raises(LayerjamError):
        make_call(Pin("drop", "drop", KAPTON, {"mass": "1 kg", BAND: NAME}))


@pytest.mark.slow
def test_the_button_is_there_with_the_band_and_pins_it():
    async def use() -> None:
        async with standing(Pull) as (user, pages):
            await user.should_see("Pulled to 40 mm", retries=300)
            await user.should_not_see(PIN_BAND)
            page = pages[-1]
            page.desk.put_brake(TESTED)
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


def test_the_figure_that_is_taken_away_shows_the_band_of_a_pin(page, monkeypatch):
    """The rest is the command's own, as in the copied Python."""
    assert page.compute()[0].finish is None
    said = {**page.calls()[0].options, "vacuum": "70 kPa", BAND: NAME}
    page.desk.state = replace(page.desk.state, pins=(Pin("pull", "tensile", TESTED, said),))
    shown, *_ = page.compute()
    figures = []
    monkeypatch.setattr(answers, "save", lambda figure, path: figures.append(figure))
    finish = shown.finish
    monkeypatch.setattr(Path, "read_bytes", lambda path: b"")
    assert shown.figure("svg") == b"" and finish is not None
    (axes,) = figures[0].axes
    (pinned,) = shown.pins
    part = [c for c in axes.collections if isinstance(c, PolyCollection)][-1]
    x, y = part.get_paths()[0].vertices.T
    band = pinned.more
    edges = [np.interp(x * 1e-3, band.elongation, edge) for edge in (band.low, band.high)]
    assert np.min([np.abs(y - edge) for edge in edges], axis=0) == pytest.approx(0, abs=1e-9)
    words = [text.get_text() for text in axes.texts]
    assert words.count(f"band: {NAME}") == 1
