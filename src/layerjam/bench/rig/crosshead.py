"""Crosshead of a bench: moved by a person, by a machine with a contact, or by the virtual machine.

It has three methods: `begin` starts a move, `is_done` checks whether the move is over, and `end`
always cleans up.
"""

import importlib
import select
import sys
from collections.abc import Callable
from typing import Any, Protocol

from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.machine import VirtualMachine
from layerjam.bench.rig.recorder import Block
from layerjam.brake.device.brake import Brake
from layerjam.brake.fluid.line import Line
from layerjam.brake.simulate.procedure import Pull, Return
from layerjam.core.errors import LayerjamError, QuantityError

Note = Callable[[str, str], None]
"""Function that records an event, given its kind and text."""
EXTERNAL = 16
"""Flag of a sample: the machine's contact is closed."""
WAITS = 600.0
"""Longest wait for a person [s]."""


class CrossheadLostError(LayerjamError):
    """Raised if a crosshead does not report the end of a move in time."""

    key = "crosshead"


class Crosshead(Protocol):
    """Interface of everything that moves the free end of the brake."""

    def start_move(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Start a move."""

    def is_done(self, elapsed_time: float) -> bool:
        """Return whether the move is over, `elapsed_time` [s] after its start by the board's clock.

        Raises CrossheadLostError if the move is long overdue.
        """

    def end_move(self, bench: Bench) -> None:
        """Finish the move, or stop waiting for its end."""

    def read_positions(self, block: Block) -> list[tuple[int, float, float]]:
        """Return (board's clock [us], elongation [m], force [N]) of the samples, if known."""


class Manual:
    """A person at a machine, who receives instructions and presses Enter twice per move.

    The board's marker (`OUTP:SYNC`) is on from the first Enter to the second, so that the machine's
    analogue input can record it. `pressed` returns whether Enter has been pressed since the last
    call; `say` shows a text.
    """

    def __init__(
        self, pressed: Callable[[], bool] | None = None, say: Callable[[str], None] | None = None
    ) -> None:
        self._pressed = pressed or _is_enter_pressed
        self._say = say or notify_operator
        self._moves = False
        self._step: Pull | Return | None = None
        self._bench: Bench | None = None
        self._note: Note = lambda kind, text: None

    def start_move(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Ask the operator to start the crosshead."""
        self._step, self._bench, self._note, self._moves = step, bench, note, False
        self._prompt_operator(f"Ready to {step.text()}: press Enter and start the machine.")

    def is_done(self, elapsed_time: float) -> bool:
        """Return whether Enter has been pressed a second time."""
        if elapsed_time > WAITS:
            raise CrossheadLostError(f"nobody pressed Enter for {WAITS:g} s")
        if not self._pressed():
            return False
        self._note("answer", "Enter")
        if self._moves or self._bench is None or self._step is None:
            return True
        self._moves = True
        self._bench.tell("OUTP:SYNC ON")
        self._prompt_operator(f"Press Enter when the crosshead is at {self._step.end * 1e3:g} mm.")
        return False

    def end_move(self, bench: Bench) -> None:
        """Switch the marker off."""
        if self._moves:
            self._moves = False
            bench.tell("OUTP:SYNC OFF")

    def read_positions(self, block: Block) -> list[tuple[int, float, float]]:
        """Return an empty list: the machine stores the positions."""
        return []

    def _prompt_operator(self, text: str) -> None:
        self._note("prompt", text)
        self._say(text)


class Trigger:
    """Machine with two contacts: `OUTP:SYNC` starts it, and its own contact reports the end.

    The board reports the state of the machine's contact in every sample. The contact must be open
    at the start, and close when the machine's method has ended.
    """

    def __init__(self) -> None:
        self._closed = self._moves = False
        self._due = self._at = 0.0

    def start_move(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Close the contact that starts the machine's method."""
        if self._closed:
            raise CrossheadLostError("the contact was closed before the machine was started")
        self._due = move_timeout(step, self._at)
        self._at = step.end
        self._moves = True
        bench.tell("OUTP:SYNC ON")

    def is_done(self, elapsed_time: float) -> bool:
        """Whether the machine's contact has closed."""
        if elapsed_time > self._due and not self._closed:
            raise CrossheadLostError(
                f"the machine's contact did not close within {self._due:.3g} s"
            )
        return self._closed

    def end_move(self, bench: Bench) -> None:
        """Open the contact."""
        if self._moves:
            self._moves = False
            bench.tell("OUTP:SYNC OFF")

    def read_positions(self, block: Block) -> list[tuple[int, float, float]]:
        """Return an empty list: the machine stores the positions, and samples only the contact."""
        self._closed = bool(block.rows["flags"][-1] & EXTERNAL)
        return []


class Virtual:
    """The machine in the plant of a virtual board; raises QuantityError for any other bench."""

    def __init__(self, bench: Bench, brake: Brake, line: Line) -> None:
        plant = bench.plant
        if plant is None:
            raise QuantityError.of(
                "crosshead",
                f"'virtual' is not allowed on {bench.address}; it needs a virtual board that "
                "this command starts itself (sim:LINE)",
            )
        self._machine = plant.machine = VirtualMachine(brake, line)
        self._due = self._end = self._seen = 0.0

    def start_move(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Start the move; the marker is on during the move."""
        self._due, self._end = move_timeout(step, self._machine.elongation), step.end
        bench.tell("OUTP:SYNC ON")
        self._machine.start_motion(step.end, step.speed)

    def is_done(self, elapsed_time: float) -> bool:
        """Whether the samples show the end position."""
        has_arrived = self._seen == self._end
        if elapsed_time > self._due and not has_arrived:
            raise CrossheadLostError(f"the virtual crosshead did not arrive in {self._due:.3g} s")
        return has_arrived

    def end_move(self, bench: Bench) -> None:
        """Stop the machine."""
        was_moving, self._due = self._due, 0.0
        self._machine.stop_motion()
        if was_moving:
            bench.tell("OUTP:SYNC OFF")

    def read_positions(self, block: Block) -> list[tuple[int, float, float]]:
        """Return the machine's readings at each sample."""
        rows = zip(block.rows["seq"].tolist(), block.us.tolist(), strict=True)
        readings = [(us, *self._machine.take_sample(seq)) for seq, us in rows]
        self._seen = readings[-1][1]
        return readings


def move_timeout(step: Pull | Return, start: float) -> float:
    """Return the time [s] after which a move from an elongation [m] is long overdue."""
    return 2 * abs(step.end - start) / step.speed + 10.0


def notify_operator(text: str) -> None:
    """Print a text for the person at the bench, without buffering."""
    print(text, file=sys.stderr, flush=True)


def _is_enter_pressed() -> bool:
    """Return whether a line has arrived on standard input, without waiting."""
    if sys.platform == "win32" and sys.stdin.isatty():
        return _is_key_pressed()
    try:
        if not select.select([sys.stdin], [], [], 0)[0]:
            return False
        line = sys.stdin.readline()
    except (OSError, ValueError):
        line = ""
    if not line:
        raise CrossheadLostError("nobody is at the keyboard: standard input has ended")
    return True


def _is_key_pressed() -> bool:
    """Return whether Enter was pressed in the Windows console, which `select` cannot watch."""
    keys: Any = importlib.import_module("msvcrt")
    is_enter = False
    while keys.kbhit():
        is_enter |= keys.getwch() in "\r\n"
    return is_enter
