"""Faults by the hundred on a virtual board: safe in time, and called by their names.

Whether the outputs are safe is taken from the plant's log of what it was commanded, never from what
the firmware says of itself. The board's clock is the plant's, as fast as samples are computed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

from layerjam.control.settings import validate
from layerjam.errors import QuantityError, UnknownNameError
from layerjam.rig.address import VIRTUAL, Address, address_of
from layerjam.rig.board import VirtualBoard, connect
from layerjam.rig.driver import Bench
from layerjam.rig.kinds import KINDS, NOT_HERE
from layerjam.rig.line import LineError
from layerjam.rig.link import SESSION, BoardLink
from layerjam.rig.observer import Observer, Plan, drawn
from layerjam.rig.plant import behind
from layerjam.rig.telemetry import records

EMPTY = 50.0
"""Vacuum [Pa] below which a run may begin."""
LONG_LEASE = 600.0
FLOOD = 2000
"""Questions of a host that reads no answer: they fill the pipe and the board's 4 kB."""
VENTS, VENT_WINDOW = 3, 60.0
"""Openings of the vent within a time [s] that make the board doubt its sensor (QUES bit 10)."""
CLOCK = 2e-6
"""What two times [s] may differ by: the board's clock counts microseconds."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One fault, and what became of it; times [s] from the event."""

    plan: Plan
    onset: float | None
    """From the pump's first run to the fault; None where its moment did not come."""
    named: str | None
    safe_after: float | None
    named_after: float | None
    """Only where the outputs are safe before it has a name."""
    deadline: float | None
    vacuum_after: float
    doubted_after: float | None
    """Until the third opening of the vent within a minute."""
    lost_after: float | None
    """Until a tenth of the target was missing; at once where it had not been reached."""
    trouble: str = ""
    """What kept the run from its end."""

    @property
    def met(self) -> bool:
        """Whether what was promised came true; with no deadline, nothing was."""
        if self.deadline is None:
            return not self.trouble
        if not self.plan.kind.called(self.named, self.plan.case) or self.safe_after is None:
            return False
        took = max(self.safe_after, self.named_after or 0.0)
        return took <= self.deadline + CLOCK

    @property
    def share(self) -> float:
        """Of its deadline that it took; what is worst is greatest."""
        took = max(self.safe_after or 0.0, self.named_after or 0.0)
        if self.deadline is None:
            return took
        return took / self.deadline if self.met else math.inf


@dataclass(frozen=True)
class Campaign:
    """All runs, and whether somebody stopped it before its end."""

    trials: tuple[Trial, ...]
    stopped: bool
    board: str
    """What ran the firmware."""


def wanted(only: Sequence[str]) -> list[str]:
    """Names of the faults to try, all without any; UnknownNameError for another."""
    for name in only:
        if name not in KINDS and name not in NOT_HERE:
            raise UnknownNameError("fault", name, [*KINDS, *NOT_HERE], quantity="only")
    return [name for name in KINDS if name in only or not only]


def accelerated(text: str | Address) -> Address:
    """The address of a virtual board, as fast as it can unless it says how fast."""
    where = address_of(text)
    if not where.simulated:
        raise QuantityError.of(
            "address",
            f"'{where}' is no virtual board; faults are put into a simulated line, 'sim:LINE'",
        )
    return replace(where, options={"speed": "0", **where.options})


class Bed:
    """A virtual board for one run after the other; a new one where the last does not answer."""

    def __init__(self, address: Address) -> None:
        self.address = address
        self.behind = behind(address)
        self._bench: Bench | None = None
        self.board: VirtualBoard | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.drop()

    def drop(self) -> None:
        """End the board."""
        if self._bench is not None:
            self._bench.close()
        self._bench = self.board = None

    def bench(self) -> tuple[Bench, VirtualBoard]:
        """The board, started where there is none."""
        if self._bench is None or self.board is None:
            line, board = connect(self.address)
            if board is None:
                raise QuantityError.of("address", f"{self.address} is no virtual board")
            self._bench, self.board = Bench(BoardLink(line, board), self.address), board
            opens = self.behind.normally_open
            self._bench.safe_state = "release" if opens else "hold"
            self._bench.vent_rest = "open" if opens else "closed"
        return self._bench, self.board

    def begin(self, plan: Plan) -> tuple[Bench, VirtualBoard, Observer]:
        """A sound line, empty, its regulator on the board, and the pump running."""
        bench, board = self.bench()
        plant = board.plant
        plant.heal()
        bench.off()
        bench.clear()
        plant.behind = plan.behind
        while plant.vacuum > EMPTY:  # a valve that rests closed keeps it
            plant.vacuum = plant.side = plant.shown = 0.0
            time.sleep(1e-3)
        bench.lease = LONG_LEASE
        bench.regulator = plan.case.regulator
        plant.watch = observer = Observer(plant, plan)
        bench.tell(f"VAC {plan.case.target:.17g};:OUTP ON")
        return bench, board, observer


def tried(bed: Bed, plan: Plan) -> Trial:
    """One run of one fault."""
    validate(plan.case.regulator, plan.case.target)
    observer: Observer | None = None
    named = named_after = None
    trouble = ""
    try:
        bench, board, observer = bed.begin(plan)
        seq = _through(bench, board, observer)
        named = bench.fault
        if seq is not None and plan.kind.host == "releases":
            named_after = _named_after(board, observer, seq)
        if observer.struck is None:
            trouble = "its moment did not come"
    except LineError as error:
        trouble = str(error)
        bed.drop()
    deadline = plan.kind.deadline(plan.case)
    seen = observer is not None and observer.struck is not None and observer.began is not None
    return Trial(
        plan=plan,
        onset=observer.struck - observer.began if seen else None,  # type: ignore[union-attr,operator]
        named=named,
        # outputs that no fault latched are safe by chance
        safe_after=observer.safe_after if observer and named else None,
        named_after=named_after,
        deadline=deadline if math.isfinite(deadline) else None,
        vacuum_after=observer.vacuum if observer else math.nan,
        doubted_after=observer.openings(VENTS, VENT_WINDOW) if observer else None,
        lost_after=_after(observer.lost, observer.event) if observer else None,
        trouble=trouble,
    )


def _after(time: float | None, event: float | None) -> float | None:
    """Time [s] from an event, None where one of both did not come."""
    return None if time is None or event is None else time - event


def _through(bench: Bench, board: VirtualBoard, observer: Observer) -> int | None:
    """Talk until the fault begins, do the host's part in it, and wait for the end.

    The board's sample at which it took the host's last word.
    """
    host, plant, case = observer.plan.kind.host, board.plant, observer.plan.case
    while not observer.done.is_set() and (host == "talks" or observer.struck is None):
        bench.ask("*OPC?")
        observer.done.wait(0.01)
    if observer.struck is None or host == "talks":
        return None
    line = board.line
    if host == "deaf":
        for count in range(FLOOD):
            lease = "" if count else f"SYST:LEAS {case.lease};:"
            line.send(SESSION, f"{lease}FETC:ALL?".encode())
        plant.pace = 0.0
        _until_done(observer)
        ran = [said for said in line.heard() if b",RUN," in said]
        last = ran[-1] if ran else b""
    else:
        said = "VAC 0" if host == "releases" else f"SYST:LEAS {case.lease}"
        last = line.ask(SESSION, f"{said};:FETC:ALL?".encode())
        if host == "silent":
            plant.pace = 0.0
    if not last:
        return None
    seq = int(last.split(b",")[0])
    observer.event = observer.time_of(seq)
    _until_done(observer)
    return seq


def _until_done(observer: Observer) -> None:
    """Wait for the plant, which goes on as long as the board takes samples."""
    asked = -1
    while not observer.done.wait(5.0):
        if observer.plant.asked == asked:
            raise LineError("the board takes no more samples")
        asked = observer.plant.asked


def _named_after(board: VirtualBoard, observer: Observer, seq: int) -> float:
    """Time [s] from the event to the first record with a fault, infinite where none is found."""
    line, event = board.line, observer.event
    line.ask(SESSION, b"STR:ACK %d" % max(seq - 1, 0))
    while event is not None:
        found = records(line.ask(SESSION, b"FETC:STR? 200"))
        named = found[found["fault"] != 0]
        if len(named):
            at = observer.time_of(int(named["seq"][0]))
            return math.inf if at is None else at - event
        if not len(found) or observer.time_of(int(found["seq"][-1])) is None:
            break
        line.ask(SESSION, b"STR:ACK %d" % int(found["seq"][-1]))
    return math.inf


def campaign(
    address: str | Address = VIRTUAL,
    *,
    only: Sequence[str] = (),
    runs: int = 10,
    seed: int = 0,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Campaign:
    """Every fault so many times, each with its own line, regulator, target and moment.

    Stopped from the keyboard, it gives what was run until then. Raises UnknownNameError,
    QuantityError for an address that is no virtual board, FileError and LineError.
    """
    names = wanted(only)
    made: list[Trial] = []
    stopped, board = False, ""
    with Bed(accelerated(address)) as bed:
        board = bed.bench()[1].name
        try:
            for number in range(runs):
                for name in names:
                    progress("faults", len(made) / (runs * len(names)))
                    made.append(tried(bed, drawn(bed.behind, name, number, seed)))
        except KeyboardInterrupt:
            stopped = True
    return Campaign(tuple(made), stopped, board)
