"""Samples from a board: blocks of packed records, with the board's clock."""

from typing import Any

import numpy as np

from layerjam.bench.rig.line import LineError

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
"""One record of 24 bytes: vacuum and target [Pa], temperature [0.01 degC], |pump| from 0 to 255."""
PERIOD = 10_000
"""Nominal time between two samples [us]."""
COUNT = 1 << 32
"""Range of `board_us` [us], which overflows after 71.6 minutes."""


def read_payload(block: bytes) -> bytes:
    """Return the content of a definite-length block; raises LineError if it is invalid."""
    digits = block[1:2]
    if block[:1] == b"#" and digits.isdigit() and digits != b"0":
        begin = 2 + int(digits)
        if block[2:begin].isdigit() and len(block) == begin + int(block[2:begin]):
            return block[begin:]
    raise LineError(f"expected a block of data, got {block[:40]!r}")


def parse_records(block: bytes) -> np.ndarray[Any, Any]:
    """Return the records of a block, an array of RECORD of shape (N,)."""
    data = read_payload(block)
    if len(data) % RECORD.itemsize:
        raise LineError(f"a block of {len(data)} bytes does not contain complete records")
    return np.frombuffer(data, RECORD)


def unwrap_clock(
    board_us: np.ndarray[Any, Any], seq: np.ndarray[Any, Any], last: tuple[int, int] | None = None
) -> np.ndarray[Any, Any]:
    """Return the board's clock [us] without overflows, int64 of shape (N,).

    `last` is (seq, unwrapped us) of an earlier sample; without one, the first value is unchanged.
    The result is correct across any gap, because the sample numbers determine the number of
    overflows. The board's clock must not differ by more than 35 minutes from 10 ms per sample.
    """
    counts, numbers = board_us.astype(np.int64), seq.astype(np.int64)
    if not len(counts):
        return counts
    start, start_us = last if last is not None else (int(numbers[0]), int(counts[0]))
    expected_times = (numbers - start) * PERIOD
    delays: np.ndarray[Any, Any] = (
        counts - start_us - expected_times + COUNT // 2
    ) % COUNT - COUNT // 2
    return start_us + expected_times + delays
