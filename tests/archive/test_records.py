"""`records`: what goes in, what it is linked with, what is refused, what is found changed."""

from __future__ import annotations

import contextlib
import io
import json
import sqlite3
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from archive.samples import BRAKE, LINE, pull_file, run_file
from lab import bench as virtual
from layerjam.archive import move, schema
from layerjam.archive.contents import CALIBRATED
from layerjam.archive.move import RecordsError
from layerjam.cli.main import main
from layerjam.device.file import updated_text
from layerjam.errors import MissingExtraError
from layerjam.identify.provenance import digests, sha256
from layerjam.identify.shape import with_shape
from layerjam.measure.sidecar import Facts, write_facts
from strategies import KAPTON


def tables(db: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Every row of every table, as a stranger reads it."""
    with contextlib.closing(sqlite3.connect(db)) as base:
        names = [n for (n,) in base.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        assert base.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert base.execute("PRAGMA foreign_key_check").fetchall() == []
        return {name: sorted(base.execute(f"SELECT * FROM {name}"), key=repr) for name in names}


def said(*words: object) -> tuple[int, dict[str, Any]]:
    """Exit code and JSON of a command."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = main(["records", *map(str, words), "--json"])
    return code, json.loads(out.getvalue()) if out.getvalue() else {}


PULLS = ("pull-1.csv", "pull-2.csv")


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two synthetic pulls, a brake and the JSON that name them as `calibrate` does."""
    folder = tmp_path_factory.mktemp("calibrated")
    for number, name in enumerate(PULLS):
        pull_file(folder / name, 40 + number, synthetic=True)
    write_facts(folder / PULLS[0], Facts(vacuum=6e4, synthetic=True))
    (folder / "my.toml").write_text(BRAKE.text, encoding="utf-8")
    files = digests([str(folder / name) for name in PULLS], [str(folder / PULLS[1])])
    made_by = {"program": "layerjam 1 calibrate", "depth": "exact", "files": files}
    text = updated_text(BRAKE, "fitted", {}, made_by)
    (folder / "fitted.toml").write_text(text, encoding="utf-8")
    made_from = {"brake": {"name": BRAKE.name, "sha256": BRAKE.sha256}, "files": files}
    result = dict.fromkeys(CALIBRATED, 0.0) | {"depth": "exact", "made_from": made_from}
    (folder / "fitted.json").write_text(json.dumps(result), encoding="utf-8")
    return folder


@pytest.mark.slow
def test_what_calibrate_writes_is_linked(tmp_path: Path) -> None:
    """The command's own brake and JSON, with nothing handmade in between."""
    for number, (name, size) in enumerate(zip(PULLS, (0.9, 0.92), strict=True), 1):
        brake = with_shape(KAPTON, *(np.array([size, 12e4, 1.2])))
        virtual.write_own(virtual.pull(brake, 60e3, 0.013, 0.04, repeat=number), tmp_path / name)
    (tmp_path / "my.toml").write_text(BRAKE.text, encoding="utf-8")
    pulls = [tmp_path / name for name in PULLS]
    result = lj.calibrate(tmp_path / "my.toml", pulls, out=tmp_path / "fitted.toml")
    result.save(tmp_path / "fitted.json")
    given = sorted(path for path in tmp_path.iterdir())
    added = lj.records_add(given, db=tmp_path / "lab.db")
    assert not added.refused and not added.warnings and len(added.ids) == len(given)
    for name in ("fitted", "fitted.json"):
        made = lj.records_show(added.ids.get(str(tmp_path / name), name), db=tmp_path / "lab.db")
        known = {row["name"] for row in made.derived_from}
        assert known >= {*PULLS, "pull-1.csv.toml", BRAKE.name}
        assert made.record_["simulated"] and not made.unlinked


@pytest.mark.slow
def test_a_run_of_the_virtual_bench_is_linked_and_marked(tmp_path: Path) -> None:
    """What `bench run` and `bench export` write, with nothing handmade in between."""
    run, table = tmp_path / "first.ljrun", tmp_path / "first.csv"
    lj.bench_run(
        "sim:choi2018?speed=0",
        procedure="evacuate to 40 kPa and hold 1 s; vent",
        brake="choi2018-kapton",
        line="choi2018",
        vent_rest="open",
        settings={"safe_state": "release", "sensor_range": "103 kPa"},
        out=run,
    )
    lj.bench_export(run, out=table)
    given = [table, run, Path(f"{table}.toml")]
    added = lj.records_add(given, db=tmp_path / "lab.db")
    assert len(added.ids) == 3 and not added.refused and not added.warnings
    assert all(row["simulated"] for row in lj.records_list(db=tmp_path / "lab.db").rows_
               if row["name"].startswith("first"))  # fmt: skip
    made = lj.records_show("first.csv", db=tmp_path / "lab.db")
    assert [row["name"] for row in made.derived_from][:1] == ["first.ljrun"]
    assert {row["kind"] for row in made.derived_from} >= {"run", "brake", "line", "board"}
    record = lj.records_show("first.ljrun", db=tmp_path / "lab.db").record_
    base = sqlite3.connect(run)
    (samples,) = base.execute("SELECT count(*) FROM samples").fetchone()
    base.close()
    assert record["samples"] == samples > 100 and record["gaps"] == 0
    assert record["outcome"] == "FINISHED" and record["safe_state"] == "release"
    # the brake of the catalogue, added as a file, is the one of the run
    (tmp_path / "kapton.toml").write_text(BRAKE.text, encoding="utf-8")
    (ident,) = lj.records_add(tmp_path / "kapton.toml", db=tmp_path / "lab.db").ids.values()
    assert "first.ljrun" in {
        row["name"] for row in lj.records_show(ident, db=tmp_path / "lab.db").used_by
    }


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


def test_a_calibration_is_linked_by_digests_in_any_order(calibrated: Path, tmp_path: Path) -> None:
    """The brake first, its sources after it; and the other way round: the same links."""
    sources = [calibrated / n for n in ("my.toml", "pull-1.csv", "pull-1.csv.toml", "pull-2.csv")]
    results = [calibrated / "fitted.toml", calibrated / "fitted.json"]
    links = []
    for number, order in enumerate(([*sources, *results], [*results, *sources])):
        db = tmp_path / f"{number}.db"
        for path in order:
            assert said("add", path, "--db", db)[0] == 0
        rows = {row["id"]: row for row in said("list", "--db", db)[1]["rows"]}
        found = tables(db)["derived_from"]
        links.append({(rows[c]["kind"], rows[c]["name"], r, rows[p]["name"]) for c, p, r in found})
        assert all(row["simulated"] for row in rows.values() if row["kind"] == "calibration")
        assert rows[next(i for i in rows if rows[i]["name"] == "fitted")]["simulated"]
        assert not next(row for row in rows.values() if row["name"] == BRAKE.name)["simulated"]
    exact = "calibrate exact"
    assert links[0] == links[1] == {
        ("brake", "fitted", "calibration", exact),
        ("calibration", exact, "start", BRAKE.name),
        ("calibration", exact, "measured", "pull-1.csv"),
        ("calibration", exact, "measured", "pull-2.csv"),
        ("calibration", exact, "conditions", "pull-1.csv.toml"),
    }  # fmt: skip
    made = lj.records_show("fitted", db=tmp_path / "0.db")
    assert {row["name"] for row in made.derived_from} == {
        exact, BRAKE.name, "pull-1.csv", "pull-2.csv", "pull-1.csv.toml"
    }  # fmt: skip


def test_what_cannot_be_linked_is_said(calibrated: Path, tmp_path: Path) -> None:
    made = lj.records_add([calibrated / "fitted.toml"], db=tmp_path / "lab.db")
    unlinked = [w for w in made.warnings if w.key == "not-linked"]
    assert len(unlinked) == 4 and all("not in the records" in w for w in unlinked)
    shown = lj.records_show(next(iter(made.also_added)), db=tmp_path / "lab.db")
    assert {row["role"] for row in shown.unlinked} == {"start", "measured", "conditions"}
    old = json.loads((calibrated / "fitted.json").read_text(encoding="utf-8"))
    del old["made_from"]
    (tmp_path / "old.json").write_text(json.dumps(old), encoding="utf-8")
    made = lj.records_add([tmp_path / "old.json"], db=tmp_path / "lab.db")
    assert ["cannot be linked" in w for w in made.warnings] == [True]


def test_a_run_brings_its_brake_line_board_and_sensor(tmp_path: Path) -> None:
    db, first = tmp_path / "lab.db", run_file(tmp_path / "a.ljrun", lost=3)
    other = run_file(tmp_path / "b.ljrun", run_id="other", outcome="", simulated="1")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.ljrun", "b.ljrun"]
    added = lj.records_add([first, other], db=db)
    assert len(added.ids) == 2 and len(added.also_added) == 4 and not added.refused
    rows = {row["name"]: row for row in lj.records_list(db=db).rows_}
    assert {row["kind"] for row in rows.values()} == {
        "brake", "line", "board", "sensor calibration", "run"
    }  # fmt: skip
    shown = lj.records_show("a.ljrun", db=db)
    record = shown.record_
    assert (record["samples"], record["gaps"], record["simulated"]) == (17, 3, False)
    assert record["outcome"] == "FINISHED" and record["procedure"] == "evacuate to 40 kPa; vent"
    assert record["brake"] == rows[BRAKE.name]["id"] and record["line"] == rows[LINE.name]["id"]
    assert {row["role"] for row in shown.derived_from} == {
        "brake", "line", "board", "sensor calibration"
    }  # fmt: skip
    sensor = lj.records_show('12.5,1.01,"2026-03"', db=db).record_
    assert (sensor["zero"], sensor["gain"]) == (12.5, 1.01)
    assert (
        rows["b.ljrun"]["simulated"]
        and lj.records_show("b.ljrun", db=db).record_["outcome"] is None
    )
    # the same brake as a file of its own is the same record, and an export is one of its run
    (tmp_path / "own.toml").write_text(BRAKE.rendered(BRAKE.name), encoding="utf-8")
    assert lj.records_add(tmp_path / "own.toml", db=db).ids == {
        str(tmp_path / "own.toml"): rows[BRAKE.name]["id"]
    }
    export = pull_file(tmp_path / "b.csv")
    export.write_text("# layerjam 1 bench export\n# run_id: other\n" + export.read_text())
    lj.records_add(export, db=db)
    made = lj.records_show("b.csv", db=db)
    assert made.record_["kind"] == "export" and made.record_["simulated"]
    assert made.derived_from[0]["name"] == "b.ljrun" and made.derived_from[0]["role"] == "run"


def test_a_run_that_is_not_whole_is_refused(tmp_path: Path) -> None:
    path = run_file(tmp_path / "a.ljrun")
    Path(f"{path}-wal").write_bytes(b"rows that only the log holds")
    other = tmp_path / "other.ljrun"
    with contextlib.closing(sqlite3.connect(other)) as base:
        base.execute("CREATE TABLE t (x)")
    made = lj.records_add([path, other], db=tmp_path / "lab.db")
    assert "is not closed" in made.refused[str(path)] and "no run" in made.refused[str(other)]
    assert not (tmp_path / "lab.db").exists()
    Path(f"{path}-wal").unlink()
    assert lj.records_add(path, db=tmp_path / "lab.db").ids
    later = run_file(tmp_path / "later.ljrun", note="the same run, resumed")
    why = lj.records_add(later, db=tmp_path / "lab.db").refused[str(later)]
    assert "another state" in why
    lj.records_withdraw("a.ljrun", why="resumed", db=tmp_path / "lab.db")
    assert lj.records_add(later, db=tmp_path / "lab.db").ids


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
    assert sum(map(len, tables(tmp_path / "lab.db").values())) == 3  # version, entry, file


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

    from layerjam.archive.database import Database

    lj.records_add(pull_file(tmp_path / "p.csv"), db=tmp_path / "lab.db")
    database = Database(tmp_path / "lab.db")
    orphan = schema.WITHDRAWN.insert().values(id="none", when="", why="x", by="")
    with pytest.raises(RecordsError, match="FOREIGN KEY"), database.writing() as db:
        db.execute(orphan)
    with pytest.raises((RecordsError, IntegrityError), match="UNIQUE"), database.writing() as db:
        row = dict(db.execute(schema.FILES.select()).mappings().one())
        db.execute(schema.ENTRIES.insert().values(id="other", kind="data"))
        db.execute(schema.FILES.insert().values(**{**row, "id": "other"}))
    assert len(lj.records_list(db=tmp_path / "lab.db").rows_) == 1


def test_nothing_is_half_added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure in the middle of the last file takes back the first ones too."""
    from layerjam.archive import store

    db = tmp_path / "lab.db"
    lj.records_add(pull_file(tmp_path / "first.csv", 1), db=db)
    before, calls = tables(db), iter(range(100))

    def cut() -> str:
        if next(calls) == 3:
            raise KeyboardInterrupt
        return "somebody"

    monkeypatch.setattr(store, "user", cut)
    more = [pull_file(tmp_path / f"{n}.csv", n + 2) for n in range(5)]
    with pytest.raises(KeyboardInterrupt):
        lj.records_add(more, db=db)
    assert tables(db) == before


@pytest.mark.parametrize(("found", "known", "why"), [(2, 1, "update layerjam"),
                                                     (1, 3, "no step leads")])  # fmt: skip
def test_other_versions_are_refused(
    found: int, known: int, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    db, pull = tmp_path / "lab.db", pull_file(tmp_path / "p.csv")
    monkeypatch.setattr(move, "VERSION", found)
    lj.records_add(pull, db=db)
    before = tables(db)
    monkeypatch.setattr(move, "VERSION", known)
    for call in (lj.records_list, partial(lj.records_add, pull)):
        with pytest.raises(RecordsError, match=why):
            call(db=db)
    assert tables(db) == before and before["schema_version"][0][0] == found


def test_an_older_version_is_brought_up_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sqlalchemy import text

    from layerjam.archive import database

    db = tmp_path / "lab.db"
    lj.records_add(pull_file(tmp_path / "p.csv"), db=db)
    steps = {1: lambda base: base.execute(text("CREATE TABLE new (x TEXT)"))}
    monkeypatch.setattr(move, "STEPS", steps)
    for module in (move, database):
        monkeypatch.setattr(module, "VERSION", 2)
    for _ in range(2):
        assert len(lj.records_list(db=db).rows_) == 1
    found = tables(db)
    assert found["new"] == [] and [row[0] for row in found["schema_version"]] == [1, 2]


def test_other_databases_are_left_alone(tmp_path: Path) -> None:
    run = run_file(tmp_path / "a.ljrun")
    before = run.read_bytes()
    pull = pull_file(tmp_path / "p.csv")
    (tmp_path / "text.db").write_text("no database at all, but long enough to be looked at" * 30)
    for db, why in (
        (run, "holds other tables"),
        (tmp_path / "text.db", "the database says"),
        ("mysql://me:secret@host/x", "cannot be used"),
        ("sqlite://", "cannot be used"),
        ("://", "no URL"),
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
    path.write_text(BRAKE.text, encoding="utf-8")
    with pytest.raises(RecordsError, match="serial"):
        lj.records_add([path, pull], serial="LJ-1", db=tmp_path / "lab.db")
    made = lj.records_add(pull, serial="LJ-1", db=tmp_path / "lab.db")
    assert "no brake" in made.refused[str(pull)] and not made.ids
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
    with pytest.raises(MissingExtraError, match=rf"layerjam\[{extra}\]"):
        lj.records_list(db=db)
