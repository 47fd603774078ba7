"""Spikes in the force of a friction test, narrower than the rig can produce.

The string stretches only as fast as the crosshead moves away from the sled, and the sled does not
move backwards. The force therefore rises by at most the string's stiffness times the travel of the
crosshead, while sticking or sliding. A rise that is faster, and gone within a few samples, is a
disturbance of the load cell or of the wiring.
"""

from dataclasses import dataclass

import numpy as np

from layerjam.laboratory.measure.noise import find_quantum, noise_sd
from layerjam.laboratory.measure.trace import Array

WIDEST = 3
"""Largest number of samples of a spike."""
CLEAR = 8.0
"""Smallest height of a spike, in standard deviations of the noise."""
LEAST = 0.02
"""Smallest height of a spike, relative to the sliding force."""
LARGEST_COUNT = 5
"""Largest number of spikes in a record; more are a vibration, and remain."""
RISEN = 0.8
"""Part of the sliding force that ends the first rise."""


@dataclass(frozen=True)
class Spike:
    """Some samples from index `start`, up to `height` [N] from the force before and after them."""

    start: int
    samples: int
    height: float


def find_spikes(travel: Array, force: Array, level: float) -> list[Spike]:
    """Return the spikes in a record of travel [m] and force [N], which slides at about `level` [N].

    The result is empty if there are more than `MOST`.
    """
    if len(force) < 4 * WIDEST:
        return []
    limits = _largest_rises(travel, force, level)
    threshold = max(CLEAR * noise_sd(force), LEAST * abs(level), 2 * find_quantum(force))
    is_rising = np.diff(force) > limits + threshold
    spikes: list[Spike] = []
    for samples in range(1, WIDEST + 1):
        before, after = force[: -samples - 1], force[samples + 1 :]
        windows = np.lib.stride_tricks.sliding_window_view(force[1:-1], samples)
        height = windows.min(axis=1) - np.maximum(before, after)
        depth = np.minimum(before, after) - windows.max(axis=1)
        # rise into an upward spike, and rise out of a downward one
        up = (height > threshold) & is_rising[: len(before)]
        down = (depth > threshold) & is_rising[samples:]
        for place in np.flatnonzero(up | down).tolist():
            part = windows[place]
            extreme = float(part.max() if up[place] else part.min())
            spikes.append(Spike(place + 1, samples, extreme - float(before[place])))
    return sorted(spikes, key=lambda spike: spike.start) if len(spikes) <= LARGEST_COUNT else []


def remove_spikes(force: Array, spikes: list[Spike]) -> Array:
    """Return the force with straight lines in place of the spikes."""
    out = force.copy()
    for spike in spikes:
        last = spike.start + spike.samples
        out[spike.start - 1 : last + 1] = np.linspace(
            force[spike.start - 1], force[last], spike.samples + 2
        )
    return out


def _largest_rises(travel: Array, force: Array, level: float) -> Array:
    """Return the largest possible rise of the force at each step [N], shape (N - 1,).

    A running median removes spikes and keeps rises. Its steepest step is that of the string. If the
    first rise has no sample between its ends, the string's stiffness is unknown and no limit
    applies there.
    """
    width = 2 * WIDEST + 1
    samples = np.pad(force, WIDEST, mode="edge")
    median = np.median(np.lib.stride_tricks.sliding_window_view(samples, width), axis=1)
    steps_of_travel = np.abs(np.diff(travel))
    mean_step = float(steps_of_travel.sum()) / max(int(np.count_nonzero(steps_of_travel)), 1)
    steps = (
        np.maximum(steps_of_travel / mean_step, 1.0)
        if mean_step > 0
        else np.ones(len(steps_of_travel))
    )
    slopes = np.diff(median) / steps
    risen = int(np.argmax(median >= RISEN * level))
    rise = median[: risen + 1]
    base = float(median[0])
    if ((rise > base + 0.1 * (level - base)) & (rise < RISEN * level)).any() or risen == 0:
        return np.asarray(max(float(slopes.max()), 0.0) * steps)
    limits = max(float(slopes[risen:].max(initial=0.0)), 0.0) * steps
    limits[: risen + 1] = np.inf
    return np.asarray(limits)
