"""Frames: whole or not at all, and nothing is executed twice whatever the line does to them."""

from __future__ import annotations

import random
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.rig.boards import Rig
from layerjam.bench.rig import frame


@given(st.integers(0, 15), st.integers(0, 255), st.binary(max_size=300))
def test_there_and_back(session: int, number: int, payload: bytes) -> None:
    made = frame.pack(session, number, payload)
    head = f"{session:X}{number:02X}{len(payload):04X}"
    check = zlib.crc32(head.encode() + payload)
    assert made == f"@{head}{check:08X} ".encode() + payload + b"\n"
    assert frame.unpack(made) == (session, number, payload)
    assert frame.parse_first_frame(b"junk@1@" + made + b"@0") == (
        (session, number, payload),
        7 + len(made),
    )


@given(st.binary(max_size=60), st.data())
def test_any_single_byte_changed_is_seen(payload: bytes, data: st.DataObject) -> None:
    made = bytearray(frame.pack(3, 7, payload))
    at = data.draw(st.integers(0, len(made) - 1))
    made[at] ^= data.draw(st.integers(1, 255))
    assert frame.unpack(bytes(made)) is None


@given(st.binary(max_size=200))
def test_noise_is_no_frame(noise: bytes) -> None:
    found, done = frame.parse_first_frame(noise)
    assert found is None and 0 <= done <= len(noise)


def test_a_frame_in_pieces_is_waited_for() -> None:
    made = frame.pack(1, 2, b"a\n@b")
    for cut in range(len(made)):
        assert frame.parse_first_frame(b"xx" + made[:cut]) == (None, 2)


def exchange(rig: Rig, session: int, number: int, text: bytes, draw: random.Random, rate: float,
             tries: int = 5) -> bytes | None:  # fmt: skip
    """One command over a line that flips, drops and doubles bytes, as a host would ask."""

    def worn(data: bytes) -> bytes:
        out = bytearray()
        for byte in data:
            if draw.random() < rate:
                kind = draw.randrange(3)
                out += bytes([[byte ^ draw.randrange(1, 256)], [], [byte, byte]][kind])
            else:
                out.append(byte)
        return bytes(out)

    for _ in range(tries):
        rig.port.process_bytes(worn(frame.pack(session, number, text)))
        said, rig.port.outbox = worn(rig.port.outbox), b""
        while said:
            found, done = frame.parse_first_frame(said)
            if found is None:
                break
            said = said[done:]
            if found[:2] == (session, number):
                return found[2]
        rig.port.process_bytes(b"\n")
    return None


@pytest.mark.parametrize("rate", [0.0, 1e-3, 5e-3])
def test_nothing_is_executed_twice_on_a_bad_line(rate: float) -> None:
    """A counter on the board: each command raises the mask by one, and is asked for afterwards."""
    rig, draw = Rig(), random.Random(11)
    ran: list[bytes] = []
    execute = rig.port.execute

    def counted(line: bytes, number: int) -> bytes:
        ran.append(line)
        return bytes(execute(line, number))

    rig.port.execute = counted
    asked = 3000
    failed = 0
    for n in range(asked):
        text = b"*ESE %d;*ESE?" % (n % 256)
        said = exchange(rig, 1 + n % 3, n // 3 % 256, text, draw, rate)
        failed += said is None
        assert said in (None, b"%d" % (n % 256))
        if n % 100 == 0:
            rig.run(0.01)
    mine = [line for line in ran if line.startswith(b"*ESE")]
    assert asked - failed <= len(mine) <= asked
    assert failed <= (0 if rate <= 1e-3 else 0.1 * asked)
    assert set(ran) - set(mine) <= {b""}


def test_a_frame_said_again_is_answered_from_store() -> None:
    rig = Rig()
    rig.port.process_bytes(frame.pack(1, 5, b"SYST:ERR:COUN?;FOO"))
    first, rig.port.outbox = rig.port.outbox, b""
    rig.port.process_bytes(frame.pack(1, 5, b"SYST:ERR:COUN?;FOO"))
    assert rig.port.outbox == first
    assert rig.say("SYST:ERR:COUN?", 1) == "1"
    rig.port.process_bytes(frame.pack(1, 6, b"SYST:ERR:COUN?;FOO"))
    assert rig.say("SYST:ERR:COUN?", 1) == "2"


def test_an_empty_payload_ends_the_session() -> None:
    rig = Rig()
    rig.port.process_bytes(frame.pack(4, 1, b"SYST:LOCK:REQ?"))
    rig.port.process_bytes(frame.pack(4, 2, b""))
    assert rig.port.outbox == frame.pack(4, 1, b"1") + frame.pack(4, 2, b"")
    assert rig.bench.owner == -1


def test_the_rest_of_a_torn_frame_is_no_command() -> None:
    """Where the space before the payload turns into an LF, the payload stands alone on a line."""
    rig = Rig()
    made = frame.pack(1, 1, b"*ESE 9")
    rig.port.process_bytes(frame.pack(1, 0, b"*OPC?"))
    rig.port.process_bytes(made.replace(b" *", b"\n*"))
    assert rig.say("*ESE?") == "0"
    rig.run(2.1)
    rig.port.process_bytes(b"*ESE 9\n")
    assert rig.say("*ESE?") == "9", "two seconds later somebody types"


def test_ten_bad_frames_are_said() -> None:
    rig = Rig()
    for _ in range(9):
        rig.port.process_bytes(b"@1bad\n")
    assert rig.error() == 0
    rig.port.process_bytes(b"@1bad\n")
    assert rig.error() == 126 and rig.error() == 0


def test_who_asks_again_spoils_nothing() -> None:
    """A host that had to wait ends what may be torn; an impatient one fills no queue with it."""
    rig = Rig()
    asked = frame.pack(1, 5, b"SYST:ERR:COUN?")
    for _ in range(25):
        rig.port.process_bytes(b"\n" + asked)
    assert rig.error() == 0 and rig.error(3) == 0
    for _ in range(10):
        rig.port.process_bytes(asked[:-4] + b"\n" + asked)
    assert rig.error(3) == 126, "what is torn counts as before"


def test_nothing_more_is_read_while_too_much_waits() -> None:
    rig = Rig()
    rig.run(12)
    rig.port.process_bytes(b"FETC:STR? 200\n")
    assert rig.port.is_full()
