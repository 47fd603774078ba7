"""Symbolic links, which not every system makes."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest


def link(path: Path, target: str | Path) -> bool:
    """Whether a link was made: Windows lets only administrators, and Wine makes none."""
    with contextlib.suppress(OSError):
        path.symlink_to(target, target_is_directory=Path(target).is_dir())
    return path.is_symlink()


def require_link(path: Path, target: str | Path) -> None:
    """Make a link, or skip the test."""
    if not link(path, target):
        pytest.skip("this system lets this user make no link")
