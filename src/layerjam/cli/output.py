"""Output of a command: its result, its progress, and the check that a file can be written."""

from __future__ import annotations

import os
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

from layerjam.errors import FileError
from layerjam.records.windows import refusal


def say(result: Any, as_json: bool) -> int:
    """Print a result as text or JSON; return the exit code."""
    try:
        print(result.json() if as_json else result, flush=True)
    except BrokenPipeError:  # a reader such as `head` has seen enough; the result stands
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    code: int = result.exit_code
    return code


PATIENCE = 2.0


class Ticker:
    """Progress that is called with (stage, share) and printed each second after two seconds.

    The first call starts the clock: loading before it does not count. Loops that numba still has to
    compile report nothing meanwhile; then a sentence states that this happens once.
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

    def __call__(self, stage: str, share: float) -> None:
        """Report the stage and its completed share."""
        time_now = time.monotonic()
        self.started = self.started or time_now
        if self.waiting is not None:
            self.waiting.cancel()
            self.waiting = None
        if share <= 0:
            self.waiting = threading.Timer(PATIENCE, self.say, ["loops are compiled, once"])
            self.waiting.daemon = True
            self.waiting.start()
            return
        if time_now - self.started > PATIENCE and time_now - self.said > 1:
            self.said = time_now
            self.say(f"{stage} {share:.0%}")

    def say(self, sentence: str) -> None:
        """Print one line."""
        print(f"layerjam: {sentence}", file=sys.stderr, flush=True)


PICTURES = (".svg", ".png", ".pdf")


def check_figure(path: Path | None, force: bool, flag: str = "--force") -> None:
    """Refuse a figure that could not be drawn or written, before any computation."""
    check_target(path, force, PICTURES, flag)
    if path is not None:
        from layerjam.report.style import look

        with look():
            pass


def check_target(
    path: Path | None, force: bool, endings: tuple[str, ...], flag: str = "--force"
) -> None:
    """Refuse an output file of another kind, or one that exists unless `force` (option `flag`)."""
    if path is None:
        return
    if path.suffix.lower() not in endings:
        choices = f"{', '.join(endings[:-1])} or {endings[-1]}" if len(endings) > 1 else endings[0]
        raise FileError(path, f"the ending '{path.suffix}' is not known; use {choices}")
    try:
        exists = os.path.lexists(path)
        if exists and not path.is_file():
            raise FileError(path, "is a folder or not a regular file")
        if exists and not force:
            raise FileError(path, f"exists already; {flag} replaces it")
        if not path.parent.is_dir():
            raise FileError(path, f"cannot be written: there is no folder {path.parent}")
        if not os.access(path.parent, os.W_OK):
            raise FileError(path, f"cannot be written: the folder {path.parent} is read-only")
        if problem := refusal(path):
            raise FileError(path, f"cannot be written: {problem}")
        if len(os.fsencode(path.name)) > 200:
            raise FileError(f"{path.name[:60]}...", "cannot be written: the name is too long")
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(str(path)[:200], f"cannot be written: {reason}") from None
