"""Hours without a fault on a virtual board: random targets, releases and holds, no sample lost."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from layerjam.control.settings import Regulator, validate
from layerjam.errors import QuantityError
from layerjam.rig.address import VIRTUAL, Address
from layerjam.rig.board import VirtualBoard, connect
from layerjam.rig.campaign import LONG_LEASE, accelerate
from layerjam.rig.driver import Bench
from layerjam.rig.link import SESSION, BoardLink
from layerjam.rig.observer import highest_target
from layerjam.rig.outcomes import Soaked
from layerjam.rig.telemetry import records

PERIOD = 10_000
"""Between two samples [us]."""
LOWEST = 0.05
"""Least target, as a share of what the pump reaches."""
HOLDS = (2.0, 120.0)
"""Shortest and longest time [s] at one target."""
RELEASES = 0.25
"""Share of the orders that release."""
WARM = 60.0
"""Time [s] of the board before its memory is looked at first."""
LOOKS = 2
"""Readings of the memory, of which the least counts."""
BLOCK = 200
"""Records taken at once."""
HELD_BACK = ((950, 5e-3), (500, 1e-3))
"""So many records that wait in the board's ring hold each sample back by so many seconds."""
PAUSE = 4e-3
"""Seconds until a block is worth taking."""


class Log:
    """Takes the board's records and looks whether any is missing."""

    def __init__(self, board: VirtualBoard) -> None:
        self.board = board
        self.seq = self.cleared = -1
        """Last record taken, and the last before which faults are known."""
        self.micros = 0
        self.gaps = 0

    def hold(self) -> None:
        """In the plant's thread: samples come no faster than their records are taken."""
        plant = self.board.plant
        waiting = plant.asked - self.seq
        plant.pace = next((pause for count, pause in HELD_BACK if waiting > count), 0.0)

    def take(self) -> bool:
        """One block, the one before acknowledged; whether it says a fault not known yet."""
        line = self.board.line
        given_up = b"STR:ACK %d;:" % self.seq if self.seq >= 0 else b""
        said = line.ask(SESSION, given_up + b"FETC:STR? %d" % BLOCK)
        if not said:  # the ring went on without us
            said = line.ask(SESSION, b"*CLS;:FETC:STR? %d" % BLOCK)
        rows = records(said)
        if not len(rows):
            return False
        self.look(rows["seq"].astype(np.int64), rows["board_us"].astype(np.int64))
        if len(rows) < BLOCK // 2:
            time.sleep(PAUSE)
        return bool(np.any(rows["fault"][rows["seq"] > self.cleared]))

    def look(self, seqs: np.ndarray, micros: np.ndarray) -> None:  # type: ignore[type-arg]
        """Count what does not follow on what was before."""
        if self.seq >= 0:
            seqs = np.concatenate(([self.seq], seqs))
            micros = np.concatenate(([self.micros], micros))
        even = (np.diff(seqs) == 1) & (np.diff(micros) % (1 << 32) == PERIOD)
        self.gaps += int(np.count_nonzero(~even))
        self.seq, self.micros = int(seqs[-1]), int(micros[-1])


def soak(
    address: str | Address = VIRTUAL,
    *,
    kind: str = "pi",
    hours: float = 24.0,
    seed: int = 0,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Soaked:
    """So many hours of the board's own time under one regulator, in which nothing may happen.

    Stopped from the keyboard, it gives what was seen until then. Raises QuantityError for an
    address that is no virtual board, FileError and LineError.
    """
    where = accelerate(address)
    line, board = connect(where)
    if board is None:
        raise QuantityError.of("address", f"{where} is no virtual board")
    with Bench(BoardLink(line, board), where) as bench:
        highest = _ready(bench, board, kind)
        done = _soaked(bench, board, highest, hours * 3600.0, random.Random(seed), progress)
        return Soaked(address=str(address), kind=kind, **done)


def _ready(bench: Bench, board: VirtualBoard, kind: str) -> float:
    """Give the board its regulator; the highest target [Pa]."""
    made = board.plant.behind
    safe = "release" if made.normally_open else "hold"
    regulator = Regulator(plant=made.plant, sensor=made.sensor, kind=kind, safe_state=safe)
    highest = highest_target(made.plant, made.sensor)
    validate(regulator, highest)
    bench.safe_state = safe
    bench.vent_rest = "open" if made.normally_open else "closed"
    bench.regulator = regulator
    bench.lease = LONG_LEASE
    return highest


def _soaked(
    bench: Bench,
    board: VirtualBoard,
    highest: float,
    lasting: float,
    draw: random.Random,
    progress: Callable[[str, float], None],
) -> dict[str, Any]:
    plant, log = board.plant, Log(board)
    plant.watch = log.hold
    faults: list[str] = []
    begun, orders, complete = plant.time, 0, True
    due, first = begun, None
    try:
        bench.output = True
        while (passed := plant.time - begun) < lasting:
            if log.take():
                _cleared(bench, log, faults)
                bench.output = True
            if first is None and passed >= min(WARM, lasting / 2):
                first = _used(bench, log, faults)
                bench.output = True
            if plant.time >= due:
                progress("hours", passed / lasting)
                releases = draw.random() < RELEASES
                target = 0.0 if releases else draw.uniform(LOWEST, 1.0) * highest
                bench.target = target
                due, orders = plant.time + draw.uniform(*HOLDS), orders + 1
    except KeyboardInterrupt:
        complete = False
    lasted = plant.time - begun
    timing = bench.ask("SYST:TIM?").split(",")
    last = _used(bench, log, faults)
    return {
        "board": board.name,
        "hours": lasted / 3600.0,
        "ticks": int(timing[0]),
        "orders": orders,
        "false_faults": len(faults),
        "faults": tuple(faults),
        "gaps": log.gaps,
        "wraps": plant.wraps,
        "heap_growth": None if first is None or last is None else last - first,
        "late_ticks": int(timing[1]),
        "complete": complete,
    }


def _cleared(bench: Bench, log: Log, faults: list[str]) -> None:
    name = bench.fault
    if name is not None:
        faults.append(name)
        bench.clear()
        log.cleared = log.board.plant.asked


def _used(bench: Bench, log: Log, faults: list[str]) -> int | None:
    """Bytes in use on the board, its law as at power-up; None where nobody counts them."""
    bench.off()
    _cleared(bench, log, faults)
    bench.tell("VAC 0;:OUTP ON;:OUTP OFF")
    seen = [float(bench.ask("SYST:MEM?").split(",")[0]) for _ in range(LOOKS)]
    return None if min(seen) > 1e30 else int(min(seen))
