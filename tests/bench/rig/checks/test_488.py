"""Check 7: IEEE 488.2 and SCPI-99 over PyVISA: mandated commands, registers, error queue.

Bits after IEEE 488.2-1992, section 11, and SCPI-99 volume 1, chapters 4 and 9.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")

from bench.rig.checks.served import Served, serving
from bench.rig.checks.visa import client, error

pytestmark = pytest.mark.slow
MANDATED = (
    "*CLS",
    "*ESE 0",
    "*ESE?",
    "*ESR?",
    "*IDN?",
    "*OPC",
    "*OPC?",
    "*RST",
    "*SRE 0",
    "*SRE?",
    "*STB?",
    "*TST?",
    "*WAI",
)
SCPI_99 = {
    "SYST:ERR?": r'0,"No error"',
    "SYST:ERR:NEXT?": r'0,"No error"',
    "SYSTem:VERSion?": "1999.0",
    "STAT:OPER?": None,
    "STATus:OPERation:EVENt?": None,
    "STAT:OPER:COND?": None,
    "STAT:OPER:ENAB?": None,
    "STAT:QUES?": None,
    "STAT:QUES:EVEN?": None,
    "STAT:QUES:COND?": None,
    "STAT:QUES:ENAB?": None,
}
EVENT, QUEUE, QUESTIONABLE, MASTER, OPERATION = 1 << 5, 1 << 2, 1 << 3, 1 << 6, 1 << 7
COMPLETE, EXECUTION, COMMAND = 1, 1 << 4, 1 << 5
VENT_OPEN, ZERO_OLD, LOST = 1 << 9, 1 << 8, 1 << 11


@pytest.fixture
def made(served: Served) -> Iterator[Any]:
    with client(served) as opened:
        opened.write("*ESE 0;*SRE 0;:STAT:PRES")
        yield opened


def test_7_every_mandated_command_is_taken(made: Any, figure: Callable[[str], None]) -> None:
    for text in MANDATED:
        if text.endswith("?"):
            answer = made.query(text)
            assert answer and (text == "*IDN?" or int(answer) >= 0), text
        else:
            made.write(text)
        assert error(made) == 0, text
    for text, wanted in SCPI_99.items():
        answer = made.query(text)
        assert answer == wanted if wanted else int(answer) >= 0, text
    made.write("STAT:PRES")
    assert error(made) == 0
    figure(f" 7  {len(MANDATED)} commands of IEEE 488.2, {len(SCPI_99) + 1} headers of SCPI-99")


def test_7_the_headers_it_lists_are_all_known(made: Any) -> None:
    """Every header in its long and in its short form; what is asked in vain says why."""
    listed = (
        made.query_binary_values("SYST:HELP:HEAD?", datatype="B", container=bytes)
        .decode()
        .split("\n")
    )
    assert len(listed) > 40
    for header in (line.partition("/")[0] for line in listed):  # /qonly/ and /nquery/ follow
        long = header.replace("[", "").replace("]", "").upper()
        short = "".join(letter for letter in header if not letter.islower())
        short = short.replace("[", "").replace("]", "")
        for text in {long, short}:
            # one parameter too many: refused before anything is done, but a header that is known
            for ends in (" 'x','x','x','x','x','x'", "? 'x','x','x','x','x','x'"):
                made.write(text + ends)
                assert error(made) in (-108, -113, -221, -203), text + ends
            made.write(text + " 'x','x','x','x','x','x'")
            made.write(text + "? 'x','x','x','x','x','x'")
            assert -108 in (error(made), error(made)) or "MAIN" in text, text
    assert error(made) == 0


def test_7_the_standard_event_register(made: Any) -> None:
    """*OPC sets bit 0 as nothing is pending; reading clears; what is not enabled is quiet."""
    made.write("*ESE 60;*OPC")
    assert int(made.query("*STB?")) & EVENT == 0
    made.write("*ESE 61")
    assert int(made.query("*STB?")) & EVENT
    assert int(made.query("*ESR?")) == COMPLETE
    assert int(made.query("*ESR?")) == 0


def test_7_bits_sum_up_as_the_standard_says(made: Any) -> None:
    """The event is remembered until read, the condition is not touched by reading."""
    made.write(f"*ESE {COMMAND}")
    made.write("NOBODY")
    assert int(made.query("*STB?")) & (EVENT | QUEUE) == EVENT | QUEUE
    made.write(f"*SRE {EVENT}")
    assert int(made.query("*STB?")) & MASTER
    assert int(made.query("*ESR?")) == COMMAND
    assert int(made.query("*STB?")) & (EVENT | MASTER | QUEUE) == QUEUE
    assert error(made) == -113
    assert int(made.query("*STB?")) & QUEUE == 0
    made.write("SOUR:VAC -1")
    assert int(made.query("*ESR?")) == EXECUTION
    made.write("*SRE 255")
    assert int(made.query("*SRE?")) == 255 & ~MASTER
    made.write("*CLS")
    assert error(made) == 0
    assert int(made.query("*ESE?")) == COMMAND  # *CLS keeps the enables


def test_7_events_clear_on_reading_and_conditions_do_not(made: Any) -> None:
    """The vent is given its rest state, which opens it: a condition that rises."""
    made.write("OUTP:VENT:REST CLOS")
    made.query("*OPC?")
    wait_for(made, "STAT:OPER:COND?", lambda value: not value & VENT_OPEN)
    made.query("STAT:OPER?")
    made.write("OUTP:VENT:REST OPEN")
    wait_for(made, "STAT:OPER:COND?", lambda value: value & VENT_OPEN)
    made.write(f"STAT:OPER:ENAB {VENT_OPEN}")
    assert int(made.query("*STB?")) & OPERATION
    assert int(made.query("STAT:OPER:EVEN?")) & VENT_OPEN
    assert int(made.query("STAT:OPER:EVEN?")) & VENT_OPEN == 0
    assert int(made.query("*STB?")) & OPERATION == 0
    assert int(made.query("STAT:OPER:COND?")) & VENT_OPEN
    made.write("STAT:PRES")
    assert int(made.query("STAT:OPER:ENAB?")) == 0


def test_7_the_questionable_register_reaches_the_status_byte(tmp_path: Path) -> None:
    """A recorder that takes nothing for ten seconds loses samples: a condition that rises.

    An uncalibrated sensor is doubtful; a client that comes sees the condition, not an event.
    """
    with serving(tmp_path, "sim:choi2018?speed=20") as fast, client(fast) as made:
        assert int(made.query("STAT:QUES:COND?")) & ZERO_OLD
        assert int(made.query("STAT:QUES?")) & (ZERO_OLD | LOST) == 0
        made.write(f"STAT:QUES:ENAB {LOST}")
        made.write(f"STR:ACK {made.query('FETC:ALL?').split(',')[0]}")
        assert int(made.query("*STB?")) & QUESTIONABLE == 0
        wait_for(made, "*STB?", lambda value: value & QUESTIONABLE)
        assert int(made.query("STAT:QUES?")) & LOST
        assert int(made.query("*STB?")) & QUESTIONABLE == 0
        assert int(made.query("STAT:QUES:COND?")) & LOST
        assert int(made.query("SYST:ERR?").split(",")[0]) == 127


def test_7_the_queue_holds_sixteen_and_says_that_it_is_full(made: Any) -> None:
    for _ in range(17):
        made.write("NOBODY")
    assert int(made.query("SYST:ERR:COUN?")) == 16
    codes = [error(made) for _ in range(17)]
    assert codes == [-113] * 15 + [-350, 0]


def test_7_headers_keep_their_path_and_answers_come_in_one_line(made: Any) -> None:
    assert made.query("SYST:VERS?;*OPC?;ERR:COUN?") == "1999.0;1;0"
    assert made.query("*OPC?;:SYST:VERS?;VERS?") == "1;1999.0;1999.0"
    made.write("syst:vers?;NOBODY?;*OPC?")
    assert made.read() == "1999.0"
    assert error(made) == -113


def wait_for(made: Any, query: str, done: Callable[[int], int | bool]) -> None:
    end = time.monotonic() + 10
    while time.monotonic() < end:
        if done(int(made.query(query))):
            return
        time.sleep(0.005)
    raise AssertionError(f"{query} did not come to it")
