"""Detection of files that a program generated, by their own text or by their sidecar."""

import re

from layerjam.core.errors import Notice

SYNTHETIC = Notice("synthetic: written by a program, not measured", "synthetic")
"""Notice for every result that uses such a file."""
_WORD = re.compile(rb"(?i)\bsynthetic\b")


def is_marked_synthetic(head: bytes) -> bool:
    """Return whether the lines above a file's numbers contain the word "synthetic"."""
    return _WORD.search(head) is not None
