"""Stop pressed during a computation: figure, copied Python and pin stay those of one computation.

The inputs are others by then. Whatever the page gives away must be what its chart still shows.
"""

from __future__ import annotations

import asyncio
import threading

import pytest
from nicegui import ui

from layerjam.workbench.call import Call, python_code
from layerjam.workbench.pages.design import Design
from layerjam.workbench.pages.drop import Drop
from layerjam.workbench.pages.pull import Pull
from layerjam.workbench.pins import make_call
from layerjam.workbench.state import State, format_link
from workbench.standing import standing


@pytest.fixture
def held(monkeypatch):
    """Once `armed`, a command that reports its progress waits for `released`, then reports it."""
    gate = {name: threading.Event() for name in ("armed", "begun", "released")}
    real = Call.run

    def run(self, by=None, **more):
        if gate["armed"].is_set() and "progress" in more:
            gate["begun"].set()
            gate["released"].wait(60)
            more["progress"]("computing", 0.5)
        return real(self, by, **more)

    monkeypatch.setattr(Call, "run", run)
    yield gate
    gate["released"].set()


async def stop_during(user, page, held, change) -> None:
    """Change an input, wait until it is being computed, press Stop."""
    held["armed"].set()
    change()
    for _ in range(600):
        if held["begun"].is_set():
            break
        await asyncio.sleep(0.05)
    assert held["begun"].is_set()
    await user.should_see(kind=ui.button, content="Stop", retries=100)
    user.find(kind=ui.button, content="Stop").click()
    held["released"].set()
    await page.wait_until_idle()
    held["armed"].clear()


def run_lines(text, folder, monkeypatch) -> dict:
    """Names that copied Python leaves, run in an empty folder."""
    monkeypatch.chdir(folder)
    space: dict[str, object] = {}
    exec(text, space)
    return space


CASES = [
    (Drop, {"shown": "full"}, "mass", 2.0, "101 kPa stops 1 kg", {"mass": "1 kg"}),
    (Pull, {}, "vacuum", 40e3, "Pulled to 40 mm", {"vacuum": "94.5 kPa"}),
    pytest.param(
        *(Pull, {"model": "stack"}, "travel", 0.02, "Pulled to 40 mm", {"elongation": "40 mm"}),
        marks=pytest.mark.slow,
    ),
]


@pytest.mark.parametrize(("kind", "settings", "key", "value", "seen", "before"), CASES)
def test_figure_python_and_pin_are_one(
    kind, settings, key, value, seen, before, held, tmp_path, monkeypatch
):
    async def use() -> None:
        link = format_link(State(page=kind.name, settings={kind.name: settings}))
        async with standing(kind, link) as (user, pages):
            await user.should_see(seen, retries=600)
            page = pages[-1]
            await page.wait_until_idle()
            shown, drawn = page.panel.shown, page.panel.chart.options["series"]
            await stop_during(
                user, page, held, lambda: page.desk.put_setting(kind.name, key, value)
            )
            await user.should_see("stopped", retries=100)
            await user.should_see(seen)
            assert page.value(key) == value, "the control has moved on"
            assert page.panel.shown is shown and page.panel.chart.options["series"] is drawn
            # the figure that is taken away, the Python under the chart and that of the header
            space = run_lines(shown.python_code(), tmp_path, monkeypatch)
            assert space["result"].values == shown.result.values
            (figure,) = tmp_path.glob("*.svg")
            assert figure.read_bytes() == shown.figure("svg")
            calls, _ = page.calls_to_copy()
            assert python_code(calls) and shown.call in calls
            for call in calls:
                assert call.options.items() & before.items() or call.name not in ("drop", "tensile")
            # the pin
            page.panel.pin_answer()
            (pin,) = page.desk.state.pins
            assert pin.options.items() >= before.items()
            assert make_call(pin) == shown.call
            await page.wait_until_idle()
            # and with the next computation all of them follow
            page.refresh()
            await asyncio.sleep(0)
            await page.wait_until_idle()
            (option,) = before  # the page keeps former keys, the command has its own names
            assert page.panel.shown.call.options[option] != before[option]

    asyncio.run(use())


def test_a_machine_stays_with_its_copy(held):
    async def use() -> None:
        part, key = "machines", "scenario"
        settings = {"design": {"part": part, key: "slow-stop"}}
        async with standing(Design, format_link(State(page="design", settings=settings))) as (
            user,
            pages,
        ):
            await user.should_see("Scenario", retries=300)
            page = pages[-1]
            machine = page.parts[part]
            for _ in range(600):
                if machine.result is not None:
                    break
                await asyncio.sleep(0.05)
            verdict = machine.verdict.text
            await stop_during(
                user, page, held, lambda: page.desk.put_setting("design", key, "neck-guard")
            )
            assert machine.verdict.text == verdict
            (call,) = page.calls_to_copy()[0]
            assert call.subjects[0].name == "slow-stop"

    asyncio.run(use())


@pytest.mark.slow
def test_a_search_that_was_stopped_shows_no_front_to_take_away(held):
    """The front of the search before is gone, and with it all that could be copied of it."""

    async def use() -> None:
        small = """name = "small"
brake = "choi2018-kapton"
constraints = ["holding_force >= 300 N", "width <= 20 mm"]
objectives = ["minimise mass", "maximise energy_capacity"]
[vary]
count = [11, 21, 31]
width = { from = "10 mm", to = "30 mm", step = "10 mm" }
"""
        settings = {"design": {"spec": small}}
        async with standing(Design, format_link(State(page="design", settings=settings))) as (
            user,
            pages,
        ):
            await user.should_see("designs meet all constraints", retries=600)
            page, need = pages[-1], pages[-1].parts["need"]
            (answer,) = page.answers()
            assert need.panel.shown is answer and answer.result.values["name"] == "small"
            other = small.replace("300 N", "250 N")
            await stop_during(
                user, page, held, lambda: page.desk.put_setting("design", "spec", other)
            )
            assert need.panel.shown is None and page.answers() == []
            assert not need.results.visible and not need.panel.chart.visible
            (call,) = page.calls_to_copy()[0]
            assert "250 N" in call.subjects[0].file.text

    asyncio.run(use())
