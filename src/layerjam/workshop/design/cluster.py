"""Blocks of a sweep on a Dask cluster: workers compute them, and this process writes them.

A task is one block and returns the bytes of its file, so workers need no shared disk. Another
worker recomputes the blocks of a lost worker, and the resulting bytes are the same.
"""

import contextlib
import ctypes
import functools
import itertools
import pickle
import threading
from collections.abc import Iterator, Sequence
from typing import Any

from layerjam.core.errors import LayerjamError, MissingExtraError
from layerjam.workshop.design.blocks import encode_block, fingerprint
from layerjam.workshop.design.search import Search

BLOCKS_PER_THREAD = 3
"""Number of blocks submitted per thread, so that no thread waits and little work can be lost."""
PATIENCE = 20.0
"""Seconds to wait for the scheduler and for the first worker."""
TRIM_THRESHOLD, MMAP_THRESHOLD, KEPT = -1, -3, 1 << 28
"""Options for glibc's mallopt, and the number of freed bytes that it keeps."""
_search_lock = threading.Lock()


class ClusterError(LayerjamError):
    """Error raised if a cluster cannot be reached or has failed."""


@functools.lru_cache(maxsize=4)
def _load_search(pickled_search: bytes) -> tuple[Search, str]:
    _reuse_freed_memory()
    spec, block = pickle.loads(pickled_search)
    return Search(spec, block), fingerprint(spec, block)


def _reuse_freed_memory() -> None:
    """Allow freed memory to be reused immediately.

    Dask's nanny starts workers with such a low MALLOC_TRIM_THRESHOLD_ that every array of a chunk
    needs new pages from the system, which doubles the time for a block.
    """
    with contextlib.suppress(OSError, AttributeError, TypeError):  # mallopt needs glibc
        set_option = ctypes.CDLL(None).mallopt
        for option in (TRIM_THRESHOLD, MMAP_THRESHOLD):
            set_option(option, KEPT)


def compute_block(pickled_search: bytes, index: int) -> bytes:
    """Return the file of one block, computed on a worker."""
    with _search_lock:
        search, mark = _load_search(pickled_search)
    return encode_block(search, index, search.run_block(index), mark)


@contextlib.contextmanager
def _connect_client(scheduler: str) -> Iterator[tuple[Any, Any]]:
    """Yield (Dask module, client) for a cluster that has at least one worker."""
    with MissingExtraError.raise_if_missing("a sweep on a cluster (dask)", "cluster"):
        import distributed
    dask: Any = distributed
    try:
        client: Any = dask.Client(scheduler, timeout=PATIENCE)
    except (OSError, TimeoutError, ValueError) as err:
        raise ClusterError(f"scheduler: {scheduler} cannot be reached ({err})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise ClusterError(f"scheduler: {scheduler} has no workers") from None
        yield dask, client


def check_cluster(scheduler: str) -> None:
    """Raise the same errors as `compute_blocks` if the cluster cannot be reached."""
    with _connect_client(scheduler):
        pass


def compute_blocks(
    search: Search, blocks: Sequence[int], scheduler: str
) -> Iterator[tuple[int, bytes]]:
    """Yield (block, bytes of its file) as the workers finish them, in any order.

    Raises MissingExtraError if Dask is not installed. Raises ClusterError if the scheduler or all
    workers are unreachable, or if a block fails repeatedly.
    """
    with _connect_client(scheduler) as (dask, client):
        threads = sum(client.nthreads().values())
        pickled_search = pickle.dumps((search.spec, search.size))
        waiting = iter(blocks)
        running: dict[Any, int] = {}
        results: Any = dask.as_completed()

        def submit_block(count: int) -> None:
            for index in itertools.islice(waiting, count):
                future = client.submit(compute_block, pickled_search, index, pure=False, retries=2)
                running[future] = index
                results.add(future)

        submit_block(max(1, threads) * BLOCKS_PER_THREAD)
        for future in results:
            index = running.pop(future)
            try:
                data = future.result()
            except Exception as err:  # Dask passes on any exception of a worker
                raise ClusterError(
                    f"block {index} failed on the cluster: {type(err).__name__}: {err}"
                ) from None
            submit_block(1)
            yield index, data
