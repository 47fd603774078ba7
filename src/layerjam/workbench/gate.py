"""What every request passes: host name, token, size."""

from __future__ import annotations

import hmac
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import parse_qs

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
        headers = {k.decode("latin-1"): v.decode("latin-1") for k, v in scope["headers"]}
        why = self._why_not(scope, headers)
        if why:
            await self._refuse(scope, send, *why)
            return
        if scope["type"] == "http" and self._given(scope):
            await self.app(scope, self._bounded(receive), self._with_cookie(send))
            return
        await self.app(scope, self._bounded(receive) if scope["type"] == "http" else receive, send)

    def _why_not(self, scope: Any, headers: dict[str, str]) -> tuple[int, str] | None:
        host = headers.get("host", "")
        name = host.rsplit(":", 1)[0] if not host.endswith("]") else host
        if self.local and name not in LOCAL:
            return 403, "this address is not served here"
        origin = headers.get("origin")
        if origin and origin.split("://", 1)[-1] != host:
            return 403, "requests of other sites are not served"
        if self.token and not self._given(scope) and not self._kept(headers):
            return 401, "open the address that was printed when the workbench began"
        length = headers.get("content-length", "0")
        if length.isdigit() and int(length) > self.largest:
            return 413, f"more than {self.largest // 2**20} MB at once is not taken"
        return None

    def _given(self, scope: Any) -> bool:
        if not self.token:
            return False
        given = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token", [""])[0]
        return hmac.compare_digest(given.encode(), self.token.encode())

    def _kept(self, headers: dict[str, str]) -> bool:
        cookie = SimpleCookie(headers.get("cookie", "")).get("layerjam")
        kept = cookie.value if cookie else ""
        return hmac.compare_digest(kept.encode(), (self.token or "").encode())

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

    async def _refuse(self, scope: Any, send: Any, status: int, why: str) -> None:
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
            return
        body = f"layerjam: {why}\n".encode()
        length = (b"content-length", str(len(body)).encode())
        head = [(b"content-type", b"text/plain; charset=utf-8"), length]
        await send({"type": "http.response.start", "status": status, "headers": head})
        await send({"type": "http.response.body", "body": body})
