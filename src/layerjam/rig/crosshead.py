"""What pulls the brake on a bench: a person, a machine's contact, or the virtual machine.

Three methods: `begin` a move, `done` asks whether it is over, `end` whatever way it went.
"""

from __future__ import annotations

import importlib
import select
import sys
from collections.abc import Callable
from typing import Any, Protocol

from layerjam.device.brake import Brake
from layerjam.errors import LayerjamError, QuantityError
from layerjam.fluid.line import Line
from layerjam.rig.driver import Bench
from layerjam.rig.machine import VirtualMachine
from layerjam.rig.recorder import Block
from layerjam.simulate.procedure import Pull, Return

Note = Callable[[str, str], None]
"""Keeps an event: its kind, its text."""
EXTERNAL = 16
"""Flag of a sample: the machine's contact is closed."""
WAITS = 600.0
"""Seconds that a person is waited for."""


class CrossheadLostError(LayerjamError):
    """A crosshead that does not say when it has arrived."""

    key = "crosshead"


class Crosshead(Protocol):
    """Whatever moves the brake's end."""

    def begin(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Start a move."""

    def done(self, passed: float) -> bool:
        """Whether it is over, `passed` [s] of the board's clock after it began.

        Raises CrossheadLostError where it should be over for long.
        """

    def end(self, bench: Bench) -> None:
        """The move is over, or nobody waits for it any more."""

    def positions(self, block: Block) -> list[tuple[int, float, float]]:
        """(board's clock [us], elongation [m], force [N]) of samples, where it knows."""


class Manual:
    """A person at a machine: told what to do, and asked for Enter twice.

    The board's marker (`OUTP:SYNC`) is on from the first Enter to the second, for the machine's
    analogue input. `pressed` says whether Enter came since it was last asked; `say` shows a text.
    """

    def __init__(
        self, pressed: Callable[[], bool] | None = None, say: Callable[[str], None] | None = None
    ) -> None:
        self._pressed = pressed or _enter
        self._say = say or tell_person
        self._moves = False
        self._step: Pull | Return | None = None
        self._bench: Bench | None = None
        self._note: Note = lambda kind, text: None

    def begin(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Ask for the start."""
        self._step, self._bench, self._note, self._moves = step, bench, note, False
        self._ask(f"Ready to {step.text()}: press Enter and start the machine.")

    def done(self, passed: float) -> bool:
        """Whether the second Enter came."""
        if passed > WAITS:
            raise CrossheadLostError(f"nobody pressed Enter for {WAITS:g} s")
        if not self._pressed():
            return False
        self._note("answer", "Enter")
        if self._moves or self._bench is None or self._step is None:
            return True
        self._moves = True
        self._bench.tell("OUTP:SYNC ON")
        self._ask(f"Press Enter when the crosshead stands at {self._step.end * 1e3:g} mm.")
        return False

    def end(self, bench: Bench) -> None:
        """Marker off."""
        if self._moves:
            self._moves = False
            bench.tell("OUTP:SYNC OFF")

    def positions(self, block: Block) -> list[tuple[int, float, float]]:
        """The machine keeps them."""
        return []

    def _ask(self, text: str) -> None:
        self._note("prompt", text)
        self._say(text)


class Trigger:
    """A machine that two contacts start and end: `OUTP:SYNC` closes, its own contact answers.

    The board shows the machine's contact in every sample. Closed, it says that the method is over;
    it must be open at the start.
    """

    def __init__(self) -> None:
        self._closed = self._moves = False
        self._due = self._at = 0.0

    def begin(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Close the contact that starts the method."""
        if self._closed:
            raise CrossheadLostError("the machine's contact is closed before it was started")
        self._due = patience(step, self._at)
        self._at = step.end
        self._moves = True
        bench.tell("OUTP:SYNC ON")

    def done(self, passed: float) -> bool:
        """Whether the machine's contact has closed."""
        if passed > self._due and not self._closed:
            raise CrossheadLostError(
                f"the machine's contact did not close within {self._due:.3g} s"
            )
        return self._closed

    def end(self, bench: Bench) -> None:
        """Open the contact."""
        if self._moves:
            self._moves = False
            bench.tell("OUTP:SYNC OFF")

    def positions(self, block: Block) -> list[tuple[int, float, float]]:
        """The machine keeps them; the contact is in the samples."""
        self._closed = bool(block.rows["flags"][-1] & EXTERNAL)
        return []


class Virtual:
    """The machine in the plant of a virtual board; QuantityError for a bench that has none here."""

    def __init__(self, bench: Bench, brake: Brake, line: Line) -> None:
        plant = bench.plant
        if plant is None:
            raise QuantityError.of(
                "crosshead",
                f"virtual is not allowed on {bench.address}: it moves in a virtual board that this "
                "command starts itself (sim:LINE)",
            )
        self._machine = plant.machine = VirtualMachine(brake, line)
        self._due = self._end = self._seen = 0.0

    def begin(self, step: Pull | Return, bench: Bench, note: Note) -> None:
        """Start the move; the marker is on as long as it lasts."""
        self._due, self._end = patience(step, self._machine.elongation), step.end
        bench.tell("OUTP:SYNC ON")
        self._machine.go(step.end, step.speed)

    def done(self, passed: float) -> bool:
        """Whether the samples show it at the end."""
        there = self._seen == self._end
        if passed > self._due and not there:
            raise CrossheadLostError(f"the virtual machine did not arrive within {self._due:.3g} s")
        return there

    def end(self, bench: Bench) -> None:
        """Stand."""
        moved, self._due = self._due, 0.0
        self._machine.halt()
        if moved:
            bench.tell("OUTP:SYNC OFF")

    def positions(self, block: Block) -> list[tuple[int, float, float]]:
        """What the machine showed at each sample."""
        rows = zip(block.rows["seq"].tolist(), block.us.tolist(), strict=True)
        shown = [(us, *self._machine.taken(seq)) for seq, us in rows]
        self._seen = shown[-1][1]
        return shown


def patience(step: Pull | Return, start: float) -> float:
    """Seconds after which a move that begins at an elongation [m] should be over for long."""
    return 2 * abs(step.end - start) / step.speed + 10.0


def tell_person(text: str) -> None:
    """Say something to who stands at the bench, at once."""
    print(text, file=sys.stderr, flush=True)


def _enter() -> bool:
    """Whether a line came on standard input, without waiting for one."""
    if sys.platform == "win32" and sys.stdin.isatty():
        return _key()
    try:
        if not select.select([sys.stdin], [], [], 0)[0]:
            return False
        line = sys.stdin.readline()
    except (OSError, ValueError):
        line = ""
    if not line:
        raise CrossheadLostError("nobody is at the keyboard: standard input is at its end")
    return True


def _key() -> bool:
    """Whether Enter was pressed at Windows' console, which `select` cannot ask."""
    keys: Any = importlib.import_module("msvcrt")
    pressed = False
    while keys.kbhit():
        pressed |= keys.getwch() in "\r\n"
    return pressed
