"""The drop rig: the accelerometer's record of a stop, taken by the board.

The record goes to `layerjam crash` as it is. `fall` lets a mass fall on a virtual board's brake.
"""

from __future__ import annotations

import contextlib
import struct
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.errors import LayerjamError, QuantityError
from layerjam.measure.shots import PIECE, Shot
from layerjam.rig.driver import Bench
from layerjam.rig.plant import VirtualPlant
from layerjam.rig.trigger import AFTER, BEFORE, FALL, LEVEL, RATE, SOURCES

if TYPE_CHECKING:
    from layerjam.device.file import BrakeFile
    from layerjam.simulate.drop import TimedStop

PAUSE = 0.02
"""Seconds between two looks at the capture."""
REST, FINE = 0.05, 40e3
"""Seconds of rest before a virtual fall; rate [Hz] at which its signal is made."""
DELAY = 0.5
"""Seconds of the board for which a virtual mass is at rest before it falls."""


class CaptureError(LayerjamError):
    """A record that did not come."""

    key = "capture"


@dataclass(frozen=True, kw_only=True)
class Capture:
    """How far a record is: IDLE, WAITING, RUNNING or DONE, and what is known of it then."""

    state: str
    size: int
    before: int
    trigger_us: int
    """Low 32 bits."""


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


def capture_of(bench: Bench) -> Capture:
    """How far the record is."""
    state, size, before, micros = bench.ask("FETC:ACC:STAT?").split(",")
    return Capture(state=state, size=int(size), before=int(before), trigger_us=int(micros))


def coming(bench: Bench, found: Capture) -> Shot:
    """A record that is DONE, as yet without its samples."""
    scale = bytes.fromhex(bench.ask("FETC:ACC:SCAL?").strip('"'))
    zero, gain, reach, rate = struct.unpack("<4d", scale)
    return Shot(
        counts=np.zeros(0, "<i2"),
        size=found.size,
        rate=rate,
        zero=zero,
        gain=gain,
        range=reach,
        before=found.before,
        trigger_us=found.trigger_us,
        synthetic=bench.simulated,
    )


def piece(bench: Bench, first: int, size: int) -> bytes:
    """Samples of a record of `size` from `first` on, PIECE of them at most."""
    return bench.block(f"FETC:ACC:DATA? {first},{min(PIECE, size - first)}")


def collect(bench: Bench, patience: float = 60.0) -> Shot:
    """The record, as soon as it is whole; asking keeps the lease alive.

    Raises CaptureError after `patience` [s] of the host without one, and where nothing waits.
    """
    end = time.monotonic() + patience
    while (found := capture_of(bench)).state != "DONE":
        if found.state == "IDLE":
            raise CaptureError("no capture waits or runs; arm it first")
        if time.monotonic() > end:
            bench.tell("ABOR")
            why = "nothing triggered" if found.state == "WAITING" else "the record did not end"
            raise CaptureError(f"no record of the accelerometer within {patience:g} s: {why}")
        time.sleep(PAUSE)
    shot = coming(bench, found)
    data = b"".join(piece(bench, at, shot.size) for at in range(0, shot.size, PIECE))
    return replace(shot, counts=np.frombuffer(data, "<i2"))


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
    delay: float = DELAY,
) -> TimedStop:
    """Let a mass [kg] fall on a virtual board's brake, to arrive with `speed` [m/s]; how it stops.

    The vacuum is the plant's own at this moment, and held. The mass is at rest for `delay` [s] of
    the board's time, falls freely for speed/g, and is stopped as `layerjam drop` computes it; the
    board's accelerometer, an ADXL193 with its low-pass, shows that. While it is computed the
    board's clock stands. Raises QuantityError where no virtual board of this program is behind the
    bench.
    """
    plant = bench.plant
    if plant is None:
        raise QuantityError.of("bench", f"{bench.address} is no virtual board of this program")
    with standing(plant):
        from layerjam.simulate.accelerometer import ADXL193, seen, specific_force
        from layerjam.simulate.drop import drop

        found, record = drop(
            file, mass=mass, speed=speed, vacuum=plant.vacuum, rope_stiffness=rope_stiffness
        )
        gravity = file.brake.site.gravity
        pulse, force = specific_force(record)
        flight = speed / gravity
        begin = np.array([-flight - REST, -flight, -flight + 1e-9, 0.0])
        times = np.concatenate([begin, pulse[pulse > 0.0]])
        forces = np.concatenate([[gravity, gravity, 0.0, 0.0], force[pulse > 0.0]])
        shown = seen((times, forces), replace(ADXL193, range=None, sampling=FINE))
        plant.accelerometer.play(plant.time + delay, shown.time + flight, shown.acceleration)
    return found


@contextlib.contextmanager
def standing(plant: VirtualPlant) -> Iterator[None]:
    """The clock of a virtual board stands; nobody may ask it anything meanwhile."""
    going, before = threading.Event(), plant.recorded
    plant.recorded = going.wait
    try:
        yield
    finally:
        plant.recorded = before
        going.set()
