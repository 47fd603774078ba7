"""What every request passes: host name, token, size; and the headers that every answer carries."""

from __future__ import annotations

import hmac
from collections.abc import Collection
from typing import Any
from urllib.parse import urlencode

from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.websockets import WebSocketClose

LOCAL = ("localhost", "127.0.0.1", "[::1]")
HEADERS = {
    # Vue compiles templates that stand in the page, so inline scripts and eval stay allowed
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
"""Nothing is loaded from elsewhere, and no other site's page shows this one inside its own."""


class _TooLarge(Exception):
    """A body of undeclared length grew beyond what is taken."""


class Gate:
    """ASGI middleware: refuses strangers, other sites' pages, and bodies beyond `largest` bytes.

    `names` are the hosts that requests may ask for, None for all. On loopback that is this machine:
    a foreign page that was made to resolve here names itself. Elsewhere the token of the printed
    address is due. It goes into a cookie and out of the address, so that no copied link holds it.
    """

    def __init__(
        self, app: Any, *, token: str | None, largest: int, names: Collection[str] | None
    ) -> None:
        self.app, self.token, self.largest, self.names = app, token, largest, names

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Pass on or refuse."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        refused = self._why_not(asked)
        if scope["type"] == "websocket":
            await (self.app if refused is None else WebSocketClose(1008))(scope, receive, send)
            return
        send = _with_headers(send)
        if refused is not None:
            await _plain(*refused)(scope, receive, send)
        elif self._holds(asked.query_params.get("token")):
            await self._without_token(asked)(scope, receive, send)
        else:
            try:
                await self.app(scope, self._bounded(receive), send)
            except _TooLarge:
                await _plain(*self._too_large())(scope, receive, send)

    def _why_not(self, asked: HTTPConnection) -> tuple[int, str] | None:
        """Status and reason of a refusal."""
        host = asked.headers.get("host", "")
        name = host.rsplit(":", 1)[0] if not host.endswith("]") else host
        if self.names is not None and name not in self.names:
            return 403, "this address is not served here"
        origin = asked.headers.get("origin")
        if origin and origin.split("://", 1)[-1] != host:
            return 403, "requests of other sites are not served"
        given = (asked.query_params.get("token"), asked.cookies.get("layerjam"))
        if self.token and not any(map(self._holds, given)):
            return 401, "open the address that was printed when the workbench began"
        length = asked.headers.get("content-length", "0")
        if length.isdigit() and int(length) > self.largest:
            return self._too_large()
        return None

    def _too_large(self) -> tuple[int, str]:
        return 413, f"more than {self.largest // 2**20} MB at once is not taken"

    def _holds(self, given: str | None) -> bool:
        """Whether it is the token, where there is one."""
        mine = (self.token or "").encode()
        return bool(self.token) and hmac.compare_digest((given or "").encode(), mine)

    def _bounded(self, receive: Any) -> Any:
        """A receive that raises _TooLarge in a body of undeclared length that grows too large."""
        seen = 0

        async def bounded() -> Any:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b""))
            if seen > self.largest:
                raise _TooLarge
            return message

        return bounded

    def _without_token(self, asked: HTTPConnection) -> RedirectResponse:
        """To the same page without the token, which the browser keeps from now on."""
        rest = [(k, v) for k, v in asked.query_params.multi_items() if k != "token"]
        # one slash: two would name another host
        place = "/" + asked.url.path.lstrip("/") + (f"?{urlencode(rest)}" if rest else "")
        answer = RedirectResponse(place, 303)
        answer.set_cookie("layerjam", self.token or "", httponly=True, samesite="strict")
        return answer


def _plain(status: int, why: str) -> PlainTextResponse:
    return PlainTextResponse(f"layerjam: {why}\n", status)


def _with_headers(send: Any) -> Any:
    extra = [(name.encode(), text.encode()) for name, text in HEADERS.items()]

    async def sent(message: Any) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", []), *extra]
        await send(message)

    return sent
