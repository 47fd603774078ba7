"""Blocks of a sweep on a Dask cluster: workers compute, this process writes.

A task is one block and gives back its file's bytes, so that workers need no disk in common. What a
lost worker had is computed again elsewhere, to the same bytes.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import itertools
import pickle
import threading
from collections.abc import Iterator, Sequence
from typing import Any

from layerjam.design.blocks import encoded, fingerprint
from layerjam.design.search import Search
from layerjam.errors import LayerjamError, MissingExtraError

AHEAD = 3
"""Blocks given out for each thread of the cluster: none waits, little is lost."""
PATIENCE = 20.0
"""Seconds to wait for the scheduler and for the first worker."""
TRIM_THRESHOLD, MMAP_THRESHOLD, KEPT = -1, -3, 1 << 28
"""Options of glibc's mallopt, and bytes."""
_making = threading.Lock()


class ClusterError(LayerjamError):
    """A cluster that cannot be reached or has given up."""


@functools.lru_cache(maxsize=4)
def _search(packed: bytes) -> tuple[Search, str]:
    import jax

    jax.config.update("jax_enable_x64", True)
    _keep_memory()
    spec, block = pickle.loads(packed)
    return Search(spec, block), fingerprint(spec, block)


def _keep_memory() -> None:
    """Let freed memory be used again at once.

    Dask's nanny starts workers with MALLOC_TRIM_THRESHOLD_ so low that every array of a chunk comes
    as fresh pages from the system, which doubles the time of a block.
    """
    with contextlib.suppress(OSError, AttributeError):  # no glibc: nothing to undo
        set_option = ctypes.CDLL(None).mallopt
        for option in (TRIM_THRESHOLD, MMAP_THRESHOLD):
            set_option(option, KEPT)


def work(packed: bytes, index: int) -> bytes:
    """One block's file, on a worker."""
    with _making:
        search, mark = _search(packed)
    return encoded(search, index, search.block(index), mark)


@contextlib.contextmanager
def _joined(scheduler: str) -> Iterator[tuple[Any, Any]]:
    """(Dask's module, a client) of a cluster that has a worker."""
    with MissingExtraError.raise_if_missing("a sweep on a cluster (dask)", "cluster"):
        import distributed
    untyped: Any = distributed
    try:
        client: Any = untyped.Client(scheduler, timeout=PATIENCE)
    except (OSError, TimeoutError, ValueError) as err:
        raise ClusterError(f"scheduler: {scheduler} cannot be reached ({err})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise ClusterError(f"scheduler: {scheduler} has no workers") from None
        yield untyped, client


def reach(scheduler: str) -> None:
    """Raise what `spread` would where there is no cluster; said before a folder is made."""
    with _joined(scheduler):
        pass


def spread(search: Search, blocks: Sequence[int], scheduler: str) -> Iterator[tuple[int, bytes]]:
    """(block, bytes of its file) as the workers finish them, in any order.

    Raises MissingExtraError without Dask and ClusterError where the scheduler or every worker is
    out of reach, or a block has failed again and again.
    """
    with _joined(scheduler) as (untyped, client):
        threads = sum(client.nthreads().values())
        packed = pickle.dumps((search.spec, search.size))
        waiting = iter(blocks)
        running: dict[Any, int] = {}
        done: Any = untyped.as_completed()

        def give(count: int) -> None:
            for index in itertools.islice(waiting, count):
                future = client.submit(work, packed, index, pure=False, retries=2)
                running[future] = index
                done.add(future)

        give(max(1, threads) * AHEAD)
        for future in done:
            index = running.pop(future)
            try:
                data = future.result()
            except Exception as err:  # of the worker; Dask hands on whatever it was
                raise ClusterError(
                    f"block {index} failed on the cluster: {type(err).__name__}: {err}"
                ) from None
            give(1)
            yield index, data


__all__ = ["ClusterError", "reach", "spread", "work"]
