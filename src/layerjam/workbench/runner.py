"""Computations outside the event loop; only the latest of several waiting requests starts."""

import asyncio
import contextlib
import threading
import time
from collections.abc import Awaitable, Callable
from typing import Any, NamedTuple

from nicegui import ui

from layerjam.core.errors import LayerjamError
from layerjam.workbench.widgets import button, dress, one_line

PATIENCE, LONG = 0.5, 2.0
"""Times after which the page shows a running computation, and a button to stop it [s]."""
PAUSE = 0.1
"""Time without another request after which the rest of a result is computed [s]."""
LOOK = 0.3
"""Seconds between two updates of the progress."""


class ComputationStopped(Exception):
    """Raised inside a computation that the user has stopped."""


class Part(NamedTuple):
    """A part of a result, which is shown before `finish()` computes the result."""

    content: Any
    finish: Callable[[], Any]


class Runner:
    """Runs `compute()` in a thread and hands its result to `show(result, problem)`.

    If it returns a `Part`, that is handed to `show_part`, and the rest is computed once no further
    request comes. If a result is requested while it runs, it runs once more with the latest inputs.
    """

    def __init__(
        self,
        compute: Callable[[], Any],
        show: Callable[[Any, str], None],
        in_thread: Callable[[Callable[[], Any]], Awaitable[Any]],
        show_part: Callable[[Any], None] = lambda part: None,
    ) -> None:
        """`in_thread` runs a function in a separate thread."""
        self._compute, self._show, self._elsewhere = compute, show, in_thread
        self._show_part = show_part
        self.running = self._again = False
        self._asked = asyncio.Event()
        self.stopping = threading.Event()
        self.doing = ("", 0.0)
        """Current phase, and its progress as a fraction."""
        self.began: float | None = None
        """Moment at which the current computation began, or None between two of them [s]."""
        self.error: LayerjamError | None = None
        """Error of the last computation."""

    async def request_result(self) -> None:
        """Compute with the current inputs and show the result, or queue this if already running."""
        if self.running:
            self._again = True
            self._asked.set()
            return
        self.running = True
        try:
            while True:
                self._again = False
                self._asked.clear()
                self.stopping.clear()
                self.doing = ("", 0.0)
                result, problem, self.error = None, "", None
                try:
                    result = await self._run(self._compute)
                    if isinstance(result, Part):
                        self._show_part(result.content)
                        with contextlib.suppress(TimeoutError):
                            await asyncio.wait_for(self._asked.wait(), PAUSE)
                            continue
                        result = await self._run(result.finish)
                except LayerjamError as err:
                    problem, self.error = one_line(err), err
                except ComputationStopped:
                    problem = "stopped"
                except (MemoryError, RecursionError):
                    problem = "too large for this machine's memory"
                self._show(result, problem)
                if not self._again:
                    return
        finally:
            self.running = False

    async def _run(self, work: Callable[[], Any]) -> Any:
        self.began = time.monotonic()
        try:
            return await self._elsewhere(work)
        finally:
            self.began = None

    def stop(self) -> None:
        """Stop a computation that reports its progress."""
        self.stopping.set()

    def report_progress(self, phase: str, share: float) -> None:
        """Store a command's progress; raises ComputationStopped if the user requested a stop."""
        if self.stopping.is_set():
            raise ComputationStopped
        self.doing = (phase, share)


def add_progress_line(page: str, runner: Runner) -> None:
    """Show a long computation, its progress, and a button to stop it."""
    with ui.row().classes("waiting items-center no-wrap gap-3") as row:
        ui.spinner(size="sm")
        label = dress(ui.label(), f"{page}-doing", "text-sm", role="status")
        bar = ui.linear_progress(value=0, show_value=False).classes("grow")
        dress(bar, aria_label="Progress")
        stop = button("Stop", runner.stop, f"{page}-stop")
    row.set_visibility(False)

    def update_line() -> None:
        duration = 0.0 if runner.began is None else time.monotonic() - runner.began
        if duration > PATIENCE:
            phase, share = runner.doing
            label.set_text(f"Updating: {phase or 'the first time takes a few seconds'}")
            stop.set_visibility(duration > LONG)
            bar.set_value(round(share, 3))
        row.set_visibility(duration > PATIENCE)

    ui.timer(LOOK, update_line)
