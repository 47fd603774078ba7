"""Progress of what takes more than two seconds, on standard error."""

from __future__ import annotations

import sys
import threading
import time

PATIENCE = 2.0


class Ticker:
    """Called with (what, share done); says so once a second from the third second on.

    The first call starts the clock: what was loaded before it is no part of the work.
    Loops that numba has not compiled yet tell nothing while they are compiled: then a sentence says
    that this happens once.
    """

    def __init__(self) -> None:
        self.started: float | None = None
        self.said = 0.0
        self.waiting: threading.Timer | None = None

    def __enter__(self) -> Ticker:
        return self

    def __exit__(self, *_: object) -> None:
        if self.waiting is not None:
            self.waiting.cancel()

    def __call__(self, what: str, share: float) -> None:
        """Tell what is being done and how much of it is."""
        now = time.monotonic()
        self.started = self.started or now
        if self.waiting is not None:
            self.waiting.cancel()
            self.waiting = None
        if share <= 0:
            self.waiting = threading.Timer(PATIENCE, self.say, ["loops are compiled, once"])
            self.waiting.daemon = True
            self.waiting.start()
            return
        if now - self.started > PATIENCE and now - self.said > 1:
            self.said = now
            self.say(f"{what} {share:.0%}")

    def say(self, sentence: str) -> None:
        """One line."""
        print(f"layerjam: {sentence}", file=sys.stderr, flush=True)
