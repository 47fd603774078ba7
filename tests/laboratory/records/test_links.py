"""What a record comes from is found from the digests in it; a run brings what is inside it."""

from __future__ import annotations

import contextlib
import json
import sqlite3
from pathlib import Path

import numpy as np
import pytest

import layerjam as lj
from laboratory.campaigns import bench as virtual
from laboratory.records.samples import BRAKE, LINE, pull_file, run_file, said, tables
from layerjam.brake.device.brake_file import updated_text
from layerjam.laboratory.identify.provenance import digest_files
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.measure.sidecar import Facts, write_facts
from layerjam.laboratory.records.contents import CALIBRATED
from strategies import KAPTON

PULLS = ("pull-1.csv", "pull-2.csv")
COVARIANCE = {
    "scale_factor": {"scale_factor": 1e-4, "stiffness": -12.5},
    "stiffness": {"scale_factor": -12.5, "stiffness": 4e6},
}


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two synthetic pulls, a brake and the JSON that name them as `calibrate` does."""
    folder = tmp_path_factory.mktemp("calibrated")
    for number, name in enumerate(PULLS):
        pull_file(folder / name, 40 + number, synthetic=True)
    write_facts(folder / PULLS[0], Facts(vacuum=6e4, synthetic=True))
    (folder / "my.toml").write_bytes(BRAKE.text.encode())
    files = digest_files([str(folder / name) for name in PULLS], [str(folder / PULLS[1])])
    made_by = {"program": "layerjam 1 calibrate", "depth": "exact", "files": files}
    pairs = (("scale_factor", "scale_factor"), ("scale_factor", "stiffness"),
             ("stiffness", "stiffness"))  # fmt: skip
    made_by["covariance"] = [{"of": a, "and": b, "value": COVARIANCE[a][b]} for a, b in pairs]
    text = updated_text(BRAKE, "fitted", {}, made_by)
    (folder / "fitted.toml").write_text(text, encoding="utf-8")
    made_from = {"brake": {"name": BRAKE.name, "sha256": BRAKE.sha256}, "files": files}
    result = dict.fromkeys(CALIBRATED, 0.0) | {"depth": "exact", "made_from": made_from}
    result["covariance"] = COVARIANCE
    (folder / "fitted.json").write_text(json.dumps(result), encoding="utf-8")
    return folder


@pytest.mark.slow
def test_what_calibrate_writes_is_linked(tmp_path: Path) -> None:
    """The command's own brake and JSON, with nothing handmade in between."""
    for number, (name, size) in enumerate(zip(PULLS, (0.9, 0.92), strict=True), 1):
        brake = change_shape(KAPTON, *(np.array([size, 12e4, 1.2])))
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
    assert [row["name"] for row in made.derived_from][:2] == ["first.csv.toml", "first.ljrun"]
    kinds = {row["kind"] for row in made.derived_from}
    assert kinds == {"run", "brake", "line", "board", "facts"}  # its sensor was never calibrated
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
        ("data", "pull-1.csv", "conditions", "pull-1.csv.toml"),
    }  # fmt: skip
    made = lj.records_show("fitted", db=tmp_path / "0.db")
    assert {row["name"] for row in made.derived_from} == {
        exact, BRAKE.name, "pull-1.csv", "pull-2.csv", "pull-1.csv.toml"
    }  # fmt: skip


def test_the_covariance_of_a_calibration_is_kept(calibrated: Path, tmp_path: Path) -> None:
    db = tmp_path / "lab.db"
    added = lj.records_add([calibrated / n for n in ("fitted.toml", "fitted.json")], db=db)
    in_brake = next(iter(added.also_added))
    for ident in (in_brake, added.ids[str(calibrated / "fitted.json")]):
        assert lj.records_show(ident, db=db).record_["covariance"] == COVARIANCE


@pytest.mark.parametrize("facts", ["pull-9.csv.toml", "conditions.toml"])
def test_a_measurement_is_linked_to_what_stands_beside_it(tmp_path: Path, facts: str) -> None:
    """In any order; also when the facts were written after it, if it is still the same file."""
    pull, beside = pull_file(tmp_path / "pull-9.csv"), tmp_path / facts
    other = pull_file(tmp_path / "pull-8.csv", 50)
    told = "vacuum = '60 kPa'\n"
    linked = {"pull-9.csv", "pull-8.csv"} if facts == "conditions.toml" else {"pull-9.csv"}
    beside.write_text(told)
    for n, order in enumerate(([pull, other, beside], [beside, other, pull])):
        for path in order:
            lj.records_add(path, db=tmp_path / f"{n}.db")
    beside.unlink()
    for path in (pull, other):
        assert not lj.records_add(path, db=tmp_path / "2.db").warnings
    beside.write_text(told)
    for _ in range(2):  # the second is refused
        lj.records_add(beside, db=tmp_path / "2.db")
    for n in range(3):
        shown = lj.records_show(facts, db=tmp_path / f"{n}.db")
        assert {row["name"] for row in shown.used_by} == linked
        assert {row["role"] for row in shown.used_by} == {"conditions"} and not shown.derived_from
    beside.unlink()
    lj.records_add(pull, db=tmp_path / "3.db")
    pull.write_text(pull.read_text().replace("40", "41"))
    beside.write_text(told)
    lj.records_add(beside, db=tmp_path / "3.db")
    assert not lj.records_show(facts, db=tmp_path / "3.db").used_by


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
    (tmp_path / "own.toml").write_bytes(BRAKE.render(BRAKE.name).encode())
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
    assert "is not closed" in made.refused[str(path)] and "bench run" in made.refused[str(other)]
    assert not (tmp_path / "lab.db").exists()
    Path(f"{path}-wal").unlink()
    assert lj.records_add(path, db=tmp_path / "lab.db").ids
    later = run_file(tmp_path / "later.ljrun", note="the same run, resumed")
    why = lj.records_add(later, db=tmp_path / "lab.db").refused[str(later)]
    assert "a different state" in why
    lj.records_withdraw("a.ljrun", why="resumed", db=tmp_path / "lab.db")
    assert lj.records_add(later, db=tmp_path / "lab.db").ids
