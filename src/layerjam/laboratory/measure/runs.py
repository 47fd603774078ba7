"""A bench run from its file: one SQLite database, also readable without this program.

`rig/run_file.py` writes it. A file that was not closed is read in place, together with the content
of its `-wal` file.
"""

import json
import math
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import numpy.typing as npt

from layerjam.core.errors import FileError, QuantityError
from layerjam.core.units import show
from layerjam.core.verdict import Acceptance
from layerjam.laboratory.measure.shots import Shot, read_shots

APPLICATION_ID = 0x4C4A5255
FORMAT = 1
ENDING = ".ljrun"
COLUMNS = tuple(
    "boot seq board_us vacuum target raw temperature pump flags state fault".split()  # noqa: SIM905
)
"""Columns of the `samples` table, in order; see runs.sql for their units."""
SCHEMA = Path(__file__).with_name("runs.sql").read_text(encoding="utf-8")
"""SQL of the tables in the file, with a description of their columns."""

Array = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class Run:
    """Content of a run file.

    `columns` are those of `samples`, preceded by `time` [s], shape (N,), with `elongation` [m] and
    `force` [N] if a machine recorded them. `time` is zero at the start of the recording, and
    negative for earlier samples of the board. The host's clock provides the time between two starts
    of the board. `gaps` is the number of missing samples.
    """

    path: str
    meta: Mapping[str, str]
    columns: Mapping[str, Array] = field(repr=False)
    boots: tuple[int, ...]
    """Starts of the board, in order."""
    events: Sequence[tuple[int, int | None, str, str]]
    clock: Array = field(repr=False)
    gaps: int
    shots: tuple[Shot, ...] = ()
    """Accelerometer records of drops."""

    @property
    def samples(self) -> int:
        """Number of samples."""
        return len(self.columns["time"])

    @property
    def outcome(self) -> str | None:
        """Outcome of the run; None if its file was never closed."""
        return self.meta.get("outcome") or None

    @property
    def decisions(self) -> tuple[Acceptance, ...]:
        """Failed checks that a person accepted before the run."""
        try:
            rows = [Acceptance.read(row) for row in json.loads(self.meta.get("accepted") or "[]")]
        except (ValueError, TypeError, QuantityError) as error:
            raise FileError(self.path, f"its accepted checks cannot be read: {error}") from None
        return tuple(replace(row, file=self.path) for row in rows)

    @property
    def interrupted(self) -> bool:
        """Whether the writer stopped before closing the file."""
        return self.outcome is None

    @property
    def simulated(self) -> bool:
        """Whether the run had no hardware."""
        return self.meta.get("simulated") != "0"

    def between(self, start: float | None, end: float | None) -> "Run":
        """Return the samples from `start` to `end` [s]; raises QuantityError if there are none."""
        time = self.columns["time"]
        is_inside = np.ones(len(time), bool)
        if start is not None:
            is_inside &= time >= start
        if end is not None:
            is_inside &= time <= end
        if not is_inside.any():
            ends = [show(float(end), "s") for end in (time[0], time[-1])] if len(time) else []
            span = " to ".join(ends) or "none"
            raise QuantityError.of("from", f"no sample in this range; the samples cover {span}")
        columns = {name: values[is_inside] for name, values in self.columns.items()}
        first, last = float(time[is_inside][0]), float(time[is_inside][-1])
        shots = tuple(shot for shot in self.shots if first <= self.trigger_time(shot) <= last)
        gaps = count_missing_samples(columns["boot"], columns["seq"])
        return replace(self, columns=columns, gaps=gaps, shots=shots)

    def trigger_time(self, shot: Shot) -> float:
        """Return the time of a shot's trigger [s]; NaN if its boot of the board has no sample."""
        indices = np.flatnonzero(self.columns["boot"] == shot.boot)
        if not len(indices):
            return math.nan
        first = indices[0]
        delay = shot.trigger_us - int(self.columns["board_us"][first])
        return float(self.columns["time"][first]) + delay * 1e-6


def count_missing_samples(boot: Array, seq: Array) -> int:
    """Return the number of missing samples between the first and the last of each boot."""
    gaps = 0
    for number in np.unique(boot):
        numbers = seq[boot == number]
        gaps += int(numbers.max() - numbers.min()) + 1 - len(numbers)
    return gaps


def open_run(path: str | Path, is_complete: bool = False) -> sqlite3.Connection:
    """Open a run file for reading; raises FileError if it is not a run file.

    `is_complete` means that no process writes to the file and that it has no `-wal` file. SQLite
    then creates no files next to it.
    """
    name = str(path)
    try:
        if not Path(path).is_file():
            raise FileError(name[:200], "is not a file")
        # use only SQLite: another open and close would release the locks of an active recorder
        uri = f"file:{quote(str(Path(path).absolute()))}?mode=ro{'&immutable=1' * is_complete}"
        base = sqlite3.connect(uri, uri=True)
    except (OSError, ValueError, sqlite3.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileError(name[:200], f"cannot be read: {reason}") from None
    try:
        _check_kind(base, name)
    except FileError:
        base.close()  # Windows cannot rename an open file
        raise
    return base


def _check_kind(base: sqlite3.Connection, name: str) -> None:
    """Raise FileError if a database is not a bench run that this version can read."""
    try:
        kind = base.execute("PRAGMA application_id").fetchone()[0]
        version = base.execute("PRAGMA user_version").fetchone()[0]
    except sqlite3.DatabaseError as error:
        if error.sqlite_errorcode == sqlite3.SQLITE_NOTADB:
            raise FileError(name, f"is not a bench run ({ENDING})") from None
        raise FileError(name, _describe_error(error)) from None
    if kind != APPLICATION_ID:
        raise FileError(name, "is a database, but not a bench run")
    if version > FORMAT:
        raise FileError(
            name, f"has format {version}; this layerjam reads up to {FORMAT}: update layerjam"
        )


def _describe_error(error: sqlite3.Error) -> str:
    kind = "cannot be read" if isinstance(error, sqlite3.OperationalError) else "is damaged"
    return f"{kind}: {error}"


def read_run(path: str | Path) -> Run:
    """Read everything in a run file; raises FileError if it is not one or is damaged."""
    base = open_run(path)
    try:
        base.execute("BEGIN")
        meta = {key: value or "" for key, value in base.execute("SELECT key, value FROM meta")}
        names = ", ".join(COLUMNS)
        rows = base.execute(f"SELECT {names} FROM samples ORDER BY boot, seq").fetchall()
        clock = base.execute("SELECT * FROM clock ORDER BY rowid").fetchall()
        events = base.execute("SELECT * FROM events ORDER BY rowid").fetchall()
        crosshead = base.execute("SELECT * FROM crosshead ORDER BY board_us").fetchall()
        shots = read_shots(base, meta.get("simulated") != "0")
    except sqlite3.Error as error:
        raise FileError(path, _describe_error(error)) from None
    except ValueError as error:
        raise FileError(path, f"is damaged: {error}") from None
    finally:
        base.close()
    clocks = np.array(clock, np.int64).reshape(-1, 5)
    boots = tuple(dict.fromkeys(clocks[:, 0].tolist()))
    rows.sort(key=lambda row: (boots.index(row[0]) if row[0] in boots else -1, row[1]))
    table = np.array(rows, float).reshape(-1, len(COLUMNS))
    columns: dict[str, Array] = {name: table[:, place] for place, name in enumerate(COLUMNS)}
    for name in set(COLUMNS) - {"vacuum", "target"}:
        columns[name] = columns[name].astype(np.int64)
    time = sample_times(columns, clocks)
    if meta.get("begun", "").isdecimal():
        first = (columns["seq"] >= int(meta["begun"])) & (columns["boot"] == boots[0])
        time = time - time[first][0] if first.any() else time
    columns = {"time": time, **columns}
    if crosshead:
        times, elongation, force = np.array(crosshead, float).T
        for name, values in (("elongation", elongation), ("force", force)):
            columns[name] = _interpolate_crosshead(columns, times, values)
    gaps = count_missing_samples(columns["boot"], columns["seq"])
    return Run(str(path), meta, columns, boots, events, clocks, gaps, shots)


def _interpolate_crosshead(columns: Mapping[str, Array], board_us: Array, values: Array) -> Array:
    """Return the machine's value at each sample; NaN if there is none."""
    us = columns["board_us"]
    place = np.searchsorted(board_us, us)
    place[place == len(board_us)] = 0
    is_same = (board_us[place] == us) & (columns["boot"] == columns["boot"][0])
    return np.where(is_same, values[place], np.nan)


def sample_times(columns: Mapping[str, Array], clock: Array) -> Array:
    """Return the time since the first sample [s], shape (N,).

    It follows the board's clock within a boot and the host's between boots, and never decreases.
    """
    boot, board = columns["boot"], columns["board_us"]
    time = np.zeros(len(boot))
    origin: tuple[int, int] | None = None
    last = 0.0
    for number in dict.fromkeys(boot.tolist()):
        is_same_boot = boot == number
        seconds = (board[is_same_boot] - board[is_same_boot][0]) * 1e-6
        start = _find_boot_clocks(clock[clock[:, 0] == number], int(board[is_same_boot][0]))
        time_offset = 0.0
        if origin is None:
            origin = start
        elif start is not None:
            # the monotonic clock restarts with the host, so only the calendar clock can be used
            clock_index = 0 if start[0] > origin[0] + last * 1e9 else 1
            time_offset = max((start[clock_index] - origin[clock_index]) * 1e-9, last)
        else:
            time_offset = last
        time[is_same_boot] = seconds + time_offset
        last = float(time[is_same_boot][-1])
    return time


def _find_boot_clocks(clock: Array, first: int) -> tuple[int, int] | None:
    """Return the host's clocks [ns] at a boot's first sample; None if unknown."""
    if not len(clock):
        return None
    _, _, board, mono, utc = (int(value) for value in clock[0])
    return mono - 1000 * (board - first), utc - 1000 * (board - first)
