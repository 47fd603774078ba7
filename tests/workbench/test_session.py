"""A session as a file: all of the state there and back, rubbish refused in a sentence."""

from __future__ import annotations

import asyncio
import json
from dataclasses import asdict, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload

from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.toml_files.toml import MAX_BYTES
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.pull import Pull
from layerjam.workbench.pins import MAX_PINS
from layerjam.workbench.session import KIND, format_session, parse_session
from layerjam.workbench.state import Pin, State
from layerjam.workbench.uploads import LARGEST
from workbench.standing import standing

KAPTON, PTFE = "choi2018-kapton", "choi2018-ptfe"
WORD = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
VALUE = st.one_of(WORD, st.booleans(), st.floats(allow_nan=False, allow_infinity=False))
PIN = Pin("pull", "tensile", PTFE, {"vacuum": "60 kPa", "speed": "1 mm/s", "elongation": "20 mm"})
EDITED = load(KAPTON).text + "\n# µ, edited\n"
STATE = State(page="pull", brake=EDITED, beside=PTFE, pins=(PIN,)).put_setting(
    "pull", "vacuum", 50e3
)


@given(st.dictionaries(WORD, st.dictionaries(WORD, VALUE, max_size=3), max_size=3))
def test_a_session_brings_everything_back(settings):
    state = replace(STATE, settings=settings)
    assert parse_session(format_session(state).encode(), "a.json") == (state, ())


def file_of(**changed) -> bytes:
    return json.dumps({"kind": KIND, "version": 1, **asdict(STATE), **changed}).encode()


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"\xff\xfe", "is not JSON"),
        (b"", "is not JSON"),
        (b"[" * 100_000, "is not JSON"),
        (b"[1, 2]", "is not a session"),
        (b'{"kind": "a brake"}', "is not a session"),
        (file_of(version=2), "a different version"),
        (file_of(page=3), "page"),
        (file_of(settings={"pull": {"vacuum": [1]}}), "settings.pull.vacuum"),
        (file_of(settings={"pull": {"vacuum": float("nan")}}), "unknown fields"),
        (file_of(pins=[{"page": "pull"}]), "pins.0"),
        (b" " * (LARGEST + 1), "the limit for a session"),
    ],
)
def test_rubbish_is_refused_with_the_files_name(data, says):
    with pytest.raises(FileError, match=says) as caught:
        parse_session(data, "mine.json")
    assert "mine.json" in str(caught.value)


def test_what_the_page_writes_of_the_largest_brakes_is_opened_again():
    """A brake of 1 MB, each line of which JSON makes longer, on the desk, beside it and in pins."""
    line = '# "\\'
    whole = EDITED + (line + "\n") * ((MAX_BYTES - len(EDITED) - 10) // (len(line) + 1))
    assert 0.99 * MAX_BYTES < len(whole) < MAX_BYTES
    pins = tuple(replace(PIN, page=page, subject=whole) for page in ("pull",) * MAX_PINS)
    state = replace(STATE, brake=whole, beside=whole, pins=pins)
    data = format_session(state).encode()
    assert 1_000_000 < len(data) < LARGEST
    assert parse_session(data, "a.json").state == state


def test_a_session_is_one_step_of_undo_and_a_brake_that_cannot_be_read_changes_nothing():
    desk = Desk(State(page="drop"))
    before = desk.state
    for wrong in ("/etc/passwd", "a = 1\n"):
        with pytest.raises(LayerjamError):
            desk.restore_state(replace(STATE, brake=wrong))
    with pytest.raises(LayerjamError):
        desk.restore_state(replace(STATE, line="none"))
    assert desk.state is before
    assert desk.brake.text == load(KAPTON).text
    desk.restore_state(STATE)
    assert desk.state == replace(STATE, page="drop")
    assert desk.brake.text == EDITED
    assert desk.undo()
    assert desk.state == before
    desk.files.close()


@pytest.mark.slow
def test_a_dropped_session_is_opened_and_another_json_is_not():
    async def use() -> None:
        async with standing(Pull) as (user, pages):
            await user.should_see("Pulled to 40 mm", retries=300)
            page = pages[-1]
            (zone,) = [
                e for e in user.find(ui.upload).elements if e.props.get("data-testid") == "files"
            ]

            async def drop(name: str, data: bytes) -> None:
                await zone.handle_uploads([SmallFileUpload(name, "application/json", data)])

            await drop("wrong.json", b"{}")
            await user.should_see("wrong.json: is not a session", retries=100)
            assert page.desk.state.pins == ()
            # of a later version with a page that is not here
            await drop("mine.json", file_of(page="nowhere"))
            for _ in range(100):
                if page.desk.state.pins:
                    break
                await asyncio.sleep(0.02)
            assert page.desk.state == STATE
            await page.wait_until_idle()
            (pinned,) = page.panel.shown.pins
            assert pinned.answer.call.subjects[0].name == PTFE

    asyncio.run(use())
