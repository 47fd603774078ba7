"""Threads: their number, their precision, and a cache that they share."""

import functools
import itertools
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

import numpy as np

P = ParamSpec("P")
R = TypeVar("R")


def core_count() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cache_threadsafe(make: Callable[P, R]) -> Callable[P, R]:
    """Call `make` once for each set of arguments; other threads wait for the result.

    It is for compiled loops, which take seconds: `functools.cache` would let several threads
    compile.
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
    """A pool of threads, one for each core, that compute in double precision.

    JAX sets the precision for each thread; a worker does not inherit that of its creator.
    """

    def __init__(self, threads: int | None = None) -> None:
        super().__init__(threads or core_count())

    def submit(self, work: Callable[P, R], /, *args: P.args, **named: P.kwargs) -> Future[R]:
        """Return the future result of `work(*args, **named)`."""
        return super().submit(functools.partial(_run_in_double, work), *args, **named)

    def share(self, count: int, work: Callable[[int, int], None]) -> None:
        """Run `work(first, last)` over `count` cases, one range for each core, and wait for all."""
        edges = np.linspace(0, count, core_count() + 1).astype(int)
        parts = [self.submit(work, int(a), int(b)) for a, b in itertools.pairwise(edges) if b > a]
        for part in parts:
            part.result()


def _run_in_double(work: Callable[..., R], *args: Any, **named: Any) -> R:
    from layerjam.mechanics.law import double_precision

    with double_precision():
        return work(*args, **named)
