"""The vacuum page in a browser: faults switched on, a line opened, changed and saved."""

from __future__ import annotations

from pathlib import Path

import pytest

from layerjam.brake.fluid.line_file import LineFile, load_line

pytestmark = pytest.mark.slow
LONG = 60_000


def at(key: str) -> str:
    return f'[data-testid="vacuum-{key}"]'


def says(tab, key: str, words: str) -> None:
    tab.wait_for_function(
        "([place, words]) => document.querySelector(place).innerText.includes(words)",
        arg=[at(key), words], timeout=LONG,
    )  # fmt: skip


@pytest.fixture
def vacuum(tab):
    tab.click("[data-testid=tab-vacuum]")
    tab.wait_for_selector(f"{at('chart')} canvas", timeout=LONG)
    says(tab, "rise-words", "3.9 s")
    return tab


def test_a_fault_is_switched_on_and_said(vacuum):
    says(vacuum, "verdict", "The controller does not run until you choose a safe state")
    vacuum.locator(at("safe_state")).get_by_text("hold", exact=True).click()
    says(vacuum, "verdict", "No fault was reported. The rise to 94.5 kPa")
    vacuum.click(at("fault"))
    vacuum.locator(".q-menu .q-item").get_by_text("sensor nan").click()
    says(vacuum, "verdict", "“not a number” was detected at 10 s")
    says(vacuum, "verdict", "hold: pump off, vent closed")
    assert vacuum.errors == []


def test_a_line_is_opened_changed_and_saved(vacuum, tmp_path):
    own = tmp_path / "mine.toml"
    own.write_text(load_line("choi2018").text.replace('"choi2018"', '"mine"'))
    place = f"{at('open-file')} input[type=file]"
    vacuum.set_input_files(place, str(own))
    vacuum.get_by_text("mine (a file)").wait_for()
    vacuum.click(at("numbers"))
    vacuum.click(at("group-chamber"))
    field = vacuum.locator(at("chamber.volume"))
    field.fill("15.006")
    field.press("Enter")
    says(vacuum, "rise-words", "7.8 s")
    with vacuum.expect_download() as saved:
        vacuum.click(at("save"))
    text = Path(saved.value.path()).read_text()
    assert LineFile.read(text, "x").line.chamber.volume == pytest.approx(15.006e-6)
    for name, content in (("rubbish.toml", b"\xff\x00\xfe"), ("other.toml", b"a = 1\nb = 2\n"),
                          ("empty.toml", b"")):  # fmt: skip
        wrong = tmp_path / name
        wrong.write_bytes(content)
        vacuum.set_input_files(place, str(wrong))
        vacuum.wait_for_function(
            "document.querySelector('[data-testid=\"vacuum-line-problem\"]').innerText.length > 9"
        )
        assert "Traceback" not in vacuum.inner_text("body")
    assert vacuum.errors == []
