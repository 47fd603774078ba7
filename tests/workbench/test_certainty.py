"""Intervals at the large numbers, and the word that they rest on: as the commands state them."""

from __future__ import annotations

import asyncio
import json
import re
from html import unescape
from types import SimpleNamespace

import pytest

from layerjam.brake.commands.force import force
from layerjam.brake.commands.tuning import tune
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.units import parse
from layerjam.workbench.certainty import BASES, basis_html, interval_text, without_intervals
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.brake import Brake
from layerjam.workbench.pages.drop import Drop
from layerjam.workbench.pages.drop_outcome import headlines
from layerjam.workbench.state import State, format_link
from layerjam.workbench.widgets import Hero, headline_html
from workbench.evidenced import add_tests
from workbench.standing import standing

KAPTON = "choi2018-kapton"
TESTED = add_tests(KAPTON)
WORDS = {"tested": (TESTED, 60e3), "extrapolated": (TESTED, 90e3), "handbook": (KAPTON, 60e3)}


def ends(text: str, unit: str) -> tuple[float, float]:
    """The ends that an interval on the page states, in SI."""
    low, high = re.fullmatch(r"95 %: (.+) to (.+)", text).groups()
    return parse(low, unit, "low"), parse(high, unit, "high")


def test_the_large_number_of_a_tuned_drop_has_the_ends_of_the_command():
    page = Drop(Desk(State(page="drop", brake=TESTED)))
    _, drops, tuning, _ = page.compute()
    numbers = {hero.key: hero for hero in headlines(drops["tuned"].result, tuning)}
    file = BrakeFile.read(TESTED, "tested")
    said = {"mass": "1 kg", "speed": "1.5 m/s", "travel": "40 mm", "rope_stiffness": "16.8 kN/m"}
    own = json.loads(tune(file, **said).json())
    stated = own["intervals"]["vacuum"]
    assert ends(numbers["hero-vacuum"].interval, "Pa") == pytest.approx(
        (stated["low"], stated["high"]), rel=5e-3
    )
    safe = numbers["hero-safe"]
    assert safe.name == "Keeps 95 % of stops within 40 mm"
    assert parse(safe.text, "Pa", "safe") == pytest.approx(own["safe_vacuum"], rel=1e-3)
    assert own["basis"] in basis_html(tuning.result, "drop-basis")


def test_the_share_of_stops_can_be_chosen():
    page = Drop(Desk(State(page="drop", brake=KAPTON, settings={"drop": {"confidence": 0.8}})))
    *_, call = page.calls()
    assert call.options["confidence"] == "0.8"
    names = [hero.name for hero in headlines(page.compute()[1]["tuned"].result, page.compute()[2])]
    assert "Keeps 80 % of stops within 40 mm" in names
    page.desk.put_setting("drop", "confidence", 0.95)
    assert "confidence" not in page.calls()[-1].options  # copied code states what was chosen


@pytest.mark.parametrize("word", BASES)
def test_the_brake_page_shows_the_interval_and_the_word(word):
    text, vacuum = WORDS[word]
    own = force(
        BrakeFile.read(text, "a file") if text == TESTED else text, slip=0.01, vacuum=vacuum
    )
    link = State(page="brake", brake=text, settings={"brake": {"slip": 0.01, "vacuum": vacuum}})

    async def use() -> tuple[str, str]:
        async with standing(Brake, format_link(link)) as (user, pages):
            await user.should_see("95 %: ", retries=300)
            figures = pages[-1].figures
            return figures._intervals["force"].text, figures._basis.content

    shown, basis = asyncio.run(use())
    stated = json.loads(own.json())["intervals"]["force"]
    assert ends(shown, "N") == pytest.approx((stated["low"], stated["high"]), rel=1e-3)
    assert own.basis == word and f">{word}</span>" in basis


@pytest.mark.parametrize("word", BASES)
def test_a_word_stands_beside_its_reason(word):
    html = basis_html(SimpleNamespace(basis=word, basis_reason="vacuum <b>1 kPa</b>"), "here")
    assert f">{word}</span>" in html and BASES[word] in html
    assert "Vacuum <b>1 kPa</b>" in unescape(html) and "<b>" not in html
    assert BASES[word] in basis_html(SimpleNamespace(basis=word), "here").partition("</span>")[2]


def test_results_without_intervals_show_nothing():
    for source in (None, SimpleNamespace(), {}, SimpleNamespace(intervals=None, basis=None)):
        assert interval_text(source, "force", "N") == ""
        assert basis_html(source, "here") == ""
    assert "interval" not in headline_html("pull", [Hero("peak", "Peak", "3 N")])


def test_open_ends_and_no_width():
    row = {"intervals": {"a": {"low": None, "high": 2.0}, "b": {"low": 0.0, "high": 0.0}}}
    assert interval_text(row, "a", "N", 1.0) == "95 %: below 2 N"
    assert interval_text(row, "b", "N", 0.0) == ""


def test_markup_of_others_is_text():
    html = headline_html("pull", [Hero("peak", "<i>", "3 N", "95 %: <b>", "<u>")])
    assert not {"<i>", "<b>", "<u>"} & set(re.findall(r"<[^>]*>", html))


def test_a_narrow_table_has_no_room_for_intervals():
    found = force(KAPTON, slip=0.01, vacuum=60e3)
    assert "95 %" in dict(found.rows())["force"]
    assert "95 %" not in dict(without_intervals(found).rows())["force"]
    assert without_intervals(None) is None
