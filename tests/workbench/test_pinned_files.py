"""Measured files pinned to the pull: drawn as points, in the session, in no link."""

from __future__ import annotations

import asyncio
import base64
import json
import zlib
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.core.errors import FileError, QuantityError
from layerjam.workbench import desk as desks
from layerjam.workbench import session
from layerjam.workbench.answer import build_notebook
from layerjam.workbench.charts import MARKS, mark_points
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages import pull_files
from layerjam.workbench.pages.pull import Pull, make_chart
from layerjam.workbench.pages.pull_files import Reading
from layerjam.workbench.pins import MAX_PINS, toggle_file_pin
from layerjam.workbench.session import (
    KIND,
    KeptFile,
    format_session,
    parse_session,
    read_kept_files,
)
from layerjam.workbench.state import MEASURED, Pin, State, format_link, parse_link
from workbench.standing import standing

ELONGATION = np.linspace(0.0, 20.0, 801)
FORCE = 150.0 * np.minimum(ELONGATION / 1.5, 1.0) - 2.0 * np.maximum(ELONGATION - 1.5, 0.0)
"""A pull by hand, in mm and N: 100 N/mm to a peak of 150 N, then 2 N/mm down."""
CSV = "\n".join(
    ["Extension (mm),Load (N)", *(f"{x},{f}" for x, f in zip(ELONGATION, FORCE, strict=True))]
).encode()
NAMES = {"60 kPa": b'vacuum = "60 kPa"\n', "made": b'vacuum = "60 kPa"\nsynthetic = true\n'}


def page_with(**sidecars: bytes) -> Pull:
    """The page of pulls with a file of each name, no two alike, and its sidecar."""
    page = Pull(Desk(State(page="pull", settings={"pull": {"vacuum": 60e3, "travel": 0.03}})))
    for count, (name, sidecar) in enumerate(sidecars.items()):
        page.uploads.store_file(f"{name}.csv.toml", sidecar)
        page.uploads.store_file(f"{name}.csv", CSV + b"\n" * count)
    return page


@pytest.fixture
def page():
    """One measured pull, pinned and computed."""
    made = page_with(mine=NAMES["60 kPa"])
    toggle_file_pin(made.desk, made.uploads.files[0].key)
    made.result = made.compute()
    yield made
    made.uploads.close()


def pinned(page) -> list[str]:
    """Labels of what is pinned, once the page has computed."""
    return [one.label for one in page.compute()[0].pins]


def test_a_pinned_file_is_drawn_as_the_file_has_it_and_called_measured(page):
    chart = make_chart(*page.result, False)
    (own,) = [s for s in chart["series"] if s["name"] == "measured, 60 kPa, mine.csv"]
    pairs = [p["value"] if isinstance(p, dict) else p for p in own["data"]]
    x, y = np.array([p for p in pairs if p[1] is not None]).T
    np.testing.assert_allclose(y, np.interp(x, ELONGATION, FORCE), atol=0.2)
    assert x[0] < 0.1 and x[-1] > 19.5
    points = [p for p in own["data"] if isinstance(p, dict)]
    assert MARKS / 2 < len(points) <= MARKS
    assert {p["symbol"] for p in points} == {"circle"}
    assert own["symbol"] == "none" and own["showSymbol"] and own["endLabel"]["show"]
    # once, not as a line besides; the model of that file and what is left over stay
    assert not [s for s in chart["series"] if s["name"] == "60 kPa, mine.csv"]
    assert [s["name"] for s in chart["series"] if s["yAxisIndex"]] == ["60 kPa, mine.csv, residual"]
    # the cursor reads it where it reads the others
    place = [
        [p["value"][0] if isinstance(p, dict) else p[0] for p in s["data"]] for s in chart["series"]
    ]
    assert all(one == place[0] for one in place)


def test_synthetic_files_and_those_without_a_vacuum_say_so():
    page = page_with(made=NAMES["made"], unsaid=b'speed = "1 mm/s"\n')
    for file in page.uploads.files:
        toggle_file_pin(page.desk, file.key)
    labels = pinned(page)
    page.uploads.close()
    assert labels == [
        "synthetic, 60 kPa, made.csv",
        "measured, vacuum not stated, unsaid.csv",
    ]


def test_of_many_files_the_pinned_one_is_named():
    page = page_with(**{f"pull{k}": NAMES["60 kPa"] for k in range(7)})
    key = page.uploads.files[4].key
    toggle_file_pin(page.desk, key)
    chart = make_chart(*page.compute(), False)
    named = [s["name"] for s in chart["series"] if s["endLabel"]["show"]]
    page.uploads.close()
    assert named == ["computed", "measured, 60 kPa, pull4.csv"]


def test_nothing_is_read_again_under_a_slider_and_nothing_of_it_is_in_the_link(page):
    reading = page.result[2]
    page.desk.put_setting("pull", "vacuum", 50e3)
    assert page.compute()[2] is reading
    assert parse_link(format_link(page.desk.state)).pins == ()
    key = page.uploads.files[0].key
    assert (
        key
        not in zlib.decompress(
            base64.urlsafe_b64decode(format_link(page.desk.state) + "==")
        ).decode()
    )


def test_a_session_carries_it_into_another_tab(page):
    state = page.desk.state
    page.uploads.store_file("waits.csv", b"x", waits=True)
    text = format_session(state, read_kept_files(page.uploads))
    opened = parse_session(text.encode(), "a.json")
    assert opened.state == state
    assert opened.files == (KeptFile("mine.csv", CSV, NAMES["60 kPa"].decode()),)
    other = Pull(Desk())
    other.uploads.store_file("mine.csv", b"another of that name")
    for one in opened.files:
        other.uploads.restore_file(one.name, one.data, one.sidecar)
        other.uploads.restore_file(one.name, one.data, one.sidecar)  # twice is once
    assert len(other.uploads.files) == 2
    other.desk.restore_state(opened.state)
    other.desk.announce_files()
    labels = pinned(other)
    other.uploads.close()
    assert labels == ["measured, 60 kPa, mine (2).csv"]


def test_the_pin_goes_with_the_file_and_undo_draws_nothing_that_is_gone(page):
    desk, key = page.desk, page.uploads.files[0].key
    assert desk.state.files == (key,)
    toggle_file_pin(desk, key)
    assert desk.state.files == ()
    desk.undo()
    assert desk.state.files == (key,)
    page.uploads.remove_files([key])
    desk.announce_files()
    assert desk.state.files == ()
    desk.redo()
    desk.undo()
    assert pinned(page) == []


def test_there_is_an_end_to_pins():
    page = page_with(**{f"pull{k}": NAMES["60 kPa"] for k in range(MAX_PINS + 1)})
    *enough, more = [file.key for file in page.uploads.files]
    for key in enough:
        toggle_file_pin(page.desk, key)
    with pytest.raises(QuantityError, match="unpin one"):
        toggle_file_pin(page.desk, more)
    assert page.desk.state.files == tuple(enough)
    page.uploads.close()


def test_figure_and_python_hold_it(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    taken = page.result[0]
    assert list(taken.pinned_answers) == ["measured, 60 kPa, mine.csv"]
    (tmp_path / "mine.csv").write_bytes(CSV)
    (tmp_path / "mine.csv.toml").write_bytes(NAMES["60 kPa"])
    exec(taken.python_code(), {})
    assert (tmp_path / "tensile.svg").read_bytes() == taken.figure("svg")
    assert b"measured, 60 kPa" in taken.figure("svg")
    assert "- `mine.csv`" in build_notebook("a", [taken.call], taken.pinned_calls)
    page.desk.put_setting("pull", "model", "judder")  # over time there is nothing to compare
    assert pinned(page) == []
    assert list(page.calls_to_copy()[1]) == list(taken.pinned_answers), (
        "the page shows what was computed last"
    )
    assert 'result.plot("tensile.svg", overwrite=True, beside=pinned)' in taken.python_code()


def packed(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data)).decode()


ONE = {"name": "a.csv", "sidecar": "", "content": packed(b"1")}


@pytest.mark.parametrize(
    ("files", "says"),
    [
        ({"a": ONE}, "a list"),
        ([ONE] * 201, "at most"),
        ([1], "files.0"),
        ([ONE, ONE | {"name": 3}], "files.1"),
        ([ONE | {"content": "§"}], "decompressed"),
        ([ONE | {"content": packed(b"1" * 999)[:-8]}], "decompressed|truncated"),
        ([ONE | {"content": packed(b"0" * 20_000)}, ONE], "larger than"),
    ],
)
def test_a_session_with_rubbish_for_files_is_refused(files, says, monkeypatch):
    monkeypatch.setattr(session, "LARGEST", 20_000)
    text = json.dumps({"kind": KIND, "version": 1, **asdict(State()), "files": files})
    with pytest.raises(FileError, match=says) as caught:
        parse_session(text.encode(), "mine.json")
    assert "mine.json" in str(caught.value)


def test_a_session_that_would_not_be_opened_is_not_written(monkeypatch):
    noise = np.random.default_rng(1).bytes(4_000)  # larger as text than it is
    for data in (noise, bytes(5_001)):
        monkeypatch.setattr(session, "LARGEST", 10_000)
        assert parse_session(format_session(State(), [KeptFile("a", data)]).encode(), "a").files
        monkeypatch.setattr(session, "LARGEST", 5_000)
        with pytest.raises(QuantityError, match="remove a file"):
            format_session(State(), [KeptFile("a", data)])


def test_a_pin_without_its_file_draws_nothing():
    page = Pull(Desk(State(page="pull", pins=(Pin("pull", MEASURED, "0123456789ab"),))))
    assert page.compute()[0].pinned_answers == {} and page.panel.problem == ""
    page.uploads.close()


@settings(max_examples=30)
@given(
    st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=300, unique=True),
    st.integers(2, 60),
    st.randoms(use_true_random=False),
)
def test_points_are_some_of_the_curve_spread_over_all_of_it(x, count, chance):
    pairs = [[v, chance.choice([None, chance.uniform(-5, 5)])] for v in sorted(x)]
    made = mark_points(pairs, count)
    assert [p["value"] if isinstance(p, dict) else p for p in made] == pairs
    seen = [k for k, p in enumerate(made) if isinstance(p, dict)]
    known = [k for k, (_, y) in enumerate(pairs) if y is not None]
    if len(known) > 1:
        assert set(seen) <= set(known) and len(seen) <= count
        assert seen[0] == known[0] and seen[-1] == known[-1]


def test_points_are_equally_far_apart_on_a_rise_and_beside_it():
    x = np.concatenate((np.linspace(0, 1, 2000), np.linspace(1, 40, 2000)[1:]))
    y = np.minimum(x, 1.0) * 100
    points = [
        p["value"]
        for p in mark_points(np.stack((x, y), axis=1).tolist(), 41)
        if isinstance(p, dict)
    ]
    a = np.array(points) / (40.0, 100.0)
    steps = np.hypot(*np.diff(a, axis=0).T)
    # a line of length 0.98 lies beside a rise of length 1.0; one step cuts the corner
    whole = np.sort(steps)[1:]
    assert np.ptp(whole) < 0.03 * whole.mean()


@pytest.mark.slow
def test_a_click_pins_the_one_file_that_is_there_and_a_second_takes_it_away():
    async def use() -> None:
        async with standing(Pull) as (user, pages):
            await user.should_see("Pulled to 40 mm", retries=300)
            page = pages[-1]
            await user.should_not_see(pull_files.TITLE)
            page.uploads.store_file("mine.csv.toml", NAMES["60 kPa"])
            page.uploads.store_file("mine.csv", CSV)
            page.desk.announce_files()
            await user.should_see(pull_files.TITLE, retries=300)
            user.find(pull_files.TITLE).click()
            await user.should_see("measured, 60 kPa, mine.csv", retries=100)
            await user.should_not_see(pull_files.TITLE, retries=100)
            page.panel.remove_pin(page.desk.state.pins[0])
            await user.should_see(pull_files.TITLE, retries=100)

    asyncio.run(use())


def test_no_files_no_labels():
    assert pull_files.collect_pinned_files(Desk(), Reading()) == ()


def test_a_reload_keeps_files_and_pins_and_a_duplicated_tab_does_not_take_them(page):
    old, key = page.desk, page.uploads.files[0].key
    path = page.uploads.files[0].path
    first = SimpleNamespace(tab_id="one", is_deleted=False)
    desks.move_files(first, old)
    twin = Desk()
    desks.move_files(SimpleNamespace(tab_id="one", is_deleted=False), twin)
    assert twin.files.files == []
    desks.move_files(first, old)
    first.tab_id = None  # the browser went away
    new = Desk(parse_link(format_link(old.state)))
    assert new.state.files == ()
    desks.move_files(SimpleNamespace(tab_id="one", is_deleted=False), new)
    assert new.state.files == (key,)
    old.files.close()
    desks.forget_desk(old)
    again = Pull(new)
    assert pinned(again) == ["measured, 60 kPa, mine.csv"]
    new.files.store_file("more.csv", b"1")
    assert len(set(path.parent.iterdir())) == 3  # two files and a sidecar
    desks.forget_desk(new)
    assert not any(desk in (old, twin, new) for _, desk in desks._desks.values())
    new.files.close()
    assert not path.exists()
