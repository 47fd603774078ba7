"""The design page without a browser: questions, links, refusals, pictures and tables."""

from __future__ import annotations

import asyncio
import json
import math

import pytest

from layerjam.brake.device.load import load
from layerjam.core.errors import FileError
from layerjam.studies.machines.apply import scenario
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import disambiguate
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages import design_front as front
from layerjam.workbench.pages.design import Design, array_chart, limits_table
from layerjam.workbench.pages.design_density import density_chart
from layerjam.workbench.pages.design_need import STOPPED, SearchResult, describe_problem
from layerjam.workbench.state import State, format_link, parse_link
from layerjam.workshop.commands.array import array
from layerjam.workshop.commands.compare import compare
from layerjam.workshop.commands.design import brake_of, design
from layerjam.workshop.design.specification import example_texts
from layerjam.workshop.figures.design_figures import find_front_axes
from workbench.standing import standing

SMALL = """name = "small <b>"
brake = "choi2018-kapton"
constraints = ["holding_force >= 300 N", "mass <= 60 g", "width <= 20 mm"]
objectives = ["minimise mass", "maximise energy_capacity"]
without = ["buildable", "drawn_mass"]
[vary]
count = [11, 21, 31]
width = { from = "10 mm", to = "30 mm", step = "5 mm" }
"""
IMPOSSIBLE = SMALL.replace("300 N", "300 kN")


def page_of(brake: str = "choi2018-kapton", **settings) -> Design:
    return Design(Desk(State(page="design", brake=brake, settings={"design": settings})))


@pytest.fixture(scope="module")
def small():
    return page_of(spec=SMALL).compute()[1].result


def test_the_page_asks_what_the_verbs_answer(small):
    page = page_of(spec=SMALL)
    assert small.values == design(page.parts["need"].spec()).values
    arrays = page_of(part="arrays", parallel=3.0).compute()[1]
    many, one = (answer.result for answer in arrays)
    assert many.values == array("choi2018-kapton", parallel=3, series=2, vacuum="94.5 kPa").values
    assert one.brakes == 1
    told = page_of(part="density", ours=60e3).compute()[1][0].result
    names = ("choi2018-polyester", "choi2018-ptfe-fiberglass", "choi2018-ptfe")
    assert told.values == compare("choi2018-kapton", *names, vacuum="60 kPa").values


def test_an_example_is_copied_by_its_name():
    assert page_of().calls() == [] and page_of().compute()[1] == SearchResult()
    assert page_of(spec="wrist").calls()[0].command_line() == "layerjam design wrist"
    assert page_of(spec="stop").calls()[0].command_line() == "layerjam design stop"
    assert page_of(spec=SMALL).calls()[0].command_line() == "layerjam design small-b.toml"


def test_the_share_of_brakes_is_that_of_the_last_search():
    """A slider that was moved since does not start a search, and is not copied."""
    (call,) = page_of(spec="wrist", share=0.7, confidence=0.9).calls()
    assert call.command_line() == "layerjam design wrist --confidence 0.7"
    found = page_of(spec=SMALL, share=0.6).compute()[1].result
    assert found.confidence == 0.6
    assert found.values == design(page_of(spec=SMALL).parts["need"].spec(), confidence=0.6).values


def test_a_link_brings_the_specification_back_and_the_brake_it_began_from(small):
    own = brake_of(small, small.chosen["number"]).text
    text = SMALL.replace("choi2018-kapton", f"small-b-{small.chosen['number']}.toml")
    page = page_of(spec=text, begin=own)
    again = Design(Desk(parse_link(format_link(page.desk.state))))
    assert again.parts["need"].spec().brake.text == own
    (call,) = again.calls()
    assert call.subjects[0].name == "small-b.toml"
    # whoever copies Python is offered both files that it reads
    names = {"small-b.toml", f"small-b-{small.chosen['number']}.toml"}
    assert set(disambiguate([call]).texts) == names
    # another brake on the desk does not take it away
    again.desk.put_brake("choi2018-ptfe")
    assert again.parts["need"].spec().brake.text == own


def test_nothing_is_searched_twice_and_nothing_anew_that_was_stopped():
    page = page_of(spec=SMALL)
    assert page.compute()[1] is page.compute()[1]
    page = page_of(spec=SMALL)
    page.runner.stop()
    assert page.compute()[1] == SearchResult(None, STOPPED)
    page.runner.stopping.clear()
    assert page.compute()[1].problem == STOPPED


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [("", None, "brake (name or path of the brake to start from"), ("rubbish", 1, ""),
     (SMALL.replace("60 g", "60 s"), 3, "mass"), (SMALL.replace("11,", '"x",'), None, "count"),
     (SMALL.replace("choi2018-kapton", "/etc/passwd"), 2, "unknown brake"),
     ("x" * 20_001, None, "the limit is 20000")],
    ids=["empty", "rubbish", "unit", "value", "path", "long"],
)  # fmt: skip
def test_refusals_are_words_with_their_line(text, line, words):
    page = page_of(spec=text)
    found = page.compute()[1]
    assert found.result is None and words in found.problem
    assert line is None or found.line == line
    said = describe_problem(found, text)
    assert "<b>" not in said
    with pytest.raises(FileError):
        page.calls()


def test_what_kills_a_specification_is_said():
    found = page_of(spec=IMPOSSIBLE).compute()[1]
    said = front.outcome_text(found.result)
    assert said.startswith("Not possible: holding_force >= 300 kN cannot be met")
    assert "none of the" in said


def test_every_point_of_the_picture_bears_its_design(small):
    names = find_front_axes(small)
    made = front.front_chart(small, names, front.CHOSEN, False)
    rows = front.all_designs(small)
    for series in made["series"]:
        for point in series["data"]:
            x, y, number = point["value"] if isinstance(point, dict) else point
            design = rows[small.chosen["number"] if number == front.CHOSEN else number]
            assert x == pytest.approx(design["mass"] * 1e3, rel=1e-5)
            assert y == pytest.approx(design["energy_capacity"], rel=1e-5)
    assert len(made["series"][0]["data"]) == len(small.front) == small.front_size
    json.dumps(made, allow_nan=False)


def test_walking_along_the_front_meets_every_design(small):
    numbers = front.front_indices(small)
    assert sorted(numbers) == sorted(d["number"] for d in small.front)
    masses = [front.all_designs(small)[n]["mass"] for n in numbers]
    assert masses == sorted(masses)
    assert front.pick_design(small, 10**9)[0] == small.chosen["number"]
    assert front.pick_design(small, front.REFINED)[1] is small.refined
    assert {"mass", "width"} <= set(front.find_axes(small))


def test_tables_tell_everything_and_escape_it(small):
    said = front.comparison_table(small, front.CHOSEN)
    for words in ("at most 60 g", "at least 300 N", "runner-up", "between grid steps", " mm"):
        assert words in said
    assert "width ≤ 20 mm" in front.exclusion_table(small)
    assert "all constraints" in front.probability_table(small)
    assert "1 % increase in" in front.sensitivity_table(small)


def test_pictures_hold_what_was_answered():
    whole, one = array("choi2018-kapton", parallel=2, series=2), array("choi2018-kapton")
    made = array_chart(whole, one, True)
    assert made["series"][0]["name"] == "2 × 2"
    top = max(y for _, y in made["series"][0]["data"])
    assert top == pytest.approx(whole.peak_force, rel=1e-4)
    told = compare("choi2018-ptfe", "choi2018-kapton")
    made = density_chart(told, False)
    json.dumps(made, allow_nan=False)
    drawn = [p["value"] for s in made["series"] if s["type"] == "scatter" for p in s["data"]]
    assert len(drawn) == len(told.devices)
    (low, high), (bottom, top) = (
        (made[a][0]["min"], made[a][0]["max"]) for a in ("xAxis", "yAxis")
    )  # fmt: skip
    assert all(low < x < high and bottom < y < top for x, y in drawn)
    # lines of one force over mass are straight and of slope one
    for series in made["series"]:
        if series["name"] == "":
            (x, y), (u, v) = series["data"]
            assert math.log(v / y) == pytest.approx(math.log(u / x), abs=1e-3)


def test_limits_of_a_machine_are_told():
    answer = scenario("slow-stop")
    said = limits_table(answer)
    assert said.count("<tr>") == 1 + len(answer.limits) and said.count(">met<") == len(
        answer.limits
    )


async def until(true) -> None:
    for _ in range(300):
        if true():
            return
        await asyncio.sleep(0.1)
    raise AssertionError("it did not come")


def test_the_page_stands(monkeypatch):
    async def use() -> None:
        link = format_link(State(page="design", settings={"design": {"spec": SMALL}}))
        async with standing(Design, link) as (user, pages):
            await user.should_see("designs meet all constraints", retries=300)
            need = pages[-1].parts["need"]
            desk = pages[-1].desk
            first = need._found[1].result
            numbers = front.front_indices(first)
            need.select_design(numbers[0])
            need.select_neighbour(1)
            assert need.selection() == numbers[1]
            need.use_design()
            assert desk.brake.name == f"small-b-{numbers[1]}"
            await user.should_see("is now the current brake")
            assert f'brake = "{desk.brake.name}.toml"' in need.editor.value
            need.start_search()
            assert desk.get("design", "begin", "") == desk.state.brake
            desk.put_setting("design", "hold_length", 0.03)
            assert "too short" in need.form.refused.text
            desk.undo()
            # what is typed as TOML moves the form, and stays as it was typed
            typed = need.editor.value.replace("holding_force >= 300 N", "max_force >= 220 N")
            need.editor.set_value(typed)
            need.form.follow_text(typed)
            assert desk.get("design", "hold_force", 0) == 220
            assert desk.get("design", "when", "") == "sliding" and need.editor.value == typed
            assert need.empty.visible, "it is not searched yet"
            desk.put_setting("design", "hold_force", 230.0)
            assert "max_force >= 230 N" in need.editor.value
            # another front is asked for: from then on no button acts on the one before
            before, name = first, desk.brake.name
            desk.put_setting("design", "spec", SMALL.replace("300 N", "250 N"))
            picked = need.selection()
            need.use_design()
            need.select_neighbour(1)
            assert need.panel.shown is None and need.answers() == []
            assert desk.brake.name == name and need.selection() == picked
            assert not need.results.visible and need.sentence.text == "Searching"
            # what comes late of the search before is not shown either
            need.draw(SearchResult(Answer(need.calls()[0], before)))
            assert not need.results.visible
            await until(lambda: need.results.visible)
            assert need._displayed_result() is need._found[1].result is not before
            need.select_design(front.front_indices(need._displayed_result())[-1])
            need.use_design()
            assert desk.brake.text == brake_of(need._displayed_result(), need.selection()).text
            need.editor.set_value(IMPOSSIBLE)
            need.start_search()
            await user.should_see("Not possible: holding force", retries=300)
            need.editor.set_value("")
            need.start_search()
            await user.should_see("brake (name or path of the brake to start from", retries=100)
            desk.put_setting("design", "part", "arrays")
            await user.should_see("share the load evenly", retries=100)

    asyncio.run(use())


def test_the_examples_are_those_of_the_program():
    assert {"wrist", "stop"} <= set(example_texts())
    assert load("choi2018-kapton").name == "choi2018-kapton"
