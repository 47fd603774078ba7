"""A run file that is being written: every block is on disk before the board may discard it.

`measure/runs.py` describes the file's content and reads it. Other programs may read it at any time.
"""

import contextlib
import os
import shutil
import sqlite3
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.system import check_file_name, lock_file, report_failure
from layerjam.laboratory.measure.runs import (
    APPLICATION_ID,
    COLUMNS,
    ENDING,
    FORMAT,
    SCHEMA,
    open_run,
)

ROOM = 10e6
"""Free space that a run needs at its start [bytes]: twice ten minutes of samples, and a 4 MB log.
"""
FAR_AWAY = frozenset(
    "9p afs ceph cifs fuse.sshfs glusterfs lustre ncpfs nfs nfs4 smb3 smbfs".split()  # noqa: SIM905
)
"""Network file systems, on which locks and the write-ahead log are not reliable."""
MOUNTS = Path("/proc/self/mountinfo")


class RecordingError(LayerjamError):
    """Raised if a run file cannot store more data; the latest data are then missing."""

    key = "recording"


def find_file_system(path: Path, mounts: str) -> str:
    """Return the type of the file system of a path, or "" if `mounts` does not list it."""
    best, kind = "", ""
    for line in mounts.splitlines():
        before, _, after = line.partition(" - ")
        words = before.split()
        if len(words) < 5 or not after:
            continue
        point = words[4].replace("\\040", " ")
        is_inside = path.is_relative_to(point)
        if is_inside and len(point) >= len(best):
            best, kind = point, after.split()[0]
    return kind


def check_place(path: Path) -> None:
    """Raise FileError if a run cannot be stored safely, for lack of space or on a network disk."""
    if path.suffix != ENDING:
        raise FileError(path, f"extension '{path.suffix}' is unknown; use {ENDING}")
    check_file_name(path)
    folder = path.parent
    if not folder.is_dir():
        raise FileError(path, f"cannot be written: there is no folder {folder}")
    free = shutil.disk_usage(folder).free
    if free < ROOM:
        raise FileError(
            path,
            f"cannot be written: its disk has {free / 1e6:.1f} MB free, and a ten-minute run "
            f"needs {ROOM / 1e6:.0f} MB",
        )
    with contextlib.suppress(OSError):
        kind = find_file_system(folder.resolve(), MOUNTS.read_text("utf-8", "replace"))
        if kind in FAR_AWAY:
            raise FileError(
                path,
                f"is on a network file system ({kind}), which does not guarantee that data reach "
                "the disk; write to a local disk and copy the file afterwards",
            )


class RunFile:
    """One run, open for writing; no other program can write to it.

    Every method raises RecordingError if the disk is full.
    """

    def __init__(self, path: Path, base: sqlite3.Connection, lock: int) -> None:
        self.path = path
        self._base = base
        self._lock = lock
        self._pending: list[tuple[int, int | None, str, str]] = []
        self._open = True

    @classmethod
    def create(
        cls, path: str | Path, meta: Mapping[str, object], overwrite: bool = False
    ) -> "RunFile":
        """Return a new file; FileError if it exists (unless `overwrite`) or cannot be written."""
        path = Path(path)
        check_place(path)
        if overwrite:
            _remove_files(path)
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL
        with report_failure(path, "cannot be written"):
            try:
                lock = os.open(path, flags, 0o644)
            except FileExistsError:
                raise FileError(path, "already exists; --overwrite replaces it") from None
        try:
            run = cls._open_database(path, lock)
            base = run._base
            base.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            base.execute(f"PRAGMA user_version = {FORMAT}")
            base.executescript("BEGIN;" + SCHEMA + "COMMIT;")
            run.set_meta({"format": FORMAT, **meta})
        except (LayerjamError, sqlite3.Error) as error:
            os.close(lock)
            _remove_files(path)
            if isinstance(error, LayerjamError):
                raise
            raise FileError(path, f"cannot be written: {error}") from None
        return run

    @classmethod
    def resume(cls, path: str | Path) -> "RunFile":
        """Return a file to continue; FileError if it is not a run or is being written."""
        path = Path(path)
        check_place(path)
        open_run(path).close()
        with report_failure(path, "cannot be written"):
            path.chmod(path.stat().st_mode | 0o200)
            lock = os.open(path, os.O_RDWR)
        try:
            run = cls._open_database(path, lock)
            run.set_meta({"outcome": "", "ended_utc": ""})
        except (LayerjamError, sqlite3.Error) as error:
            os.close(lock)
            if isinstance(error, FileError):
                raise
            raise FileError(path, f"cannot be written: {error}") from None
        return run

    @classmethod
    def _open_database(cls, path: Path, lock: int) -> "RunFile":
        """Return the database of a locked file; the lock is kept until it is closed."""
        if not lock_file(lock):
            raise FileError(path, "is being written by another recorder")
        base = sqlite3.connect(path, isolation_level=None, timeout=2.0, check_same_thread=False)
        base.execute("PRAGMA journal_mode = WAL")
        base.execute("PRAGMA synchronous = FULL")
        return cls(path, base, lock)

    @property
    def meta(self) -> dict[str, str]:
        """{key: text} of the file's metadata."""
        rows = self._base.execute("SELECT key, value FROM meta")
        return {key: value or "" for key, value in rows}

    def last_sample(self, boot: int) -> tuple[int, int] | None:
        """Return (seq, board_us) of the last sample since a start of the board, or None."""
        row = self._base.execute(
            "SELECT seq, board_us FROM samples WHERE boot = ? ORDER BY seq DESC LIMIT 1", (boot,)
        ).fetchone()
        return None if row is None else (row[0], row[1])

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of samples, of missing samples and of starts of the board."""
        rows = self._base.execute(
            "SELECT count(*), max(seq) - min(seq) + 1 FROM samples GROUP BY boot"
        ).fetchall()
        total = sum(row[0] for row in rows)
        return total, sum(row[1] for row in rows) - total, len(rows)

    def add_note(self, kind: str, text: str, board_us: int | None = None) -> None:
        """Add one event, which is written with the next block."""
        self._pending.append((time.time_ns(), board_us, kind, text))

    def add_samples(
        self,
        rows: Sequence[Sequence[Any]] = (),
        clock: Sequence[int] | None = None,
        moves: Sequence[Sequence[Any]] = (),
    ) -> None:
        """Write samples, the host's clocks and the crosshead's rows to disk.

        Existing samples are kept.
        """
        events, marks = self._pending, ", ".join("?" * len(COLUMNS))
        with self._transaction() as base:
            base.executemany(f"INSERT OR IGNORE INTO samples VALUES ({marks})", rows)
            base.executemany("INSERT OR IGNORE INTO crosshead VALUES (?, ?, ?)", moves)
            if clock is not None:
                base.execute("INSERT INTO clock VALUES (?, ?, ?, ?, ?)", clock)
            base.executemany("INSERT INTO events VALUES (?, ?, ?, ?)", events)
        self._pending = []

    def add_shot(self, row: Mapping[str, Any]) -> None:
        """Write the row of an accelerometer's record; its samples follow."""
        names, marks = ", ".join(row), ", ".join("?" * len(row))
        with self._transaction() as base:
            base.execute(f"INSERT INTO shots ({names}) VALUES ({marks})", tuple(row.values()))

    def add_shot_data(self, shot: int, first: int, data: bytes) -> None:
        """Write samples of an accelerometer's record, int16, starting at its sample `first`."""
        with self._transaction() as base:
            row = (shot, first, len(data) // 2, data)
            base.execute("INSERT INTO shot_data VALUES (?, ?, ?, ?)", row)

    def set_meta(self, meta: Mapping[str, object]) -> None:
        """Set entries in the meta table of the file."""
        pairs = [(key, str(value)) for key, value in meta.items()]
        with self._transaction() as base:
            base.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", pairs)

    @contextlib.contextmanager
    def _transaction(self) -> Any:
        try:
            self._base.execute("BEGIN IMMEDIATE")
            yield self._base
            self._base.execute("COMMIT")
        except sqlite3.Error as error:
            with contextlib.suppress(sqlite3.Error):
                self._base.execute("ROLLBACK")
            raise RecordingError(f"{self.path}: cannot store more samples: {error}") from None

    def close(self, outcome: str = "") -> None:
        """Store the outcome and leave one read-only file, as far as the disk allows.

        Without an outcome, the file looks like one whose recorder was killed.
        """
        if not self._open:
            return
        self._open = False
        try:
            if outcome:
                with contextlib.suppress(RecordingError):
                    self.add_samples()
                with contextlib.suppress(RecordingError):
                    self.set_meta({"outcome": outcome, "ended_utc": format_utc()})
                # another program has the file open, or the disk is full
                with contextlib.suppress(sqlite3.Error):
                    self._base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
                    self._base.execute("PRAGMA journal_mode = DELETE")
        finally:
            with contextlib.suppress(sqlite3.Error):
                self._base.close()
            os.close(self._lock)
        if outcome:
            with contextlib.suppress(OSError):
                self.path.chmod(0o444)

    def discard(self) -> None:
        """Remove the file."""
        self.close()
        _remove_files(self.path)


def format_utc(ns: int | None = None) -> str:
    """Return a moment of the host's calendar time, by default now: 2026-11-23T03:00:00.123Z."""
    ns = time.time_ns() if ns is None else ns
    seconds = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(ns // 10**9))
    return f"{seconds}.{ns // 10**6 % 1000:03d}Z"


def _remove_files(path: Path) -> None:
    for file in (path, *(Path(f"{path}{ending}") for ending in ("-wal", "-shm"))):
        with contextlib.suppress(FileNotFoundError):
            file.unlink()
