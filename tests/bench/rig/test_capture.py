"""The accelerometer's record: trigger, ring and scale, on signals that the test knows exactly."""

from __future__ import annotations

import array
import math
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bench.rig.boards import Hal, Rig

GAIN, ZERO, GRAVITY = 1.5, 2068.7, 9.80665
ROOM = 16384


class Shaken(Hal):
    """A HAL whose accelerometer follows a function of time [s], in counts of GAIN m/s^2."""

    def __init__(self, force: Callable[[float], float]) -> None:
        super().__init__()
        self.force = force
        self.closed = False
        self.capture_ring = array.array("h", bytes(2 * ROOM))
        self.rate, self.begun, self.count = 0, 0, 0

    def start_capture(self, rate: int) -> None:
        self.rate, self.begun, self.count = rate, self.now, 0

    def capture_count(self) -> int:
        total = (self.now - self.begun) * self.rate // 1_000_000
        for n in range(self.count, total):
            at = self.begun * 1e-6 + n / self.rate
            self.capture_ring[n % ROOM] = round(self.force(at) / GAIN + ZERO)
        self.count = total
        return total

    def capture_part(self, first: int, last: int) -> array.array[int]:
        return self.capture_ring[first:last]

    def stop_capture(self) -> None:
        self.rate = 0

    def capture_scale(self) -> tuple[float, ...]:
        return (ZERO, GAIN, 2450.0, float(self.rate or 8000))

    def is_contact_closed(self) -> bool:
        return self.closed


def falling(at: float, flight: float = 0.2, pulse: float = 180.0) -> Callable[[float], float]:
    """Held, falling freely, a half sine of 20 ms that begins at `at`, then at rest."""

    def force(t: float) -> float:
        if t < at - flight or t > at + 0.02:
            return GRAVITY
        return pulse * math.sin(math.pi * (t - at) / 0.02) if t >= at else 0.0

    return force


def record(rig: Rig) -> tuple[np.ndarray[Any, Any], int, int]:
    """(m/s^2, samples before the trigger, board's time of it [us])."""
    state, size, before, micros = rig.say("FETC:ACC:STAT?").split(",")
    assert state == "DONE"
    zero, gain, _, _ = struct.unpack("<4d", bytes.fromhex(rig.say("FETC:ACC:SCAL?").strip('"')))
    data = b""
    for first in range(0, int(size), 700):
        line = f"FETC:ACC:DATA? {first},{min(700, int(size) - first)}"
        block = rig.port.execute(line.encode(), 0)
        digits = int(block[1:2])
        data += block[2 + digits :]
    counts = np.frombuffer(data, "<i2")
    assert len(counts) == int(size)
    return (counts - zero) * gain, int(before), int(micros)


@pytest.mark.parametrize("rate", [500, 8000, 20000])
def test_a_fall_arms_and_the_level_triggers(rate: int) -> None:
    """The record is the signal itself, to half a count, and its trigger is where the level is."""
    force = falling(0.77)
    rig = Rig(Shaken(force))
    rig.say(f"SENS:ACC:RATE {rate};PRE 0.1 s;POST 200 ms;:TRIG:SOUR ACC;LEV 5 G;FALL 30 ms")
    rig.say("INIT")
    assert rig.error() == 0 and rig.say("FETC:ACC:STAT?").startswith("WAITING")
    rig.run(1.2)
    shown, before, micros = record(rig)
    assert (before, len(shown)) == (round(rate * 0.1), round(rate * 0.3))
    start = rig.bench.micros - rig.hal.now
    assert start == 0
    times = micros * 1e-6 + (np.arange(len(shown)) - before) / rate
    # the level is met on the sine's rise: 5 g of what it shows in the fall
    due = 0.77 + 0.02 / math.pi * math.asin(5 * GRAVITY / 180.0)
    assert due - GAIN * 0.02 / 180 <= micros * 1e-6 <= due + 1 / rate + 1e-4
    assert np.max(np.abs(shown - [force(t) for t in times])) < 0.5 * GAIN + 180 * 160 * 2e-6


def test_a_capture_that_starts_right_before_a_tick_finds_the_level_at_rest() -> None:
    """That tick has no sample yet; counted as one, it would shift the level by 200 counts."""
    rig = Rig(Shaken(falling(0.77)))
    rig.say("SENS:ACC:RATE 4000;:TRIG:SOUR ACC;LEV 5 G;FALL 30 ms;:INIT")
    rig.bench.tick(0)
    rig.run(1.5)
    assert rig.say("FETC:ACC:STAT?").startswith("DONE")


def test_a_knock_without_a_fall_does_not_trigger_and_does_with_none_asked_for() -> None:
    force = falling(0.5, flight=0.0)
    rig = Rig(Shaken(force))
    rig.say("TRIG:SOUR ACC;FALL 0.05;:INIT")
    rig.run(1.0)
    assert rig.say("FETC:ACC:STAT?") == "WAITING,0,0,0"
    assert int(rig.say("STAT:OPER:COND?")) & 32
    rig.say("ABOR;:TRIG:FALL 0;:INIT")
    assert rig.error() == 0
    rig.hal.force = falling(rig.hal.now * 1e-6 + 0.4, flight=0.0)  # type: ignore[attr-defined]
    rig.run(0.45)
    assert rig.say("FETC:ACC:STAT?").startswith("RUNNING")
    assert int(rig.say("STAT:OPER:COND?")) & 16
    rig.run(0.6)
    assert rig.say("FETC:ACC:STAT?").startswith("DONE,4800,800,")


@pytest.mark.parametrize("offset", [-12.0, 12.0])
def test_the_fall_is_seen_whatever_the_offset_and_the_way_round(offset: float) -> None:
    """An ADXL193 may be off by a dozen g; and somebody mounts it upside down."""
    force = falling(0.6)
    rig = Rig(Shaken(lambda t: offset * GRAVITY - force(t)))
    rig.say("TRIG:SOUR ACC;:INIT")
    rig.run(1.3)
    assert rig.say("FETC:ACC:STAT?").startswith("DONE,4800,800,")


def test_the_other_triggers() -> None:
    rig = Rig(Shaken(lambda t: t))
    rig.say("*TRG")
    assert rig.error() == -211
    rig.say("TRIG:SOUR BUS;:SENS:ACC:PRE 0.05;:INIT")
    rig.run(0.3)
    rig.say("*TRG")
    asked = rig.hal.now
    rig.run(0.7)
    shown, before, micros = record(rig)
    assert before == 400 and 0 <= micros - asked <= 10_200
    assert shown[before] == pytest.approx(micros * 1e-6, abs=GAIN)
    rig.say("TRIG:SOUR IMM;:INIT")
    begun = rig.hal.now
    rig.run(0.7)
    _, before, micros = record(rig)
    assert before == 400 and micros - begun == pytest.approx(50_000, abs=200)
    hal = rig.hal
    assert isinstance(hal, Shaken)
    hal.closed = True  # closed already: only closing counts
    rig.say("TRIG:SOUR EXT;:INIT")
    rig.run(0.2)
    assert rig.say("FETC:ACC:STAT?").startswith("WAITING")
    hal.closed = False
    rig.run(0.02)
    hal.closed = True
    rig.run(0.7)
    assert rig.say("FETC:ACC:STAT?").startswith("DONE")
    assert rig.error() == 0


def test_a_contact_that_closes_after_a_tick_without_samples_triggers() -> None:
    rig = Rig(Shaken(lambda t: GRAVITY))
    rig.say("TRIG:SOUR EXT;:INIT")
    rig.bench.tick(0)
    assert isinstance(rig.hal, Shaken)
    rig.hal.closed = True
    rig.run(0.7)
    assert rig.say("FETC:ACC:STAT?").startswith("DONE")


def test_samples_that_were_lost_end_the_record_and_are_said() -> None:
    rig = Rig(Shaken(lambda t: 0.0))
    rig.say("TRIG:SOUR BUS;:INIT")
    rig.run(0.1)
    rig.hal.capture_count = lambda: -1  # type: ignore[attr-defined]
    rig.run(0.05)
    assert rig.say("FETC:ACC:STAT?") == "IDLE,0,0,0"
    assert rig.say("SYST:ERR?") == '127,"RING_OVERRUN;of the accelerometer"'
    assert rig.error() == 0


def test_what_is_refused() -> None:
    rig = Rig(Shaken(lambda t: 0.0))
    for line, code in (
        ("SENS:ACC:RATE 499", -222),
        ("SENS:ACC:RATE 20.1 kHz", -222),
        ("TRIG:LEV 5 Pa", -131),
        ("TRIG:SOUR ALWAYS", -224),
        ("FETC:ACC:DATA? 0,1", -230),
        ("FETC:ACC:DATA? 0,0", -222),
        ("SENS:ACC:RATE 20 kHz;POST 1.5;:INIT", -221),
    ):
        rig.say(line)
        assert rig.error() == code, line
    rig.say("SENS:ACC:RATE 8 kHz;POST 0.5;:INIT;:INIT")
    assert rig.error() == -213
    for line in ("SENS:ACC:RATE 1000", "SENS:ACC:PRE 0", "TRIG:LEV 6", "TRIG:SOUR BUS"):
        rig.say(line)
        assert rig.error() == -221, line
    rig.run(1.0)
    rig.say("FETC:ACC:DATA? 4799,2")
    assert rig.error() == -222
    rig.say("*RST")
    assert rig.say("FETC:ACC:STAT?") == "IDLE,0,0,0" and rig.say("SENS:ACC:RATE?") == "8000"
    bare = Rig()
    bare.say("INIT")
    assert bare.error() == -241


def test_the_law_goes_on_while_the_capture_runs() -> None:
    """Every sample of a second is taken, in RUN, while a capture waits, runs and is fetched."""
    rig = Rig(Shaken(lambda t: GRAVITY))
    rig.on(40e3)
    rig.say("SYST:LEAS 10;:TRIG:SOUR BUS;:INIT")
    first = rig.bench.count
    rig.run(1.0)
    rig.say("*TRG")
    rig.run(1.0)
    assert rig.bench.count - first == 200 and rig.bench.state == 1
    assert record(rig)[0] == pytest.approx(np.full(4800, GRAVITY), abs=GAIN / 2)
    assert rig.hal.vacuum > 20e3


def test_complete_waits_for_the_end_of_a_capture_in_its_own_session_alone() -> None:
    """IEEE 488.2, 12.5.2 and 12.5.3: *OPC sets bit 0, *OPC? answers, when nothing is pending."""
    rig = Rig(Shaken(lambda t: t))
    pending, done = "\x05", "FETC:ACC:STAT?"
    rig.say("*CLS;TRIG:SOUR BUS;:SENS:ACC:PRE 0.05;POST 0.1;:INIT;*OPC")
    assert rig.say("*ESR?") == "0"
    assert rig.say("SYST:VERS?;*OPC?;ERR:COUN?", 2) == pending
    assert rig.say("*WAI;:" + done, 3) == pending
    rig.run(0.5)
    assert rig.say(pending, 2) == pending and rig.say("*IDN?", 1).startswith("layerjam")
    rig.say("*TRG")
    rig.run(0.1)
    assert rig.say(done).startswith("RUNNING") and rig.say("*ESR?") == "0"
    assert rig.say(pending, 2) == pending
    rig.run(0.1)
    assert rig.say(done).startswith("DONE")
    assert rig.say(pending, 2) == "1999.0;1;0", "the path of the line is kept"
    assert rig.say(pending, 3).startswith("DONE") and rig.say("*ESR?;*OPC?") == "1;1"


def test_what_ends_or_cancels_a_wait() -> None:
    rig = Rig(Shaken(lambda t: t))
    rig.say("*CLS;TRIG:SOUR BUS;:INIT;*OPC")
    rig.say("*CLS;*OPC?")
    rig.port.process_bytes(b"*IDN?\nFOO\n")
    rig.port.resume()
    assert rig.port.outbox == b"", "later lines wait behind it"
    rig.port.process_bytes(b" outp off\nABOR\n")
    rig.port.resume()
    assert rig.port.outbox.startswith(b"1\nlayerjam,") and rig.error() == -113
    assert rig.say("*ESR?") == "32", "*CLS took back *OPC"
    rig.say("INIT;*OPC", 1)
    rig.say("*RST")
    rig.run(0.01)
    assert rig.say("*ESR?", 1) == "129", "the capture that *OPC waited for is given up"


def test_a_client_that_waits_does_not_renew_the_lease() -> None:
    rig = Rig(Shaken(lambda t: t))
    rig.on(20e3)
    rig.say("TRIG:SOUR BUS;:INIT;*OPC?")
    for _ in range(25):
        rig.run(0.1)
        rig.say("\x05")
    assert rig.bench.state == 2 and rig.bench.fault == 120
