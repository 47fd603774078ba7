"""What a command prints: one JSON object, or lines that fit a terminal."""

from __future__ import annotations

import os
import sys
from typing import Any


def say(result: Any, as_json: bool) -> int:
    """Print a result the way that was asked for; gives the exit code."""
    try:
        print(result.json() if as_json else result, flush=True)
    except BrokenPipeError:  # a reader such as `head` has seen enough; the result stands
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    code: int = result.exit_code
    return code
