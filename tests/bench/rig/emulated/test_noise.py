"""The frozen image under random bytes on its USB, and under halves of real commands."""

from __future__ import annotations

import random

import pytest

from bench.rig.emulated.emulator import Emulated, missing
from bench.rig.emulated.test_safe import gaps

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]
PIECES = (b"OUTP ON", b"*IDN?", b"SYST:ERR?", b"VAC 9e99", b"@", b"#H", b'"', b"\x00", b"\x03\x04")
"""Parts of commands, frames, blocks, strings, and what ends a program at a prompt."""
LETTERS = 1600


def noise(seed: int) -> bytes:
    """Random bytes with pieces of commands among them; a line at most each 200 bytes or so."""
    draw, made = random.Random(seed), bytearray()
    while len(made) < LETTERS:
        if draw.random() < 0.1:
            made += draw.choice(PIECES)
        made += draw.randbytes(draw.randint(1, 30))
        if draw.random() < 0.1:
            made += b"\n"
    return bytes(made)


@pytest.mark.parametrize("seed", [1, 2])
def test_random_bytes_start_nothing_and_stop_no_sample(seed: int) -> None:
    board = Emulated()
    board.boot()
    boot = board.ask("SYST:BOOT?").split(",")[0]
    begin, sent = board.time, noise(seed)
    for at in range(0, len(sent), 64):
        for byte in sent[at : at + 64]:
            board.usb.send_serial_byte(byte)
        assert board.run(1.0, lambda: not board.usb.tx_fifo.item_count)
        assert board.pump == 0.0
    board.run(0.05)
    between = gaps(board, begin)
    assert len(between) > 10 and max(between) < 25e-3, max(between)
    board.say("")
    board.synchronise()
    assert board.ask("*CLS;*OPC?") == "1"
    assert board.ask("SYST:BOOT?").split(",")[0] == boot, "it restarted"
    assert board.ask("OUTP?;:OUTP:PROT:TRIP?") == "0;0"
