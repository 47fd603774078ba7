"""`workbench` on the command line."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import MissingExtraError
from layerjam.core.units import QuantitySpec

PORT = QuantitySpec("1", "port to listen on", lo=1, hi=65535, whole=True)


@result
class WorkbenchResult(Result):
    """Address of the page."""

    port: int = fact("port of the server", listed=False)


@contextmanager
def _skip_http_clients() -> Iterator[None]:
    """Import NiceGUI's server without the clients that its Socket.IO can also use.

    Socket.IO then regards them as not installed; importing them takes 0.15 s.
    """
    absent = [name for name in ("aiohttp", "requests", "tornado") if name not in sys.modules]
    sys.modules.update(dict.fromkeys(absent))  # type: ignore[arg-type]
    try:
        yield
    finally:
        for name in absent:
            del sys.modules[name]


@command("share")
def workbench(
    *,
    port: Annotated[int, PORT] = 8321,
    host: Annotated[str, Help("Address to listen on. Remote clients need a token.")] = "127.0.0.1",
    show: Annotated[bool, Help("Open a browser.", option="--show/--no-show")] = True,
) -> WorkbenchResult:
    """Open the workbench: all of layerjam on a page of your browser."""
    missing_extra = MissingExtraError.raise_if_missing("the workbench (nicegui)", "workbench")
    with missing_extra, _skip_http_clients():
        import nicegui  # noqa: F401

        from layerjam.workbench.server import serve
    serve(host=host, port=port, show=show)
    return WorkbenchResult(port=port)
