"""Double precision and repeatable random examples for every test."""

from __future__ import annotations

import os
from pathlib import Path

import jax
from hypothesis import settings

jax.config.update("jax_enable_x64", True)
# what one worker has compiled the other need not; most of a test's time is compiling
COMPILED = Path(__file__).parents[1] / ".pytest_cache" / "compiled"
jax.config.update("jax_compilation_cache_dir", str(COMPILED))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.05)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)

settings.register_profile("quick", derandomize=True, deadline=None, max_examples=60, database=None)
settings.register_profile("deep", deadline=None, max_examples=2000, database=None)
settings.load_profile(os.environ.get("LAYERJAM_HYPOTHESIS", "quick"))
