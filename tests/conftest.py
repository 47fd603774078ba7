"""Double precision and repeatable random examples for every test."""

from __future__ import annotations

import ctypes
import gc
import os
from collections.abc import Iterator
from pathlib import Path

import jax
import pytest
from hypothesis import settings

# what one process has compiled no other need; most of a test's time is compiling
COMPILED = Path(__file__).parents[1] / ".pytest_cache" / "compiled"
CACHE = {
    "jax_compilation_cache_dir": str(COMPILED),
    "jax_persistent_cache_min_compile_time_secs": 0.05,
    "jax_persistent_cache_min_entry_size_bytes": -1,
}
jax.config.update("jax_enable_x64", True)
for name, value in CACHE.items():
    jax.config.update(name, value)
    os.environ[name.upper()] = str(value)

settings.register_profile("quick", derandomize=True, deadline=None, max_examples=60, database=None)
settings.register_profile("deep", deadline=None, max_examples=2000, database=None)
settings.load_profile(os.environ.get("LAYERJAM_HYPOTHESIS", "quick"))


MOST_MEMORY = 2_000_000_000
"""Bytes of a worker beyond which compiled functions are given up; the cache on disk has them."""


@pytest.fixture(autouse=True, scope="module")
def _memory() -> Iterator[None]:
    """What one module has compiled does not stay in memory to the end of all tests."""
    yield
    if resident() > MOST_MEMORY:
        jax.clear_caches()
        gc.collect()
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # glibc's alone
        if trim is not None:
            trim(0)


def resident() -> int:
    """Bytes of memory that this process holds; zero where the system does not say."""
    statm = Path("/proc/self/statm")
    if not (statm.exists() and hasattr(os, "sysconf")):  # Wine shows /proc to Windows' Python
        return 0
    return int(statm.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")
