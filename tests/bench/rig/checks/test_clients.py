"""Checks 10 and 11: eight clients at once, and one that has the lock."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable

import pytest

pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")

from bench.rig.checks.served import Served
from bench.rig.checks.visa import client, error

pytestmark = pytest.mark.slow
CLIENTS, QUERIES = 8, 400
KINDS = ("*ESE?", "SYST:ERR?", "SYST:VERS?", "*OPC?", "own")


def test_10_eight_clients_are_never_mixed(served: Served, figure: Callable[[str], None]) -> None:
    """Every client has an `*ESE` and mistakes of its own; their answers belong to it alone."""
    wrong: list[str] = []
    times: list[float] = []

    def use(number: int) -> None:
        draw = random.Random(number)
        with client(served) as made:
            made.write(f"*ESE {number}")
            for _ in range(QUERIES):
                kind, begun = draw.choice(KINDS), time.perf_counter()
                if kind == "own":
                    made.write(f"MINE{number}")
                    said = made.query("SYST:ERR?")
                    right = said.startswith("-113") and f"MINE{number}" in said
                else:
                    said = made.query(kind)
                    due = {"*ESE?": str(number), "SYST:VERS?": "1999.0", "*OPC?": "1"}
                    right = said == due.get(kind, '0,"No error"')
                times.append(time.perf_counter() - begun)
                if not right:
                    wrong.append(f"client {number}: {kind} {said}")

    threads = [threading.Thread(target=use, args=(n,)) for n in range(1, CLIENTS + 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    times.sort()
    assert wrong == [] and len(times) == CLIENTS * QUERIES
    figure(
        f"10  {CLIENTS} clients × {QUERIES} queries: 0 mixed, median "
        f"{times[len(times) // 2] * 1e3:.2f} ms, p99 {times[len(times) * 99 // 100] * 1e3:.1f} ms"
    )


def test_11_the_lock(served: Served, figure: Callable[[str], None]) -> None:
    with client(served) as mine, client(served) as other:
        assert mine.query("SYST:LOCK:REQ?") == "1"
        assert other.query("SYST:LOCK:REQ?") == "0"
        other.write("SOUR:VAC 1")
        assert error(other) == -203
        other.write("OUTP ON")
        assert error(other) == -203
        other.write("OUTP OFF")
        assert error(other) == 0
        other.write("ABOR")
        assert error(other) == 0
        mine.write("SOUR:VAC 0")
        assert error(mine) == 0
    with client(served) as after:
        for _ in range(100):
            if after.query("SYST:LOCK:OWN?") == '"NONE"':
                break
        after.write("SOUR:VAC 0")
        assert error(after) == 0
    figure("11  locked: another's SOUR:VAC -203, OUTP OFF and ABOR obeyed; freed with its client")
