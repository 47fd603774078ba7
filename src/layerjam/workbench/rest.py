"""What a server that stays up does with its memory: no pause under a slider, little held at rest.

JAX keeps what it has compiled and everything it compiled it from: some 200 MB once all pages were
used. Compiled again from the cache on disk a page takes about half a second longer, once.
"""

from __future__ import annotations

import asyncio
import ctypes
import gc
import mmap
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nicegui import run

REST = 120.0
"""Seconds without a computation after which what was compiled is given back."""

USUAL = (700, 10, 10)
"""Python's own settings of its collector, see `cli.start.SELDOM`."""

SOON = 2.0
"""Seconds after a page's first result in which it is sent and drawn."""


class Work:
    """Who computes now, and since when nobody does."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._door = threading.Lock()
        self._working = 0
        self._last = clock()
        self._holding = False
        self._answered: set[str] = set()

    def first(self, page: str) -> bool:
        """Whether this is the first result of that page in this process, or since a rest."""
        with self._door:
            known = page in self._answered
            self._answered.add(page)
            return not known

    @contextmanager
    def going_on(self) -> Iterator[None]:
        """While something is computed, nothing is given back, and nothing begins meanwhile."""
        with self._door:
            self._working += 1
            self._holding = True
        try:
            yield
        finally:
            with self._door:
                self._working -= 1
                self._last = self._clock()

    def give_back(self) -> bool:
        """After a rest, drop what was compiled; whether that was done now."""
        with self._door:
            if self._working or not self._holding or self._clock() - self._last < REST:
                return False
            if "jax" in sys.modules:
                sys.modules["jax"].clear_caches()
            gc.unfreeze()
            settle()
            leave_code()
            self._holding = False
            self._answered.clear()
            return True


WORK = Work()
"""The server's."""


def forget_routes() -> None:
    """Once a tab is gone, let go of it.

    FastAPI remembers what kind of function each route's is, and with it the function: that of an
    upload holds its element, and so the whole page, about a megabyte for every reload.
    """
    module = sys.modules.get("fastapi.dependencies.models")
    for known in list(vars(module).values()) if module is not None else ():
        if hasattr(known, "cache_clear"):
            known.cache_clear()


async def elsewhere(function: Callable[..., Any], *given: Any) -> Any:
    """`function(*given)` in another thread, as work; None where the program is being ended."""

    def counted() -> Any:
        with WORK.going_on():
            return function(*given)

    return await run.io_bound(counted)


async def settle_later() -> None:
    """`settle` once what was just shown has reached the browser."""
    await asyncio.sleep(SOON)
    await elsewhere(settle)


def settle() -> None:
    """After something was loaded: it will stay, and no collection has to go through it again.

    Without this, one move in a hundred waits a third of a second for Python's collector. From now
    on it looks as often as usual: the command line looks seldom, and closed pages would pile up.
    """
    gc.set_threshold(*USUAL)
    gc.collect()
    gc.freeze()
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # glibc's alone
        if trim is not None:
            trim(0)


def leave_code() -> None:
    """Let the system have the pages of libraries: it reads them again where they are needed.

    JAX, LLVM and the others are some 200 MB of this process while it does nothing. Their pages stay
    in the system's own cache of files as long as there is room, so that this costs milliseconds.
    """
    if sys.platform == "linux":
        advise = ctypes.CDLL(None).madvise
        advise.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
        with Path("/proc/self/smaps").open(encoding="utf-8") as parts:  # a kB for each of thousands
            for start, size in _only_read(parts):
                advise(start, size, mmap.MADV_DONTNEED)


def _only_read(lines: Iterable[str]) -> Iterator[tuple[int, int]]:
    """(address, bytes) of mapped files that may not be written, and that nothing was written to.

    What the loader wrote into a page before it was closed is not in the file: such a part stays.
    """
    part: tuple[int, int] | None = None
    for line in lines:
        first, *rest = line.split()
        if not first.endswith(":"):
            start, end = (int(number, 16) for number in first.split("-"))
            closed = "w" not in rest[0] and rest[4:] != [] and rest[4].startswith("/")
            part = (start, end - start) if closed else None
        elif first == "Anonymous:" and part is not None and int(rest[0]) == 0:
            yield part
