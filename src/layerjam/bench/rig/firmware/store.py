"""Settings that survive a power failure: two alternating files with counters and checksums."""

import binascii
import math
import struct

LAW = 39
"""Number of doubles in the law's settings: 15 for the controller, 24 for its detectors."""
REGULATOR = 15
MAGIC = b"LJ01"
FIXED = "<4sIBBddB"
BIG = 1e16
LIMITS = (
    (0, 2), (0, 1e3), (0, 1e3), (0, 1e5), (1e-9, 1.2e5), (-1, 0), (1e-6, 1), (0, 1e9), (0, 1e9),
    (0, 1e9), (0, 1e12), (0, 1e12), (10, 1.2e5), (0, 1), (0, 1),
    (1e-12, 1e6), (1, 1e6), (0, 1e3), (0, 1e3), (1e-12, 1), (-1e6, 0), (1e-3, 1e9), (1, 1e6),
    (1e-9, 1e6), (0, 1), (0, 1), (1, 1e3), (1e-9, 1e6), (0, 1e9), (1, BIG), (0, 1e9),
    (1e-9, 1e5), (0, 1e9), (-BIG, BIG), (-BIG, BIG), (-BIG, BIG), (0, 1e3), (1e-12, 1e7), (0, 1e5),
)  # fmt: skip
"""Smallest and largest value of each number in the law's settings, in their order."""
INTEGER_PLACES = (0, 5, 14)
"""Indices of the numbers that must be integers: the kind, and yes-or-no values."""


class Settings:
    """Declared settings of a board; settings that could be unsafe have no default."""

    def __init__(self) -> None:
        self.safe = 0
        """Safe state: 1 release, 2 hold, 0 not declared."""
        self.rest = 0
        """Position of the vent without power: 1 open, 2 closed, 0 not declared."""
        self.law = None
        self.offset = 0.0
        self.gain = 1.0
        self.sensor = ""
        """Name of the sensor's calibration."""
        self.generation = 0

    def pack(self) -> bytes:
        """Return the settings as one file."""
        name = self.sensor.encode()
        law = b"" if self.law is None else flatten_law(self.law)
        body = struct.pack(
            FIXED, MAGIC, self.generation, self.safe, self.rest, self.offset, self.gain, len(name)
        )  # fmt: skip
        body += name + law
        return body + struct.pack("<I", binascii.crc32(body))


def flatten_law(law: tuple) -> bytes:
    """Return the law's settings as little-endian doubles."""
    return struct.pack("<%dd" % LAW, *law[0], *law[1])


def parse_law(raw: bytes) -> tuple:
    """Return (the law's settings, "") from packed doubles, or (None, error in one of them)."""
    numbers = struct.unpack("<%dd" % LAW, raw)
    for place, value in enumerate(numbers):
        lo, hi = LIMITS[place]
        if not lo <= value <= hi or math.isnan(value):
            return None, "number %d of the law must be %g to %g" % (place, lo, hi)
        if place in INTEGER_PLACES and value != int(value):
            return None, "number %d of the law must be an integer" % place
    return (tuple(numbers[:REGULATOR]), tuple(numbers[REGULATOR:])), ""


def unpack_settings(raw: bytes) -> "Settings | None":
    """Return the settings in one file; None if it is damaged."""
    size = struct.calcsize(FIXED)
    if raw is None or len(raw) < size + 4 or raw[:4] != MAGIC:
        return None
    body, (check,) = raw[:-4], struct.unpack("<I", raw[-4:])
    if check != binascii.crc32(body):
        return None
    settings = Settings()
    _, settings.generation, settings.safe, settings.rest, settings.offset, settings.gain, name = (
        struct.unpack(FIXED, body[:size])
    )
    settings.sensor = str(body[size : size + name], "ascii")
    law, wrong = body[size + name :], ""
    if law:
        settings.law, wrong = parse_law(law) if len(law) == 8 * LAW else (None, "its length")
    return None if wrong else settings


def load(hal) -> tuple:
    """Return (settings, error or 0) of the newer of two slots; error -314 if no slot is intact."""
    raw = [hal.load(0), hal.load(1)]
    good = [s for s in [unpack_settings(slot) for slot in raw if slot is not None] if s]
    if not good:
        return Settings(), -314 if raw != [None, None] else 0
    newest = good[0]
    for settings in good[1:]:
        if settings.generation > newest.generation:
            newest = settings
    torn = sum(1 for slot in raw if slot is not None) > len(good)
    return newest, 125 if torn else 0


def save(hal, settings: Settings) -> None:
    """Write the settings to the slot that does not hold the newest ones."""
    settings.generation += 1
    hal.save(settings.generation % 2, settings.pack())
