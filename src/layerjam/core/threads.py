"""Threads: their number, and a cache that they share."""

import functools
import itertools
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

import numpy as np

P = ParamSpec("P")
R = TypeVar("R")


def core_count() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cache_threadsafe(make: Callable[P, R]) -> Callable[P, R]:
    """Call `make` once for each set of arguments; other threads wait for the result.

    With `functools.cache`, several threads would compile the same loop, which takes seconds.
    """
    results: dict[Any, R] = {}
    lock = threading.RLock()

    @functools.wraps(make)
    def get(*args: P.args, **named: P.kwargs) -> R:
        key = (args, tuple(sorted(named.items())))
        with lock:
            if key not in results:
                results[key] = make(*args, **named)
            return results[key]

    return get


class Workers(ThreadPoolExecutor):
    """A pool of threads, one for each core."""

    def __init__(self, threads: int | None = None) -> None:
        super().__init__(threads or core_count())

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Wait for the work; after an error or an interrupt, only for that already begun."""
        self.shutdown(cancel_futures=kind is not None)

    def share(self, count: int, work: Callable[[int, int], None]) -> None:
        """Run `work(first, last)` over `count` cases, one range for each core, and wait for all."""
        edges = np.linspace(0, count, core_count() + 1).astype(int)
        parts = [self.submit(work, int(a), int(b)) for a, b in itertools.pairwise(edges) if b > a]
        for part in parts:
            part.result()
