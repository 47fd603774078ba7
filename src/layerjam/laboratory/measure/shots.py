"""Accelerometer record of one drop, from a board or a run file."""

import json
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.core.errors import FileError
from layerjam.core.store import store_file
from layerjam.core.toml_files.table_text import comment

SYNTHETIC = "synthetic: computed by a virtual bench, not measured"
MEASURED = "measured on a bench"
PIECE = 1000
"""Number of samples in one row of `shot_data`, and in one query to a board."""
Array = np.ndarray[Any, np.dtype[Any]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot:
    """One record; `counts` (N,), int16, has `before` samples before the trigger.

    `zero` [counts], `gain` [m/s^2 per count], `range` [m/s^2] and `rate` [Hz] are the values of the
    board. `number` and `boot` are those in a run file; `size` is N if nothing is missing.
    """

    counts: Array = field(repr=False)
    size: int
    rate: float
    zero: float
    gain: float
    range: float
    before: int
    trigger_us: int
    """Trigger time on the board's clock [us]; outside a run file, only its low 32 bits."""
    synthetic: bool
    """Whether a virtual board recorded it."""
    number: int = 1
    boot: int = 0

    @property
    def time(self) -> Array:
        """Time since the trigger [s], shape (N,)."""
        return (np.arange(len(self.counts)) - self.before) / self.rate

    @property
    def acceleration(self) -> Array:
        """Specific force along the sensor's axis [m/s^2], shape (N,); 0 in free fall."""
        return (self.counts.astype(float) - self.zero) * self.gain

    def row(self) -> dict[str, Any]:
        """Return the record's row in the table `shots`."""
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
        """Return the record's rows in the table `shot_data`: (first, n, samples)."""
        counts = self.counts.astype("<i2")
        pieces = {first: counts[first : first + PIECE] for first in range(0, len(counts), PIECE)}
        return [(first, len(piece), piece.tobytes()) for first, piece in pieces.items()]

    @classmethod
    def from_rows(
        cls, row: Mapping[str, Any], parts: list[tuple[int, int, bytes]], synthetic: bool
    ) -> "Shot":
        """Return the record in `row` and `parts`, up to the first gap."""
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

    def text(self, facts: Mapping[str, str] | None = None) -> str:
        """Return CSV for `layerjam crash`; the metadata `facts` are added to its first lines."""
        head = {
            **(facts or {}),
            "data": SYNTHETIC if self.synthetic else MEASURED,
            "shot": f"{self.number}",
            "range": f"{self.range:.6g} m/s^2",
        }
        lines = [f"# layerjam {__version__} bench export"]
        lines += [comment(f"{key}: {text}") for key, text in head.items()]
        lines.append("time [s],acceleration [m/s^2]")
        pairs = zip(self.time.tolist(), self.acceleration.tolist(), strict=True)
        lines += [f"{time:.9g},{value:.9g}" for time, value in pairs]
        return "\n".join(lines) + "\n"

    def write(self, file: str | Path, overwrite: bool = False) -> Path:
        """Write a CSV file; raises FileError on failure, or if it exists, unless `overwrite`."""
        return store_file(file, self.text(), overwrite)


def read_shots(base: sqlite3.Connection, synthetic: bool) -> tuple[Shot, ...]:
    """Return the records in an open run file, in order.

    Raises sqlite3.Error, or ValueError for foreign rows.
    """
    table = base.execute("SELECT * FROM shots ORDER BY shot")
    names = [column[0] for column in table.description]
    shots = []
    for values in table.fetchall():
        row = dict(zip(names, values, strict=True))
        parts = base.execute("SELECT first, n, data FROM shot_data WHERE shot = ?", (row["shot"],))
        try:
            shots.append(Shot.from_rows(row, parts.fetchall(), synthetic))
        except (KeyError, TypeError) as error:
            raise ValueError(f"shot {row['shot']}: {error!r}") from None
    return tuple(shots)


def find_shot(shots: tuple[Shot, ...], number: int | None, path: str) -> Shot:
    """Return the only shot of a run, or the one with a number; raises FileError."""
    numbers = [shot.number for shot in shots]
    if not numbers:
        raise FileError(path, "contains no shot; 'layerjam bench run --shot' records one")
    if number is None and len(numbers) > 1:
        names = ", ".join(map(str, numbers))
        raise FileError(path, f"contains the shots {names}; choose one (--shot {numbers[0]})")
    match = next((shot for shot in shots if number in (None, shot.number)), None)
    if match is None:
        names = ", ".join(map(str, numbers))
        raise FileError(path, f"contains no shot {number}, only {names}")
    return match
