"""What every request passes: host name, token, size."""

from __future__ import annotations

import hmac
from typing import Any

from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.websockets import WebSocketClose

LOCAL = ("localhost", "127.0.0.1", "[::1]")


class Gate:
    """ASGI middleware: refuses strangers, other sites' pages, and bodies beyond `largest` bytes.

    On loopback the Host must name this machine (a foreign page that was made to resolve here does
    not); elsewhere the token of the printed address is due, kept as a cookie from then on.
    """

    def __init__(self, app: Any, *, token: str | None, largest: int, local: bool) -> None:
        self.app, self.token, self.largest, self.local = app, token, largest, local

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Pass on or refuse."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        asked = HTTPConnection(scope)
        refused = self._why_not(asked)
        if refused is not None:
            status, why = refused
            plain = PlainTextResponse(f"layerjam: {why}\n", status)
            stop = WebSocketClose(1008) if scope["type"] == "websocket" else plain
            await stop(scope, receive, send)
            return
        if scope["type"] == "http":
            receive = self._bounded(receive)
            send = self._with_cookie(send) if self._holds(asked.query_params.get("token")) else send
        await self.app(scope, receive, send)

    def _why_not(self, asked: HTTPConnection) -> tuple[int, str] | None:
        """Status and reason of a refusal."""
        host = asked.headers.get("host", "")
        name = host.rsplit(":", 1)[0] if not host.endswith("]") else host
        if self.local and name not in LOCAL:
            return 403, "this address is not served here"
        origin = asked.headers.get("origin")
        if origin and origin.split("://", 1)[-1] != host:
            return 403, "requests of other sites are not served"
        given = (asked.query_params.get("token"), asked.cookies.get("layerjam"))
        if self.token and not any(map(self._holds, given)):
            return 401, "open the address that was printed when the workbench began"
        length = asked.headers.get("content-length", "0")
        if length.isdigit() and int(length) > self.largest:
            return 413, f"more than {self.largest // 2**20} MB at once is not taken"
        return None

    def _holds(self, given: str | None) -> bool:
        """Whether it is the token, where there is one."""
        mine = (self.token or "").encode()
        return bool(self.token) and hmac.compare_digest((given or "").encode(), mine)

    def _bounded(self, receive: Any) -> Any:
        """A receive that ends a body of undeclared length that grows too large."""
        seen = 0

        async def bounded() -> Any:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b""))
            return {"type": "http.disconnect"} if seen > self.largest else message

        return bounded

    def _with_cookie(self, send: Any) -> Any:
        async def sent(message: Any) -> None:
            if message["type"] == "http.response.start":
                cookie = f"layerjam={self.token}; HttpOnly; SameSite=Strict; Path=/"
                message["headers"] = [*message.get("headers", []), (b"set-cookie", cookie.encode())]
            await send(message)

        return sent
