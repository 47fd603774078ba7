"""Each picture of the docs is what its program draws today, is shown, and can be read on a page."""

from __future__ import annotations

import re
from pathlib import Path
from types import ModuleType

import pytest

from core.drawing.legible import faults
from docs.examples import ROOT, pages, script
from docs.pictures import compare
from docs.style_texts import read_words
from layerjam.bench.figures.line_pictures import draw_coupling
from layerjam.core.drawing.style import format_svg

IMAGES = ROOT / "docs" / "images"
QUICK = ("kapton.svg", "engines.svg", "overview.svg")
SLOW = ("rise.svg", "regulators.svg", "forces.svg", "warned.svg", "bending.svg")
ELSEWHERE = ("coupling.svg", "stop.svg", "wiring-pico.svg", "workbench.png", "held.svg",
             "elbow.svg", "elbow-animation.svg")  # fmt: skip
"""Pictures that a test of their own compares, or that need MuJoCo."""
COLUMN, LEAST = 700, 8.0
"""Width of a page's text and smallest readable letter [px]."""
FIGURE_WORDS = 8.5
"""Smallest font of a figure, whose letters are drawn as curves [pt]."""


@pytest.fixture(scope="module")
def make() -> ModuleType:
    """docs/images/make.py."""
    return script(IMAGES / "make.py")


@pytest.mark.parametrize("name", [*QUICK, *(pytest.param(n, marks=pytest.mark.slow) for n in SLOW)])
def test_picture_is_what_its_program_draws(name: str, make: ModuleType, tmp_path: Path) -> None:
    drawn = make.draw(name, tmp_path).read_text("utf-8")
    assert compare((IMAGES / name).read_text("utf-8"), drawn) == "", f"make.py {name}"


@pytest.mark.slow
def test_pictures_of_the_gallery_are_what_its_code_draws(make: ModuleType, tmp_path: Path) -> None:
    make.draw_gallery(tmp_path)
    for name in make.list_gallery():
        drawn = (tmp_path / name).read_text("utf-8")
        assert compare((IMAGES / name).read_text("utf-8"), drawn) == "", f"make.py {name}"


@pytest.mark.campaign
def test_coupling_has_its_words_in_their_places() -> None:
    """One of its six vacuums is drawn, because all of them take a minute."""
    figure = draw_coupling((50e3,))
    assert faults(figure) == []
    pictures = (IMAGES / "coupling.svg").read_text("utf-8"), format_svg(figure)
    words = [[w for w in read_words(p) if re.search("[a-z]", w)] for p in pictures]
    assert words[0] == words[1], "make.py coupling.svg"


def test_each_picture_has_a_program_a_page_and_a_comparison(make: ModuleType) -> None:
    files = {path.name for path in IMAGES.iterdir() if path.suffix in (".svg", ".png")}
    text = "".join(page.read_text("utf-8") for page in pages())
    shown = set(re.findall(r"images/([\w-]+\.(?:svg|png))", text))
    assert files == set(make.NAMES) == shown
    assert files == {*QUICK, *SLOW, *ELSEWHERE, *make.list_gallery()}


@pytest.mark.parametrize("path", sorted(IMAGES.glob("*.svg")), ids=lambda p: p.name)
def test_picture_is_small_and_its_words_can_be_read(path: Path) -> None:
    text = path.read_text("utf-8")
    assert len(text.encode()) <= 200_000
    assert "http://" not in re.sub(r'xmlns[^"]*"[^"]*"|"http://[^"]*"', "", text)
    width = float(re.findall(r'<svg[^>]*\bwidth="([\d.]+)', text)[0])
    fonts = re.findall(r'font(?:-size)?[:=]"?\s*([\d.]+)', text)
    assert min(map(float, fonts), default=FIGURE_WORDS) * COLUMN / width >= LEAST


def test_comparison_finds_words_and_shifts() -> None:
    old = "<!-- 12 N --><path d='M1 2.00'/><text>slip</text>"
    assert compare(old, old.replace("12 N", "13 N")) == "words: ['12 N', '13 N']"
    assert compare(old, old.replace("slip", "Slip")).startswith("words")
    assert compare(old, old.replace("2.00", "2.03")) == "coordinates"
    assert compare(old, old.replace("M1", "L1")) == "shapes"
    assert compare(old, old.replace("2.00", "2.005")) == ""
