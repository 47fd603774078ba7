"""The drop in a browser: playing, pausing, the scrubber by keyboard, the cursor in the charts."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.slow
LONG = 60_000


def at(key: str) -> str:
    return f"[data-testid=drop-{key}]"


@pytest.fixture
def drop(tab):
    tab.click("[data-testid=tab-drop]")
    tab.wait_for_selector(f"{at('chart')} canvas", timeout=LONG)
    tab.wait_for_function(
        "document.querySelector('[data-testid=drop-verdict]').innerText.includes(' kPa stops ')",
        timeout=LONG,
    )
    tab.wait_for_function("window.layerjamDrop !== undefined", timeout=LONG)
    tab.wait_for_timeout(500)
    return tab


def cursor(tab) -> float:
    place = tab.evaluate("document.querySelector('.drop-cursor').style.transform")
    return float(place.removeprefix("translateX(").removesuffix("px)"))


def test_it_plays_in_slow_motion_and_the_cursor_goes_with_it(drop):
    assert "100 times slower than life" in drop.inner_text(at("slow-said"))
    start = cursor(drop)
    drop.click(at("play"))
    drop.wait_for_timeout(1000)
    drop.click(at("play"))
    now = drop.evaluate("layerjamDrop.time()")
    assert 2 < now < 30  # ms of the drop in a second or so, a hundred times slower
    assert not drop.evaluate("layerjamDrop.playing()")
    assert cursor(drop) > start
    drop.wait_for_timeout(300)
    assert drop.evaluate("layerjamDrop.time()") == now
    assert drop.errors == []


def test_the_scrubber_goes_by_keyboard(drop):
    drop.focus(at("scrub"))
    drop.keyboard.press("End")
    end = drop.evaluate("layerjamDrop.time()")
    assert end == pytest.approx(63.94, abs=0.1)
    assert "41." in drop.inner_text(at("now"))  # 40 mm of slip and what the rope gives
    drop.keyboard.press("ArrowLeft")
    assert 0 < end - drop.evaluate("layerjamDrop.time()") < 1
    drop.keyboard.press("Home")
    assert drop.evaluate("layerjamDrop.time()") == 0


def test_every_kind_of_vacuum_and_undo(drop):
    drop.locator(at("shown")).get_by_text("no brake", exact=True).click()
    drop.wait_for_function(
        "document.querySelector('[data-testid=drop-verdict]').innerText.includes('12.5 ms')"
    )
    drop.locator(at("shown")).get_by_text("a value", exact=True).click()
    field = drop.locator(at("vacuum-number"))
    field.fill("900 kPa")
    field.press("Enter")
    drop.get_by_text("is not allowed").wait_for()
    field.fill("5")
    field.press("Enter")
    drop.get_by_text("The travel of 60 mm is used up").wait_for()
    # the table follows the chart
    drop.wait_for_function(
        "place => document.querySelector(place)?.innerText === 'bottomed out'",
        arg=at("value-outcome"),
    )
    drop.click("[data-testid=undo]")
    drop.wait_for_function(
        "document.querySelector('[data-testid=drop-verdict]').innerText.includes(' kPa stops ')"
    )
    assert drop.errors == []


def test_all_numbers_are_there_once_the_fold_is_open(drop):
    """They follow the settings only while they can be seen."""
    others = at("others")
    assert drop.locator(others).text_content() == ""
    drop.locator(f"{at('numbers')} [role=button]").first.click()
    drop.wait_for_function(
        "place => document.querySelector(place).innerText.includes('Dissipated energy')",
        arg=others,
    )
