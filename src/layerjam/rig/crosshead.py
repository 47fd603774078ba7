"""What pulls the brake on a bench: a person, a machine's contact, or the virtual machine.

Three methods: `begin` a move, `done` asks whether it is over, `end` whatever way it went.
"""

from __future__ import annotations

import select
import sys
from collections.abc import Callable
from typing import Protocol

from layerjam.errors import LayerjamError
from layerjam.rig.driver import Bench
from layerjam.rig.recorder import Block
from layerjam.simulate.procedure import Pull, Return

Note = Callable[[str, str], None]
"""Keeps an event: its kind, its text."""
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
        self._say = say or _shown
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


def _shown(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _enter() -> bool:
    """Whether a line came on standard input, without waiting for one."""
    try:
        if not select.select([sys.stdin], [], [], 0)[0]:
            return False
        line = sys.stdin.readline()
    except (OSError, ValueError):
        line = ""
    if not line:
        raise CrossheadLostError("nobody is at the keyboard: standard input is at its end")
    return True
