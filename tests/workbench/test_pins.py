"""Pinned curves: kept as calls in the state, labelled by what differs, safe to take from a link."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from layerjam.brake.commands.drop import drop
from layerjam.brake.commands.tensile import tensile
from layerjam.brake.commands.vacuum_line import rise
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, DataFile, Subject
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.drop import Drop
from layerjam.workbench.pages.drop_outcome import drop_chart, time_series
from layerjam.workbench.pages.pull import STICK_SLIP, Pull, make_chart
from layerjam.workbench.pages.pull_chart import stick_slip_chart
from layerjam.workbench.pages.vacuum import Vacuum
from layerjam.workbench.pins import MAX_PINS, make_call, make_pin, make_pin_labels
from layerjam.workbench.state import Pin, State, format_link, parse_link
from workbench.standing import standing

KAPTON, PTFE = "choi2018-kapton", "choi2018-ptfe"


def call(vacuum="60 kPa", brake=KAPTON, **more) -> Call:
    said = {"vacuum": vacuum, "speed": "1 mm/s", "elongation": "20 mm", **more}
    return Call("tensile", (Subject(brake),), said)


def test_a_pin_goes_with_the_link_and_gives_the_numbers_of_the_command():
    pin = make_pin("pull", call("40 kPa"))
    state = parse_link(format_link(State(page="pull", pins=(pin,))))
    assert state.pins == (pin,)
    page = Pull(Desk(state))
    page.result = answer, whole, reading, band = page.compute()
    (kept,) = answer.pins
    own = tensile(KAPTON, vacuum="40 kPa", speed="1 mm/s", travel="20 mm")
    assert kept.answer.result.values == own.values
    # not computed twice
    assert page.compute()[0].pins[0].answer is kept.answer
    chart = make_chart(answer, whole, reading, band, False)
    quiet = chart["series"][-1]
    assert quiet["name"] == kept.label
    assert max(y for _, y in quiet["data"]) == pytest.approx(own.peak_force, rel=1e-5)
    assert "beside=pinned" in answer.python_code()
    assert list(page.calls_to_copy()[1].values()) == [call("40 kPa")]
    page.uploads.close()


@pytest.mark.slow
def test_a_sawtooth_is_pinned_and_drawn_beside_another():
    said = {"vacuum": "60 kPa", "speed": "1 mm/s"}
    kept = make_pin("pull", Call(STICK_SLIP, (Subject(KAPTON),), said))
    pinned = make_call(kept).run()
    shown = Call(STICK_SLIP, (Subject(KAPTON),), {**said, "vacuum": "40 kPa"}).run()
    whole = Call("show", (Subject(KAPTON),)).run()
    names = [
        line.get("name")
        for line in stick_slip_chart(shown, whole, False, {"60 kPa": pinned})["series"]
    ]
    assert "60 kPa" in names and parse_link(format_link(State(pins=(kept,)))).pins == (kept,)


def test_the_label_says_what_differs():
    shown = call("94.5 kPa")
    assert make_pin_labels([call("60 kPa"), call("94.5 kPa", PTFE)], shown) == ["60 kPa", PTFE]
    assert make_pin_labels([call("60 kPa", PTFE)], shown) == [f"{PTFE}, 60 kPa"]
    assert make_pin_labels([call("94.5 kPa")], shown) == ["as shown"]
    assert make_pin_labels([call("94.5 kPa", model="stack")], shown) == ["stack"]
    assert make_pin_labels([shown], call("94.5 kPa", model="stack")) == ["no model"]
    many = [call("60 kPa"), call("60 kPa", model="stack"), call("60 kPa", PTFE), call("60 kPa")]
    made = make_pin_labels(many, shown)
    assert len(set(made)) == len(made)


@pytest.mark.parametrize(
    "pin",
    [
        Pin("pull", "bench run", KAPTON),
        Pin("pull", "drop", KAPTON, {"vacuum_history": "/etc/passwd"}),
        Pin("drop", "drop", KAPTON, {"vacuum_history": "/etc/passwd"}),
        Pin("pull", "tensile", "/etc/passwd", {"vacuum": "60 kPa"}),
        Pin("pull", "tensile", KAPTON, {"brake": "/etc/passwd"}),
        Pin("pull", "tensile", KAPTON, {"progress": True}),
        Pin("vacuum", "regulate", "choi2018", {"step": "/etc/passwd"}),
        Pin("vacuum", "rise", "/etc/passwd", {"target": "60 kPa"}),
        Pin("vacuum", "rise", KAPTON, {"target": "60 kPa"}),
    ],
)
def test_a_link_can_ask_for_nothing_but_curves_of_the_page(pin):
    with pytest.raises(LayerjamError):
        make_call(pin)
    page = Pull(Desk(State(page="pull", pins=(pin,))))
    assert page.compute()[0].pins == ()
    page.uploads.close()


def test_a_drop_is_pinned_and_drawn_with_its_own_end():
    options = {"mass": "1 kg", "speed": "1.5 m/s", "rope_stiffness": "16.8 kN/m"}
    pins = (Pin("drop", "drop", KAPTON, {**options, "vacuum": "60 kPa"}),)
    page = Drop(Desk(State(page="drop", pins=pins, settings={"drop": {"shown": "full"}})))
    call = page.table_calls()["full"]
    own, slower = call.run(), drop(KAPTON, vacuum="60 kPa", **options)
    answer = Answer(call, own, pins=page.panel.pinned_answers(call))
    assert list(answer.pinned_calls) == ["60 kPa"]
    assert slower.stopping_time > own.stopping_time
    beside = {label: one.result for label, one in answer.pinned_answers.items()}
    chart = drop_chart(time_series(own.record), None, beside, False)
    quiet = [s for s in chart["series"] if s["name"] == "60 kPa"]
    ends = (slower.peak_force, slower.record.travel[-1] * 1e3, slower.peak_deceleration)
    for one, most in zip(quiet, ends, strict=True):
        assert max(y for _, y in one["data"]) == pytest.approx(most, rel=1e-4)
    assert chart["xAxis"][0]["max"] == pytest.approx(slower.stopping_time * 1e3, rel=1e-4)
    page.desk.files.close()


def test_steps_of_a_vacuum_line_are_pinned_apart_from_its_regulator():
    pins = (
        Pin("vacuum", "rise", "choi2018", {"target": "80 kPa"}),
        Pin("vacuum", "regulate", "choi2018", {"target": "80 kPa", "safe_state": "release"}),
    )
    page = Vacuum(Desk(State(page="vacuum", pins=pins)))
    answer, _ = page.compute()  # nothing is regulated yet
    (step,) = answer.pins
    own = rise("choi2018", target="80 kPa")
    assert step.answer.result.rise_time == own.rise_time
    (pane,) = step.answer.result.panes()
    assert own.target < 1e3 * pane.curves[0].y[-1] <= 1.12 * own.target
    assert step.pin is pins[0] and step.label == "80 kPa"
    page.desk.files.close()


def test_what_comes_from_a_dropped_file_is_not_kept(tmp_path):
    with pytest.raises(QuantityError, match="dropped"):
        make_pin("pull", call(interfaces=DataFile("a.csv", tmp_path / "a.csv")))


def test_pin_drag_unpin_and_undo_on_the_page():
    async def use() -> None:
        async with standing(Pull) as (user, pages):
            await user.should_see("Pulled to 40 mm", retries=300)
            page = pages[-1]
            user.find("Pin").click()
            await user.should_see("as shown", retries=100)
            page.desk.put_setting("pull", "vacuum", 50e3)
            await user.should_see("94.5 kPa", retries=100)
            assert len(page.panel.chart.options["series"]) == 2
            first = np.array(page.panel.chart.options["series"][0]["data"])[:, 1].max()
            assert np.array(page.panel.chart.options["series"][1]["data"])[:, 1].max() > first
            page.panel.remove_pin(page.desk.state.pins[0])
            assert page.desk.state.pins == ()
            page.desk.undo()
            assert len(page.desk.state.pins) == 1
            await page.wait_until_idle()
            for k in range(MAX_PINS + 2):
                page.desk.put_setting("pull", "vacuum", 20e3 + 1e3 * k)
                await asyncio.sleep(0)
                await page.wait_until_idle()
                page.panel.pin_answer()
            assert len(page.desk.state.pins) == MAX_PINS

    asyncio.run(use())
