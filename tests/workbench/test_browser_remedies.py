"""A field that rejects a number offers the nearest allowed one, and one click sets it."""

import pytest

from layerjam.core.units import parse
from workbench.access import LONG, at, opened

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("tab_name", "field", "typed", "unit"),
    [
        ("start", "start-vacuum", "500", "kPa"),
        ("pull", "pull-speed", "-1", "mm/s"),
        ("drop", "drop-mass", "-3", "kg"),
        ("vacuum", "vacuum-target", "400", "kPa"),
    ],
)
def test_the_nearest_allowed_number_is_one_click_away(tab, workbench, tab_name, field, typed, unit):
    opened(tab, workbench, tab_name)
    number, remedy = tab.locator(at(f"{field}-number")), tab.locator(at(f"{field}-number-remedy"))
    number.wait_for(timeout=LONG)
    number.fill(typed)
    number.press("Enter")
    remedy.wait_for(timeout=LONG)
    error = tab.locator(".q-field--error").get_by_role("alert").first
    assert typed in error.inner_text()
    offered = remedy.text_content().removeprefix("Use ")
    remedy.click(delay=500)  # a finger is slower than the answer to leaving the field
    remedy.wait_for(state="detached", timeout=LONG)
    value = parse(f"{number.input_value()} {unit}", unit, field)
    assert value == pytest.approx(parse(offered, unit, field), rel=1e-5)
    assert tab.locator(".q-field--error").count() == 0
    assert tab.errors == []
