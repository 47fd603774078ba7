"""The page of the brake without a browser: the picture, the fields, the comparison."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nicegui import ui

from layerjam.brake.commands.edit import BRAKE_FIELDS as FIELDS
from layerjam.brake.device.load import load
from layerjam.core.units import get
from layerjam.workbench import live
from layerjam.workbench.controls import add_unit
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.brake import KIND, ROWS, Brake, compare_numbers, comparison_html
from layerjam.workbench.pages.records import bare_unit
from layerjam.workbench.scene import (
    MAX_SHEETS,
    UNIT,
    StackView,
    build_stack,
    describe_stack,
    find_magnification,
)
from layerjam.workbench.state import format_link, parse_link
from layerjam.workshop.commands.show import show
from strategies import one, random_brakes, seeds
from workbench.standing import simulate_user, standing

KAPTON = load("choi2018-kapton").brake


def boxes(brake, slip=0.0, share=1.0):
    return {box.name: box for box in build_stack(brake, slip, share).boxes}


@settings(max_examples=30, deadline=None)
@given(seeds, st.floats(0, 1), st.floats(0, 1))
def test_the_picture_is_true_in_length(seed, part, share):
    brake = one(random_brakes(seed, 1), 0)
    slip = part * brake.sheets.overlap
    rest, slid = boxes(brake, 0.0, share), boxes(brake, slip, share)
    drawn = min(int(brake.sheets.count), MAX_SHEETS)
    left, right = slid["sheet 0"], slid["sheet 1"]
    # where sheets of both ends lie over each other is the overlap left
    end = left.centre[0] + left.size[0] / 2
    start = right.centre[0] - right.size[0] / 2
    assert (end - start) * UNIT == pytest.approx(brake.sheets.overlap - slip, abs=1e-9)
    if slip < brake.sheets.overlap - 1e-4:
        assert slid["overlap"].size[0] * UNIT == pytest.approx(brake.sheets.overlap - slip)
    for k in range(drawn):
        moved = slid[f"sheet {k}"].centre[0] - rest[f"sheet {k}"].centre[0]
        assert moved * UNIT == pytest.approx(slip if k % 2 else 0.0, abs=1e-12)
        assert slid[f"sheet {k}"].size[1] * UNIT == pytest.approx(brake.sheets.width)
    # no sheet lies in another
    for k in range(drawn - 1):
        low, high = slid[f"sheet {k}"], slid[f"sheet {k + 1}"]
        assert high.centre[2] - low.centre[2] >= low.size[2]


def test_a_move_tells_the_picture_once_and_a_rest_nothing(monkeypatch):
    views, alone = [], []

    def page() -> None:
        views.append(StackView("seen"))

    def told(brake, *moves):
        """(stack, words, what is sent): after moves of which none waited for the one before."""
        [view] = views
        for slip, share in moves:
            stack = build_stack(brake, slip, share)
            words = describe_stack(brake, stack, slip)
            view.show(stack, words)
        return stack, words, live._waiting.pop(view.scene.client, {})

    async def drive() -> None:
        async with simulate_user(page) as user:
            await user.open("/")
            scene = views[0].scene
            scene._initialized_event.set()
            monkeypatch.setattr(ui.element, "run_method", lambda *all: alone.append(all))
            stack, words, sent = told(KAPTON, (0.0, 1.0), (0.01, 0.2))
            assert sent["spoken"] == {scene.id: words}
            seen = replayed({}, sent["spaces"][scene.id])
            assert told(KAPTON, (0.01, 0.2))[2] == {}
            fewer = replace(KAPTON, sheets=replace(KAPTON.sheets, count=6))
            stack, words, sent = told(fewer, (0.01, 0.2))
            seen = replayed(seen, sent["spaces"][scene.id])
            drawn = {(tuple(one["move"]), tuple(one["scale"])) for one in seen.values()}
            assert {(box.centre, box.size) for box in stack.boxes} <= drawn
            assert len(seen) == len(stack.boxes) + len(stack.labels)
            assert not alone

    asyncio.run(drive())


def replayed(things, calls):
    """What stands in a view after what it was told."""
    for name, thing, *rest in calls:
        if name == "create":
            things[rest[0]] = {"move": [0, 0, 0], "scale": [1, 1, 1]}
        elif name == "delete":
            del things[thing]
        else:
            things[thing][name] = rest
    return things


def test_vacuum_draws_sheets_and_enclosure_together():
    loose, tight = boxes(KAPTON, 0, 0.0), boxes(KAPTON, 0, 1.0)
    apart = [b["sheet 1"].centre[2] - b["sheet 0"].centre[2] for b in (loose, tight)]
    assert apart[1] < apart[0]
    assert tight["enclosure"].size[2] < loose["enclosure"].size[2]
    assert tight["sheet 0"].size == loose["sheet 0"].size


def test_what_is_not_to_scale_is_said():
    assert find_magnification(KAPTON.sheets.thickness, 11, KAPTON.sheets.width) == 5
    assert find_magnification(0.01, 11, 0.05) == 1
    many = replace(KAPTON, sheets=replace(KAPTON.sheets, count=100))
    stack = build_stack(many, 0.01, 1.0)
    assert stack.drawn == MAX_SHEETS
    words = describe_stack(many, stack, 0.01)
    assert "100 sheets, 24 of them drawn, 50 held on the left" in words
    assert "overlap by 58 mm of 68 mm" in words
    assert f"{stack.scale} times larger" in words
    assert "6 held on the left (blue) and 5 on" in describe_stack(
        KAPTON, build_stack(KAPTON, 0, 1), 0
    )


def test_every_number_of_a_brake_has_a_field():
    assert sorted(p for group in KIND.groups for p in KIND.paths(group)) == sorted(FIELDS)


@pytest.mark.parametrize(
    ("typed", "shown", "path", "taken"),
    [
        ("15", "13 mm", "sheets.width", "15 mm"),
        (" 1.5 cm ", "13 mm", "sheets.width", "1.5 cm"),
        ("3", "2.5 GPa", "film.modulus", "3 GPa"),
        ("13", "11", "sheets.count", "13"),
        ("15", "", "weighed_mass", "15 g"),
    ],
)
def test_a_bare_number_is_in_the_unit_shown(typed, shown, path, taken):
    spec = FIELDS[path][0]
    assert add_unit(typed, "" if spec.unit == "1" else bare_unit(shown, spec)) == taken


def test_the_comparison_says_which_is_better_in_words():
    here, beside = show("choi2018-kapton"), show("choi2018-ptfe")
    assert {k for k in ROWS} <= set(here.values)
    rows = comparison_html(here, beside).split("<tr>")
    (force,) = (row for row in rows if "Peak force of a pull at the site" in row)
    stronger = here.max_force > beside.max_force
    assert ("▲" if stronger else "▼") in force
    assert (", better" if stronger else ", worse") in force
    assert compare_numbers(2.0, 1.0, -1) == "▼ +100.0%, worse"
    assert compare_numbers(0.5, 1.0, -1) == "▲ −50.0%, better"
    assert compare_numbers(1.0, 1.0, 1) == "same"
    assert compare_numbers(None, 1.0, 1) == ""
    # what "0.00 %" would be said of is no difference, to either side and for either direction
    for part in (4.9e-5, -4.9e-5):
        assert {compare_numbers(1 + part, 1.0, better) for better in (-1, 0, 1)} == {"same"}
    assert compare_numbers(1 + 5.1e-5, 1.0, -1) == "▼ +0.01%, worse"
    assert compare_numbers(2.0, 1.0, 0) == "+100.0%"
    assert compare_numbers(2.0, 0.0, 1) == "▲ was zero, better"


def test_an_edited_brake_is_undone_and_comes_back_by_its_link():
    page = Brake(Desk())
    assert page.editor.change_values({"sheets.width": "26 mm"}) == ""
    assert page.desk.brake.name == "choi2018-kapton-edited"
    assert "is shorter than" in page.editor.change_values({"sheets.overlap": "600 mm"})
    assert page.editor.change_values({"sheets.count": "21"}) == ""
    assert page.desk.brake.name == "choi2018-kapton-edited"
    again = Desk(parse_link(format_link(page.desk.state)))
    assert again.brake.brake == page.desk.brake.brake
    page.desk.undo()
    assert get(page.desk.brake.brake, "sheets.count") == 11
    assert page.desk.brake.brake.sheets.width == 0.026
    page.desk.undo()
    assert page.desk.brake.brake == KAPTON


def test_the_page_is_built_and_answers():
    async def drive() -> None:
        async with standing(Brake) as (user, _):
            await user.should_see("Peak force of a pull at the site", retries=100)
            await user.should_see("Sources of the numbers")
            await user.should_see("11 sheets, 6 held on the left", retries=50)

    asyncio.run(drive())
