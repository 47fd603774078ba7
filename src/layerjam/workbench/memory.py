"""Releases the memory of closed tabs on a server that runs for weeks, without pausing others."""

import asyncio
import gc
import sys

from nicegui import Client, run

WHILE_MOVING = (700, 10, 100)
"""Settings of the garbage collector, with a full search ten times less often than usual.

A full search takes up to 0.1 s, in which no move is answered. See also `cli.start.SELDOM`.
"""
PARTIAL_SEARCHES = 5
"""Number of partial searches for garbage after which a full one is worthwhile."""
IDLE_TIME = 0.5
"""Time since the last result after which nobody moves anything [s]."""
_frozen_pages: set[str] = set()
_latest: set[object] = set()
"""Token of the last result of all pages."""


def forget_tab() -> None:
    """Release the memory of a closed tab and, after the last one, compiled code.

    FastAPI caches the function of each route. An upload's function refers to its element, and so
    keeps the whole page in memory: about a megabyte for every reload.
    """
    module = sys.modules.get("fastapi.dependencies.models")
    for item in list(vars(module).values()) if module is not None else ():
        if hasattr(item, "cache_clear"):
            item.cache_clear()
    if len(Client.instances) <= 1:  # only the closed tab itself is left
        # JAX lacks this function while a thread imports it
        clear = getattr(sys.modules.get("jax"), "clear_caches", lambda: None)
        clear()
        gc.unfreeze()
        _frozen_pages.clear()


async def tidy_after_result(page: str) -> None:
    """Release memory once no page has had a further result for a while."""
    token = object()
    _latest.clear()
    _latest.add(token)
    await asyncio.sleep(IDLE_TIME)
    if token not in _latest:
        return
    if page not in _frozen_pages:
        _frozen_pages.add(page)
        await run.io_bound(freeze_modules)
    elif gc.get_count()[2] >= PARTIAL_SEARCHES:
        await run.io_bound(gc.collect)


def freeze_modules() -> None:
    """Exclude loaded modules from garbage collection, which paused one move in a hundred for 0.3 s.

    From then on the collector runs more often than at the rate that the command line sets, at which
    closed pages would accumulate.
    """
    gc.set_threshold(*WHILE_MOVING)
    gc.collect()
    gc.freeze()
