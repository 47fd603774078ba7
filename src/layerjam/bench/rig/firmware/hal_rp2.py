"""The HAL of a Raspberry Pi Pico (RP2040): its pins, converter, watchdog and flash memory."""

import json
import os
import select
import sys
import time

import begin
import converter
import machine
import outside
import ring
import ticks
import wired

PIECE = 64
"""Bytes written between two checks of the time: one USB packet, which takes 0.6 ms. With more
bytes, a host that does not read would block the board, and one that does would delay a sample."""
READ = 64
"""Largest number of bytes read before the loop checks the time: at most 32 lines of 1 ms each."""
HEARD = 4
"""Number of bytes read even if a sample is late, so that a slow board still receives commands."""
EARLY = 2000
"""Time [us] before each sample during which the loop does not sleep."""
SHARP = 300
"""Time [us] before each sample during which the line is not read: reading takes up to 200 us."""
BITE, SAVING = 100, 3000
"""Timeout of the watchdog [ms]: normally, and while erasing a sector halts the chip."""
REASON, TIMER = 0x40058008, 1
"""Register with the reason for a watchdog reset; bit 0 means its timeout."""
FILE = "settings%d.bin"
WIRED = "wired.json"
CRASHED = "crash.txt"
FULL = 65535


def wiring() -> dict:
    """Return the wiring in the image, updated from the file in the board's flash memory, if any."""
    pins = dict(wired.WIRED)
    try:
        with open(WIRED) as file:
            pins.update(json.load(file))
    except OSError:
        pass
    return pins


class Hal:
    """HAL of the board; `reset` is not needed, because the chip resets itself."""

    collects = True

    def __init__(self, words: list, reset) -> None:
        self.collected = 0
        self.saved: int | None = None
        begin_of_ring = outside.reserved_address("RING")
        self.ring_store = (
            outside.map_memory(begin_of_ring, ring.ROOM * ring.SIZE) if begin_of_ring else None
        )
        self.dog = None
        pins = self.made = wiring()
        pin = machine.Pin
        self.vent = pin(pins["vent_gate"], pin.OUT, value=0)
        frequency = int(pins["pump_frequency"])
        self.pump = machine.PWM(pin(pins["pump_gate"]), freq=frequency, duty_u16=0)
        self.back = machine.PWM(pin(pins["pump_back_gate"]), freq=frequency, duty_u16=0)
        self.closed = pin(pins["estop_sense"], pin.IN)
        self.marker = pin(pins["sync_out"], pin.OUT, value=0)
        self.led = pin(pins["led_out"], pin.OUT, value=0)
        self.trigger = pin(pins["trigger_in"], pin.IN, pin.PULL_UP)
        self.converter = converter.Converter(pins)
        self.volts = self.converter.add_pin(pins["supply_adc"])
        volts = pins["least_supply"] / pins["supply_ratio"]
        self.least = int(volts / pins["reference_voltage"] * FULL)
        self.other = None
        if pins.get("sensor_full") is not None:
            self.other = __import__("sensor_adc").Sensor(pins, self.converter)
        if pins["sensor_kind"] == "hsc":
            self.part = __import__("sensor_hsc").Sensor(pins)
        else:
            self.part, self.other = self.other, None
        if self.converter.records:
            source = self.converter
            self.start_capture, self.capture_count = source.start_record, source.count_samples
            self.capture_part, self.stop_capture = source.copy_samples, source.stop_record
            self.capture_scale = source.read_scale
        self.shown = 0
        self.stdin: object = sys.stdin.buffer
        self.stdout: object = sys.stdout.buffer
        self.byte = bytearray(1)
        self.poll = select.poll()
        self.poll.register(sys.stdin, select.POLLIN)
        self.writing = select.poll()
        self.writing.register(sys.stdout, select.POLLOUT)
        self.both = select.poll()
        self.both.register(sys.stdin, select.POLLIN | select.POLLOUT)
        self.cause = "POWER_ON"
        if machine.reset_cause() == machine.WDT_RESET:
            self.cause = "WATCHDOG" if machine.mem32[REASON] & TIMER else "SOFT"

    def ticks_us(self) -> int:
        """Return the board's clock [us], in 30 bits."""
        return time.ticks_us()

    def wait(self, due: int, reading: bool, sending: bool) -> bytearray:
        """Return bytes from the line, or none once `due` is reached or something can be sent."""
        data = bytearray()
        poll = self.both if reading and sending else self.writing if sending else self.poll
        late, has_polled = 0, False
        while True:
            left = ticks.diff(due, time.ticks_us())
            if has_polled and not data and left < SHARP:
                time.sleep_us(max(left, 0))
                return data
            if left <= 0:
                late += 1
                if late > HEARD:
                    return data
            if not (reading or sending):
                time.sleep_us(max(left, 0))
                return data
            wait = 0 if data or left < EARLY else (left - EARLY + 999) // 1000
            events, has_polled = 0, True
            for entry in poll.ipoll(wait):
                events = entry[1]
            if events & select.POLLIN:
                self.stdin.readinto(self.byte)
                data.extend(self.byte)
                if len(data) == READ:
                    return data
            elif data or left <= 0 or events & select.POLLOUT:
                return data

    def send(self, data: bytes) -> int:
        """Send a piece if the line accepts one; return its number of bytes."""
        if not self.writing.poll(0):
            return 0
        return self.stdout.write(data[:PIECE]) or 0

    def read_sensor(self) -> tuple:
        """Return (vacuum [Pa] or NaN, raw counts, temperature [0.01 degC], diagnostic bits)."""
        return self.part.read()

    def read_second_sensor(self):
        """Return the second sensor's reading [Pa]; None if it is not fitted."""
        return None if self.other is None else self.other.read()[0]

    def set_outputs(self, pump: float, power: int) -> None:
        """Set the pump (-1 to 1), and whether the vent valve is powered."""
        self.pump.duty_u16(int(FULL * pump + 0.5) if pump > 0.0 else 0)
        self.back.duty_u16(int(FULL * -pump + 0.5) if pump < 0.0 else 0)
        self.vent.value(power)

    def is_stop_pressed(self) -> bool:
        """Return whether 12 V are missing downstream of the emergency stop: the pin is low."""
        return not self.closed.value()

    def has_supply(self) -> bool:
        """Return whether the 12 V upstream of the emergency stop are present."""
        return self.volts.read_mean(1) >= self.least

    def is_contact_closed(self) -> bool:
        """Return whether the trigger contact is closed to ground."""
        return not self.trigger.value()

    def show_state(self, state: int, sync: int) -> None:
        """Set the lamp (1 Hz in SAFE and DRIVE, on in RUN, 5 Hz in FAULT) and the marker."""
        self.shown += 1
        period = 20 if state == 2 else 100
        self.led.value(1 if state == 1 or self.shown % period < period // 2 else 0)
        self.marker.value(sync)

    def arm_watchdog(self) -> None:
        """Start the watchdog, which only a reset stops."""
        if self.dog is None:
            self.dog = machine.WDT(timeout=BITE)

    def feed_watchdog(self) -> None:
        """Restart the watchdog's timer."""
        if self.dog is not None:
            self.dog.feed()

    def load(self, slot: int):
        """Return the settings in a slot: None if there are none, empty if they cannot be read."""
        try:
            with open(FILE % slot, "rb") as file:
                return file.read()
        except OSError as error:
            return None if error.errno == 2 else b""

    def save(self, slot: int, data: bytes) -> None:
        """Store settings in a slot."""
        self.write(FILE % slot, data)
        self.saved = time.ticks_ms()

    def write(self, name: str, data: bytes) -> None:
        """Write a file to flash memory, with a longer watchdog timeout."""
        if self.dog is not None:
            self.dog = machine.WDT(timeout=SAVING)
        try:
            with open(name, "wb") as file:
                file.write(data)
        finally:
            if self.dog is not None:
                self.dog = machine.WDT(timeout=BITE)

    def time_since_save(self) -> int:
        """Return the time [us] since settings were last stored; 2^40 beyond the clock's range."""
        milliseconds = -1 if self.saved is None else time.ticks_diff(time.ticks_ms(), self.saved)
        return 1 << 40 if milliseconds < 0 else milliseconds * 1000

    def identity(self) -> tuple:
        """Return (model, serial number)."""
        return self.made["name"], "".join(["%02X" % byte for byte in machine.unique_id()])

    def reset_cause(self) -> str:
        """Return POWER_ON, SOFT or WATCHDOG."""
        return self.cause

    def reset(self) -> None:
        """Restart the board."""
        machine.reset()

    def enter_maintenance(self) -> None:
        """Restart to the prompt without the watchdog, which would reset the board there."""
        machine.mem32[begin.SCRATCH] = begin.ASKED
        machine.reset()

    def handle_crash(self, error) -> None:
        """Handle an error that the firmware cannot survive: outputs off, then the watchdog.

        Only the first error is stored in a file, so that repeated crashes do not wear the flash.
        """
        self.set_outputs(0.0, 0)
        try:
            if CRASHED not in os.listdir():
                with open(CRASHED, "w") as file:
                    sys.print_exception(error, file)
        finally:
            self.arm_watchdog()
            while True:
                pass
