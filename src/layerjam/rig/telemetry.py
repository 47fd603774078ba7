"""Samples as a board sends them: blocks of packed records, and the board's clock in them."""

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
PERIOD = 10_000
"""Between two samples [us], as a board means it."""
COUNT = 1 << 32
"""Where `board_us` wraps: after 71.6 minutes."""


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


def unwrapped(
    board_us: np.ndarray[Any, Any], seq: np.ndarray[Any, Any], last: tuple[int, int] | None = None
) -> np.ndarray[Any, Any]:
    """The board's clock [us] without wraps, int64 of shape (N,).

    `last` is (seq, unwrapped us) of a sample before; without one the first stays as it is. Right
    across any gap: the samples' numbers say how many wraps there were, as long as the board's
    clock is within 35 minutes of one sample every 10 ms.
    """
    counts, numbers = board_us.astype(np.int64), seq.astype(np.int64)
    if not len(counts):
        return counts
    begun, at = last if last is not None else (int(numbers[0]), int(counts[0]))
    due = (numbers - begun) * PERIOD
    passed: np.ndarray[Any, Any] = (counts - at - due + COUNT // 2) % COUNT - COUNT // 2 + due
    return at + passed
