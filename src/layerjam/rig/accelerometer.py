"""The accelerometer of a virtual board: an ADXL193 behind a divider, on a converter of 12 bits."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from layerjam.simulate.accelerometer import ADXL193, STANDARD_GRAVITY

SCALE = struct.Struct("<4d")
"""Counts at 0, m/s^2 a count, range [m/s^2], rate [Hz]."""
SENSITIVITY = 8e-3
"""Of an ADXL193 of 250 g on 5 V [V/g], half the supply at 0 g; remembered, no sheet was opened."""
DIVIDER, REFERENCE, CODES = 2 / 3, 3.3, 4096
ZERO = 2.5 * DIVIDER / REFERENCE * CODES
"""Counts at 0."""
GAIN = STANDARD_GRAVITY / (SENSITIVITY * DIVIDER / REFERENCE * CODES)
"""m/s^2 a count."""
RANGE = float(ADXL193.range or 0.0)
NOISE = 1.2
"""Counts, RMS: 0.97 to 1.36 were measured of an RP2040's converter (pico-adc.markomo.me)."""
Array = np.ndarray[Any, Any]


class VirtualAccelerometer:
    """Specific force along its axis in counts, from the plant's time.

    At rest it shows 1 g. `play` puts a signal on it.
    """

    def __init__(self, seed: int) -> None:
        self._draw = np.random.default_rng(seed)
        self._rate, self._begun, self._given = 8000, 0.0, 0
        self._signal: tuple[float, Array, Array] | None = None

    def play(self, at: float, time: Array, force: Array) -> None:
        """From the plant's time `at` [s] on a specific force [m/s^2]; shapes (N,), rising times.

        Before it the sensor is at rest, after it the last value stays.
        """
        self._signal = (at, np.asarray(time, float), np.asarray(force, float))

    def start(self, rate: int, now: float) -> bytes:
        """Begin to sample; the scale, packed."""
        self._rate, self._begun, self._given = rate, now, 0
        return SCALE.pack(ZERO, GAIN, RANGE, float(rate))

    def samples(self, count: int) -> bytes:
        """The next samples, int16, little-endian."""
        at = self._begun + (self._given + np.arange(count)) / self._rate
        self._given += count
        force = np.full(count, STANDARD_GRAVITY)
        if self._signal is not None:
            begin, time, values = self._signal
            force = np.interp(at - begin, time, values, left=STANDARD_GRAVITY)
        shown = np.clip(force, -RANGE, RANGE) / GAIN + ZERO
        codes = np.round(shown + NOISE * self._draw.standard_normal(count))
        return np.clip(codes, 0, CODES - 1).astype("<i2").tobytes()
