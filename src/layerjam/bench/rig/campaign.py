"""Fault injection on a virtual board: time to safe outputs, and correct fault names.

Whether the outputs are safe is judged from the plant's log of commands, never from the firmware's
own report. The board's clock advances with the plant, as fast as samples are computed.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

from layerjam.bench.control.settings import validate
from layerjam.bench.rig.address import VIRTUAL, Address, address_of
from layerjam.bench.rig.board import VirtualBoard, connect
from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.kinds import KINDS, NOT_HERE, NOTHING
from layerjam.bench.rig.line import LineError
from layerjam.bench.rig.link import SESSION, BoardLink
from layerjam.bench.rig.observer import Observer, Plan, draw_plan
from layerjam.bench.rig.telemetry import parse_records
from layerjam.bench.rig.virtual_plant import read_hardware
from layerjam.core.brief import brief
from layerjam.core.errors import QuantityError, UnknownNameError

EMPTY = 50.0
"""Vacuum [Pa] below which a run may start."""
LONG_LEASE = 600.0
FLOOD = 2000
"""Number of queries from a host that never reads: their responses fill the pipe and the buffer."""
VENTS, VENT_WINDOW = 3, 60.0
"""Number of vent openings within a time [s] after which the board suspects its sensor."""
HEALTHY_RUNS = 10
"""Number of fault-free runs in each round, which contains one run of every fault."""
CLOCK = 2e-6
"""Tolerance when two times are compared [s]: the board's clock counts whole microseconds."""


@brief
@dataclass(frozen=True, kw_only=True)
class Trial:
    """One injected fault and its result; times [s] count from the event."""

    plan: Plan
    onset: float | None
    """Time from the first start of the pump to the fault, or None if the fault did not occur."""
    named: str | None
    safe_after: float | None
    named_after: float | None
    """Time until a record names the fault; set only if the outputs were already safe by then."""
    deadline: float | None
    vacuum_after: float
    doubted_after: float | None
    """Time until the vent has opened three times within a minute."""
    lost_after: float | None
    """Time until a tenth of the target vacuum was lost; 0 if the target had not been reached."""
    trouble: str = ""
    """Reason why the run did not finish, or ""."""

    @property
    def is_met(self) -> bool:
        """Whether the deadline was met; without a deadline, whether the run finished."""
        if self.deadline is None:
            return not self.trouble
        if not self.plan.kind.accepts_name(self.named, self.plan.case) or self.safe_after is None:
            return False
        took = max(self.safe_after, self.named_after or 0.0)
        return took <= self.deadline + CLOCK

    @property
    def deadline_ratio(self) -> float:
        """Return the ratio of the time to its deadline; the largest ratio is the worst."""
        took = max(self.safe_after or 0.0, self.named_after or 0.0)
        if self.deadline is None:
            return took
        return took / self.deadline if self.is_met else math.inf


@dataclass(frozen=True)
class Campaign:
    """All runs."""

    trials: tuple[Trial, ...]
    board: str
    """Platform of the firmware."""


def select_faults(names_wanted: Sequence[str]) -> list[str]:
    """Return the names of the faults to inject, all by default; raises UnknownNameError."""
    for name in names_wanted:
        if name not in KINDS and name not in NOT_HERE:
            raise UnknownNameError("fault", name, [*KINDS, *NOT_HERE], quantity="only")
    return [name for name in KINDS if name in names_wanted or not names_wanted]


def set_full_speed(text: str | Address) -> Address:
    """Return the address of a virtual board, at full speed unless the text states a speed."""
    target = address_of(text)
    if not target.simulated:
        raise QuantityError.of(
            "address",
            f"'{target}' is not a virtual board; inject faults into a simulated line, 'sim:LINE'",
        )
    return replace(target, options={"speed": "0", **target.options})


class Bed:
    """A virtual board for successive runs, replaced if it stops responding."""

    def __init__(self, address: Address) -> None:
        self.address = address
        self.behind = read_hardware(address)
        self._bench: Bench | None = None
        self.board: VirtualBoard | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.discard_board()

    def discard_board(self) -> None:
        """Disconnect and discard the board."""
        if self._bench is not None:
            self._bench.close()
        self._bench = self.board = None

    def get_bench(self) -> tuple[Bench, VirtualBoard]:
        """Return the board, started if necessary."""
        if self._bench is None or self.board is None:
            line, board = connect(self.address)
            if board is None:
                raise QuantityError.of("address", f"{self.address} is not a virtual board")
            self._bench, self.board = Bench(BoardLink(line, board), self.address), board
            opens = self.behind.normally_open
            self._bench.safe_state = "release" if opens else "hold"
            self._bench.vent_rest = "open" if opens else "closed"
        return self._bench, self.board

    def prepare_trial(self, plan: Plan) -> tuple[Bench, VirtualBoard, Observer]:
        """Prepare a healthy, vented line and its controller, and start the pump."""
        bench, board = self.get_bench()
        plant = board.plant
        plant.clear_faults()
        bench.off()
        bench.clear()
        plant.behind = plan.behind
        while plant.vacuum > EMPTY:  # a normally closed valve keeps the vacuum
            plant.vacuum = plant.side = plant.shown = 0.0
            time.sleep(1e-3)
        # the board must have read the repaired sensor: it gets each response before the next sample
        fresh = plant.asked + 2
        while plant.asked < fresh:
            bench.ask("*OPC?")
        bench.lease = LONG_LEASE
        bench.regulator = plan.case.regulator
        plant.watch = observer = Observer(plant, plan)
        bench.tell(f"VAC {plan.case.target:.17g};:OUTP ON")
        return bench, board, observer


def run_trial(bed: Bed, plan: Plan) -> Trial:
    """Return the result of one run of one fault."""
    validate(plan.case.regulator, plan.case.target)
    observer: Observer | None = None
    fault = named_after = None
    trouble = ""
    try:
        bench, board, observer = bed.prepare_trial(plan)
        seq = _inject_fault(bench, board, observer)
        fault = bench.fault
        if seq is not None and plan.kind.host == "releases":
            named_after = _time_to_name_fault(board, observer, seq)
        if observer.struck is None:
            trouble = "the time of the fault was not reached"
    except LineError as error:
        trouble = str(error)
        bed.discard_board()
    deadline = plan.kind.deadline(plan.case)
    has_struck = observer is not None and observer.struck is not None and observer.began is not None
    return Trial(
        plan=plan,
        onset=observer.struck - observer.began if has_struck else None,  # type: ignore[union-attr,operator]
        named=fault,
        # outputs that are safe without a latched fault are safe only by chance
        safe_after=observer.safe_after if observer and fault else None,
        named_after=named_after,
        deadline=deadline if math.isfinite(deadline) else None,
        vacuum_after=observer.vacuum if observer else math.nan,
        doubted_after=observer.last_opening_time(VENTS, VENT_WINDOW) if observer else None,
        lost_after=observer.lost_after if observer else None,
        trouble=trouble,
    )


def _inject_fault(bench: Bench, board: VirtualBoard, observer: Observer) -> int | None:
    """Wait for the fault, act as the host that the fault requires, and wait for the end of the run.

    Returns the number of the sample at which the board received the host's last command.
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
        _wait_until_done(observer)
        ran = [response for response in line.waiting_responses() if b",RUN," in response]
        last = ran[-1] if ran else b""
    else:
        response = "VAC 0" if host == "releases" else f"SYST:LEAS {case.lease}"
        last = line.ask(SESSION, f"{response};:FETC:ALL?".encode())
        if host == "silent":
            plant.pace = 0.0
    if not last:
        return None
    seq = int(last.split(b",")[0])
    observer.event = observer.find_sample_time(seq)
    _wait_until_done(observer)
    return seq


def _wait_until_done(observer: Observer) -> None:
    """Wait until the observer is done; raises LineError if the board stops taking samples."""
    count = -1
    while not observer.done.wait(5.0):
        if observer.plant.asked == count:
            raise LineError("the board stopped taking samples")
        count = observer.plant.asked


def _time_to_name_fault(board: VirtualBoard, observer: Observer, seq: int) -> float:
    """Return the time [s] from the event to the first record that names a fault, or infinity."""
    line, event = board.line, observer.event
    line.ask(SESSION, b"STR:ACK %d" % max(seq - 1, 0))
    while event is not None:
        rows = parse_records(line.ask(SESSION, b"FETC:STR? 200"))
        faults = rows[rows["fault"] != 0]
        if len(faults):
            time_named = observer.find_sample_time(int(faults["seq"][0]))
            return math.inf if time_named is None else time_named - event
        if not len(rows) or observer.find_sample_time(int(rows["seq"][-1])) is None:
            break
        line.ask(SESSION, b"STR:ACK %d" % int(rows["seq"][-1]))
    return math.inf


def campaign(
    address: str | Address = VIRTUAL,
    *,
    only: Sequence[str] = (),
    runs: int = 10,
    seed: int = 0,
    mismatch: bool = False,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Campaign:
    """Inject each fault `runs` times, each with a different line, controller, target and onset.

    With `mismatch`, each real line differs from its controller's model within the tolerances, and
    each round includes ten fault-free runs.

    Raises UnknownNameError, QuantityError for an address that is not a virtual board, FileError and
    LineError.
    """
    names = [*select_faults(only), *([NOTHING] * HEALTHY_RUNS if mismatch else [])]
    trials: list[Trial] = []
    with Bed(set_full_speed(address)) as bed:
        board = bed.get_bench()[1].name
        for number in range(runs):
            for place, name in enumerate(names):
                progress("faults", len(trials) / (runs * len(names)))
                count = number if name != NOTHING else number * len(names) + place
                plan = draw_plan(bed.behind, name, count, seed, mismatch=mismatch)
                trials.append(run_trial(bed, plan))
    return Campaign(tuple(trials), board)
