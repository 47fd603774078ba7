"""The design page in a browser: a need typed, the front clicked, arrays, densities, machines."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from layerjam.workshop.design.specification import example_texts

pytestmark = pytest.mark.slow
LONG = 90_000
SMALL = (
    'name = "small"\nbrake = "choi2018-kapton"\nwithout = ["buildable", "drawn_mass"]\n'
    'constraints = ["holding_force >= 300 N", "mass <= 60 g"]\n'
    'objectives = ["minimise mass", "maximise energy_capacity"]\n'
    "[vary]\ncount = { from = 5, to = 41, step = 2 }\n"
    'width = { from = "10 mm", to = "30 mm", step = "2 mm" }\n'
)


def at(key: str) -> str:
    return f'[data-testid="design-{key}"]'


def says(tab, key: str, words: str) -> None:
    tab.wait_for_function(
        "([place, words]) => document.querySelector(place)?.innerText.includes(words)",
        arg=[at(key), words], timeout=LONG,
    )  # fmt: skip


def part(tab, words: str) -> None:
    tab.locator(at("part")).get_by_text(words, exact=True).click()


@pytest.fixture
def design(tab):
    tab.click("[data-testid=tab-design]")
    tab.click(at("form-open"))
    tab.click(at("example-wrist"))
    says(tab, "outcome", "designs meet all constraints")
    tab.wait_for_selector(f"{at('front')} canvas")
    return tab


def search(tab, text: str) -> None:
    tab.fill(f"textarea{at('spec')}", text)
    tab.click(at("search"))


def test_a_need_is_typed_and_the_front_clicked(design):
    search(design, SMALL)
    says(design, "outcome", "of 209 designs meet all constraints")
    before = design.inner_text(at("picked"))
    design.locator(at("front")).evaluate("e => e.scrollIntoView({block: 'center'})")
    place = design.locator(at("front")).bounding_box()
    # the dots lie between the axes: click along a diagonal until one is hit
    hit = False
    for step in range(8, 60):
        share = step / 70
        for high in (0.75, 0.6, 0.5, 0.4, 0.3, 0.2):
            design.mouse.click(place["x"] + 70 + share * (place["width"] - 220),
                               place["y"] + high * place["height"])  # fmt: skip
        design.wait_for_timeout(60)
        if design.inner_text(at("picked")) != before:
            hit = True
            break
    assert hit, "no click on the chart met a design"
    now = design.inner_text(at("picked"))
    design.click(at("next"))
    design.wait_for_function(
        "([place, old]) => document.querySelector(place).innerText !== old",
        arg=[at("picked"), now],
    )  # fmt: skip
    design.click(at("take"))
    design.get_by_text("is now the current brake").wait_for()
    design.click("[data-testid=tab-brake]")
    design.locator('input[data-testid="brake-name"]').wait_for()
    assert design.input_value('input[data-testid="brake-name"]').startswith("small-")
    assert design.errors == []


def test_errors_stand_in_place_with_their_line(design):
    search(design, SMALL.replace("60 g", "60 parsecs"))
    says(design, "spec-problem", "Line 4")
    search(design, SMALL.replace("choi2018-kapton", "/etc/passwd"))
    says(design, "spec-problem", "unknown brake")
    search(design, "rubbish")
    says(design, "spec-problem", "Line 1")
    search(design, "")
    says(design, "spec-problem", "brake (name or path of the brake to start from")
    search(design, SMALL.replace("300 N", "300 kN"))
    says(design, "outcome", "Not possible: holding force ≥ 300 kN cannot be met")
    assert "Traceback" not in design.inner_text("body")
    design.click(at("example-wrist"))
    says(design, "outcome", "designs meet all constraints")
    assert design.input_value(f"textarea{at('spec')}") == example_texts()["wrist"]
    assert design.errors == []


def test_a_long_search_is_stopped(design):
    steps = 'overlap = { from = "40 mm", to = "160 mm", step = "1 um" }\n'
    search(design, SMALL + steps)
    design.click(at("stop"), timeout=LONG)
    says(design, "spec-problem", "Stopped")
    assert design.errors == []


def test_the_form_writes_and_the_copied_command_gives_the_same(design, tmp_path):
    field = design.locator(f"input{at('hold_force-number')}")
    field.fill("400 N")
    field.press("Enter")
    design.wait_for_function(
        "place => document.querySelector(place).value.includes('holding_force >= 400 N')",
        arg=f"textarea{at('spec')}",
    )  # fmt: skip
    design.click(at("search"))
    says(design, "outcome", "designs meet all constraints")
    text = design.input_value(f"textarea{at('spec')}")
    with design.expect_download() as saved:
        design.click(at("save"))
    name = saved.value.suggested_filename
    assert Path(saved.value.path()).read_text() == text
    (tmp_path / name).write_text(text)
    design.click("[data-testid=copy-as-command]")
    command = design.inner_text("[data-testid=copied] code").strip()
    assert command == f"layerjam design {name}"
    program = str(Path(sys.executable).with_name("layerjam"))
    done = subprocess.run([program, "design", name], cwd=tmp_path, capture_output=True, text=True,
                          timeout=120, check=True)  # fmt: skip
    chosen = re.search(r"Chosen: (\d+) sheets", design.inner_text(at("outcome")))
    assert f"chosen: {chosen.group(1)} sheets" in done.stdout
    assert design.errors == []


def test_the_other_parts(design):
    part(design, "Arrays of brakes")
    says(design, "array-brakes", "4")
    says(design, "array-peak_force", "351.9 N")
    part(design, "Force versus mass")
    design.wait_for_selector(f"{at('density-chart')} canvas")
    says(design, "density-table", "magnetic powder brake")
    part(design, "Four machines")
    says(design, "verdict", "Not feasible: 2 of 5 limits are missed")
    drawn = design.locator(f"{at('pictures')} svg[role=img]")
    assert drawn.count() >= 2
    assert all(box["width"] > 100 for box in (one.bounding_box() for one in drawn.all()))
    design.click(at("scenario"))
    design.locator(".q-menu .q-item").get_by_text("slow-stop").click()
    says(design, "verdict", "Feasible")
    assert design.errors == []
