"""Faults of a test machine, each with a magnitude, and their effects on a record.

All arrays of force, travel and time have shape (M, N), M tests of N samples, and SI units. Each
fault draws its own random numbers in each test, so that adding a fault does not affect others.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from layerjam.core.errors import QuantityError
from layerjam.core.units import quantity
from layerjam.laboratory.measure.trace import Array

Bools = npt.NDArray[np.bool_]

# one fixed number per use of random numbers; it is part of the seed and must never change
STREAMS = {
    "scatter": 1,
    "jitter": 2,
    "noise": 3,
    "dropped": 4,
    "repeated": 5,
    "texture": 6,
    "practice": 7,
    "odd": 8,
}


def fault(unit: str, text: str, hi: float, lo: float = 0.0) -> Any:
    """Return a field for the magnitude of a fault; 0 means none."""
    return quantity(unit, text, lo=lo, hi=hi, default=0.0)


@dataclass(frozen=True, kw_only=True)
class LoadCell:
    """A load cell and its recording, without faults by default."""

    sampling_rate: float = quantity("Hz", "samples per second", lo=0.1, hi=1e6, default=1000.0)
    force_noise: float = fault("N", "standard deviation of the load cell's white noise", 1e4)
    force_offset: float = fault("N", "load cell's reading at no load", 1e4, lo=-1e4)
    load_cell_range: float | None = quantity(
        "N", "force at which the load cell saturates", lo=1e-3, hi=1e7, default=None
    )
    force_step: float = fault("N", "resolution of the recorded force", 100)


@dataclass(frozen=True, kw_only=True)
class Faults(LoadCell):
    """A test machine, without faults by default."""

    force_drift: float = fault("N/s", "drift of the load cell's zero", 100, lo=-100)
    travel_step: float = fault("m", "resolution of the recorded travel", 1e-3)
    slack: float = fault("m", "travel before the brake is taut", 0.1)
    preload: float = fault(
        "N", "force at which the record starts, with the travel set to zero", 1e4
    )
    crosshead_start: float = fault("m", "travel shown by the first sample", 2, lo=-2)
    compliance: float = fault("m/N", "compliance of frame and grips included in the travel", 1e-3)
    lag: float = fault("s", "delay of the force", 10)
    jitter: float = fault("s", "standard deviation of the sampling jitter", 1)
    dropped: float = fault("1", "fraction of samples that are lost", 0.5)
    repeated_stamps: float = fault("1", "fraction of samples with a repeated time stamp", 0.5)
    stick_slip: float = fault("N", "stick-slip while sliding, peak to peak", 1e4)
    overshoot: float = fault(
        "1", "relative excess of static over kinetic friction of the sheets", 1
    )
    overshoot_slip: float = quantity(
        "m", "slip over which that excess falls to 1/e", lo=1e-5, hi=0.1, default=1e-3
    )
    seating: float = fault("m", "settling of grips and caps under the first load", 0.01)
    seating_force: float = quantity(
        "N", "load at which 1 - 1/e of that settling is reached", lo=0.1, hi=1e4, default=50.0
    )
    vacuum_error: float = fault("Pa", "vacuum in the brake minus the gauge reading", 2e4, lo=-2e4)
    vacuum_loss: float = fault("Pa/s", "drop in vacuum while the brake is pulled", 1e5)
    warming: float = fault("K", "rise in temperature from the first test to the last", 30, lo=-30)
    zero_per_kelvin: float = fault("N", "change in the load cell's zero per kelvin", 100, lo=-100)
    span_per_kelvin: float = fault(
        "1", "relative change in the load cell's span per kelvin", 0.01, lo=-0.01
    )
    friction_per_kelvin: float = fault(
        "1", "relative change in the sheets' friction per kelvin", 0.02, lo=-0.02
    )


def check_consistency(machine: Faults) -> None:
    """Raise QuantityError if faults contradict each other."""
    if machine.slack > 0 and machine.preload > 0:
        raise QuantityError.of(
            "machine.slack",
            f"{machine.slack * 1e3:g} mm is not allowed together with a preload of "
            f"{machine.preload:g} N, which removes the slack; state only one of them",
        )
    if machine.jitter * machine.sampling_rate > 0.2:
        raise QuantityError.of(
            "machine.jitter",
            f"{machine.jitter:.4g} s is not allowed; it must be at most 0.2 of the "
            f"sampling period, {0.2 / machine.sampling_rate:.4g} s",
        )


def make_rng(seed: int, stream: str, test: int) -> np.random.Generator:
    """Return the random number generator for one fault in one test."""
    return np.random.Generator(np.random.PCG64([seed, STREAMS[stream], test]))


def draw_normals(seed: int, stream: str, tests: npt.NDArray[np.int64], count: int) -> Array:
    """Return standard normal numbers for some tests, shape (len(tests), count)."""
    out = np.empty((len(tests), count))
    for row, test in zip(out, tests.tolist(), strict=True):
        make_rng(seed, stream, test).standard_normal(out=row)
    return out


def round_to_step(values: Array, step: float) -> Array:
    """Return values rounded to a converter's step, or unchanged if the step is 0."""
    return np.round(values / step) * step if step > 0 else values


def factors(relative: float, draws: Array) -> Array:
    """Return factors of mean 1 and standard deviation `relative`, never negative (log-normal)."""
    width = float(np.sqrt(np.log1p(relative**2)))
    return np.exp(width * draws - width**2 / 2)


def sample_times(machine: Faults, seed: int, tests: npt.NDArray[np.int64], count: int) -> Array:
    """Return the times of the samples [s], ascending, shape (M, count)."""
    time = np.arange(count) / machine.sampling_rate
    if machine.jitter <= 0:
        return np.broadcast_to(time, (len(tests), count))
    # limit to 2 standard deviations, so that time stamps remain in order
    shift = np.clip(draw_normals(seed, "jitter", tests, count), -2, 2) * machine.jitter
    shift[:, [0, -1]] = 0.0
    return time + shift


def saw_force(slip: Array, amplitude: float, stiffness: Array) -> Array:
    """Return stick–slip about the mean force [N] versus slip [m], a sawtooth.

    Between two slips the force rises by `amplitude` with slope `stiffness` [N/m], so that a slip
    occurs after each amplitude/stiffness of travel. It is zero before the first slip.
    """
    if amplitude <= 0:
        return np.zeros_like(slip)
    phase = np.mod(0.5 + slip * stiffness / amplitude, 1.0) - 0.5
    return np.where(slip > 0, amplitude * phase, 0.0)


def measured_force(
    force: Array,
    time: Array,
    warmer: Array,
    machine: Faults,
    seed: int,
    tests: npt.NDArray[np.int64],
) -> Array:
    """Return the load cell's reading of a true force, warmed by `warmer` [K], shape (M, 1)."""
    reading = force * (1 + machine.span_per_kelvin * warmer)
    reading += machine.force_offset + machine.zero_per_kelvin * warmer + machine.force_drift * time
    if machine.force_noise > 0:
        reading += machine.force_noise * draw_normals(seed, "noise", tests, force.shape[1])
    if machine.load_cell_range is not None:
        np.clip(reading, -machine.load_cell_range, machine.load_cell_range, out=reading)
    return round_to_step(reading, machine.force_step)


def measured_travel(travel: Array, machine: Faults) -> Array:
    """Return the crosshead's reading of its true travel."""
    return round_to_step(travel + machine.crosshead_start, machine.travel_step)


def sample_mask(machine: Faults, seed: int, test: int, count: int) -> Bools | None:
    """Return a mask of the kept samples (first and last are always kept), None if none are lost."""
    if machine.dropped <= 0:
        return None
    keep = make_rng(seed, "dropped", test).random(count) >= machine.dropped
    keep[[0, -1]] = True
    return keep


def recorded_times(time: Array, machine: Faults, seed: int, test: int) -> Array:
    """Return the time stamps of a test, shape (N,), some of which repeat the previous one."""
    if machine.repeated_stamps <= 0:
        return time
    repeats = make_rng(seed, "repeated", test).random(len(time)) < machine.repeated_stamps
    repeats[0] = False
    stamps = np.where(repeats, -np.inf, time)
    return np.maximum.accumulate(stamps)
