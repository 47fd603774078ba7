"""What the board promises in its own time: samples on time, a host that does not read, a dead core.

Each test continues on one board, whose seconds cost half a minute of a processor each.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest

from bench.rig.boards import PLANT, law_words, regulator
from bench.rig.emulated.emulator import Emulated, missing

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]
LEASE = 0.8


@pytest.fixture(scope="module")
def board() -> Iterator[Emulated]:
    made = Emulated()
    made.plant = PLANT
    made.boot()
    yield made


@pytest.fixture(autouse=True)
def nothing_unread(board: Emulated) -> None:
    """No test reads what the one before it asked for."""
    board.synchronise()


def start(board: Emulated, lease: float) -> None:
    """A law, both declarations, 60 kPa asked for: the pump runs at once."""
    board.vacuum = 0.0
    assert board.ask(f"OUTP:SAFE REL;VENT:REST OPEN;:SYST:LEAS {lease};*OPC?") == "1"
    assert board.ask("CONT:LAW " + law_words(regulator()) + ";*OPC?", 3.0) == "1"
    assert board.ask("VAC 60 kPa;:OUTP ON;*OPC?") == "1"
    assert board.ask("OUTP?;:SYST:ERR?") == '1;0,"No error"'
    assert board.run(0.05, lambda: board.pump > 0.0)


def gaps(board: Emulated, begin: float) -> list[float]:
    """Times between samples, as the sensor sees them, since then."""
    seen = [time for time in board.samples if time >= begin]
    return [b - a for a, b in itertools.pairwise(seen)]


def test_samples_come_on_time_at_rest(board: Emulated) -> None:
    """Check 21."""
    begin = board.time
    board.run(2.0)
    between = gaps(board, begin)
    assert len(between) >= 198
    assert min(between) >= 9.8e-3 and max(between) <= 10.2e-3, (min(between), max(between))


def test_a_host_that_does_not_read_stops_no_sample(board: Emulated) -> None:
    """Check 20: 4.8 kB are waiting, nobody takes them; the samples go on, then the lease ends."""
    start(board, LEASE)
    board.hold()
    begin = board.time
    board.say("FETC:STR? 200")
    assert board.run(LEASE + 0.2, lambda: board.pump == 0.0)
    took = board.time - begin
    board.run(0.1)
    between = gaps(board, begin)
    assert max(between) <= 25e-3, max(between)
    assert took <= LEASE + 0.02 + 0.02, took
    board.synchronise()
    assert board.ask("OUTP:PROT:FAUL?") == '120,"LEASE_EXPIRED"'


def test_a_core_that_hangs_is_reset(board: Emulated) -> None:
    """Check 19: an endless loop with interrupts off; the pin of the pump is off within 110 ms."""
    if board.ask("OUTP:PROT:TRIP?") == "1":
        assert board.ask("OUTP:PROT:CLE;*CLS;*OPC?") == "1"
    start(board, 5.0)
    board.hang()
    begin, seen = board.time, board.connected
    assert board.run(0.3, lambda: board.pump == 0.0)
    assert board.time - begin <= 0.110, board.time - begin
    assert not board.vent
    board.pins()
    assert board.run(2.0, lambda: board.connected > seen)
    board.run(0.5)
    assert "WATCHDOG_RESET" in board.ask("SYST:ERR?")
    assert '"WATCHDOG"' in board.ask("SYST:BOOT?") and board.ask("OUTP?") == "0"
