"""Files dropped anywhere, as a new user would: real drops, real clicks, screenshots kept."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import layerjam as lj
from layerjam.workbench.pages.laboratory_files import make_practice_files

pytestmark = pytest.mark.slow
LONG = 120_000
BEGIN = """(spec) => {
  const data = new DataTransfer();
  for (const [name, text] of spec) data.items.add(new File([text], name));
  window.dropped = data;
  document.body.dispatchEvent(
    new DragEvent('dragover', {dataTransfer: data, bubbles: true, cancelable: true}));
}"""
END = """() => document.body.dispatchEvent(
    new DragEvent('drop', {dataTransfer: window.dropped, bubbles: true, cancelable: true}))"""


def at(ident: str) -> str:
    return f'[data-testid="{ident}"]'


class User:
    """Counts what is done, and films it where PICTURES names a folder."""

    def __init__(self, page) -> None:
        self.page, self.actions = page, []

    def film(self, name: str) -> None:
        folder = os.environ.get("PICTURES")
        if folder:
            self.page.screenshot(path=str(Path(folder) / f"{name}.png"))

    def drop(self, *files: tuple[str, str]) -> None:
        self.actions.append("drop")
        self.page.evaluate(BEGIN, [list(f) for f in files])
        self.page.wait_for_selector(".files-veil", state="visible")
        self.film(f"{len(self.actions)}-veil")
        self.page.evaluate(END)
        assert not self.page.is_visible(".files-veil")

    def click(self, ident: str) -> None:
        self.actions.append(f"click {ident}")
        self.page.click(at(ident))

    def type(self, ident: str, text: str) -> None:
        self.actions.append(f"type {ident}")
        self.page.fill(f"{at(ident)}", text)


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """A friction test and a pull as machines write them, without sidecars."""
    made = make_practice_files(tmp_path_factory.mktemp("two"), lambda *_: None)
    named = {"friction_Kapton.csv": "friction_choi2018-kapton_1", "94.5kPa_2.csv": "94.5kPa_7mms_1"}
    found = []
    for name, part in named.items():
        data = next(d for n, d in made.items() if part in n and not n.endswith(".toml"))
        shown = name if name.startswith("friction") else f"pull_{name}"
        found.append((shown, data.decode("latin-1")))
    return found


def test_two_own_files_to_a_calibrated_brake_and_its_report_in_three_clicks(tab, two):
    user = User(tab)
    tab.wait_for_selector(at("brake-here-name"), timeout=LONG)
    user.film("0-empty")
    user.drop(*two)
    tab.wait_for_selector(at("dropped-use"), timeout=LONG)
    tab.wait_for_timeout(400)
    user.film("1-proposed")
    words = tab.inner_text(at("dropped"))
    assert "its name: friction" in words and "its name: 94.5kPa" in words
    user.type("dropped-normal_force", "2.45 N")
    user.click("dropped-use")
    tab.wait_for_selector(at("laboratory-calibrate-scale-factor"), timeout=LONG)
    tab.wait_for_selector(f"{at('laboratory-calibrate')} .figure svg", timeout=LONG)
    user.film("3-calibrated")
    with tab.expect_download(timeout=LONG) as got:
        user.click("laboratory-make-report")
    assert Path(got.value.path()).read_bytes().startswith(b"%PDF")
    user.click("laboratory-take")
    tab.wait_for_timeout(1500)
    user.film("4-on-the-desk")
    kinds = [action.partition(" ")[0] for action in user.actions]
    assert kinds == ["drop", "type", "click", "click", "click"]
    tab.click(at("tab-brake"))
    tab.wait_for_timeout(500)
    assert "calibrated" in tab.content()
    tab.click(at("tab-pull"))
    tab.wait_for_selector(f"{at('pull-files')} >> text=pull_94.5kPa_2.csv", timeout=LONG)
    user.film("5-pull")
    assert not tab.errors


def test_a_pull_is_pinned_and_a_reload_and_a_session_keep_it(tab, two, tmp_path):
    user = User(tab)
    tab.wait_for_selector(at("brake-here-name"), timeout=LONG)
    user.drop(two[1])
    tab.wait_for_selector(at("dropped-use"), timeout=LONG)
    user.click("dropped-use")
    tab.click(at("tab-pull"))
    tab.wait_for_selector(at("pull-pin-file"), timeout=LONG)
    user.click("pull-pin-file")
    label = f"synthetic, 94.5 kPa, {two[1][0]}"
    pinned = f"{at('pull-pins')} >> text={label}"
    tab.wait_for_selector(pinned, timeout=LONG)
    tab.wait_for_selector(at("pull-pin-file"), state="hidden", timeout=LONG)
    drawn = "([place, name]) => getElement(+document.querySelector(place).id.slice(1)).chart"
    drawn += ".getOption().series.find(s => s.name === name)?.data.filter(p => p.symbol).length"
    tab.wait_for_function(f"{drawn} > 20", arg=[at("pull-chart"), label], timeout=LONG)
    user.film("pinned")
    tab.click(at("copy-a-link-to-all-settings"))
    tab.wait_for_selector("text=so your file is not included", timeout=LONG)
    with tab.expect_download() as saved:
        tab.click(at("save-the-session"))
    file = tmp_path / "mine.json"
    saved.value.save_as(file)
    tab.wait_for_timeout(1500)  # the address follows
    tab.reload()
    tab.wait_for_selector(pinned, timeout=LONG)
    tab.click(f"{at('pull-pins')} button")
    tab.wait_for_selector(pinned, state="detached", timeout=LONG)
    tab.click(at("pull-file-remove"))
    tab.wait_for_selector(at("pull-file-remove"), state="detached", timeout=LONG)
    user.drop(("mine.json", file.read_text("utf-8")))
    tab.wait_for_selector(pinned, timeout=LONG)
    tab.click(at("pull-file-remove"))
    tab.wait_for_selector(pinned, state="detached", timeout=LONG)
    assert not tab.errors


def test_the_header_shows_a_failed_check_that_was_accepted(tab):
    row = '[[accepted]]\ncheck = "agreement"\nreason = "new operator"\ndate = "2026-11-24"\n'
    text = f"{lj.load('choi2018-kapton').text}\n{row}"
    tab.wait_for_selector(at("brake-here-name"), timeout=LONG)
    assert not tab.is_visible(at("brake-here-verdict"))
    User(tab).drop(("mine.toml", text))
    tab.wait_for_selector(at("brake-here-verdict"), timeout=LONG)
    assert tab.inner_text(at("brake-here-verdict")) == "failed check"
    tab.hover(at("brake-here"))
    tab.wait_for_selector("text=new operator", timeout=LONG)
    head = tab.locator("header").bounding_box()
    assert head["height"] < 100  # one row, as without it
    assert not tab.errors
