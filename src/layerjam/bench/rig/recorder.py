"""Recording of a board's samples in a run file: fetch, commit, then acknowledge.

A board sends every sample at least once. The file contains each sample exactly once, identified by
the number of the board's start and its own number. If the recorder is killed, no acknowledged
sample is lost; the board keeps the others for ten seconds.
"""

import contextlib
import getpass
import platform
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.bench.rig.board import law_hash
from layerjam.bench.rig.driver import Bench, InstrumentError, open_bench
from layerjam.bench.rig.line import LineError, SpoiltError
from layerjam.bench.rig.outcomes import Logged
from layerjam.bench.rig.run_file import RecordingError, RunFile, format_utc
from layerjam.bench.rig.stop import Stop
from layerjam.bench.rig.telemetry import PERIOD, unwrap_clock
from layerjam.core.errors import FileError, LayerjamError, are_text
from layerjam.core.store import accept_force_option

PACE = 0.05
"""Time between two blocks [s of the host's clock]."""
FULL = 200
"""Largest number of records in one block."""
FEW = 25
"""Number of records in a block if the line damages longer ones."""
SLOW = 0.1
"""Transfer time of a block above which the next one is shortened [s of the host's clock]."""
CREDIT = 300
"""Number of samples that a board at full speed may take before it waits for its recorder."""
SLOWLY = 0.0005
PATIENCE = 60.0
"""Longest time spent trying to restore a lost connection [s]."""
JUMP = 1_000_000_000
"""Smallest jump between the host's calendar time and its clock that is reported [ns]."""
FINISHED, STOPPED = "FINISHED", "OPERATOR_STOPPED"
LINE_LOST, DISK_FULL = "LINE_LOST", "DISK_FULL"


@dataclass(frozen=True, eq=False)
class Block:
    """Samples that are on disk: the board's records, and their times `us` without overflow."""

    rows: np.ndarray[Any, Any]
    us: np.ndarray[Any, Any]


Moves = Callable[[Block], list[tuple[int, float, float]]]
"""Crosshead's rows for a block: board's clock [us], elongation [m], force [N]."""


class Recorder:
    """Recorder of one board in one file; call `record_block` about every 50 ms.

    `clocks` returns the host's (monotonic ns, calendar ns).
    """

    def __init__(
        self,
        bench: Bench,
        file: RunFile,
        clocks: Callable[[], tuple[int, int]] = lambda: (time.monotonic_ns(), time.time_ns()),
    ) -> None:
        self.bench, self.file = bench, file
        self.boot: int | None = None
        self.now = 0
        """The board's clock [us] at the last sample."""
        self.recorded = 0
        """Number of samples since this recorder began, including missing ones."""
        self._clocks = clocks
        self._calendar: int | None = None
        self._last: tuple[int, int] | None = None
        self._told, self._heard = 0.0, 0
        self._asked = self._most = FULL
        self._throttle = _make_throttle(bench)

    @property
    def seq(self) -> int:
        """Number of the last sample, or -1."""
        return -1 if self._last is None else self._last[0]

    def record_block(self, moves: Moves | None = None) -> Block:
        """Fetch, store and acknowledge one block.

        `moves` returns the crosshead's rows for this block. Raises LineError, or RecordingError if
        the disk is full; in that case nothing is acknowledged.
        """
        rows, boot = self._fetch_block()
        mono, calendar = self._clocks()
        for text in self.bench.events[self._heard :]:
            self.file.add_note("error", text, self.now)
        self._heard = len(self.bench.events)
        with self._hold_board():
            if boot != self.boot:
                self._begin_series(boot)
            self._watch_calendar(calendar - mono)
            us = unwrap_clock(rows["board_us"], rows["seq"], self._last)
            block = Block(rows, us)
            if len(rows):
                self._commit_block(block, moves, mono, calendar)
        if len(rows):
            try:
                self.bench.acknowledge(self.seq)
            except InstrumentError as error:
                if error.code != -222:
                    raise
                text = "the board has lost the samples: it was reset, or another recorder read them"
                self.file.add_note("link", text, self.now)
        return block

    def _fetch_block(self) -> tuple[np.ndarray[Any, Any], int]:
        """Return one block and the board's start; short blocks if long ones are damaged."""
        start, self._asked = time.monotonic(), self._most
        try:
            block = self.bench.stream(self._asked)
        except SpoiltError:
            if self._asked == FEW:
                raise
            self._asked = FEW
            block = self.bench.stream(FEW)
        is_slow = self._asked < self._most or time.monotonic() - start > SLOW
        self._most = FEW if is_slow else min(2 * self._most, FULL)
        return block

    def is_behind(self, block: Block) -> bool:
        """Return whether the board had more samples than the block could contain."""
        return len(block.rows) >= self._asked

    def start_recording(self, moves: Moves | None = None) -> None:
        """Record the samples that the board has stored; time counts from the last of them."""
        block = self.record_block(moves)
        while self.is_behind(block):
            self.pause(block)
            block = self.record_block(moves)
        if not self.file.meta.get("begun"):
            self.file.set_meta({"begun": max(self.seq, 0)})
        self.recorded = 0

    def _commit_block(self, block: Block, moves: Any, mono: int, calendar: int) -> None:
        rows, us = block.rows, block.us
        first, last = int(rows["seq"][0]), int(rows["seq"][-1])
        last_number = first - 1 if self._last is None else self._last[0]
        if first > last_number + 1:
            samples = are_text(first - last_number - 1, "sample")
            self.file.add_note("link", f"{samples} missing", int(us[0]))
        rows_ = [
            # None stands for NaN
            [self.boot, seq, us_, *(None if value != value else value for value in columns)]
            for (seq, _, *columns), us_ in zip(rows.tolist(), us.tolist(), strict=True)
        ]
        self.file.add_samples(
            rows_,
            (self.boot or 0, last, int(us[-1]), mono, calendar),
            moves(block) if moves is not None else (),
        )
        self.recorded += max(last - last_number, 0)
        self._last, self.now = (last, int(us[-1])), int(us[-1])

    def _begin_series(self, boot: int) -> None:
        """Start a new series after a restart of the board."""
        if self.boot is not None:
            self.file.add_note("link", f"the board restarted: {boot:08X}")
        boots = self.file.meta.get("boots", "").split()
        if f"{boot:08X}" not in boots:
            self.file.set_meta({"boots": " ".join([*boots, f"{boot:08X}"])})
        self.boot, self._last = boot, self.file.last_sample(boot)

    def _watch_calendar(self, offset: int) -> None:
        """Note a change of the host's calendar time, on which the samples' times do not depend."""
        offset_before, self._calendar = self._calendar, offset
        if offset_before is not None and abs(offset - offset_before) > JUMP:
            direction = "back" if offset < offset_before else "forward"
            seconds = abs(offset - offset_before) / 1e9
            self.file.add_note(
                "note", f"the host's clock was set {direction} by {seconds:.0f} s", self.now
            )

    @contextlib.contextmanager
    def _hold_board(self) -> Iterator[None]:
        """Pause a board at full speed during a write, because its buffer is full after 45 ms."""
        if self._throttle is None:
            yield
            return
        self._throttle.going.clear()
        try:
            yield
        finally:
            self._throttle.going.set()

    def pause(self, block: Block) -> None:
        """Wait for the next block, unless the board already has more samples."""
        if self._throttle is not None:
            self._throttle.credit = 0 if self.is_behind(block) else CREDIT
        elif not self.is_behind(block):
            time.sleep(max(PACE - (time.monotonic() - self._told), 0.0))
        self._told = time.monotonic()


class Throttle:
    """Speed limiter for a virtual board that runs at full speed.

    The board's clock stops unless `going` is set; after `credit` samples, each takes half a
    millisecond.
    """

    def __init__(self) -> None:
        self.going = threading.Event()
        self.going.set()
        self.credit = CREDIT

    def __call__(self) -> None:
        """Wait before each sample."""
        self.going.wait()
        self.credit -= 1
        if self.credit < 0:
            time.sleep(SLOWLY)


def _make_throttle(bench: Bench) -> Throttle | None:
    """Return the throttle of a local board that runs at full speed, or None for any other board."""
    plant = bench.plant
    if plant is None or plant.behind.speed:
        return None
    throttle = Throttle()
    plant.recorded = throttle
    return throttle


def describe_bench(bench: Bench) -> dict[str, object]:
    """Return a run file's entries about a bench and its host."""
    maker, model, serial, firmware = _read_identity(bench)
    user = ""
    with contextlib.suppress(OSError, KeyError, ImportError):
        user = getpass.getuser()
    return {
        "run_id": str(uuid.uuid4()),
        "started_utc": format_utc(),
        "ended_utc": "",
        "outcome": "",
        "simulated": int(bench.simulated),
        "software": f"layerjam {__version__}",
        "firmware": firmware,
        "law_sha256": law_hash(),
        "board": serial,
        "model": f"{maker} {model}",
        "boots": "",
        "begun": "",
        "host": platform.node(),
        "operator": user,
        "safe_state": bench.safe_state or "",
        "vent_rest": bench.vent_rest or "",
        "settings_hex": _ask_or_empty(bench, "CONT:LAW?"),
        "sensor_calibration": _ask_or_empty(bench, "SENS:VAC:CAL?"),
        "zero": _ask_or_empty(bench, "SENS:VAC:ZERO?"),
        "note": "",
    }


def _read_identity(bench: Bench) -> list[str]:
    """Return maker, model, serial number and firmware from `*IDN?`."""
    return ([*bench.identity.split(","), "", "", ""])[:4]


def _ask_or_empty(bench: Bench, query: str) -> str:
    try:
        return bench.ask(query)
    except InstrumentError:
        return ""


def check_board(bench: Bench, file: RunFile) -> None:
    """Raise FileError if a file belongs to a different board."""
    serial, actual = file.meta.get("board", ""), _read_identity(bench)[2]
    if serial != actual:
        raise FileError(file.path, f"comes from board {serial}, but {bench.address} is {actual}")


@accept_force_option
def record_log(
    address: str,
    out: str | Path,
    *,
    duration: float | None = None,
    resume: bool = False,
    overwrite: bool = False,
    patience: float = PATIENCE,
    say: Callable[[str], None] = lambda sentence: None,
) -> Logged:
    """Record a bench that another client commands, for `duration` [s of the board] at most.

    SIGINT and SIGTERM end the log early. A lost connection is retried for `patience` [s]; a board
    other than the first is rejected. Raises FileError if file or bench are not available.
    """
    with Stop() as stop:
        bench = open_bench(address)
        try:
            file = _open_file(bench, Path(out), resume, overwrite)
        except BaseException:
            bench.close()
            raise
        logging = _Log(bench, file, duration, patience, stop, say)
        try:
            outcome, reason = logging.run()
            counts = file.counts()
        except BaseException:
            file.close()
            raise
        finally:
            logging.recorder.bench.close()
        is_simulated = bench.simulated
        file.close(outcome)
    return Logged(
        outcome=outcome,
        reason=reason,
        samples=counts[0],
        gaps=counts[1],
        boots=counts[2],
        file=str(file.path),
        simulated=is_simulated,
    )


def _open_file(bench: Bench, out: Path, resume: bool, overwrite: bool) -> RunFile:
    """Return a new file, or the one to continue."""
    if not resume:
        return RunFile.create(out, {"kind": "log", **describe_bench(bench)}, overwrite)
    file = RunFile.resume(out)
    try:
        check_board(bench, file)
        if file.meta.get("kind") != "log":
            raise FileError(out, "contains a run of a procedure; only a log can be resumed")
        file.add_note("link", "recording continues")
    except BaseException:
        file.close()
        raise
    return file


class _Log:
    def __init__(
        self,
        bench: Bench,
        file: RunFile,
        duration: float | None,
        patience: float,
        stop: Stop,
        say: Callable[[str], None],
    ) -> None:
        self.recorder = Recorder(bench, file)
        self._left = None if duration is None else duration * 1e6 / PERIOD
        self._patience, self._stop, self._say = patience, stop, say

    def run(self) -> tuple[str, str | None]:
        """Return (outcome, reason); the reason is empty after a success."""
        begun = False
        while True:
            try:
                if not begun:
                    self.recorder.start_recording()
                    begun = True
                if self._stop.asked:
                    self.recorder.file.add_note(
                        "note", "stopped by the operator", self.recorder.now
                    )
                    return STOPPED, None
                if self._left is not None and self.recorder.recorded >= self._left:
                    return FINISHED, None
                self.recorder.pause(self.recorder.record_block())
            except RecordingError as error:
                return DISK_FULL, str(error)
            except LineError as error:
                failure = self._reconnect_board(str(error))
                if failure is not None:
                    return failure

    def _reconnect_board(self, reason: str) -> tuple[str, str | None] | None:
        """Try to restore the connection; return None once it works again."""
        recorder = self.recorder
        bench, end = recorder.bench, time.monotonic() + self._patience
        recorder.file.add_note("link", f"connection lost: {reason}", recorder.now)
        self._say(f"{reason}; trying to reconnect for {self._patience:g} s")
        with contextlib.suppress(LayerjamError):
            bench.close()
        if bench.address.simulated:
            return LINE_LOST, reason  # a virtual board ends when its line closes
        while time.monotonic() < end and not self._stop.asked:
            try:
                bench_ = open_bench(bench.address)
            except LayerjamError:
                time.sleep(0.2)
                continue
            try:
                check_board(bench_, recorder.file)
            except BaseException:
                bench_.close()
                raise
            recorder.bench, recorder._heard = bench_, 0
            recorder.file.add_note("link", "the connection is restored", recorder.now)
            self._say("the connection is restored")
            return None
        return LINE_LOST, reason
