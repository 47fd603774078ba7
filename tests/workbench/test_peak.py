"""The peak of a pull set by hand, without a browser: what follows gives the asked force."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import pytest

from layerjam.brake.commands.tensile import tensile
from layerjam.workbench.desk import Desk, resize_stack
from layerjam.workbench.pages.pull import Pull
from layerjam.workbench.peak import MAX_SHEETS, describe_result
from layerjam.workbench.state import State

KAPTON = "choi2018-kapton"


@pytest.fixture
def page():
    settings = {"pull": {"vacuum": 60e3, "speed": 0.013, "travel": 0.03}}
    made = Pull(Desk(State(page="pull", settings=settings)))
    yield made
    made.uploads.close()


def peak(vacuum, brake=KAPTON):
    return tensile(brake, vacuum=vacuum, speed="13 mm/s", travel="30 mm").peak_force


def test_the_vacuum_found_gives_the_peak_of_the_command(page):
    found = page.peak.search_setting(150.0, by_sheets=False)
    assert peak(found.value) == pytest.approx(150.0, rel=1e-7)
    assert describe_result(found, 150.0, False).endswith("gives a peak of 150 N.")
    beyond = page.peak.search_setting(900.0, by_sheets=False)
    assert beyond.value is None
    assert beyond.force == peak(page.controls()["vacuum"].high)
    assert "the highest possible peak is" in describe_result(beyond, 900.0, False)


def test_the_sheets_found_are_the_nearest_at_this_vacuum(page):
    found = page.peak.search_setting(300.0, by_sheets=True)
    file = page.desk.brake
    about = {n: abs(peak(60e3, resize_stack(file, n)) - 300.0) for n in range(2, 60)}
    assert found.value == min(about, key=about.__getitem__)
    assert f"{int(found.value)} sheets" in describe_result(found, 300.0, True)
    beyond = describe_result(page.peak.search_setting(1e6, by_sheets=True), 1e6, True)
    assert beyond.startswith(f"No number of sheets up to {MAX_SHEETS} sheets gives")


def test_a_peak_that_is_drawn_during_the_last_search_appears_in_the_field(page, monkeypatch):
    """The released pointer asks once more for the peak that is shown, and nothing else is drawn."""
    setting, texts = page.peak, []
    setting.field = SimpleNamespace(value="150", show_text=texts.append)

    def search(force, by_sheets):
        setting.fill(force)
        assert texts == [], "what is typed stays during a search"
        return object()

    monkeypatch.setattr(setting, "search_setting", search)
    monkeypatch.setattr(setting, "_apply_result", lambda *_: None)
    setting._asked, setting._seeking = 120.1, True
    asyncio.run(setting._search_target())
    assert texts == ["120.1"]


def test_a_dragged_peak_is_one_step_of_undo_and_the_slider_follows():
    desk, seen = Desk(), []
    desk.add_watcher(seen.append)
    for vacuum in (50e3, 51e3, 52e3):
        desk.put_setting("pull", "vacuum", vacuum, follow=True)
    assert seen == ["moved"] * 3
    desk.undo()
    assert desk.state == Desk().state
