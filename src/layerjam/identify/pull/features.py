"""What one measured pull shows: stiffness before onset, peak, and where loading ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from layerjam.errors import FileError
from layerjam.identify.stick_slip import noise_of, running_mean
from layerjam.measure.trace import Trace, block_means
from layerjam.units import show

LINEAR = (0.2, 0.8)
"""Part of the greatest force over which the slope before onset is taken."""
BENT = 0.1
"""Part of the greatest force by which the slope's line may miss the first sample."""
FEWEST = 10
"""Samples needed around the peak to calibrate on it."""
FALL = 0.10
"""The peak is fitted from onset until the force has fallen by this part."""
ROUGH = 0.02
"""Noise of one sample above this part of the greatest force is smoothed before levels are read."""
SLIP = 0.2
"""A fall by this part of the greatest force before it is a slip: the first rise ends there."""


@dataclass(frozen=True, kw_only=True)
class PullFeatures:
    """Features of one pull, SI units.

    `elongation` and `force` are the loading branch, with zero elongation where the straight line
    before onset meets zero force. Standard errors rest on the scatter about the two fits.
    `straight` is False where the brake slides long before its greatest force (low vacuum): then
    no slope tells the stiffness, and zero elongation is where the record begins.
    """

    stiffness: float
    stiffness_se: float
    peak_force: float
    peak_force_se: float
    peak_elongation: float
    has_peak: bool
    peak_samples: int
    straight: bool
    noise: float
    origin: float
    elongation: np.ndarray
    force: np.ndarray
    path: str

    def thinned(self, most: int) -> PullFeatures:
        """The same features with a curve of at most `most` samples, means over neighbours."""
        return replace(
            self,
            elongation=block_means(self.elongation, most),
            force=block_means(self.force, most),
        )


def loading_branch(trace: Trace) -> tuple[np.ndarray, np.ndarray]:
    """Elongation [m] and force [N] up to the greatest elongation."""
    end = int(np.argmax(trace.elongation)) + 1
    return trace.elongation[:end], trace.force[:end]


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float]:
    """Slope, its standard error and intercept of a straight line."""
    mean = x.mean()
    spread = float(((x - mean) ** 2).sum())
    slope = float(((x - mean) * y).sum() / spread)
    intercept = float(y.mean() - slope * mean)
    rest = y - slope * x - intercept
    variance = float((rest**2).sum()) / (len(x) - 2)
    return slope, float(np.sqrt(variance / spread)), intercept


def _running_mean(force: np.ndarray, most: int) -> np.ndarray:
    """Centred running mean over a hundredth of the record, at most `most` samples; same length."""
    half = min(len(force) // 200, most // 2)
    padded = np.pad(force, half, mode="edge")
    return np.convolve(padded, np.ones(2 * half + 1) / (2 * half + 1), mode="valid")


def _first_rise(smooth: np.ndarray) -> int:
    """Index of the greatest force, or of the first one a pull that judders slips from."""
    top = int(np.argmax(smooth))
    highest = np.maximum.accumulate(smooth[: top + 1])
    slipped = highest - smooth[: top + 1] > SLIP * smooth[top]
    slipped &= highest > 0.5 * smooth[top]
    if not slipped.any():
        return top
    return int(np.argmax(smooth[: int(np.argmax(slipped)) + 1]))


def _calmed(rise: np.ndarray, height: float) -> np.ndarray:
    """The rise as it is, or smoothed where one sample's noise would pass for another level."""
    noise = noise_of(rise)
    if noise <= ROUGH * height:
        return rise
    wanted = int((noise / (ROUGH * height)) ** 2)
    steep = int(np.sum((rise > LINEAR[0] * height) & (rise < LINEAR[1] * height)))
    return running_mean(rise, 2 * (min(wanted, steep // 3) // 2) + 1)


def pull_features(trace: Trace) -> PullFeatures:
    """Stiffness, peak and loading branch of one pull.

    The slope before onset is a straight line through 20 to 80 % of the greatest force. The peak is
    the top of A - c x + e sqrt(x), the brake's own shape, fitted by least squares over the slip
    x = u - F/k from onset until the force has fallen by 10 %: the raw maximum of a noisy record
    lies too high. Raises FileError where the record shows no rise to measure a slope on.
    """
    elongation, force = loading_branch(trace)
    # one spike of noise is no peak
    smooth = _running_mean(force, 9)
    top = _first_rise(smooth)
    height = float(smooth[top])
    rise = slice(0, top + 1)
    # the last passage through each level, so that slack and wiggles before the rise do not count
    steps = _calmed(force[rise], height)
    low, high = (
        int(np.flatnonzero(steps <= part * height)[-1]) if (steps <= part * height).any() else 0
        for part in LINEAR
    )
    if high - low < 5:
        raise FileError(
            trace.path,
            f"has {max(high - low, 0)} samples between {LINEAR[0]:.0%} and {LINEAR[1]:.0%} of its "
            f"greatest force, {show(height, 'N')}; at least 5 are needed to find the stiffness",
        )
    x, y = elongation[low : high + 1], force[low : high + 1]
    if not np.ptp(x) > 1e-9:
        raise FileError(trace.path, "the crosshead does not move while the force rises")
    stiffness, stiffness_se, intercept = _line(x, y)
    if stiffness <= 0:
        raise FileError(trace.path, "the force does not rise with elongation before the peak")
    origin = -intercept / stiffness
    # the line would have started far above what the record shows there: it is no first rise
    straight = stiffness * (float(elongation[0]) - origin) - float(force[0]) <= BENT * height
    if not straight:
        origin = float(elongation[0])
    u = elongation - origin
    peak = _fit_peak(u, force, stiffness, top, height, straight)
    return PullFeatures(
        stiffness=stiffness,
        stiffness_se=stiffness_se,
        peak_force=peak[0],
        peak_force_se=peak[1],
        peak_elongation=peak[2],
        has_peak=peak[4],
        peak_samples=peak[5],
        straight=straight,
        noise=peak[3],
        origin=origin,
        elongation=u,
        force=force,
        path=trace.path,
    )


def _fit_peak(
    u: np.ndarray, force: np.ndarray, stiffness: float, top: int, height: float, straight: bool
) -> tuple[float, float, float, float, bool, int]:
    """Peak force, its standard error, its elongation, the noise, whether it is a peak, samples."""
    slip = u - force / stiffness
    smooth = _running_mean(force, 51)
    fallen = np.flatnonzero(smooth[top:] < (1 - FALL) * height)
    end = top + int(fallen[0]) if len(fallen) else len(force)
    before = np.flatnonzero(smooth[: top + 1] <= 0.97 * height)
    onset = int(before[-1]) if len(before) else 0
    rise_noise = float(np.std(np.diff(force[max(0, top - 20) : top + 20]))) / np.sqrt(2)
    least = 3 * rise_noise / stiffness + 1e-9
    index = np.arange(onset, end)
    index = index[slip[index] > least]
    # means over equal stretches; the greatest of many lies a few of its own errors too high
    few = max(3, len(force) // 100)
    most = float(np.convolve(force, np.ones(few) / few, mode="valid").max())
    falls = float(force[-few:].mean()) < 0.995 * most - 5 * rise_noise / np.sqrt(few)
    if not straight:
        return height, rise_noise, float(u[top]), rise_noise, falls, len(index)
    if len(index) < FEWEST or not falls:
        return height, rise_noise, float(u[top]), rise_noise, falls, len(index)
    x = slip[index]
    scale = float(x.max())
    basis = np.column_stack([np.ones_like(x), -x / scale, np.sqrt(x / scale)])
    weights, _, _, _ = np.linalg.lstsq(basis, force[index], rcond=None)
    rest = force[index] - basis @ weights
    variance = float((rest**2).sum()) / max(len(index) - 3, 1)
    _, fall, root = (float(w) for w in weights)
    at = (root / (2 * fall)) ** 2 if fall > 0 and root > 0 else 0.0
    at = min(at, 1.0)
    here = np.array([1.0, -at, np.sqrt(at)])
    peak = float(here @ weights)
    covariance = variance * np.linalg.pinv(basis.T @ basis)
    error = float(np.sqrt(here @ covariance @ here))
    return peak, error, at * scale + peak / stiffness, float(np.sqrt(variance)), True, len(index)
