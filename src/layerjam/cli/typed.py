"""The words of the running command, which some commands store with their output."""

from __future__ import annotations

from contextvars import ContextVar

TYPED: ContextVar[tuple[str, ...]] = ContextVar("TYPED", default=())
"""Set by `main`, also if a program calls it and `sys.argv` differs."""
