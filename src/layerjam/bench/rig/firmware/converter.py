"""The RP2040's converter, used for single readings or for an accelerometer record by DMA.

During a record the converter runs freely and alternates between the accelerometer and the other
voltages that a sample needs. One DMA channel writes the accelerometer's counts to the record's
ring, and a second one stores the other voltages; each channel starts the other.
"""

import array

import machine
import outside
from capture import NOTHING, ROOM

CONTROL, QUEUE, TAKEN, DIVIDER = 0x4004C000, 0x4004C008, 0x4004C00C, 0x4004C010
ENABLED, START_MANY, READY, INPUT, TURNS = 1, 8, 1 << 8, 12, 16
"""Bits of the register CONTROL; the last two are the lowest bits of fields."""
QUEUED, ASKS, EMPTY, SPILT, LEVEL = 1, 1 << 3, 1 << 8, 1 << 11, 1 << 24
"""Bits of the register QUEUE: queue on, DMA request, empty, overflow, and a threshold of one."""
CLOCK = 48000000
PACE = 36
"""Index of the converter in the list of DMA requests."""
FIRST, CHANNELS = 26, 5
CODES, FULL = 4096, 65535
ASIDE, ASIDE_BITS = 16, 5
"""Number of stored readings of the other voltages, and number of address bits of their ring."""
RING_BITS = 15
TRIES = 1000


class Voltage:
    """One pin of the converter."""

    def __init__(self, converter, number: int) -> None:
        self.converter, self.channel = converter, number - FIRST
        self.adc = machine.ADC(machine.Pin(number))

    def read_mean(self, reads: int) -> float:
        """Return the mean of some conversions (during a record: the latest), from 0 to 65535."""
        converter = self.converter
        if converter.running:
            codes = converter.aside[converter.others.index(self.channel) :: len(converter.others)]
            return sum(codes) * FULL / ((CODES - 1) * len(codes))
        total = 0
        for _ in range(reads):
            total += self.adc.read_u16()
        return total / reads


class Converter:
    """The chip's only converter; `running` is true during a record."""

    def __init__(self, pins: dict) -> None:
        self.running = False
        self.voltages: list[Voltage] = []
        self.others: list[int] = []
        self.counted = 0
        self.rate = 0.0
        self.begin = outside.reserved_address("FAST")
        self.records = self.begin > 0 and pins.get("accelerometer_full") is not None
        if self.records:
            self.store = outside.map_memory(self.begin, 2 * ROOM)
            # twice the size, because a DMA ring must start at a multiple of its size
            self.spare = array.array("H", bytes(4 * ASIDE))
            machine.ADC(machine.Pin(pins["accelerometer_adc"]))
            self.input = pins["accelerometer_adc"] - FIRST
            self.zero = pins["accelerometer_zero"] * CODES
            self.range = pins["accelerometer_range"]
            full = pins["accelerometer_full"] - pins["accelerometer_zero"]
            self.gain = self.range / (full * CODES)

    def add_pin(self, number: int) -> Voltage:
        """Return a pin that can be read at each sample, even during a recording."""
        voltage = Voltage(self, number)
        self.voltages.append(voltage)
        return voltage

    def start_record(self, rate: int) -> None:
        """Start sampling the accelerometer at the nearest rate that the divider allows."""
        import rp2
        import uctypes

        self.stop_record()
        first, by_channel = self.input, {pin.channel: pin for pin in self.voltages}
        self.others = sorted(by_channel, key=lambda channel: (channel - first) % CHANNELS)
        turn = 1 + len(self.others)
        address = uctypes.addressof(self.spare)
        padding = -address % (2 * ASIDE)
        self.aside = memoryview(self.spare)[padding // 2 : padding // 2 + ASIDE]
        for place in range(ASIDE):  # a sample may be read before the first rounds are over
            channel = self.others[place % len(self.others)]
            self.aside[place] = by_channel[channel].adc.read_u16() >> 4
        self.empty_queue()
        divider = (CLOCK * 256 + rate * turn // 2) // (rate * turn) - 256
        self.rate = CLOCK * 256 / ((divider + 256) * turn)
        self.fast, self.rest = rp2.DMA(), rp2.DMA()
        self.configure_channel(self.fast, self.begin, 1, RING_BITS, self.rest)
        self.configure_channel(self.rest, address + padding, turn - 1, ASIDE_BITS, self.fast)
        self.fast.active(1)
        machine.mem32[QUEUE] = QUEUED | ASKS | LEVEL
        machine.mem32[DIVIDER] = divider
        turns = 1 << first
        for channel in self.others:
            turns |= 1 << channel
        self.counted, self.running = 0, True
        machine.mem32[CONTROL] = ENABLED | first << INPUT | turns << TURNS | START_MANY

    def configure_channel(self, channel, address: int, count: int, bits: int, after) -> None:
        """Make a DMA channel write `count` values to a ring and then start the channel `after`."""
        control = channel.pack_ctrl(
            size=1, inc_read=0, inc_write=1, ring_sel=1, ring_size=bits, treq_sel=PACE,
            chain_to=after.channel, high_pri=1,
        )  # fmt: skip
        channel.config(read=TAKEN, write=address, count=count, ctrl=control)

    def count_samples(self) -> int:
        """Return the number of samples since the start; call this more often than the ring fills.

        Return -1 if the queue has overflowed, because each value's input is then unknown.
        """
        if self.running:
            if machine.mem32[QUEUE] & SPILT:
                return -1
            written_samples = (self.fast.write - self.begin) >> 1
            self.counted += (written_samples - self.counted) % ROOM
        return self.counted

    def copy_samples(self, first: int, last: int) -> array.array:
        """Return a copy of a part of the ring."""
        return array.array("h", self.store[2 * first : 2 * last])

    def read_scale(self) -> tuple:
        """Return counts at 0, m/s^2 per count, range [m/s^2] and rate [Hz] since the last start."""
        return (self.zero, self.gain, self.range, self.rate) if self.rate else NOTHING

    def stop_record(self) -> None:
        """Return to single readings; the ring keeps its content."""
        if not self.running:
            return
        machine.mem32[CONTROL] = ENABLED
        for _ in range(TRIES):
            if machine.mem32[CONTROL] & READY:
                break
        for channel in (self.fast, self.rest):
            channel.active(0)
            channel.close()
        self.running = False
        self.empty_queue()

    def empty_queue(self) -> None:
        """Empty the queue and clear its requests and overflow."""
        machine.mem32[QUEUE] = SPILT
        for _ in range(TRIES):
            if machine.mem32[QUEUE] & EMPTY:
                break
            machine.mem32[TAKEN]
