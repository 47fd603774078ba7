"""The words of the command that runs now, which some commands keep with what they write."""

from __future__ import annotations

from contextvars import ContextVar

TYPED: ContextVar[tuple[str, ...]] = ContextVar("TYPED", default=())
"""Set by `main`, also where a program calls it and `sys.argv` says something else."""
