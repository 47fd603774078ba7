"""Brake and Pull in a browser: real keys, real files, what stands on the page afterwards."""

from __future__ import annotations

import zipfile

import pytest

from layerjam.brake.commands.tensile import tensile
from layerjam.workbench.answer import file_bytes
from layerjam.workbench.state import State, format_link

pytestmark = pytest.mark.slow


def cell(tab, name):
    return tab.locator(f'[data-testid="{name}"]')


def test_a_brake_is_edited_compared_undone_saved_and_opened(tab, tmp_path):
    cell(tab, "tab-brake").click()
    tab.wait_for_selector("[data-testid=brake-numbers]", timeout=90_000)
    cell(tab, "brake-keep").click()
    width = cell(tab, "brake-sheets.width")
    width.fill("26")
    width.press("Enter")
    tab.wait_for_selector("text=better")
    assert width.input_value() == "26 mm"
    assert cell(tab, "brake-name").input_value() == "choi2018-kapton-edited"
    with tab.expect_download() as download:
        cell(tab, "brake-save").click()
    kept = tmp_path / "kept.toml"
    download.value.save_as(kept)
    with tab.expect_download() as download:
        cell(tab, "brake-html").click()
    assert download.value.suggested_filename == "choi2018-kapton-edited.html"
    text = download.value.path().read_text("utf-8")
    assert "26 mm" in text and "Content-Security-Policy" in text
    cell(tab, "undo").click()
    tab.wait_for_function(
        "document.querySelector('[data-testid=\"brake-sheets.width\"]').value == '13 mm'"
    )
    chosen = tab.locator("[data-testid=brake-open-file] input[type=file]")
    chosen.set_input_files(kept)
    tab.wait_for_function(
        "document.querySelector('[data-testid=\"brake-sheets.width\"]').value == '26 mm'"
    )
    rubbish = tmp_path / "rubbish.toml"
    rubbish.write_bytes(b"\xff\xfe\x00")
    chosen.set_input_files(rubbish)
    tab.wait_for_selector("text=is not UTF-8 text")
    assert not [e for e in tab.errors if "WebGL" not in e]


def test_a_measured_pull_is_dropped_and_compared(tab, tmp_path):
    cell(tab, "tab-pull").click()
    tab.wait_for_function(
        "(document.querySelector('[data-testid=pull-peak_force]') || {}).innerText?.length > 2",
        timeout=90_000,
    )
    pull = tmp_path / "pull.csv"
    answer = tensile("choi2018-kapton", vacuum="60 kPa", speed="1 mm/s", travel="30 mm")
    pull.write_bytes(file_bytes(answer, "csv"))
    tab.locator(".files-dropped input[type=file]").first.set_input_files(pull)
    tab.wait_for_selector("[data-testid=dropped-use]")
    tab.wait_for_timeout(300)
    tab.click("[data-testid=dropped-use]")
    tab.wait_for_selector("[data-testid=pull-errors]", timeout=60_000)
    assert "pull.csv" in cell(tab, "pull-errors").inner_text()
    with tab.expect_download() as download:
        cell(tab, "pull-figure-svg").click()
    assert download.value.suggested_filename == "choi2018-kapton-tensile.svg"
    assert not tab.errors


def test_the_stack_is_drawn_when_it_looks_different_and_not_otherwise(tab):
    cell(tab, "tab-brake").click()
    tab.wait_for_selector("[data-testid=brake-numbers]", timeout=90_000)
    view = tab.evaluate_handle(
        "() => getElement(+document.querySelector('[data-testid=brake-scene]').id.slice(1))"
    )
    tab.wait_for_function("view => view.renderer?.info.render.frame > 0", arg=view)

    def settled() -> int:
        seen, now = -1, view.evaluate("view => view.renderer.info.render.frame")
        while now != seen:
            tab.wait_for_timeout(1000)
            seen, now = now, view.evaluate("view => view.renderer.info.render.frame")
        return now

    def drawn_after(act) -> None:
        before = settled()
        act()
        tab.wait_for_function("([v, n]) => v.renderer.info.render.frame > n", arg=[view, before])

    tab.locator("[data-testid=brake-slip] [tabindex='0']").first.focus()
    drawn_after(lambda: tab.keyboard.press("ArrowRight"))
    drawn_after(cell(tab, "brake-scene-side").click)
    drawn_after(cell(tab, "light-or-dark").click)
    before = settled()
    cell(tab, "tab-pull").click()
    assert settled() == before  # it turns on unseen, and nothing is drawn
    drawn_after(cell(tab, "tab-brake").click)
    assert not [e for e in tab.errors if "WebGL" not in e]


def test_a_build_is_drawn_and_its_folder_downloaded(tab, tmp_path):
    cell(tab, "tab-brake").click()
    tab.wait_for_selector("[data-testid=brake-numbers]", timeout=90_000)
    tab.get_by_role("button", name="Build", exact=True).click()
    tab.wait_for_selector("[data-testid=brake-build-checks]", timeout=60_000)
    view = tab.evaluate_handle(
        "() => getElement(+document.querySelector('[data-testid=brake-build-scene]').id.slice(1))"
    )
    tab.wait_for_function("view => view.renderer?.info.render.triangles > 5000", arg=view)
    with tab.expect_download(timeout=60_000) as download:
        cell(tab, "brake-build-download").click()
    assert download.value.suggested_filename == "choi2018-kapton-build.zip"
    folder = tmp_path / "folder.zip"
    download.value.save_as(folder)
    with zipfile.ZipFile(folder) as archive:
        assert "choi2018-kapton-build/assembly.pdf" in archive.namelist()
    assert not [e for e in tab.errors if "WebGL" not in e]


def test_the_cursor_and_the_keyboard_say_which_sheets_slide(chromium, workbench):
    link = format_link(State(page="pull", settings={"pull": {"model": "stack"}}))
    tab = chromium.new_page(viewport={"width": 1280, "height": 800})
    tab.goto(f"{workbench}?s={link}")
    said = cell(tab, "pull-sheets-said")
    tab.wait_for_selector("text=2 of 10 interfaces slide", timeout=90_000)
    tab.wait_for_timeout(500)
    box = cell(tab, "pull-chart").bounding_box()
    tab.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    tab.wait_for_selector("text=every sheet slides")
    bar = tab.locator("[data-testid=pull-along] [tabindex='0']")
    bar.focus()
    # the slider's own value on the server never followed the pointer
    tab.keyboard.press("Home")
    tab.wait_for_selector("text=no sheet slides")
    tab.keyboard.press("End")
    tab.wait_for_selector("text=At 40 mm")
    assert "every sheet slides" in said.inner_text()
    before = cell(tab, "pull-sheets").inner_html()
    cell(tab, "pull-vacuum").locator("[tabindex='0']").press("Home")
    tab.wait_for_function(
        "before => document.querySelector('[data-testid=pull-sheets]').innerHTML !== before",
        arg=before,
    )
    tab.close()
