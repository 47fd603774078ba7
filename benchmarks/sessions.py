"""Other people at the workbench: sessions that move the Pull page's vacuum, without their browsers.

They run in a process of their own: `python -m benchmarks.sessions ADDRESS COUNT PAUSE`. It says
"ready" once every session has its slider, moves until its input is closed, and then says how many
moves were answered with a curve.
"""

from __future__ import annotations

import asyncio
import json
import re
import sys
import urllib.request
import uuid
from typing import Any

import socketio

from layerjam.workbench.state import State, format_link

SLIDER = "pull-vacuum"
LOW, HIGH = 70.0, 90.0


class Session:
    """One of them."""

    def __init__(self, place: str) -> None:
        self.place = place
        self.answered = 0
        self.slider: tuple[int, str] | None = None
        self.socket = socketio.AsyncClient(reconnection=False)
        self.socket.on("update", self._updated)
        self.socket.on("run_javascript", self._asked)

    async def begin(self) -> None:
        """Load the page as a browser does, and wait for its slider."""
        link = f"{self.place}?s={format_link(State(page='pull'))}"
        text = await asyncio.to_thread(lambda: urllib.request.urlopen(link).read().decode())
        found = re.search(r"'client_id': '([^']+)'", text)
        assert found is not None
        self.client = found.group(1)
        own = "&".join(f"{k}={uuid.uuid4()}" for k in ("tab_id", "document_id"))
        await self.socket.connect(
            f"{self.place}?client_id={self.client}&next_message_id=0&implicit_handshake=true&{own}",
            socketio_path="/_nicegui_ws/socket.io", transports=["websocket"],
        )  # fmt: skip
        while self.slider is None or not self.answered:
            await asyncio.sleep(0.05)

    async def _updated(self, message: dict[str, Any]) -> None:
        for ident, element in message.items():
            if (
                ident.isdigit()
                and element
                and element.get("props", {}).get("data-testid") == SLIDER
            ):
                listener = next(
                    event["listener_id"] for event in element["events"]
                    if event["type"] == "update:modelValue" and not event.get("js_handler")
                )  # fmt: skip
                self.slider = int(ident), listener

    async def _asked(self, message: dict[str, Any]) -> None:
        if message.get("request_id"):
            await self.socket.emit("javascript_response", {
                "request_id": message["request_id"], "client_id": self.client, "result": False,
            })  # fmt: skip
        self.answered += message["code"].startswith("layerjamLive")

    async def move(self, value: float) -> None:
        """The slider at a value [kPa], as the browser tells it."""
        assert self.slider is not None
        ident, listener = self.slider
        await self.socket.emit("event", {
            "id": ident, "client_id": self.client, "listener_id": listener,
            "args": [json.dumps(value)],
        })  # fmt: skip


async def run(place: str, count: int, pause: float) -> None:
    """All of them."""
    sessions = [Session(place) for _ in range(count)]
    for session in sessions:
        await session.begin()
    print("ready", flush=True)
    for session in sessions:
        session.answered = 0
    closed = asyncio.create_task(asyncio.to_thread(sys.stdin.read))
    moves = 0
    while not closed.done():
        value = LOW + (HIGH - LOW) * (moves % 40) / 40
        for session in sessions:
            await session.move(value)
            await asyncio.sleep(pause / count)
        moves += 1
    print(moves * count, sum(session.answered for session in sessions), flush=True)
    for session in sessions:
        await session.socket.disconnect()


if __name__ == "__main__":
    asyncio.run(run(sys.argv[1], int(sys.argv[2]), float(sys.argv[3])))
