"""Samples from a board into a run file: fetched, committed, and only then acknowledged.

So a board gives every sample at least once, and the file holds it exactly once, by the number of
the board's start and its own. A killed recorder loses nothing that was acknowledged, and what was
not the board still has, for ten seconds.
"""

from __future__ import annotations

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
from layerjam.errors import FileError, LayerjamError
from layerjam.rig.board import law_hash
from layerjam.rig.driver import Bench, InstrumentError, open_bench
from layerjam.rig.line import LineError, SpoiltError
from layerjam.rig.outcomes import Logged
from layerjam.rig.run_file import RecordingError, RunFile, utc
from layerjam.rig.stop import Stop
from layerjam.rig.telemetry import PERIOD, unwrapped

PACE = 0.05
"""Seconds of the host between two blocks."""
FULL = 200
"""Records in one block at most."""
FEW = 25
"""Records in a block behind a line on which longer ones are spoilt."""
SLOW = 0.1
"""Seconds of the host for one block after which the next is shorter."""
AHEAD = 300
"""Samples that a board as fast as it can makes before it waits for its recorder."""
SLOWLY = 0.0005
PATIENCE = 60.0
"""Seconds for which a log looks for a line that is down."""
JUMP = 1_000_000_000
"""Nanoseconds by which the host's calendar must run off its own clock to be said."""
FINISHED, STOPPED = "FINISHED", "OPERATOR_STOPPED"
LINE_LOST, DISK_FULL = "LINE_LOST", "DISK_FULL"


@dataclass(frozen=True, eq=False)
class Block:
    """Samples that are on disk: records as the board sends them, with `us` that does not wrap."""

    rows: np.ndarray[Any, Any]
    us: np.ndarray[Any, Any]


Moves = Callable[[Block], list[tuple[int, float, float]]]
"""Rows of a crosshead that belong to a block: board's clock [us], elongation [m], force [N]."""


class Recorder:
    """One board into one file; `pump` is to be called every 50 ms or so.

    `clocks` gives the host's (monotonic ns, calendar ns).
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
        """Samples since this recorder began, those counted that are missing."""
        self._clocks = clocks
        self._calendar: int | None = None
        self._last: tuple[int, int] | None = None
        self._told, self._heard = 0.0, 0
        self._asked = self._most = FULL
        self._throttle = _throttle(bench)

    @property
    def seq(self) -> int:
        """Number of the last sample, -1 before there is one."""
        return -1 if self._last is None else self._last[0]

    def pump(self, moves: Moves | None = None) -> Block:
        """One block: fetched, on disk, acknowledged.

        `moves` gives the crosshead's rows that belong to it. Raises
        LineError, or RecordingError where the disk takes no more: then nothing is acknowledged.
        """
        rows, boot = self._fetched()
        mono, calendar = self._clocks()
        for text in self.bench.events[self._heard :]:
            self.file.note("error", text, self.now)
        self._heard = len(self.bench.events)
        with self._standing():
            if boot != self.boot:
                self._begin(boot)
            self._watch_calendar(calendar - mono)
            us = unwrapped(rows["board_us"], rows["seq"], self._last)
            block = Block(rows, us)
            if len(rows):
                self._commit(block, moves, mono, calendar)
        if len(rows):
            try:
                self.bench.acknowledge(self.seq)
            except InstrumentError as error:
                if error.code != -222:
                    raise
                text = "the board holds them no more: a reset, or another recorder beside this one"
                self.file.note("link", text, self.now)
        return block

    def _fetched(self) -> tuple[np.ndarray[Any, Any], int]:
        """One block and the board's start; long ones only where the line brings them unspoilt."""
        begun, self._asked = time.monotonic(), self._most
        try:
            got = self.bench.stream(self._asked)
        except SpoiltError:
            if self._asked == FEW:
                raise
            self._asked = FEW
            got = self.bench.stream(FEW)
        slow = self._asked < self._most or time.monotonic() - begun > SLOW
        self._most = FEW if slow else min(2 * self._most, FULL)
        return got

    def behind(self, block: Block) -> bool:
        """Whether the board had more samples than came with a block."""
        return len(block.rows) >= self._asked

    def begin(self, moves: Moves | None = None) -> None:
        """Record what the board still has from before; time counts from the last of it on."""
        block = self.pump(moves)
        while self.behind(block):
            self.pause(block)
            block = self.pump(moves)
        if not self.file.meta.get("begun"):
            self.file.state({"begun": max(self.seq, 0)})
        self.recorded = 0

    def _commit(self, block: Block, moves: Any, mono: int, calendar: int) -> None:
        rows, us = block.rows, block.us
        first, last = int(rows["seq"][0]), int(rows["seq"][-1])
        before = first - 1 if self._last is None else self._last[0]
        if first > before + 1:
            self.file.note("link", f"{first - before - 1} samples are missing", int(us[0]))
        listed = [[self.boot, seq, at, *rest] for seq, at, rest in _rows(rows, us)]
        self.file.add(
            listed,
            (self.boot or 0, last, int(us[-1]), mono, calendar),
            moves(block) if moves is not None else (),
        )
        self.recorded += max(last - before, 0)
        self._last, self.now = (last, int(us[-1])), int(us[-1])

    def _begin(self, boot: int) -> None:
        """Another start of the board than the last one."""
        if self.boot is not None:
            self.file.note("link", f"the board started anew: {boot:08X}")
        known = self.file.meta.get("boots", "").split()
        if f"{boot:08X}" not in known:
            self.file.state({"boots": " ".join([*known, f"{boot:08X}"])})
        self.boot, self._last = boot, self.file.last(boot)

    def _watch_calendar(self, ahead: int) -> None:
        """Say where the host's calendar was set; the samples' time does not depend on it."""
        was, self._calendar = self._calendar, ahead
        if was is not None and abs(ahead - was) > JUMP:
            back = "back" if ahead < was else "forward"
            seconds = abs(ahead - was) / 1e9
            self.file.note("note", f"the host's clock was set {back} by {seconds:.0f} s", self.now)

    @contextlib.contextmanager
    def _standing(self) -> Iterator[None]:
        """A board that is as fast as it can waits for the disk: its ring is full in 45 ms."""
        if self._throttle is None:
            yield
            return
        self._throttle.going.clear()
        try:
            yield
        finally:
            self._throttle.going.set()

    def pause(self, block: Block) -> None:
        """Wait until the next block is due; not at all behind a board that is ahead."""
        if self._throttle is not None:
            self._throttle.credit = 0 if self.behind(block) else AHEAD
        elif not self.behind(block):
            time.sleep(max(PACE - (time.monotonic() - self._told), 0.0))
        self._told = time.monotonic()


class Throttle:
    """Keeps back a virtual board that runs as fast as it can.

    While `going` is not set its clock stands; after `credit` samples each takes half a millisecond.
    """

    def __init__(self) -> None:
        self.going = threading.Event()
        self.going.set()
        self.credit = AHEAD

    def __call__(self) -> None:
        """Called before each sample."""
        self.going.wait()
        self.credit -= 1
        if self.credit < 0:
            time.sleep(SLOWLY)


def _throttle(bench: Bench) -> Throttle | None:
    """Of a board that runs as fast as it can, here; None for any other."""
    plant = bench.plant
    if plant is None or plant.behind.speed:
        return None
    made = Throttle()
    plant.recorded = made
    return made


def _rows(rows: np.ndarray[Any, Any], us: np.ndarray[Any, Any]) -> Iterator[tuple[int, int, Any]]:
    """(seq, unwrapped us, the rest of the columns) as SQLite takes them, None for NaN."""
    for record, at in zip(rows.tolist(), us.tolist(), strict=True):
        seq, _, *rest = record
        yield seq, at, [None if value != value else value for value in rest]


def described(bench: Bench) -> dict[str, object]:
    """What a run file says of its bench and of its host."""
    maker, model, serial, firmware = _identity(bench)
    user = ""
    with contextlib.suppress(OSError, KeyError, ImportError):
        user = getpass.getuser()
    return {
        "run_id": str(uuid.uuid4()),
        "started_utc": utc(),
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
        "settings_hex": _said(bench, "CONT:LAW?"),
        "sensor_calibration": _said(bench, "SENS:VAC:CAL?"),
        "zero": _said(bench, "SENS:VAC:ZERO?"),
        "note": "",
    }


def _identity(bench: Bench) -> list[str]:
    """Maker, model, serial number and firmware, as `*IDN?` says them."""
    return ([*bench.identity.split(","), "", "", ""])[:4]


def _said(bench: Bench, query: str) -> str:
    """The board's answer, "" where it has none."""
    try:
        return bench.ask(query)
    except InstrumentError:
        return ""


def check_board(bench: Bench, file: RunFile) -> None:
    """Raise FileError where a file is of another board than this one."""
    serial, said = file.meta.get("board", ""), _identity(bench)[2]
    if serial != said:
        raise FileError(file.path, f"is of the board {serial}, and {bench.address} is {said}")


def log(
    address: str,
    out: str | Path,
    *,
    duration: float | None = None,
    resume: bool = False,
    force: bool = False,
    patience: float = PATIENCE,
    say: Callable[[str], None] = lambda sentence: None,
) -> Logged:
    """Record a bench that somebody else commands, until `duration` [s of the board] or a signal.

    SIGINT and SIGTERM end it. A line that is down is looked for again, `patience` [s] long; another
    board there is refused. Raises FileError for a file or a bench that cannot be had.
    """
    with Stop() as stop:
        bench = open_bench(address)
        try:
            file = _file(bench, Path(out), resume, force)
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
        simulated = bench.simulated
        file.close(outcome)
    return Logged(
        outcome=outcome,
        reason=reason,
        samples=counts[0],
        gaps=counts[1],
        boots=counts[2],
        file=str(file.path),
        simulated=simulated,
    )


def _file(bench: Bench, out: Path, resume: bool, force: bool) -> RunFile:
    """A new file, or the one to go on with."""
    if not resume:
        return RunFile.create(out, {"kind": "log", **described(bench)}, force)
    file = RunFile.resume(out)
    try:
        check_board(bench, file)
        if file.meta.get("kind") != "log":
            raise FileError(out, "is a run of a procedure, and only a log can go on")
        file.note("link", "recording goes on")
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
        """(outcome, why where it is no good one)."""
        begun = False
        while True:
            try:
                if not begun:
                    self.recorder.begin()
                    begun = True
                if self._stop.asked:
                    self.recorder.file.note("note", "stopped by the operator", self.recorder.now)
                    return STOPPED, None
                if self._left is not None and self.recorder.recorded >= self._left:
                    return FINISHED, None
                self.recorder.pause(self.recorder.pump())
            except RecordingError as error:
                return DISK_FULL, str(error)
            except LineError as error:
                lost = self._again(str(error))
                if lost is not None:
                    return lost

    def _again(self, why: str) -> tuple[str, str | None] | None:
        """Look for the line; None once it is there again."""
        recorder = self.recorder
        bench, end = recorder.bench, time.monotonic() + self._patience
        recorder.file.note("link", f"the line is lost: {why}", recorder.now)
        self._say(f"{why}; looking for it for {self._patience:g} s")
        with contextlib.suppress(LayerjamError):
            bench.close()
        if bench.address.simulated:
            return LINE_LOST, why  # a virtual board ends with its line
        while time.monotonic() < end and not self._stop.asked:
            try:
                found = open_bench(bench.address)
            except LayerjamError:
                time.sleep(0.2)
                continue
            try:
                check_board(found, recorder.file)
            except BaseException:
                found.close()
                raise
            recorder.bench, recorder._heard = found, 0
            recorder.file.note("link", "the line is there again", recorder.now)
            self._say("the line is there again")
            return None
        return LINE_LOST, why
