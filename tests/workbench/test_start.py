"""The first page without a browser: one vacuum for all, what holds, what falls, one word."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nicegui import ui

from layerjam.brake.commands.edit import edit
from layerjam.brake.commands.tensile import tensile
from layerjam.brake.device.load import catalogue, load
from layerjam.core.toml_files.source import Source
from layerjam.laboratory.identify.origin import ORIGINS, describe_origin
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.all import TABS
from layerjam.workbench.pages.start import Start, drop_sentence, holding_sentence, round_down_digits
from layerjam.workbench.state import SAME, State, format_link, parse_link
from workbench.standing import standing

KAPTON = "choi2018-kapton"
GRAVITY = 9.80665
CONTROLS = SAME["vacuum"]


@given(st.sampled_from(CONTROLS), st.floats(0, 1e5), st.sampled_from(CONTROLS), st.floats(0, 1e5))
def test_one_vacuum_on_every_page(mover, vacuum, other, old):
    state = State(settings={other[0]: {other[1]: old, "kept": 3.0}})
    # a link of before there was one vacuum: its page shows what it showed
    assert parse_link(format_link(state)).get(*other, 1.0) == old
    moved = parse_link(format_link(state.put_setting(*mover, vacuum)))
    assert {moved.get(page, key, -1.0) for page, key in CONTROLS} == {vacuum}
    assert moved.get(other[0], "kept", 0.0) == 3.0
    assert moved.get("pull", "speed", 7.0) == 7.0


def test_an_old_link_with_one_vacuum_sets_it_for_every_page():
    state = State(settings={"pull": {"vacuum": 60e3}})
    assert {state.get(*control, 0.0) for control in CONTROLS} == {60e3}


def test_undo_brings_the_vacuum_of_every_page_back():
    desk = Desk(State(settings={"drop": {"vacuum": 30e3}}))
    desk.put_setting("start", "vacuum", 80e3)
    assert desk.get("drop", "vacuum", 0.0) == 80e3
    assert desk.undo()
    assert desk.get("drop", "vacuum", 0.0) == 30e3


@given(st.floats(1e-6, 1e6))
def test_what_hangs_is_rounded_down_and_by_little(value):
    made = round_down_digits(value)
    assert made <= value * (1 + 1e-9)
    assert value - made <= 0.0101 * value


def test_what_is_said_to_hang_is_what_the_sheets_hold():
    for vacuum in (15e3, 40e3, 94.5e3):
        page = Start(Desk(State(settings={"desk": {"vacuum": vacuum}})))
        answer, full, *fall = page.compute()
        found = answer.result
        words = holding_sentence(found, GRAVITY)
        mass = float(words.split("up to ")[1].split(" kg")[0].split()[-1])
        # the sheets alone, by hand: a mu (n - 1) W L P
        friction = 0.875 * 0.24 * 10 * 0.013 * 0.068 * vacuum
        assert 0.99 * friction < mass * GRAVITY <= found.peak_force < 1.3 * friction
        assert fall == [] and full.peak_force > found.peak_force


def test_without_vacuum_nothing_is_said_to_hang():
    page = Start(Desk(State(settings={"desk": {"vacuum": 0.0}})))
    assert holding_sentence(page.compute()[0].result, GRAVITY).startswith(
        "The sheets do not resist yet"
    )


@pytest.mark.parametrize("vacuum", [1e3, 20e3, 35e3, 60e3, 94.5e3])
def test_the_kilogram_stops_where_friction_eats_its_energy(vacuum):
    """By hand, friction alone: the work over 60 mm against what 30 cm and the slip put in."""
    page = Start(Desk(State(settings={"desk": {"vacuum": vacuum}})))
    page.dropped = True
    answer = page.compute()[2]
    stop = answer.result
    said = drop_sentence(stop, answer.refusal)
    per_length = 0.875 * 0.24 * 10 * 0.013 * vacuum
    work = per_length * (0.068 * 0.06 - 0.06**2 / 2)
    if work > GRAVITY * 0.36:
        assert "stops the mass within" in said and stop.slip < 0.06
    else:
        assert "too little vacuum" in said and "60 mm" in said


def test_the_first_page_is_loaded_without_what_computes():
    code = "import sys, layerjam.workbench.pages.start; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    assert [tab.name for tab in TABS if tab.light] == ["start"]


def test_the_word_of_a_brake_follows_from_its_facts():
    assert describe_origin(load(KAPTON)).word == "paper"
    assert describe_origin(load("choi2018-polyester")).word == "handbook"
    assert {describe_origin(load(name)).word for name in catalogue()} <= set(ORIGINS)
    edited = edit(KAPTON, {"sheets.width": "20 mm"}).record
    assert (
        describe_origin(edited).word == "edited"
        and "sheets.width" in describe_origin(edited).sentence
    )


def with_kinds(notes=(), **kinds):
    file = load(KAPTON)
    paths = {"friction": "film.kinetic", "factor": "scale_factor"}
    changed = {paths[name]: Source(kind=kind, text="synthetic") for name, kind in kinds.items()}
    return replace(file, sources={**file.sources, **changed}, notes=dict(notes))


def test_a_brake_of_synthetic_files_is_synthetic_whatever_else_it_is():
    made = {"files": [{"name": "a.csv", "sha256": "0"}, {"name": "b.csv", "synthetic": True}]}
    assert describe_origin(with_kinds(factor="calibrated")).word == "calibrated"
    assert describe_origin(with_kinds(made, factor="calibrated")).word == "synthetic"
    # the mark of a single number counts as well
    assert (
        describe_origin(with_kinds(friction="synthetic", factor="calibrated")).word == "synthetic"
    )
    # what a source says in words is no fact
    assert describe_origin(with_kinds(friction="measured")).word == "measured"
    assert (
        describe_origin(with_kinds({"files": "synthetic"}, friction="measured")).word == "measured"
    )


def test_the_page_stands_drops_a_kilogram_and_takes_another_brake():
    async def use() -> None:
        async with standing(Start) as (user, pages):
            force = tensile(KAPTON, vacuum="94.5 kPa", speed="1 mm/s", travel="40 mm").peak_force
            await user.should_see(f"{force:.0f} N", retries=300)
            await user.should_see("The brake resists a pull of up to 176 N, the weight of 17.9 kg")
            await user.should_not_see("1 kg falls")
            user.find("Drop a kilogram").click()
            await user.should_see("1 kg falls 30 cm: the brake slips", retries=100)
            user.find(kind=ui.button, content="polyester").click()
            await user.should_see("handbook", retries=100)
            assert pages[-1].desk.brake.name == "choi2018-polyester"

    asyncio.run(use())
