"""Whatever is added and withdrawn in whatever order: rows stay, links follow from what is there."""

from __future__ import annotations

import contextlib
import json
import shutil
import sqlite3
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from laboratory.records.samples import pull_file
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.records.contents import CALIBRATED
from layerjam.laboratory.records.database import Database, RecordsError
from layerjam.laboratory.records.store import add, withdraw_record

PULLS = ("a.csv", "b.csv", "c.csv")
CITES = {"x.json": ("a.csv",), "y.json": ("a.csv", "b.csv", "c.csv"), "z.json": ("b.csv", "lost")}
OTHER_NAME = {"a again.csv": "a.csv", "y again.json": "y.json"}
FILES = (*PULLS, *CITES, *OTHER_NAME)
STEPS = st.one_of(
    st.tuples(st.just("add"), st.lists(st.sampled_from(FILES), min_size=1, max_size=4)),
    st.tuples(st.just("withdraw"), st.sampled_from((*PULLS, *CITES))),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Pulls, calibrations that name some of them, and copies under other names."""
    made = tmp_path_factory.mktemp("sequences")
    digests = {"lost": "0" * 64}
    for number, name in enumerate(PULLS):
        digests[name] = sha256(str(pull_file(made / name, 10.0 + number)))
    for name, cited in CITES.items():
        files = [{"name": pull, "sha256": digests[pull]} for pull in cited]
        said = {**dict.fromkeys(CALIBRATED, 0), "made_from": {"files": files}, "own": name}
        (made / name).write_text(json.dumps(said))
    for copy, name in OTHER_NAME.items():
        shutil.copy(made / name, made / copy)
    return made


def every_row(db: Path) -> dict[str, Counter[Any]]:
    """All rows of all tables and views, by SQLite's own module."""
    with contextlib.closing(sqlite3.connect(db)) as base:
        assert base.execute("PRAGMA foreign_key_check").fetchall() == []
        listed = "SELECT name FROM sqlite_master WHERE type IN ('table', 'view')"
        names = [name for (name,) in base.execute(listed)]
        return {name: Counter(base.execute(f"SELECT * FROM {name}")) for name in names}


@settings(max_examples=12, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(STEPS, min_size=1, max_size=6), st.integers(0, 10**9))
def test_rows_stay_and_links_follow(folder: Path, steps: list[Any], number: int) -> None:
    db = folder / f"{number}.db"
    db.unlink(missing_ok=True)
    base = Database(db)
    ids: dict[str, str] = {}
    gone: set[str] = set()
    before: dict[str, Counter[Any]] = {}
    for act, what in steps:
        if act == "add":
            made = add(base, [folder / name for name in what])
            for name in dict.fromkeys(what):
                true, path = OTHER_NAME.get(name, name), str(folder / name)
                if true in ids:
                    assert ids[true] in made.refused[path]
                else:
                    ids[true] = made.ids[path]
        elif what in ids and what not in gone:
            withdraw_record(base, ids[what], "odd")
            gone.add(what)
        else:
            with pytest.raises(RecordsError):
                withdraw_record(base, ids.get(what, "0000"), "odd")
        if not db.exists():
            continue
        now = every_row(db)
        assert all(rows <= now[table] for table, rows in before.items())
        assert {row[0] for row in now["entries"]} == set(ids.values())
        assert len(now["files"]) == len(ids) == len(set(ids.values()))
        assert {row[0] for row in now["withdrawn"]} == {ids[name] for name in gone}
        assert {row[:2] for row in now["derived_from"]} == {
            (ids[result], ids[pull])
            for result, cited in CITES.items()
            for pull in cited
            if result in ids and pull in ids
        }
        before = now
    db.unlink(missing_ok=True)
