"""A computation in a separate process, which releases its memory when it ends.

Open CASCADE and the typesetter for the instructions would keep half a gigabyte after use.
"""

import multiprocessing
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from layerjam.core.errors import LayerjamError

T = TypeVar("T")
Tell = Callable[[str, float], None]
LOOK = 0.2
"""Seconds between two checks for a stop request."""
ENGINE = (
    "jax_enable_x64",
    "jax_compilation_cache_dir",
    "jax_persistent_cache_min_compile_time_secs",
    "jax_persistent_cache_min_entry_size_bytes",
)
"""JAX settings that the subprocess inherits."""


def run_in_subprocess(work: Callable[..., T], *args: Any, progress: Tell) -> T:
    """Return `work(*args, tell)`, computed in a separate process.

    `tell(what, share)` is called in this process repeatedly; an error that it raises ends the
    subprocess. Raises any error of `work`, or LayerjamError if no result arrives.
    """
    # not forked, because a fork of a process with threads can deadlock
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    with receiver, tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        job = (sender, folder, _subprocess_settings(), work, args)
        process = context.Process(target=_run_subprocess, args=job, daemon=True)
        process.start()
        sender.close()
        try:
            answer: T = _receive_result(receiver, progress)
            return answer
        except EOFError:
            process.join()
            code = process.exitcode
            raise LayerjamError(
                f"the subprocess ended unexpectedly, with exit code {code}"
            ) from None
        finally:
            process.kill()
            process.join()
            process.close()


def _subprocess_settings() -> dict[str, Any]:
    config = getattr(sys.modules.get("jax"), "config", None)  # None while a thread imports JAX
    return {} if config is None else {name: getattr(config, name) for name in ENGINE}


def _receive_result(pipe: Connection, progress: Tell) -> Any:
    doing = ("", 0.0)
    while True:
        while not pipe.poll(LOOK):
            progress(*doing)
        kind, content = pipe.recv()
        if kind == "made":
            return content
        if kind == "failed":
            raise _rebuild_error(*content)
        doing = content
        progress(*doing)


def _rebuild_error(
    kind: type[Exception], args: tuple[Any, ...], facts: dict[str, Any]
) -> Exception:
    """Return the error as raised in the subprocess, without calling its constructor again."""
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(facts)
    return error


def _run_subprocess(
    pipe: Connection,
    room: str,
    settings: dict[str, Any],
    work: Callable[..., Any],
    args: tuple[Any, ...],
) -> None:
    """Run the subprocess; it ignores Ctrl-C, which the server handles."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    tempfile.tempdir = room  # removed with the process, even if it is killed
    try:
        if settings:
            import jax

            for name, value in settings.items():
                jax.config.update(name, value)
        message = ("made", work(*args, lambda what, share: pipe.send(("doing", (what, share)))))
    except Exception as error:
        if not isinstance(error, LayerjamError):
            error.add_note(traceback.format_exc())  # keep the traceback of this process
        message = ("failed", (type(error), error.args, vars(error)))
    with pipe:
        pipe.send(message)
