"""An operator's wish to stop: Ctrl-C or SIGTERM, as often as they come, asked for and not raised.

What holds a brake must first put it to rest, and no second Ctrl-C may take it out of that.
"""

from __future__ import annotations

import signal
import threading
from typing import Any, Self

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stop:
    """`asked` is True once somebody wants to stop; signals count inside `with`."""

    def __init__(self) -> None:
        self.asked = False
        self._before: dict[signal.Signals, Any] = {}

    def ask(self, *_: object) -> None:
        """Want to stop."""
        self.asked = True

    def __enter__(self) -> Self:
        # only the main thread hears signals
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.signal(number, self.ask) for number in SIGNALS}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before = {}
