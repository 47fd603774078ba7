"""The vacuum page without a browser: questions, words, the line's numbers."""

from __future__ import annotations

import asyncio

import pytest

from layerjam.bench.commands.regulate import regulate
from layerjam.brake.commands.edit import LINE_FIELDS as FIELDS
from layerjam.brake.commands.edit import edit_line
from layerjam.brake.commands.force import force
from layerjam.brake.commands.vacuum_line import rise
from layerjam.core.errors import LayerjamError
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.vacuum import (
    Vacuum,
    describe_fault,
    detection_table,
    fault_choice,
    headlines,
)
from layerjam.workbench.state import State, format_link, parse_link
from workbench.standing import standing

SEEN = {"sensor_range": "103 kPa", "noise": "50 Pa", "duration": "20 s", "sample_time": "10 ms"}


def page_of(line: str = "choi2018", **settings) -> Vacuum:
    return Vacuum(Desk(State(page="vacuum", line=line, settings={"vacuum": settings})))


def test_nothing_is_regulated_until_a_safe_state_is_chosen():
    page = page_of(fault="leak")
    assert [call.name for call in page.calls()] == ["rise", "force"]
    page.desk.put_setting("vacuum", "safe_state", "hold")
    assert [call.name for call in page.calls()] == ["rise", "regulate", "force"]
    # a link cannot choose one that is none
    assert [c.name for c in page_of(safe_state="whatever").calls()] == ["rise", "force"]


def test_the_page_asks_what_the_verbs_answer():
    page = page_of(safe_state="release", fault="sensor-nan", fault_at=8.0)
    risen, loop, held = (answer.result for answer in page.compute())
    own = force("choi2018-kapton", slip="0 mm", vacuum="94.5 kPa")
    assert held.values == own.values
    (hero,) = (hero for hero in headlines(risen, held) if hero.key == "force")
    low, high = (round(own.intervals["force"][end]) for end in ("low", "high"))
    assert hero.interval == f"95 %: {low} N to {high} N"
    assert risen.values == rise("choi2018", target="94.5 kPa").values
    own = regulate("choi2018", target="94.5 kPa", safe_state="release", fault="sensor-nan",
                   fault_at="8 s", **SEEN)  # fmt: skip
    assert loop.values == own.values


def test_a_link_brings_line_and_settings_back():
    text = edit_line("choi2018", {"chamber.volume": "5 mL"}, name="mine").text
    page = page_of(text, safe_state="hold", target=40e3)
    again = Vacuum(Desk(parse_link(format_link(page.desk.state))))
    assert again.calls() == page.calls()
    assert again.calls()[0].subjects[0].name == "mine.toml"


def test_a_line_with_a_sensor_takes_its_own():
    text = edit_line("choi2018", takes={"sensor": "nxp-mpx5100dp"}).text
    assert "noise" not in page_of(text, safe_state="hold").calls()[1].options


@pytest.mark.parametrize("fault", [f for f in fault_choice().words if f != "none"])
def test_the_verdict_in_words(fault):
    page = page_of(safe_state="release", fault=fault, fault_at=0.5, duration=10.0)
    answer = page.compute()[1]
    loop = answer.result
    assert not answer.refusal
    words = describe_fault(loop)
    assert words.startswith("From 0.5 s on, ")
    assert ("reported nothing" in words) == (loop.outcome == "HEALTHY")
    if loop.outcome != "HEALTHY":
        assert "release: pump off, vent open" in words
    assert detection_table(loop).count("<dt>") == 8


def test_refusals_are_words_and_leave_the_other_answer():
    page = page_of(safe_state="hold", sample_time=0.5)  # beyond the slider; within the bounds
    risen, loop, _ = page.compute()
    assert risen.result is not None and loop.result is None
    assert loop.refusal.startswith("sample_time: 0.5 s is not allowed")
    tight = edit_line("choi2018", {"leak.laminar": "5 mL/s"}).text
    risen, loop, _ = page_of(tight, safe_state="hold").compute()
    assert not risen.result.feasible and "target" in loop.refusal


def test_the_page_stands_and_the_line_can_be_changed():
    async def use() -> None:
        async with standing(Vacuum) as (user, pages):
            await user.should_see("10 to 90 % in 3.9 s", retries=300)
            await user.should_see("The controller does not run until you choose a safe state")
            page = pages[-1]
            page.desk.put_setting("vacuum", "safe_state", "release")
            await user.should_see("No fault was reported. The rise to 94.5 kPa", retries=100)
            line = page.line
            for path in FIELDS:
                line.field_row(path)
            assert set(line.rows) == set(FIELDS)
            typed = line.field_row("chamber.volume").field
            typed.set_value("15.006")  # in the unit shown
            line.field_row("chamber.volume").on_type()
            assert page.desk.line.line.chamber.volume == pytest.approx(15.006e-6)
            assert page.desk.line.name == "choi2018-edited"
            await user.should_see("10 to 90 % in 7.8 s", retries=100)
            typed.set_value("15 kPa")
            line.field_row("chamber.volume").on_type()
            assert "units of m^3" in typed.error
            # a tube stands only with its bore; its length waits for it
            line.field_row("tube.length").field.set_value("1 m")
            line.field_row("tube.length").on_type()
            assert "tube.bore" in line.field_row("tube.length").field.error
            line.field_row("tube.bore").field.set_value("3 mm")
            line.field_row("tube.bore").on_type()
            assert page.desk.line.line.tube.length == 1.0
            line.use_part("valve", "smc-vt307v")
            assert page.desk.line.parts["valve"] == "smc-vt307v"
            for _ in range(3):
                page.desk.undo()
            assert page.desk.state.line == "choi2018"
            assert typed.value == "7.503 mL"
            with pytest.raises(LayerjamError):
                page.desk.put_file("line", "rubbish = \n")

    asyncio.run(use())
