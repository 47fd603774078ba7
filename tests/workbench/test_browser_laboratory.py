"""The laboratory in a browser: real clicks, real files, what is downloaded and left behind."""

from __future__ import annotations

import tempfile
import time
import tomllib
from pathlib import Path

import pytest

from layerjam.workbench.pages.laboratory_files import make_practice_files

pytestmark = pytest.mark.slow
LONG = 60_000
DROP = """(spec) => {
  const data = new DataTransfer();
  for (const [name, text] of spec) data.items.add(new File([text], name));
  for (const kind of ['dragover', 'drop'])
    document.body.dispatchEvent(
      new DragEvent(kind, {dataTransfer: data, bubbles: true, cancelable: true}));
}"""


def at(key: str) -> str:
    return f"[data-testid=laboratory-{key}]"


@pytest.fixture
def laboratory(tab):
    tab.click("[data-testid=tab-laboratory]")
    tab.wait_for_selector(at("practice"))
    tab.wait_for_timeout(500)
    return tab


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    for name, data in make_practice_files(folder, lambda *_: None).items():
        (folder / name).write_bytes(data)
    return sorted(p for p in folder.iterdir() if p.is_file())


def choose(page, paths) -> None:
    page.locator(".files-dropped input[type=file]").first.set_input_files([str(p) for p in paths])


def accepted(page) -> None:
    page.wait_for_selector("[data-testid=dropped-use]", timeout=LONG)
    page.wait_for_timeout(300)
    page.click("[data-testid=dropped-use]")


def chosen(page, name: str) -> None:
    row = page.locator(f"{at('files')} tbody tr").filter(has_text=name).first
    row.locator("td").nth(1).click()
    page.wait_for_selector(at("detail"))


def test_two_files_dropped_calibrate_the_brake(laboratory, files):
    two = [p for p in files if "94.5kPa_7mms_2" in p.name or "94.5kPa_7mms_3" in p.name]
    assert len(two) == 4, "two files with their sidecars"
    choose(laboratory, two)
    accepted(laboratory)
    laboratory.wait_for_selector(at("calibrate-scale-factor"), timeout=LONG)
    laboratory.wait_for_selector(f"{at('count')}:has-text('2 files, 2 of them usable')")
    assert laboratory.is_visible(at("synthetic"))
    assert not laboratory.errors


def test_the_practice_campaign_from_a_click_to_report_and_brake(laboratory, tmp_path):
    laboratory.click(at("practice"))
    laboratory.wait_for_selector(at("validate-pulls"), timeout=LONG)
    laboratory.wait_for_selector(f"{at('validate')} .figure svg", timeout=LONG)
    assert laboratory.is_visible(at("synthetic"))
    with laboratory.expect_download() as got:
        laboratory.click(at("toml"))
    brake = tomllib.loads(Path(got.value.path()).read_text(encoding="utf-8"))
    assert brake["scale_factor"]["value"] == pytest.approx(0.92, abs=0.02)
    assert all(f["name"].startswith("pull_choi2018") for f in brake["made_by"]["files"])
    laboratory.click(at("make-report"))
    laboratory.wait_for_selector(f"{at('report-pdf')}:visible", timeout=LONG)
    for key, begins in (("report-pdf", b"%PDF"), ("report-html", b"<!DOCTYPE"),
                        ("report-zip", b"PK")):  # fmt: skip
        with laboratory.expect_download() as got:
            laboratory.click(at(key))
        data = Path(got.value.path()).read_bytes()
        assert data.lower().startswith(begins.lower()), key
    laboratory.click(at("take"))
    laboratory.wait_for_timeout(1500)
    laboratory.click("[data-testid=copy-as-command]")
    copied = "[data-testid=copied]:has-text('--brake choi2018-kapton-calibrated.toml')"
    laboratory.wait_for_selector(copied)
    assert not laboratory.errors


def test_a_column_and_a_vacuum_are_corrected_in_the_page_and_undone(laboratory):
    force = [min(7.0 * i, 175 - i) for i in range(60)]
    text = "".join(f"{i};{f:.3f};{i / 10:.2f}\n" for i, f in enumerate(force))
    laboratory.evaluate(DROP, [["plain.csv", text]])
    dropped = "[data-testid=dropped]"
    laboratory.wait_for_selector(f"{dropped} >> text=Click the headers", timeout=LONG)
    assert "--" not in laboratory.inner_text(dropped)
    for index, what in ((1, "force-N"), (2, "elongation-mm")):
        laboratory.click(f"[data-testid=column-{index}]")
        laboratory.click(f"[data-testid=column-is-{what}]")
        laboratory.wait_for_selector(
            f"{dropped} th >> text={what.replace('-', ' in ')}", timeout=LONG
        )
    laboratory.fill("[data-testid=dropped-vacuum]", "80")
    accepted(laboratory)
    laboratory.wait_for_selector(f"{at('files')} >> text=understood", timeout=LONG)
    assert "80 kPa" in laboratory.inner_text(at("files"))
    laboratory.click("[data-testid=undo]")
    laboratory.wait_for_selector(f"{at('files')} >> text=vacuum?", timeout=LONG)
    chosen(laboratory, "plain.csv")
    laboratory.fill(at("vacuum"), "80 furlong")
    laboratory.click(at("apply"))
    laboratory.wait_for_selector(f"{at('edit-problem')}:has-text('furlong')")
    assert not laboratory.errors


def test_from_my_files_a_pull_is_pinned_and_let_go_by_keyboard(tab):
    """The card has no list of its own: it leads to the laboratory's, and that has the button."""
    pull = "mm,N\n" + "".join(f"{i / 10},{min(7 * i, 175 - i)}\n" for i in range(60))
    tab.wait_for_selector("[data-testid=start-files]", timeout=LONG)
    tab.evaluate(DROP, [["pull_80kPa.csv", pull]])
    accepted(tab)
    tab.wait_for_selector(f"{at('files')} >> text=understood", timeout=LONG)
    tab.click("[data-testid=tab-start]")
    tab.focus("[data-testid=start-files]")
    tab.keyboard.press("Enter")
    tab.wait_for_selector("[data-testid=dropped-used]", timeout=LONG)
    tab.focus("[data-testid=dropped-used]")
    tab.keyboard.press("Enter")
    tab.get_by_role("checkbox", name="Choose pull_80kPa.csv").focus()
    tab.keyboard.press("Space")
    pinned = "[data-testid=pull-pins] >> text=measured, 80 kPa, pull_80kPa.csv"
    for name, said, state in (
        ("Show on the Pull page", "The file is on the Pull page", "visible"),
        ("Remove from the Pull page", "The file was removed from the Pull page", "detached"),
    ):
        tab.get_by_role("button", name=name).focus()
        tab.keyboard.press("Enter")
        tab.locator("[role=alert]", has_text=said).wait_for(timeout=LONG)
        tab.click("[data-testid=tab-pull]")
        tab.wait_for_selector(pinned, state=state, timeout=LONG)
        tab.click("[data-testid=tab-laboratory]")
    assert not tab.errors


def test_rubbish_gets_a_word_and_the_server_stays_up(laboratory, tmp_path):
    picture = tmp_path / "picture.csv"
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 9)
    (tmp_path / "empty.csv").touch()
    huge = tmp_path / "huge.csv"
    with huge.open("wb") as file:
        file.truncate(10**9)
    choose(laboratory, [picture, tmp_path / "empty.csv", huge])
    told = "[data-testid=dropped-told]"
    for words in ("is binary", "is empty", "huge.csv: 954 MB is too large"):
        laboratory.wait_for_selector(f"{told} >> text={words}", timeout=LONG)
    laboratory.click("[data-testid=dropped-close]")
    names = [["../../etc/passwd", "root:x"], ["a" * 5000 + ".csv", "1"], ["b\x00\n<b>.csv", "2"]]
    laboratory.evaluate(DROP, names)
    laboratory.wait_for_selector(f"{told} >> text=passwd", timeout=LONG)
    laboratory.wait_for_selector(f"{told} >> text=its name cannot be sent", timeout=LONG)
    laboratory.click("[data-testid=dropped-close]")
    pull = "mm,N\n" + "".join(f"{i / 10},{min(7 * i, 175 - i)}\n" for i in range(60))
    laboratory.evaluate(DROP, [[f"pull_{i}_80kPa.csv", f"{pull}9,{i}\n"] for i in range(210)])
    laboratory.wait_for_selector(f"{told} >> text=at most 200 measurements >> nth=0",
                                 timeout=2 * LONG)  # fmt: skip
    laboratory.wait_for_selector("[data-testid=dropped-more]", timeout=LONG)


@pytest.mark.campaign
def test_a_closed_tab_leaves_no_file_behind(chromium, workbench):
    def folders() -> set[Path]:
        return set(Path(tempfile.gettempdir()).glob("layerjam-workbench-*"))

    before = folders()
    page = chromium.new_page()
    page.goto(workbench)
    page.click("[data-testid=tab-laboratory]")
    page.wait_for_selector(at("practice"))
    page.wait_for_timeout(500)
    page.click(at("practice"))
    page.wait_for_selector(f"{at('count')}:has-text('21 files')", timeout=LONG)
    made = folders() - before
    assert made
    page.close()  # in the middle of the computation
    for _ in range(120):
        if not made & folders():
            return
        time.sleep(0.5)
    pytest.fail(f"left behind: {made & folders()}")
