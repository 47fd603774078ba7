"""The image on an emulated RP2040 (rp2040py), with a sensor, an emergency stop and a USB host."""

from __future__ import annotations

import math
import runpy
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import layerjam.bench.rig
from layerjam.bench.control.plant import Plant
from layerjam.bench.rig import uf2
from layerjam.bench.rig.board import firmware_files
from layerjam.bench.rig.wiring import load_wiring

IMAGE = Path(__file__).parents[4] / "out" / "firmware" / "layerjam-pico.uf2"
BUILD = Path(layerjam.bench.rig.__file__).parent / "firmware" / "image" / "build.py"
ZERO, SPAN = 1638, 13108
SUPPLY = 12.0
THRESHOLD = 1.4
"""Voltage [V] between the greatest for low and the least for high of the chip's data sheet."""


def missing() -> str:
    """Why the tests here cannot run, "" where they can."""
    if find_spec("rp2040py") is None:
        return "the emulator rp2040py is not installed here; run `make firmware-checks`"
    if not IMAGE.exists():
        return f"there is no image at {IMAGE}; run `make firmware`"
    if not runpy.run_path(str(BUILD))["is_current"](IMAGE.parent):
        return "the image is not of these sources; run `make firmware`"
    return ""


def firmware_hash() -> str:
    """What the board says of its own files."""
    held: dict[str, Any] = {}
    exec(firmware_files("pico")["built.py"], held)
    return str(held["FIRMWARE"])


class Emulated:
    """A board; `vacuum` is what its sensor shows [Pa], of a chamber where there is a `plant`.

    The valve is open without power. `samples` are the times of its readings [s].
    """

    def __init__(self, image: bytes | None = None) -> None:
        from rp2040py.device.bootrom import BOOTROM_B1
        from rp2040py.memory_map import FLASH_START_ADDRESS
        from rp2040py.simulator import Simulator
        from rp2040py.usb.cdc import USBCDC
        from rp2040py.utils.logging import ConsoleLogger, LogLevel

        self.simulator = Simulator()
        self.chip = self.simulator.rp2040
        self.chip.logger = ConsoleLogger(LogLevel.ERROR)
        self.chip.load_bootrom(BOOTROM_B1)
        program = uf2.decode_uf2(image or IMAGE.read_bytes(), uf2.RP2040, str(IMAGE))
        self.chip.flash[:] = b"\xff" * len(self.chip.flash)
        self.chip.flash[: len(program)] = program
        self.usb = USBCDC(self.chip.usb_ctrl)
        self.usb.on_serial_data = self._heard
        self.heard = bytearray()
        self.connected = 0
        self.usb.on_device_connected = self._enumerated
        self.firmware_pins = load_wiring("pico").firmware_pins()
        self.vacuum = self.moved = 0.0
        self.plant: Plant | None = None
        self.status = 0
        self.samples: list[float] = []
        self.chip.spi[0].on_transmit = self._sensor
        self.answer = [0, 0, 0, 0]
        self.pins()
        # the wave itself is not looked at, and its edges would cost a second each hundredth
        for channel in self.chip.pwm.channels:
            for alarm in (channel.alarm_a, channel.alarm_b, channel.alarm_bottom):
                alarm.enable = False
        self.chip.core.pc = FLASH_START_ADDRESS
        self.simulator.stopped = False

    def pins(self) -> None:
        """12 V before and behind the emergency stop."""
        self.supply(SUPPLY)

    def supply(self, before: float, behind: float | None = None) -> None:
        """Voltages [V] before and behind the emergency stop; one where it is closed."""
        ratio = self.firmware_pins["supply_ratio"]
        self.senses(before / ratio, (before if behind is None else behind) / ratio)

    def senses(self, supply: float, stop: float) -> None:
        """Voltages [V] at the pins that sense the supply and the emergency stop."""
        self.chip.gpio[self.firmware_pins["estop_sense"]].set_input_value(stop > THRESHOLD)
        share = min(supply / self.firmware_pins["reference_voltage"], 1.0)
        self.chip.adc.channel_values[self.firmware_pins["supply_adc"] - 26] = int(share * 4095)

    @property
    def time(self) -> float:
        """The board's time [s]."""
        return float(self.chip.clock.nanos) * 1e-9

    def _enumerated(self) -> None:
        self.connected += 1

    def _heard(self, data: bytes) -> None:
        self.heard.extend(data)

    def _breathe(self) -> None:
        """The chamber since its last reading, exact for a pump and a vent that stood still."""
        passed, self.moved = self.time - self.moved, self.time
        if self.plant is None:
            return
        gain = self.plant.rate * self.pump
        loss = gain + self.plant.leak + (0.0 if self.vent else self.plant.vent)
        end = gain * self.plant.top / loss
        self.vacuum = end + (self.vacuum - end) * math.exp(-loss * passed)

    def _sensor(self, _: int) -> None:
        """Four bytes a reading: status and counts, then a temperature of 25 degC."""
        if not self.answer:
            self._breathe()
            pascals = self.firmware_pins["sensor_range"]
            raw = round(ZERO + SPAN * (0.5 - self.vacuum / (2 * pascals)))
            warmth = round((25 + 50) * 2047 / 200)
            self.answer = [self.status << 6 | raw >> 8, raw & 255, warmth >> 3, warmth << 5 & 255]
            self.samples.append(self.time)
        self.chip.spi[0].complete_transmit(self.answer.pop(0))

    @property
    def pump(self) -> float:
        """The pump's share of full power, as its pin gives it; 0 where nothing drives the pin."""
        number = self.firmware_pins["pump_gate"]
        channel = self.chip.pwm.channels[number // 2 % 8]
        if self.chip.gpio[number].function_select != 4 or not channel.csr & 1:
            return 0.0
        duty = channel.cc >> 16 if number % 2 else channel.cc & 0xFFFF
        return float(min(duty / (channel.top + 1), 1.0))

    @property
    def vent(self) -> bool:
        """Whether the vent valve is given power."""
        pin = self.chip.gpio[self.firmware_pins["vent_gate"]]
        return bool(pin.output_enable and pin.output_value)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Go on by so much of the board's time; True as soon as something is so."""
        end = self.time + seconds
        while self.time < end:
            self.simulator._execute_batch()
            if until():
                return True
        return False

    def boot(self, seconds: float = 2.0) -> None:
        """Until the board is on the USB and its loop runs."""
        seen, first = self.connected, len(self.samples)
        assert self.run(seconds, lambda: self.connected > seen), "not on the USB"
        assert self.run(seconds, lambda: len(self.samples) > first + 3), bytes(self.heard)
        self.heard.clear()

    def say(self, text: str) -> None:
        """Send a line; the emulated host holds 512 bytes at most."""
        line = text.encode("ascii") + b"\n"
        for at in range(0, len(line), 256):
            for byte in line[at : at + 256]:
                self.usb.send_serial_byte(byte)
            assert self.run(1.0, lambda: not self.usb.tx_fifo.item_count), text

    def synchronise(self, quiet: float = 0.05) -> None:
        """The host reads, and throws away what still comes until the line has been quiet so long.

        What an earlier question left unread is no answer to the next one.
        """
        self.hold(reads=True)
        while True:
            self.heard.clear()
            self.run(quiet)
            if not self.heard:
                return

    def ask(self, text: str, seconds: float = 1.0) -> str:
        """The answer to one line that has one; nothing else may stand on the line."""
        left = bytes(self.heard)
        assert not left, f"not read before {text}: {left!r}; synchronise first"
        self.say(text)
        assert self.run(seconds, lambda: self.heard.endswith(b"\n")), (text, bytes(self.heard))
        answer = self.heard[:-1].decode("ascii")
        self.heard.clear()
        return answer

    def executed(self, text: str, seconds: float) -> str:
        """What a program prints at the board's prompt (raw mode: Ctrl-A, the text, Ctrl-D)."""
        for part in ("\x01", *(text[i : i + 128] for i in range(0, len(text), 128)), "\x04"):
            for byte in part.encode("ascii"):
                self.usb.send_serial_byte(byte)
            self.run(0.05)
        assert self.run(seconds, lambda: self.heard.count(b"\x04") >= 2), bytes(self.heard)
        return self.heard.decode("ascii", "replace")

    def hold(self, reads: bool = False) -> None:
        """The host reads nothing any more, or reads again what waits for it."""
        usb = self.chip.usb_ctrl
        usb.write_delay_microseconds = 10 if reads else 10**9
        if reads:
            for waiting in usb.endpoint_write_alarms:
                if waiting.buffers:
                    waiting.alarm.schedule(10_000)

    def hang(self) -> None:
        """The core runs in a circle, with interrupts off, as after a stray pointer."""
        core = self.chip.core
        at = 0x20041000
        self.chip.sram[at - 0x20000000 : at - 0x20000000 + 2] = b"\xfe\xe7"
        core.pc, core.pm = at, True
