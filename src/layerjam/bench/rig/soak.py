"""Soak test of a virtual board: random targets, releases and holds, with no sample lost."""

import random
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from layerjam.bench.control.settings import Regulator, validate
from layerjam.bench.rig.address import VIRTUAL, Address
from layerjam.bench.rig.board import VirtualBoard, connect
from layerjam.bench.rig.campaign import LONG_LEASE, set_full_speed
from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.link import SESSION, BoardLink
from layerjam.bench.rig.observer import highest_target
from layerjam.bench.rig.outcomes import Soaked
from layerjam.bench.rig.telemetry import parse_records
from layerjam.core.errors import QuantityError

PERIOD = 10_000
"""Time between two samples [us]."""
LOWEST = 0.05
"""Lowest target, as a fraction of the pump's highest vacuum."""
HOLDS = (2.0, 120.0)
"""Shortest and longest time [s] at one target."""
RELEASES = 0.25
"""Fraction of the commands that release the vacuum."""
WARM = 60.0
"""Board time [s] after which its memory use is first read."""
VENTED = 5.0
"""Time [s] before the first command, in which the board records the zero of its sensor."""
LOOKS = 6
"""Number of readings of memory use, of which the smallest is used."""
ROUNDS = 5
"""Maximum number of rounds of these readings at the end. MicroPython's collector keeps a block if
an old word on its stack seems to point to it; a real leak shows in every reading.
"""
BLOCK = 200
"""Number of records fetched at a time."""
HELD_BACK = ((950, 5e-3), (500, 1e-3))
"""Pairs of records waiting in the board's ring, and the resulting delay of each sample [s]."""
PAUSE = 4e-3
"""Pause [s] after a fetch that did not fill a block."""


class Log:
    """Log of the board's records that detects missing ones."""

    def __init__(self, board: VirtualBoard) -> None:
        self.board = board
        self.seq = self.cleared = -1
        """Number of the last record read, and of the last record whose fault has been counted."""
        self.micros = 0
        self.gaps = 0

    def set_pace(self) -> None:
        """Delay the samples, in the plant's thread, to the rate at which their records are read."""
        plant = self.board.plant
        waiting = plant.asked - self.seq
        plant.pace = next((pause for count, pause in HELD_BACK if waiting > count), 0.0)

    def read_block(self) -> bool:
        """Read one block and acknowledge the previous one; return whether there is a new fault."""
        line = self.board.line
        given_up = b"STR:ACK %d;:" % self.seq if self.seq >= 0 else b""
        response = line.ask(SESSION, given_up + b"FETC:STR? %d" % BLOCK)
        if not response:  # records in the ring have been overwritten
            response = line.ask(SESSION, b"*CLS;:FETC:STR? %d" % BLOCK)
        rows = parse_records(response)
        if not len(rows):
            return False
        self.count_gaps(rows["seq"].astype(np.int64), rows["board_us"].astype(np.int64))
        if len(rows) < BLOCK // 2:
            time.sleep(PAUSE)
        return bool(np.any(rows["fault"][rows["seq"] > self.cleared]))

    def count_gaps(self, seqs: np.ndarray, micros: np.ndarray) -> None:  # type: ignore[type-arg]
        """Count the gaps between samples."""
        if self.seq >= 0:
            seqs = np.concatenate(([self.seq], seqs))
            micros = np.concatenate(([self.micros], micros))
        is_regular = (np.diff(seqs) == 1) & (np.diff(micros) % (1 << 32) == PERIOD)
        self.gaps += int(np.count_nonzero(~is_regular))
        self.seq, self.micros = int(seqs[-1]), int(micros[-1])


def soak(
    address: str | Address = VIRTUAL,
    *,
    kind: str = "pi",
    hours: float = 24.0,
    seed: int = 0,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Soaked:
    """Run a virtual board for hours of its own time under one controller; expect no fault.

    Raises QuantityError for an address that is not a virtual board, FileError and LineError.
    """
    target = set_full_speed(address)
    line, board = connect(target)
    if board is None:
        raise QuantityError.of("address", f"{target} is not a virtual board")
    with Bench(BoardLink(line, board), target) as bench:
        highest = _prepare_bench(bench, board, kind)
        results = _run_board(bench, board, highest, hours * 3600.0, random.Random(seed), progress)
        return Soaked(address=str(address), kind=kind, **results)


def _prepare_bench(bench: Bench, board: VirtualBoard, kind: str) -> float:
    """Set the board's controller; return the highest target [Pa]."""
    hardware = board.plant.behind
    safe_state = "release" if hardware.normally_open else "hold"
    regulator = Regulator(
        plant=hardware.plant, sensor=hardware.sensor, kind=kind, safe_state=safe_state
    )
    highest = highest_target(hardware.plant, hardware.sensor)
    validate(regulator, highest)
    bench.safe_state = safe_state
    bench.vent_rest = "open" if hardware.normally_open else "closed"
    bench.regulator = regulator
    bench.lease = LONG_LEASE
    return highest


def _run_board(
    bench: Bench,
    board: VirtualBoard,
    highest: float,
    lasting: float,
    draw: random.Random,
    progress: Callable[[str, float], None],
) -> dict[str, Any]:
    plant, log = board.plant, Log(board)
    plant.watch = log.set_pace
    faults: list[str] = []
    start, orders = plant.time, 0
    vent_end, first = start + VENTED, None
    bench.output = True
    while (elapsed_time := plant.time - start) < lasting:
        if log.read_block():
            _clear_fault(bench, log, faults)
            bench.output = True
        if first is None and elapsed_time >= min(WARM, lasting / 2):
            first = _read_used_memory(bench, log, faults)
            bench.output = True
        if plant.time >= vent_end:
            progress("hours", elapsed_time / lasting)
            releases = draw.random() < RELEASES
            target = 0.0 if releases else draw.uniform(LOWEST, 1.0) * highest
            bench.target = target
            vent_end, orders = plant.time + draw.uniform(*HOLDS), orders + 1
    duration_ = plant.time - start
    timing = bench.ask("SYST:TIM?").split(",")
    last = _read_used_memory(bench, log, faults)
    for _ in range(ROUNDS - 1):
        if first is not None and last is not None and last > first:
            last = _read_used_memory(bench, log, faults)
    return {
        "board": board.name,
        "hours": duration_ / 3600.0,
        "ticks": int(timing[0]),
        "orders": orders,
        "false_faults": len(faults),
        "faults": tuple(faults),
        "gaps": log.gaps,
        "wraps": plant.wraps,
        "heap_growth": None if first is None or last is None else last - first,
        "late_ticks": int(timing[1]),
        "complete": True,
    }


def _clear_fault(bench: Bench, log: Log, faults: list[str]) -> None:
    name = bench.fault
    if name is not None:
        faults.append(name)
        bench.clear()
        log.cleared = log.board.plant.asked


def _read_used_memory(bench: Bench, log: Log, faults: list[str]) -> int | None:
    """Return the bytes in use on the board with the law as at power-up; None if unknown."""
    bench.off()
    _clear_fault(bench, log, faults)
    bench.tell("VAC 0;:OUTP ON;:OUTP OFF")
    readings = [float(bench.ask("SYST:MEM?").split(",")[0]) for _ in range(LOOKS)]
    return None if min(readings) > 1e30 else int(min(readings))
