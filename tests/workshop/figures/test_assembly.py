"""assembly.pdf: every part and number is there, nothing is cut off, and it is the same twice."""

from __future__ import annotations

import csv
import io
import math
from typing import Any, NamedTuple

import numpy as np
import pypdfium2
import pytest

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.limits import greatest_force
from layerjam.workshop.fabricate.bom import bom_csv, list_items
from layerjam.workshop.fabricate.choices import resolve_choices
from layerjam.workshop.fabricate.drawing import Drawing, draw_build
from layerjam.workshop.fabricate.lengths import compute_lengths
from layerjam.workshop.figures.build_files import typeset_assembly

KAPTON = load("choi2018-kapton")
NAMES = ("exploded", "stacking", "mould", "assembled", "section", "layers", "film", "boards")
BLANK = '<svg xmlns="http://www.w3.org/2000/svg" width="300" height="200"/>'
PICTURES = dict.fromkeys(NAMES, BLANK)


class Read(NamedTuple):
    pages: list[str]
    outside: int
    """Objects that leave their page."""

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.pages).split())


def made(file: BrakeFile = KAPTON, parallel: int = 1, series: int = 1, **build: Any) -> Drawing:
    chosen = resolve_choices(file, overrides=build)
    return draw_build(file, chosen, greatest_force(file.brake), parallel, series)


def read(data: bytes) -> Read:
    document = pypdfium2.PdfDocument(data)
    pages, outside = [], 0
    for page in document:
        words = page.get_textpage()
        pages.append(words.get_text_bounded())
        wide, tall = page.get_size()
        for each in page.get_objects():
            left, low, right, high = each.get_bounds()
            outside += left < -1 or low < -1 or right > wide + 1 or high > tall + 1
        words.close()
        page.close()
    document.close()
    return Read(pages, outside)


def test_the_papers_brake() -> None:
    found = made()
    data = typeset_assembly(found, PICTURES)
    assert data == typeset_assembly(found, PICTURES)
    sheet = read(data)
    assert sheet.outside == 0
    for words in (
        "We have never cut, printed or cast",
        "154.4 mm",
        "214.4 mm",
        "M3 × 8",
        "6 sheets and 5 spacers, the right cap 5 and 6: 11 layers in each",
        "Both outer faces are left sheets",
        "522 N",
        "126 mm",
        "layerjam leak hold.csv",
        "layerjam new my-brake --from choi2018-kapton --out my-brake.toml",
        "layerjam calibrate my-brake-friction.toml",
        "film 0.254 mm thick, Kapton HN polyimide film",
        "Ecoflex 5",
        "hex keys: 2.5 mm and 3 mm",
        "for a circumference of 42 mm",
        "weighed_mass",
        "dab",
    ):
        assert words in sheet.text, words
    for row in csv.DictReader(io.StringIO(bom_csv(found))):
        assert row["item"] in sheet.text and row["what"].split(";")[0] in sheet.text, row
    for check in found.checks:
        assert check.code in sheet.text
    for said in found.assumptions():
        assert " ".join(said.split())[:40] in sheet.text.replace("- ", "-"), said
    assert "price" not in sheet.text.lower() and "€" not in sheet.text


def test_every_picture_is_asked_for() -> None:
    """A picture more or less is an error of typst, not a gap in a page."""
    bare = {name: svg for name, svg in PICTURES.items() if name != "mould"}
    with pytest.raises(Exception, match=r"mould\.svg"):
        typeset_assembly(made(), bare)


def test_even_stacks_and_unlike_sides() -> None:
    text = read(typeset_assembly(made(KAPTON.with_(count=6, free_left="9 mm")), PICTURES)).text
    assert "the highest a right sheet: mark the faces" in text
    assert "20 mm behind the left cap's face and 18 mm behind the right cap's face" in text.replace(
        "’", "'"
    )
    assert "2 × cap" not in text and "1 × cap-left, 1 × cap-right" in text


def test_who_cuts_decides_what_is_said() -> None:
    service = read(typeset_assembly(made(), PICTURES)).text
    assert "ask it to compensate" in service and "coupon.dxf" not in service.split("Check the")[0]
    laser = read(typeset_assembly(made(cutter="laser", kerf=0.15e-3), PICTURES, True)).text
    assert "The outlines include half the kerf of 0.15 mm" in laser and "divided by 11" in laser
    knife = read(typeset_assembly(made(cutter="knife"), PICTURES)).text
    assert "Punch the 3 mm holes" in knife
    never = read(typeset_assembly(made(load("choi2018-ptfe")), PICTURES)).text
    assert "Never cut this film with a laser" in never
    assert "tell the service: never cut this film with a laser" in never


def test_caps_lie_level_on_the_jig() -> None:
    """What is packed under tray and head makes them as low as the neck, by lengths of their own."""
    text = read(typeset_assembly(made(), PICTURES)).text
    neck = 1.25 * 2 * (13 + 2.794) / (2 * math.pi)
    tray, head = 2.794 / 2 + 4.003, 8.2 / 2
    said = f"film, {neck - tray:.1f} mm under the trays and {neck - head:.1f} mm under the heads"
    assert said in text, said


def test_what_is_not_in_the_folder_is_not_named() -> None:
    found = made()
    every = {row.file for row in list_items(found) if row.file}
    assert "cad/sleeve.step" in every
    there = every - {"cad/sleeve.step"}
    assert {row.file for row in list_items(found, there)} == {*there, ""}
    text = read(typeset_assembly(found, PICTURES, False, there)).text
    assert "cad/" not in text and "there is no pattern to cut by hand" in text
    whole = read(typeset_assembly(found, PICTURES, False, {*every, "cut/pattern.pdf"})).text
    assert "cut/pattern.pdf printed at 100 %" in whole


def test_each_casting_is_mixed_by_itself() -> None:
    one, four = (read(typeset_assembly(made(parallel=n), PICTURES)).text for n in (1, 4))
    assert "Mix 3.37 g of A with 3.37 g of B (1A:1B) and degas" in one
    assert "Mix 3.37 g of A with 3.37 g of B (1A:1B) for each casting and degas" in four
    assert "silicone A Ecoflex 5, to mix, including waste 13.5 g" in four


@pytest.mark.parametrize("screws", [1, 3])
def test_each_label_of_the_clamp_names_its_part(screws: int) -> None:
    from layerjam.workshop.figures.build_pictures import _draw_stacking
    from layerjam.workshop.figures.build_scene import make_scene

    file = KAPTON.with_(width="40 mm", screws=screws)
    build = resolve_choices(file).build
    world = make_scene(build, compute_lengths(file.brake, build))
    assert world.lengths.screws == screws
    thread, found = world.lengths.thread, world.lengths
    high = {"nut": thread.nut_height, "screw": thread.head_height + found.screw_length,
            "clamp plate": found.plate_height}  # fmt: skip
    labels = {label.words.split(",")[0]: label.target for label in _draw_stacking(world)[1]}
    for name, height in high.items():
        assert np.ptp(labels[name].corners[:, 2]) == pytest.approx(height), name


def test_arrays_are_joined() -> None:
    text = read(typeset_assembly(made(parallel=3, series=2), PICTURES)).text
    assert "Join 2 brakes in a row" in text and "Set 3 side by side" in text
    assert "2.73 N m" in text
    assert "7 Join the brakes" in text and "8 Check the first brake" in text
    assert "Join" not in read(typeset_assembly(made(), PICTURES)).text
