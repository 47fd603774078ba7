"""Features of one measured pull: stiffness before onset, peak and end of loading."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.core.errors import FileError, count_text
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.laboratory.identify.pull.cycles import find_cycles
from layerjam.laboratory.identify.statistics import StraightLine, fit_line
from layerjam.laboratory.measure.noise import noise_sd, running_mean
from layerjam.laboratory.measure.trace import Array, Trace, block_means

LINEAR = (0.2, 0.8)
"""Range of force, relative to its maximum, in which the slope before onset is fitted."""
BENT = 0.1
"""Largest distance of the fitted line from the first sample, relative to the maximum force."""
SLOPE = 5
"""Minimum number of samples between these levels for a fit of the slope."""
FEWEST = 10
"""Minimum number of samples around the peak for a calibration on it."""
FALL = 0.10
"""Relative drop in force after the peak up to which the peak is fitted."""
ABOVE = 0.01
"""Largest relative excess of the fitted peak, between two samples, over the highest sample."""
ROUGH = 0.02
"""Noise of one sample, relative to the maximum force, above which levels are smoothed."""
SLIP = 0.2
"""Noise of one sample, relative to the maximum force, above which a rise is smoothed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PullFeatures:
    """Features of one pull, in SI units.

    `elongation` and `force` are the loading branch, with zero elongation where the straight line
    before onset meets zero force. Standard errors are from the scatter about the two fits.
    `straight` is False if no slope shows the stiffness. Either the brake slides long before its
    maximum force (low vacuum); zero elongation is then the start of the record. Or the rise has
    fewer than `SLOPE` samples (`rise_samples`); the peak is then just as accurate, and `stiffness`
    is a rough value used to locate it. `peak_sample` is the largest sample, `peak_misfit` the part
    of its distance from `peak_force` that noise does not explain [N]. `seating` is the log of the
    ratio of the slopes in the upper and lower halves of the rise, or None. It is 0 for a straight
    rise and positive for a yielding seat.
    """

    stiffness: float
    stiffness_se: float
    peak_force: float
    peak_force_se: float
    peak_elongation: float
    peak_sample: float
    peak_misfit: float
    has_peak: bool
    peak_samples: int
    straight: bool
    rise_samples: int
    noise: float
    origin: float
    seating: float | None
    seating_se: float
    elongation: Array
    force: Array
    path: str
    baseline: float | None = None
    """Force before the rise [N], a preload or a zero error; None if it was not recorded."""

    @property
    def peak_error(self) -> float:
        """Standard error of the peak force with the misfit of its law [N]."""
        return float(np.hypot(self.peak_force_se, self.peak_misfit))

    @property
    def is_sparse(self) -> bool:
        """Return whether the rise has too few samples to determine its slope."""
        return self.rise_samples < SLOPE

    def thinned(self, limit: int) -> "PullFeatures":
        """Return the features with at most `limit` samples of the curve, as means of neighbours."""
        return evolve(
            self,
            elongation=block_means(self.elongation, limit),
            force=block_means(self.force, limit),
        )


def select_loading(trace: Trace) -> tuple[Array, Array]:
    """Return elongation [m] and force [N] up to the maximum elongation.

    If the crosshead reverses and pulls again, this is the end of the first loading.
    """
    cycles = find_cycles(trace.elongation)
    end = (int(np.argmax(trace.elongation)) if cycles is None else cycles.loading_end) + 1
    return trace.elongation[:end], trace.force[:end]


def _running_mean(force: Array, limit: int) -> Array:
    """Return the running mean [N] over 1 % of the record, at most `limit` samples, shape (N,)."""
    return running_mean(force, 2 * min(len(force) // 200, limit // 2) + 1)


def _find_rise_end(smooth: Array) -> int:
    """Return the index of the maximum force, or of the first peak after which the brake slips."""
    top = int(np.argmax(smooth))
    highest = np.maximum.accumulate(smooth[: top + 1])
    slipped = highest - smooth[: top + 1] > SLIP * smooth[top]
    slipped &= highest > 0.5 * smooth[top]
    if not slipped.any():
        return top
    return int(np.argmax(smooth[: int(np.argmax(slipped)) + 1]))


def _smooth_rise(rise: Array, height: float) -> Array:
    """Return the rise, smoothed if the noise of a sample could shift where it crosses a level."""
    noise = noise_sd(rise)
    if noise <= ROUGH * height:
        return rise
    samples = int((noise / (ROUGH * height)) ** 2)
    rise_count = int(np.sum((rise > LINEAR[0] * height) & (rise < LINEAR[1] * height)))
    return running_mean(rise, 2 * (min(samples, rise_count // 3) // 2) + 1)


def pull_features(trace: Trace) -> PullFeatures:
    """Return stiffness, peak and loading branch of one pull.

    The slope before onset is that of a straight line through 20 to 80 % of the maximum force. The
    peak is the top of A - c x + e sqrt(x), the brake's own shape, because the raw maximum of a
    noisy record is too high. It is fitted by least squares over the slip x = u - F/k from onset
    until the force has dropped by 10 %. Raises FileError if the record has no rise, or neither a
    slope nor a peak.
    """
    elongation, force = select_loading(trace)
    smooth = _running_mean(force, 9)  # one spike of noise is not a peak
    top = _find_rise_end(smooth)
    height = float(smooth[top])
    # use the last crossing of each level, to ignore slack and ripples before the rise
    steps = _smooth_rise(force[: top + 1], height)
    indices_below = [np.flatnonzero(steps <= part * height) for part in LINEAR]
    low, high = (int(b[-1]) if len(b) else 0 for b in indices_below)
    sparse = high - low < SLOPE
    if sparse and not (
        len(indices_below[0]) and _has_falling_end(force, _estimate_noise_sd(force, top))
    ):
        raise FileError(
            trace.path,
            f"has {count_text(max(high - low, 0), 'sample')} between {LINEAR[0]:.0%} and "
            f"{LINEAR[1]:.0%} of its maximum force, {show(height, 'N')}; at least "
            f"{SLOPE} are needed to find the stiffness, and without a peak the scale "
            "factor cannot be determined either",
        )
    rise = slice(low, max(high, low + 1) + 1)
    line = fit_line(elongation[rise], force[rise])
    if line is None or not np.ptp(elongation[rise]) > 1e-9:
        raise FileError(trace.path, "the crosshead does not move while the force rises")
    if line.slope <= 0:
        raise FileError(trace.path, "the force does not rise with elongation before the peak")
    origin = line.meets(0.0)
    # a line that starts far above the first sample of the record is not its first rise
    bent = line.value_at(float(elongation[0])) - float(force[0]) > BENT * height
    if bent:
        origin = float(elongation[0])
    u = elongation - origin
    seating = None if bent or sparse else _find_seating(elongation[:top], force[:top], line, height)
    return PullFeatures(
        stiffness=line.slope,
        stiffness_se=line.slope_se,
        straight=not bent and not sparse,
        rise_samples=max(high - low, 0),
        seating=None if seating is None else seating[0],
        seating_se=0.0 if seating is None else seating[1],
        origin=origin,
        elongation=u,
        force=force,
        path=trace.path,
        **_fit_peak(u, force, line.slope, top, height, not bent),
    )


def _find_seating(
    elongation: Array, force: Array, line: StraightLine, height: float
) -> tuple[float, float] | None:
    """Return the log of the slope ratio of the upper to the lower half, and its error.

    The rise is split by elongation; a split by force would select samples by their noise.
    """
    middle = sum(LINEAR) / 2
    first, half, last = (line.meets(part * height) for part in (LINEAR[0], middle, LINEAR[1]))
    slopes = []
    for start, end in ((first, half), (half, last)):
        part = (elongation >= start) & (elongation < end)
        half_line = fit_line(elongation[part], force[part]) if part.sum() >= SLOPE else None
        if half_line is None or half_line.slope <= 0:
            return None
        slopes.append(half_line)
    lower, upper = slopes
    error = np.hypot(lower.slope_se / lower.slope, upper.slope_se / upper.slope)
    return float(np.log(upper.slope / lower.slope)), float(error)


def _estimate_noise_sd(force: Array, top: int) -> float:
    """Return the standard deviation of one sample around the peak [N]."""
    return float(np.std(np.diff(force[max(0, top - 20) : top + 20]))) / np.sqrt(2)


def _has_falling_end(force: Array, noise: float) -> bool:
    # use means over equal sections: the highest of many samples is a few standard errors too high
    width = max(3, len(force) // 100)
    sums = np.cumsum(force)  # a convolution with `few` steps per sample
    largest_mean = (
        float(max((sums[width:] - sums[:-width]).max(initial=-np.inf), sums[width - 1])) / width
    )
    return bool(force[-width:].mean() < 0.995 * largest_mean - 5 * noise / np.sqrt(width))


def _fit_peak(
    u: Array, force: Array, stiffness: float, top: int, height: float, rises: bool
) -> dict[str, Any]:
    """Return the fields of PullFeatures for the peak; `stiffness` [N/m] is that of the rise."""
    slip = u - force / stiffness
    smooth = _running_mean(force, 51)
    below_peak = np.flatnonzero(smooth[top:] < (1 - FALL) * height)
    end = top + int(below_peak[0]) if len(below_peak) else len(force)
    lower_indices = np.flatnonzero(smooth[: top + 1] <= 0.97 * height)
    onset = int(lower_indices[-1]) if len(lower_indices) else 0
    noise = _estimate_noise_sd(force, top)
    index = np.arange(onset, end)
    index = index[slip[index] > 3 * noise / stiffness + 1e-9]
    has_falling_end = _has_falling_end(force, noise)
    highest = float(force[:end].max())
    peak_fields = {
        "has_peak": has_falling_end,
        "peak_samples": len(index),
        "noise": noise,
        "peak_sample": highest,
        "peak_misfit": 0.0,
    }
    raw = peak_fields | {
        "peak_force": height,
        "peak_force_se": noise,
        "peak_elongation": float(u[top]),
    }
    if not rises or len(index) < FEWEST or not has_falling_end:
        return raw
    x = slip[index]
    scale = float(x.max())
    basis = np.column_stack([np.ones_like(x), -x / scale, np.sqrt(x / scale)])
    weights, _, _, _ = np.linalg.lstsq(basis, force[index], rcond=None)
    residuals = force[index] - basis @ weights
    variance = float((residuals**2).sum()) / max(len(index) - 3, 1)
    _, fall, root = (float(w) for w in weights)
    top_slip = min((root / (2 * fall)) ** 2 if fall > 0 and root > 0 else 0.0, 1.0)
    top_basis = np.array([1.0, -top_slip, np.sqrt(top_slip)])
    peak = float(top_basis @ weights)
    if peak > (1 + ABOVE) * highest:
        return raw  # the fitted law peaks outside the samples, so it does not fit
    covariance = variance * np.linalg.pinv(basis.T @ basis)
    return peak_fields | {
        "peak_force": peak,
        "peak_force_se": float(np.sqrt(top_basis @ covariance @ top_basis)),
        "peak_elongation": top_slip * scale + peak / stiffness,
        "peak_misfit": _misfit(highest - peak, noise_sd(force[index]), len(index)),
        "noise": float(np.sqrt(variance)),
    }


def _misfit(excess: float, noise: float, samples: int) -> float:
    """Return how far the largest sample [N] is from its expected excess over the fitted peak.

    The largest of `samples` with white noise exceeds the peak by up to σ √(2 ln n).
    """
    return max(excess - noise * float(np.sqrt(2 * np.log(samples))), -excess, 0.0)
