"""How a file says that a program wrote it: in its own words, or in the facts beside it."""

from __future__ import annotations

import re

from layerjam.errors import Notice

SYNTHETIC = Notice("synthetic: written by a program, not measured", "synthetic")
"""What every result says that rests on such a file."""
_WORD = re.compile(rb"(?i)\bsynthetic\b")


def says_synthetic(head: bytes) -> bool:
    """Whether the lines above a file's numbers say so."""
    return _WORD.search(head) is not None
