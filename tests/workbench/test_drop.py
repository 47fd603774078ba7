"""The drop page without a browser: its questions, its words, what it sends to be drawn."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from nicegui import ui
from nicegui.testing.user_interaction import UserInteraction

from layerjam.brake.commands.drop import drop
from layerjam.brake.commands.tuning import tune
from layerjam.core.command.declare import load_command
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.drop import KEYS, NO_ROPE, Drop, Drops
from layerjam.workbench.pages.drop_outcome import (
    FOLLOWS,
    SLOW,
    describe_drop,
    drop_tables,
    headlines,
    list_notes,
    slow_motion_factor,
    time_series,
)
from layerjam.workbench.state import State, format_link, parse_link
from layerjam.workbench.uploads import Upload
from workbench.standing import standing

KAPTON = "choi2018-kapton"
CASE = {"mass": "1 kg", "speed": "1.5 m/s", "rope_stiffness": "16.8 kN/m"}


CALL = Call("drop", (Subject(KAPTON),), {"mass": "1 kg"})


def page_of(**settings) -> Drop:
    return Drop(Desk(State(page="drop", settings={"drop": settings})))


def test_the_page_asks_what_the_verbs_answer():
    shown, drops, tuned, _ = page_of().compute()
    assert shown == "tuned"
    assert list(drops) == ["none", "full", "tuned"]
    own = drop(KAPTON, **CASE, vacuum="tuned", travel="40 mm")
    assert drops["tuned"].result.values == own.values
    assert drops["none"].result.values == drop(KAPTON, **CASE, no_brake=True).values
    assert tuned.result.values == tune(KAPTON, **CASE, travel="40 mm").values


@pytest.mark.parametrize(
    "settings", [{}, {"shown": "full"}, {"on_rope": "none"}, {"shown": "none"}, {"speed": 5.0}]
)
def test_a_move_shows_the_same_numbers_first_and_their_intervals_at_rest(settings):
    part = page_of(**settings).begin()
    first = part.content
    view, answers, tuning, pins = part.finish()
    whole = Drops({}, view, answers, tuning, pins, first.runner)
    assert first.chart_mode == whole.chart_mode
    before, after = first.chart_stop, whole.chart_stop
    assert {**before.values, "intervals": None} == {**after.values, "intervals": None}
    assert time_series(before.record) == time_series(after.record)
    assert not getattr(before, "intervals", None)
    assert bool(after.intervals) == (whole.chart_mode != "none")
    assert (before.basis, before.basis_reason) == (after.basis, after.basis_reason)
    # a vacuum that stops nothing is explained at length once the sliders rest
    assert whole.continues(first) == (settings.get("speed") != 5.0)
    texts = [
        {hero.key: hero.text for hero in headlines(drops.chart_stop, drops.chart_tuning)}
        for drops in (first, whole)
    ]
    if whole.chart_tuning is not None:
        assert texts[0].pop("hero-safe") == FOLLOWS != texts[1].pop("hero-safe")
    assert texts[0] == texts[1]


def test_a_link_brings_the_drop_back():
    page = page_of(mass=2.0, direction="horizontal", shown="full")
    again = Drop(Desk(parse_link(format_link(page.desk.state))))
    assert again.calls() == page.calls()
    assert again.calls()[0].options["horizontal"] is True
    # rubbish in a link leaves the defaults
    odd = page_of(mass="heavy", shown=3.0, arrives="train")
    assert odd.calls() == page_of().calls()


def test_without_a_rope_no_brake_is_refused_in_words_and_the_rest_answered():
    page = page_of(on_rope="none", shown="none")
    page.result = shown, drops, *_ = page.compute()
    assert drops["none"].result is None and drops["none"].refusal == NO_ROPE
    assert drops["full"].result.feasible
    assert [answer.call for answer in page.answers()] == page.calls() and len(page.calls()) == 3
    assert "Not possible: there is neither a rope" in describe_drop(None, drops[shown].refusal, {})


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            {"shown": "tuned", "speed": 2.5},
            "59.9 kPa stops 1 kg from 2.5 m/s within 40 mm, at up to 11.4 g.",
        ),
        ({"shown": "full"}, "101 kPa stops 1 kg from 1.5 m/s within 0.31 mm, at "),
        (
            {"shown": "value", "vacuum": 5e3},
            "The travel of 60 mm is used up with the mass still moving at",
        ),
        ({"shown": "full", "mass": 0.1, "speed": 0.5}, "Stopped in "),
        ({"shown": "tuned", "speed": 5.0}, "Not possible: 5 m/s is too fast for 40 mm"),
        ({"shown": "none"}, "The rope alone stops 1 kg from 1.5 m/s in 12.5 ms, at "),
        ({"shown": "value", "vacuum": 60e3, "rope_stiffness": 500.0, "speed": 5.0}, "Not possible"),
    ],
)
def test_what_happened_in_words(settings, words):
    shown, drops, *_ = page_of(**settings).compute()
    answer = drops[shown]
    assert describe_drop(answer.result, answer.refusal, answer.call.options).startswith(words)
    html, others = drop_tables(drops, shown)
    assert 6 <= html.count("<tr>") <= 8 and html.count("<th") <= 12
    assert "Dissipated energy" in others
    said = list_notes(drops)
    assert len(said) == len(set(said))


@pytest.mark.slow
def test_what_the_fold_more_holds_reaches_the_command(tmp_path):
    page = page_of(rope_damping="20 N s/m", duration="0.2 s", accelerometer="adxl193", seed="x")
    names = {p.name for p in page.more.inputs} | set(KEYS) | {"brake", "progress"}
    names.add("has_intervals")  # for the page itself
    assert names == {p.name for p in load_command("drop").parameters}
    file = tmp_path / "made-up.csv"
    file.write_text("time [s],vacuum [kPa]\n" + "".join(f"{i / 100},60\n" for i in range(200)))
    page.more.files["vacuum_history"].files.append(Upload("my log.csv", file))
    shown, drops, *_ = page.compute()
    assert shown == "history"
    own = drop(KAPTON, **CASE, vacuum_history=file, rope_damping="20 N s/m", duration="0.2 s",
               accelerometer="adxl193")  # fmt: skip
    assert drops["history"].result.peak_force == own.peak_force
    assert drops["none"].result.accelerometer == "adxl193"
    words = page.table_calls()["history"].command_line()
    assert "--vacuum-history 'my log.csv'" in words and "--vacuum " not in words
    odd = page_of(rope_damping="20 furlongs", atmosphere="12 s")
    assert odd.calls() == page_of().calls()


def test_the_table_holds_no_markup_of_others():
    tables = drop_tables({"none": Answer(CALL, refusal="<script>alert(1)</script>")}, "none")
    assert "<script>" not in "".join(tables)


def test_what_is_sent_is_the_record():
    record = drop(KAPTON, **CASE, vacuum="tuned", travel="40 mm").record
    made = time_series(record)
    time = np.array(made["time"]) / 1e3
    for key, column, factor in (
        ("travel", record.travel, 1e3), ("force", record.force, 1.0), ("slip", record.slip, 1e3),
        ("deceleration", record.force / record.mass - record.gravity, 1.0),
    ):  # fmt: skip
        exact = np.interp(time, record.time, column) * factor
        assert made[key] == pytest.approx(exact, abs=1e-4 * np.abs(exact).max())
    assert max(made["force"]) == pytest.approx(record.force.max(), rel=1e-4)
    assert made["slow"] == 100.0 and not made["horizontal"] and made["brake"]
    bare = time_series(drop(KAPTON, **CASE, no_brake=True).record)
    assert not bare["brake"] and bare["slip"] == []
    assert max(bare["travel"]) == pytest.approx(max(bare["force"]) / 16.8, rel=1e-3)
    for lasts in (1e-6, 0.01, 0.3, 60.0):
        assert slow_motion_factor(lasts) in SLOW


def press(user, ident):
    buttons = user.find(kind=ui.button).elements
    UserInteraction(user, {b for b in buttons if b.props.get("data-testid") == ident}, None).click()


def test_the_page_stands_and_follows_its_controls():
    async def use() -> None:
        async with standing(Drop) as (user, pages):
            await user.should_see("25.1 kPa stops 1 kg from 1.5 m/s within 40 mm", retries=300)
            page = pages[-1]
            page.desk.put_setting("drop", "shown", "full")
            await user.should_see("101 kPa stops 1 kg from 1.5 m/s", retries=50)
            page.desk.put_setting("drop", "direction", "horizontal")
            await user.should_see("v²/2gd, for a constant force", retries=50)
            page.desk.undo()
            page.desk.undo()
            await user.should_see("25.1 kPa stops 1 kg from 1.5 m/s within 40 mm", retries=50)
            page.desk.put_setting("drop", "speed", 5.0)
            await user.should_see("Not possible: 5 m/s is too fast for 40 mm", retries=50)
            # full vacuum is shown, it crashes, and the page says what would stop it
            await user.should_see("it hits the end stop, with up to", retries=50)
            assert page.panel.chart.visible
            before = page.desk.state
            await user.should_see("23 sheets")
            press(user, "drop-advice-sheets")
            await user.should_see(" kPa stops ", retries=50)
            assert page.desk.brake.brake.sheets.count == 23
            page.desk.undo()
            assert page.desk.state == before
            await asyncio.sleep(0)
            await page.wait_until_idle()  # the table names three brakes before there is a button
            press(user, "drop-advice-brakes")
            await user.should_see(" kPa stops ", retries=50)
            assert page.value("mass") == pytest.approx(1 / 3)
            assert page.value("rope_stiffness") == pytest.approx(16.8e3 / 3)
            page.desk.undo()
            assert page.desk.state == before
            # the same button for another mass sets a third of that one
            page.desk.put_setting("drop", "mass", 0.98)
            await asyncio.sleep(0)
            await page.wait_until_idle()
            press(user, "drop-advice-brakes")
            assert page.value("mass") == pytest.approx(0.98 / 3)

    asyncio.run(use())


def test_a_drop_that_crashes_is_drawn_to_its_standstill_behind_the_travel():
    shown, drops, *_ = page_of(shown="value", vacuum=5e3).compute()
    stop = drops[shown].result
    made = time_series(stop.record, None, stop.crash)
    assert made["crash"] == pytest.approx(stop.record.time[-1] * 1e3)
    assert made["last"] > made["crash"]
    assert made["top"] == pytest.approx(stop.crash_force, rel=1e-4)
    after = np.array(made["time"]) > made["crash"] * (1 + 1e-6)
    assert set(np.array(made["slip"])[after]) == {60.0}
    assert made["travel"][-1] == pytest.approx(stop.crash.travel[-1] * 1e3, rel=1e-4)
    assert f"{stop.crash_g:.3g} g" in describe_drop(stop, "", {})
    # without a rope the record ends where it crashes, and nobody knows how hard
    bare = drop(KAPTON, mass="1 kg", speed="1.5 m/s", vacuum="5 kPa")
    alone = time_series(bare.record, None, bare.crash)
    assert alone["crash"] == pytest.approx(alone["last"])
    assert "The impact force is unknown" in describe_drop(bare, "", {})
    fine = drop(KAPTON, **CASE, vacuum="50 kPa")
    assert time_series(fine.record, None, fine.crash)["crash"] is None


def test_what_would_stop_it_is_looked_for_once(monkeypatch):
    """A vacuum that there is not costs one search, which takes most of the time."""
    from layerjam.brake.simulate import tuned

    asked = []
    real = tuned.suggest_sheet_count
    monkeypatch.setattr(tuned, "suggest_sheet_count", lambda case: asked.append(case) or real(case))
    _, drops, found, _ = page_of(speed=5.0).compute()
    assert len(asked) == 1
    own = drop(KAPTON, **CASE | {"speed": "5 m/s"}, vacuum="tuned", travel="40 mm")
    assert drops["tuned"].result.reason == own.reason == found.result.reason
