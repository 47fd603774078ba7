"""Checks 8 and 9: the numbers of bad lines, and a hundred thousand lines of noise."""

from __future__ import annotations

import random
import socket
import time
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")

from bench.rig.bad_lines import BAD
from bench.rig.checks.served import Served, serving
from bench.rig.checks.visa import client, error

pytestmark = pytest.mark.slow
LINES = 100_000
BATCH = 500
WORDS = (
    "*IDN?",
    "SYST",
    ":",
    "ERR",
    "?",
    ";",
    "SOUR:VAC",
    " ",
    "1",
    "60 kPa",
    "OUTP",
    "ON",
    "'",
    '"',
    "#15",
    "@1",
    ",",
    "STAT:OPER",
    "FETC:STR?",
    "MIN",
    "e9",
    "-",
    "DIAG:DRIV 1,0,5",
    "CONT:LAW",
    "*RST",
    "\t",
    "INIT",
    "*TRG",
    "µ",
    "\x00",
    "\x80",
    "DEF",
    "ABOR",
    "SYST:LOCK:REQ?",
)


def test_8_every_bad_line_has_its_number(served: Served, figure: Callable[[str], None]) -> None:
    with client(served) as made:
        # `*RST` keeps settings, and the lines were written for a board that has none
        made.write("*RST;:SYST:SETT:DEF")
        for line, code in BAD:
            made.write_raw((line if isinstance(line, bytes) else line.encode("latin-1")) + b"\n")
            assert error(made) == code, line
        assert error(made) == 0
    assert len(BAD) >= 40
    figure(f" 8  {len(BAD)} bad lines, each with its number")


def noise(draw: random.Random) -> bytes:
    """Words of the language in any order, or bytes of any kind."""
    if draw.random() < 0.5:
        text = "".join(draw.choice(WORDS) for _ in range(draw.randrange(1, 12)))
        line = text.encode("latin-1")
    else:
        line = bytes(draw.randrange(256) for _ in range(draw.randrange(40)))
    return line.replace(b"\n", b"") + b"\n"


def test_9_a_hundred_thousand_random_lines(tmp_path: Path, figure: Callable[[str], None]) -> None:
    """After each batch one query whose answer is waited for: what is before it is noise."""
    draw, begun = random.Random(2018), time.monotonic()
    with serving(tmp_path, "sim:choi2018?speed=10") as made:
        with socket.create_connection(("127.0.0.1", made.port), 60) as line:
            file = line.makefile("rb")
            # a connection that begins with anything but a message is closed at once
            line.sendall(b"*IDN?\n")
            assert file.readline().startswith(b"layerjam,")
            for batch in range(LINES // BATCH):
                line.sendall(b"".join(noise(draw) for _ in range(BATCH)))
                mark = b"MARK%d" % batch
                line.sendall(b"\n*CLS;:SYST:LOCK:REL\n" + mark + b"?\n:SYST:ERR?\n")
                while mark not in (answer := file.readline()):
                    assert answer, "closed"
            file.close()
        seconds = time.monotonic() - begun
        with client(made) as after:
            assert after.query("*IDN?").startswith("layerjam,")
            for _ in range(300):
                state, pump = after.query("FETC:ALL?").split(",")[5], after.query("FETC:ALL?")
                if state != "DRIVE":
                    break
            assert state in ("SAFE", "FAULT") and float(pump.split(",")[3]) == 0.0
            assert after.query("OUTP?") == "0"
        assert made.process.poll() is None
    figure(f" 9  {LINES:,} random lines at {LINES / seconds:,.0f}/s: alive, {state}, pump off")
