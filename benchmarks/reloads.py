"""Memory of the workbench under many people: reloads, tabs that stay, and sessions that all move.

Run alone: `python -m benchmarks.reloads [RELOADS [TABS]]`. The browsers are left out: a session is
what the server sees of one, so that the numbers are the server's alone.
"""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Callable

from benchmarks.first_page import started
from benchmarks.sessions import Session
from benchmarks.timing import Row, table
from benchmarks.workbench import GONE, memory, others

RELOADS, TABS, SESSIONS = 400, 20, 10
SECONDS = 20.0
"""That the sessions move for."""
LONG = 120.0
"""Seconds a page may take."""
MOST = 0.5


async def come(place: str) -> Session:
    """One more tab, with its first curve."""
    session = Session(place)
    while True:
        try:
            await asyncio.wait_for(session.begin(), LONG)
        except OSError:  # the server has said its address and does not listen yet
            await asyncio.sleep(0.1)
        else:
            return session


async def reload(place: str, times: int) -> None:
    """A tab that is opened and closed so many times."""
    for _ in range(times):
        session = await come(place)
        await session.socket.disconnect()


async def together(place: str, count: int) -> list[Session]:
    """So many tabs that stay."""
    return [await come(place) for _ in range(count)]


def moved(place: str, process: int) -> float:
    """GB after sessions have all moved for a while."""
    with others(place, SESSIONS):
        time.sleep(SECONDS)
        return memory(process)


def rows(reloads: int = RELOADS, tabs: int = TABS) -> list[Row]:
    """What the server holds, step by step; the last row is what the promise is about."""
    out = []
    with started() as (place, process, _):

        def seen(what: str, most: float | None = None) -> None:
            out.append(Row(what, memory(process), most, unit="GB"))

        asyncio.run(reload(place, 1))
        time.sleep(GONE)
        seen("one tab, gone again")
        for part in (reloads // 2, reloads):
            asyncio.run(reload(place, reloads // 2))
            time.sleep(GONE)
            seen(f"after {part} reloads", MOST)
        out.append(Row(f"{SESSIONS} sessions that move", moved(place, process), None, unit="GB"))
        asyncio.run(_stay(place, tabs, lambda: seen(f"{tabs} tabs at once")))
        time.sleep(GONE)
        seen("once all are closed", MOST)
    return out


async def _stay(place: str, tabs: int, look: Callable[[], None]) -> None:
    sessions = await together(place, tabs)
    look()
    for session in sessions:
        await session.socket.disconnect()


if __name__ == "__main__":
    print(table(rows(*map(int, sys.argv[1:]))))
