"""A sensor with a voltage, through an amplifier or a divider, on the board's own converter."""

READS = 8
"""Conversions in one reading, for their mean."""
WIRE = 0.01
"""Share of the converter's range at either end that only a broken wire shows."""


class Sensor:
    """`sensor_zero` and `sensor_full`: shares of the range at no vacuum and at `sensor_range`."""

    def __init__(self, pins: dict, converter) -> None:
        self.zero = pins["sensor_zero"]
        self.pascals = pins["sensor_range"] / (pins["sensor_full"] - self.zero)
        self.volts = converter.voltage(pins["sensor_adc"])

    def read(self) -> tuple:
        """(vacuum [Pa] or NaN, counts of 16 bits, no temperature, 1 where a wire is broken)."""
        mean = self.volts.mean(READS)
        share, raw = mean / 65535, int(mean)
        if not WIRE <= share <= 1.0 - WIRE:
            return float("nan"), raw, 0, 1
        return (share - self.zero) * self.pascals, raw, 0, 0
