"""The drop rig: the accelerometer's record of a stop, taken by the board.

The record goes to `layerjam crash` as it is. `fall` lets a mass fall on a virtual board's brake.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from layerjam.errors import FileError, LayerjamError, QuantityError
from layerjam.rig.driver import Bench
from layerjam.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.device.file import BrakeFile
    from layerjam.simulate.drop import TimedStop

SOURCES = {"immediate": "IMM", "bus": "BUS", "acceleration": "ACC", "external": "EXT"}
PIECE = 1000
"""Samples in one question."""
PAUSE = 0.02
"""Seconds between two looks at the capture."""
REST, FINE = 0.05, 40e3
"""Seconds of rest before a virtual fall; rate [Hz] at which its signal is made."""
Array = np.ndarray[Any, np.dtype[Any]]
T = TypeVar("T")


class CaptureError(LayerjamError):
    """A record that did not come."""

    key = "capture"


@dataclass(frozen=True, kw_only=True)
class Shot:
    """One record; `counts` has shape (N,), int16, of which `before` come before the trigger.

    `zero` [counts], `gain` [m/s^2 a count], `range` [m/s^2] and `rate` [Hz] are the board's own.
    """

    counts: Array
    rate: float
    zero: float
    gain: float
    range: float
    before: int
    trigger_us: int
    """The board's time of the trigger, low 32 bits [us]."""
    synthetic: bool
    """Whether a virtual board made it."""

    @property
    def time(self) -> Array:
        """Time from the trigger on [s], shape (N,)."""
        return (np.arange(len(self.counts)) - self.before) / self.rate

    @property
    def acceleration(self) -> Array:
        """Specific force along the sensor's axis [m/s^2], shape (N,): 0 in free fall."""
        return (self.counts.astype(float) - self.zero) * self.gain

    def tables(self) -> tuple[dict[str, Any], list[tuple[int, int, bytes]]]:
        """The row of a run file's `shots`, and those of its `shot_data` (first, n, samples)."""
        scale = struct.pack("<4d", self.zero, self.gain, self.range, self.rate)
        row = {
            "rate": self.rate,
            "scale": scale,
            "trigger_us": self.trigger_us,
            "pre": self.before,
        }
        counts = self.counts.astype("<i2")
        parts = [
            (at, len(piece), piece.tobytes())
            for at in range(0, len(counts), PIECE)
            for piece in (counts[at : at + PIECE],)
        ]
        return row, parts

    @classmethod
    def of(
        cls, row: Mapping[str, Any], parts: list[tuple[int, int, bytes]], synthetic: bool
    ) -> Shot:
        """The record that `tables` made rows of."""
        zero, gain, reach, rate = struct.unpack("<4d", row["scale"])
        data = b"".join(samples for _, _, samples in sorted(parts))
        return cls(
            counts=np.frombuffer(data, "<i2"),
            rate=rate,
            zero=zero,
            gain=gain,
            range=reach,
            before=int(row["pre"]),
            trigger_us=int(row["trigger_us"]),
            synthetic=synthetic,
        )

    def write(self, file: str | Path) -> Path:
        """A CSV file that `layerjam crash` reads, and what it is on its first lines.

        Raises FileError where it cannot be written.
        """
        path = Path(file)
        kind = "synthetic: a virtual board" if self.synthetic else "measured"
        lines = [f"# {kind}; range {self.range:.6g} m/s^2", "time [s],acceleration [m/s^2]"]
        pairs = zip(self.time, self.acceleration, strict=True)
        lines += [f"{at:.9g},{value:.9g}" for at, value in pairs]
        try:
            path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        except OSError as error:
            raise FileError(path, error.strerror or "cannot be written") from None
        return path


RATE = QuantitySpec("Hz", "samples of the accelerometer a second", lo=500, hi=20000, whole=True)
BEFORE = QuantitySpec("s", "time kept before the trigger", lo=0, hi=0.5)
AFTER = QuantitySpec("s", "time kept after the trigger", lo=0.01, hi=1.5)
FALL = QuantitySpec("s", "free fall that arms the trigger; 0: none is needed", lo=0, hi=0.5)
LEVEL = QuantitySpec("1", "acceleration that triggers, in g", lo=0.5, hi=200)


def prepare(
    bench: Bench,
    *,
    source: str = "acceleration",
    rate: float | str = 8000.0,
    before: float | str = 0.1,
    after: float | str = 0.5,
    level: float = 5.0,
    fall: float | str = 0.03,
) -> None:
    """Set what a capture needs, in SAFE; what is so already is left alone.

    Rate [Hz]; times [s] before and after the trigger; `level` in g beyond what the sensor shows in
    the fall; `fall` [s] of free fall that arms it. Raises QuantityError and InstrumentError.
    """
    if source not in SOURCES:
        raise QuantityError.of("source", f"'{source}' is not one of {', '.join(SOURCES)}")
    wanted = {
        "SENS:ACC:RATE": RATE.si(rate, "rate"),
        "SENS:ACC:PRE": BEFORE.si(before, "before"),
        "SENS:ACC:POST": AFTER.si(after, "after"),
        "TRIG:LEV": LEVEL.si(level, "level"),
        "TRIG:FALL": FALL.si(fall, "fall"),
    }
    for header, value in wanted.items():
        if abs(float(bench.ask(header + "?")) - value) > 1e-8 * abs(value):
            bench.tell(f"{header} {value:.9g}")
    if bench.ask("TRIG:SOUR?") != SOURCES[source]:
        bench.tell(f"TRIG:SOUR {SOURCES[source]}")


def arm(bench: Bench) -> None:
    """Sample from now on and wait for the trigger; raises InstrumentError."""
    bench.tell("INIT")


def collect(bench: Bench, patience: float = 60.0) -> Shot:
    """The record, as soon as it is whole; asking keeps the lease alive.

    Raises CaptureError after `patience` [s] of the host without one, and where nothing waits.
    """
    end = time.monotonic() + patience
    while True:
        state, size, before, micros = bench.ask("FETC:ACC:STAT?").split(",")
        if state == "DONE":
            break
        if state == "IDLE":
            raise CaptureError("no capture waits or runs; arm it first")
        if time.monotonic() > end:
            bench.tell("ABOR")
            why = "nothing triggered" if state == "WAITING" else "the record did not end"
            raise CaptureError(f"no record of the accelerometer within {patience:g} s: {why}")
        time.sleep(PAUSE)
    scale = bytes.fromhex(bench.ask("FETC:ACC:SCAL?").strip('"'))
    zero, gain, reach, rate = struct.unpack("<4d", scale)
    data = b""
    for at in range(0, int(size), PIECE):
        data += bench.block(f"FETC:ACC:DATA? {at},{min(PIECE, int(size) - at)}")
    return Shot(
        counts=np.frombuffer(data, "<i2"),
        rate=rate,
        zero=zero,
        gain=gain,
        range=reach,
        before=int(before),
        trigger_us=int(micros),
        synthetic=bench.simulated,
    )


def capture(
    bench: Bench,
    *,
    patience: float = 60.0,
    ready: Callable[[], None] | None = None,
    **settings: Any,
) -> Shot:
    """One record, from settings to samples; `ready` is called once it waits for the trigger.

    `settings` are those of `prepare`. Raises what that, `arm` and `collect` raise.
    """
    prepare(bench, **settings)
    arm(bench)
    if ready is not None:
        ready()
    return collect(bench, patience)


def fall(
    bench: Bench,
    file: BrakeFile,
    *,
    mass: float,
    speed: float,
    rope_stiffness: float | None = None,
    delay: float = 0.5,
) -> TimedStop:
    """Let a mass [kg] fall on a virtual board's brake, to arrive with `speed` [m/s]; how it stops.

    The vacuum is the plant's own at this moment, and held. The mass is at rest for `delay` [s] of
    the board's time, falls freely for speed/g, and is stopped as `layerjam drop` computes it; the
    board's accelerometer, an ADXL193 with its low-pass, shows that. Raises QuantityError where no
    virtual board of this program is behind the bench.
    """
    plant = bench.plant
    if plant is None:
        raise QuantityError.of("bench", f"{bench.address} is no virtual board of this program")

    def computed() -> tuple[TimedStop, Array, Array]:
        from layerjam.simulate.accelerometer import ADXL193, seen, specific_force
        from layerjam.simulate.drop import drop

        found, record = drop(
            file, mass=mass, speed=speed, vacuum=plant.vacuum, rope_stiffness=rope_stiffness
        )
        gravity = file.brake.site.gravity
        pulse, force = specific_force(record)
        flight = speed / gravity
        begin = np.array([-flight - REST, -flight, -flight + 1e-9])
        times = np.concatenate([begin, pulse[pulse > 0.0]])
        forces = np.concatenate([[gravity, gravity, 0.0], force[pulse > 0.0]])
        shown = seen((times, forces), replace(ADXL193, range=None, sampling=FINE))
        return found, shown.time + flight, shown.acceleration

    found, times, forces = kept_alive(bench, computed)
    plant.accelerometer.play(plant.time + delay, times, forces)
    return found


def kept_alive(bench: Bench, work: Callable[[], T]) -> T:
    """What `work` returns, computed while the bench's lease is kept alive."""
    pause = min(bench.lease / 4, 0.1)
    with ThreadPoolExecutor(1) as pool:
        job = pool.submit(work)
        while not job.done():
            bench.ask("*OPC?")
            time.sleep(pause)
        return job.result()
