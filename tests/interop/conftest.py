"""Chromium for the tests of pages."""

from __future__ import annotations

from workbench.conftest import chromium  # noqa: F401
