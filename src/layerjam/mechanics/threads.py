"""Loops that leave Python's lock, shared among the cores."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def shared(pool: ThreadPoolExecutor, count: int, work: Callable[[int, int], None]) -> None:
    """`work(first, last)` over `count` cases, one run of them to each core; waits for all."""
    edges = np.linspace(0, count, cores() + 1).astype(int)
    parts = [pool.submit(work, int(a), int(b)) for a, b in itertools.pairwise(edges) if b > a]
    for part in parts:
        part.result()
