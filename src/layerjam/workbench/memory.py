"""Releases the memory of closed tabs on a server that runs for weeks, without pausing others."""

import asyncio
import gc
import sys

from nicegui import Client, run

USUAL = (700, 10, 10)
"""Python's default settings of the garbage collector; see `cli.start.SELDOM`."""
SOON = 0.5
"""Time allowed for sending and drawing a page's first result [s]."""
_frozen_pages: set[str] = set()


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


async def freeze_after_result(page: str) -> None:
    """Call `freeze_modules` once the page's first result has reached the browser."""
    if page not in _frozen_pages:
        _frozen_pages.add(page)
        await asyncio.sleep(SOON)
        await run.io_bound(freeze_modules)


def freeze_modules() -> None:
    """Exclude loaded modules from garbage collection, which paused one move in a hundred for 0.3 s.

    From then on the collector runs at Python's usual rate. At the lower rate that the command line
    sets, closed pages would accumulate.
    """
    gc.set_threshold(*USUAL)
    gc.collect()
    gc.freeze()
