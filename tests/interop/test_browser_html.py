"""The page of `export html` in Chromium, opened from disk without a network."""

from __future__ import annotations

import re

import pytest

from interop.live_cases import check_answers, kernel_script, make_cases, safe_vacuum
from interop.test_refusals import file_of
from layerjam.bench.control.plan import Arrival, needed_vacuum
from layerjam.brake.device.load import load
from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.mechanics.pull import brake_force
from layerjam.core.units import show

pytest.importorskip("jinja2", reason="the extra report is not installed")

from layerjam.interop.commands.export import export_html

pytestmark = pytest.mark.slow
FILE = load("choi2018-kapton")
BRAKE = FILE.brake
DESK, PHONE = {"width": 1280, "height": 900}, {"width": 360, "height": 740}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("html")
    export_html(FILE, out=folder / "brake.html")
    (folder / "own.toml").write_text(file_of("speed_law"), encoding="utf-8")
    export_html(folder / "own.toml", out=folder / "not-live.html")
    return folder


@pytest.fixture
def opened(chromium, place):
    """A function that opens a file; requests and errors of its page fail the test."""
    pages, requests, errors = [], [], []

    def open_page(name="brake.html", **look):
        context = chromium.new_context(**{"viewport": DESK, "offline": True, **look})
        pages.append(context)
        page = context.new_page()
        page.on("request", lambda r: requests.append(r.url))
        page.on("console", lambda m: errors.append(m.text))
        page.on("pageerror", lambda e: errors.append(str(e)))
        page.goto((place / name).as_uri())
        if name == "brake.html":
            page.wait_for_selector("#live-stop-chart circle")
        return page

    yield open_page
    for context in pages:
        context.close()
    assert errors == []
    assert {url.rpartition("/")[2] for url in requests} <= {"brake.html", "not-live.html"}


def fill(page, name, value):
    """Type a value, and wait for the frame that shows it."""
    page.fill(f"#live-number-{name}", str(value))
    settle(page)


def settle(page):
    """Wait until the page has drawn its next frame."""
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => setTimeout(done)))")


def read(page, name):
    return page.inner_text(f"#live-{name}").replace("\u00a0", " ")


def test_chromium_computes_the_digits_of_python(chromium):
    inputs = make_cases()
    page = chromium.new_page()
    answers = page.evaluate(f"inputs => {{ {kernel_script()} return answer(inputs); }}", inputs)
    page.close()
    check_answers(inputs, answers)


def test_every_part_shows_the_numbers_of_python(opened):
    page = opened()
    fill(page, "vacuum", 94.5)
    fill(page, "slip", 20)
    assert read(page, "force-number") == show(float(brake_force(0.02, 94.5e3, BRAKE)), "N")
    page.click("#live-again")
    kernel = Kernel(FILE)
    kernel.start(94.5e3)
    for elongation in (40, 39.5, 39.8, 39.0, 45):
        fill(page, "elongation", elongation)
        kernel.move(elongation * 1e-3, 94.5e3)
        assert read(page, "pull-number") == show(kernel.force, "N")
        assert f"slip {show(kernel.slip, 'm')}" in read(page, "pull-words")
    for name, value in {"mass": 2, "speed": 1.5, "travel": 30}.items():
        fill(page, name, value)
    case = Arrival(mass=2, speed=1.5, travel=0.03, warning=0, gravity=BRAKE.site.gravity)
    assert read(page, "stop-number") == show(safe_vacuum(BRAKE, case), "Pa")
    assert f"Without a margin: {show(needed_vacuum(BRAKE, case), 'Pa')}" in read(page, "stop-words")
    fill(page, "speed", 6)
    assert safe_vacuum(BRAKE, Arrival(mass=2, speed=6, travel=0.03, warning=0, gravity=9.8)) is None
    assert read(page, "stop-number") == "none" and "No vacuum of this site" in read(
        page, "stop-words"
    )


def test_the_keyboard_reaches_and_moves_everything(opened):
    page = opened()
    seen = []
    for _ in range(40):
        page.keyboard.press("Tab")
        focus = "e => [e.id || e.getAttribute('aria-label'), getComputedStyle(e).outlineStyle]"
        name, outline = page.evaluate(f"({focus})(document.activeElement)")
        assert outline != "none" or not name, name
        seen.append(name)
        if name == "Slip" and seen.count("Slip") == 1:
            before = read(page, "force-number")
            page.keyboard.press("End")
            settle(page)
            assert read(page, "force-number") != before
            assert page.input_value("#live-number-slip") == "60"
    fields = ("Vacuum", "Slip", "Elongation", "Mass", "Speed", "Travel allowed", "Margin")
    assert {*fields, "live-out", "live-back", "live-again", "live-falls"} <= {*seen}


def test_a_curve_is_dragged_and_a_wrong_number_is_explained(opened):
    page = opened()
    page.locator("#live-force-chart").scroll_into_view_if_needed()
    box = page.locator("#live-force-chart").bounding_box()
    page.mouse.move(box["x"] + 60, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] + 30, box["y"] + 120, steps=4)
    page.mouse.up()
    assert page.input_value("#live-number-slip") == "60"
    fill(page, "vacuum", 200)
    said = page.evaluate("document.getElementById('live-number-vacuum').validationMessage")
    assert said == "Value must be less than or equal to 101.325."
    assert "60 kPa" in read(page, "force-words")
    page.locator("#live-number-vacuum").blur()
    assert page.input_value("#live-number-vacuum") == "60"


@pytest.mark.parametrize("viewport", [DESK, PHONE], ids=["desk", "phone"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_stands_against_the_page(opened, viewport, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe here").Axe()
    for name in ("brake.html", "not-live.html"):
        page = opened(name, viewport=viewport, color_scheme=scheme)
        found = axe.run(page, options={"resultTypes": ["violations"]}).response["violations"]
        assert [(rule["id"], rule["nodes"][0]["html"][:90]) for rule in found] == []
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        # no label of a drawing is cut off at a side
        outside = page.evaluate("""() => [...document.querySelectorAll('svg text')].filter(t => {
          const [a, b] = [t.getBoundingClientRect(), t.ownerSVGElement.getBoundingClientRect()];
          return a.left < b.left - 1 || a.right > b.right + 1;
        }).map(t => t.textContent)""")
        assert outside == []


def test_paper_has_the_numbers_and_no_controls(opened):
    page = opened()
    page.emulate_media(media="print")
    assert page.locator("#live-force-number").is_visible()
    assert page.locator("#live-number-vacuum").is_visible()
    assert not page.locator("#live-parts input[type=range]").first.is_visible()
    assert not page.locator("#live-out").is_visible()
    assert re.match(rb"%PDF", page.pdf())
