"""Double precision and repeatable random examples for every test."""

from __future__ import annotations

import os

import jax
from hypothesis import settings

jax.config.update("jax_enable_x64", True)

settings.register_profile("quick", derandomize=True, deadline=None, max_examples=60, database=None)
settings.register_profile("deep", deadline=None, max_examples=2000, database=None)
settings.load_profile(os.environ.get("LAYERJAM_HYPOTHESIS", "quick"))
