"""Computations off the event loop: the latest wins, what was overtaken is never begun."""

from __future__ import annotations

import threading
from collections.abc import Awaitable, Callable
from typing import Any

from layerjam.errors import LayerjamError


class Stopped(Exception):
    """Raised inside a computation that the user has stopped."""


class Runner:
    """Runs `compute()` in a thread and hands its result to `show(result, problem)`.

    Asked again while it runs, it begins anew once, with the latest inputs, when it is done.
    """

    def __init__(
        self,
        compute: Callable[[], Any],
        show: Callable[[Any, str], None],
        elsewhere: Callable[[Callable[[], Any]], Awaitable[Any]],
    ) -> None:
        """`elsewhere` awaits a function in another thread."""
        self._compute, self._show, self._elsewhere = compute, show, elsewhere
        self.running = self._again = False
        self.stop_flag = threading.Event()

    async def ask(self) -> None:
        """Compute with the inputs of now; returns when the result is shown or was overtaken."""
        if self.running:
            self._again = True
            return
        self.running = True
        try:
            while True:
                self._again = False
                self.stop_flag.clear()
                result, problem = None, ""
                try:
                    result = await self._elsewhere(self._compute)
                except LayerjamError as err:
                    problem = " ".join(str(err).split())
                except Stopped:
                    problem = "stopped"
                except (MemoryError, RecursionError):
                    problem = "too large for this machine's memory"
                self._show(result, problem)
                if not self._again:
                    return
        finally:
            self.running = False

    def stop(self) -> None:
        """End a computation that reports its progress."""
        self.stop_flag.set()

    def check(self, *_: Any) -> None:
        """A progress callback that ends a stopped computation; raises Stopped."""
        if self.stop_flag.is_set():
            raise Stopped
