"""A run file that is written row by row: its times, gaps, machine and shots come back."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layerjam.core.errors import FileError
from layerjam.laboratory.measure.runs import APPLICATION_ID, FORMAT, SCHEMA, Run, open_run, read_run
from layerjam.laboratory.measure.shots import MEASURED, PIECE, SYNTHETIC, Shot, find_shot

STEP, PAUSE = 2_000, 7.5
"""Microseconds between samples, and seconds between the two starts of the board."""
BOOTS = {11: (400, 1_000_000), 5: (300, 30_000)}
"""{start of the board: number of samples, its clock at the first one [us]}; the later is smaller"""
LOST = {11: (50, 51, 300), 5: (7,)}
COUNTS = (np.arange(2 * PIECE + 17) * 31 % 4001 - 2000).astype(np.int16)


def shot(**changes: Any) -> Shot:
    values = {"counts": COUNTS, "size": len(COUNTS), "rate": 3200.0, "zero": 12.0, "gain": 0.048}
    values |= {"range": 160.0, "before": 100, "trigger_us": 1_100_000, "synthetic": False}
    return Shot(**values | {"boot": 11} | changes)  # type: ignore[arg-type]


def write(path: Path, begun: int | None = 20, host_ns: int = 10**15, **meta: str) -> Run:
    base = sqlite3.connect(path)
    base.executescript(SCHEMA)
    base.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    base.execute(f"PRAGMA user_version = {FORMAT}")
    host = host_ns
    for boot, (count, first) in BOOTS.items():
        for seq in sorted(set(range(count)) - set(LOST[boot])):
            row = (boot, seq, first + STEP * seq, 100.0 * seq, None, seq, 2000, 255, 1, 1, 0)
            base.execute(f"INSERT INTO samples VALUES ({', '.join('?' * len(row))})", row)
        late = 10  # the first block came after ten samples
        clock = (boot, late, first + STEP * late, host + 1000 * STEP * late, 3 * host)
        base.execute("INSERT INTO clock VALUES (?, ?, ?, ?, ?)", clock)
        host += int(PAUSE * 1e9)
    for seq in range(0, 400, 2):
        at = BOOTS[11][1] + STEP * seq
        base.execute("INSERT INTO crosshead VALUES (?, ?, ?)", (at, 1e-6 * seq, 0.5 * seq))
    one = shot()
    base.execute("INSERT INTO shots VALUES (?, ?, ?, ?, ?, ?, ?)", tuple(one.row().values()))
    for part in one.parts():
        base.execute("INSERT INTO shot_data VALUES (1, ?, ?, ?)", part)
    meta |= {} if begun is None else {"begun": str(begun)}
    base.executemany("INSERT INTO meta VALUES (?, ?)", meta.items())
    base.commit()
    base.close()
    return read_run(path)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return write(tmp_path_factory.mktemp("run") / "a.ljrun", simulated="0", outcome="done")


def test_times_follow_the_board_and_between_its_starts_the_host(run: Run) -> None:
    boot, seq, time = (run.columns[name] for name in ("boot", "seq", "time"))
    assert run.boots == tuple(BOOTS) and list(dict.fromkeys(boot.tolist())) == list(BOOTS)
    expected = (seq - 20) * STEP * 1e-6 + PAUSE * (boot == 5)
    assert time == pytest.approx(expected, abs=2e-9)
    assert np.all(np.diff(time) > 0)


def test_neither_the_hosts_clock_nor_the_origin_changes_a_difference(
    run: Run, tmp_path: Path
) -> None:
    for number, (begun, host) in enumerate(((None, 10**15), (100, 10**15), (20, 10**15 + 10**12))):
        other = write(tmp_path / f"{number}.ljrun", begun, host)
        assert np.diff(other.columns["time"]) == pytest.approx(
            np.diff(run.columns["time"]), abs=2e-9
        )
        first = 0.0 if begun is None else -begun * STEP * 1e-6
        assert other.columns["time"][0] == pytest.approx(first, abs=1e-12)


def test_samples_and_gaps_are_all_that_the_board_has_counted(run: Run) -> None:
    assert run.gaps == sum(map(len, LOST.values()))
    assert run.samples + run.gaps == sum(count for count, _ in BOOTS.values())
    parts = [run.between(None, 0.3), run.between(0.3 + 1e-9, None)]
    assert sum(part.samples for part in parts) == run.samples
    assert [part.gaps for part in parts] == [2, 2]
    assert [len(part.shots) for part in parts] == [1, 0]


def test_a_machine_is_read_at_the_same_moments_of_the_first_start_alone(run: Run) -> None:
    boot, seq = run.columns["boot"], run.columns["seq"]
    there = (boot == 11) & (seq % 2 == 0)
    for name, slope in (("elongation", 1e-6), ("force", 0.5)):
        values = run.columns[name]
        assert values[there] == pytest.approx(slope * seq[there], rel=1e-12)
        assert np.isnan(values[~there]).all()


def test_a_shot_comes_back_with_its_times_and_accelerations(run: Run) -> None:
    (made,) = run.shots
    assert np.array_equal(made.counts, COUNTS) and made.size == len(COUNTS)
    assert made.time[100] == 0 and np.diff(made.time) == pytest.approx(1 / 3200)
    assert made.acceleration == pytest.approx((COUNTS - 12.0) * 0.048)
    assert run.trigger_time(made) == pytest.approx((1_100_000 - 1_000_000) * 1e-6 - 20 * 2e-3)
    assert np.isnan(run.trigger_time(shot(boot=99)))
    parts = made.parts()
    assert [(first, n, len(data)) for first, n, data in parts] == [
        (0, PIECE, 2 * PIECE), (PIECE, PIECE, 2 * PIECE), (2 * PIECE, 17, 34),
    ]  # fmt: skip
    gap = Shot.from_rows(made.row(), [parts[0], parts[2]], True)
    assert len(gap.counts) == PIECE and gap.size == len(COUNTS) and gap.synthetic
    assert MEASURED in made.text() and SYNTHETIC in gap.text()
    rows = [line for line in made.text().splitlines() if not line.startswith("#")]
    table = np.array([line.split(",") for line in rows[1:]], float)
    assert table == pytest.approx(np.column_stack((made.time, made.acceleration)), rel=1e-8)


def test_a_shot_is_found_by_its_number() -> None:
    several = (shot(number=3), shot(number=4))
    assert find_shot(several, 4, "a").number == 4 and find_shot(several[:1], None, "a").number == 3
    for shots, number in (((), None), (several, None), (several, 5)):
        with pytest.raises(FileError):
            find_shot(shots, number, "a")


def test_a_run_is_measured_only_if_it_says_so(run: Run, tmp_path: Path) -> None:
    assert not run.simulated and not run.shots[0].synthetic and run.outcome == "done"
    assert not run.interrupted and run.decisions == ()
    for number, meta in enumerate(({}, {"simulated": "1"}, {"simulated": ""})):
        other = write(tmp_path / f"{number}.ljrun", **meta)
        assert other.simulated and other.shots[0].synthetic and other.interrupted
    facts = json.loads(other.shots[0].row()["scale"])
    assert facts == {"zero": 12.0, "gain": 0.048, "range": 160.0}


def test_only_a_run_of_a_known_format_is_opened(tmp_path: Path) -> None:
    write(tmp_path / "a.ljrun")
    for key, value in (("user_version", FORMAT + 1), ("application_id", 7)):
        base = sqlite3.connect(tmp_path / "a.ljrun")
        base.execute(f"PRAGMA {key} = {value}")
        base.commit()
        base.close()
        with pytest.raises(FileError):
            open_run(tmp_path / "a.ljrun")
