"""An accelerometer's record of one drop, as a board takes it and a run file holds it."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.device.load import write_whole
from layerjam.errors import FileError
from layerjam.records.table_text import comment

SYNTHETIC = "synthetic: a virtual bench computed it, nothing was measured"
MEASURED = "measured on a bench"
PIECE = 1000
"""Samples in one row of `shot_data`, and in one question to a board."""
SCHEMA = """
-- accelerations: trigger_us on the clock of board_us; samples of the whole record, pre of them
-- before the trigger; scale is JSON: zero (counts at 0), gain (m/s^2 a count), range (m/s^2)
CREATE TABLE shots (
  shot INTEGER PRIMARY KEY, boot INTEGER, rate REAL, scale TEXT, trigger_us INTEGER, pre INTEGER,
  samples INTEGER
);
-- n counts from the sample first on, int16, little-endian
CREATE TABLE shot_data (
  shot INTEGER, first INTEGER, n INTEGER, data BLOB, PRIMARY KEY (shot, first)
);
"""
Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """One record; `counts` has shape (N,), int16, of which `before` come before the trigger.

    `zero` [counts], `gain` [m/s^2 a count], `range` [m/s^2] and `rate` [Hz] are the board's own.
    `number` and `boot` are those of a run file; `size` is N where nothing is missing.
    """

    counts: Array
    size: int
    rate: float
    zero: float
    gain: float
    range: float
    before: int
    trigger_us: int
    """The board's time of the trigger [us]; outside of a run file its low 32 bits."""
    synthetic: bool
    """Whether a virtual board made it."""
    number: int = 1
    boot: int = 0

    @property
    def time(self) -> Array:
        """Time from the trigger on [s], shape (N,)."""
        return (np.arange(len(self.counts)) - self.before) / self.rate

    @property
    def acceleration(self) -> Array:
        """Specific force along the sensor's axis [m/s^2], shape (N,): 0 in free fall."""
        return (self.counts.astype(float) - self.zero) * self.gain

    def row(self) -> dict[str, Any]:
        """Its row of `shots`."""
        scale = {"zero": self.zero, "gain": self.gain, "range": self.range}
        return {
            "shot": self.number,
            "boot": self.boot,
            "rate": self.rate,
            "scale": json.dumps(scale),
            "trigger_us": self.trigger_us,
            "pre": self.before,
            "samples": self.size,
        }

    def parts(self) -> list[tuple[int, int, bytes]]:
        """Its rows of `shot_data`: first, n, samples."""
        counts = self.counts.astype("<i2")
        pieces = {at: counts[at : at + PIECE] for at in range(0, len(counts), PIECE)}
        return [(at, len(piece), piece.tobytes()) for at, piece in pieces.items()]

    @classmethod
    def of(
        cls, row: Mapping[str, Any], parts: list[tuple[int, int, bytes]], synthetic: bool
    ) -> Shot:
        """The record that `row` and `parts` made rows of, as far as it came without a gap."""
        data = b""
        for first, _, samples in sorted(parts):
            if first * 2 == len(data):
                data += samples
        scale = json.loads(row["scale"])
        return cls(
            counts=np.frombuffer(data, "<i2"),
            size=int(row["samples"]),
            rate=float(row["rate"]),
            zero=float(scale["zero"]),
            gain=float(scale["gain"]),
            range=float(scale["range"]),
            before=int(row["pre"]),
            trigger_us=int(row["trigger_us"]),
            synthetic=synthetic,
            number=int(row["shot"]),
            boot=int(row["boot"]),
        )

    def text(self, said: Mapping[str, str] | None = None) -> str:
        """CSV that `layerjam crash` reads; `said` is what its first lines say besides."""
        head = {
            **(said or {}),
            "data": SYNTHETIC if self.synthetic else MEASURED,
            "shot": f"{self.number}",
            "range": f"{self.range:.6g} m/s^2",
        }
        lines = [f"# layerjam {__version__} bench export"]
        lines += [comment(f"{key}: {text}") for key, text in head.items()]
        lines.append("time [s],acceleration [m/s^2]")
        pairs = zip(self.time.tolist(), self.acceleration.tolist(), strict=True)
        lines += [f"{at:.9g},{value:.9g}" for at, value in pairs]
        return "\n".join(lines) + "\n"

    def write(self, file: str | Path, force: bool = False) -> Path:
        """A CSV file of `text`; FileError where it exists (unless `force`) or cannot be written."""
        return write_whole(file, self.text(), force)


def shots_in(base: sqlite3.Connection, synthetic: bool) -> tuple[Shot, ...]:
    """The records in an open run file, in their order.

    Raises sqlite3.Error, or ValueError for rows that are none of ours.
    """
    table = base.execute("SELECT * FROM shots ORDER BY shot")
    names = [column[0] for column in table.description]
    made = []
    for values in table.fetchall():
        row = dict(zip(names, values, strict=True))
        parts = base.execute("SELECT first, n, data FROM shot_data WHERE shot = ?", (row["shot"],))
        try:
            made.append(Shot.of(row, parts.fetchall(), synthetic))
        except (KeyError, TypeError) as error:
            raise ValueError(f"shot {row['shot']}: {error!r}") from None
    return tuple(made)


def chosen(shots: tuple[Shot, ...], number: int | None, path: str) -> Shot:
    """The shot of a run that is meant: the only one, or that of a number; raises FileError."""
    numbers = [shot.number for shot in shots]
    if not numbers:
        raise FileError(path, "holds no shot; 'layerjam bench run --shot' records one")
    if number is None and len(numbers) > 1:
        listed = ", ".join(map(str, numbers))
        raise FileError(path, f"holds the shots {listed}; say which one (--shot {numbers[0]})")
    found = next((shot for shot in shots if number in (None, shot.number)), None)
    if found is None:
        listed = ", ".join(map(str, numbers))
        raise FileError(path, f"holds no shot {number}; there are {listed}")
    return found
