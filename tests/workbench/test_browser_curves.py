"""What one does with a curve in a browser: zoom it, drag its peak, with mouse and keyboard."""

from __future__ import annotations

import pytest

from workbench.access import LONG, WHOLE, ZOOM, at, opened

pytestmark = pytest.mark.slow
CHART = at("pull-chart")


@pytest.fixture(scope="module")
def pull(chromium, workbench):
    """One tab for all tests of this file."""
    page = chromium.new_page(viewport={"width": 1280, "height": 500})
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    opened(page, workbench, "pull")
    page.wait_for_selector(f"{CHART} canvas", timeout=LONG)
    yield page
    assert page.errors == []
    page.close()


def shown(page):
    page.wait_for_timeout(250)
    return page.evaluate(ZOOM, CHART)


def test_a_chart_is_zoomed_and_a_slider_keeps_it(pull):
    assert pull.evaluate(ZOOM, CHART) == {}  # what nobody points at costs nothing
    pull.locator(CHART).hover(position={"x": 200, "y": 100})
    pull.mouse.wheel(0, 150)
    assert shown(pull) == WHOLE
    assert pull.evaluate("scrollY") > 0  # the wheel alone is the page's
    pull.keyboard.down("Control")
    pull.mouse.wheel(0, -300)
    pull.keyboard.up("Control")
    near = shown(pull)
    assert all(end - start < 95 for start, end in near.values())
    assert pull.evaluate("visualViewport.scale") == 1
    peak = pull.inner_text(at("pull-peak_force"))
    pull.locator(f"{at('pull-vacuum')} [tabindex='0']").focus()
    pull.keyboard.press("Home")
    pull.wait_for_function(
        "([place, old]) => document.querySelector(place).innerText !== old",
        arg=[at("pull-peak_force"), peak],
    )
    assert shown(pull) == near
    pull.click(at("pull-pin"))  # another number of curves: the chart is made anew
    pull.wait_for_selector(at("pull-unpin-0"))
    assert shown(pull) == near
    pull.locator(CHART).dblclick(position={"x": 200, "y": 100})
    assert shown(pull) == WHOLE


def test_the_keyboard_zooms_moves_and_shows_all(pull):
    pull.get_by_role("button", name="Zoom in: Force versus elongation").focus()
    pull.keyboard.press("Enter")
    near = shown(pull)
    assert near["x"] == near["y0"] == [20, 80]
    pull.keyboard.press("ArrowRight")
    pull.keyboard.press("ArrowUp")
    moved = shown(pull)
    assert moved["x"] == moved["y0"] == pytest.approx([32, 92])
    pull.get_by_role("button", name="Show all: Force versus elongation").focus()
    pull.keyboard.press("Enter")
    assert shown(pull) == WHOLE


def wait_for_peak(page, force):
    """Until table, sentence, handle and field have followed to a peak [N], of which the chart draws
    four digits and the vacuum keeps whole pascals; answers on the way to it do not count."""
    page.wait_for_function(
        "([said, peak, handle, field, force]) => {"
        " const f = parseFloat(document.querySelector(peak).title);"
        " return Math.abs(f - force) < 0.3"
        " && document.querySelector(said).innerText.includes(`a peak of ${f} N`)"
        " && Math.abs(document.querySelector(handle).ariaValueNow - f) < 0.1"
        " && Math.abs(parseFloat(document.querySelector(field).value) - f) < 0.1; }",
        arg=[
            *map(at, ("pull-peak-said", "pull-peak_force", "pull-peak-handle", "pull-peak")),
            force,
        ],
        timeout=LONG,
    )


def test_the_peak_is_dragged_and_the_vacuum_follows(pull):
    words = "([place, word]) => document.querySelector(place).innerText.startsWith(word)"
    said = at("pull-peak-said")
    field = pull.locator(at("pull-peak"))
    field.fill("150")
    field.press("Enter")
    pull.wait_for_function(words, arg=[said, "A vacuum of 80."], timeout=LONG)
    handle = pull.locator(at("pull-peak-handle"))
    handle.scroll_into_view_if_needed()
    box = handle.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    pull.mouse.move(x, y)
    pull.mouse.down()
    pull.mouse.move(x, y + 40, steps=4)
    pull.wait_for_function(
        "([handle, y]) => { const box = document.querySelector(handle).getBoundingClientRect();"
        " return Math.abs(box.top + box.height / 2 - y) < 2; }",
        arg=[at("pull-peak-handle"), y + 40],
        timeout=LONG,
    )
    asked = float(handle.get_attribute("aria-valuenow"))
    assert 60 < asked < 145
    pull.mouse.up()
    wait_for_peak(pull, asked)
    handle.press("ArrowUp")
    asked += float(handle.get_attribute("aria-valuemax")) / 100
    # the field follows with the answer: what is typed before that would be written over
    wait_for_peak(pull, asked)
    field.fill("900")
    field.press("Enter")
    pull.wait_for_function(words, arg=[said, "No vacuum up to 101.3 kPa"], timeout=LONG)
    assert "the highest possible peak is 188.6 N" in pull.inner_text(said)


def test_a_step_of_the_vacuum_line_and_a_drop_are_pinned(pull):
    for page, control, value in (("drop", "mass", "1.6"), ("vacuum", "target", "60")):
        pull.click(at(f"tab-{page}"))
        said = {"drop": "drop-verdict", "vacuum": "vacuum-rise-words"}[page]
        pull.wait_for_function(
            "place => document.querySelector(place)?.innerText.length > 9",
            arg=at(said),
            timeout=LONG,
        )
        pull.click(at(f"{page}-pin"))
        field = pull.locator(at(f"{page}-{control}-number"))
        field.fill(value)
        field.press("Enter")
        pull.wait_for_function(
            "([place, pins]) => { const said = document.querySelector(pins).innerText;"
            " return !said.startsWith('as shown')"
            " && getElement(+document.querySelector(place).id.slice(1)).chart"
            ".getOption().series.some(s => s.name && said.startsWith(s.name)); }",
            arg=[at(f"{page}-chart"), at(f"{page}-pins")],
            timeout=LONG,
        )


NAMES = """place => {
  const element = document.querySelector(place), list = element.querySelector('.chart-names');
  const made = getElement(+element.id.slice(1)).chart.getOption();
  return {
    below: [...list.querySelectorAll('li')].map(li => li.innerText),
    beside: made.series.filter(one => one.endLabel?.show).map(one => one.name),
    room: made.grid.map(one => one.right),
    plot: element.querySelector('canvas').getBoundingClientRect().height,
    clear: list.hidden || list.getBoundingClientRect().top
      >= element.querySelector('canvas').getBoundingClientRect().bottom - 1,
  };
}"""


def test_a_phone_has_the_names_below_its_chart(pull):
    """Beside the curves they take over 60 pixels; turned around, the phone has room for that."""
    pull.set_viewport_size({"width": 1280, "height": 800})
    pull.click(at("tab-pull"))
    pull.wait_for_selector(f"{CHART} canvas")
    pins = pull.locator("[data-testid^=pull-unpin-]")
    while pins.count() < 2:
        many = pins.count()
        pull.locator(f"{at('pull-vacuum')} [tabindex='0']").focus()
        pull.keyboard.press("End" if many else "Home")
        pull.wait_for_timeout(1500)
        pull.click(at("pull-pin"))
        pull.wait_for_function(
            "many => document.querySelectorAll('[data-testid^=pull-unpin-]').length > many",
            arg=many,
        )
    pull.wait_for_timeout(500)
    wide = pull.evaluate(NAMES, CHART)
    assert wide["below"] == [] and len(wide["beside"]) == 3 and max(wide["room"]) > 60
    pull.set_viewport_size({"width": 390, "height": 844})
    pull.wait_for_function(
        "place => document.querySelector(place + ' .chart-names li')", arg=CHART, timeout=LONG
    )
    pull.wait_for_timeout(500)
    phone = pull.evaluate(NAMES, CHART)
    assert phone["below"] == wide["beside"] and phone["beside"] == []
    assert max(phone["room"]) < 40 and phone["clear"] and phone["plot"] > 290
    pins.first.click()
    pull.wait_for_function(
        "place => document.querySelectorAll(place + ' .chart-names li').length === 2", arg=CHART
    )
    pull.set_viewport_size({"width": 1280, "height": 800})
    pull.wait_for_function("place => document.querySelector(place + ' .chart-names').hidden",
                           arg=CHART)  # fmt: skip
    pull.wait_for_timeout(500)
    again = pull.evaluate(NAMES, CHART)
    assert again["below"] == [] and len(again["beside"]) == 2
    assert max(again["room"]) > 60


@pytest.mark.parametrize(
    ("name", "slider", "settings"),
    [
        ("start", "start-vacuum", {}),
        ("brake", "brake-slip", {}),
        ("pull", "pull-vacuum", {"model": "stack"}),
        ("drop", "drop-mass", {}),
        ("vacuum", "vacuum-target", {"safe_state": "hold"}),
    ],
)
def test_a_move_of_a_slider_sends_no_element(tab, workbench, name, slider, settings):
    """An element that is sent lays out the whole page, which takes as long as the numbers."""
    opened(tab, workbench, name, settings)
    tab.evaluate("window.sent = []; socket.onAny((name, what) => sent.push([name, what]))")
    tab.locator(f"{at(slider)} [tabindex='0']").first.focus()

    def move(count):
        for answers in range(1, count + 1):
            tab.keyboard.press("ArrowRight")
            tab.wait_for_function(
                "answers => sent.filter(([kind, what]) => kind === 'run_javascript'"
                " && what.code.startsWith('layerjamLive')).length >= answers",
                arg=answers,
                timeout=LONG,
            )

    def updates_of_moves(count):
        tab.evaluate("sent.length = 0")
        move(count)
        tab.wait_for_timeout(300)
        return [what for kind, what in tab.evaluate("sent") if kind == "update"]

    for _ in range(5):  # the start of the page may still send something
        if not updates_of_moves(1):
            break
    assert updates_of_moves(4) == []
