"""Noise and resolution of a measured signal."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

SAME = 1e-9
"""Difference, relative to the span, below which two values count as identical despite rounding."""
DITHERED = 0.6
"""Scatter in steps above which the samples use at least three steps, so that their mean is right.
Two steps scatter by 0.5 at most."""


def noise_sd(force: Array) -> float:
    """Return the standard deviation of the white noise in a record [N], without slow changes.

    It is from the median second difference, which straight lines do not change and jumps hardly
    affect.
    """
    if len(force) < 5:
        return 0.0
    bends = np.abs(np.diff(force, 2))
    return float(np.median(bends)) * 1.4826 / 6**0.5


def running_mean(values: Array, samples: int) -> Array:
    """Return the centred running mean over an odd number of samples, with the ends repeated."""
    if samples < 3:
        return values
    half_window = samples // 2
    width = 2 * half_window + 1
    sums = np.empty(len(values) + width)  # one array, because a record may be long
    sums[: half_window + 1], sums[-half_window:] = values[0], values[-1]
    sums[0], sums[half_window + 1 : -half_window] = 0.0, values
    means = np.cumsum(sums, out=sums)[width:] - sums[:-width]
    means /= width
    return means


def find_quantum(values: Array) -> float:
    """Return the smallest step between two values, 0 if all are the same.

    It is the resolution of a coarse instrument. For a fine one it is close to zero.
    """
    levels = np.sort(values)
    steps = np.diff(levels)
    steps = steps[steps > SAME * float(levels[-1] - levels[0])] if len(steps) else steps
    if not len(steps):
        return 0.0
    # steps that are rounded to decimal digits differ in width
    smallest_step = float(steps.min())
    return float(steps[steps < 1.2 * smallest_step].mean())


def rounding_limit(samples: Array, quantum: float) -> float:
    """Return the largest error that a resolution of `quantum` leaves in the mean of some samples.

    If all samples lie within two steps, or there are none, it is half a step. Samples that scatter
    over more steps average it out: for normal scatter with SD s, the error is at most
    q/pi exp(-2 pi^2 s^2/q^2) (Widrow and Kollar 2008, section 5.3).
    """
    if quantum <= 0:
        return 0.0
    spread = float(np.std(samples)) / quantum if len(samples) else 0.0
    if spread < DITHERED:
        return quantum / 2
    return float(quantum / np.pi * np.exp(-2 * np.pi**2 * (spread**2 - 1 / 12)))
