"""Random cases of a long test: a share in `make slow`, all of them in `make campaigns`."""

from __future__ import annotations

import os

FULL = bool(os.environ.get("LAYERJAM_FULL"))


def cases(full: int, usual: int) -> int:
    """Return `full` where all random cases are asked for, otherwise `usual`."""
    return full if FULL else usual
