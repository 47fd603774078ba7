"""assembly.pdf: every part and number is there, nothing is cut off, and it is the same twice."""

from __future__ import annotations

import csv
import io
from typing import Any, NamedTuple

import pypdfium2
import pytest

from layerjam.commands.build import greatest_force
from layerjam.device.file import BrakeFile
from layerjam.device.load import load
from layerjam.fabricate.bom import bom_csv
from layerjam.fabricate.choices import choices
from layerjam.fabricate.drawing import Drawing, drawing
from layerjam.report.assembly import assembly

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
    chosen = choices(file, given=build)
    return drawing(file, chosen, greatest_force(file.brake), parallel, series)


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
    data = assembly(found, PICTURES)
    assert data == assembly(found, PICTURES)
    sheet = read(data)
    assert sheet.outside == 0
    for words in (
        "never cut, printed or cast by us",
        "154.4 mm",
        "214.4 mm",
        "M3 × 8",
        "6 sheets and 5 spacers, the right cap 5 and 6: 11 layers in each",
        "Both outer faces are left sheets",
        "522 N",
        "126 mm",
        "layerjam leak hold.csv",
        "layerjam calibrate my-brake.toml",
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
        assembly(made(), bare)


def test_even_stacks_and_unlike_sides() -> None:
    text = read(assembly(made(KAPTON.with_(count=6, free_left="9 mm")), PICTURES)).text
    assert "the highest a right one: mark the faces" in text
    assert "20 mm behind the left cap's face and 18 mm behind the right one's" in text.replace(
        "’", "'"
    )
    assert "2 × cap" not in text and "1 × cap-left, 1 × cap-right" in text


def test_who_cuts_decides_what_is_said() -> None:
    service = read(assembly(made(), PICTURES)).text
    assert "ask it to compensate" in service and "coupon.dxf" not in service.split("Check the")[0]
    laser = read(assembly(made(cutter="laser", kerf=0.15e-3), PICTURES, True)).text
    assert "Half the kerf of 0.15 mm is in the outlines" in laser and "divided by 11" in laser
    knife = read(assembly(made(cutter="knife"), PICTURES)).text
    assert "Punch the holes of 3 mm" in knife
    never = read(assembly(made(load("choi2018-ptfe")), PICTURES)).text
    assert "Never cut this film with a laser" in never
    assert "tell the service: this film must never go into a laser" in never


def test_arrays_are_joined() -> None:
    text = read(assembly(made(parallel=3, series=2), PICTURES)).text
    assert "Join 2 brakes in a row" in text and "Set 3 side by side" in text
    assert "2.73 N m" in text
    assert "7 Join the brakes" in text and "8 Check the first one" in text
    assert "Join" not in read(assembly(made(), PICTURES)).text
