"""Everybody can use every page: the automated check, keyboard, phones and large screens, paper."""

from __future__ import annotations

from itertools import pairwise

import pytest

from layerjam.core.drawing.chart import Curve, Pane
from layerjam.workbench.charts import FONT, chart_options
from layerjam.workbench.pages.all import TABS
from layerjam.workbench.session import format_session
from layerjam.workbench.state import State
from workbench.access import (
    COLORS,
    FILLED,
    FOCUS,
    LONG,
    OVER,
    PANEL,
    at,
    done,
    opened,
    turned,
    unfolded,
    wrong,
)
from workbench.evidenced import add_tests

pytestmark = pytest.mark.slow
NAMES = [tab.name for tab in TABS]
SWITCHED_OFF: dict[str, str] = {}
"""{rule of the check: why it is not asked}; every other rule is."""


@pytest.fixture(scope="module")
def page(chromium, workbench):
    """One tab for all tests of this file."""
    look = {"color_scheme": "light", "reduced_motion": "reduce"}
    made = chromium.new_page(viewport={"width": 1280, "height": 900}, **look)
    made.place = workbench
    yield made
    made.close()


@pytest.fixture(scope="module")
def axe():
    check = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe here").Axe()
    rules = {name: {"enabled": False} for name in SWITCHED_OFF}

    def violations(page, state):
        assert_no_flag(page, state)
        asked = {"rules": rules, "resultTypes": ["violations"]}
        found = check.run(page, options=asked).response["violations"]
        dark = page.evaluate("document.body.classList.contains('body--dark')")
        state += ", dark" if dark else ", light"
        return [
            f"{state}: {rule['id']} at {' '.join(map(str, node['target']))}: {node['html'][:160]}"
            for rule in found
            for node in rule["nodes"]
        ]

    return violations


FLAGS = """() => {
  const found = [], flag = /(^|[^\\w-])--[a-z]/;
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const text = walk.currentNode.nodeValue, e = walk.currentNode.parentElement;
    // a copied command keeps its own
    if (flag.test(text) && !e.closest('script, style, [data-testid=copied]')) found.push(text);
  }
  for (const e of document.querySelectorAll('[aria-label], [title], [placeholder]'))
    for (const name of ['aria-label', 'title', 'placeholder'])
      if (flag.test(e.getAttribute(name) ?? '')) found.push(e.getAttribute(name));
  return found;
}"""


def assert_no_flag(page, state):
    """No text of a page names a flag of the command line."""
    assert page.evaluate(FLAGS) == [], state


@pytest.mark.parametrize("name", NAMES)
def test_nothing_stands_against_a_page_in_any_state(page, axe, name):
    """Empty, filled, all folds open, and with errors; each in light and dark."""
    found = []

    def look(state):
        found.extend(axe(page, state))
        turned(page)
        found.extend(axe(page, state))

    opened(page, page.place, name)
    look("empty")
    for settings in FILLED.get(name, [{}]):
        opened(page, page.place, name, settings)
        done(page, name)
        unfolded(page)
        look(f"filled {settings or ''}")
    wrong(page)
    look("errors")
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    "name", ["drop", *(pytest.param(n, marks=pytest.mark.campaign) for n in ("brake", "vacuum"))]
)
def test_nothing_stands_against_intervals_and_what_they_rest_on(page, axe, name):
    """A brake within and outside its tested range, and one from a handbook."""
    tested, found = add_tests("choi2018-kapton"), []
    for vacuum, brake in ((60e3, tested), (90e3, tested), (60e3, "choi2018-kapton")):
        key = "target" if name == "vacuum" else "vacuum"
        opened(page, page.place, name, {key: vacuum}, brake=brake)
        assert page.locator(f"{PANEL} .interval").first.inner_text().startswith("95 %: ")
        word = page.locator(f"{PANEL} .basis").first.inner_text()
        for _ in range(2):
            found += axe(page, f"{name}, {word}")
            turned(page)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_nothing_stands_against_what_opens_over_a_page(page, axe, tmp_path, dark):
    """The dialog of files, empty and filled; the menu of sessions; a notice."""
    opened(page, page.place, "start")
    if dark:
        turned(page)
    found = []
    for what, (act, seen) in OVER.items():
        page.click(at(act))
        page.mouse.move(1, 300)  # no tip of the button stays open
        page.wait_for_selector(at(seen))
        page.wait_for_timeout(400)
        found += axe(page, what)
        page.keyboard.press("Escape")
        page.wait_for_selector(at(seen), state="hidden")
    rows = "\n".join(f"{x},{20 * x}" for x in range(40))
    pull = tmp_path / "pull_60kPa.csv"
    pull.write_text(f"Extension (mm),Load (N)\n{rows}\n")
    other = tmp_path / "no-test.csv"
    other.write_text("a,b\n1,2\n")
    zone = page.locator(".files-dropped input[type=file]").first
    zone.set_input_files([pull, other])
    page.wait_for_selector(at("dropped-use"))
    page.wait_for_timeout(400)
    found += axe(page, "files dropped")
    page.keyboard.press("Escape")
    page.wait_for_selector(at("dropped-use"), state="hidden")
    session = tmp_path / "mine.json"
    session.write_text(format_session(State()))
    zone.set_input_files(session)
    page.wait_for_selector(".q-notification")
    page.wait_for_timeout(400)
    found += axe(page, "a notice")
    assert not found, "\n".join(found)


def test_the_check_finds_what_is_wrong(page, axe):
    opened(page, page.place, NAMES[0])
    page.evaluate("document.querySelector('h1').insertAdjacentHTML('afterend', '<input>')")
    assert any("label" in one and "<input>" in one for one in axe(page, "spoilt"))


NUMBERED = """() => {
  const all = [...document.querySelectorAll(
    'button, a[href], input:not([type=file]), textarea, select, [tabindex]')];
  const meant = all.filter(e => e.tabIndex >= 0 && !e.disabled && !e.closest('[inert]')
     && e.checkVisibility()
    && e.getAttribute('aria-disabled') !== 'true' && e.getBoundingClientRect().width >= 1);
  document.querySelectorAll('[data-walk]').forEach(e => delete e.dataset.walk);
  meant.forEach((e, i) => { e.dataset.walk = i; });
  document.activeElement.blur();
  return meant.map(e => e.outerHTML.slice(0, 160));
}"""


def walked(page, steps):
    """What the Tab key comes by, step by step; None where the page is left."""
    for _ in range(steps):
        page.keyboard.press("Tab")
        yield page.evaluate(FOCUS)


def faint(focused):
    """What does not show that it has the focus, 3 to 1 against its ground."""
    return [one for one in focused if one and (one["wide"] < 2 or one["contrast"] < 3)]


@pytest.mark.parametrize("name", NAMES)
def test_a_page_is_walked_by_keyboard_alone(page, name):
    """The Tab key reaches every control, shows where it is, and comes out at the end."""
    opened(page, page.place, name)
    unfolded(page)
    meant = page.evaluate(NUMBERED)
    came = list(walked(page, len(meant) + 10))
    reached = {one["walk"] for one in came if one}
    missed = [html for i, html in enumerate(meant) if str(i) not in reached]
    assert (missed, faint(came)) == ([], [])
    assert None in came[1:] or {"0", str(len(meant) - 1)} <= reached
    turned(page)
    assert faint(walked(page, 30)) == []


def test_home_and_end_move_a_slider_to_its_ends(page):
    opened(page, page.place, "pull")
    field, bar = at("pull-travel-number"), f"{at('pull-travel')} [tabindex='0']"
    first = page.input_value(field)
    for key, much in (("End", "60"), ("Home", "1")):
        page.locator(bar).focus()
        page.keyboard.press(key)
        page.wait_for_function(
            "([place, much]) => document.querySelector(place).value === much", arg=[field, much]
        )
        page.wait_for_function(
            "([place, much]) => document.querySelector(place).innerText.includes(much)",
            arg=[at("pull-peak_force"), "N"],
        )
    page.wait_for_timeout(3000)
    link = page.url
    assert "s=" in link and first not in ("60", "1")
    page.goto(link)
    page.wait_for_selector(field, timeout=LONG)
    assert page.input_value(field) == "1"  # the server knew of it


CONTROLS = """() => [
    ...document.querySelectorAll('button, input[type=range], .q-slider, .q-uploader')]
  .filter(e => e.checkVisibility() && e.getAttribute('aria-pressed') !== 'true')
  .map(e => e.outerHTML.slice(0, 120))"""
FACES = """() => {
  const found = new Set();
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const e = walk.currentNode.parentElement;
    if (!walk.currentNode.nodeValue.trim() || !e.checkVisibility()) continue;
    if (e.closest('.q-icon, textarea, code, pre, .font-mono, script, style')) continue;
    found.add(getComputedStyle(e).fontFamily.split(',')[0].replaceAll('"', ''));
  }
  return [...found];
}"""
COVERED = (
    f"() => {{ {COLORS} "
    """return [...document.querySelectorAll('body *')].filter(e => {
  const box = e.getBoundingClientRect(), color = rgba(getComputedStyle(e).backgroundColor);
  const over = ['fixed', 'absolute'].includes(getComputedStyle(e).position);
  return over && e.checkVisibility() && color[3] > 0 && box.width > 500 && box.height > 500;
}).map(e => e.outerHTML.slice(0, 120)); }"""
)
WIDE = "document.documentElement.scrollWidth"


@pytest.mark.parametrize("name", NAMES)
def test_a_phone_a_large_screen_and_paper_are_used_well(page, name):
    opened(page, page.place, name)
    assert page.evaluate(FACES) == ["Roboto"]
    usual = areas(page)
    try:
        page.set_viewport_size({"width": 390, "height": 844})
        page.wait_for_timeout(300)
        assert page.evaluate(WIDE) <= 390
        unfolds(page)
        page.set_viewport_size({"width": 1920, "height": 1080})
        page.wait_for_timeout(500)
        large = areas(page)
        assert all(now > 1.3 * before for now, before in zip(large, usual, strict=True))
        for box in (one.bounding_box() for one in page.locator(f"{PANEL} [role=status]").all()):
            assert box is None or box["width"] < 1100
        turned(page)
        page.emulate_media(media="print")
        page.set_viewport_size({"width": 720, "height": 1000})  # A4 less its margins
        page.wait_for_timeout(500)
        assert page.evaluate(CONTROLS) == []
        for box in (one.bounding_box() for one in page.locator(f"{PANEL} .chart:visible").all()):
            assert box["height"] > 250
        covers = page.evaluate(COVERED)
        assert covers == [], "what lies over the page hides it on paper"
        ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert ground == "rgb(255, 255, 255)"
        assert page.evaluate(WIDE) <= 720 and page.locator(f"{PANEL} h1").is_visible()
    finally:
        page.emulate_media(media="screen")
        page.set_viewport_size({"width": 1280, "height": 900})


def areas(page):
    """How large the charts are [pixels]."""
    boxes = [one.bounding_box() for one in page.locator(f"{PANEL} .nicegui-echart:visible").all()]
    return [box["width"] * box["height"] for box in boxes]


def unfolds(page):
    """Where a narrow window hides controls, a button shows them."""
    more = page.locator(f"{PANEL} .side-more:visible")
    if more.count():
        shown = page.locator(f"{PANEL} .side > :visible")
        few = shown.count()
        assert more.first.get_attribute("aria-expanded") == "false"
        more.first.click()
        assert more.first.get_attribute("aria-expanded") == "true"
        assert shown.count() > few and page.evaluate(WIDE) <= 390


def test_figures_and_charts_have_the_typeface_of_the_page(page):
    opened(page, page.place, "design", {"part": "machines"})
    page.wait_for_selector(f"{at('design-pictures')} svg text", timeout=LONG)
    assert page.evaluate(FACES) == ["Roboto"]
    assert FONT.startswith("Roboto")
    ours = "f => f.family.includes('Roboto') && f.status === 'loaded'"
    assert page.evaluate(f"[...document.fonts].some({ours})")


def test_drawings_follow_light_and_dark(page):
    opened(page, page.place, "design", {"part": "machines"})
    words = f"{at('design-pictures')} svg text"
    page.wait_for_selector(words, timeout=LONG)
    ink = f"getComputedStyle(document.querySelector('{words}')).fill.match(/[0-9]+/g)"
    light = [int(part) for part in page.evaluate(ink)]
    turned(page)
    dark = [int(part) for part in page.evaluate(ink)]
    assert sum(light) / 765 < 0.35 < 0.75 < sum(dark) / 765


ENDS = """([id, made]) => {
  const chart = getElement(id).chart;
  chart.setOption(made, true);
  return chart.getZr().storage.getDisplayList(true)
    .filter(e => e.type === 'tspan' && /^curve/.test(e.style.text))
    .map(e => { const r = e.getBoundingRect().clone(); r.applyTransform(e.transform);
                return [r.x, r.y, r.width, r.height, e.style.text]; });
}"""


def test_names_at_the_ends_of_many_curves_do_not_overprint(page):
    opened(page, page.place, "pull")
    curves = [Curve([0, 1], [0, 100 + 0.4 * k], name=f"curve {k}") for k in range(9)]
    made = chart_options([Pane(curves, "x", "y")])
    chart = int(page.locator(at("pull-chart")).get_attribute("id")[1:])
    boxes = page.evaluate(ENDS, [chart, made])
    assert len(boxes) == len(curves)
    boxes.sort(key=lambda box: box[1])
    for above, below in pairwise(boxes):
        assert above[1] + above[3] <= below[1] + 1.0, (above, below)
    room = page.locator(at("pull-chart")).bounding_box()
    assert all(b[1] >= 0 and b[1] + b[3] <= room["height"] for b in boxes)
    assert all(b[0] + b[2] <= room["width"] for b in boxes)
