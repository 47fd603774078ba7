"""Python printed as C computes the same numbers; what cannot be printed is refused."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from c_printers.printer import format_program
from layerjam.brake.kernel.compiler import build_library


class Pair(NamedTuple):
    """A record with a name that C reserves."""

    short: float
    rows: Sequence[int]


LIMIT = 3
Word = int
MASK = 2**64 - 1


def swap_while(a: float, b: float) -> tuple[float, float]:
    """Return both, exchanged until the first is the larger."""
    while a < b or (a == b and not a < LIMIT):
        a, b = b, a - 1.0
    return a, b


def choose(triple: tuple[float, ...], case: int, pair: Pair) -> float:
    """Return something that depends on the order of every operation."""
    x, y, z = triple
    if case == 0:
        return x - (y - z) - -y / (z * (x + y))
    elif case == 1:
        low, high = (x, y) if x < y else (y, x)
        return max(low, min(high, z)) ** 2.0 - abs(x) + round(z)
    total = 0.0
    for n in range(case):
        total += pair.rows[n] * pair.short
        if n > LIMIT and total > 10.0:
            return -total
    return total if -1.0 < total <= 50.0 else math.inf


def spread(word: Word) -> Word:
    """Return a word whose bits are mixed."""
    return (word ^ (word >> 7)) * 0x9E3779B97F4A7C15 & MASK


def run_all(triple: tuple[float, ...], case: int, pair: Pair) -> tuple[float, float, float]:
    """Return the answers of the others."""
    x, y, _z = triple
    a, b = swap_while(x, y)
    return choose(triple, case, pair), a, b


def compiled(tmp_path: Path) -> Any:
    text = format_program("a test", FUNCTIONS, (Pair,), {"run_all", "spread"}, {"swap_while"})
    (tmp_path / "printed.c").write_text(text, "utf-8")
    flags = ("-Wall", "-Wextra", "-Werror")
    return ctypes.CDLL(str(build_library([tmp_path / "printed.c"], flags=flags)))


FUNCTIONS: tuple[Callable[..., Any], ...] = (swap_while, choose, spread, run_all)


def test_c_computes_what_python_does(tmp_path: Path) -> None:
    library = compiled(tmp_path)
    library.lj_spread.restype = ctypes.c_uint64
    rows = (3, -2, 7, 1, 9, 4, 0, 2)

    class InC(ctypes.Structure):
        _fields_ = (("short", ctypes.c_double), ("rows", ctypes.POINTER(ctypes.c_int64)))

    pair, numbers = Pair(0.7, rows), (0.1, -2.5, 3.3, 1e-3, 7.5)
    in_c = InC(0.7, (ctypes.c_int64 * 8)(*rows))
    for case in range(8):
        for x in numbers:
            for y in numbers:
                triple, out = (x, y, numbers[case % 5] + 0.01), (ctypes.c_double * 3)()
                args = (ctypes.c_double * 3)(*triple), ctypes.c_int64(case), ctypes.byref(in_c)
                library.lj_run_all(*args, out)
                assert tuple(out) == run_all(triple, case, pair)
    for word in (0, 1, 2**40 + 17, 2**64 - 1):
        assert library.lj_spread(ctypes.c_uint64(word)) == spread(word)


def listed(x: float) -> float:
    """Return the sum of a list."""
    return sum([x, x])


def caught(x: float) -> float:
    """Return x, whatever happens."""
    try:
        return x
    finally:
        pass


def uneven(x: float) -> tuple[float, ...]:
    """Return one number or two."""
    if x > 0.0:
        return x, x
    return x, x, x


def foreign(x: complex) -> float:
    """Return a length."""
    return abs(x)


@pytest.mark.parametrize("function", [listed, caught, uneven, foreign])
def test_what_cannot_be_printed_is_refused(function: Callable[..., Any]) -> None:
    with pytest.raises(TypeError, match=r"cannot be printed|different lengths"):
        format_program("a test", (function,), (), set(), set())
