"""The command line; its names, options and JSON keys are a contract (docs/commands.md)."""

from contextvars import ContextVar

TYPED: ContextVar[tuple[str, ...]] = ContextVar("TYPED", default=())
"""The typed words, set by `main`, because a program may call it with a different `sys.argv`."""
