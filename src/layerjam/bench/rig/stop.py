"""Stop request from an operator: Ctrl-C or SIGTERM, recorded instead of raised.

A program that holds a brake must first make it safe, which a second Ctrl-C must not interrupt.
"""

import signal
import threading
from typing import Any, Self

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stop:
    """Stop request; `asked` is True once it is made. Signals are handled inside a `with` block."""

    signalled = False
    """Whether a signal, and not the program, has requested any stop in this process."""

    def __init__(self) -> None:
        self.asked = False
        self._before: dict[signal.Signals, Any] = {}

    def request_stop(self, *signals: object) -> None:
        """Request a stop."""
        self.asked = True
        Stop.signalled |= bool(signals)

    def __enter__(self) -> Self:
        # only the main thread receives signals
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.signal(number, self.request_stop) for number in SIGNALS}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before = {}
