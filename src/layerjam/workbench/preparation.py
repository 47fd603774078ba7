"""Steps before the first result of a server: each is done once, in a thread."""

import threading
from collections.abc import Callable


class Preparation:
    """Callable that does the remaining steps; `text` states the current one for the page."""

    def __init__(self, **steps: Callable[[], object]) -> None:
        """Prepare with steps, {what is done, with underscores: function}."""
        self.steps = {name.replace("_", " "): step for name, step in steps.items()}
        self.done = 0
        self._lock = threading.Lock()

    def __call__(self) -> None:
        """Do the steps that remain; another thread waits until they are done."""
        with self._lock:
            for step in list(self.steps.values())[self.done :]:
                step()
                self.done += 1

    @property
    def text(self) -> str:
        """Sentence about the current step; empty if all are done."""
        if self.done == len(self.steps):
            return ""
        return f"Preparing, {self.done + 1} of {len(self.steps)}: {[*self.steps][self.done]}"
