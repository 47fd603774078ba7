"""What a line is answered with: the numbers of the standard, registers, queues, and any line."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.rig.bad_lines import BAD, GOOD, LONG
from bench.rig.boards import PLANT, Rig, firmware, law_words, regulator
from counts import cases


@pytest.fixture(scope="module")
def shared() -> Rig:
    return Rig()


@pytest.fixture
def rig(shared: Rig) -> Rig:
    shared.say("*CLS;*ESE 0;*SRE 0;:SYST:LEAS 2;:STAT:PRES")
    return shared


@pytest.mark.parametrize(("line", "code"), BAD, ids=lambda value: repr(value)[:30])
def test_a_bad_line_has_its_number(rig: Rig, line: str | bytes, code: int) -> None:
    rig.say(line)
    assert rig.error() == code
    assert rig.error() == 0, "one line, one error"
    assert rig.bench.state == 0 and rig.hal.pump == 0.0 and rig.bench.target == 0.0


@pytest.mark.parametrize("line", GOOD, ids=repr)
def test_a_good_line_has_none(rig: Rig, line: str) -> None:
    assert rig.say(line) == "" and rig.error() == 0


def test_answers_follow_the_header_path(rig: Rig) -> None:
    assert rig.say("SYST:VERS?;*OPC?;ERR:COUN?") == "1999.0;1;0"
    assert rig.say("SYST:VERS?;:SYST:VERS?;VERS?") == "1999.0;1999.0;1999.0"
    rig.say("SYST:VERS?;SYST:VERS?")
    assert rig.error() == -113
    rig.say("VAC:LEV 0;IMM 0;IMM?")
    assert rig.error() == 0


def test_after_an_error_the_rest_is_dropped(rig: Rig) -> None:
    assert rig.say("*ESE 3;*ESE?;FOO;*ESE 5;*ESE?") == "3"
    assert rig.say("*ESE?") == "3" and rig.error() == -113


def test_what_comes_before_an_open_quote_is_done(rig: Rig) -> None:
    rig.say("*ESE 7;CONT:LAW 'x")
    assert rig.say("*ESE?") == "7" and rig.error() == -151


def test_seventeen_errors_leave_sixteen(rig: Rig) -> None:
    for _ in range(17):
        rig.say("FOO")
    assert rig.say("SYST:ERR:COUN?") == "16"
    codes = [rig.error() for _ in range(17)]
    assert codes == [-113] * 15 + [-350, 0]
    rig.say("FOO")
    rig.say("SOUR:VAC -1")
    said = rig.say("SYST:ERR:ALL?")
    assert said.startswith(
        '-113,"Undefined header;FOO",-222,"Data out of range;vacuum must be 0 to '
    )
    assert rig.say("SYST:ERR:ALL?") == '0,"No error"'


def test_a_range_is_named(rig: Rig) -> None:
    rig.say("SYST:LEAS 700")
    assert rig.say("SYST:ERR?") == '-222,"Data out of range;lease must be 0.2 to 600 s"'
    assert rig.say("SYST:LEAS? MIN;LEAS? MAX;LEAS? DEF;LEAS?") == "0.2;600;2;2"


def test_registers(rig: Rig) -> None:
    """ESE to bit 5, queue to bit 2, SRE to bit 6; reading an event clears it; *CLS keeps masks."""
    assert rig.say("*STB?") == "0"
    rig.say("FOO")
    assert rig.say("*STB?") == "4"
    rig.say("*ESE 32;*SRE 32")
    assert rig.say("*STB?") == str(4 + 32 + 64)
    assert rig.say("*ESR?;*ESR?") == "32;0"
    assert rig.say("*STB?") == "4"
    rig.say("*SRE 4;*SRE?")
    assert rig.say("*STB?") == str(4 + 64)
    rig.say("*CLS")
    assert rig.say("*STB?;*ESE?;*SRE?") == "0;32;4"
    rig.say("SOUR:VAC -1")
    assert rig.say("*ESR?") == "16"
    rig.say("*OPC")
    assert rig.say("*ESR?;*OPC?") == "1;1"
    rig.say("*SRE 255")
    assert rig.say("*SRE?") == "191", "bit 6 cannot ask for itself"


def test_condition_event_enable() -> None:
    rig = Rig()
    rig.on()
    rig.run(0.02)
    assert int(rig.say("STAT:OPER:COND?")) & 256
    assert int(rig.say("STAT:OPER?")) & 256
    assert int(rig.say("STAT:OPER:COND?")) & 256, "reading does not clear a condition"
    assert int(rig.say("STAT:OPER:EVEN?")) & 256 == 0, "reading clears an event"
    rig.say("OUTP OFF")
    rig.run(0.02)
    assert int(rig.say("STAT:OPER:COND?")) & 256 == 0
    assert int(rig.say("STAT:OPER?")) & 256 == 0, "only a rise is an event"
    rig.say("STAT:OPER:ENAB 256;:OUTP ON")
    rig.run(0.02)
    assert int(rig.say("*STB?")) & 128 and int(rig.say("*STB?", 3)) & 128 == 0
    rig.say("STAT:PRES")
    assert rig.say("STAT:OPER:ENAB?") == "0"


def test_queues_and_masks_are_each_clients_own() -> None:
    rig = Rig()
    rig.say("*ESE 1", 1)
    rig.say("*ESE 2;FOO", 2)
    assert rig.say("*ESE?", 1) == "1" and rig.say("*ESE?", 2) == "2"
    assert rig.error(1) == 0 and rig.error(2) == -113
    rig.on()
    rig.hal.estop_open = True
    rig.run(0.02)
    assert [rig.error(n) for n in (0, 1, 2, 15)] == [123] * 4
    rig.bench.end_session(2)
    assert rig.say("*ESE?;:SYST:ERR?", 2) == '0;0,"No error"'


def test_a_lock_keeps_others_out_but_not_from_off() -> None:
    rig = Rig()
    rig.on()
    assert rig.say("SYST:LOCK:REQ?", 1) == "1" and rig.say("SYST:LOCK:REQ?", 2) == "0"
    for line in ("SOUR:VAC 1", "OUTP ON", "*RST", "OUTP:PROT:CLE", "SYST:LOCK:REL", "SYST:LEAS 5"):
        rig.say(line, 2)
        assert rig.error(2) == -203, line
    assert rig.say("MEAS:VAC?;:SYST:LOCK:OWN?", 2).endswith('"SESSION 1"')
    assert rig.bench.state == 1
    rig.say("OUTP OFF", 2)
    assert rig.error(2) == 0 and rig.bench.state == 0 and rig.hal.pump == 0
    rig.say("OUTP ON", 1)
    rig.say("ABOR", 2)
    assert rig.bench.state == 0
    rig.bench.end_session(1)
    assert rig.say("SYST:LOCK:OWN?", 2) == '"NONE"'
    rig.say("SOUR:VAC 1", 2)
    assert rig.error(2) == 0


def test_every_header_is_listed_and_answers(rig: Rig) -> None:
    said = rig.say("SYST:HELP:HEAD?")
    assert said[0] == "#" and int(said[2 : 2 + int(said[1])]) == len(said) - 2 - int(said[1])
    listed = said[2 + int(said[1]) :].split("\n")
    names = [name.partition("/")[0] for name in listed]
    assert {"*CLS/nquery/", "*IDN/qonly/", "*ESE", "OUTPut[:STATe]"} <= set(listed)
    mandated = ["*CLS", "*ESE", "*ESR", "*IDN", "*OPC", "*RST", "*SRE", "*STB", "*TST", "*WAI"]
    assert {*mandated, "SYSTem:VERSion", "STATus:PRESet"} <= set(names)
    assert len(names) == len(set(names)) > 45
    rig.say("*CLS")
    for name, mark in zip(names, listed, strict=True):
        plain = name.replace("[", "").replace("]", "")
        answer = rig.say(plain + "?")
        assert (rig.error() == -113) == mark.endswith("/nquery/"), mark
        assert answer or not mark.endswith("/qonly/") or plain == "FETCh:ACCeleration:DATA", mark
        rig.say("ABOR;*CLS")
        assert rig.say("*OPC?") == "1"


@pytest.mark.parametrize("register", ["STAT:OPER:ENAB", "STAT:QUES:ENAB"])
@pytest.mark.parametrize(
    ("text", "value"),
    [("65535", 32767), ("32768", 0), ("#HFFFF", 32767), ("#h1f", 31), ("#Q17", 15), ("#B101", 5)],
)
def test_enable_registers_take_sixteen_bits_and_other_bases(
    rig: Rig, register: str, text: str, value: int
) -> None:
    rig.say(f"{register} {text}")
    assert rig.error() == 0 and int(rig.say(register + "?")) == value


@pytest.mark.parametrize("text", ["#H", "#HG", "#X1", "#B2", "#Q8", "#H-1", "#H1_0", "#H1 0"])
def test_other_bases_that_are_not_numbers(rig: Rig, text: str) -> None:
    rig.say(f"*ESE {text}")
    assert rig.error() == -104 and rig.say("*ESE?") == "0"


def test_a_numeric_suffix_is_one_or_an_error(rig: Rig) -> None:
    assert rig.say("OUTP1?;:OUTP1:STAT1?;:SOUR1:VAC?") == "0;0;0"
    for line in ("OUTP2 ON", "OUTP0?", "SOUR:VAC12 0"):
        rig.say(line)
        assert rig.error() == -114, line


def test_without_a_law_a_target_says_what_to_do() -> None:
    rig = Rig()
    rig.say("SOUR:VAC 60 kPa")
    assert rig.say("SYST:ERR?") == '-221,"Settings conflict;no controller; CONT:LAW sets one"'
    rig.say("SOUR:VAC 0")
    assert rig.error() == 0


def test_quotes_in_a_name_are_doubled(rig: Rig) -> None:
    rig.say("SENS:VAC:CAL 0,1,'bench \"7\"'")
    assert rig.say("SENS:VAC:CAL?") == '0,1,"bench ""7"""' and rig.error() == 0
    rig.say("SENS:VAC:CAL " + rig.say("SENS:VAC:CAL?"))
    assert rig.say("SENS:VAC:CAL?") == '0,1,"bench ""7"""' and rig.error() == 0


def test_units() -> None:
    rig = Rig()
    rig.ready()
    for text in ("60000", "60 kPa", "60KPAL", "6e4 Pa", "600 mbar", "600hPa", "0.6 bar", "+.6e5"):
        rig.say("SOUR:VAC 0")
        rig.say("SOUR:VAC " + text)
        assert (rig.error(), float(rig.say("VAC?"))) == (0, 60e3), text
    assert float(rig.say("VAC? MAX")) == pytest.approx(PLANT.reach, rel=1e-8)


def random_line(draw: random.Random, headers: list[str]) -> bytes:
    """Any bytes, or pieces of true lines put together in wrong ways."""
    if draw.random() < 0.2:
        return bytes(draw.randrange(256) for _ in range(draw.randrange(40))).replace(b"\n", b"")
    pieces = [";", ":", "?", " ", ",", "*", "'", '"', "#", "1e9", "-0", "MIN", "NaN", "60 kPa", "@",
              "ON", "OFF", "REL", "OPEN", "'00'", "0.2", "\t", "[", "5 s", "4e9"]  # fmt: skip
    out = ""
    for _ in range(draw.randrange(1, 6)):
        out += draw.choice(headers) if draw.random() < 0.5 else draw.choice(pieces)
    return out.encode()


def fuzz(count: int, seed: int) -> None:
    rig, draw = Rig(), random.Random(seed)
    names = [name.partition("/")[0] for name in rig.say("SYST:HELP:HEAD?")[4:].split("\n")]
    headers = [name.replace("[", "").replace("]", "") for name in names]
    headers = [h + end for h in headers for end in ("", "?", " ")] + headers
    headers = [h for h in headers if not h.startswith(("SYSTem:RES", "SYSTem:MAIN", "DIAG"))]
    for number in range(count):
        rig.say(random_line(draw, headers), 1 + number % 15)
        if number % 50 == 0:
            rig.run(0.01)
            assert rig.bench.state == 0 and rig.hal.pump == 0
    assert rig.say("*IDN?").startswith("layerjam,")
    assert len(rig.bench.sessions[1].errors) <= 16


@pytest.mark.slow
def test_random_lines_leave_it_alive_with_outputs_off() -> None:
    fuzz(cases(100_000, 20_000), 2)


def test_the_law_is_checked_number_by_number() -> None:
    """A number that is none, of the wrong sign, or half a switch: refused, the old law stays."""
    code, rig = firmware(), Rig()
    import struct
    import zlib

    rig.ready()
    before = rig.say("CONT:LAW?")
    first, second = regulator().pack()
    for place in range(39):
        for wrong in (float("nan"), float("inf"), -1e17):
            numbers = [*first, *second]
            numbers[place] = wrong
            raw = struct.pack("<39d", *numbers)
            rig.say(f'CONT:LAW "{raw.hex()}","{zlib.crc32(raw):08X}"')
            assert rig.error() == -222, (place, wrong)
    numbers = [*first, *second]
    numbers[14] = 0.5
    assert code.store.parse_law(struct.pack("<39d", *numbers))[0] is None
    assert rig.say("CONT:LAW?") == before == law_words(regulator())


def test_too_long_a_line_is_said_once_and_the_next_is_served() -> None:
    rig = Rig()
    for piece in (LONG[:700], LONG[:700], LONG[:700], "\n*OPC?\n"):
        rig.port.process_bytes(piece.encode())
    assert rig.port.outbox == b"1\n" and rig.error() == -363 and rig.error() == 0


@given(st.text("a;,\"'", max_size=12), st.integers(0, 12), st.sampled_from(";,"))
def test_a_mark_within_quotes_is_no_mark(text: str, at: int, mark: str) -> None:
    """Letter by letter: a quote is open until the same one comes again."""
    quote, due = "", len(text)
    for place in range(min(at, len(text)), len(text)):
        if quote:
            quote = "" if text[place] == quote else quote
        elif text[place] in "\"'":
            quote = text[place]
        elif text[place] == mark:
            due = place
            break
    scpi = firmware().scpi
    if quote:
        with pytest.raises(scpi.ScpiError, match="-151"):
            scpi.find_end(text, at, mark)
    else:
        assert scpi.find_end(text, min(at, len(text)), mark) == due
