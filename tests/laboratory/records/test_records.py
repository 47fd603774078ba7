"""`records`: what goes in, what is refused, what is found changed, what is never changed."""

from __future__ import annotations

import contextlib
import json
import sqlite3
import sys
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import layerjam as lj
from laboratory.records.samples import BRAKE, pull_file, run_file, said, tables
from layerjam.core.errors import MissingExtraError
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.records import database, schema
from layerjam.laboratory.records.contents import CALIBRATED
from layerjam.laboratory.records.database import Database, RecordsError


def test_add_list_show_as_the_contract_names_them(tmp_path: Path) -> None:
    db, pull = tmp_path / "lab.db", pull_file(tmp_path / "p.csv")
    code, made = said("add", pull, "--db", db)
    assert code == 0 and set(made["ids"]) == {str(pull)} and made["refused"] == {}
    (ident,) = made["ids"].values()
    code, again = said("add", pull, "--db", db)
    assert code == 3 and again["ids"] == {} and ident in again["refused"][str(pull)]
    (row,) = said("list", "--db", db)[1]["rows"]
    assert (row["id"], row["kind"], row["name"]) == (ident, "data", "p.csv")
    for name in (ident, ident[:8], "p.csv"):
        record = said("show", name, "--db", db)[1]["record"]
        assert record["sha256"] == sha256(str(pull)) and record["folder"] == str(tmp_path)
    with contextlib.closing(sqlite3.connect(db)) as base:
        found = base.execute("SELECT made_at, software, sha256, bytes FROM files").fetchall()
    assert found == [
        (row["made_at"], f"layerjam {lj.__version__}", sha256(str(pull)), pull.stat().st_size)
    ]
    assert row["made_at"].endswith("Z") and row["made_at"][10] == "T"


BAD = {
    "none.csv": None,
    "empty.csv": b"",
    "odd.toml": b"x = 1\n",
    "broken.toml": b"[sheets\n",
    "half.toml": b'name = "x"\n[sheets]\ncount = 3\n',
    "odd.json": b'{"x": 1}',
    "broken.json": b"{",
    "text.ljrun": b"no database",
    "cut.ljrun": b"SQLite format 3\0 cut off",
}


@pytest.mark.parametrize("name", BAD)
def test_what_the_records_do_not_take(name: str, tmp_path: Path) -> None:
    data = BAD[name]
    if data is not None:
        (tmp_path / name).write_bytes(data)
    good = pull_file(tmp_path / "good.csv")
    code, made = said("add", tmp_path / name, good, "--db", tmp_path / "lab.db")
    assert code == 3 and list(made["refused"]) == [str(tmp_path / name)]
    assert list(made["ids"]) == [str(good)] and "Traceback" not in str(made)
    found = {name: len(rows) for name, rows in tables(tmp_path / "lab.db").items() if rows}
    assert found == {"schema_version": 1, "entries": 1, "files": 1, "keys": 2}


def test_verify_tells_changed_from_missing(tmp_path: Path) -> None:
    db, lab = tmp_path / "lab.db", tmp_path / "lab"
    lab.mkdir()
    names = ("same.csv", "byte.csv", "gone.csv", "moved.csv", "withdrawn.csv")
    paths = {name: pull_file(lab / name, force) for force, name in enumerate(names, 10)}
    run = run_file(lab / "r.ljrun")
    lj.records_add([*paths.values(), run], db=db)
    assert said("verify", "--db", db)[1] == {
        "checked": 8, "changed": [], "missing": [], "units": {}, "warnings": []
    }  # fmt: skip
    lj.records_withdraw("withdrawn.csv", why="wrong brake", db=db)
    data = bytearray(paths["byte.csv"].read_bytes())
    data[-3] ^= 1
    paths["byte.csv"].write_bytes(data)
    (tmp_path / "new").mkdir()
    paths["moved.csv"].rename(tmp_path / "new" / "moved.csv")
    paths["gone.csv"].unlink()
    paths["withdrawn.csv"].unlink()
    code, found = said("verify", tmp_path / "new", "--db", db)
    assert code == 1 and found["checked"] == 7
    assert [row["name"] for row in found["changed"]] == ["byte.csv"]
    assert [row["name"] for row in found["missing"]] == ["gone.csv"]
    assert [row["name"] for row in said("verify", "--db", db)[1]["missing"]] == [
        "gone.csv", "moved.csv"
    ]  # fmt: skip


def test_withdrawn_stays_and_is_not_added_again(tmp_path: Path) -> None:
    db, pull = tmp_path / "lab.db", pull_file(tmp_path / "p.csv")
    (ident,) = lj.records_add(pull, db=db).ids.values()
    before = tables(db)
    made = lj.records_withdraw(ident[:6], why=" the grip slipped ", db=db)
    after = tables(db)
    (gone,) = after.pop("withdrawn")
    assert made.id == gone[0] == ident and gone[2] == "the grip slipped"
    assert {**after, "withdrawn": []} == before
    assert lj.records_list(db=db).rows_[0]["withdrawn"] == "the grip slipped"
    assert "the grip slipped" in lj.records_add(pull, db=db).refused[str(pull)]
    for what, why in ((ident, "twice"), ("0000", "unknown"), (ident, "  ")):
        with pytest.raises(RecordsError):
            lj.records_withdraw(what, why=why, db=db)


@pytest.mark.parametrize("change", ["UPDATE files SET name = 'x'", "DELETE FROM files",
                                    "DELETE FROM schema_version"])  # fmt: skip
def test_the_database_itself_refuses_to_change_a_row(change: str, tmp_path: Path) -> None:
    db = tmp_path / "lab.db"
    lj.records_add(pull_file(tmp_path / "p.csv"), db=db)
    base = sqlite3.connect(db)
    with pytest.raises(sqlite3.IntegrityError, match="never changed"):
        base.execute(change)
    base.close()


def test_foreign_keys_and_digests_are_held_by_the_tables(tmp_path: Path) -> None:
    from sqlalchemy.exc import IntegrityError

    lj.records_add(pull_file(tmp_path / "p.csv"), db=tmp_path / "lab.db")
    base = Database(tmp_path / "lab.db")
    orphan = schema.WITHDRAWN.insert().values(id="none", when="", why="x", by="")
    with pytest.raises(RecordsError, match="FOREIGN KEY"), base.open_transaction() as db:
        db.execute(orphan)
    with base.open_snapshot() as db:
        assert db is not None
        entry = dict(db.execute(schema.ENTRIES.select()).mappings().one()) | {"id": "other"}
        file = dict(db.execute(schema.FILES.select()).mappings().one()) | {"id": "other"}
    with (
        pytest.raises((RecordsError, IntegrityError), match="UNIQUE"),
        base.open_transaction() as db,
    ):
        db.execute(schema.ENTRIES.insert().values(**entry))
    with (
        pytest.raises((RecordsError, IntegrityError), match="UNIQUE"),
        base.open_transaction() as db,
    ):
        db.execute(schema.ENTRIES.insert().values(**entry | {"identity": "data other"}))
        db.execute(schema.FILES.insert().values(**file))
    assert len(lj.records_list(db=tmp_path / "lab.db").rows_) == 1


def test_nothing_is_half_added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure in the middle of the last file takes back the first ones too."""
    from layerjam.laboratory.records import store

    db = tmp_path / "lab.db"
    lj.records_add(pull_file(tmp_path / "first.csv", 1), db=db)
    before, calls = tables(db), iter(range(100))

    def cut() -> str:
        if next(calls) == 3:
            raise KeyboardInterrupt
        return "somebody"

    monkeypatch.setattr(store, "user_name", cut)
    more = [pull_file(tmp_path / f"{n}.csv", n + 2) for n in range(5)]
    with pytest.raises(KeyboardInterrupt):
        lj.records_add(more, db=db)
    assert tables(db) == before


@pytest.mark.parametrize(("found", "known", "why"), [(3, 2, "update layerjam"),
                                                     (2, 4, "cannot be migrated")])  # fmt: skip
def test_other_versions_are_refused(
    found: int, known: int, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    db, pull = tmp_path / "lab.db", pull_file(tmp_path / "p.csv")
    monkeypatch.setattr(database, "VERSION", found)
    lj.records_add(pull, db=db)
    before = tables(db)
    monkeypatch.setattr(database, "VERSION", known)
    for call in (lj.records_list, partial(lj.records_add, pull)):
        with pytest.raises(RecordsError, match=why):
            call(db=db)
    assert tables(db) == before and before["schema_version"][0][0] == found


def test_an_older_version_is_brought_up_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sqlalchemy import text

    db = tmp_path / "lab.db"
    lj.records_add(pull_file(tmp_path / "p.csv"), db=db)
    steps = {2: lambda base: base.execute(text("CREATE TABLE new (x TEXT)"))}
    monkeypatch.setattr(database, "STEPS", steps)
    monkeypatch.setattr(database, "VERSION", 3)
    for _ in range(2):
        assert len(lj.records_list(db=db).rows_) == 1
    found = tables(db)
    assert found["new"] == [] and [row[0] for row in found["schema_version"]] == [2, 3]


def test_the_tables_of_version_1_become_views(tmp_path: Path) -> None:
    """A database that the program of version 1 wrote: each of its rows is found as it was."""
    db = tmp_path / "lab.db"
    text = Path(__file__).with_name("version-1.sql").read_text(encoding="utf-8")
    with contextlib.closing(sqlite3.connect(db)) as base:
        base.executescript(text)
        listed = "SELECT name FROM sqlite_master WHERE type = 'table'"
        names = [name for (name,) in base.execute(listed)]
        before = {name: _by_column(base, name) for name in names}
    assert {name: len(rows) for name, rows in before.items()} == {
        "schema_version": 1, "entries": 14, "brakes": 3, "lines": 1, "boards": 1, "files": 9,
        "sensor_calibrations": 1, "runs": 1, "calibrations": 2, "cited": 13, "withdrawn": 1,
        "derived_from": 16,
    }  # fmt: skip
    rows = {row["name"]: row for row in lj.records_list(db=db).rows_}
    assert len(rows) == 12 and rows["odd.csv"]["withdrawn"] == "the grip slipped"
    assert {name for name, row in rows.items() if row["simulated"]} == {
        "calibrate exact", "fitted", "pull-1.csv", "pull-1.csv.toml", "pull-2.csv"
    }  # fmt: skip
    shown = lj.records_show("r.csv", db=db)
    assert shown.derived_from[0]["name"] == "r.ljrun" and not shown.unlinked
    assert lj.records_verify(db=db).changed == []
    (tmp_path / "same.csv").write_bytes(pull_file(tmp_path / "x.csv", 7).read_bytes())
    assert "withdrawn" in lj.records_add(tmp_path / "same.csv", db=db).refused.popitem()[1]
    with contextlib.closing(sqlite3.connect(db)) as base:
        assert base.execute("PRAGMA foreign_key_check").fetchall() == []
        for name, old in before.items():
            new = _by_column(base, name)
            assert [row for row in old if not any(row.items() <= one.items() for one in new)] == []
            assert len(new) == len(old) + (name == "schema_version") or name == "cited"


def _by_column(base: sqlite3.Connection, table: str) -> list[dict[str, Any]]:
    """The rows of a table or view as {column: value}."""
    cursor = base.execute(f"SELECT * FROM {table}")
    return [dict(zip((c[0] for c in cursor.description), row, strict=True)) for row in cursor]


def test_other_databases_are_left_alone(tmp_path: Path) -> None:
    run = run_file(tmp_path / "a.ljrun")
    before = run.read_bytes()
    pull = pull_file(tmp_path / "p.csv")
    (tmp_path / "text.db").write_text("no database at all, but long enough to be looked at" * 30)
    for db, why in (
        (run, "contains other tables"),
        (tmp_path / "text.db", "the database reports"),
        ("mysql://me:secret@host/x", "cannot be used"),
        ("sqlite://", "cannot be used"),
        ("://", "not the URL"),
        ("postgresql:/me@host/x", "not the URL"),
    ):
        for call in (lj.records_list, partial(lj.records_add, pull)):
            with pytest.raises(RecordsError, match=why) as caught:
                call(db=db)
            assert "secret" not in str(caught.value)
    assert run.read_bytes() == before
    made = lj.records_list(db=tmp_path / "new.db")
    assert made.rows_ == [] and made.warnings[0].key == "no-records"
    assert not (tmp_path / "new.db").exists()


def test_a_serial_number_belongs_to_one_brake(tmp_path: Path) -> None:
    path, pull = tmp_path / "b.toml", pull_file(tmp_path / "p.csv")
    path.write_bytes(BRAKE.text.encode())
    with pytest.raises(RecordsError, match="serial"):
        lj.records_add([path, pull], serial="LJ-1", db=tmp_path / "lab.db")
    made = lj.records_add(pull, serial="LJ-1", db=tmp_path / "lab.db")
    assert "not a brake" in made.refused[str(pull)] and not made.ids
    lj.records_add(path, serial="LJ-1", db=tmp_path / "lab.db")
    assert lj.records_show(BRAKE.name, db=tmp_path / "lab.db").record_["serial"] == "LJ-1"
    # a byte order mark makes other bytes of the same text
    (tmp_path / "marked.toml").write_bytes(b"\xef\xbb\xbf" + BRAKE.text.encode())
    again = lj.records_add(tmp_path / "marked.toml", db=tmp_path / "lab.db")
    assert "b.toml" in again.refused[str(tmp_path / "marked.toml")]


@pytest.mark.parametrize(
    ("missing", "db", "extra"),
    [("sqlalchemy", "lab.db", "records"), ("psycopg", "postgresql://me@host/x", "postgres")],
)
def test_a_missing_extra_is_one_sentence(
    missing: str, db: str, extra: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(MissingExtraError, match=rf"\[{extra}\]"):
        lj.records_list(db=db)


def test_another_machines_file_is_missing_here_not_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from layerjam.laboratory.records import store

    db, pull = tmp_path / "lab.db", pull_file(tmp_path / "p.csv")
    monkeypatch.setattr(store, "node", lambda: "another machine")
    lj.records_add(pull, db=db)
    assert lj.records_verify(db=db).checked == 1 and not lj.records_verify(db=db).missing
    pull_file(pull, force=7.0)
    made = lj.records_verify(db=db)
    assert not made.changed and [row["host"] for row in made.missing] == ["another machine"]


def test_a_text_that_was_changed_in_the_database_is_found(tmp_path: Path) -> None:
    db, path = tmp_path / "lab.db", tmp_path / "b.toml"
    path.write_text(BRAKE.text, encoding="utf-8")
    lj.records_add(path, db=db)
    with contextlib.closing(sqlite3.connect(db)) as base, base:
        base.execute("DROP TRIGGER entries_no_update")
        base.execute("UPDATE entries SET content = json_set(content, '$.toml', 'x = 1')")
    made = lj.records_verify(db=db)
    assert [(row["name"], row["folder"]) for row in made.changed] == [(BRAKE.name, None)]
    assert not made.missing


def test_odd_names_are_kept_or_refused(tmp_path: Path) -> None:
    db, known = tmp_path / "lab.db", pull_file(tmp_path / "µ 'x'; DROP TABLE files --.csv")
    bad = pull_file(tmp_path / "p.csv", 9.0)
    with contextlib.suppress(OSError):  # Wine has no such name
        bad = bad.rename(tmp_path / "\udcff.csv")
    said = dict.fromkeys(CALIBRATED, 0) | {"depth": "\0"}
    said["made_from"] = {"files": [{"name": "\ud800\0", "sha256": "1" * 64}]}
    (tmp_path / "odd.json").write_text(json.dumps(said))
    made = lj.records_add([known, bad, tmp_path / "odd.json"], db=db)
    kept = {str(known), str(tmp_path / "odd.json")}
    if bad.name == "p.csv":
        kept.add(str(bad))
    else:
        assert "UTF-8" in made.refused[str(bad)]
    assert set(made.ids) == kept
    assert lj.records_show(known.name, db=db).record_["name"] == known.name
    assert not lj.records_verify(db=db).missing
