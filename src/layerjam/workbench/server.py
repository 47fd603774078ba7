"""The server: loopback only unless told otherwise, then behind a token."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import secrets
import socket
import threading
from collections.abc import Callable

from layerjam.errors import MissingExtraError, QuantityError

BODY = 64 * 2**20
"""Largest request body [bytes]."""


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach it."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        raise QuantityError(f"host: '{host[:60]}' is no address of this machine") from None


def check_free(host: str, port: int) -> None:
    """QuantityError where nothing can listen at this address."""
    try:
        where = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    except OSError:
        raise QuantityError(f"host: '{host[:60]}' is no address of this machine") from None
    for family, kind, protocol, _, place in where:
        with socket.socket(family, kind, protocol) as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                trial.bind(place)
            except OSError as error:
                raise QuantityError(_why_not(error.errno, host, port)) from None


def _why_not(number: int | None, host: str, port: int) -> str:
    if number == errno.EADDRINUSE:
        return f"port: {port} is used by another program; take another one with --port"
    if number == errno.EACCES:
        return f"port: {port} may not be used by this user; take one above 1023 with --port"
    return f"host: '{host[:60]}' is no address of this machine"


def serve(
    *, host: str, port: int, show: bool, engine: Callable[[], None], token: str | None = None
) -> None:
    """Serve until interrupted; `engine` makes JAX ready, in a thread.

    Raises MissingExtraError without NiceGUI, and QuantityError where it cannot listen.
    """
    with MissingExtraError.raise_if_missing("the workbench (nicegui)", "workbench"):
        from nicegui import app, run, ui
    if not is_loopback(host):
        token = token or secrets.token_urlsafe(18)
    check_free(host, port)
    from layerjam.workbench import live
    from layerjam.workbench.folders import sweep
    from layerjam.workbench.gate import LOCAL, Gate
    from layerjam.workbench.pages.all import TABS
    from layerjam.workbench.shell import frame
    from layerjam.workbench.uploads import close_all

    live.check()

    @ui.page("/", title="layerjam workbench", dark=None)
    def page(s: str = "") -> None:
        frame(s, TABS, lambda: prepare(engine))

    named = f"[{host}]" if ":" in host else host
    names = (*LOCAL, named) if is_loopback(host) else None
    app.add_middleware(Gate, token=token, largest=BODY, names=names)
    place = f"http://{'localhost' if named in LOCAL else named}:{port}/"
    said = f"workbench: {place}{f'?token={token}' if token else ''}  (Ctrl-C ends it)"
    app.on_startup(lambda: print(said, flush=True))
    # while the browser opens and reads the page, the server has time
    app.on_startup(threading.Thread(target=prepare, args=(engine,)).start)
    app.on_startup(lambda: run.io_bound(sweep))
    app.on_shutdown(close_all)
    with contextlib.suppress(KeyboardInterrupt):
        ui.run(
            host=host,
            port=port,
            title="layerjam workbench",
            show=show,
            reload=False,
            show_welcome_message=False,
            reconnect_timeout=10,
            favicon=ICON,
            language="en-US",
            ws_per_message_deflate=not is_loopback(host),
        )


_preparing, _prepared = threading.Lock(), threading.Event()


def prepare(engine: Callable[[], None]) -> None:
    """Load what the first page computes with, and compute it, once, while it is on its way."""
    with _preparing:
        if _prepared.is_set():
            return
        engine()
        from layerjam.workbench.desk import Desk
        from layerjam.workbench.pages.start import Start

        Start(Desk()).compute()
        _prepared.set()


ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><g fill="#0072B2">'
    '<rect x="2" y="6" width="20" height="3"/><rect x="2" y="14" width="20" height="3"/>'
    '<rect x="2" y="22" width="20" height="3"/></g><g fill="#E69F00">'
    '<rect x="10" y="10" width="20" height="3"/><rect x="10" y="18" width="20" height="3"/>'
    "</g></svg>"
)
