"""Samples as a board sends them: blocks of packed records, and the board's clock in them."""

from __future__ import annotations

from dataclasses import dataclass
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


@dataclass(frozen=True)
class ClockFit:
    """The host's clock over the board's: host = begin + rate (board - board0)."""

    board0: int
    begin: float
    """[ns] of the host at `board0` [us]."""
    rate: float
    """Nanoseconds of the host over those of the board."""
    delay: float
    """Median delay of a block [ns] over the quickest."""


def fit_clock(board_us: np.ndarray[Any, Any], host_ns: np.ndarray[Any, Any]) -> ClockFit:
    """The line below the arrivals of blocks, shape (N,) each: none comes before it was sent.

    Least squares over the quicker half, five times; then moved down to the quickest.
    """
    board0 = int(board_us[0])
    x = (board_us - board0) * 1e3
    y = (host_ns - host_ns[0]).astype(float)
    kept = np.ones(len(x), bool)
    rate, begin = 1.0, 0.0
    for _ in range(5):
        if np.ptp(x[kept]) > 0:
            rate, begin = np.polyfit(x[kept], y[kept], 1)
        left = y - rate * x
        kept = left <= np.median(left)
    left = y - rate * x
    begin = float(left.min())
    return ClockFit(board0, float(host_ns[0]) + begin, float(rate), float(np.median(left) - begin))
