"""Honeywell HSC and SSC sensors on SPI: 14 bits of pressure, 11 of temperature and two of status.

The counts 1638 and 14746 correspond to the lowest and the highest pressure of the part (Linux
driver hsc030pa.c); the clock is at most 800 kHz.
"""

import machine

BAUD = 500000
LOWEST, SPAN = 1638, 13108
STALE, BROKEN = 2, 3


class Sensor:
    """`range` is the highest pressure difference between the ports; the brake is at port 1."""

    def __init__(self, pins: dict) -> None:
        self.range = pins["sensor_range"]
        self.chosen = machine.Pin(pins["spi_cs"], machine.Pin.OUT, value=1)
        self.spi = machine.SPI(
            0,
            baudrate=BAUD,
            sck=machine.Pin(pins["spi_sck"]),
            mosi=machine.Pin(pins["spi_mosi"]),
            miso=machine.Pin(pins["spi_miso"]),
        )
        self.got = bytearray(4)

    def read(self) -> tuple:
        """Return (vacuum [Pa] or NaN, counts, temperature [0.01 degC], 1 after an error).

        Counts that are read twice are still valid; the law detects a part that stops responding.
        """
        data = self.got
        self.chosen.value(0)
        self.spi.readinto(data)
        self.chosen.value(1)
        status, raw = data[0] >> 6, (data[0] & 63) << 8 | data[1]
        warmth = ((data[2] << 3 | data[3] >> 5) * 20000) // 2047 - 5000
        if status not in (0, STALE):
            return float("nan"), raw, warmth, 1
        return self.range * (1.0 - 2.0 * (raw - LOWEST) / SPAN), raw, warmth, 0
