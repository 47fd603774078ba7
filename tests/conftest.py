"""Double precision and repeatable random examples for every test."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import jax
import pytest
from hypothesis import settings

jax.config.update("jax_enable_x64", True)

settings.register_profile("quick", derandomize=True, deadline=None, max_examples=60, database=None)
settings.register_profile("deep", deadline=None, max_examples=2000, database=None)
settings.load_profile(os.environ.get("LAYERJAM_HYPOTHESIS", "quick"))

LARGEST = 2.5e9
"""Bytes of a test process from which JAX forgets what it has compiled."""


@pytest.fixture(autouse=True, scope="module")
def _room() -> Iterator[None]:
    """Thousands of compiled laws take gigabytes: two workers have to fit beside each other."""
    yield
    held = Path("/proc/self/statm")
    if held.exists():
        pages = int(held.read_text(encoding="ascii").split()[1])
        if pages * os.sysconf("SC_PAGE_SIZE") > LARGEST:
            jax.clear_caches()
