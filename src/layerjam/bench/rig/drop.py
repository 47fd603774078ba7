"""The drop rig: the accelerometer's record of a stop, sampled by the board.

`layerjam crash` reads the record directly. `fall` drops a mass on a virtual board's brake.
"""

import contextlib
import struct
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.trigger import AFTER, BEFORE, FALL, LEVEL, RATE, SOURCES
from layerjam.bench.rig.virtual_plant import VirtualPlant
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.laboratory.measure.shots import PIECE, Shot

if TYPE_CHECKING:
    from layerjam.brake.device.brake_file import BrakeFile
    from layerjam.brake.simulate.drop import TimedStop

PAUSE = 0.02
"""Time between two queries of the capture's state [s]."""
REST_TIME, FINE = 0.05, 40e3
"""Time at rest in the signal before a virtual fall [s], and the signal's sampling rate [Hz]."""
DELAY = 0.5
"""Default time for which a virtual mass is at rest before it falls [s of the board's clock]."""


class CaptureError(LayerjamError):
    """Raised if an accelerometer record is not completed."""

    key = "capture"


@dataclass(frozen=True, kw_only=True)
class Capture:
    """State of a record (IDLE, WAITING, RUNNING or DONE), with the values known in that state."""

    state: str
    size: int
    before: int
    trigger_us: int
    """Low 32 bits of the clock at the trigger [us]."""


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
    """Set up a capture, in the state SAFE; only settings that differ from the board's are sent.

    `rate` is in Hz, `before` and `after` are times [s] around the trigger. `level` [g] is relative
    to the reading in free fall; `fall` [s] is the time in free fall that arms the trigger. Raises
    QuantityError and InstrumentError.
    """
    if source not in SOURCES:
        raise QuantityError.of("source", f"'{source}' is not one of {', '.join(SOURCES)}")
    settings = {
        "SENS:ACC:RATE": RATE.si(rate, "rate"),
        "SENS:ACC:PRE": BEFORE.si(before, "before"),
        "SENS:ACC:POST": AFTER.si(after, "after"),
        "TRIG:LEV": LEVEL.si(level, "level"),
        "TRIG:FALL": FALL.si(fall, "fall"),
    }
    for header, value in settings.items():
        if abs(float(bench.ask(header + "?")) - value) > 1e-8 * abs(value):
            bench.tell(f"{header} {value:.9g}")
    if bench.ask("TRIG:SOUR?") != SOURCES[source]:
        bench.tell(f"TRIG:SOUR {SOURCES[source]}")


def arm(bench: Bench) -> None:
    """Make the board sample and wait for the trigger; raises InstrumentError."""
    bench.tell("INIT")


def read_capture(bench: Bench) -> Capture:
    """Return the state of the record."""
    state, size, before, micros = bench.ask("FETC:ACC:STAT?").split(",")
    return Capture(state=state, size=int(size), before=int(before), trigger_us=int(micros))


def pending_shot(bench: Bench, state: Capture) -> Shot:
    """Return a complete (DONE) record without its samples."""
    scale = bytes.fromhex(bench.ask("FETC:ACC:SCAL?").strip('"'))
    zero, gain, reach, rate = struct.unpack("<4d", scale)
    return Shot(
        counts=np.zeros(0, "<i2"),
        size=state.size,
        rate=rate,
        zero=zero,
        gain=gain,
        range=reach,
        before=state.before,
        trigger_us=state.trigger_us,
        synthetic=bench.simulated,
    )


def read_piece(bench: Bench, first: int, size: int) -> bytes:
    """Return at most PIECE samples of a record of `size` samples, starting at index `first`."""
    return bench.block(f"FETC:ACC:DATA? {first},{min(PIECE, size - first)}")


def collect(bench: Bench, patience: float = 60.0) -> Shot:
    """Return the record when it is complete; the queries keep the lease alive.

    Raises CaptureError if no record is complete after `patience` [s] of the host's clock, or if no
    capture is armed.
    """
    end = time.monotonic() + patience
    while (state := read_capture(bench)).state != "DONE":
        if state.state == "IDLE":
            raise CaptureError("no capture is armed or running; arm it first")
        if time.monotonic() > end:
            bench.tell("ABOR")
            reason = "the record did not finish"
            if state.state == "WAITING":
                reason = "the capture was not triggered"
            raise CaptureError(f"no record of the accelerometer within {patience:g} s: {reason}")
        time.sleep(PAUSE)
    shot = pending_shot(bench, state)
    data = b"".join(read_piece(bench, start, shot.size) for start in range(0, shot.size, PIECE))
    return replace(shot, counts=np.frombuffer(data, "<i2"))


def capture(
    bench: Bench,
    *,
    patience: float = 60.0,
    ready: Callable[[], None] | None = None,
    **settings: Any,
) -> Shot:
    """Set up a capture and return its record; `ready` is called once it waits for a trigger.

    `settings` are the arguments of `prepare`. Raises the errors of `prepare`, `arm` and `collect`.
    """
    prepare(bench, **settings)
    arm(bench)
    if ready is not None:
        ready()
    return collect(bench, patience)


def fall(
    bench: Bench,
    file: "BrakeFile",
    *,
    mass: float,
    speed: float,
    rope_stiffness: float | None = None,
    delay: float = DELAY,
) -> "TimedStop":
    """Drop a mass [kg] on a virtual board's brake, arriving at `speed` [m/s]; return its stop.

    The vacuum stays at the plant's current value. The mass is at rest for `delay` [s] of the
    board's time, falls freely for speed/g, and stops as `layerjam drop` computes it. The board's
    accelerometer, an ADXL193 with a low-pass filter, measures the motion. The board's clock stops
    meanwhile. Raises QuantityError if the bench is not a virtual board of this program.
    """
    plant = bench.plant
    if plant is None:
        raise QuantityError.of("bench", f"{bench.address} is not a virtual board of this program")
    with pause_clock(plant):
        from layerjam.brake.simulate.accelerometer import (
            ADXL193,
            measure_acceleration,
            specific_force,
        )
        from layerjam.brake.simulate.drop import drop

        stop, record = drop(
            file, mass=mass, speed=speed, vacuum=plant.vacuum, rope_stiffness=rope_stiffness
        )
        gravity = file.brake.site.gravity
        pulse, force = specific_force(record)
        flight = speed / gravity
        begin = np.array([-flight - REST_TIME, -flight, -flight + 1e-9, 0.0])
        times = np.concatenate([begin, pulse[pulse > 0.0]])
        forces = np.concatenate([[gravity, gravity, 0.0, 0.0], force[pulse > 0.0]])
        signal = measure_acceleration((times, forces), replace(ADXL193, range=None, sampling=FINE))
        plant.accelerometer.set_force(plant.time + delay, signal.time + flight, signal.acceleration)
    return stop


@contextlib.contextmanager
def pause_clock(plant: VirtualPlant) -> Iterator[None]:
    """Stop the clock of a virtual board; do not query it during that time."""
    is_running, recorded_before = threading.Event(), plant.recorded
    plant.recorded = is_running.wait
    try:
        yield
    finally:
        plant.recorded = recorded_before
        is_running.set()
