"""The accelerometer's record by DMA on the emulated chip, while samples go on.

The emulator turns from channel to channel wrongly, as its own source says; the test mends that.
"""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest

from bench.rig.emulated.emulator import Emulated, missing
from bench.rig.emulated.test_safe import gaps

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]
TONE = 40.0
"""Of the signal at the accelerometer's pin [Hz]."""


def signal(time: float) -> int:
    """Counts at the accelerometer's pin."""
    return round(2048 + 1500 * math.sin(2 * math.pi * TONE * time))


def wired(board: Emulated) -> list[float]:
    """Put the signal on its pin; the times at which it is read are noted."""
    from rp2040py.peripherals.adc import RPADC

    def turn(adc: RPADC, channel: int) -> None:
        adc.cs = adc.cs & ~(7 << 12) | (channel & 7) << 12

    RPADC._active_channel = property(RPADC._active_channel.fget, turn)
    adc, read, times = board.chip.adc, board.chip.adc._default_on_adc_read, []

    def shown(channel: int) -> None:
        if channel == board.firmware_pins["accelerometer_adc"] - 26:
            times.append(board.time)
            adc.channel_values[channel] = signal(board.time)
        read(channel)

    adc.on_adc_read = shown
    return times


def test_a_record_by_dma_while_the_samples_go_on() -> None:
    board = Emulated()
    times = wired(board)
    board.boot()
    contact = board.chip.gpio[board.firmware_pins["trigger_in"]]
    contact.set_input_value(True)
    said = board.ask("SENS:ACC:RATE 4 kHz;PRE 20 ms;POST 40 ms;:TRIG:SOUR EXT;:INIT;:SYST:ERR?")
    assert said == '0,"No error"'
    times.clear()
    begin = board.time
    board.run(0.06)
    contact.set_input_value(False)
    closed = board.time
    board.run(0.08)
    between = gaps(board, begin)
    assert len(between) >= 13 and max(between) < 11e-3, max(between)
    assert board.ask("FETC:ACC:STAT?").startswith("DONE,240,80,")
    # supply and emergency stop were read all the while
    assert board.ask("*TST?") == "0"
    zero, gain, reach, rate = struct.unpack(
        "<4d", bytes.fromhex(board.ask("FETC:ACC:SCAL?").strip('"'))
    )
    assert (rate, reach) == (pytest.approx(4000, rel=1e-4), pytest.approx(250 * 9.80665, rel=1e-5))
    assert zero == pytest.approx(2.5 * 2 / 3 / 3.3 * 4096, rel=1e-5)
    assert gain == pytest.approx(9.80665 / (8e-3 * 2 / 3 / 3.3 * 4096), rel=1e-5)
    board.heard.clear()
    board.say("FETC:ACC:DATA? 0,240")
    assert board.run(0.5, lambda: len(board.heard) >= 2 + 3 + 480 + 1)
    counts = np.frombuffer(bytes(board.heard[5:485]), "<i2")
    # the very numbers that were at the pin, one after another, and the trigger among them
    at = np.array(times)
    due = np.array([signal(time) for time in at])
    found = [n for n in range(len(due) - 239) if (counts == due[n : n + 240]).all()]
    assert found, (counts[:8], due[:8])
    assert np.diff(at) == pytest.approx(1 / 4000, abs=2e-6)
    assert any(abs(at[n + 80] - closed) < 12e-3 for n in found)
