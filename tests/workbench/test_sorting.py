"""The dialog of dropped files, where they come one after the other."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from itertools import accumulate, repeat

import pytest
from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload

from layerjam.workbench import sorting
from layerjam.workbench.dropping import SOON
from layerjam.workbench.pages.pull import Pull
from workbench.standing import standing

pytestmark = pytest.mark.timing

LINES = "\n".join(f"{i / 10},{min(7 * i, 175 - i)}" for i in range(60))

MORE = accumulate(repeat("\n"))
"""No two files are alike."""


@pytest.fixture
def read(monkeypatch):
    """{file: how often it was read}, each time slowly as a large file is; "most" at once."""
    counts, door, plain = Counter(), Counter(), sorting.propose_use

    def slow(key, name, path):
        door["now"] += 1
        counts["most"] = max(counts["most"], door["now"])
        counts[name] += 1
        time.sleep(3 * SOON)
        door["now"] -= 1
        return plain(key, name, path)

    monkeypatch.setattr(sorting, "propose_use", slow)
    return counts


async def drop(user, *names):
    """Files that come at once, and are being read after this."""
    (zone,) = [e for e in user.find(ui.upload).elements if e.props.get("data-testid") == "files"]
    files = [
        SmallFileUpload(name, "text/csv", f"mm,N\n{LINES}{next(MORE)}".encode()) for name in names
    ]
    await zone.handle_uploads(files)
    await asyncio.sleep(2 * SOON)


def names_in(user):
    """Of which files there are rows, while the dialog is open."""
    (dialog,) = [e for e in user.client.elements.values() if e.props.get("aria-label") == "Files"]
    rows = [e for e in dialog.descendants() if e.props.get("data-testid") == "dropped-file"]
    labels = [e.text for row in rows for e in row.descendants() if isinstance(e, ui.label)]
    return {text for text in labels if text.endswith(".csv")} if dialog.value else set()


async def until(condition):
    for _ in range(300):
        if condition():
            return
        await asyncio.sleep(0.05)
    raise AssertionError("it did not come so far")


@pytest.mark.slow
def test_each_of_many_files_is_read_once_and_what_was_accepted_is_not_asked_again(read):
    async def use() -> None:
        async with standing(Pull) as (user, pages):
            await user.should_see("Pulled to 40 mm", retries=300)
            await drop(user, "pull_60kPa.csv")
            await drop(user, "pull_100hPa.csv", "pull_7000Pa.csv")
            await until(lambda: names_in(user) == {"pull_60kPa.csv"})
            user.find("Use this").click()
            await until(lambda: names_in(user) == {"pull_100hPa.csv", "pull_7000Pa.csv"})
            await asyncio.sleep(2 * SOON)
            assert [f.shown for f in pages[-1].uploads.files_in_use] == ["pull_60kPa.csv"]

    asyncio.run(use())
    assert read.pop("most") == 1
    assert set(read.values()) == {1} and len(read) == 3
