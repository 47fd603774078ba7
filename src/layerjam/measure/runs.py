"""A run of a bench as its file holds it: one SQLite database, also readable without us.

`rig/run_file.py` writes it. A file that nobody has closed is read in place, with what its `-wal`
holds.
"""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import numpy.typing as npt

from layerjam.errors import FileError, QuantityError
from layerjam.measure.shots import SCHEMA as SHOTS
from layerjam.measure.shots import Shot, shots_in
from layerjam.units import show
from layerjam.verdict import Acceptance

APPLICATION_ID = 0x4C4A5255
FORMAT = 1
ENDING = ".ljrun"
COLUMNS = tuple(
    "boot seq board_us vacuum target raw temperature pump flags state fault".split()  # noqa: SIM905
)
"""Of the table `samples`, in its order; see SCHEMA for their units."""
SCHEMA = (
    """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT);
-- one row a sample of the board: board_us its clock in microseconds, without wraps; vacuum and
-- target in Pa (NULL: no number); temperature in 0.01 degC of the sensor; pump 0 to 255;
-- flags 1 vent open, 2 pump backwards, 4 sync, 8 emergency stop, 16 external contact;
-- state 0 SAFE, 1 RUN, 2 FAULT, 3 DRIVE
CREATE TABLE samples (
  boot INTEGER, seq INTEGER, board_us INTEGER, vacuum REAL, target REAL, raw INTEGER,
  temperature INTEGER, pump INTEGER, flags INTEGER, state INTEGER, fault INTEGER,
  PRIMARY KEY (boot, seq)
) WITHOUT ROWID;
-- the host's clocks when a block had come whose last sample is seq
CREATE TABLE clock (
  boot INTEGER, seq INTEGER, board_us INTEGER, host_mono_ns INTEGER, host_utc_ns INTEGER
);
-- kind: step, prompt, answer, error, fault, link, note
CREATE TABLE events (host_utc_ns INTEGER, board_us INTEGER, kind TEXT, text TEXT);
-- elongation in m, force in N
CREATE TABLE crosshead (board_us INTEGER PRIMARY KEY, elongation REAL, force REAL);
"""
    + SHOTS
)
"""`boot` is the number that a board draws when it starts."""

Array = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class Run:
    """What a run file holds.

    `columns` are those of `samples` with `time` [s] before them, shape (N,); where a machine gave
    them `elongation` [m] and `force` [N] too. `time` counts from where the recording began: what
    the board still had from before is earlier than 0. Between two starts of the board it is the
    host's. `gaps` counts samples that are missing.
    """

    path: str
    meta: Mapping[str, str]
    columns: Mapping[str, Array]
    boots: tuple[int, ...]
    """Starts of the board, in their order."""
    events: Sequence[tuple[int, int | None, str, str]]
    clock: Array
    gaps: int
    shots: tuple[Shot, ...] = ()
    """What the accelerometer recorded of drops."""

    @property
    def samples(self) -> int:
        """How many there are."""
        return len(self.columns["time"])

    @property
    def outcome(self) -> str | None:
        """How it ended; None for a run that nobody closed."""
        return self.meta.get("outcome") or None

    @property
    def decisions(self) -> tuple[Acceptance, ...]:
        """The failed checks that somebody accepted before the run."""
        try:
            rows = [Acceptance.read(row) for row in json.loads(self.meta.get("accepted") or "[]")]
        except (ValueError, TypeError, QuantityError) as error:
            raise FileError(self.path, f"its accepted checks cannot be read: {error}") from None
        return tuple(replace(row, file=self.path) for row in rows)

    @property
    def interrupted(self) -> bool:
        """Whether whoever wrote it was stopped before it closed the file."""
        return self.outcome is None

    @property
    def simulated(self) -> bool:
        """Whether no hardware was behind it."""
        return self.meta.get("simulated") != "0"

    def between(self, start: float | None, end: float | None) -> Run:
        """The samples from `start` to `end` [s]; QuantityError where there are none."""
        time = self.columns["time"]
        kept = np.ones(len(time), bool)
        if start is not None:
            kept &= time >= start
        if end is not None:
            kept &= time <= end
        if not kept.any():
            ends = [show(float(end), "s") for end in (time[0], time[-1])] if len(time) else []
            span = " to ".join(ends) or "none"
            raise QuantityError.of("from", f"no sample lies within; there are samples: {span}")
        columns = {name: values[kept] for name, values in self.columns.items()}
        first, last = float(time[kept][0]), float(time[kept][-1])
        shots = tuple(shot for shot in self.shots if first <= self.time_of(shot) <= last)
        gaps = missing(columns["boot"], columns["seq"])
        return replace(self, columns=columns, gaps=gaps, shots=shots)

    def time_of(self, shot: Shot) -> float:
        """When a shot was triggered [s]; NaN where no sample of its board is there."""
        inside = np.flatnonzero(self.columns["boot"] == shot.boot)
        if not len(inside):
            return math.nan
        first = inside[0]
        passed = shot.trigger_us - int(self.columns["board_us"][first])
        return float(self.columns["time"][first]) + passed * 1e-6


def missing(boot: Array, seq: Array) -> int:
    """How many samples lack between the first and the last of each boot."""
    gaps = 0
    for one in np.unique(boot):
        numbers = seq[boot == one]
        gaps += int(numbers.max() - numbers.min()) + 1 - len(numbers)
    return gaps


def opened(path: str | Path, whole: bool = False) -> sqlite3.Connection:
    """A run file, to read only; FileError for what is none.

    `whole` is for a file that nobody writes to and that has no `-wal`: SQLite then leaves nothing
    beside it.
    """
    name = str(path)
    try:
        if not Path(path).is_file():
            raise FileError(name[:200], "is no file")
        # SQLite alone opens it: another close would give up the locks of a recorder beside us
        uri = f"file:{quote(str(Path(path).absolute()))}?mode=ro{'&immutable=1' * whole}"
        base = sqlite3.connect(uri, uri=True)
        kind = base.execute("PRAGMA application_id").fetchone()[0]
        version = base.execute("PRAGMA user_version").fetchone()[0]
    except sqlite3.DatabaseError as error:
        if error.sqlite_errorcode == sqlite3.SQLITE_NOTADB:
            raise FileError(name, f"is no run of a bench ({ENDING})") from None
        raise FileError(name, _wrong(error)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileError(name[:200], f"cannot be read: {reason}") from None
    if kind != APPLICATION_ID:
        raise FileError(name, "is a database, but no run of a bench")
    if version > FORMAT:
        raise FileError(
            name, f"has format {version}; this version reads up to {FORMAT}, so update layerjam"
        )
    return base


def _wrong(error: sqlite3.Error) -> str:
    kind = "cannot be read" if isinstance(error, sqlite3.OperationalError) else "is damaged"
    return f"{kind}: {error}"


def read_run(path: str | Path) -> Run:
    """Everything in a run file; FileError for what is none, or damaged."""
    base = opened(path)
    try:
        base.execute("BEGIN")
        meta = {key: value or "" for key, value in base.execute("SELECT key, value FROM meta")}
        listed = ", ".join(COLUMNS)
        rows = base.execute(f"SELECT {listed} FROM samples ORDER BY boot, seq").fetchall()
        clock = base.execute("SELECT * FROM clock ORDER BY rowid").fetchall()
        events = base.execute("SELECT * FROM events ORDER BY rowid").fetchall()
        moved = base.execute("SELECT * FROM crosshead ORDER BY board_us").fetchall()
        shots = shots_in(base, meta.get("simulated") != "0")
    except sqlite3.Error as error:
        raise FileError(path, _wrong(error)) from None
    except ValueError as error:
        raise FileError(path, f"is damaged: {error}") from None
    finally:
        base.close()
    clocks = np.array(clock, np.int64).reshape(-1, 5)
    boots = tuple(dict.fromkeys(clocks[:, 0].tolist()))
    rows.sort(key=lambda row: (boots.index(row[0]) if row[0] in boots else -1, row[1]))
    found = np.array(rows, float).reshape(-1, len(COLUMNS))
    columns: dict[str, Array] = {name: found[:, at] for at, name in enumerate(COLUMNS)}
    for name in set(COLUMNS) - {"vacuum", "target"}:
        columns[name] = columns[name].astype(np.int64)
    time = time_of(columns, clocks)
    if meta.get("begun", "").isdecimal():
        first = (columns["seq"] >= int(meta["begun"])) & (columns["boot"] == boots[0])
        time = time - time[first][0] if first.any() else time
    columns = {"time": time, **columns}
    if moved:
        at, elongation, force = np.array(moved, float).T
        for name, values in (("elongation", elongation), ("force", force)):
            columns[name] = _at(columns, at, values)
    gaps = missing(columns["boot"], columns["seq"])
    return Run(str(path), meta, columns, boots, events, clocks, gaps, shots)


def _at(columns: Mapping[str, Array], board_us: Array, values: Array) -> Array:
    """What the machine showed at each sample, NaN where it showed nothing."""
    us = columns["board_us"]
    place = np.searchsorted(board_us, us)
    place[place == len(board_us)] = 0
    there = (board_us[place] == us) & (columns["boot"] == columns["boot"][0])
    return np.where(there, values[place], np.nan)


def time_of(columns: Mapping[str, Array], clock: Array) -> Array:
    """Seconds from the first sample on, shape (N,).

    The board's clock within a boot; the host's from one to the next, and never backwards.
    """
    boot, board = columns["boot"], columns["board_us"]
    time = np.zeros(len(boot))
    origin: tuple[int, int] | None = None
    last = 0.0
    for one in dict.fromkeys(boot.tolist()):
        inside = boot == one
        own = (board[inside] - board[inside][0]) * 1e-6
        begun = _begun(clock[clock[:, 0] == one], int(board[inside][0]))
        after = 0.0
        if origin is None:
            origin = begun
        elif begun is not None:
            # the monotonic clock starts anew with the host; then there is only its calendar
            which = 0 if begun[0] > origin[0] + last * 1e9 else 1
            after = max((begun[which] - origin[which]) * 1e-9, last)
        else:
            after = last
        time[inside] = own + after
        last = float(time[inside][-1])
    return time


def _begun(clock: Array, first: int) -> tuple[int, int] | None:
    """The host's clocks [ns] at a boot's first sample, None where nobody looked."""
    if not len(clock):
        return None
    _, _, board, mono, utc = (int(value) for value in clock[0])
    return mono - 1000 * (board - first), utc - 1000 * (board - first)
