"""`kill -9` of a log, again and again: nothing missing, nothing double."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench.rig.gateways import Client, gateway
from layerjam.bench.rig.driver import open_bench
from layerjam.laboratory.measure.runs import read_run

KILLS = int(os.environ.get("LAYERJAM_KILLS", "12"))
"""Fifty take two minutes on a busy machine."""
CODE = """
import sys
from layerjam.bench.rig.recorder import record_log
resume = sys.argv[3] == "resume"
made = record_log(sys.argv[1], sys.argv[2], resume=resume, duration=float(sys.argv[4]))
print(made.outcome, made.samples, made.gaps, made.boots, made.reason)
"""


def started(port: int, path: Path, duration: float = 1e6) -> subprocess.Popen[str]:
    how = "resume" if path.exists() else "new"
    return subprocess.Popen(
        [sys.executable, "-c", CODE, f"tcp:127.0.0.1:{port}", str(path), how, str(duration)],
        stdout=subprocess.PIPE, text=True, env={**os.environ},
    )  # fmt: skip


def count(path: Path) -> int:
    """Samples, as a stranger counts them while they are being written."""
    try:
        with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as base:
            return int(base.execute("SELECT count(*) FROM samples").fetchone()[0])
    except sqlite3.Error:
        return 0


@pytest.mark.parametrize("kills", [2, pytest.param(KILLS, marks=pytest.mark.slow)])
def test_killed_and_started_again_it_has_every_sample_once(kills: int, tmp_path: Path) -> None:
    path, draw = tmp_path / "a.ljrun", random.Random(kills)
    with gateway("sim:choi2018") as (port, _):
        for _ in range(kills):
            before = count(path)
            process = started(port, path)
            end = time.monotonic() + 30
            while count(path) <= before and time.monotonic() < end:
                time.sleep(0.01)
            time.sleep(draw.uniform(0, 0.15))
            process.kill()
            process.communicate()
        assert read_run(path).interrupted
        process = started(port, path, 0.3)
        said = process.communicate(timeout=60)[0].split()
    with contextlib.closing(sqlite3.connect(path)) as base:
        numbers, span, boots = base.execute(
            "SELECT count(*), max(seq) - min(seq) + 1, count(DISTINCT boot) FROM samples"
        ).fetchone()
        assert base.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    assert numbers == span > 10 * kills and boots == 1
    assert said[:4] == ["FINISHED", str(numbers), "0", "1"]
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.ljrun"]


@pytest.mark.slow
def test_a_signal_closes_the_file_and_leaves_the_outputs_alone(tmp_path: Path) -> None:
    path = tmp_path / "a.ljrun"
    with gateway("sim:choi2018") as (port, _), open_bench(f"tcp:127.0.0.1:{port}") as bench:
        bench.tell("OUTP:SYNC ON")
        process = started(port, path)
        while not count(path):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=30)[0].split()
        assert bench.ask("OUTP:SYNC?") == "1"
    assert said[0] == "OPERATOR_STOPPED" and process.returncode == 0
    assert read_run(path).outcome == "OPERATOR_STOPPED"


@pytest.mark.slow
def test_a_killed_run_stops_within_its_lease(tmp_path: Path) -> None:
    """Also if somebody asked for a long lease before and left."""
    words = ["--procedure", "evacuate to 40 kPa and hold 60 s; vent", "--brake", "choi2018-kapton"]
    words += ["--line", "choi2018", "--sensor-range", "103kPa", "--safe-state", "release"]
    words += ["--vent-rest", "open", "--out", str(tmp_path / "a.ljrun")]
    with gateway("sim:choi2018") as (port, _):
        asked, other = Client(port), Client(port)
        asked.send("SYST:LEAS 120;*RST;:SYST:LEAS 120")
        assert asked.error() == 0
        asked.close()
        process = subprocess.Popen(
            [sys.executable, "-m", "layerjam", "bench", "run", f"tcp:127.0.0.1:{port}", *words],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ},
        )  # fmt: skip
        end = time.monotonic() + 60
        while "RUN" not in other.ask("FETC:ALL?") and time.monotonic() < end:
            time.sleep(0.05)
        assert "RUN" in other.ask("FETC:ALL?")
        process.kill()
        first = process.communicate()[1].splitlines()[0]
        end = time.monotonic() + 3
        while "RUN" in other.ask("FETC:ALL?") and time.monotonic() < end:
            time.sleep(0.05)
        assert "RUN" not in other.ask("FETC:ALL?")
        assert first.startswith("layerjam: lease 2 s:")
        other.close()


@pytest.mark.slow
def test_a_file_that_may_not_grow(tmp_path: Path) -> None:
    """The system's own limit of a file's size, as a quota has it."""
    path = tmp_path / "a.ljrun"
    limits = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))\n"
    with gateway("sim:choi2018?speed=20") as (port, _):
        made = subprocess.run(
            [sys.executable, "-c", limits + CODE, f"tcp:127.0.0.1:{port}", str(path), "new", "1e6"],
            capture_output=True, text=True, timeout=60, check=True, env={**os.environ},
        )  # fmt: skip
        with open_bench(f"tcp:127.0.0.1:{port}") as bench:
            first = int(bench.stream(1)[0]["seq"][0])
    outcome, samples, gaps, *reason = made.stdout.split()
    run = read_run(path)
    assert (outcome, int(samples), int(gaps)) == ("DISK_FULL", run.samples, run.gaps) and reason
    # what the board still gives is what comes after the file's last sample, or later
    assert run.samples > 500 and first > int(run.columns["seq"][-1])
