"""`bench run --shot`: drops on the virtual rig, in the run's file, and what is read of them."""

from __future__ import annotations

import contextlib
import io
import json
import sqlite3
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from layerjam.bench.commands.bench_run import DropRigOptions
from layerjam.bench.rig.shots import DropRig, Shots, check_rig
from layerjam.brake.device.load import load
from layerjam.brake.simulate.drop import drop
from layerjam.brake.simulate.procedure import parse_procedure
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from layerjam.laboratory.measure.runs import read_run
from layerjam.laboratory.measure.shots import PIECE, Shot, find_shot

RUN = [
    "bench", "run", "sim:choi2018?speed=0", "--brake", "choi2018-kapton", "--line", "choi2018",
    "--safe-state", "release", "--vent-rest", "open", "--sensor-range", "103kPa", "--json",
]  # fmt: skip
DROP = ["--shot", "--mass", "1kg", "--speed", "2.5m/s"]
PROCEDURE = "evacuate to 80 kPa and hold 2 s; hold 2 s; vent"
SPEED, GRAVITY = 2.5, 9.80665


def said(words: list[str], code: int = 0) -> dict[str, Any]:
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        assert main(words) == code
    made: dict[str, Any] = json.loads(text.getvalue())
    return made


@pytest.fixture(scope="module")
def answered(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A run of two drops."""
    out = tmp_path_factory.mktemp("drop") / "a.ljrun"
    return said([*RUN, *DROP, "--procedure", PROCEDURE, "--out", str(out)])


@pytest.mark.slow
def test_each_hold_has_its_drop(answered: dict[str, Any]) -> None:
    """Two whole records, triggered within their holds, at the vacuum that was held."""
    first, second = answered["shots"]
    assert answered["outcome"] == "FINISHED" and answered["gaps"] == 0
    run = read_run(answered["file"])
    time, vacuum = run.columns["time"], run.columns["vacuum"]
    for step, shot, kept in zip(answered["steps"], (first, second), run.shots, strict=False):
        assert shot["whole"] and shot["samples"] == 4800 and shot["rate"] == 8000
        assert step["started"] < shot["time"] < step["ended"] - 0.5
        assert run.trigger_time(kept) == pytest.approx(shot["time"], abs=1e-9)
        assert kept.number == shot["shot"] and kept.boot == run.boots[0] and kept.synthetic
        stop = (time > shot["time"] - 0.1) & (time < shot["time"] + 0.5)
        assert stop.sum() >= 59 and np.abs(vacuum[stop] - 80e3).max() < 800
    assert run.meta["drop_mass"] == "1 kg" and run.meta["drop_speed"] == "2.5 m/s"
    assert run.meta["brake"] == "choi2018-kapton"


@pytest.mark.slow
def test_the_record_holds_the_stop(answered: dict[str, Any]) -> None:
    """In the fall it reads nothing; what it reads then takes the mass's speed in `drop`'s time.

    The speed is that of the fall less the integral of F/M - g, from the taut brake on.
    """
    due = drop(load("choi2018-kapton"), mass=1.0, speed=SPEED, vacuum=80e3)[0]
    for shot in read_run(answered["file"]).shots:
        time, force = shot.time, shot.acceleration
        fallen = (time > -0.09) & (time < -0.02)
        assert abs(force[fallen].mean()) < 0.3
        taut = int(np.argmax(force > GRAVITY))
        speed = SPEED - np.cumsum(force[taut:] - GRAVITY) / shot.rate
        still = np.argmax(speed < 0.0) / shot.rate
        assert still == pytest.approx(due.time, rel=0.04)
        assert force.max() == pytest.approx(due.peak_force, rel=0.06)


@pytest.mark.slow
def test_strangers_read_the_shots(answered: dict[str, Any]) -> None:
    """By SQLite, JSON and NumPy alone."""
    with contextlib.closing(sqlite3.connect(answered["file"])) as base:
        for number in (1, 2):
            row = "SELECT rate, scale, trigger_us, pre, samples FROM shots WHERE shot = ?"
            rate, scale, trigger, before, size = base.execute(row, (number,)).fetchone()
            data = base.execute(
                "SELECT data FROM shot_data WHERE shot = ? ORDER BY first", (number,)
            ).fetchall()
            counts = np.frombuffer(b"".join(part for (part,) in data), "<i2")
            zero, gain = (json.loads(scale)[key] for key in ("zero", "gain"))
            assert (len(counts), rate, before) == (size, 8000.0, 800)
            first, last = base.execute(
                "SELECT min(board_us), max(board_us) FROM samples"
            ).fetchone()
            assert first < trigger < last
            peak = (counts.max() - zero) * gain
            assert peak == pytest.approx(149.0, rel=0.1)


@pytest.mark.slow
def test_crash_reads_the_run_as_it_reads_the_export(
    answered: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = answered["file"], tmp_path / "a.csv"
    made = said(["bench", "export", path, "--out", str(out), "--json"])
    files = [str(tmp_path / f"a-shot{number}.csv") for number in (1, 2)]
    assert made["shots"] == files
    for number, file in enumerate(files, 1):
        own = said(["crash", path, "--shot", str(number), "--falling", "--json"])
        other = said(["crash", file, "--range", "250 g", "--falling", "--json"])
        for key in ("peak", "filtered_peak", "velocity_change", "offset"):
            assert own[key] == pytest.approx(other[key], rel=1e-5, abs=1e-5)
        assert (own["sampling"], own["samples"]) == (8000, 4800)
        for made in (own, other):
            assert any("synthetic" in text for text in made["warnings"])
    capsys.readouterr()
    for more, why in (
        ([], "shots 1, 2"),
        (["--shot", "3"], "no shot 3"),
        (["--shot", "1", "--sampling", "8kHz"], "sampling"),
        (["--shot", "1", "--decimal", "."], "decimal"),
    ):
        assert main(["crash", path, *more]) == 2
        assert why in capsys.readouterr().err
    assert main(["crash", files[0], "--shot", "1"]) == 2
    assert "contains shots" in capsys.readouterr().err
    # an export is not half replaced
    assert main(["bench", "export", path, "--out", str(tmp_path / "b.csv")]) == 0
    (tmp_path / "b.csv").unlink(), (tmp_path / "b.csv.toml").unlink()
    assert main(["bench", "export", path, "--out", str(tmp_path / "b.csv")]) == 2
    assert not (tmp_path / "b.csv").exists()


@pytest.mark.slow
def test_other_exports_hold_the_shots(answered: dict[str, Any], tmp_path: Path) -> None:
    from scipy.io import netcdf_file

    run = read_run(answered["file"])
    out = tmp_path / "a.nc"
    said(["bench", "export", answered["file"], "--out", str(out), "--json"])
    with netcdf_file(out, mmap=False) as file:
        for shot in run.shots:
            there = file.variables[f"shot{shot.number}_acceleration"]
            assert there.units == b"m/s^2" and np.array_equal(there[:], shot.acceleration)
    parquet = pytest.importorskip("pyarrow.parquet")
    made = said(
        ["bench", "export", answered["file"], "--out", str(tmp_path / "a.parquet"),
         "--from", "0 s", "--to", f"{answered['steps'][0]['ended']} s", "--json"]
    )  # fmt: skip
    assert made["shots"] == [str(tmp_path / "a-shot1.parquet")]
    table = parquet.read_table(made["shots"][0])
    assert np.array_equal(table["acceleration"].to_numpy(), run.shots[0].acceleration)
    assert table.schema.metadata[b"simulated"] == b"1"


def made_shot(counts: int = 2500, **other: Any) -> Shot:
    values = {
        "counts": np.arange(counts, dtype="<i2"), "size": counts, "rate": 8000.0, "zero": 2068.7,
        "gain": -0.1, "range": 2451.6625, "before": 80, "trigger_us": (1 << 33) + 5,
        "synthetic": False, "number": 3, "boot": 7,
    }  # fmt: skip
    return Shot(**{**values, **other})


def test_rows_give_the_shot_back() -> None:
    shot = made_shot()
    again = Shot.from_rows(shot.row(), shot.parts()[::-1], synthetic=False)
    assert np.array_equal(again.counts, shot.counts)
    assert (again.row(), again.parts()) == (shot.row(), shot.parts())
    # a part that is missing ends it there
    cut = Shot.from_rows(shot.row(), [shot.parts()[0], shot.parts()[2]], synthetic=False)
    assert len(cut.counts) == PIECE and cut.size == 2500


def test_the_shot_that_is_meant() -> None:
    one, two = made_shot(), made_shot(number=4)
    assert find_shot((one,), None, "a") is one and find_shot((one, two), 4, "a") is two


def test_a_killed_run_keeps_what_came_of_a_shot(tmp_path: Path) -> None:
    from layerjam.bench.rig.run_file import RunFile

    path, shot = tmp_path / "a.ljrun", made_shot(synthetic=True)
    file = RunFile.create(path, {"simulated": 1})
    file.add_shot(shot.row())
    first, _, data = shot.parts()[0]
    file.add_shot_data(shot.number, first, data)
    file.close()  # as a killed one leaves it
    (kept,) = read_run(path).shots
    assert np.array_equal(kept.counts, shot.counts[:PIECE])
    made = said(["crash", str(path), "--filter", "none", "--before", "50ms", "--json"], 4)
    assert [check["name"] for check in made["failed_checks"]] == ["whole pulse"]
    assert made["samples"] == PIECE
    assert any("1000 of the record's 2500" in text for text in made["warnings"])


def test_what_cannot_be_dropped_is_refused() -> None:
    bench: Any = SimpleNamespace(plant=object(), address="sim:choi2018")
    held = "evacuate to 80 kPa and hold 2 s"
    whole = {"file": load("choi2018-kapton"), "mass": 1.0, "speed": 2.5}
    check_rig(DropRig(**whole), bench, parse_procedure(held))
    for stated, procedure, why in (
        (whole, "evacuate to 80 kPa; vent", "hold 20 s"),
        (whole, "evacuate to 80 kPa and hold 1.2 s", "too short"),
        ({**whole, "mass": None}, held, "--mass"),
        ({**whole, "speed": None}, held, "--speed"),
        ({**whole, "speed": -1.0}, held, "speed"),
        (whole, f"{held}; pull at 1 mm/s until 2 mm", "drop rig"),
    ):
        with pytest.raises(QuantityError, match=why):
            check_rig(DropRig(**stated), bench, parse_procedure(procedure))
    # at a real bench a person says what fell, or nothing
    real: Any = SimpleNamespace(plant=None)
    check_rig(DropRig(), real, parse_procedure(held))
    for options in ({"mass": 1.0}, {"trigger_level": 3.0}):
        with pytest.raises(QuantityError, match="add --shot"):
            DropRigOptions(**options).make_rig(whole["file"])


@pytest.mark.slow
def test_a_refused_run_leaves_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["--out", str(tmp_path / "a.ljrun"), "--procedure", "hold 2 s"]
    assert main([*RUN, *DROP, "--trigger-level", "0.1", *out]) == 2
    assert "trigger level" in capsys.readouterr().err
    assert main([*RUN, "--shot", *out]) == 2
    assert "--mass" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_nothing_falls_and_it_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run finishes, the accelerometer waits no more, and no shot is in the file."""
    monkeypatch.setattr(Shots, "release_mass", lambda self: None)
    words = [*DROP, "--procedure", "hold 2 s", "--out", str(tmp_path / "a.ljrun")]
    made = said([*RUN, *words])
    assert made["outcome"] == "FINISHED" and made["shots"] == []
    assert any("no fall was detected" in text for text in made["warnings"])
