"""Crash and impact pulses: a shape with a velocity change and duration, or a record."""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from layerjam.core.errors import FileError, UnknownNameError
from layerjam.laboratory.measure.log import ACCELERATION, TIME, read_log

Array = npt.NDArray[np.float64]
SHAPES = ("half-sine", "haversine", "trapezoid")
RAMP = 0.2
"""Fraction of a trapezoid's duration in which it rises; the fall is assumed to last as long."""


def compute_pulse(shape: str, change: float, duration: float, time: Array) -> Array:
    """Return the acceleration [m/s^2] at times [s], (N,), with the integral `change` [m/s]."""
    part = time / duration
    is_inside = (part >= 0) & (part <= 1)
    if shape == "half-sine":
        value = np.pi / 2 * np.sin(np.pi * part)
    elif shape == "haversine":
        value = 2 * np.sin(np.pi * part) ** 2
    elif shape == "trapezoid":
        value = np.minimum(1.0, np.minimum(part, 1 - part) / RAMP) / (1 - RAMP)
    else:
        raise UnknownNameError("pulse", shape, SHAPES)
    return np.where(is_inside, value * change / duration, 0.0)


def read_record(path: Path) -> tuple[Array, Array]:
    """Return (time [s] since the first sample, magnitude of deceleration [m/s^2]) of a log.

    A mostly negative record, such as that of a braking car, is inverted. Raises FileError if time
    does not increase.
    """
    log = read_log(path, (TIME, ACCELERATION))
    time, value = log["time"] - log["time"][0], log["acceleration"]
    if len(time) < 5 or (np.diff(time) <= 0).any():
        raise FileError(path, "its time must increase from row to row over at least five samples")
    return time, value if np.trapezoid(value, time) >= 0 else -value


def make_drive(
    shape: str, change: float, duration: float, after: float, steps: int, folder: Path
) -> tuple[Array, float, float]:
    """Return (acceleration [m/s^2] at equal time steps, step [s], velocity change [m/s]).

    The `steps` cover the pulse and `after` [s] without load. A `shape` that is a path is read as a
    log, with its own velocity change and duration.
    """
    if shape not in SHAPES and not Path(shape).suffix:
        raise UnknownNameError("pulse", shape, SHAPES)
    log = None
    if shape not in SHAPES:
        local_file = folder / shape
        log = read_record(local_file if local_file.is_file() else Path(shape))
        duration = float(log[0][-1])
    dt = (duration + after) / steps
    time = np.asarray(np.arange(steps + 1) * dt, np.float64)
    if log is None:
        return compute_pulse(shape, change, duration, time), dt, change
    acceleration = np.interp(time, *log, right=0.0)
    return acceleration, dt, float(np.trapezoid(acceleration, dx=dt))
