"""The server. It listens on the loopback address by default; other addresses need a token."""

import errno
import hmac
import ipaddress
import secrets
import socket
import threading
from collections.abc import Collection
from typing import Any
from urllib.parse import urlencode

from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.websockets import WebSocketClose

from layerjam.core.errors import QuantityError
from layerjam.core.store import Appearing
from layerjam.core.system import is_windows
from layerjam.workbench.preparation import Preparation

LOCAL = ("localhost", "127.0.0.1", "[::1]")
HEADERS = {
    # Vue compiles templates in the page, so inline scripts and eval stay allowed
    "content-security-policy": (
        "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; "
        "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
        "connect-src 'self' ws: wss: blob: data:; worker-src 'self' blob:; object-src 'none'; "
        "base-uri 'self'; form-action 'self'; frame-ancestors 'none'"
    ),
    "x-frame-options": "DENY",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
}
"""Headers that block content from other sites, and embedding by other sites."""


class _TooLarge(Exception):
    """A request body of undeclared length exceeded the limit."""


class RequestGuard:
    """ASGI middleware that rejects other users, other sites and bodies over `largest` bytes.

    `names` are the host names that requests may contain; None allows all. On loopback they must be
    names of this machine, because another site whose name resolves to this machine sends its own
    name. On other addresses the token of the printed address is required. It is moved from the
    address to a cookie, so that copied links do not contain it.
    """

    def __init__(
        self, app: Any, *, token: str | None, largest: int, names: Collection[str] | None
    ) -> None:
        self.app, self.token, self.largest, self.names = app, token, largest, names

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Pass a request on, or reject it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        refusal = self._find_refusal(request)
        if scope["type"] == "websocket":
            await (self.app if refusal is None else WebSocketClose(1008))(scope, receive, send)
            return
        send = _add_headers(send)
        if refusal is not None:
            await _plain_response(*refusal)(scope, receive, send)
        elif self._is_token(request.query_params.get("token")):
            await self._redirect_without_token(request)(scope, receive, send)
        else:
            try:
                await self.app(scope, self._limit_body(receive), send)
            except _TooLarge:
                await _plain_response(*self._size_refusal())(scope, receive, send)

    def _find_refusal(self, request: HTTPConnection) -> tuple[int, str] | None:
        host = request.headers.get("host", "")
        name = host.rsplit(":", 1)[0] if not host.endswith("]") else host
        if self.names is not None and name not in self.names:
            return 403, "this server has no page at this address"
        origin = request.headers.get("origin")
        if origin and origin.split("://", 1)[-1] != host:
            return 403, "requests from other sites are rejected"
        tokens = (request.query_params.get("token"), request.cookies.get("layerjam"))
        if self.token and not any(map(self._is_token, tokens)):
            return 401, "open the address that was printed when the workbench started"
        length = request.headers.get("content-length", "0")
        if length.isdigit() and int(length) > self.largest:
            return self._size_refusal()
        return None

    def _size_refusal(self) -> tuple[int, str]:
        return 413, f"at most {self.largest // 2**20} MB are accepted at once"

    def _is_token(self, token: str | None) -> bool:
        expected_token = (self.token or "").encode()
        return bool(self.token) and hmac.compare_digest((token or "").encode(), expected_token)

    def _limit_body(self, receive: Any) -> Any:
        """Return a receiver that raises _TooLarge if a body of undeclared length is too large."""
        size = 0

        async def receive_limited() -> Any:
            nonlocal size
            message = await receive()
            size += len(message.get("body", b""))
            if size > self.largest:
                raise _TooLarge
            return message

        return receive_limited

    def _redirect_without_token(self, request: HTTPConnection) -> RedirectResponse:
        """Redirect to the same address without the token, and store the token in a cookie."""
        query = [(k, v) for k, v in request.query_params.multi_items() if k != "token"]
        # use one slash, because two would name another host
        place = "/" + request.url.path.lstrip("/") + (f"?{urlencode(query)}" if query else "")
        answer = RedirectResponse(place, 303)
        answer.set_cookie("layerjam", self.token or "", httponly=True, samesite="strict")
        return answer


def _plain_response(status: int, reason: str) -> PlainTextResponse:
    return PlainTextResponse(f"layerjam: {reason}\n", status)


def _add_headers(send: Any) -> Any:
    headers = [(name.encode(), text.encode()) for name, text in HEADERS.items()]

    async def send_with_headers(message: Any) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", []), *headers]
        await send(message)

    return send_with_headers


BODY = 64 * 2**20
"""Largest request body [bytes]."""


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach a host address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        raise QuantityError(f"host: '{host[:60]}' is not an address of this machine") from None


def check_address(host: str, port: int) -> None:
    """Raise QuantityError if the server cannot listen on this host and port."""
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    except OSError:
        raise QuantityError(f"host: '{host[:60]}' is not an address of this machine") from None
    for family, kind, protocol, _, place in addresses:
        with socket.socket(family, kind, protocol) as trial:
            if not is_windows():  # on Windows both servers would share the port
                trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                trial.bind(place)
            except OSError as error:
                raise QuantityError(_bind_problem(error.errno, host, port)) from None


def _bind_problem(number: int | None, host: str, port: int) -> str:
    # Windows may report a busy port as access denied
    if number == errno.EADDRINUSE or (number == errno.EACCES and port > 1023):
        return f"port: {port} is in use by another program; choose a different one with --port"
    if number == errno.EACCES:
        return f"port: no permission to use {port}; choose one above 1023 with --port"
    return f"host: '{host[:60]}' is not an address of this machine"


def serve(*, host: str, port: int, show: bool, token: str | None = None) -> None:
    """Serve until interrupted.

    Raises ImportError if NiceGUI is missing, and QuantityError if it cannot listen.
    """
    from nicegui import app, run, ui

    if not is_loopback(host):
        token = token or secrets.token_urlsafe(18)
    check_address(host, port)
    from layerjam.workbench import live
    from layerjam.workbench.folders import remove_stale_folders
    from layerjam.workbench.pages.all import TABS
    from layerjam.workbench.shell import build_frame
    from layerjam.workbench.uploads import delete_folders

    live.check_version()

    @ui.page("/", title="layerjam workbench", dark=None)
    def page(s: str = "") -> None:
        build_frame(s, TABS, prepare_first_page)

    host_name = f"[{host}]" if ":" in host else host
    names = (*LOCAL, host_name) if is_loopback(host) else None
    app.add_middleware(RequestGuard, token=token, largest=BODY, names=names)
    place = f"http://{'localhost' if host_name in LOCAL else host_name}:{port}/"
    greeting = f"workbench: {place}{f'?token={token}' if token else ''}  (press Ctrl-C to stop)"
    app.on_startup(lambda: print(greeting, flush=True))
    # the server is idle while the browser opens and loads the page
    app.on_startup(threading.Thread(target=prepare_first_page).start)
    app.on_startup(lambda: run.io_bound(remove_stale_folders))
    app.on_shutdown(delete_folders)
    try:
        ui.run(
            host=host,
            port=port,
            title="layerjam workbench",
            show=show,
            reload=False,
            tailwind=False,
            show_welcome_message=False,
            reconnect_timeout=10,
            favicon=ICON,
            language="en-US",
            ws_per_message_deflate=not is_loopback(host),
        )
    except KeyboardInterrupt:  # the usual end of a server
        Appearing.interrupted = False


def _make_first_page() -> Any:
    """Return the first page, whose code is loaded while the browser loads the page."""
    from layerjam.workbench.desk import Desk
    from layerjam.workbench.pages.start import Start

    return Start(Desk())


prepare_first_page = Preparation(
    loading_the_numerical_code=_make_first_page,
    computing_the_first_pull=lambda: _make_first_page().compute(),
)


ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><g fill="#0072B2">'
    '<rect x="2" y="6" width="20" height="3"/><rect x="2" y="14" width="20" height="3"/>'
    '<rect x="2" y="22" width="20" height="3"/></g><g fill="#E69F00">'
    '<rect x="10" y="10" width="20" height="3"/><rect x="10" y="18" width="20" height="3"/>'
    "</g></svg>"
)
