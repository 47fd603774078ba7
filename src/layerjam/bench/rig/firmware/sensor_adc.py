"""A sensor with a voltage output, amplified or divided, read by the board's own converter."""

READS = 8
"""Number of conversions averaged for one reading."""
WIRE = 0.01
"""Fraction of the converter's range, at either end, that is reached only with a broken wire."""


class Sensor:
    """`sensor_zero` and `sensor_full`: fractions of the range at zero and at `sensor_range`."""

    def __init__(self, pins: dict, converter) -> None:
        self.zero = pins["sensor_zero"]
        self.pascals = pins["sensor_range"] / (pins["sensor_full"] - self.zero)
        self.volts = converter.add_pin(pins["sensor_adc"])

    def read(self) -> tuple:
        """Return (vacuum [Pa] or NaN, 16-bit counts, no temperature, 1 if a wire is broken)."""
        mean = self.volts.read_mean(READS)
        share, raw = mean / 65535, int(mean)
        if not WIRE <= share <= 1.0 - WIRE:
            return float("nan"), raw, 0, 1
        return (share - self.zero) * self.pascals, raw, 0, 0
