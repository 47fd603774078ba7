"""Suggestion of an existing file in place of a missing one."""

import difflib
from pathlib import Path

MAX_NAMES = 5_000
"""Number of names in a folder that are compared."""


def nearby(path: Path) -> str:
    """Return a suggestion of the nearest name in a missing file's folder, or ""."""
    try:
        if path.exists():
            return ""
        names = [p.name for p, _ in zip(path.parent.iterdir(), range(MAX_NAMES), strict=False)]
    except (OSError, ValueError):
        return ""
    matches = difflib.get_close_matches(path.name, names, n=1, cutoff=0.8)
    return f"; did you mean {path.with_name(matches[0])}?" if matches else ""
