"""`bench run`, `bench log` and `bench export` from end to end, on the virtual board."""

from __future__ import annotations

import contextlib
import io
import json
import math
import sqlite3
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam.bench.rig
from bench.rig.gateways import gateway
from layerjam.bench.commands.bench_run import companion_notice
from layerjam.bench.commands.regulator import RecordedStep, tune_from_step
from layerjam.bench.control.closed_loop import FaultInjection
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.execute import STATES, Execution, ProcedureBench
from layerjam.bench.rig.recorder import Recorder, describe_bench, record_log
from layerjam.bench.rig.run_file import RunFile
from layerjam.bench.rig.settling import measure_scatter
from layerjam.bench.rig.virtual_plant import read_hardware
from layerjam.cli.main import main
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.laboratory.commands.pressure_log import read_pressure
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.runs import read_run
from layerjam.laboratory.measure.sidecar import read_facts

FAST = "sim:choi2018?speed=0"
PROCEDURE = "evacuate to 40 kPa and hold 2 s; vent; hold 1 s"
RUN = ["bench", "run", FAST, "--brake", "choi2018-kapton", "--line", "choi2018", "--safe-state",
       "release", "--vent-rest", "open", "--sensor-range", "103kPa"]  # fmt: skip


def said(words: list[str], capsys: pytest.CaptureFixture[str], code: int = 0) -> dict[str, Any]:
    assert main([*words, "--json"]) == code
    return dict(json.loads(capsys.readouterr().out))


def ready(address: str = FAST, **other: Any) -> ProcedureBench:
    made = read_hardware(address_of(address))
    regulator = {"plant": made.plant, "sensor": made.sensor, "safe_state": "release", **other}
    bench = layerjam.bench.rig.open(address)
    bench.safe_state, bench.vent_rest, bench.regulator = "release", "open", Regulator(**regulator)
    return bench


def record(folder: Path) -> dict[str, Any]:
    """Record a run in a folder; return what it answers."""
    path, text = folder / "a.ljrun", io.StringIO()
    with contextlib.redirect_stdout(text):
        assert main([*RUN, "--procedure", PROCEDURE, "--out", str(path), "--json"]) == 0
    made: dict[str, Any] = json.loads(text.getvalue())
    return made


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a run."""
    return Path(record(tmp_path_factory.mktemp("run"))["file"])


def test_a_run_says_what_was_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = record(tmp_path)  # again in each try, because a busy machine may record too little
    path = Path(made["file"])
    assert (made["outcome"], made["gaps"], made["simulated"]) == ("FINISHED", 0, True)
    assert made["fault"] is None
    evacuate, vent, hold = made["steps"]
    assert all(step["reached"] for step in made["steps"])
    assert evacuate["text"] == "evacuate to 40 kPa and hold 2 s"
    assert evacuate["ended"] == vent["started"] and hold["ended"] - hold["started"] >= 1.0
    run = read_run(path)
    assert run.samples == made["samples"] and run.meta["run_id"] == made["run_id"]
    assert run.meta["outcome"] == "FINISHED" and run.meta["procedure"] == PROCEDURE
    time, vacuum = run.columns["time"], run.columns["vacuum"]
    assert time[0] <= 0 <= evacuate["started"] < 5
    assert np.array_equal(np.diff(run.columns["seq"]), np.ones(run.samples - 1))
    assert time[-1] == pytest.approx(made["duration"])
    # the step begins where the board has the target, and then the pump works
    asked = float(time[run.columns["target"] == 40e3][0])
    assert evacuate["started"] < asked < evacuate["started"] + 2
    assert not vacuum[time <= asked].any() and (vacuum[(time > asked + 0.1) & (time < 5)] > 0).all()
    held = (time > evacuate["ended"] - 2.0) & (time <= evacuate["ended"])
    assert np.abs(vacuum[held] - 40e3).max() < 400
    # the last act: pump off, vent open, for half a second
    state = run.columns["state"]
    after = np.arange(run.samples) > np.flatnonzero(state == 1)[-1]
    assert after.sum() >= 50 and not state[after].any()
    assert not run.columns["pump"][after].any() and (run.columns["flags"][after] & 1).all()
    # an existing run is not overwritten
    assert main([*RUN, "--procedure", PROCEDURE, "--out", str(path)]) == 2
    assert "--overwrite" in capsys.readouterr().err


def test_the_rise_is_that_of_the_line(recorded: Path) -> None:
    """Full pump into a constant volume: an exponential, by the line's own numbers."""
    plant, run = read_hardware(address_of(FAST + "&at=40kPa")).plant, read_run(recorded)
    full = run.columns["pump"] == 255
    time, vacuum = run.columns["time"][full], run.columns["vacuum"][full]
    pole, reach = plant.rate + plant.leak, plant.rate * plant.top / (plant.rate + plant.leak)
    due = reach - (reach - vacuum[0]) * np.exp(-pole * (time - time[0]))
    assert len(time) > 50 and np.abs(vacuum - due).max() < 1.0


@pytest.mark.parametrize("ending", ["csv", "parquet", "nc"])
def test_an_export_holds_the_samples(
    ending: str, recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Against what SQLite itself says, read by libraries of others."""
    out = tmp_path / f"a.{ending}"
    made = said(["bench", "export", str(recorded), "--out", str(out)], capsys)
    with contextlib.closing(sqlite3.connect(recorded)) as base:
        rows = base.execute("SELECT seq, vacuum, pump, board_us FROM samples ORDER BY seq")
        seq, vacuum, pump, us = np.array(rows.fetchall()).T
    assert (made["samples"], made["gaps"], made["interrupted"]) == (len(seq), 0, False)
    assert made["simulated"] and main(["bench", "export", str(recorded), "--out", str(out)]) == 2
    if ending == "csv":
        import pandas

        table = pandas.read_csv(out, comment="#")
        found = {name.split(" ")[0]: table[name].to_numpy() for name in table}
        text = (tmp_path / "a.csv.toml").read_text()
        assert 'vacuum = "40 kPa"' in text and "synthetic = true" in text
        assert "synthetic" in out.read_text().splitlines()[1]
    elif ending == "parquet":
        parquet = pytest.importorskip("pyarrow.parquet")
        made_table = parquet.read_table(out)
        found = {name: made_table[name].to_numpy() for name in made_table.column_names}
        assert made_table.schema.metadata[b"simulated"] == b"1"
        assert made_table.schema.field("vacuum").metadata == {b"unit": b"Pa"}
    else:
        xarray = pytest.importorskip("xarray")
        with xarray.open_dataset(out, engine="scipy") as data:
            found = {name: data[name].to_numpy() for name in data.variables}
            assert data.attrs["simulated"] == "1" and data["vacuum"].attrs["units"] == "Pa"
            assert data.attrs["brake_toml"].startswith("#")
    for name, values in (("seq", seq), ("vacuum", vacuum), ("pump", pump), ("board_us", us)):
        assert np.array_equal(found[name], values), name
    begun = int(read_run(recorded).meta["begun"])
    due = (us - us[seq == begun]) * 1e-6
    assert np.allclose(found["time"], due, rtol=0, atol=5e-7)


def test_a_part_of_a_run(recorded: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.csv"
    assert main(["bench", "export", str(recorded), "--out", str(out), "--from", "1 s",
                 "--to", "2 s"]) == 0  # fmt: skip
    time = np.loadtxt(out, delimiter=",", skiprows=_head(out), usecols=0)
    assert time[0] >= 1 and time[-1] <= 2 and 99 <= len(time) <= 101
    assert main(["bench", "export", str(recorded), "--out", str(tmp_path / "b.csv"),
                 "--from", "1000 s"]) == 2  # fmt: skip
    assert not (tmp_path / "b.csv").exists()


def _head(path: Path) -> int:
    lines = path.read_text().splitlines()
    return next(n for n, line in enumerate(lines, 1) if not line.startswith("#"))


def test_a_log_is_read_as_it_is(recorded: Path, tmp_path: Path) -> None:
    """By what `leak`, `pump-down` and `regulate --step` read with."""
    out = tmp_path / "a.csv"
    assert main(["bench", "export", str(recorded), "--out", str(out)]) == 0
    read, run = read_pressure(out, ReadingOptions(), 101325.0), read_run(recorded)
    assert read.reading == "vacuum" and "temperature" not in read.log
    assert np.allclose(read.log["time"], run.columns["time"], atol=5e-7)
    assert np.array_equal(read.absolute, np.maximum(101325.0 - run.columns["vacuum"], 1.0))
    # the run itself reads the same
    own = read_pressure(recorded, ReadingOptions(), 101325.0)
    assert np.array_equal(own.absolute, read.absolute)
    assert np.array_equal(own.log["time"], read.log["time"])
    facts = read_facts(out)
    assert facts.synthetic and facts.vacuum == 40e3 and facts.procedure == PROCEDURE


@pytest.mark.slow
def test_readers_take_the_csv_as_it_is(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the log commands make of it agrees with the line behind the virtual board."""
    out = tmp_path / "a.csv"
    assert main(["bench", "export", str(recorded), "--out", str(out)]) == 0
    capsys.readouterr()
    run, made = read_run(recorded), read_hardware(address_of(FAST + "&at=40kPa"))
    plant = made.plant
    full = run.columns["time"][run.columns["pump"] == 255]
    window = ["--from", f"{full[0]} s", "--to", f"{full[-1]} s"]
    code = main(["pump-down", str(out), *window, "--json"])
    down = json.loads(capsys.readouterr().out)
    # the pump evacuates to zero: no interval of the ultimate pressure is narrow beside that
    allowed = {"ultimate pressure interval"} if code == 4 else set()
    assert {one["name"] for one in down["failed_checks"]} == allowed
    assert down["rate"] == pytest.approx(plant.rate + plant.leak, rel=0.02)
    # what `regulate --step` makes of it
    regulator = Regulator(plant=plant, sensor=made.sensor, safe_state="release")
    step = RecordedStep(step=out, start=full[0], end=full[-1])
    _, found, _ = tune_from_step(regulator, step.step, step, atmosphere=101325.0, keep_noise=True)
    assert found.plant.rate == pytest.approx(plant.rate, rel=0.02)


@pytest.mark.slow
def test_a_leak_is_found_in_a_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A held vacuum that leaks at a rate known: `leak` finds it in the exported file."""
    path, out = tmp_path / "a.ljrun", tmp_path / "a.csv"
    with layerjam.bench.rig.open(FAST + "&rest=closed") as bench:
        made = read_hardware(bench.address)
        bench.safe_state, bench.vent_rest = "hold", "closed"
        bench.regulator = Regulator(plant=made.plant, sensor=made.sensor, safe_state="hold")
        bench.lease, bench.target, bench.output = 600.0, 60e3, True
        bench.wait(10, until=59e3)
        bench.off()
        assert bench.plant is not None
        bench.plant.injected = FaultInjection(leak=0.01)
        recorder = Recorder(bench, RunFile.create(path, describe_bench(bench)))
        while recorder.recorded < 3000:
            recorder.pause(recorder.record_block())
        recorder.file.close("FINISHED")
    assert main(["bench", "export", str(path), "--out", str(out)]) == 0
    capsys.readouterr()
    found = said(["leak", str(out), "--from", "11 s"], capsys)
    assert found["reading"] == "vacuum" and found["model"] == "linear"
    assert found["rate"] == pytest.approx(made.plant.leak + 0.01, rel=1e-3)


def test_what_cannot_be_is_refused_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["--out", str(tmp_path / "a.ljrun")]
    for more, why in (
        (["--procedure", "evacuate to 40 kPa; pull at 1 mm/s until 5 mm"], "crosshead"),
        (["--procedure", "blow"], "not a step"),
        (["--procedure", PROCEDURE, "--sample-time", "20ms"], "10 ms"),
        (["--procedure", PROCEDURE, "--vent-rest", "closed"], "-221"),
    ):
        assert main([*RUN, *more, *out]) == 2
        assert why in capsys.readouterr().err
    assert main([*RUN, "--procedure", PROCEDURE, "--out", str(tmp_path / "a.db")]) == 2
    weak = replace(read_hardware(address_of(FAST)).plant, top=50e3)
    with ready(plant=weak) as bench, pytest.raises(QuantityError, match="reaches"):
        bench.run("evacuate to 60 kPa", out=tmp_path / "a.ljrun")
    assert list(tmp_path.iterdir()) == []


def test_a_fault_ends_a_run_with_its_name(tmp_path: Path) -> None:
    with ready() as bench:
        assert bench.plant is not None
        bench.plant.injected = FaultInjection(pump=0.0)
        made = bench.run("evacuate to 60 kPa", out=tmp_path / "a.ljrun")
        assert bench.plant.outputs == (0.0, True) and bench.state == "FAULT"
    assert (made.outcome, made.fault) == ("FAULT:NO_VACUUM", "NO_VACUUM")
    assert [step.reached for step in made.steps] == [False]
    run = read_run(made.file)
    first = float(run.columns["time"][run.columns["state"] == 2][0])
    assert made.fault_time == pytest.approx(first)
    assert [text for *_, kind, text in run.events if kind == "fault"] == ["NO_VACUUM"]


def test_what_is_not_reached_is_said(tmp_path: Path) -> None:
    """A gain so small that the pump never starts: healthy by the law, and at no vacuum for good."""
    with ready(gain=1e-9, feed_forward=False, integral_time=1e6) as bench:
        made = bench.run("evacuate to 60 kPa", out=tmp_path / "a.ljrun")
    plant = read_hardware(address_of(FAST)).plant
    pole, reach = plant.rate + plant.leak, plant.rate * plant.top / (plant.rate + plant.leak)
    rise = -math.log(1 - 0.99 * 60e3 / reach) / pole
    assert made.outcome == "NOT_REACHED" and not made.steps[0].reached
    assert made.reason is not None and "60 kPa was not reached" in made.reason
    step = made.steps[0]
    assert step.started is not None and step.ended is not None
    # a block of at most two seconds late
    assert 3 * rise + 10 <= step.ended - step.started < 3 * rise + 12.5


def test_an_operator_stops_it_safely(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C twice: the second one while the outputs are put to rest."""
    import signal

    rest = Execution._make_safe

    def twice(self: Execution) -> None:
        signal.raise_signal(signal.SIGINT)
        rest(self)
        assert self.bench.plant is not None and self.bench.plant.outputs == (0.0, True)

    monkeypatch.setattr(Execution, "_make_safe", twice)
    begin = Execution._begin_run

    def stopped(self: Execution) -> None:
        begin(self)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Execution, "_begin_run", stopped)
    with ready() as bench:
        made = bench.run(PROCEDURE, out=tmp_path / "a.ljrun")
    assert made.outcome == "OPERATOR_STOPPED" and read_run(made.file).outcome == made.outcome


def test_a_full_disk_ends_a_run_safely(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make = RunFile.create.__func__  # type: ignore[attr-defined]

    def small(*given: Any) -> RunFile:
        file: RunFile = make(RunFile, *given)
        pages = file._base.execute("PRAGMA page_count").fetchone()[0]
        file._base.execute(f"PRAGMA max_page_count = {pages + 8}")
        return file

    monkeypatch.setattr(RunFile, "create", small)
    with ready() as bench:
        assert bench.plant is not None
        made = bench.run(PROCEDURE, out=tmp_path / "a.ljrun")
        assert bench.state == "SAFE" and bench.plant.outputs == (0.0, True)
    assert made.outcome == "DISK_FULL" and made.reason is not None and "full" in made.reason
    run = read_run(made.file)
    assert 0 < run.samples == made.samples and run.gaps == 0


def test_a_line_that_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begin = Execution._begin_run

    def cut(self: Execution) -> None:
        begin(self)
        self.bench._link.board._child.process.kill()  # type: ignore[attr-defined]

    monkeypatch.setattr(Execution, "_begin_run", cut)
    with ready() as bench:
        made = bench.run(PROCEDURE, out=tmp_path / "a.ljrun")
    assert made.outcome == "LINE_LOST" and read_run(made.file).outcome == "LINE_LOST"


def test_a_board_that_is_reset_ends_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its number is another then, and its outputs are at rest anyway."""
    stream, ran = Bench.stream, False

    def anew(self: Bench, records: int = 200) -> tuple[np.ndarray, int]:
        nonlocal ran
        rows, boot = stream(self, records)
        ran = ran or bool((rows["state"] == STATES["RUN"]).any())
        return rows, boot + ran

    monkeypatch.setattr(Bench, "stream", anew)
    with ready() as bench:
        made = bench.run("hold 100 s", out=tmp_path / "a.ljrun")
    run = read_run(made.file)
    assert (made.outcome, made.reason) == ("LINE_LOST", "the board was reset during the run")
    assert len(run.boots) == 2 and any("restarted" in text for *_, text in run.events)


def test_another_has_locked_the_bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with ready() as bench:
        monkeypatch.setattr(Bench, "lock", lambda self: False)
        with pytest.raises(LayerjamError, match="locked"):
            bench.run(PROCEDURE, out=tmp_path / "a.ljrun")
    assert list(tmp_path.iterdir()) == []


def test_a_sensor_at_rest_shows_its_noise() -> None:
    draw = np.random.default_rng(3)
    noisy = 500 + draw.normal(0, 20, 4000) + 0.5 * np.arange(4000)
    assert measure_scatter(noisy) == pytest.approx(60, rel=0.1)
    assert not any(map(measure_scatter, (np.full(30, 7.0), np.array([]), np.array([math.nan]))))
    coarse = np.round(noisy / 15.8) * 15.8
    assert measure_scatter(coarse) == pytest.approx(60 + 2 * 15.8, rel=0.15)


def test_a_board_without_a_clock_waits_for_who_fetches_and_not_for_the_dead() -> None:
    """A host that stops for 0.4 s loses nothing; after a second of silence the lease runs again."""
    with layerjam.bench.rig.open(FAST) as bench:
        rows, _ = bench.stream()
        bench.acknowledge(int(rows["seq"][-1]))
        seen = [int(rows["seq"][-1])]
        for pause in (0.4, 0.0, 0.0, 0.0):
            time.sleep(pause)
            rows, _ = bench.stream()
            seen.extend(rows["seq"].tolist())
            bench.acknowledge(seen[-1])
        assert seen == list(range(seen[0], seen[0] + len(seen))) and len(seen) > 500
        assert bench.ask("STR:LOST?") == "0"
        time.sleep(1.0)
        polls = (time.sleep(0.1) or int(bench.ask("STR:NEXT?")) for _ in range(200))
        assert any(number > seen[-1] + 1 for number in polls), "the board still waits"


def test_a_log_needs_no_lock(tmp_path: Path) -> None:
    """Another client has the lock and records too; both files have every sample."""
    with gateway("sim:choi2018") as (number, _):
        address = f"tcp:127.0.0.1:{number}"
        with layerjam.bench.rig.open(address) as bench:
            assert bench.lock()
            rows, _ = bench.stream()
            made = record_log(address, tmp_path / "a.ljrun", duration=0.5)
            assert (made.outcome, made.gaps) == ("FINISHED", 0) and made.samples >= 50
            more, _ = bench.stream()
            assert more["seq"][0] == rows["seq"][0], "nothing was taken from the first client"
            assert bench.ask("SYST:LOCK:OWN?") == '"SELF"'


def test_files_that_belong_together_are_named(tmp_path: Path) -> None:
    file = tmp_path / "a.ljrun"
    assert companion_notice(file) == []
    (tmp_path / "a.ljrun-wal").touch()
    (notice,) = companion_notice(file)
    assert notice.startswith("a.ljrun and a.ljrun-wal belong together")


def test_a_run_states_its_lease_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "a.ljrun")
    run = ["bench", "run", FAST, "--procedure", "evacuate to 40 kPa; vent", "--out", out]
    run += ["--brake", "choi2018-kapton", "--line", "choi2018", "--sensor-range", "103kPa"]
    run += ["--safe-state", "release", "--vent-rest", "open"]
    assert main(run) == 0
    first = capsys.readouterr().err.splitlines()[0]
    assert first.startswith("layerjam: lease 600 s:") and "safe state (release)" in first


@pytest.mark.slow
def test_a_log_and_its_resume(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["bench", "log", FAST, "--out", str(tmp_path / "a.ljrun"), "--duration", "5 s"]
    first = said(out, capsys)
    assert (first["outcome"], first["gaps"], first["boots"]) == ("FINISHED", 0, 1)
    assert first["samples"] >= 500 and first["simulated"]
    assert main(out) == 2 and "already exists" in capsys.readouterr().err
    again = said([*out, "--resume"], capsys)
    assert again["boots"] == 2 and again["samples"] >= first["samples"] + 500
    assert again["gaps"] == 0
    assert main(["bench", "log", FAST + "&at=40kPa", "--out", str(tmp_path / "b.ljrun"),
                 "--resume", "--duration", "5 s"]) == 2  # fmt: skip
    assert "not a file" in capsys.readouterr().err


@pytest.mark.slow
def test_what_a_held_up_host_reads_late_is_no_time_of_the_step(tmp_path: Path) -> None:
    """The board is up to 8 s ahead of who reads slowly; time to vent runs from its being told."""
    with ready(FAST + "&vent=0.2s") as bench:
        made = bench.run(
            "evacuate to 60 kPa and hold 1 s; vent",
            out=tmp_path / "held.ljrun",
            watch=lambda _: time.sleep(0.25),
        )
    assert (made.outcome, made.gaps) == ("FINISHED", 0), made.reason
    assert all(step.reached for step in made.steps)
