"""How a page is brought into a state, and scripts that look at it as everybody who uses it does."""

from __future__ import annotations

from pathlib import Path

from layerjam.workbench.state import State, format_link

LONG = 90_000
FILLED = {
    "brake": [{"part": "build"}],
    "pull": [{"model": "judder"}],
    "drop": [{"shown": "value", "direction": "horizontal"}],
    "vacuum": [{"safe_state": "release", "fault": "leak"}],
    "design": [{"part": "arrays"}, {"part": "density"}, {"part": "machines"}],
}
"""Settings under which more of a page stands than at first; a page that is not named has one."""
DEEDS = {
    "laboratory": (
        "[data-testid=laboratory-practice]",
        "[data-testid=laboratory-files] tbody td:nth-child(2):visible",
    ),
    "bench": ("[data-testid=bench-connect]",),
}
"""What is clicked for that, where settings alone do not bring it."""
QUIET = """() => new Promise(done => {
  const busy = () => [...document.querySelectorAll('.q-spinner')].some(e => e.checkVisibility());
  const rests = () => { if (busy()) timer = setTimeout(rests, 300); else done(); };
  let timer = setTimeout(rests, 900);
  new MutationObserver(() => { clearTimeout(timer); timer = setTimeout(rests, 900); })
    .observe(document.body, {childList: true, subtree: true});
  setTimeout(done, 100000);
})"""
"""Until nothing comes or goes on the page, and nothing is being computed."""
UNFOLD = """() => {
  const shut = '.q-expansion-item [role=button][aria-expanded=false]';
  const heads = [...document.querySelectorAll(shut)].filter(e => e.checkVisibility());
  heads.forEach(e => e.click());
  return heads.length;
}"""
OVER = {
    "files, none yet": ("start-files", "dropped-choose"),
    "copied Python": ("copy-as-python", "copied"),
}
"""{what opens over a page: the button that opens it, what is seen then}."""
ZOOM = """place => Object.fromEntries(
  getElement(+document.querySelector(place).id.slice(1)).chart.getOption().dataZoom
    .map(z => [z.id, [z.start, z.end]]))"""
"""{axis: [from, to], percent of it} of a chart; empty while nobody has pointed at it."""
WHOLE = {"x": [0, 100], "y0": [0, 100]}
"""Of a chart with one pair of axes."""
PANEL = ".q-tab-panel:visible"
"""The open page."""


HERE = Path(__file__).parent
COLORS = (HERE / "colors.js").read_text("utf-8")


def script(name):
    """A script of this folder as a function, with what it needs to look at colours."""
    return f"() => {{ {COLORS} {(HERE / name).read_text('utf-8')} }}"


CONTRAST, FOCUS = script("contrast.js"), script("focus.js")


def at(ident):
    return f'[data-testid="{ident}"]'


def opened(page, place, tab, settings=None, **state):
    """A page, once it stands still, in a tab that has no files of the test before."""
    if page.url.startswith("http"):
        page.evaluate("sessionStorage.clear()")
    shown = State(page=tab, settings={tab: settings} if settings else {}, **state)
    page.goto(f"{place}?s={format_link(shown)}")
    page.wait_for_selector(f"{PANEL} h1", timeout=LONG)
    page.evaluate(QUIET)


def done(page, tab):
    """What a page's settings do not bring, by clicks."""
    for place in DEEDS.get(tab, ()):
        page.locator(place).first.click()
        page.mouse.move(1, 300)
        page.evaluate(QUIET)


def unfolded(page):
    """Every fold of the page opened, with those inside of it."""
    for _ in range(4):
        if not page.evaluate(UNFOLD):
            break
        page.evaluate(QUIET)


def wrong(page):
    """Rubbish typed into the fields of the page, which say so."""
    fields = page.locator(f"{PANEL} input[type=text]:visible, {PANEL} input:not([type]):visible")
    for place in range(12):
        if place >= fields.count():  # a refused word may fold away what it asked for
            break
        field = fields.nth(place)
        if field.get_attribute("role") != "combobox" and field.is_editable():
            field.fill("rubbish")
            field.press("Enter")
    page.evaluate(QUIET)


def turned(page):
    """The other of light and dark; no tip of the button stays open."""
    page.click(at("light-or-dark"))
    page.mouse.move(1, 300)
    page.wait_for_timeout(700)
