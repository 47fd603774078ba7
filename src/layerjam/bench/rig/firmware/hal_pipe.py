"""HAL of the virtual board under MicroPython's unix port: stdin, stdout and two pipes.

The clock has 30 bits and starts five seconds before it wraps. It runs `speed` times as fast as the
host's or, if `speed` is 0, as fast as samples are computed and fetched. While the host suspends
this process or its plant, the clock stops 2 ms after the time of the next sample. The law therefore
receives evenly spaced samples, as on a board.
"""

import array
import select
import struct
import sys
import time

import ticks
from capture import NOTHING, ROOM
from scpi import ScpiError

BEGIN = ticks.WRAP - 5000000
LEAP = 2000
"""Longest time [us] that the clock may advance beyond the time of the next sample."""
LONGEST_STEP = 10000000
SERVED = 20
"""Number of samples between two reads from the line at speed 0."""
PATIENCE = 1000000
"""Longest wait [us of the host's clock] at speed 0 for a client that fetches samples slowly."""
PIECE = 4096
TOLD, ASKED, SAMPLED, STARTED = 0, 1, 2, 3
"""Kinds of messages to the plant: outputs only, a reading, samples, a scale (starts sampling)."""
OUT = "<dIBBH"
IN = "<dHhBBHd"
SIZE = 24
SLOT = ".%d"
MISSING = 2
"""Error number of a missing file."""
SCALE = "<4d"
ESTOP, SUPPLY_LOW, DIAGNOSTIC, SECOND, CONTACT = 1, 2, 4, 8, 16


class Hal:
    """HAL; `words` are the pipes from and to the plant, speed, serial number and settings file."""

    collects = True

    def __init__(self, words: list, reset) -> None:
        self.plant_in, self.plant_out, speed, self.serial = words[:4]
        self.store = words[4] if len(words) > 4 else ""
        self.speed = float(speed)
        self.reset_error = reset
        self.cause = "POWER_ON"
        self.collected = 0
        self.slots: list = [None, None]
        self.saved: int | None = None
        self.now, self.part = BEGIN, 0.0
        self.ring = None
        self.fetched = self.pressed = 0
        self.due = BEGIN
        self.leap = LEAP
        self.second: float | None = None
        self.waits = 0
        self.estop_open = self.supply_low = self.contact = False
        self.scale, self.captures, self.sampled = NOTHING, False, 0
        self.pump, self.power = 0.0, 0
        self.open()
        self.seen = self.host_us()

    def open(self) -> None:
        """Open the four pipes."""
        self.line_in, self.line_out = open(0, "rb"), open(1, "wb")
        self.plant_in = open(int(self.plant_in), "rb")
        self.plant_out = open(int(self.plant_out), "wb")
        self.reading = select.poll()
        self.reading.register(self.line_in, select.POLLIN)
        self.writing = select.poll()
        self.writing.register(self.line_out, select.POLLOUT)
        self.both = select.poll()
        self.both.register(self.line_in, select.POLLIN)
        self.both.register(self.line_out, select.POLLOUT)

    def host_us(self) -> int:
        """Return the host's clock [us]."""
        return time.ticks_us()

    def is_readable(self, us: int, sending: bool) -> bool:
        """Wait up to `us` until bytes arrive or some can be sent; return whether bytes arrived."""
        for file, event in (self.both if sending else self.reading).poll(us // 1000):
            if file is self.line_in and event:
                return True
        if us < 1000 and not sending:
            time.sleep_us(us)
        return False

    def read_line(self) -> bytes:
        """Return the bytes that have arrived; the host made the pipe non-blocking."""
        return self.line_in.read(1024)

    def send(self, data: bytes) -> int:
        """Send as many bytes as the line accepts without waiting; return their number."""
        if not self.writing.poll(0):
            return 0
        return self.line_out.write(data[:PIECE]) or 0

    def read_plant(self, size: int) -> bytes:
        """Return the plant's complete response."""
        return self.plant_in.read(size)

    def write_plant(self, data: bytes) -> None:
        """Send data to the plant."""
        self.plant_out.write(data)

    def ticks_us(self) -> int:
        """Return the board's clock [us], in 30 bits."""
        if self.speed > 0.0:
            host = self.host_us()
            elapsed_time = (host - self.seen) * self.speed + self.part
            self.seen = host
            whole_time = int(elapsed_time)
            self.part = elapsed_time - whole_time
            self.now = ticks.add(self.now, min(whole_time, LONGEST_STEP))
            if ticks.diff(self.now, self.due) > self.leap:
                self.now = ticks.add(self.due, self.leap)
        return self.now

    def wait(self, due: int, reading: bool, sending: bool) -> bytes:
        """Return bytes from the line, or none once `due` is reached or something can be sent."""
        self.due = due
        if self.speed == 0.0:
            if reading and not sending and self.ring.is_nearly_full():
                left = self.remaining_patience()
                if left <= 0:
                    self.ring.reader = -1
                elif self.is_readable(left, False):
                    return self.receive()
            self.waits += 1
            if self.waits >= SERVED or sending:
                self.waits = 0
                if reading and self.is_readable(0, False):
                    return self.receive()
            if ticks.diff(due, self.now) > 0:
                self.now = due
            return b""
        left = ticks.diff(due, self.ticks_us())
        if left > 0:
            self.leap = LEAP
        if left <= 0 or not reading:
            left = 0
        if self.is_readable(int(left / self.speed), sending) and reading:
            return self.receive()
        return b""

    def remaining_patience(self) -> int:
        """Return the time [us of the host's clock] left for a client to fetch its samples."""
        host_time = self.host_us()
        if self.ring.fetched != self.fetched:
            self.fetched, self.pressed = self.ring.fetched, host_time
        return PATIENCE - (host_time - self.pressed)

    def receive(self) -> bytes:
        """Return the bytes that have arrived; exit at the end of the pipe."""
        data = self.read_line()
        if data == b"":
            raise EOFError
        return data or b""

    def send_message(self, kind: int, count: int = 0) -> None:
        """Send the time and the outputs to the plant."""
        self.write_plant(struct.pack(OUT, self.pump, self.ticks_us(), self.power, kind, count))

    def query_plant(self, kind: int, size: int, count: int = 0) -> bytes:
        """Return the plant's response; exit if there is none."""
        self.send_message(kind, count)
        data = self.read_plant(size)
        if data is None or len(data) != size:
            raise EOFError
        return data

    def read_sensor(self) -> tuple:
        """Return (vacuum [Pa] or NaN, raw counts, temperature [0.01 degC], diagnostic bits)."""
        data = self.query_plant(ASKED, SIZE)
        vacuum, raw, warmth, flags, _, busy, second = struct.unpack(IN, data)
        self.estop_open = bool(flags & ESTOP)
        self.supply_low = bool(flags & SUPPLY_LOW)
        self.contact = bool(flags & CONTACT)
        self.second = second if flags & SECOND else None
        if busy:  # a simulated task keeps the core busy for this long [ms]
            self.leap = LEAP + 1000 * busy
            self.now = ticks.add(self.now, 1000 * busy)
        return vacuum, raw, warmth, flags & DIAGNOSTIC

    def read_second_sensor(self):
        """Return the second sensor's reading at the last sample [Pa]; None if it is not fitted."""
        return self.second

    def set_outputs(self, pump: float, power: int) -> None:
        """Set the pump (-1 to 1), and whether the vent valve is powered."""
        if pump != self.pump or power != self.power:
            self.pump, self.power = pump, power
            self.send_message(TOLD)

    def is_stop_pressed(self) -> bool:
        """Return whether the emergency stop was open (pressed) at the last sample."""
        return self.estop_open

    def has_supply(self) -> bool:
        """Return whether the supply voltage was sufficient at the last sample."""
        return not self.supply_low

    def show_state(self, state: int, sync: int) -> None:
        """Do nothing: a virtual board has neither a lamp nor a marker."""

    def arm_watchdog(self) -> None:
        """Do nothing: a virtual board is not used to test hangs, so it has no watchdog."""

    def feed_watchdog(self) -> None:
        """Do nothing: there is no watchdog."""

    def load(self, slot: int):
        """Return the settings in a slot, or None; if no file is used, those kept in memory."""
        if not self.store:
            return self.slots[slot]
        try:
            with open(self.store + SLOT % slot, "rb") as file:
                return file.read()
        except OSError as error:
            return None if error.errno == MISSING else b""

    def save(self, slot: int, data: bytes) -> None:
        """Store settings in a slot."""
        self.slots[slot] = data
        if self.store:
            self.write_file(self.store + SLOT % slot, data)
        self.saved = self.host_us()

    def write_file(self, path: str, data: bytes) -> None:
        """Write a file and flush it to disk, which MicroPython's `flush` does."""
        with open(path, "wb") as file:
            file.write(data)
            file.flush()

    def time_since_save(self) -> int:
        """Return the host's time [us] since settings were last stored."""
        return 1 << 40 if self.saved is None else self.host_us() - self.saved

    def is_contact_closed(self) -> bool:
        """Return whether the trigger contact was closed at the last sample."""
        return self.contact

    def start_capture(self, rate: int) -> None:
        """Make the plant sample its accelerometer from now on."""
        self.capture_ring = array.array("h", bytes(2 * ROOM))
        data = self.query_plant(STARTED, struct.calcsize(SCALE), rate)
        self.scale = struct.unpack(SCALE, data)
        self.sampled, self.since, self.passed = 0, self.now, 0
        self.captures = True

    def capture_count(self) -> int:
        """Return the number of samples since the start, after storing new ones in the ring."""
        if not self.captures:
            return self.sampled
        board_time = self.ticks_us()
        self.passed += ticks.diff(board_time, self.since)
        self.since = board_time
        left = int(self.passed * self.scale[3] * 1e-6) - self.sampled
        while left > 0:
            place = self.sampled % ROOM
            count = min(left, ROOM - place)
            data = self.query_plant(SAMPLED, 2 * count, count)
            self.capture_ring[place : place + count] = array.array("h", data)
            self.sampled, left = self.sampled + count, left - count
        return self.sampled

    def capture_part(self, first: int, last: int) -> memoryview:
        """Return a part of the ring."""
        return memoryview(self.capture_ring)[first:last]

    def stop_capture(self) -> None:
        """Stop sampling; the ring keeps its content."""
        self.captures = False

    def capture_scale(self) -> tuple:
        """Return counts at 0, m/s^2 per count, range [m/s^2], rate [Hz] of the last start."""
        return self.scale

    def identity(self) -> tuple:
        """Return (model, serial number)."""
        return "virtual bench", self.serial

    def reset_cause(self) -> str:
        """Return POWER_ON, SOFT or WATCHDOG."""
        return self.cause

    def reset(self) -> None:
        """Restart the board."""
        raise self.reset_error

    def enter_maintenance(self) -> None:
        """Do nothing: a virtual board has no prompt."""
        raise ScpiError(-241, "a virtual board has no prompt " + sys.platform)

    def handle_crash(self, error) -> None:
        """End the process with this error."""
        raise error
