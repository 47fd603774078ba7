"""The server: loopback only unless told otherwise, then behind a token."""

from __future__ import annotations

import ipaddress
import secrets
import threading

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


def serve(*, host: str, port: int, show: bool, token: str | None = None) -> None:
    """Serve until interrupted; MissingExtraError without NiceGUI."""
    try:
        from nicegui import app, ui
    except ImportError:
        raise MissingExtraError("the workbench (nicegui)", "workbench") from None
    if not is_loopback(host):
        token = token or secrets.token_urlsafe(18)
    from layerjam.workbench.gate import Gate
    from layerjam.workbench.pages.all import PAGES
    from layerjam.workbench.shell import frame
    from layerjam.workbench.uploads import close_all

    @ui.page("/", title="layerjam workbench", dark=None)
    def page(s: str = "") -> None:
        frame(s, PAGES, prepare)

    app.add_middleware(Gate, token=token, largest=BODY, local=is_loopback(host))
    place = f"http://{'localhost' if host in ('127.0.0.1', '::1') else host}:{port}/"
    app.on_startup(lambda: print(f"workbench: {place}{f'?token={token}' if token else ''}"
                                 "  (Ctrl-C ends it)", flush=True))  # fmt: skip
    app.on_shutdown(close_all)
    threading.Thread(target=prepare, daemon=True).start()
    ui.run(
        host=host, port=port, title="layerjam workbench", show=show, reload=False,
        show_welcome_message=False, reconnect_timeout=10, favicon=ICON,
    )  # fmt: skip


_ready = threading.Lock()


def prepare() -> None:
    """Load what computing needs, once, while the first page is on its way."""
    with _ready:
        import jax

        jax.config.update("jax_enable_x64", True)
        import layerjam.verbs.edit
        import layerjam.verbs.impact
        import layerjam.verbs.predict  # noqa: F401


ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><g fill="#0072B2">'
    '<rect x="2" y="6" width="20" height="3"/><rect x="2" y="14" width="20" height="3"/>'
    '<rect x="2" y="22" width="20" height="3"/></g><g fill="#E69F00">'
    '<rect x="10" y="10" width="20" height="3"/><rect x="10" y="18" width="20" height="3"/>'
    "</g></svg>"
)
