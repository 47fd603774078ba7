"""What a file that is not there may have been meant to be."""

from __future__ import annotations

import difflib
from pathlib import Path

MOST = 5_000
"""Names of a folder that are compared."""


def nearby(path: Path) -> str:
    """The end of a sentence about a missing file: the nearest name in its folder, or nothing."""
    try:
        if path.exists():
            return ""
        there = [one.name for one, _ in zip(path.parent.iterdir(), range(MOST), strict=False)]
    except (OSError, ValueError):
        return ""
    near = difflib.get_close_matches(path.name, there, n=1, cutoff=0.8)
    return f"; did you mean {path.with_name(near[0])}?" if near else ""
