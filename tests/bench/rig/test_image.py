"""A board's pins, its image, and its HAL on a chip that is a few lines of the test."""

from __future__ import annotations

import runpy
import struct
import sys
import tempfile
import types
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.rig.boards import CHIP, firmware
from layerjam.bench.rig import uf2
from layerjam.bench.rig.board import firmware_files
from layerjam.bench.rig.wiring import WiringFile, list_boards, load_wiring
from layerjam.core.errors import FileError, UnknownNameError

PICO = Path(__file__).parents[3] / "src" / "layerjam" / "bench" / "rig" / "boards" / "pico.toml"


@settings(max_examples=30)
@given(st.binary(min_size=1, max_size=2000))
def test_an_image_is_whole_or_refused(program: bytes) -> None:
    image = uf2.encode_uf2(program, uf2.RP2040)
    back = uf2.decode_uf2(image, uf2.RP2040, "x")
    assert back[: len(program)] == program and not any(back[len(program) :])
    assert len(image) == 512 * -(-len(program) // 256)
    with pytest.raises(uf2.ImageError, match="is for chip family"):
        uf2.decode_uf2(image, 0x12345678, "x")
    with pytest.raises(uf2.ImageError, match="not a UF2 image"):
        uf2.decode_uf2(image[:-1], uf2.RP2040, "x")
    if len(image) > 512:
        with pytest.raises(uf2.ImageError, match="not whole"):
            uf2.decode_uf2(image[:-512], uf2.RP2040, "x")


def test_what_is_no_image() -> None:
    good = bytearray(uf2.encode_uf2(b"x" * 600, uf2.RP2040))
    for raw in (b"", b"no image", b"\0" * 512):
        with pytest.raises(uf2.ImageError, match="not a UF2 image"):
            uf2.decode_uf2(raw, uf2.RP2040, "x")
    struct.pack_into("<I", good, 512 + 12, 0x20000000)
    with pytest.raises(uf2.ImageError, match="flash"):
        uf2.decode_uf2(bytes(good), uf2.RP2040, "x")
    struct.pack_into("<I", good, 4, 7)
    with pytest.raises(uf2.ImageError, match="markers"):
        uf2.decode_uf2(bytes(good), uf2.RP2040, "x")


def test_the_pico_s_pins() -> None:
    assert list_boards() == ["pico"]
    wired = load_wiring("pico").firmware_pins()
    assert (wired["pump_gate"], wired["vent_gate"], wired["estop_sense"]) == (16, 17, 18)
    assert wired["sensor_kind"] == "hsc" and "sensor_full" not in wired
    held: dict[str, Any] = {}
    exec(firmware_files("pico")["wired.py"], held)
    assert held["WIRED"] == wired and "wired.py" not in firmware_files()
    with pytest.raises(UnknownNameError):
        load_wiring("pica")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("vent_gate = 17", "vent_gate = 16", "GP16 is already used by pins.pump_gate"),
        ("vent_gate = 17", "vent_gate = 30", "at most 29"),
        ("vent_gate = 17", "", "vent_gate"),
        ("sensor_adc = 26", "sensor_adc = 22", "GP22 has no converter"),
        ('sensor_kind = "hsc"', 'sensor_kind = "adc"', "sensor_full"),
        ('sensor_kind = "hsc"', 'sensor_kind = "hcs"', "hsc"),
        ("accelerometer_full = {", "accelerometer_zeros = {", "did you mean"),
        ("value = 0.9090909", "value = 0.5050505", "a different accelerometer_full"),
        ("vent_gate = 17", "vent_gat = 17", "did you mean"),
        ('pump_frequency = { value = "20 kHz"', "pump_frequency = { value = 20", "unit"),
    ],
)
def test_pins_that_cannot_be(old: str, new: str, says: str) -> None:
    text = PICO.read_text("utf-8")
    assert old in text
    with pytest.raises(FileError, match="mine.toml") as error:
        WiringFile.read(text.replace(old, new), "mine.toml")
    assert says in str(error.value)


class Line:
    """MicroPython's `select` and `time`, and both ends of the line, each call 10 us long."""

    POLLIN, POLLOUT = 1, 4

    def __init__(self) -> None:
        self.now, self.inbox, self.said, self.room = 0, b"", b"", 10**6
        self.look = 10
        """Microseconds that a look at an idle line takes."""

    def ticks_us(self) -> int:
        self.now += 10
        return self.now % 2**30

    def ticks_ms(self) -> int:
        return self.now // 1000

    def ticks_diff(self, later: int, earlier: int) -> int:
        return later - earlier

    def sleep_us(self, us: int) -> None:
        self.now += us

    def poll(self) -> Line:
        made = Line.__new__(Line)
        made.__dict__ = {"of": self, "events": 0}
        made.poll = made.ipoll  # type: ignore[method-assign,assignment]
        return made

    def register(self, _: object, events: int) -> None:
        self.events = events

    def ipoll(self, ms: int) -> list[tuple[object, int]]:
        line = self.of
        ready = (1 if line.inbox else 0) | (4 if line.room else 0)
        if not ready & self.events:
            line.now += ms * 1000 or line.look
            return []
        return [(None, ready & self.events)]

    def readinto(self, buffer: bytearray) -> None:
        buffer[:], self.inbox = self.inbox[: len(buffer)], self.inbox[len(buffer) :]

    def write(self, data: memoryview) -> int:
        taken = bytes(data[: self.room])
        self.said += taken
        self.room -= len(taken)
        return len(taken)


class Machine(types.SimpleNamespace):
    """What MicroPython's `machine` has of the chip."""

    PWRON_RESET, WDT_RESET = 1, 3

    def __init__(self) -> None:
        super().__init__(
            analogue=set(),
            pins={},
            pulls={},
            duties={},
            bites=[],
            fed=0,
            counts=0,
            mem32={},
            cause=1,
            spi=b"",
        )
        outer = self

        class Pin:
            OUT, IN, PULL_DOWN, PULL_UP = 1, 0, 2, 1

            def __init__(self, number: int, *modes: int | None, value: int | None = None) -> None:
                self.number = number
                outer.pulls[number] = modes[1] if len(modes) > 1 else None
                if value is not None:
                    outer.pins[number] = value

            def value(self, value: int | None = None) -> int:
                if value is not None:
                    outer.pins[self.number] = value
                return outer.pins.get(self.number, 0)

        class Pwm:
            def __init__(self, pin: Pin, freq: int, duty_u16: int) -> None:
                assert isinstance(freq, int)
                self.number = pin.number
                self.duty_u16(duty_u16)

            def duty_u16(self, value: int) -> None:
                assert isinstance(value, int) and 0 <= value <= 65535
                outer.duties[self.number] = value

        class Adc:
            def __init__(self, pin: Pin) -> None:
                self.number = pin.number
                outer.analogue.add(pin.number)

            def read_u16(self) -> int:
                return outer.counts

        class Spi:
            def __init__(self, *_: object, **lines: object) -> None:
                assert lines["baudrate"] <= 800_000  # type: ignore[operator]

            def readinto(self, buffer: bytearray) -> None:
                assert outer.pins[1] == 0, "not selected"
                buffer[:] = outer.spi

        class Wdt:
            def __init__(self, timeout: int) -> None:
                outer.bites.append(timeout)

            def feed(self) -> None:
                outer.fed += 1

        self.Pin, self.PWM, self.ADC, self.SPI, self.WDT = Pin, Pwm, Adc, Spi, Wdt

    def reset_cause(self) -> int:
        return self.cause

    def unique_id(self) -> bytes:
        return b"\xe6\x61\x00\xff"


@pytest.fixture
def chip(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Machine:
    return made_chip(monkeypatch, tmp_path)


def made_chip(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Machine:
    machine = Machine()
    made = firmware()
    held: dict[str, Any] = {"machine": machine}
    for name in ("ticks", "begin", "ring", "outside", "capture"):
        held[name] = getattr(made, name)
    for name, text in firmware_files("pico").items():
        if name in (*CHIP, "wired.py"):
            module = types.ModuleType(name.removesuffix(".py"))
            held[module.__name__] = module
            machine.__dict__.setdefault("texts", {})[module.__name__] = text
    for name, module in held.items():
        monkeypatch.setitem(sys.modules, name, module)
    for name in ("wired", "sensor_hsc", "sensor_adc", "converter", "hal_rp2"):
        exec(machine.texts[name], held[name].__dict__)
    line = Line()
    machine.line = line
    monkeypatch.setattr(held["hal_rp2"], "select", line)
    monkeypatch.setattr(held["hal_rp2"], "time", line)
    end = types.SimpleNamespace(buffer=line)
    monkeypatch.setattr(held["hal_rp2"], "sys", types.SimpleNamespace(stdin=end, stdout=end))
    monkeypatch.chdir(folder)
    return machine


def hal(**causes: Any) -> Any:
    return sys.modules["hal_rp2"].Hal([], None)


def test_outputs_are_at_rest_from_the_start_and_follow(chip: Machine) -> None:
    made = hal()
    assert chip.duties == {16: 0, 19: 0} and chip.pins[17] == 0
    made.set_outputs(0.5, 1)
    assert chip.duties == {16: 32768, 19: 0} and chip.pins[17] == 1
    made.set_outputs(-1.0, 0)
    assert chip.duties == {16: 0, 19: 65535} and chip.pins[17] == 0
    made.set_outputs(1.0, 0)
    assert chip.duties == {16: 65535, 19: 0}


def test_the_emergency_stop_and_the_supply(chip: Machine) -> None:
    """The supply is that of pump and valve, 100 kohm over 30 kohm at GP28; 10.7 V are needed."""
    made = hal()
    assert made.is_stop_pressed() and not made.has_supply()
    chip.pins[18] = 1
    chip.counts = int(10.71 * 30 / 130 / 3.3 * 65535)
    assert not made.is_stop_pressed() and made.has_supply()
    chip.counts = int(10.69 * 30 / 130 / 3.3 * 65535)
    assert not made.has_supply()


def test_no_resistor_of_the_chip_spoils_the_sense_of_the_emergency_stop(chip: Machine) -> None:
    """Its pull-down of 50 to 80 kohm took a third of the divider's voltage."""
    hal()
    assert chip.pulls[18] is None and chip.pulls[21] == chip.Pin.PULL_UP


@pytest.mark.parametrize("status", [0, 1, 2, 3])
def test_the_digital_sensor(chip: Machine, status: int) -> None:
    """Its 14 bits over its range, port 1 below port 2; NaN where the part itself is in doubt."""
    made = hal()
    for raw, warmth in ((1638, 0), (8192, 767), (14746, 2047)):
        chip.spi = struct.pack(">H", status << 14 | raw) + struct.pack(">H", warmth << 5)
        vacuum, counts, degrees, trouble = made.read_sensor()
        assert counts == raw and trouble == (status in (1, 3))
        assert degrees == pytest.approx(warmth / 2047 * 20000 - 5000, abs=1)
        right = -103421.0 + (14746 - raw) / (14746 - 1638) * 2 * 103421.0
        if trouble:
            assert vacuum != vacuum
        else:
            assert vacuum == pytest.approx(right, abs=1e-6)
    assert chip.pins[1] == 1


def test_a_sensor_with_a_voltage(chip: Machine, tmp_path: Path) -> None:
    """0.2 V at no vacuum and 2.7 V at 100 kPa on 3.3 V; a broken wire is no reading."""
    (tmp_path / "wired.json").write_text(
        '{"sensor_kind": "adc", "sensor_range": 1e5, "sensor_zero": 0.0606060606, '
        '"sensor_full": 0.8181818182}',
        encoding="utf-8",
    )
    made = hal()
    for volts, pascals in ((0.2, 0.0), (1.45, 50e3), (2.7, 100e3)):
        chip.counts = round(volts / 3.3 * 65535)
        vacuum, raw, _, trouble = made.read_sensor()
        assert raw == chip.counts and not trouble
        assert vacuum == pytest.approx(pascals, abs=2)
    for counts in (0, 65535):
        chip.counts = counts
        vacuum, _, _, trouble = made.read_sensor()
        assert vacuum != vacuum and trouble == 1


def test_a_second_sensor_is_fitted_or_not(chip: Machine, tmp_path: Path) -> None:
    assert hal().read_second_sensor() is None
    (tmp_path / "wired.json").write_text(
        '{"sensor_range": 1e5, "sensor_zero": 0.1, "sensor_full": 0.9}', encoding="utf-8"
    )
    chip.counts = round(0.5 * 65535)
    assert hal().read_second_sensor() == pytest.approx(50e3, abs=2)


def test_the_watchdog_is_armed_once_and_waits_for_the_flash(chip: Machine) -> None:
    made = hal()
    made.feed_watchdog()
    made.save(0, b"nothing runs yet")
    assert (chip.bites, chip.fed) == ([], 0)
    made.arm_watchdog()
    made.arm_watchdog()
    made.feed_watchdog()
    assert (chip.bites, chip.fed) == ([100], 1)
    made.save(1, b"settings")
    assert chip.bites == [100, 3000, 100]
    assert (made.load(0), made.load(1)) == (b"nothing runs yet", b"settings")
    chip.line.now += 700_000
    assert made.time_since_save() == pytest.approx(700_000, abs=2000)


@settings(max_examples=20)
@given(text=st.binary(max_size=700), step=st.integers(0, 9000))
def test_the_line_is_read_until_the_sample_is_due(text: bytes, step: int) -> None:
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        chip = made_chip(patch, Path(folder))
        made, got, due = hal(), b"", 0
        chip.line.inbox = text
        while chip.line.inbox:
            due += 10_000
            chip.line.now = begun = due + 50 - step
            while len(more := made.wait(due, True, False)):
                got += more
                if chip.line.now >= due:
                    break
            assert chip.line.now - max(due, begun) <= 60
        assert got == text


@given(before=st.integers(700, 9000), sending=st.booleans())
def test_a_look_at_an_idle_line_makes_no_sample_late(before: int, sending: bool) -> None:
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        chip = made_chip(patch, Path(folder))
        made = hal()
        chip.line.look, chip.line.room = 200, 0
        due = chip.line.now + before
        assert made.wait(due, True, sending) == b""
        assert 0 <= chip.line.now - due <= 30


def test_a_full_line_takes_no_time(chip: Machine) -> None:
    made = hal()
    for room in (0, 1, 63, 64, 65, 300):
        chip.line.room, chip.line.said, sent = room, b"", 0
        while count := made.send(memoryview(bytes(range(200)))[sent:]):
            # a packet at a time: the loop looks at the clock before the next
            assert count <= 64
            sent += count
        assert sent == min(room, 200) and chip.line.said == bytes(range(200))[:room]
    chip.line.room = 0
    assert made.wait(chip.line.now + 5000, False, True) == b""
    chip.line.room = 1
    before = chip.line.now
    assert made.wait(before + 5000, False, True) == b"" and chip.line.now < before + 100


def test_settings_that_cannot_be_read_are_not_none(chip: Machine, tmp_path: Path) -> None:
    made = hal()
    assert made.load(0) is None and made.time_since_save() > 1e9
    (tmp_path / "settings0.bin").mkdir()
    assert made.load(0) == b""


def test_why_it_started(chip: Machine) -> None:
    assert hal().reset_cause() == "POWER_ON"
    chip.cause = Machine.WDT_RESET
    for reason, name in ((1, "WATCHDOG"), (2, "SOFT")):
        chip.mem32[0x40058008] = reason
        assert hal().reset_cause() == name
    assert hal().identity() == ("Raspberry Pi Pico", "E66100FF")


def test_what_the_image_keeps_out_of_the_heap_holds_the_samples() -> None:
    """Two pieces at the end of the memory; DMA wraps the second one at a multiple of its size."""
    build = runpy.run_path(str(PICO.parents[1] / "firmware" / "image" / "build.py"))
    held: dict[str, int] = {}
    exec(build["RESERVED"], held)
    ring, size = firmware().ring, build["FAST_SIZE"]
    assert held["FAST"] - held["RING"] >= ring.ROOM * ring.SIZE
    assert held["FAST"] % size == 0 and held["FAST"] + size == 0x20000000 + (256 << 10)
    assert size == 2 * firmware().capture.ROOM
