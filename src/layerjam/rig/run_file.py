"""A run file that is being written: every block is on disk before the board may forget it.

What is in such a file, and how it is read, says `measure/runs.py`. Strangers may read it with their
own tools at any time.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sqlite3
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.runs import APPLICATION_ID, COLUMNS, ENDING, FORMAT, SCHEMA, opened

ROOM = 10e6
"""Free bytes that a run needs at its start: ten minutes of samples, twice, and the log of 4 MB."""
FAR_AWAY = frozenset(
    "9p afs ceph cifs fuse.sshfs glusterfs lustre ncpfs nfs nfs4 smb3 smbfs".split()  # noqa: SIM905
)
"""File systems of another machine: their locks and their write-ahead log do not hold."""
MOUNTS = Path("/proc/self/mountinfo")


class RecordingError(LayerjamError):
    """A run file that takes no more; what it was given last is not in it."""

    key = "recording"


def file_system(path: Path, mounts: str) -> str:
    """The kind of file system that a path lies on, "" where the list of mounts does not say."""
    best, kind = "", ""
    for line in mounts.splitlines():
        before, _, after = line.partition(" - ")
        words = before.split()
        if len(words) < 5 or not after:
            continue
        point = words[4].replace("\\040", " ")
        inside = path.is_relative_to(point)
        if inside and len(point) >= len(best):
            best, kind = point, after.split()[0]
    return kind


def check_place(path: Path) -> None:
    """Raise FileError where a run cannot be written safely: no folder, no room, a far disk."""
    if path.suffix != ENDING:
        raise FileError(path, f"the ending '{path.suffix}' is not known; use {ENDING}")
    folder = path.parent
    if not folder.is_dir():
        raise FileError(path, f"cannot be written: there is no folder {folder}")
    free = shutil.disk_usage(folder).free
    if free < ROOM:
        raise FileError(
            path,
            f"cannot be written: {free / 1e6:.1f} MB are free on its disk, and ten minutes of a "
            f"run need {ROOM / 1e6:.0f} MB",
        )
    with contextlib.suppress(OSError):
        kind = file_system(folder.resolve(), MOUNTS.read_text("utf-8", "replace"))
        if kind in FAR_AWAY:
            raise FileError(
                path,
                f"lies on a network file system ({kind}), which does not promise that data are on "
                "disk; write to a local disk and copy the file afterwards",
            )


class RunFile:
    """One run, open for writing; nobody else can write to it meanwhile.

    Every method raises RecordingError where the disk takes no more.
    """

    def __init__(self, path: Path, base: sqlite3.Connection, lock: int) -> None:
        self.path = path
        self._base = base
        self._lock = lock
        self._pending: list[tuple[int, int | None, str, str]] = []
        self._open = True

    @classmethod
    def create(cls, path: str | Path, meta: Mapping[str, object], force: bool = False) -> RunFile:
        """A new file; FileError where there is one already (unless `force`) or none can be."""
        path = Path(path)
        check_place(path)
        if force:
            _remove(path)
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL
        try:
            lock = os.open(path, flags, 0o644)
        except FileExistsError:
            raise FileError(path, "exists already; --force replaces it") from None
        except OSError as error:
            raise FileError(path, f"cannot be written: {error.strerror}") from None
        try:
            made = cls._on(path, lock)
            base = made._base
            base.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            base.execute(f"PRAGMA user_version = {FORMAT}")
            base.executescript("BEGIN;" + SCHEMA + "COMMIT;")
            made.state({"format": FORMAT, **meta})
        except (LayerjamError, sqlite3.Error) as error:
            os.close(lock)
            _remove(path)
            if isinstance(error, LayerjamError):
                raise
            raise FileError(path, f"cannot be written: {error}") from None
        return made

    @classmethod
    def resume(cls, path: str | Path) -> RunFile:
        """A file to go on with; FileError for what is none, or is being written by another."""
        path = Path(path)
        check_place(path)
        opened(path).close()
        try:
            path.chmod(path.stat().st_mode | 0o200)
            lock = os.open(path, os.O_RDWR)
        except OSError as error:
            raise FileError(path, f"cannot be written: {error.strerror}") from None
        try:
            made = cls._on(path, lock)
            made.state({"outcome": "", "ended_utc": ""})
        except (LayerjamError, sqlite3.Error) as error:
            os.close(lock)
            if isinstance(error, FileError):
                raise
            raise FileError(path, f"cannot be written: {error}") from None
        return made

    @classmethod
    def _on(cls, path: Path, lock: int) -> RunFile:
        """The database of a file whose lock is taken; the lock is kept until it is closed."""
        with contextlib.suppress(ImportError):  # no such locks elsewhere than on POSIX
            import fcntl

            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise FileError(path, "is being written by another recorder") from None
        base = sqlite3.connect(path, isolation_level=None, timeout=2.0, check_same_thread=False)
        base.execute("PRAGMA journal_mode = WAL")
        base.execute("PRAGMA synchronous = FULL")
        return cls(path, base, lock)

    @property
    def meta(self) -> dict[str, str]:
        """What the file says of itself."""
        rows = self._base.execute("SELECT key, value FROM meta")
        return {key: value or "" for key, value in rows}

    def last(self, boot: int) -> tuple[int, int] | None:
        """(seq, board_us) of a boot's last sample, None where there is none."""
        row = self._base.execute(
            "SELECT seq, board_us FROM samples WHERE boot = ? ORDER BY seq DESC LIMIT 1", (boot,)
        ).fetchone()
        return None if row is None else (row[0], row[1])

    def counts(self) -> tuple[int, int, int]:
        """(samples, missing ones, starts of the board)."""
        rows = self._base.execute(
            "SELECT count(*), max(seq) - min(seq) + 1 FROM samples GROUP BY boot"
        ).fetchall()
        there = sum(row[0] for row in rows)
        return there, sum(row[1] for row in rows) - there, len(rows)

    def note(self, kind: str, text: str, board_us: int | None = None) -> None:
        """One event; it is written with the next block."""
        self._pending.append((time.time_ns(), board_us, kind, text))

    def add(
        self,
        rows: Sequence[Sequence[Any]] = (),
        clock: Sequence[int] | None = None,
        moves: Sequence[Sequence[Any]] = (),
    ) -> None:
        """Samples, the host's clocks and the crosshead's rows, on disk when this returns.

        A sample that is there already stays as it is.
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
        """The row of an accelerometer's record; its samples follow."""
        names, marks = ", ".join(row), ", ".join("?" * len(row))
        with self._transaction() as base:
            base.execute(f"INSERT INTO shots ({names}) VALUES ({marks})", tuple(row.values()))

    def add_shot_data(self, shot: int, first: int, data: bytes) -> None:
        """Samples of an accelerometer's record, int16, from its sample `first` on."""
        with self._transaction() as base:
            row = (shot, first, len(data) // 2, data)
            base.execute("INSERT INTO shot_data VALUES (?, ?, ?, ?)", row)

    def state(self, meta: Mapping[str, object]) -> None:
        """Say or correct what the file says of itself."""
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
            raise RecordingError(f"{self.path}: takes no more samples: {error}") from None

    def close(self, outcome: str = "") -> None:
        """State how it ended and leave one read-only file, as far as the disk lets it.

        Without an outcome it is left as a killed recorder leaves it.
        """
        if not self._open:
            return
        self._open = False
        try:
            if outcome:
                with contextlib.suppress(RecordingError):
                    self.add()
                with contextlib.suppress(RecordingError):
                    self.state({"outcome": outcome, "ended_utc": utc()})
                with contextlib.suppress(sqlite3.Error):  # a reader has it open, or no room
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
        """Take it away: nothing came of it."""
        self.close()
        _remove(self.path)


def utc(ns: int | None = None) -> str:
    """A moment of the host's calendar, now unless given, such as 2026-11-23T03:00:00.123Z."""
    ns = time.time_ns() if ns is None else ns
    whole = time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(ns // 10**9))
    return f"{whole}.{ns // 10**6 % 1000:03d}Z"


def _remove(path: Path) -> None:
    for each in (path, *(Path(f"{path}{more}") for more in ("-wal", "-shm"))):
        with contextlib.suppress(FileNotFoundError):
            each.unlink()
