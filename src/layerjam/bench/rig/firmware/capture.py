"""The accelerometer's record: the HAL samples it into a ring, and a trigger selects the record.

A HAL with an accelerometer has `start_capture(rate)`, `capture_scale()`, `stop_capture()`, and
`is_contact_closed()`. `capture_count()` returns the number of samples since the start, or -1 if
some were lost. `capture_part(first, last)` returns int16 counts of its ring of length ROOM, sample
n at n % ROOM.
"""

import struct

from scpi import ScpiError

IDLE, WAITING, RUNNING, DONE = 0, 1, 2, 3
STATES = ("IDLE", "WAITING", "RUNNING", "DONE")
IMMEDIATE, BUS, ACCELERATION, EXTERNAL = 0, 1, 2, 3
ROOM = 16384
"""Number of samples in the ring."""
SPARE = 0.02
"""Length of ring [s] kept free, because samples may overwrite it before a late `tick`."""
STILL = 10
"""Number of initial ticks with samples whose mean reading is the level at rest."""
LEAST, GREATEST = 0.7, 1.3
"""Range of the change in the reading [g], of either sign, that counts as free fall."""
GRAVITY = 9.80665
READ = 2000
"""Largest number of samples in one response."""
NOTHING = (0.0, 1.0, 0.0, 0.0)


class Capture:
    """Settings and state of one record, samples `first` to `end`; `at` is the trigger sample."""

    def __init__(self, hal) -> None:
        self.hal = hal
        self.state = IDLE
        self.reset()

    def reset(self) -> None:
        """Set the power-up defaults, and discard any record."""
        self.stop()
        self.state = IDLE
        self.scale = NOTHING
        self.rate, self.before, self.after = 8000, 0.1, 0.5
        self.source, self.level, self.fall = IMMEDIATE, 5.0, 0.03
        self.first = self.at = self.end = 0
        self.micros = 0

    def is_busy(self) -> bool:
        """Return whether a capture is waiting or running; this is the only overlapped operation."""
        return self.state in (WAITING, RUNNING)

    def stop(self) -> None:
        """Stop a capture that is waiting or running; a complete record is kept."""
        if self.is_busy():
            self.hal.stop_capture()
            self.state = IDLE

    def require_idle(self) -> None:
        """Raise an error during a capture, because the command would change it."""
        if self.is_busy():
            raise ScpiError(-221, "a capture is waiting or running; send ABOR")

    def start(self) -> None:
        """Start sampling and wait for the trigger."""
        if self.is_busy():
            raise ScpiError(-213, "a capture is waiting or running")
        if not hasattr(self.hal, "start_capture"):
            raise ScpiError(-241, "no accelerometer")
        if self.rate * (self.before + self.after + SPARE) > ROOM:
            raise ScpiError(-221, "rate, PRE and POST need more than %d samples" % ROOM)
        self.hal.start_capture(self.rate)
        self.scale = self.hal.capture_scale()
        self.state = WAITING
        self.asked = self.armed = False
        self.looked = self.looks = 0
        self.rest, self.zero, self.fallen = 0.0, 0.0, 0.0
        self.closed = None

    def trigger(self) -> None:
        """Trigger the capture (`*TRG`)."""
        if self.state != WAITING or self.source != BUS:
            raise ScpiError(-211, "no capture is waiting for a trigger")
        self.asked = True

    def tick(self, micros: int) -> bool:
        """Process new samples, 100 times a second; `micros` is the board's time.

        Return True if samples have been lost; the record is then discarded.
        """
        if not self.is_busy():
            return False
        count = self.hal.capture_count()
        if count < 0:
            self.stop()
            return True
        if self.state == WAITING:
            trigger = self.find_trigger(count)
            self.looks += count > self.looked  # a tick right after the start has no samples yet
            self.looked = count
            if trigger >= 0:
                self.state, self.at = RUNNING, trigger
                self.first = max(trigger - int(self.rate * self.before + 0.5), 0)
                self.end = trigger + int(self.rate * self.after + 0.5)
                self.micros = (micros - int((count - trigger) * 1e6 / self.scale[3])) & 0xFFFFFFFF
        elif count >= self.end:
            self.hal.stop_capture()
            self.state = DONE
        return False

    def find_trigger(self, count: int) -> int:
        """Return the number of the sample that triggers, or -1."""
        if self.source == IMMEDIATE:
            trigger = int(self.rate * self.before + 0.5)
            return trigger if count > trigger else -1
        if self.source == BUS:
            return count if self.asked else -1
        if self.source == EXTERNAL:
            was, self.closed = self.closed, self.hal.is_contact_closed()
            return count if self.closed and was is False else -1
        return self.find_hit(self.looked, count)

    def find_hit(self, begin: int, end: int) -> int:
        """Return the first sample beyond the level, once at rest and fallen if required, or -1."""
        if begin == end:
            return -1
        parts = self.parts(begin, end)
        count = end - begin
        mean = sum([sum(part) for part in parts]) / count
        if self.looks < STILL:
            self.rest += (mean - self.rest) / (self.looks + 1)
            self.zero = self.rest
            return -1
        gain = GRAVITY / abs(self.scale[1])
        if self.fall > 0.0 and not self.armed:
            if LEAST * gain <= abs(mean - self.rest) <= GREATEST * gain:
                self.fallen += count / self.scale[3]
                self.zero = mean
                self.armed = self.fallen >= self.fall - 1e-6
            else:
                self.fallen = 0.0
            return -1
        low, high = self.zero - self.level * gain, self.zero + self.level * gain
        if low <= min([min(part) for part in parts]) and high >= max([max(p) for p in parts]):
            return -1
        number = begin
        for part in parts:
            for value in part:
                if not low <= value <= high:
                    return number
                number += 1
        return -1

    def parts(self, begin: int, end: int) -> list:
        """Return samples from the ring, in one or two non-empty parts."""
        part = self.hal.capture_part
        first, last = begin % ROOM, end % ROOM
        if first < last:
            return [part(first, last)]
        return [part(first, ROOM), part(0, last)] if last else [part(first, ROOM)]

    def data(self, first: int, count: int) -> bytes:
        """Return `count` samples of the record starting with `first`, int16, little-endian."""
        if self.state != DONE:
            raise ScpiError(-230, "no record; the state is " + STATES[self.state])
        size = self.end - self.first
        if not (first < size and first + count <= size):
            raise ScpiError(-222, "the record has %d samples" % size)
        begin = self.first + first
        return b"".join([bytes(part) for part in self.parts(begin, begin + count)])

    def format_state(self) -> str:
        """Return state, number of samples, samples before the trigger, time of the trigger [us]."""
        known = self.state in (RUNNING, DONE)
        size = self.end - self.first if known else 0
        before = self.at - self.first if known else 0
        return "%s,%d,%d,%d" % (STATES[self.state], size, before, self.micros if known else 0)

    def pack_scale(self) -> bytes:
        """Return offset [counts], scale [m/s^2 per count], range [m/s^2] and rate [Hz], packed."""
        has = hasattr(self.hal, "capture_scale")
        return struct.pack("<4d", *(self.hal.capture_scale() if has else NOTHING))
