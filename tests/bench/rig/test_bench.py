"""What the board does by itself: states, safe state, deadlines, the law's very bits, settings."""

from __future__ import annotations

import math
import random
import struct

import pytest

from bench.rig.boards import Hal, Rig, firmware, law_words, regulator
from layerjam.bench.control import law
from layerjam.bench.control.detection import detection_times
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import FAULTS, KINDS
from layerjam.brake.fluid.line import Sensor

SAMPLE = 0.01


def until_fault(rig: Rig, most: float) -> float:
    """Time [s] until FAULT; talks all the while, so that no lease ends."""
    for n in range(round(most * 100)):
        if rig.bench.state == 2:
            return n * SAMPLE
        rig.run(SAMPLE, talk=True)
    raise AssertionError("no fault")


def test_it_regulates_and_releases() -> None:
    rig = Rig()
    rig.on(60e3)
    rig.run(15, talk=True)
    assert rig.hal.vacuum == pytest.approx(60e3, abs=600) and rig.say("OUTP?") == "1"
    rig.say("SOUR:VAC 0")
    rig.run(2, talk=True)
    assert rig.hal.vacuum < 100 and rig.hal.vent_open
    assert rig.say("FETC:ALL?").split(",")[5:] == ["RUN", "0"]


@pytest.mark.parametrize(("safe", "rest"), [("REL", "CLOS"), ("HOLD", "OPEN")])
def test_a_safe_state_that_hardware_does_not_keep_is_refused(safe: str, rest: str) -> None:
    rig = Rig()
    rig.ready(regulator(safe_state="release" if safe == "REL" else "hold"))
    rig.say(f"OUTP:SAFE {safe};:OUTP:VENT:REST {rest};:OUTP ON")
    assert rig.error() == -221 and rig.bench.state == 0


@pytest.mark.parametrize("missing", ["OUTP:SAFE", "OUTP:VENT:REST", "CONT:LAW"])
def test_nothing_is_switched_on_that_was_not_declared(missing: str) -> None:
    rig = Rig()
    for line in ("OUTP:SAFE REL", "OUTP:VENT:REST OPEN", "CONT:LAW " + law_words(regulator())):
        if not line.startswith(missing):
            rig.say(line)
    rig.say("OUTP ON")
    assert rig.error() == -221 and rig.hal.pump == 0
    assert missing in rig.bench.explain_refusal()


def test_a_regulator_of_another_safe_state_is_refused() -> None:
    rig = Rig()
    rig.ready(regulator(safe_state="hold"))
    rig.say("OUTP ON")
    assert rig.error() == -221


@pytest.mark.parametrize("shown", [math.nan, 2e5, -2e4])
def test_no_start_on_a_sick_sensor(shown: float) -> None:
    rig = Rig()
    rig.ready()
    rig.hal.shows = shown
    rig.run(SAMPLE)
    rig.say("OUTP ON")
    assert rig.error() == -221


@pytest.mark.parametrize("safe", ["release", "hold"])
def test_the_safe_state_needs_no_power(safe: str) -> None:
    """In SAFE and FAULT the valve has no power: what a board in reset does is the same."""
    hal = Hal()
    hal.normally_open = safe == "release"
    rig = Rig(hal)
    rig.ready(regulator(safe_state=safe))
    if safe == "hold":
        rig.say("OUTP:SAFE HOLD;:OUTP:VENT:REST CLOS")
    assert rig.hal.power == 0
    rig.say("SOUR:VAC 50 kPa;:OUTP ON")
    rig.run(8, talk=True)
    held = rig.hal.vacuum
    assert held == pytest.approx(50e3, abs=600) and not rig.hal.vent_open
    rig.hal.estop_open = True
    rig.run(2 * SAMPLE, talk=True)
    assert (rig.hal.pump, rig.hal.power) == (0.0, 0)
    assert rig.hal.vent_open == (safe == "release")
    rig.run(2, talk=True)
    assert rig.hal.vacuum < 100 if safe == "release" else rig.hal.vacuum > 0.98 * held


def test_a_fault_latches_and_clearing_it_starts_nothing() -> None:
    rig = Rig()
    rig.on()
    rig.run(1, talk=True)
    rig.hal.shows = math.nan
    rig.run(SAMPLE)
    assert rig.say("OUTP:PROT:FAUL?;TRIP?") == '1,"NOT_A_NUMBER";1'
    assert [rig.error() for _ in range(3)] == [101, 129, 0]
    rig.hal.shows = None
    rig.run(SAMPLE)
    for line in ("OUTP ON", "*RST"):
        rig.say(line)
        assert rig.bench.state == 2
    rig.say("*CLS;:OUTP:PROT:CLE")
    assert rig.say("OUTP?;:OUTP:PROT:FAUL?") == '0;0,"HEALTHY"' and rig.hal.pump == 0
    rig.say("OUTP ON")
    assert rig.bench.state == 1


def test_rst_stops_and_keeps_what_was_declared() -> None:
    rig = Rig()
    rig.on()
    rig.say("SYST:LEAS 5;*ESE 8;FOO")
    rig.say("*RST")
    assert rig.say("OUTP?;:VAC?;:SYST:LEAS?;*ESE?;:OUTP:SAFE?") == "0;0;2;8;REL"
    assert rig.error() == -113


@pytest.mark.parametrize(
    ("breaks", "code", "deadline"),
    [
        ({"shows": math.nan}, "NOT_A_NUMBER", SAMPLE),
        ({"shows": 103421.0}, "SENSOR_OUT_OF_RANGE", 4 * SAMPLE),
        ({"stands": True}, "SENSOR_STUCK", 1.01),
        ({"estop_open": True}, "EMERGENCY_STOP", 2 * SAMPLE),
        ({"supply_low": True}, "SUPPLY_LOW", 3 * SAMPLE),
        ({"pump_works": 0.0}, "NO_VACUUM", None),
        ({"pump_works": 0.25}, "WEAK_PUMP", None),
    ],
    ids=lambda value: str(value)[:20],
)
def test_a_fault_is_named_within_its_deadline(
    breaks: dict[str, object], code: str, deadline: float | None
) -> None:
    """At full pumping; the pump's deadlines are those of `detection_times`."""
    rig = Rig()
    rig.on(90e3)
    rig.run(1.0, talk=True)
    assert rig.bench.state == 1
    if "stands" in breaks:
        rig.say("VAC 30 kPa")
        rig.run(5, talk=True)
        breaks = {"shows": rig.bench.reading}
    for name, value in breaks.items():
        setattr(rig.hal, name, value)
    took = until_fault(rig, 5.0)
    # a dead pump's last rise, in the decision that it dies in, may still call it weak
    assert rig.say("OUTP:PROT:FAUL?").split('"')[1] in (
        code,
        code.replace("NO_VACUUM", "WEAK_PUMP"),
    )
    assert took <= (detection_times(regulator(), 90e3)[code] if deadline is None else deadline)
    assert (rig.hal.pump, rig.hal.power) == (0.0, 0) and rig.hal.vent_open


@pytest.mark.parametrize("lease", [0.2, 0.8, 2.0])
def test_a_silent_host_loses_the_outputs_one_sample_after_the_lease(lease: float) -> None:
    rig = Rig()
    rig.on()
    rig.say(f"SYST:LEAS {lease}")
    rig.run(lease - 0.01)
    assert rig.bench.state == 1
    rig.run(0.02)
    assert rig.say("OUTP:PROT:FAUL?") == '120,"LEASE_EXPIRED"' and rig.hal.vent_open


def test_only_the_locks_holder_and_only_what_is_right_renews() -> None:
    rig = Rig()
    rig.on()
    rig.say("SYST:LOCK:REQ?", 1)
    for _ in range(21):
        rig.run(0.1)
        rig.say("*OPC?", 2)
        rig.say("FOO", 1)
    assert rig.bench.state == 2 and rig.bench.fault == 120


def test_queries_of_another_client_renew_nothing_and_its_commands_do() -> None:
    """The client that commanded is silent; a second one only asks, then commands."""
    rig = Rig()
    rig.on()
    for _ in range(15):
        rig.run(0.1)
        assert rig.say("*IDN?;*OPC?;:FETC:ALL?;:FETC:STR? 1", 3) and rig.error(3) == 0
    rig.say("SOUR:VAC 50 kPa", 3)
    for _ in range(19):
        rig.run(0.1)
        rig.say("*OPC?", 4)
    assert rig.bench.state == 1, "2 s have not passed since the command of client 3"
    rig.run(0.2)
    assert rig.bench.fault == 120


@pytest.mark.parametrize("end", ["leave", "*RST"])
def test_a_long_lease_ends_with_the_client_that_asked_for_it(end: str) -> None:
    rig = Rig()
    rig.ready()
    rig.say("SYST:LEAS 120", 5)
    rig.say("VAC 40 kPa;:OUTP ON", 5)
    rig.run(3)
    assert rig.bench.state == 1
    if end == "leave":
        rig.bench.end_session(5)
    else:
        rig.say("*RST", 6)
    assert float(rig.say("SYST:LEAS?")) == 2
    if end == "leave":
        rig.run(2.02)
        assert rig.bench.fault == 120


def test_a_lease_of_another_client_stays() -> None:
    rig = Rig()
    rig.say("SYST:LEAS 120", 5)
    rig.say("*OPC?", 6)
    rig.bench.end_session(6)
    assert float(rig.say("SYST:LEAS?")) == 120


def test_the_way_out_of_a_fault_is_named() -> None:
    rig = Rig()
    rig.on()
    rig.hal.estop_open = True
    rig.run(0.05)
    rig.hal.estop_open = False
    for line in ("OUTP ON", "OUTP:SAFE HOLD", "DIAG:DRIV 0,0,1"):
        rig.say(line)
        assert "OUTP:PROT:CLE or 'layerjam bench clear'" in rig.say("SYST:ERR:ALL?"), line


def test_a_sample_that_comes_far_too_late_is_a_fault() -> None:
    rig = Rig()
    rig.on()
    rig.run(SAMPLE, talk=True, late=100_000)
    assert rig.bench.state == 1 and int(rig.say("STAT:QUES:COND?")) & 4
    rig.run(SAMPLE, talk=True, late=100_001)
    assert rig.bench.fault == 121
    assert rig.say("SYST:TIM?").split(",")[5:] == ["1", "0", "0", "1", "1"]


def test_a_sensor_that_climbs_is_doubted_at_the_third_opening() -> None:
    """The regulator gives away vacuum that nothing brought; a target that falls is no doubt."""
    rig = Rig()
    rig.on(60e3)
    rig.run(12, talk=True)
    for target in (50e3, 40e3, 30e3):
        rig.say(f"VAC {target}")
        rig.run(3, talk=True)
    assert int(rig.say("STAT:QUES:COND?")) & 1024 == 0
    seen = 0
    for _ in range(60):
        rig.hal.vacuum += 600.0  # somebody warms the chamber: vacuum that no pump brought
        rig.run(0.5, talk=True)
        seen |= int(rig.say("STAT:QUES:COND?")) & 1024
    assert seen and rig.bench.state == 1


def test_the_reach_is_the_plants() -> None:
    draw = random.Random(3)
    rig = Rig()
    for _ in range(50):
        plant = Plant(
            rate=draw.uniform(0.05, 2), top=draw.uniform(2e4, 1e5), leak=draw.uniform(0, 0.02),
            vent=draw.uniform(0.5, 20), water=draw.random() < 0.3,
        )  # fmt: skip
        made = regulator(plant=plant, kind=draw.choice(list(KINDS)), sensor=Sensor(range=1.1e5))
        rig.ready(made)
        assert rig.bench.reach == pytest.approx(plant.reach, rel=1e-9)


@pytest.mark.parametrize("kind", list(KINDS))
def test_outputs_are_the_laws_to_the_last_bit(kind: str) -> None:
    rig, settings = Rig(), regulator(kind=kind).pack()
    rig.ready(regulator(kind=kind))
    rig.say("VAC 60 kPa;:OUTP ON")
    state = law.fresh()
    for n in range(1500):
        rig.say("VAC 40 kPa" if n == 800 else "*OPC?")
        rig.run(SAMPLE)
        target = 60e3 if n < 800 else 40e3
        state, pump, vent, fault = law.step(settings, state, rig.bench.reading, target)
        assert (rig.bench.pump, rig.bench.vent, rig.bench.fault) == (pump, vent, fault)
    assert rig.bench.state_of_law == state


def test_every_fault_of_the_law_has_its_name() -> None:
    code = firmware()
    names = code.built.FAULTS
    assert names == {number: name for number, name in FAULTS.items() if number}
    described = code.status.format_error
    assert described(105, "", names) == '105,"NO_VACUUM"'
    assert {described(100 + n, "", names).split('"')[1] for n in names} == set(names.values())


def test_the_self_test_finds_what_is_wrong() -> None:
    rig = Rig()
    assert rig.say("*TST?") == "0"
    rig.hal.shows, rig.hal.estop_open = math.nan, True
    rig.run(SAMPLE)
    assert rig.say("*TST?") == str(1 + 16)
    rig.hal.supply_low = True
    rig.run(SAMPLE)
    assert rig.say("*TST?") == str(1 + 8), "without supply nothing is known of the stop"


def test_a_lost_supply_is_not_an_emergency_stop() -> None:
    """Without 12 V there is no voltage behind the stop either."""
    rig = Rig()
    rig.on(90e3)
    rig.run(1.0, talk=True)
    rig.hal.supply_low = rig.hal.estop_open = True
    rig.hal.pump_works = 0.0
    assert until_fault(rig, 1.0) <= 3 * SAMPLE
    assert rig.say("OUTP:PROT:FAUL?") == '122,"SUPPLY_LOW"'
    rig.say("*CLS;:OUTP:PROT:CLE")
    for line in ("OUTP ON", "DIAG:DRIV 0,0,1"):
        rig.say(line)
        assert rig.bench.state == 0
        assert "-221" in (said := rig.say("SYST:ERR?")) and "supply" in said, said
    rig.hal.supply_low = False
    rig.say("OUTP ON")
    assert "the emergency stop is open" in rig.say("SYST:ERR?")


def test_a_dip_of_the_supply_ends_without_a_fault() -> None:
    """Two samples without 12 V, behind the stop too; the third has it again."""
    rig = Rig()
    rig.on(50e3)
    rig.run(8.0, talk=True)
    rig.hal.supply_low = rig.hal.estop_open = True
    rig.run(2 * SAMPLE, talk=True)
    rig.hal.supply_low = rig.hal.estop_open = False
    rig.run(1.0, talk=True)
    assert rig.bench.state == 1


@pytest.mark.parametrize("mutant", ["gain", "fault"])
def test_a_law_that_is_spoilt_fails_its_own_check(
    mutant: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = firmware()
    right = code.law.step

    def wrong(settings: object, state: object, measured: float, target: float) -> object:
        state, pump, vent, fault = right(settings, state, measured, target)
        return state, pump * (mutant == "fault"), vent, fault * (mutant == "gain")

    assert code.bench.is_law_sound()
    monkeypatch.setattr(code.law, "step", wrong)
    assert not code.bench.is_law_sound()


def test_driving_by_hand_ends_by_itself_and_by_the_lease() -> None:
    rig = Rig()
    rig.say("OUTP:VENT:REST OPEN;:DIAG:DRIV 0.5,0,1 s")
    assert rig.error() == 0 and rig.hal.pump == 0.0, "the next sample sets them"
    rig.run(SAMPLE)
    assert rig.hal.pump == 0.5 and not rig.hal.vent_open
    rig.run(0.5)
    rig.say("OUTP:SAFE HOLD")
    assert rig.error() == -221
    rig.run(0.51)
    assert rig.bench.state == 0 and rig.hal.pump == 0 and rig.hal.vent_open
    rig.say("DIAG:DRIV 1,1,5")
    rig.run(2.02)
    assert rig.bench.state == 0


def test_the_zero() -> None:
    rig = Rig()
    rig.ready()
    rig.hal.shows = 120.0
    rig.run(SAMPLE)
    rig.say("SENS:VAC:ZERO")
    assert rig.error() == -221, "the vent has only just been opened"
    rig.run(3)
    assert rig.say("SENS:VAC:ZERO?").split(",")[0] == "120"
    rig.say("SENS:VAC:ZERO")
    rig.run(SAMPLE)
    assert rig.error() == 0 and float(rig.say("MEAS?")) == 0.0
    rig.hal.shows = 6e3
    rig.run(3)
    rig.say("SENS:VAC:ZERO")
    assert rig.error() == -222


def test_settings_survive_a_reset_and_a_torn_write() -> None:
    rig = Rig()
    rig.ready()
    rig.say("SENS:VAC:CAL 12,1.01,'bench 7'")
    rig.say("SYST:SETT:STOR")
    old = rig.say("CONT:LAW?;:SENS:VAC:CAL?;:OUTP:SAFE?;VENT:REST?")
    rig.say("SENS:VAC:CAL 13,1.01,'bench 8';:SYST:SETT:STOR")
    new = rig.say("CONT:LAW?;:SENS:VAC:CAL?;:OUTP:SAFE?;VENT:REST?")
    assert rig.say("SYST:SETT:COUN?") == "2" and old != new
    slot, whole = 0, rig.hal.slots[0]
    assert whole is not None and rig.hal.slots[1] is not None
    for size in range(0, len(whole), 7):
        hal = Hal()
        hal.slots = list(rig.hal.slots)
        hal.slots[slot] = whole[:size]
        again = Rig(hal)
        assert again.say("CONT:LAW?;:SENS:VAC:CAL?;:OUTP:SAFE?;VENT:REST?") == old
        assert again.error() == 125 and again.say("*TST?") == "2"
        assert again.bench.state == 0 and again.hal.pump == 0
    assert Rig(rig.hal).say("CONT:LAW?;:SENS:VAC:CAL?;:OUTP:SAFE?;VENT:REST?") == new
    hal = Hal()
    hal.slots = [b"", whole[:-1]]
    bare = Rig(hal)
    assert bare.error() == -314 and bare.say("OUTP:SAFE?;*TST?") == "NONE;32"
    rig.say("SYST:SETT:DEF")
    assert rig.say("OUTP:SAFE?;VENT:REST?") == "NONE;NONE"


def test_records_hold_what_happened() -> None:
    rig = Rig()
    rig.on(50e3)
    rig.say("OUTP:SYNC ON")
    rig.run(1.0, talk=True)
    said = rig.port.execute(b"FETC:STR? 200", 0)
    last = struct.unpack("<IIffHhBBBB", said[-24:])
    seq, micros, vacuum, target, raw, warmth, pump, flags, state, fault = last
    assert (seq, target, raw, warmth, state, fault) == (rig.bench.ring.next - 1, 5e4, 7, 2300, 1, 0)
    assert micros == rig.bench.micros and vacuum == pytest.approx(rig.bench.reading, rel=1e-6)
    assert flags == 4 and pump == round(255 * rig.bench.pump)


def test_ticks_wrap() -> None:
    ticks = firmware().ticks
    wrap = 2**30
    for a in (0, 1, wrap - 1, wrap // 2, 12345):
        for d in (0, 1, 10_000, wrap // 2 - 1, -10_000, -wrap // 2):
            assert ticks.diff((a + d) % wrap, a) == d
            assert ticks.add(a, d) == (a + d) % wrap
