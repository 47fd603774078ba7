"""Samples as a board sends them: blocks of packed records."""

from __future__ import annotations

from typing import Any

import numpy as np

from layerjam.rig.line import LineError

RECORD = np.dtype(
    [
        ("seq", "<u4"),
        ("board_us", "<u4"),
        ("vacuum", "<f4"),
        ("target", "<f4"),
        ("raw", "<u2"),
        ("temperature", "<i2"),
        ("pump", "u1"),
        ("flags", "u1"),
        ("state", "u1"),
        ("fault", "u1"),
    ]
)
"""One record of 24 bytes; vacuum and target [Pa], temperature [0.01 degC], |pump| over 255."""


def payload(block: bytes) -> bytes:
    """What a definite-length block holds; LineError where it is none or not whole."""
    digits = block[1:2]
    if block[:1] == b"#" and digits.isdigit() and digits != b"0":
        begin = 2 + int(digits)
        if block[2:begin].isdigit() and len(block) == begin + int(block[2:begin]):
            return block[begin:]
    raise LineError(f"no block of data came, but {block[:40]!r}")


def records(block: bytes) -> np.ndarray[Any, Any]:
    """The records of a block, an array of RECORD of shape (N,)."""
    data = payload(block)
    if len(data) % RECORD.itemsize:
        raise LineError(f"a block of {len(data)} bytes holds no whole records")
    return np.frombuffer(data, RECORD)
