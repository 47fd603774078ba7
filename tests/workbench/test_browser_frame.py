"""The frame in a browser: links, undo, copying, keyboard, contrast, no request elsewhere; and the
server when things go wrong."""

from __future__ import annotations

import http.client
import json
import signal
import subprocess
import sys
import time
import urllib.request
from contextlib import closing
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from counts import cases
from layerjam.core.units import show
from layerjam.workbench.widgets import round_value
from printed import split_command
from workbench.access import CONTRAST, QUIET
from workbench.conftest import running

pytestmark = pytest.mark.slow
LONG = 90_000
TABS = {
    "start": "[data-testid=start-chart] canvas",
    "brake": "[data-testid=brake-numbers]",
    "pull": "[data-testid=pull-chart] canvas",
    "drop": "[data-testid=drop-chart] canvas",
    "vacuum": "[data-testid=vacuum-chart] canvas",
    "laboratory": "[data-testid=laboratory-drop]",
    "design": "[data-testid^=design]:visible",
    "bench": "[data-testid=bench-connect]",
}
UNNAMED = """() => [...document.querySelectorAll(
    'input:not([type=file]), select, textarea, button, [role=slider], [role=tab], canvas')]
  .filter(e => e.checkVisibility() && !(e.getAttribute('aria-label') || e.labels?.length
    || e.innerText?.trim() || e.closest('[aria-label]')))
  .map(e => e.outerHTML.slice(0, 120))"""


def at(ident: str) -> str:
    return f'[data-testid="{ident}"]'


def opened(page, name):
    page.click(at(f"tab-{name}"))
    page.wait_for_selector(TABS[name], timeout=LONG)


def peak(page, old=""):
    """What stands as the peak force, once it is another than `old`."""
    page.wait_for_function(
        "old => { const e = document.querySelector('[data-testid=pull-peak_force]');"
        " return e && e.innerText.length > 2 && e.innerText !== old; }", arg=old, timeout=LONG,
    )  # fmt: skip
    return page.inner_text(at("pull-peak_force"))


def moved(page, times=30):
    """The vacuum's slider, by its keys."""
    page.locator(f"{at('pull-vacuum')} [tabindex='0']").first.focus()
    for _ in range(times):
        page.keyboard.press("ArrowLeft")
    page.wait_for_timeout(1500)


@pytest.fixture
def pull(tab):
    opened(tab, "pull")
    peak(tab)
    return tab


def test_a_link_brings_everything_back_after_a_reload(pull):
    first = peak(pull)
    moved(pull)
    force = peak(pull, first)
    vacuum = pull.input_value(at("pull-vacuum-number"))
    assert vacuum == "86.9" and "s=" in pull.url
    pull.reload()
    assert peak(pull) == force
    assert pull.input_value(at("pull-vacuum-number")) == vacuum
    assert not pull.errors


def test_undo_and_redo_by_keys(pull):
    first = peak(pull)
    moved(pull)
    force = peak(pull, first)
    pull.keyboard.press("Control+z")
    assert peak(pull, force) == first
    assert pull.input_value(at("pull-vacuum-number")) == "94.5"
    value = f"{at('pull-vacuum')} [role=slider], {at('pull-vacuum')}[role=slider]"
    assert pull.locator(value).first.get_attribute("aria-valuenow") == "94.5"
    pull.keyboard.press("Control+Shift+z")
    assert peak(pull, first) == force
    assert not pull.errors


def copied(page, button):
    page.click(at(button))
    shown = page.locator(at("copied"))
    filled = "box => box.innerText.includes('layerjam')"  # the code comes after its box
    page.wait_for_function(filled, arg=shown.element_handle(timeout=LONG), timeout=LONG)
    text = shown.inner_text()
    page.get_by_role("button", name="Close").click()
    shown.wait_for(state="hidden")
    return text.replace("content_copy", "").strip()


def test_what_is_copied_gives_the_number_on_the_page(pull, tmp_path):
    first = peak(pull)
    moved(pull, 7)
    shown = peak(pull, first)
    words = split_command(copied(pull, "copy-as-command").splitlines()[0])
    assert words[0] == "layerjam"
    words = [sys.executable, "-m", "layerjam.cli.main", *words[1:], "--json"]
    said = subprocess.run(words, capture_output=True, text=True, check=True, cwd=tmp_path)
    force = json.loads(said.stdout)["peak_force"]
    assert round_value(show(force, "N")) == shown
    code = copied(pull, "copy-as-python") + "\nprint(result.peak_force.hex())"
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert float.fromhex(said.stdout.split()[-1]) == force


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_page_is_readable_named_and_asks_nobody_else(chromium, workbench, scheme):
    own = urlsplit(workbench).netloc
    context = chromium.new_context(color_scheme=scheme, viewport={"width": 1280, "height": 800})
    page, asked = context.new_page(), []
    page.on("request", lambda r: asked.append(r.url))
    page.on("websocket", lambda w: asked.append(w.url))
    page.goto(workbench)
    for name in TABS:
        opened(page, name)
        for width in (1280, 820):
            page.set_viewport_size({"width": width, "height": 1000})
            page.evaluate(QUIET)
            wide = page.evaluate("document.documentElement.scrollWidth")
            assert wide <= width, (name, width)
            assert page.evaluate(CONTRAST) == [], (name, width)
        assert page.evaluate(UNNAMED) == [], name
    assert any(u.startswith("ws:") for u in asked)
    strange = {
        u for u in asked if not u.startswith(("data:", "blob:")) and urlsplit(u).netloc != own
    }
    assert not strange
    # the check itself: a faint text is found
    page.evaluate("""document.body.insertAdjacentHTML('beforeend',
      '<p style="position:fixed;top:50%;color:#888;background:#777">faint</p>')""")
    assert [bad["text"] for bad in page.evaluate(CONTRAST)] == ["faint"]
    context.close()


def test_axes_can_be_read_in_the_dark(chromium, workbench):
    found = {}
    for scheme in ("light", "dark"):
        context = chromium.new_context(color_scheme=scheme)
        page = context.new_page()
        page.goto(workbench)
        for name, chart in (("pull", "pull-chart"), ("drop", "drop-chart"),
                            ("vacuum", "vacuum-chart")):  # fmt: skip
            opened(page, name)
            page.evaluate(QUIET)
            colors = page.evaluate(
                "place => { const o = getElement(+document.querySelector(place).id.slice(1)).chart"
                ""
                ".getOption(); return [...o.xAxis, ...o.yAxis].map(a => a.axisLabel)"
                ".filter(l => l.show).map(l => l.color); }",
                at(chart),
            )
            found[scheme, name] = [
                sum(int(c[i : i + 2], 16) for i in (1, 3, 5)) / 765 for c in colors
            ]
        context.close()
    for name in ("pull", "drop", "vacuum"):
        assert max(found["light", name]) < 0.35 < 0.75 < min(found["dark", name])


def test_the_tabs_go_by_arrow_keys_and_focus_is_seen(tab):
    tab.wait_for_selector(TABS["start"], timeout=LONG)
    tab.focus(at("tab-start"))
    for _ in range(2):
        tab.keyboard.press("ArrowRight")
    tab.keyboard.press("Enter")
    tab.wait_for_selector(TABS["pull"], timeout=LONG)
    peak(tab)
    seen = []
    for _ in range(30):
        tab.keyboard.press("Tab")
        seen.append(
            tab.evaluate("""() => { const e = document.activeElement;
          const ring = getComputedStyle(e).outlineStyle !== 'none'
            || !!e.closest('.q-field--focused, .q-slider')
            || !!e.querySelector('.q-focus-helper, .q-slider__focus-ring');
          return [e.closest('[data-testid]')?.dataset.testid || e.tagName, ring]; }""")
        )
    order = [name for name, _ in seen]
    wanted = ["pull-vacuum-number", "pull-vacuum", "pull-speed-number", "pull-speed",
              "pull-travel-number", "pull-travel", "pull-model"]  # fmt: skip
    places = [order.index(name) for name in wanted]
    assert places == sorted(places)
    assert all(ring for _, ring in seen if _ != "BODY")


def test_a_link_of_rubbish_opens_a_fresh_page_with_a_sentence(chromium, workbench):
    page = chromium.new_page()
    page.goto(f"{workbench}?s=rubbish")
    page.get_by_text("the page uses the default values").wait_for(timeout=LONG)
    page.wait_for_selector(TABS["start"], timeout=LONG)
    page.close()


def test_many_tabs(chromium, workbench):
    context = chromium.new_context()
    pages = [context.new_page() for _ in range(cases(20, 8))]
    for page in pages:
        page.goto(workbench)
    for page in pages:
        page.wait_for_selector(TABS["start"], timeout=LONG)
    opened(pages[-1], "pull")
    assert peak(pages[-1]).endswith("N")
    context.close()


def test_a_tab_closed_while_it_computes(chromium, tmp_path):
    """The computation ends, the tab's folder goes, nothing is said, others are served."""
    log, folder = tmp_path / "log", tmp_path / "temporary"
    folder.mkdir()
    with log.open("w") as told, running(folder=folder, tell=told) as (place, process):
        page = chromium.new_page()
        page.goto(place)
        opened(page, "laboratory")
        page.get_by_text("Try with synthetic files").click()
        page.wait_for_timeout(300)
        for _ in range(100):
            if list(folder.glob("layerjam-workbench-*")):
                break
            page.wait_for_timeout(100)
        assert list(folder.glob("layerjam-workbench-*"))
        page.close()
        for _ in range(180):
            if not list(folder.glob("layerjam-workbench-*")):
                break
            time.sleep(1)
        assert not list(folder.glob("layerjam-workbench-*"))
        other = chromium.new_page()
        other.goto(place)
        opened(other, "pull")
        assert peak(other).endswith("N")
        other.close()
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 0
    assert log.read_text() == ""


def refused(*options):
    program = str(Path(sys.executable).with_name("layerjam"))
    words = [program, "workbench", "--no-show", *options]
    said = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr.startswith("layerjam: ") and said.stderr.count("\n") == 1
    return said.stderr


def test_a_used_port_and_a_strange_host_are_refused_in_a_sentence(workbench):
    port = str(urlsplit(workbench).port)
    assert f"port: {port} is in use by another program" in refused("--port", port)
    assert "not an address of this machine" in refused("--host", "rubbish")
    assert "not an address of this machine" in refused("--host", "192.0.2.7")


def asked(port, path, **headers):
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=30)) as link:
        link.request("GET", path, headers=headers)
        with link.getresponse() as answer:
            return answer.status, answer.getheader("set-cookie") or ""


def test_beyond_this_machine_a_token_is_due(chromium):
    with running("--host", "0.0.0.0") as (place, _):
        parts = urlsplit(place)
        port, token = parts.port, parts.query.removeprefix("token=")
        assert len(token) > 20
        assert asked(port, "/")[0] == 401 and asked(port, "/?token=wrong")[0] == 401
        status, cookie = asked(port, f"/?token={token}")
        assert status == 303 and "HttpOnly" in cookie
        assert asked(port, "/", Cookie=cookie.split(";")[0])[0] == 200
        socket = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
                  "Sec-WebSocket-Key": "bGF5ZXJqYW0gYnJha2VzIQ=="}  # fmt: skip
        way = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
        assert asked(port, way, **socket)[0] == 403
        page = chromium.new_context().new_page()
        page.goto(place)
        page.wait_for_selector(TABS["start"], timeout=LONG)
        assert "token" not in page.url
        page.close()


def test_another_address_of_this_machine_is_served():
    with (
        running("--host", "127.0.0.2") as (place, _),
        urllib.request.urlopen(place, timeout=30) as answer,
    ):
        assert answer.status == 200 and "127.0.0.2" in place


@pytest.mark.parametrize("forbids", [True, False], ids=["forbidden", "by selection"])
def test_copying_where_the_browser_has_no_clipboard(chromium, workbench, forbids):
    """Outside https and this machine a page gets none; what was not copied is not called so."""
    page = chromium.new_page()
    page.add_init_script("Object.defineProperty(navigator, 'clipboard', {value: undefined});")
    if forbids:
        page.add_init_script("document.execCommand = () => false;")
    page.goto(workbench)
    page.wait_for_selector(TABS["start"], timeout=LONG)
    page.click(at("copy-as-python"))
    said = page.locator(".q-dialog .font-medium")
    said.wait_for(timeout=LONG)
    assert ("does not allow this page to copy" in said.inner_text()) == forbids
    page.keyboard.press("Escape")
    page.click(at("copy-a-link-to-all-settings"))
    words = "does not allow this page to copy" if forbids else "Link copied"
    page.locator(".q-notification", has_text=words).wait_for(timeout=LONG)
    page.close()
