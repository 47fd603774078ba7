"""Fetch, commit, acknowledge: at least once from the board, exactly once in the file."""

from __future__ import annotations

import contextlib
import sqlite3
import stat
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layerjam.bench.rig import recorder, run_file
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.driver import InstrumentError
from layerjam.bench.rig.export import export
from layerjam.bench.rig.line import LineError
from layerjam.bench.rig.recorder import Recorder, check_board
from layerjam.bench.rig.run_file import RecordingError, RunFile, check_place, find_file_system
from layerjam.bench.rig.telemetry import RECORD, unwrap_clock
from layerjam.core.errors import FileError
from layerjam.laboratory.measure.runs import read_run

META = {"kind": "log", "board": "T1", "simulated": 1, "run_id": "r"}
ROOM = 1000


class Killed(BaseException):
    """What `kill -9` is to a test."""


class Board:
    """A ring of a board and its driver in one, in the plainest Python: no code of the firmware."""

    def __init__(self, boot: int = 7, uptime: int = 0) -> None:
        self.boot, self.uptime = boot, uptime
        self.made = self.kept = 0
        self.events: list[str] = []
        self.plant = None
        self.identity = "layerjam,test bench,T1,0"
        self.address = address_of("tcp:127.0.0.1:1")
        self.acts: list[str] = []

    def run(self, samples: int) -> None:
        self.made += samples
        self.kept = max(self.kept, self.made - ROOM)

    def row(self, seq: int) -> tuple[Any, ...]:
        us = (self.uptime + 10_000 * seq) % 2**32
        return (seq, us, 100.0 * seq, 5.0, seq % 999, 2300, 1, 0, 0, 0)

    def stream(self, count: int) -> tuple[np.ndarray, int]:
        self.acts.append("fetch")
        upto = min(self.made, self.kept + count)
        return np.array([self.row(seq) for seq in range(self.kept, upto)], RECORD), self.boot

    def acknowledge(self, seq: int) -> None:
        self.acts.append("acknowledge")
        if not self.kept <= seq < self.made:
            raise InstrumentError(-222, "out of range", "STR:ACK")
        self.kept = seq + 1


def opened(path: Path, board: Any) -> Recorder:
    """A recorder as `bench log --resume` starts one."""
    file = RunFile.resume(path) if path.exists() else RunFile.create(path, META)
    return Recorder(board, file)


@pytest.mark.parametrize("uptime", [0, 2**32 - 3_000_000])
def test_every_sample_once_and_its_clock_counts_on(tmp_path: Path, uptime: int) -> None:
    board, path = Board(uptime=uptime), tmp_path / "a.ljrun"
    made = opened(path, board)
    for _ in range(5):
        board.run(150)
        made.record_block()
    made.file.close("FINISHED")
    run = read_run(path)
    assert run.outcome == "FINISHED" and not run.interrupted and run.gaps == 0
    assert np.array_equal(run.columns["seq"], np.arange(750))
    assert np.array_equal(run.columns["board_us"], uptime + 10_000 * np.arange(750))
    assert np.abs(run.columns["time"] - 0.01 * np.arange(750)).max() < 1e-9
    assert np.array_equal(run.columns["vacuum"], 100.0 * np.arange(750))
    assert not (path.stat().st_mode & stat.S_IWUSR) and len(list(tmp_path.iterdir())) == 1


def test_nothing_is_acknowledged_before_it_is_on_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = Board()
    made = opened(tmp_path / "a.ljrun", board)
    add = made.file.add_samples

    def noted(*given: Any) -> None:
        add(*given)
        with contextlib.closing(sqlite3.connect(tmp_path / "a.ljrun")) as stranger:
            seen = stranger.execute("SELECT max(seq) FROM samples").fetchone()[0]
        board.acts.append(f"on disk to {seen}")

    monkeypatch.setattr(made.file, "add_samples", noted)
    for _ in range(2):
        board.run(30)
        made.record_block()
    assert board.acts == [
        "fetch", "on disk to 29", "acknowledge", "fetch", "on disk to 59", "acknowledge",
    ]  # fmt: skip
    made.file.close("FINISHED")


@settings(max_examples=8, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(0, 120), st.sampled_from(["", "fetch", "add", "acknowledge"])),
        min_size=1,
        max_size=8,
    )
)
def test_killed_anywhere_it_misses_nothing_and_doubles_nothing(
    tmp_path_factory: pytest.TempPathFactory, lives: list[tuple[int, str]]
) -> None:
    """Killed after each of the three acts, in any order; the ring holds all that is left."""
    path = tmp_path_factory.mktemp("kills") / "a.ljrun"
    board = Board(uptime=2**32 - 5_000_000)
    for samples, dies_after in lives:
        made = opened(path, board)
        board.run(samples)
        target: Any = made.file if dies_after == "add" else board
        if dies_after:
            name = {"fetch": "stream", "add": "add_samples"}.get(dies_after, dies_after)
            act = getattr(target, name)

            def dying(*given: Any, act: Any = act) -> None:
                act(*given)
                raise Killed

            setattr(target, name, dying)
        try:
            while board.kept < board.made:
                made.record_block()
        except Killed:
            pass
        if dies_after:
            delattr(target, name)
        made.file.close()
    made = opened(path, board)
    while board.kept < board.made:
        made.record_block()
    made.file.close("FINISHED")
    run = read_run(path)
    assert np.array_equal(run.columns["seq"], np.arange(board.made)) and run.gaps == 0
    assert np.array_equal(np.diff(run.columns["board_us"]), np.full(max(board.made - 1, 0), 10_000))


def test_what_the_ring_lost_is_counted_and_said(tmp_path: Path) -> None:
    board, path = Board(), tmp_path / "a.ljrun"
    made = opened(path, board)
    board.run(100)
    made.record_block()
    board.run(ROOM + 123)
    while board.kept < board.made:
        made.record_block()
    assert made.file.counts() == (ROOM + 100, 123, 1)
    made.file.close("FINISHED")
    run = read_run(path)
    assert run.gaps == 123 and any("123 samples are missing" in text for *_, text in run.events)
    assert run.columns["time"][100] == pytest.approx(2.23)


def test_a_board_that_starts_anew_is_another_boot(tmp_path: Path) -> None:
    """Time goes on by the host's clock, and never back, whatever the calendar does."""
    path, now = tmp_path / "a.ljrun", [10**12, 10**18]
    first, second = Board(boot=900), Board(boot=3)
    made = opened(path, first)
    made._clocks = lambda: (now[0], now[1])
    first.run(200)
    made.record_block()
    now[:] = now[0] + 5 * 10**9, now[1] - 3600 * 10**9
    made.bench = second  # type: ignore[assignment]
    second.run(200)
    made.record_block()
    assert made.file.counts() == (400, 0, 2)
    made.file.close("FINISHED")
    run = read_run(path)
    assert run.boots == (900, 3) and run.meta["boots"].split() == ["00000384", "00000003"]
    assert run.columns["boot"].tolist() == [900] * 200 + [3] * 200
    # both blocks came two seconds after their first sample
    assert run.columns["time"][200] == pytest.approx(5.0)
    assert (np.diff(run.columns["time"]) > 0).all()
    said = " ".join(text for *_, text in run.events)
    assert "restarted: 00000003" in said and "set back by 3605 s" in said


def test_an_open_file_is_read_and_a_second_recorder_refused(tmp_path: Path) -> None:
    board, path = Board(), tmp_path / "a.ljrun"
    made = opened(path, board)
    board.run(50)
    made.record_block()
    assert read_run(path).interrupted and read_run(path).samples == 50
    with pytest.raises(FileError, match="another recorder"):
        RunFile.resume(path)
    with pytest.raises(FileError, match="already exists"):
        RunFile.create(path, META)
    board.run(50)
    made.record_block()
    made.file.close()
    assert read_run(path).samples == 100
    other = Board()
    other.identity = "layerjam,test bench,T2,0"
    file = RunFile.resume(path)
    with pytest.raises(FileError, match="board T1"):
        check_board(other, file)  # type: ignore[arg-type]
    file.close("FINISHED")
    with contextlib.closing(sqlite3.connect(path)) as base:
        assert base.execute("PRAGMA application_id").fetchone() == (0x4C4A5255,)
        assert base.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert base.execute("PRAGMA journal_mode").fetchone() == ("delete",)


def test_a_full_disk_acknowledges_nothing(tmp_path: Path) -> None:
    board, path = Board(), tmp_path / "a.ljrun"
    made = opened(path, board)
    pages = made.file._base.execute("PRAGMA page_count").fetchone()[0]
    made.file._base.execute(f"PRAGMA max_page_count = {pages + 6}")
    with pytest.raises(RecordingError, match="full"):
        for _ in range(50):
            board.run(100)
            made.record_block()
    kept = board.kept
    made.file.close("DISK_FULL")
    run = read_run(path)
    assert 0 < kept < board.made and run.samples == kept
    assert np.array_equal(run.columns["seq"], np.arange(kept))


def test_export_takes_the_former_keyword_of_overwrite(tmp_path: Path) -> None:
    run, out = tmp_path / "a.ljrun", tmp_path / "a.csv"
    RunFile.create(run, META).close("FINISHED")
    for keyword in ("overwrite", "force"):
        out.write_text("old")
        with pytest.raises(FileError, match="already exists"):
            export(run, out)
        export(run, out, **{keyword: True})
        assert out.read_text() != "old"


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    text, other, torn = (tmp_path / name for name in ("a.txt", "b.db", "c.ljrun"))
    text.write_text("no database, but long enough to hold a head of one hundred bytes" * 4)
    with contextlib.closing(sqlite3.connect(other)) as base:
        base.execute("CREATE TABLE samples (seq INTEGER)")
        base.commit()
    RunFile.create(torn, META).close("FINISHED")
    torn.chmod(0o644)
    torn.write_bytes(torn.read_bytes()[:9000] + bytes(3000))
    for path, why in ((text, "not a bench run"), (other, "not a bench run"), (torn, "damaged"),
                      (tmp_path, "not a file"), (tmp_path / "none", "not a file")):  # fmt: skip
        with pytest.raises(FileError, match=why):
            read_run(path)


MOUNTED = """22 1 254:0 / / rw,relatime shared:1 - ext4 /dev/vda1 rw
31 22 0:27 / /data rw shared:5 - nfs4 server:/export rw
32 22 0:28 / /data/local\\040disk rw - xfs /dev/sdb1 rw
33 22 0:29 / /database rw - ext4 /dev/sdc1 rw
"""


@pytest.mark.parametrize(
    ("path", "kind"),
    [("/home/me", "ext4"), ("/data/runs", "nfs4"), ("/data/local disk/x", "xfs"),
     ("/database/x", "ext4")],
)  # fmt: skip
def test_the_file_system_of_a_path(path: str, kind: str) -> None:
    assert find_file_system(Path(path), MOUNTED) == kind
    assert find_file_system(Path(path), "") == ""


def test_a_place_where_no_run_can_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check_place(tmp_path / "a.ljrun")
    for name, why in (("a.db", "extension"), ("none/a.ljrun", "no folder")):
        with pytest.raises(FileError, match=why):
            check_place(tmp_path / name)
    mounts = tmp_path / "mounts"
    mounts.write_text(f"22 1 0:1 / {tmp_path} rw - nfs4 server:/x rw\n")
    monkeypatch.setattr(run_file, "MOUNTS", mounts)
    with pytest.raises(FileError, match="network file system"):
        RunFile.create(tmp_path / "a.ljrun", META)
    free = run_file.shutil.disk_usage(tmp_path)._replace(free=3_000_000)
    monkeypatch.setattr(run_file.shutil, "disk_usage", lambda path: free)
    with pytest.raises(FileError, match=r"has 3.0 MB free.*needs 10 MB"):
        RunFile.create(tmp_path / "a.ljrun", META)
    assert [path.name for path in tmp_path.iterdir()] == ["mounts"]


@given(
    st.integers(0, 2**33),
    st.lists(st.tuples(st.integers(1, 2_000_000), st.integers(-400, 400)), max_size=40),
)
def test_the_clock_without_wraps(start: int, steps: list[tuple[int, int]]) -> None:
    """Against a clock of as many bits as it takes; gaps of many wraps, each sample a bit off."""
    seq = np.cumsum([0, *(gap for gap, _ in steps)])
    true = start + 10_000 * seq + np.array([0, *(off for _, off in steps)])
    counts = (true % 2**32).astype("<u4")
    made = unwrap_clock(counts, seq.astype("<u4"))
    assert np.array_equal(made - made[0], true - true[0]) and np.array_equal(made % 2**32, counts)
    last = (int(seq[0]), int(made[0]))
    again = unwrap_clock(counts[1:], seq[1:].astype("<u4"), last)
    assert np.array_equal(again, made[1:])


class Cable(Board):
    """A board whose line is pulled after so many blocks; `makes` samples come between two."""

    safe_state = vent_rest = None
    simulated = False

    def __init__(self, blocks: int, makes: int = 60) -> None:
        super().__init__()
        self.blocks, self.makes, self.closed = blocks, makes, 0

    def ask(self, query: str) -> str:
        return "0"

    def stream(self, count: int) -> tuple[np.ndarray, int]:
        self.run(self.makes)
        self.blocks -= 1
        if self.blocks == 0:
            raise LineError("the serial line is gone")
        return super().stream(count)

    def close(self) -> None:
        self.closed += 1


def test_a_cable_is_pulled_and_put_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same board goes on without a gap; a while without a line costs nothing either."""
    board, tries = Cable(blocks=5), iter([True, False, False, True])

    def found(address: object) -> Cable:
        if not next(tries):
            raise FileError(address, "cannot be had")
        return board

    monkeypatch.setattr(recorder, "open_bench", found)
    said: list[str] = []
    made = recorder.record_log(
        "tcp:127.0.0.1:1", tmp_path / "a.ljrun", duration=8.0, say=said.append
    )
    assert (made.outcome, made.gaps, made.boots, made.simulated) == ("FINISHED", 0, 1, False)
    assert len(said) == 2 and board.closed == 2
    kinds = [text for *_, kind, text in read_run(made.file).events if kind == "link"]
    assert kinds == ["connection lost: the serial line is gone", "the connection is restored"]


def test_another_board_on_the_cable_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = Cable(blocks=3), Cable(blocks=99)
    second.identity = "layerjam,test bench,T2,0"
    boards = iter([first, second])
    monkeypatch.setattr(recorder, "open_bench", lambda address: next(boards))
    with pytest.raises(FileError, match="board T1"):
        recorder.record_log("tcp:127.0.0.1:1", tmp_path / "a.ljrun", duration=8.0)
    assert (first.closed, second.closed) == (2, 1)
    assert read_run(tmp_path / "a.ljrun").samples == 120


def test_a_line_that_stays_down_ends_a_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    boards = iter([Cable(blocks=3)])

    def found(address: object) -> Cable:
        for board in boards:
            return board
        raise FileError(address, "cannot be had")

    monkeypatch.setattr(recorder, "open_bench", found)
    made = recorder.record_log("tcp:127.0.0.1:1", tmp_path / "a.ljrun", patience=0.3)
    assert (made.outcome, made.reason) == ("LINE_LOST", "the serial line is gone")
    assert made.samples == 120 and read_run(made.file).outcome == "LINE_LOST"
